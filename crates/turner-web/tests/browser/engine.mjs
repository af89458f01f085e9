// Checks of the engine without the page's controls: the same bytes as the native program, with threads and without.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { Unsupported } from "./webkit.mjs";

/** Files that the native program wrote: scenes with their pictures. See xtask's `web/expected.rs`. */
const EXPECTED = process.env.TURNER_EXPECTED;

/** Opens an empty page of the folder that has an engine in `window.engine`. */
async function engine(page, base, options = {}) {
  await page.goto(`${base}blank.html`);
  return page.evaluate(async ({ base, options }) => {
    const { startLocal } = await import(`${base}engine.js`);
    window.engine = await startLocal(options);
    const { threads, isolated, memory } = window.engine;
    return { threads, isolated, memory };
  }, { base, options });
}

/** Makes a call in the page; an error is returned as `{error}`. */
function call(page, name, args = {}, files = []) {
  return page.evaluate(async ({ name, args, files }) => {
    const own = files.map(file => ({ name: file.name, bytes: new TextEncoder().encode(file.text) }));
    try {
      const { bytes, ...ok } = await window.engine.call(name, args, own);
      return { ...ok, bytes: bytes && btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join("")) };
    } catch (error) {
      const { message, line, column } = error;
      return { error: { ...error, message, line, column } };
    }
  }, { name, args, files });
}

/** Whether the browser sends memory to workers; called in the page. */
function sharesMemory() {
  try {
    new MessageChannel().port1.postMessage(new WebAssembly.Memory({ initial: 1, maximum: 1, shared: true }));
    return true;
  } catch {
    return false;
  }
}

/** Waits until the picture of the last call is finished. */
function settled(page) {
  return page.evaluate(() => new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error("the picture is not finished after 100 s")), 100_000);
    window.engine.addEventListener("status", ({ detail }) => {
      if (detail.error) reject(new Error(detail.error.message));
      if (detail.settled) { clearTimeout(late); resolve(); }
    });
    window.engine.addEventListener("fault", ({ detail }) => reject(new Error(detail.message)));
  }));
}

async function sameBytes(page) {
  for (const name of ["hello", "paths"]) {
    const text = await readFile(path.join(EXPECTED, `${name}.toml`), "utf8");
    const end = settled(page);
    const { error } = await call(page, "set_text", { text });
    assert.equal(error, undefined);
    await end;
    for (const format of ["png", "exr"]) {
      const { bytes, settled } = await call(page, "save", { format });
      assert.ok(settled);
      const wanted = await readFile(path.join(EXPECTED, `${name}.${format}`));
      assert.ok(Buffer.from(bytes, "base64").equals(wanted), `${name}.${format} differs from the native file`);
    }
  }
}

const SMALL = '[film]\nwidth = 40\nheight = 30\n[[light]]\ntype = "ambient"\n[[object]]\ntype = "sphere"\n';

export const checks = [
  ["threads render the bytes of the native program", async (page, base) => {
    const { threads, isolated } = await engine(page, base, { threads: 3 });
    if (!await page.evaluate(sharesMemory)) throw new Unsupported("memory that workers share");
    assert.deepEqual({ threads, isolated }, { threads: 3, isolated: true });
    await sameBytes(page);
  }],
  ["one thread renders them where the host sends no headers", async (page, base) => {
    const { threads, isolated } = await engine(page, base, { threads: 3 });
    assert.deepEqual({ threads, isolated }, { threads: 1, isolated: false });
    await sameBytes(page);
  }, { plain: true }],
  ["a bad file has a message, and the engine continues", async (page, base) => {
    await engine(page, base);
    const hostile = await call(page, "open", {}, [{ name: "a.glb", text: "glTF\u0002\u0000\u0000\u0000not a model" }]);
    assert.match(hostile.error.message, /a\.glb/);
    const text = await call(page, "set_text", { text: '[[object]]\ntype = "spher"\n' });
    assert.deepEqual([text.error.line, text.error.column], [2, 8]);
    assert.match(text.error.help, /sphere/);
    const end = settled(page);
    await call(page, "set_text", { text: SMALL });
    await end;
  }],
  ["a picture beyond the memory limit has a message", async (page, base) => {
    await engine(page, base);
    const failed = page.evaluate(() => new Promise(resolve => {
      window.engine.addEventListener("status", ({ detail }) => detail.error && resolve(detail.error));
      window.engine.addEventListener("fault", ({ detail }) => resolve(detail));
    }));
    await call(page, "set_text", { text: SMALL.replace("width = 40", "width = 16000").replace("height = 30", "height = 16000") });
    const { message } = await failed;
    assert.match(message, /memory/);
    const end = settled(page);
    await call(page, "set_text", { text: SMALL });
    await end;
  }],
  ["what moves is answered while it moves", async (page, base) => {
    await engine(page, base);
    await call(page, "open_start", { id: "cornell-box" });
    const frames = await page.evaluate(async () => {
      let frames = 0;
      window.engine.addEventListener("frame", () => { frames += 1; });
      for (let i = 0; i < 20; i++) {
        await window.engine.call("gesture", { kind: "orbit", x: 0.02, y: 0 });
        await new Promise(resolve => setTimeout(resolve, 50));
      }
      await window.engine.call("gesture_end");
      return frames;
    });
    assert.ok(frames >= 3, `${frames} frames while the camera moved 20 times`);
  }],
  ["the service worker isolates the page and keeps it without a network", async (page, base) => {
    await page.goto(base);
    await page.waitForFunction(() => window.crossOriginIsolated, null, { timeout: 30_000 });
    const all = () => page.evaluate(async () => {
      const [name] = await caches.keys();
      return name ? (await (await caches.open(name)).keys()).length : 0;
    });
    for (const begun = Date.now(); (await all()) < 90;) {
      assert.ok(Date.now() - begun < 60_000, "the files of the page are not kept");
      await new Promise(resolve => setTimeout(resolve, 200));
    }
    await page.context().setOffline(true);
    await page.goto(`${base}?start=002-02-one-light`);
    await page.waitForFunction(() => document.getElementById("scene-name").textContent === "2. One light", null, { timeout: 60_000 });
  }, { plain: true, workers: "allow" }],
];
