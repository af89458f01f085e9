// What the tests share: the package as it is installed, and small inputs.
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { inflateSync } from "node:zlib";
import { build } from "../build.mjs";

/** The package: that of the folder TURNER_NPM, or one that is put together with the module TURNER_WASM. */
export async function installed() {
  let folder = process.env.TURNER_NPM;
  if (!folder) {
    const wasm = process.env.TURNER_WASM;
    if (!wasm) throw new Error("TURNER_WASM must be the path of turner.wasm");
    folder = await mkdtemp(join(tmpdir(), "turner-npm-"));
    await build(folder, wasm);
    cleanups.push(() => rm(folder, { recursive: true }));
  }
  return import(join(folder, "node.js"));
}

export const cleanups = [];

/** A glTF model: a box of 24 vertices. */
export const box = () => readFile(new URL("../../../turner-io/tests/assets/gltf/Box.glb", import.meta.url));

/** A lit ball of this size. */
export const ball = (width, height, more = "") => `
[film]
width = ${width}
height = ${height}
samples = 8
[integrator]
type = "path"
[studio]
${more}
[[object]]
type = "sphere"
`;

/** The pixels of a PNG of 8 bits with three or four channels, as RGBA. */
export function decodePng(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const parts = [];
  let header;
  for (let at = 8; at < bytes.length;) {
    const length = view.getUint32(at);
    const type = String.fromCharCode(...bytes.subarray(at + 4, at + 8));
    if (type === "IHDR") header = { width: view.getUint32(at + 8), height: view.getUint32(at + 12), depth: bytes[at + 16], color: bytes[at + 17] };
    if (type === "IDAT") parts.push(bytes.subarray(at + 8, at + 8 + length));
    at += length + 12;
  }
  const { width, height, depth, color } = header;
  const channels = { 2: 3, 6: 4 }[color];
  if (depth !== 8 || !channels) throw new Error(`depth ${depth}, colour type ${color}`);
  const raw = inflateSync(Buffer.concat(parts));
  const row = width * channels;
  const lines = new Uint8Array(row * height);
  const paeth = (a, b, c) => {
    const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
  };
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (row + 1)];
    for (let x = 0; x < row; x++) {
      const at = y * row + x;
      const left = x >= channels ? lines[at - channels] : 0;
      const up = y ? lines[at - row] : 0;
      const corner = y && x >= channels ? lines[at - row - channels] : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      lines[at] = raw[y * (row + 1) + 1 + x] + guess;
    }
  }
  const data = new Uint8Array(width * height * 4).fill(255);
  for (let i = 0; i < width * height; i++) data.set(lines.subarray(i * channels, (i + 1) * channels), i * 4);
  return { width, height, data };
}
