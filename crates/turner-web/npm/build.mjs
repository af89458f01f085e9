// Puts the package together: node build.mjs OUT TURNER.WASM. `npm pack OUT` makes the file for a registry.
import { copyFile, mkdir, readdir } from "node:fs/promises";
import { fileURLToPath } from "node:url";

/** Copies the package with its module to a folder. */
export async function build(out, wasm) {
  const own = new URL("./", import.meta.url);
  await mkdir(out, { recursive: true });
  const names = (await readdir(own)).filter(name => /\.(js|json|md|d\.ts)$/.test(name));
  const from = names.map(name => [new URL(name, own), name]);
  from.push([new URL("../page/core.js", own), "core.js"], [wasm, "turner.wasm"]);
  for (const name of ["LICENSE-MIT", "LICENSE-APACHE"]) from.push([new URL(`../../../${name}`, own), name]);
  for (const [path, name] of from) await copyFile(path, `${out}/${name}`);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [, , out, wasm] = process.argv;
  if (!wasm) {
    console.error("usage: node build.mjs OUT TURNER.WASM");
    process.exit(2);
  }
  await build(out, wasm);
}
