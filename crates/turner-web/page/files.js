// Files from the machine: dropped, chosen, or in a zip file. They are read here and never sent anywhere.

import { find } from "./dom.js";
import { fail } from "./message.js";
import { checkName, isOfSystem, isZip, unzip } from "./zip.js";

const LIMITS = { files: 10_000, bytes: 2 ** 30, depth: 32 };
const FORMATS = "This page opens .glb, .gltf, .usdz, .usd, .obj, .ply, .stl, .toml, .pbrt and Mitsuba’s .xml, alone, in a folder or in a .zip file.";
const KNOWN = /\.(toml|glb|gltf|usd[acz]?|pbrt|xml|obj|ply|stl)$/i;
// A package of USD is a zip file that the reader opens itself.
const PACKAGE = /\.usdz$/i;

export function setupFiles(page) {
  const files = find("files");
  const folder = find("folder");
  page.chooseFiles = () => files.click();
  page.chooseFolder = () => folder.click();
  find("choose-files").addEventListener("click", page.chooseFiles);
  find("choose-folder").addEventListener("click", page.chooseFolder);
  for (const input of [files, folder]) {
    input.addEventListener("change", async () => {
      const chosen = Array.from(input.files, file => ({ name: file.webkitRelativePath || file.name, file }));
      input.value = "";
      if (chosen.length) await openAll(page, chosen);
    });
  }
  drops(page);
}

function drops(page) {
  const veil = find("dropping");
  const carries = event => Array.from(event.dataTransfer?.types || []).includes("Files");
  let inside = 0;
  addEventListener("dragenter", event => {
    if (!carries(event)) return;
    inside++;
    veil.hidden = false;
  });
  addEventListener("dragleave", event => {
    if (carries(event) && --inside <= 0) { inside = 0; veil.hidden = true; }
  });
  addEventListener("dragover", event => { if (carries(event)) event.preventDefault(); });
  addEventListener("drop", event => {
    inside = 0;
    veil.hidden = true;
    if (!carries(event)) return;
    event.preventDefault();
    // Entries are only there during the event.
    const entries = Array.from(event.dataTransfer.items, item => item.webkitGetAsEntry?.()).filter(Boolean);
    const plain = Array.from(event.dataTransfer.files, file => ({ name: file.name, file }));
    openAll(page, entries.length ? walk(entries) : plain);
  });
}

/** Opens files. Without `main` the engine chooses the scene among them. */
async function openAll(page, list, main = null) {
  let files;
  try {
    files = await readAll(list = await list, await page.ready);
  } catch (error) {
    fail(error, "Cannot open the files");
    return;
  }
  const names = files.map(({ name }) => name);
  const what = main || (names.length === 1 ? names[0] : "the files");
  const opened = await page.open(what, { files: names.filter(name => name !== main && !(names.length === 1 && /\.toml$/i.test(name))) }, () => page.call("open", main ? { main } : {}, files), error => {
    // Several scenes: the user chooses one.
    const wanted = /^open one of: (.+)$/.exec(error.help || "")?.[1].split(", ").filter(name => names.includes(name)) || [];
    return wanted.map(name => [name, () => openAll(page, list, name)]);
  });
  if (opened) page.remember({ files: true });
}

/** The files of dropped folders, by their paths. */
async function walk(entries, depth = 0, found = []) {
  if (depth > LIMITS.depth) throw withHelp(`the folders are nested more than ${LIMITS.depth} deep`, "Drop the scene’s own folder.");
  for (const entry of entries) {
    const name = entry.fullPath.replace(/^\//, "");
    if (isOfSystem(name) || isOfSystem(`${name}/`)) continue;
    if (entry.isFile) found.push({ name, file: await new Promise((resolve, reject) => entry.file(resolve, reject)) });
    else if (entry.isDirectory) await walk(await children(entry), depth + 1, found);
    if (found.length > LIMITS.files) throw tooMany();
  }
  return found;
}

/** A reader gives at most a hundred entries at a time. */
async function children(directory) {
  const reader = directory.createReader();
  const all = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return all;
    all.push(...some);
    if (all.length > LIMITS.files) throw tooMany();
  }
}

/** Reads files into memory, and those of a zip file. */
async function readAll(list, engine) {
  const wanted = list.filter(({ name }) => !isOfSystem(name));
  if (!wanted.length) throw withHelp("no file was found", FORMATS);
  if (wanted.length > LIMITS.files) throw tooMany();
  const most = Math.min(LIMITS.bytes, engine.memory || Infinity);
  const size = wanted.reduce((sum, { file }) => sum + file.size, 0);
  if (size > most) throw withHelp(`the files have ${mebibytes(size)}; the renderer of this page can use ${mebibytes(most)}`, "Use smaller textures or meshes, or render with the program turner.");
  let files = [];
  for (const { name, file } of wanted) {
    checkName(name);
    try {
      files.push({ name, bytes: new Uint8Array(await file.arrayBuffer()) });
    } catch {
      throw withHelp(`${name} cannot be read`, "Check that the file still exists and that the browser may read it.");
    }
  }
  if (files.length === 1 && isZip(files[0].bytes) && !PACKAGE.test(files[0].name)) files = await unzip(files[0].bytes, { entries: LIMITS.files, bytes: most });
  if (!files.some(({ name }) => KNOWN.test(name))) {
    const found = Array.from(new Set(files.map(({ name }) => /\.[^./]+$/.exec(name)?.[0] || "no extension"))).slice(0, 8).join(", ");
    throw withHelp(`no scene or model is among the files (found: ${found})`, FORMATS);
  }
  return files;
}

const mebibytes = bytes => `${Math.ceil(bytes / 2 ** 20).toLocaleString("en")} MiB`;
const tooMany = () => withHelp(`there are more than ${LIMITS.files.toLocaleString("en")} files`, "Drop the scene’s own folder.");
const withHelp = (message, help) => Object.assign(new Error(message), { help });
