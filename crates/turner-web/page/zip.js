// Zip files (PKWARE's APPNOTE 6.3): the entries of an untrusted file, within limits.

const LIMITS = { entries: 10_000, bytes: 2 ** 30 };
const END = 0x06054b50;
const CENTRAL = 0x02014b50;
const LOCAL = 0x04034b50;
/** Size of the end record, and of the longest comment after it. */
const END_SIZE = 22;
const COMMENT = 0xffff;

class ZipError extends Error {
  constructor(message, help = "Make the zip file again, without encryption.") {
    super(message);
    this.help = help;
  }
}

export const isZip = bytes => bytes.length > 3 && bytes[0] === 0x50 && bytes[1] === 0x4b && (bytes[2] === 3 || bytes[2] === 5);

/** [{name, bytes}] */
export async function unzip(bytes, limits = LIMITS) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const entries = directory(view, bytes, limits);
  const files = [];
  let total = 0;
  for (const entry of entries) {
    const left = limits.bytes - total;
    const content = await extract(view, bytes, entry, left);
    total += content.length;
    files.push({ name: entry.name, bytes: content });
  }
  return files;
}

/** The central directory, at the end of the file. */
function directory(view, bytes, limits) {
  let end = -1;
  for (let i = bytes.length - END_SIZE; i >= Math.max(0, bytes.length - END_SIZE - COMMENT); i--) {
    if (view.getUint32(i, true) === END) { end = i; break; }
  }
  if (end < 0) throw new ZipError("the zip file has no directory: it is cut off, or is not a zip file");
  const count = view.getUint16(end + 10, true);
  let at = view.getUint32(end + 16, true);
  if (count === 0xffff || at === 0xffffffff) throw new ZipError("the zip file is a zip64 file, which this page does not read", "Make a zip file of less than 4 GiB and 65,535 entries.");
  if (count > limits.entries) throw new ZipError(`the zip file has ${count} entries, at most ${limits.entries} are read`, "Zip the scene and its textures alone.");
  const found = [];
  const names = new Set();
  let declared = 0;
  for (let i = 0; i < count; i++) {
    if (at + 46 > bytes.length || view.getUint32(at, true) !== CENTRAL) throw new ZipError("the directory of the zip file is broken");
    const [nameSize, extra, comment] = [28, 30, 32].map(field => view.getUint16(at + field, true));
    if (at + 46 + nameSize > bytes.length) throw new ZipError("the directory of the zip file is broken");
    const name = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + nameSize)).replaceAll("\\", "/");
    const entry = {
      name, flags: view.getUint16(at + 8, true), method: view.getUint16(at + 10, true),
      packed: view.getUint32(at + 20, true), size: view.getUint32(at + 24, true), offset: view.getUint32(at + 42, true),
    };
    at += 46 + nameSize + extra + comment;
    if (name.endsWith("/") || isOfSystem(name)) continue;
    checkName(name);
    if (names.has(name)) throw new ZipError(`the zip file has two entries “${name}”`);
    names.add(name);
    declared += entry.size;
    if (declared > limits.bytes) throw tooLarge(limits.bytes);
    found.push(entry);
  }
  return found;
}

const tooLarge = bytes => new ZipError(`the zip file has more than ${mebibytes(bytes)} of files`, "Use smaller textures, or fewer files.");
const mebibytes = bytes => `${Math.floor(bytes / 2 ** 20).toLocaleString("en")} MiB`;

/** Files that systems add to folders. */
export const isOfSystem = name => /(^|\/)(__MACOSX\/|\.DS_Store$|Thumbs\.db$|desktop\.ini$|\.git\/)/.test(name);

/** Names stay inside the folder. */
export function checkName(name) {
  if (/^\/|^[A-Za-z]:|\0/.test(name) || name.split("/").includes("..")) {
    throw new ZipError(`the entry “${name.slice(0, 200)}” of the zip file lies outside its folder`, "Names must be relative, without “..”.");
  }
}

async function extract(view, bytes, entry, left) {
  const { name, offset, packed, method, flags, size } = entry;
  if (flags & 1) throw new ZipError(`“${name}” in the zip file is encrypted`);
  if (offset + 30 > bytes.length || view.getUint32(offset, true) !== LOCAL) throw new ZipError(`“${name}” in the zip file is broken`);
  const start = offset + 30 + view.getUint16(offset + 26, true) + view.getUint16(offset + 28, true);
  if (start + packed > bytes.length) throw new ZipError(`“${name}” in the zip file is cut off`);
  const content = bytes.subarray(start, start + packed);
  if (method === 0) return content.slice();
  if (method !== 8) throw new ZipError(`“${name}” in the zip file has the compression method ${method}; 0 (stored) and 8 (deflate) are read`);
  let result;
  try {
    result = await inflate(content, Math.min(size, left));
  } catch (error) {
    if (error instanceof ZipError) throw error;
    throw new ZipError(`“${name}” in the zip file is broken: its compressed bytes do not decode`);
  }
  if (!result) throw new ZipError(`“${name}” in the zip file has more bytes than it states`);
  if (result.length !== size) throw new ZipError(`“${name}” in the zip file has ${result.length} bytes, its directory says ${size}`);
  return result;
}

/** Decompresses deflate data; `null` if it has more than `most` bytes. Stops reading then. */
export async function inflate(bytes, most) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const chunks = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    size += value.length;
    if (size > most) {
      await reader.cancel().catch(() => {});
      return null;
    }
    chunks.push(value);
  }
  return join(chunks, size);
}

export async function deflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function join(chunks, size) {
  const all = new Uint8Array(size);
  let at = 0;
  for (const chunk of chunks) {
    all.set(chunk, at);
    at += chunk.length;
  }
  return all;
}
