// What a program asks for, as arguments of the core.

const FORMATS = ["rgba", "linear", "png", "jpg", "webp", "exr", "hdr"];

/** An error that becomes a TurnerError. */
function wrong(message, help) {
  return { plain: { message, help } };
}

/** A value of the scene as text, in the notation of scene files (TOML). */
export function written(value) {
  if (typeof value === "string") return JSON.stringify(value).replace(/\u007f/g, "\\u007F");
  if (typeof value === "number") {
    if (Number.isFinite(value)) return String(value);
    return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  }
  if (typeof value === "boolean" || typeof value === "bigint") return String(value);
  if (Array.isArray(value) || ArrayBuffer.isView(value)) return `[${Array.from(value, written).join(", ")}]`;
  if (value && typeof value === "object") {
    const entries = Object.entries(value).map(([key, own]) => `${JSON.stringify(key)} = ${written(own)}`);
    return `{ ${entries.join(", ")} }`;
  }
  throw wrong(`${String(value)} is no value of a scene`, "give a number, a text, a boolean, a list or an object");
}

/** A copy of bytes, which a worker may have. */
function copied(bytes, name) {
  if (typeof bytes === "string") return new TextEncoder().encode(bytes);
  if (bytes instanceof ArrayBuffer || bytes instanceof Uint8Array) return new Uint8Array(bytes).slice();
  if (ArrayBuffer.isView(bytes)) return new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength).slice();
  if (typeof SharedArrayBuffer !== "undefined" && bytes instanceof SharedArrayBuffer) return new Uint8Array(bytes).slice();
  throw wrong(`${name} is no bytes`, "give a Uint8Array, an ArrayBuffer or a text");
}

/** The name that tells the format of bytes: a glTF file in one piece, glTF, USD, PLY and scenes as text are recognised. */
function nameOf(input, bytes) {
  const text = new TextDecoder("latin1").decode(bytes.subarray(0, 4));
  if (text === "glTF") return "model.glb";
  if (text === "PXR-") return "model.usdc";
  if (text === "#usd") return "model.usda";
  if (text === "PK\u0003\u0004") return "model.usdz";
  if (text.startsWith("ply")) return "model.ply";
  if (/^\s*\{/.test(text)) return "model.gltf";
  if (typeof input === "string") return "scene.toml";
  throw wrong("the format of the bytes is not known", 'give its name, such as { name: "model.stl" }');
}

function filesOf(input, options) {
  if (input && typeof input === "object" && input.files) {
    const files = Object.entries(input.files).map(([name, bytes]) => ({ name, bytes: copied(bytes, name) }));
    if (!files.length) throw wrong("there are no files", undefined);
    const main = input.main ?? options.name ?? (files.length === 1 ? files[0].name : undefined);
    if (main === undefined) throw wrong("which of the files is the scene?", 'give its name: { files, main: "scene.toml" }');
    return { main, files };
  }
  const bytes = copied(input, "the input");
  const main = options.name ?? nameOf(input, bytes);
  return { main, files: [{ name: main, bytes }] };
}

/** `studio.camera` for a camera. */
function cameraOf(camera) {
  if (typeof camera === "string") return camera;
  const orbit = Array.isArray(camera.orbit) ? camera.orbit : [camera.azimuth ?? 35, camera.elevation ?? 22, camera.distance];
  return `orbit:${orbit.filter(v => v !== undefined).join(",")}`;
}

/** The light of an environment map, and its file. */
function environmentOf(environment) {
  const { bytes, name, strength, rotation } = ArrayBuffer.isView(environment) || environment instanceof ArrayBuffer
    ? { bytes: environment } : environment;
  const file = { name: name ?? "environment.hdr", bytes: copied(bytes, "the environment") };
  const light = { type: "environment", file: file.name };
  if (strength !== undefined) light.strength = strength;
  if (rotation !== undefined) light.rotation = rotation;
  return { file, light };
}

/** The message for the session: files, and arguments of the call `picture_begin`. */
export function requestOf(input, options) {
  const { main, files } = filesOf(input, options);
  const format = options.format === "jpeg" ? "jpg" : options.format ?? "rgba";
  if (!FORMATS.includes(format)) throw wrong(`there is no format "${format}"`, `expected one of: ${FORMATS.join(", ")}`);
  const set = { ...options.set };
  if (options.samples !== undefined) set["film.samples"] = options.samples;
  if (options.camera !== undefined) set["studio.camera"] = cameraOf(options.camera);
  if (options.camera?.fov !== undefined) set["studio.fov"] = options.camera.fov;
  if (options.aovs?.length) set["film.aovs"] = options.aovs;
  if (options.environment) {
    const { file, light } = environmentOf(options.environment);
    files.push(file);
    set.light = [light];
  }
  const overrides = Object.entries(set).map(([path, value]) => [path, written(value)]);
  const { width, height, integrator } = options;
  const wantsAovs = options.aovs !== undefined || "film.aovs" in set;
  return { args: { main, overrides, width, height, integrator }, files, format, wantsAovs };
}
