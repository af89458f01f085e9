// The package in Node: workers are worker threads.
import { readFile } from "node:fs/promises";
import { availableParallelism, cpus } from "node:os";
import { fileURLToPath } from "node:url";
import { Worker } from "node:worker_threads";
import { bind } from "./turner.js";

/** @type {import("./turner.js").Host} */
const host = {
  wasm: new URL("./turner.wasm", import.meta.url),

  async compile(wasm) {
    const url = wasm instanceof URL ? wasm : /^[a-z]+:\/\//.test(wasm) ? new URL(wasm) : null;
    if (url && url.protocol !== "file:") {
      const response = await fetch(url);
      if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
      return WebAssembly.compile(await response.arrayBuffer());
    }
    return WebAssembly.compile(await readFile(url ? fileURLToPath(url) : wasm));
  },

  threads: () => availableParallelism?.() ?? cpus().length,

  startSession(onMessage, onError) {
    const worker = new Worker(new URL("./node-session.js", import.meta.url));
    worker.on("message", onMessage);
    worker.on("error", error => onError(error.message));
    // A program ends although a session is kept for the next picture.
    worker.unref();
    return {
      post: (message, transfer) => worker.postMessage(message, transfer),
      end: () => void worker.terminate(),
      hold: busy => busy ? worker.ref() : worker.unref(),
    };
  },
};

export const { Turner, TurnerError, render } = bind(host);
