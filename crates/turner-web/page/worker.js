// The session's worker: loads the module, starts threads, makes the page's calls and renders between them.
import { Core, newMemory } from "./core.js";

/** Memory that is kept free of scenes and pictures, for what has no limit of its own: 64 MiB. */
const RESERVE = 64 << 20;

/** Seconds after which a thread that does not start is given up. */
const PATIENCE = 10;

let core;
let fault = "";
let runs = false;
const { port1: wake, port2: pump } = new MessageChannel();

/** Compiles the module while it is fetched; hosts that send it with another type than application/wasm are read whole. */
async function compile(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  const copy = response.clone();
  try {
    return await WebAssembly.compileStreaming(response);
  } catch {
    return WebAssembly.compile(await copy.arrayBuffer());
  }
}

/** Starts a thread; whether it runs. */
function startThread() {
  return new Promise(resolve => {
    const thread = new Worker(new URL("thread.js", import.meta.url), { type: "module" });
    const late = setTimeout(() => { thread.terminate(); resolve(false); }, PATIENCE * 1000);
    thread.onerror = () => { clearTimeout(late); resolve(false); };
    thread.onmessage = ({ data }) => {
      if (data.ready) { clearTimeout(late); resolve(true); } else end(data.fault);
    };
    thread.postMessage(core.newThread());
  });
}

/** Tells the page that the session has ended. The page starts another worker. */
function end(message) {
  self.postMessage({ fault: message });
}

/** Whether a memory can be sent to other workers: WebKit for GTK isolates pages, but shares no memory. */
function canPost(memory) {
  const { port1, port2 } = new MessageChannel();
  try {
    port1.postMessage(memory);
    return true;
  } catch {
    return false;
  } finally {
    port1.close();
    port2.close();
  }
}

async function start({ wasm, threads }) {
  const module = wasm instanceof WebAssembly.Module ? wasm : await compile(wasm);
  const { memory, limit } = newMemory();
  const isShared = self.crossOriginIsolated === true && canPost(memory);
  core = new Core(module, memory, message => { fault = message; });
  core.begin(limit - RESERVE);
  const wanted = isShared ? Math.max(1, threads || navigator.hardwareConcurrency || 1) : 1;
  const started = await Promise.all(Array.from({ length: wanted - 1 }, startThread));
  const running = 1 + started.filter(Boolean).length;
  // The threads have said that they are about to serve; the last step takes them a moment.
  const begun = performance.now();
  while (core.threads < running && performance.now() - begun < 1000) await new Promise(r => setTimeout(r, 1));
  self.postMessage({
    started: true, threads: core.threads, isolated: isShared, memory: limit,
    shared: isShared ? { memory, stop: core.stop } : null,
  });
}

/** Runs a part of the session; a panic or the end of memory ends it with a message. */
function guarded(work) {
  try {
    return work();
  } catch (error) {
    core = null;
    end(fault || String(error?.message ?? error));
    return undefined;
  }
}

function sendEvents() {
  for (const { event, detail } of core.events()) {
    self.postMessage({ event, detail }, detail.pixels ? [detail.pixels.buffer] : []);
  }
}

function render() {
  if (!core) return;
  const begun = performance.now();
  const more = guarded(() => {
    const more = core.step();
    sendEvents();
    return more;
  });
  runs = more === true;
  if (!runs) return;
  // Between the moves of a camera there is nothing to do for a moment.
  if (performance.now() - begun < 0.5) setTimeout(render, 4); else wake.postMessage(null);
}

pump.onmessage = render;

self.onmessage = ({ data }) => {
  if (data.start) {
    start(data.start).catch(error => end(String(error?.message ?? error)));
    return;
  }
  if (!core) {
    self.postMessage({ id: data.id, error: { message: "the renderer is not running" } });
    return;
  }
  guarded(() => {
    const { ok, error, bytes } = core.call(data.name, data.args, data.files);
    if (bytes && ok) ok.bytes = bytes;
    self.postMessage({ id: data.id, ok, error }, bytes ? [bytes.buffer] : []);
    sendEvents();
    if (!runs) {
      runs = true;
      wake.postMessage(null);
    }
  });
};
