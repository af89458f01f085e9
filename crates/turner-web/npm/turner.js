// What is the same in Node and in browsers: sessions in workers, and pictures one after another.
import { requestOf } from "./request.js";

/**
 * What differs between Node and browsers.
 * @typedef {object} Host
 * @property {URL} wasm address of the module
 * @property {(wasm: URL | string) => Promise<WebAssembly.Module>} compile
 * @property {() => number} threads of the machine
 * @property {(onMessage: Function, onError: Function) => {post: Function, end: Function, hold: Function}} startSession
 */

/** Milliseconds that a session has to stop; then it is ended, and another one starts for the next picture. */
const GRACE = 100;

/** Why a picture failed: message, and where known help, code, file, line, column, end_column, excerpt. */
export class TurnerError extends Error {
  constructor(error) {
    super(error.message);
    this.name = "TurnerError";
    for (const [key, value] of Object.entries(error)) if (key !== "message" && value != null) this[key] = value;
  }
}

/** The values of one AOV from those of all. */
function split(list, bytes, pixels) {
  const out = {};
  let at = 0;
  for (const { name, channels, type } of list) {
    const Values = type === "uint32" ? Uint32Array : Float32Array;
    out[name] = { data: new Values(bytes.buffer, bytes.byteOffset + at, pixels * channels.length), channels };
    at += pixels * channels.length * 4;
  }
  return out;
}

/** The bytes of a picture as the type of its format. */
function typed(bytes, format) {
  if (format === "rgba") return new Uint8ClampedArray(bytes.buffer, bytes.byteOffset, bytes.length);
  if (format === "linear") return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  return bytes;
}

/** The classes of the package for a host. */
export function bind(host) {
  /** Modules by address: all sessions share them. */
  const modules = new Map();

  function compiled(wasm) {
    if (wasm instanceof WebAssembly.Module) return Promise.resolve(wasm);
    const key = String(wasm);
    let module = modules.get(key);
    if (!module) {
      module = host.compile(wasm);
      modules.set(key, module);
      module.catch(() => modules.delete(key));
    }
    return module;
  }

  class Turner {
    #options;
    /** The worker and what it told: a promise, so that pictures wait for it. */
    #session = null;
    /** Ends when the last picture that was asked for has ended. */
    #last = Promise.resolve();
    #next = 1;
    #isClosed = false;
    #threads = 0;
    #memory = 0;

    constructor(options = {}) {
      this.#options = options;
    }

    /** Threads of the session; 0 before the first picture. */
    get threads() {
      return this.#threads;
    }

    /** Bytes of the session's memory after the last picture. */
    get memory() {
      return this.#memory;
    }

    render(input, options = {}) {
      const { signal } = options;
      let request;
      try {
        signal?.throwIfAborted();
        request = requestOf(input, options);
      } catch (error) {
        return Promise.reject(error.plain ? new TurnerError(error.plain) : error);
      }
      return new Promise((resolve, reject) => {
        const job = { resolve, reject, request, options, aborted: false, stop: null };
        const abort = () => {
          job.aborted = true;
          reject(signal.reason);
          job.stop?.();
        };
        signal?.addEventListener("abort", abort, { once: true });
        const run = () => job.aborted ? undefined : this.#run(job).catch(reject);
        this.#last = this.#last.then(run).finally(() => signal?.removeEventListener("abort", abort));
      });
    }

    close() {
      this.#isClosed = true;
      this.#session?.then(session => session.close("it was closed"), () => {});
      this.#session = null;
    }

    [Symbol.dispose ?? Symbol.for("Symbol.dispose")]() {
      this.close();
    }

    /** The session that runs, or a new one. */
    #started() {
      const { wasm = host.wasm, threads } = this.#options;
      this.#session ??= compiled(wasm)
        .then(module => this.#start(module, threads || host.threads()))
        .catch(error => {
          this.#session = null;
          throw error instanceof TurnerError ? error : new TurnerError({ message: error.message });
        });
      return this.#session;
    }

    #start(module, threads) {
      return new Promise((resolve, reject) => {
        const session = { take: null, fail: reject, shared: null };
        const fail = message => {
          session.isOver = true;
          worker.end();
          this.#session = null;
          session.fail(new TurnerError({ message: `the renderer stopped: ${message}` }));
        };
        const worker = host.startSession(data => {
          if (data.fault !== undefined) return session.isOver ? undefined : fail(data.fault);
          if (!data.started) return session.take?.(data);
          session.shared = data.shared;
          this.#threads = data.threads;
          worker.hold(false);
          resolve(session);
        }, fail);
        session.worker = worker;
        session.close = fail;
        worker.hold(true);
        worker.post({ start: { module, threads } });
      });
    }

    /** Renders a picture; resolves when the session is free again. */
    async #run(job) {
      if (this.#isClosed) throw new TurnerError({ message: "this Turner is closed" });
      const { request, options } = job;
      options.onProgress?.({ fraction: 0, stage: "reading" });
      const session = await this.#started();
      if (job.aborted) return;
      const id = this.#next++;
      const { worker } = session;
      worker.hold(true);
      try {
        await new Promise(resolve => this.#exchange(session, job, id, resolve));
      } finally {
        session.take = null;
        session.fail = () => {};
        worker.hold(false);
      }
    }

    #exchange(session, job, id, free) {
      const { request, options } = job;
      const { worker, shared } = session;
      let late;
      session.fail = error => { clearTimeout(late); job.reject(error); free(); };
      session.take = data => {
        if (data.id !== id) return;
        if (data.progress) {
          if (!job.aborted) options.onProgress?.(data.progress);
          return;
        }
        clearTimeout(late);
        if (data.error) job.reject(new TurnerError(data.error));
        else if (data.done) job.resolve(this.#result(data.done, request.format));
        free();
      };
      job.stop = () => {
        if (shared) Atomics.store(new Uint8Array(shared.memory.buffer), shared.stop, 1);
        worker.post({ cancel: id });
        late = setTimeout(() => session.close("it was cancelled"), GRACE);
      };
      const transfer = request.files.map(file => file.bytes.buffer);
      worker.post({ id, ...request }, transfer);
    }

    #result({ width, height, data, warnings, aovs, layers, memory }, format) {
      this.#memory = memory;
      return { width, height, format, data: typed(data, format), aovs: split(aovs, layers, width * height), warnings };
    }
  }

  /** Sessions of `render`, by module and number of threads. */
  const kept = new Map();

  function render(input, options = {}) {
    const { wasm = host.wasm, threads = 0 } = options;
    const key = `${threads} ${wasm}`;
    if (!kept.has(key)) kept.set(key, new Turner({ wasm, threads }));
    return kept.get(key).render(input, options);
  }

  return { Turner, TurnerError, render };
}
