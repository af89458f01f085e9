// Runs the checks of this folder in Chromium: node run.mjs FOLDER NODE_MODULES [NAME…]
//
// FOLDER is the built page, NODE_MODULES holds playwright-core. A check is a pair of a name and an async function of a page
// and the address of the folder; checks that throw fail. CHROMIUM names the browser.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [folder, modules, ...only] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(modules), "x"));
const { chromium } = require("playwright-core");

const TYPES = {
  html: "text/html; charset=utf-8", js: "text/javascript", css: "text/css", wasm: "application/wasm", json: "application/json",
  webmanifest: "application/manifest+json", jpg: "image/jpeg", svg: "image/svg+xml", png: "image/png",
};

/** A static host; with `isolated` it sends the headers that threads need. */
async function host(isolated) {
  const server = createServer(async (request, response) => {
    const name = decodeURIComponent(new URL(request.url, "http://host").pathname).replace(/\/$/, "/index.html");
    const file = path.join(folder, path.normalize(name));
    try {
      const bytes = await readFile(file);
      response.setHeader("Content-Type", TYPES[path.extname(file).slice(1)] ?? "application/octet-stream");
      response.setHeader("Cache-Control", "no-cache");
      if (isolated) {
        response.setHeader("Cross-Origin-Opener-Policy", "same-origin");
        response.setHeader("Cross-Origin-Embedder-Policy", "require-corp");
      }
      response.end(bytes);
    } catch {
      response.statusCode = 404;
      response.end("not found");
    }
  });
  await new Promise(resolve => server.listen(0, "127.0.0.1", resolve));
  return { base: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

const CHROMIUM = process.env.CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
if (!CHROMIUM) {
  console.error("no Chromium was found: install it, or name it in CHROMIUM");
  process.exit(1);
}

const here = path.dirname(fileURLToPath(import.meta.url));
const browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", "--disable-gpu"] });
const hosts = { isolated: await host(true), plain: await host(false) };
let failed = 0;
for (const file of ["engine.mjs", "page.mjs", "view.mjs"].filter(name => existsSync(path.join(here, name)))) {
  const { checks } = await import(pathToFileURL(path.join(here, file)));
  for (const [name, check, options = {}] of checks) {
    if (only.length && !only.some(part => name.includes(part))) continue;
    const begun = Date.now();
    const { workers = "block", plain = false, ...context } = options;
    // Service workers are tested by the checks that allow them; elsewhere they would keep files.
    const own = await browser.newContext({ serviceWorkers: workers, acceptDownloads: true, ...context });
    const page = await own.newPage();
    try {
      await check(page, (plain ? hosts.plain : hosts.isolated).base);
      console.log(`ok      ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      failed += 1;
      console.log(`FAILED  ${name}: ${String(error?.stack ?? error).slice(0, 1500)}`);
    }
    await own.close();
  }
}
await browser.close();
hosts.isolated.close();
hosts.plain.close();
process.exit(failed ? 1 : 0);
