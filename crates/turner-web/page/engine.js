// The engine as the page sees it: calls that return promises, and events. The session runs in a worker (`startLocal`) or in
// `turner serve` (`connect`).

/** Why a call failed: message, and where known help, code, file, line, column, end_column, excerpt. */
export class EngineError extends Error {
  constructor(error) {
    super(error.message);
    this.name = "EngineError";
    // WebKit gives errors a line and a column of their own: those of the script.
    Object.assign(this, { line: undefined, column: undefined }, error);
  }
}

/** Calls that make the picture that is being rendered obsolete: they end the step that runs. */
const REPLACES = new Set(["open", "open_start", "set_text", "set", "undo", "redo", "gesture", "frame", "focus", "view"]);

/** @extends EventTarget events: frame, status, document, fault */
export class Engine extends EventTarget {
  #waiting = new Map();
  #next = 1;
  threads = 1;
  isolated = false;
  memory = 0;

  /** Makes a call of docs/reference/page.md. */
  async call(name, args = {}, files = undefined) {
    const sent = name === "open_start" && !files ? await this.filesOfStart(args.id) : files;
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#waiting.set(id, { resolve, reject });
      this.send({ id, name, args, files: sent ?? [] }, REPLACES.has(name));
    });
  }

  /** The files of a scene of the gallery that the core does not hold itself. */
  async filesOfStart() {
    return [];
  }

  /** Takes a message of the session. */
  take(data) {
    if (data.event) {
      this.dispatchEvent(new CustomEvent(data.event, { detail: data.detail }));
      return;
    }
    const waiting = this.#waiting.get(data.id);
    this.#waiting.delete(data.id);
    if (data.error) waiting?.reject(new EngineError(data.error));
    else waiting?.resolve(data.ok ?? {});
  }

  /** The session has ended: calls that wait have no answer. */
  fail(message, help = undefined) {
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { reject } of waiting) reject(new EngineError({ message: `the renderer stopped: ${message}` }));
    this.dispatchEvent(new CustomEvent("fault", { detail: { message, help } }));
  }

  close() {}
}

/** A session in a worker of the page. */
class LocalEngine extends Engine {
  #options;
  #worker;
  #shared = null;
  #queued = [];
  #isReady = false;
  #gallery;

  constructor(options) {
    super();
    this.#options = options;
  }

  /** Starts the worker; resolves when it runs. */
  start() {
    return new Promise((resolve, reject) => {
      const { threads, wasm = new URL("turner.wasm", import.meta.url).href } = this.#options;
      const worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
      this.#worker = worker;
      this.#isReady = false;
      worker.onerror = event => reject(new EngineError({ message: event.message || "the worker cannot be started" }));
      worker.onmessage = ({ data }) => {
        if (this.#worker !== worker) return;
        if (data.started) {
          ({ threads: this.threads, isolated: this.isolated, memory: this.memory, shared: this.#shared } = data);
          this.#isReady = true;
          for (const [message, transfer] of this.#queued.splice(0)) worker.postMessage(message, transfer);
          resolve(this);
        } else if (data.fault !== undefined) {
          worker.terminate();
          if (!this.#isReady) {
            reject(new EngineError({ message: data.fault }));
            return;
          }
          this.#shared = null;
          this.#isReady = false;
          // Calls that the page makes on hearing of the fault wait for the new worker.
          this.start().catch(error => this.fail(error.message));
          this.fail(data.fault);
        } else {
          this.take(data);
        }
      };
      worker.postMessage({ start: { wasm, threads } });
    });
  }

  send(message, replaces) {
    const transfer = message.files.map(file => file.bytes.buffer).filter((b, i, all) => all.indexOf(b) === i);
    if (!this.#isReady) {
      this.#queued.push([message, transfer]);
      return;
    }
    if (replaces && this.#shared) {
      Atomics.store(new Uint8Array(this.#shared.memory.buffer), this.#shared.stop, 1);
    }
    this.#worker.postMessage(message, transfer);
  }

  async filesOfStart(id) {
    this.#gallery ??= this.call("gallery");
    const { groups } = await this.#gallery;
    const start = groups.flatMap(group => group.entries).find(entry => entry.id === id);
    const base = new URL(this.#options.scenes ?? "scenes/", import.meta.url);
    return Promise.all((start?.files ?? []).map(async ({ name, path }) => {
      const response = await fetch(new URL(path, base));
      if (!response.ok) throw new EngineError({ message: `${path}: ${response.status} ${response.statusText}` });
      return { name, bytes: new Uint8Array(await response.arrayBuffer()) };
    }));
  }

  close() {
    this.#worker.terminate();
  }
}

/** Starts a session in a worker. Options: threads (all of the machine's), wasm (an address or a compiled module) and scenes
 * (an address). */
export function startLocal(options = {}) {
  return new LocalEngine(options).start();
}
