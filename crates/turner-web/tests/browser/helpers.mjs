// What the checks of the page share: small scenes and files, and the ways to open them.

import { deflateRawSync } from "node:zlib";
import { Unsupported } from "./webkit.mjs";

/** Milliseconds for a picture of a small scene; machines of CI are slow. */
export const PATIENCE = Number(process.env.TURNER_PATIENCE || 90_000);

/** A red ball before grey, small enough to settle within a second. */
export const SCENE = `# A red ball
[film]
width = 96
height = 64
samples = 4

[camera]
position = [0, 1, 6]
look_at = [0, 0.5, 0]

[background]
color = "slategray"

[material.red]
type = "matte"
color = "#d02010"

[[light]]
type = "point"
position = [-4, 6, 5]

[[object]]
name = "ball"
type = "sphere"
center = [0, 0.5, 0]
radius = 1
material = "red"

[[object]]
name = "small"
type = "sphere"
center = [1.6, 0.4, 1]
radius = 0.4
material = { type = "matte", color = "gold" }
`;

export function assert(condition, message) {
  if (!condition) throw new Error(message);
}

export function equal(found, wanted, what) {
  const short = value => JSON.stringify(value)?.slice(0, 1500);
  assert(found === wanted, `${what}: found ${short(found)}, wanted ${short(wanted)}`);
}

/** The start page, once its gallery is there. */
export async function start(page, base) {
  await page.goto(base);
  await page.waitForSelector("#gallery [data-start]", { timeout: PATIENCE });
}

/** The address that holds a text. */
export const link = (base, text) => `${base}#s=${deflateRawSync(Buffer.from(text)).toString("base64url")}`;

/**
 * Opens a text by its link, and waits for the finished picture. An address that differs only behind `#` would not load
 * the page again.
 */
export async function openText(page, base, text = SCENE) {
  await page.goto("about:blank");
  await page.goto(link(base, text));
  await settled(page);
}

export const frames = page => page.evaluate(() => Number(document.querySelector("#canvas").dataset.frames || 0));

/**
 * Milliseconds without a new picture after which it is the last one: the page orders pictures of another size, and
 * those of what was typed, a quarter of a second late.
 */
const QUIET = 450;

/** Waits for a finished picture after frame number `after`, which stays. */
export async function settled(page, after = 0) {
  for (let last = after; ;) {
    await page.waitForFunction(frame => {
      const { stage, frames } = document.querySelector("#canvas").dataset;
      return stage === "settled" && Number(frames) > frame;
    }, after, { timeout: PATIENCE });
    await page.waitForTimeout(QUIET);
    const now = await frames(page);
    if (now === last) return;
    last = now;
  }
}

/** Acts, and waits for the finished picture that follows. */
export async function andSettles(page, act) {
  const before = await frames(page);
  await act();
  await settled(page, before);
}

/** The picture's bytes, as a data address. */
export const picture = page => page.evaluate(() => document.querySelector("#canvas").toDataURL());

/** [r, g, b] of the picture at fractions of its size. */
export const color = (page, x, y) => page.evaluate(([x, y]) => {
  const canvas = document.querySelector("#canvas");
  const at = [Math.floor(x * canvas.width), Math.floor(y * canvas.height)];
  return Array.from(canvas.getContext("2d").getImageData(...at, 1, 1).data.slice(0, 3));
}, [x, y]);

/** The message that is shown; waits for one. */
export async function message(page) {
  await page.waitForSelector("#message:not([hidden])", { timeout: PATIENCE });
  return page.innerText("#message");
}

/** Drops files on the page: [[name, bytes]]. */
export async function drop(page, files) {
  const plain = files.map(([name, bytes]) => [name, Buffer.from(bytes).toString("base64")]);
  const dropped = await page.evaluate(async files => {
    const data = new DataTransfer();
    for (const [name, text] of files) {
      data.items.add(new File([Uint8Array.from(atob(text), c => c.charCodeAt(0))], name));
    }
    const made = type => new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true });
    // WebKit makes events whose files are never read.
    const entry = made("drop").dataTransfer?.items[0]?.webkitGetAsEntry?.();
    const isRead = !entry || await new Promise(resolve => {
      setTimeout(resolve, 2000, false);
      entry.file(() => resolve(true), () => resolve(false));
    });
    for (const type of isRead ? ["dragenter", "dragover", "drop"] : []) document.body.dispatchEvent(made(type));
    return isRead;
  }, plain);
  if (!dropped) throw new Unsupported("events with files");
}

/** A binary glTF (Khronos glTF 2.0, section 4.4) with one red triangle. */
export function glb() {
  const positions = Float32Array.of(-1, -1, 0, 1, -1, 0, 0, 1, 0);
  const json = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name: "triangle" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }],
    materials: [{ name: "red", doubleSided: true, pbrMetallicRoughness: { baseColorFactor: [0.8, 0.05, 0.02, 1], metallicFactor: 0 } }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [-1, -1, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength }], buffers: [{ byteLength: positions.byteLength }],
  };
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, " ")]);
  const chunk = (type, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, bytes]);
  };
  const body = Buffer.concat([chunk("JSON", padded), chunk("BIN\0", Buffer.from(positions.buffer))]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}

/** A zip file (PKWARE's APPNOTE 6.3) of [[name, bytes]]. `lie` changes the size that the directory states. */
export function zip(files, lie = size => size) {
  const locals = [];
  const central = [];
  let offset = 0;
  for (const [name, content] of files) {
    const bytes = Buffer.from(content);
    const packed = deflateRawSync(bytes);
    const file = Buffer.from(name);
    const local = Buffer.alloc(30);
    local.writeUInt32LE(0x04034b50, 0);
    local.writeUInt16LE(8, 8);
    local.writeUInt32LE(packed.length, 18);
    local.writeUInt32LE(lie(bytes.length), 22);
    local.writeUInt16LE(file.length, 26);
    const entry = Buffer.alloc(46);
    entry.writeUInt32LE(0x02014b50, 0);
    entry.writeUInt16LE(8, 10);
    entry.writeUInt32LE(packed.length, 20);
    entry.writeUInt32LE(lie(bytes.length), 24);
    entry.writeUInt16LE(file.length, 28);
    entry.writeUInt32LE(offset, 42);
    locals.push(local, file, packed);
    central.push(entry, file);
    offset += 30 + file.length + packed.length;
  }
  const directory = Buffer.concat(central);
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(files.length, 8);
  end.writeUInt16LE(files.length, 10);
  end.writeUInt32LE(directory.length, 12);
  end.writeUInt32LE(offset, 16);
  return Buffer.concat([...locals, directory, end]);
}
