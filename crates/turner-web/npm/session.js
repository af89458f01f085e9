// The session in its worker: one memory, in which pictures are rendered one after another.
import { Core, newMemory } from "./core.js";

/** Memory that is kept free of scenes and pictures, for what has no limit of its own: 64 MiB. */
const RESERVE = 64 << 20;

/** Milliseconds after which a thread that does not start is given up, and after which one that has started must serve. */
const PATIENCE = 10_000;
const LAST_STEP = 1000;

/** Seconds between two reports of progress: a picture that is cancelled ends after this time. */
const STEP = 0.05;

/**
 * @param {{isShared: boolean, post: Function, startThread: Function}} host
 * @returns {(message: object) => void} takes the messages of the program
 */
export function serve(host) {
  let core = null;
  let fault = "";
  let cancelled = 0;
  const { port1: here, port2: there } = new MessageChannel();

  /** Lets messages of the program arrive. */
  const turn = () => new Promise(resolve => {
    here.onmessage = resolve;
    there.postMessage(null);
  });

  const end = message => {
    core = null;
    host.post({ fault: message });
  };

  const startThread = () => new Promise(resolve => {
    let stop = () => {};
    const late = setTimeout(() => { stop(); resolve(false); }, PATIENCE);
    const settle = runs => { clearTimeout(late); resolve(runs); };
    stop = host.startThread(
      core.newThread(),
      message => message.ready ? settle(true) : end(message.fault),
      () => settle(false),
    );
  });

  async function start({ module, threads }) {
    const { memory, limit } = newMemory();
    core = new Core(module, memory, message => { fault = message; });
    core.begin(limit - RESERVE);
    const wanted = host.isShared ? Math.max(1, threads) : 1;
    const started = await Promise.all(Array.from({ length: wanted - 1 }, startThread));
    const running = 1 + started.filter(Boolean).length;
    const begun = performance.now();
    while (core.threads < running && performance.now() - begun < LAST_STEP) await new Promise(r => setTimeout(r, 1));
    host.post({
      started: true, threads: core.threads, limit,
      shared: host.isShared ? { memory, stop: core.stop } : null,
    });
  }

  /** Makes a call; throws the error of the scene, as data. */
  function call(name, args = {}, files = []) {
    const { ok, error, bytes } = core.call(name, args, files);
    if (error) throw { refused: error };
    return { ok, bytes };
  }

  async function render({ id, args, files, format, wantsAovs }) {
    const { ok: scene } = call("picture_begin", args, files);
    for (let done = false; !done;) {
      const { ok } = call("picture_step", { seconds: STEP });
      done = ok.done;
      host.post({ id, progress: { fraction: ok.progress, stage: done ? "finishing" : "rendering" } });
      await turn();
      if (cancelled === id) return void host.post({ id, cancelled: true });
    }
    const { ok: size, bytes } = call("picture_take", { format });
    const aovs = wantsAovs ? call("picture_aovs") : { ok: [], bytes: new Uint8Array() };
    const done = {
      width: size.width, height: size.height, data: bytes, warnings: scene.warnings,
      aovs: aovs.ok, layers: aovs.bytes ?? new Uint8Array(), memory: core.memory.buffer.byteLength,
    };
    host.post({ id, done }, [done.data.buffer, done.layers.buffer]);
  }

  /** Renders, and frees the picture's memory. A panic or the end of memory ends the session. */
  async function guarded(message) {
    try {
      await render(message);
    } catch (error) {
      if (!error?.refused) return end(fault || String(error?.message ?? error));
      host.post({ id: message.id, error: error.refused });
    }
    try {
      core?.call("picture_end");
    } catch (error) {
      end(fault || String(error?.message ?? error));
    }
  }

  return message => {
    if (message.start) start(message.start).catch(error => end(fault || String(error?.message ?? error)));
    else if (message.cancel) cancelled = message.cancel;
    else if (core) void guarded(message);
  };
}
