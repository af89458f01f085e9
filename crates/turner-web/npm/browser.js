// The package in a browser: workers are those of the page.
import { bind } from "./turner.js";

/** @type {import("./turner.js").Host} */
const host = {
  wasm: new URL("./turner.wasm", import.meta.url),

  async compile(wasm) {
    const response = await fetch(wasm);
    if (!response.ok) throw new Error(`${wasm}: ${response.status} ${response.statusText}`);
    const copy = response.clone();
    try {
      return await WebAssembly.compileStreaming(response);
    } catch {
      // Hosts that send the module with another type than application/wasm.
      return WebAssembly.compile(await copy.arrayBuffer());
    }
  },

  threads: () => navigator.hardwareConcurrency || 1,

  startSession(onMessage, onError) {
    const worker = new Worker(new URL("./browser-session.js", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }) => onMessage(data);
    worker.onerror = event => onError(event.message || "the worker cannot be started");
    return {
      post: (message, transfer) => worker.postMessage(message, transfer),
      end: () => worker.terminate(),
      hold() {},
    };
  },
};

export const { Turner, TurnerError, render } = bind(host);
