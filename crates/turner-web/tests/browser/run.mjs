// Runs the checks of this folder in browsers: node run.mjs FOLDER NODE_MODULES [NAME…]
//
// FOLDER is the built page, NODE_MODULES holds playwright-core. A check is a triple of a name, an async function of a page
// and the address of the folder, and options; checks that throw fail. They run in Chromium, and where they are
// installed in Firefox and in WebKit (its driver needs a display). What a driver lacks is left out: it throws, or the option
// `driver` names the one that has it. A check that has no answer from Firefox or WebKit in time runs once more in a browser
// started again, and fails if it has none then: a page that hangs does so twice. CHROMIUM, FIREFOX and WEBKIT name the programs;
// BROWSERS="firefox" runs one of them alone.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { launch as launchWebKit, Unsupported } from "./webkit.mjs";

const [folder, modules, ...only] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(modules), "x"));
const { chromium, firefox } = require("playwright-core");

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

const found = (variable, ...places) => process.env[variable] ?? places.find(existsSync);
const PROGRAMS = {
  chromium: found("CHROMIUM", "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"),
  firefox: found("FIREFOX", "/usr/bin/firefox-esr", "/usr/bin/firefox"),
  webkit: process.env.DISPLAY && found("WEBKIT", "/usr/bin/WebKitWebDriver"),
};
const isWanted = name => process.env.BROWSERS?.split(/[ ,]+/).includes(name) ?? true;
if (isWanted("chromium") && !PROGRAMS.chromium) {
  console.error("no Chromium was found: install it, or name it in CHROMIUM");
  process.exit(1);
}
const LAUNCH = {
  chromium: executablePath => chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu"] }),
  // The program as it is installed, by WebDriver BiDi.
  firefox: executablePath => firefox.launch({ executablePath, channel: "moz-firefox" }),
  webkit: launchWebKit,
};

/** Milliseconds for a check, and for closing its page. */
const [LIMIT, CLOSING] = [180_000, 30_000];

const here = path.dirname(fileURLToPath(import.meta.url));
const hosts = { isolated: await host(true), plain: await host(false) };
let failed = 0;
for (const [name, program] of Object.entries(PROGRAMS)) {
  if (isWanted(name) && program) {
    await run(name, program);
  } else {
    console.log(`${name}: left out, ${isWanted(name) ? "it is not installed" : "as BROWSERS says"}`);
  }
}

/** A driver or a page that did not answer in time. */
class Late extends Error {}

/** The result of a promise, or an error if it takes longer: a driver may never answer. */
function within(ms, promise) {
  let late;
  const limit = new Promise((_, reject) => { late = setTimeout(() => reject(new Late(`no answer after ${ms / 1000} s`)), ms); });
  return Promise.race([promise, limit]).finally(() => clearTimeout(late));
}

/** Runs the checks in a browser. */
async function run(name, program) {
  let browser = await LAUNCH[name](program);
  console.log(`${name} ${browser.version()}`);
  for (const file of ["engine.mjs", "page.mjs", "view.mjs"].filter(name => existsSync(path.join(here, name)))) {
    const { checks } = await import(pathToFileURL(path.join(here, file)));
    for (const check of checks) {
      const [title, , { driver = name } = {}] = check;
      if (only.length && !only.some(part => title.includes(part))) continue;
      if (driver !== name) {
        console.log(`left out  ${title}: only the driver of ${driver} can`);
        continue;
      }
      let ended = await one(check);
      if (ended === "late" && name !== "chromium") ended = await one(check);
      failed += ended === "passed" ? 0 : 1;
    }
  }
  await within(CLOSING, browser.close()).catch(() => {});

  /** Runs one check in a page of its own: "passed" (also what the driver lacks), "failed" or "late". */
  async function one([title, check, options = {}]) {
    const { workers = "block", plain = false, driver: _, ...context } = options;
    const begun = Date.now();
    let own, ended = "passed";
    try {
      // Service workers are tested by the checks that allow them; elsewhere they would keep files.
      own = await browser.newContext({ serviceWorkers: workers, acceptDownloads: true, ...context });
      await within(LIMIT, check(await own.newPage(), (plain ? hosts.plain : hosts.isolated).base));
      console.log(`ok      ${title} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      const text = String(error?.stack ?? error);
      // What stock browsers answer to commands that they do not know.
      const isLacking = name !== "chromium" && (error instanceof Unsupported || /unknown command|CDP session is only/.test(text));
      if (!isLacking) ended = error instanceof Late ? "late" : "failed";
      console.log(`${isLacking ? "left out" : "FAILED "} ${title}: ${text.slice(0, isLacking ? 120 : 1500)}`);
    }
    try {
      await within(CLOSING, own?.close());
      if (ended === "late") throw new Late();
    } catch {
      console.log(`          ${name} is started again`);
      await within(CLOSING, browser.close()).catch(() => {});
      browser = await LAUNCH[name](program);
    }
    return ended;
  }
}
hosts.isolated.close();
hosts.plain.close();
process.exit(failed ? 1 : 0);
