// The files of a <turner-view>: fetched with progress, those of a .gltf as well.

/** The name of a file in its address. Those of blob: addresses have none; it may follow as a fragment: `#/model.glb`. */
export function nameOf(url) {
  const { protocol, pathname, hash } = new URL(url);
  const path = protocol === "blob:" || protocol === "data:" ? hash : pathname;
  return decodeURIComponent(path.split("/").pop()) || "model.glb";
}

/** Fetches a file. `progress` gets the fraction that has arrived, if it is known. */
async function read(url, signal, progress = () => {}) {
  const response = await fetch(url, { signal });
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  const size = Number(response.headers.get("content-length"));
  // Compressed answers have another length.
  if (!size || response.headers.get("content-encoding") || !response.body) {
    return new Uint8Array(await response.arrayBuffer());
  }
  const [parts, reader] = [[], response.body.getReader()];
  let count = 0;
  for (let next = await reader.read(); !next.done; next = await reader.read()) {
    parts.push(next.value);
    progress(Math.min(1, (count += next.value.length) / size));
  }
  const bytes = new Uint8Array(count);
  parts.reduce((at, part) => (bytes.set(part, at), at + part.length), 0);
  return bytes;
}

/** Buffers and images that a glTF file names, relative to it. */
function named(bytes) {
  try {
    const { buffers = [], images = [] } = JSON.parse(new TextDecoder().decode(bytes));
    return [...buffers, ...images].map(({ uri }) => uri).filter(uri => uri && !/^[a-z]+:/i.test(uri));
  } catch {
    // The core says what is wrong with the file.
    return [];
  }
}

/** The files of a model, and of its environment map: {main, environment, files}. */
export async function filesOf(src, environment, signal, progress) {
  const main = nameOf(src);
  const map = environment && { name: `environment-${nameOf(environment)}`, bytes: read(environment, signal) };
  map?.bytes.catch(() => {});
  const files = [{ name: main, bytes: await read(src, signal, progress) }];
  if (/\.gltf$/i.test(main)) {
    const uris = [...new Set(named(files[0].bytes))];
    files.push(...await Promise.all(uris.map(async uri =>
      ({ name: decodeURIComponent(uri), bytes: await read(new URL(uri, src).href, signal) }))));
  }
  if (map) files.push({ name: map.name, bytes: await map.bytes });
  return { main, environment: map?.name, files };
}
