// The WebAssembly module of Turner: memory, threads and exports. `crates/turner-web/src/abi.rs` is the other side.

/** First size of the memory in pages of 64 KiB; the module is linked with it. */
const INITIAL_PAGES = 1024;

/** Largest sizes that are tried, in pages: 4, 2, 1 and 0.5 GiB. Phones refuse the larger ones. */
const MAXIMUM_PAGES = [65536, 32768, 16384, 8192];

/** Bytes of the stack of a thread. */
const STACK = 2 << 20;

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** Memory that threads share, and the most bytes that it may have. Where the page may not share it, one thread uses it. */
export function newMemory() {
  let refused;
  for (const maximum of MAXIMUM_PAGES) {
    try {
      const memory = new WebAssembly.Memory({ initial: INITIAL_PAGES, maximum, shared: true });
      return { memory, limit: maximum * 65536 };
    } catch (error) {
      refused = error;
    }
  }
  throw refused;
}

/** A text in shared memory: decoders do not read shared memory themselves. */
function textAt(memory, at, length) {
  return decoder.decode(new Uint8Array(memory.buffer, at >>> 0, length).slice());
}

/** What the module imports. `onFault` gets the message of a panic. */
function importsOf(memory, onFault) {
  const turner = {
    now: () => performance.timeOrigin + performance.now(),
    fault: (at, length) => onFault(textAt(memory, at, length)),
  };
  return { env: { memory }, turner };
}

/** An instance of the module on a memory. */
function instantiate(module, memory, onFault) {
  return new WebAssembly.Instance(module, importsOf(memory, onFault)).exports;
}

/** Makes an instance a thread of a program that runs on the same memory, and serves its tasks without end. */
export function runThread({ module, memory, stack, tls }, onFault) {
  const exports = instantiate(module, memory, onFault);
  exports.__stack_pointer.value = stack + STACK;
  exports.__wasm_init_tls(tls);
  exports.turner_serve();
}

/** A session in the calling thread. */
export class Core {
  /**
   * @param {WebAssembly.Module} module
   * @param {WebAssembly.Memory} memory
   * @param {(message: string) => void} onFault called before a call or a step throws
   */
  constructor(module, memory, onFault = () => {}, exports = instantiate(module, memory, onFault)) {
    this.module = module;
    this.memory = memory;
    this.exports = exports;
  }

  /** The same where modules of this size may not be instantiated at once: outside workers. */
  static async create(module, memory, onFault = () => {}) {
    const { exports } = await WebAssembly.instantiate(module, importsOf(memory, onFault));
    return new Core(module, memory, onFault, exports);
  }

  /** Begins the session, with at most `limit` bytes of memory. */
  begin(limit) {
    this.exports.turner_begin(limit);
  }

  /** What a thread needs to run on the same memory. */
  newThread() {
    const { turner_alloc: alloc, __tls_size: size } = this.exports;
    const [stack, tls] = [alloc(STACK), alloc(Math.max(16, size.value))];
    if (!stack || !tls) throw new Error("there is no memory for the stack of a thread");
    return { module: this.module, memory: this.memory, stack: stack >>> 0, tls: tls >>> 0 };
  }

  /** Threads that render. */
  get threads() {
    return this.exports.turner_threads();
  }

  /** Address of the byte that ends the step that runs. */
  get stop() {
    return this.exports.turner_stop() >>> 0;
  }

  /** Runs `use` with the address of a copy of bytes in the memory. */
  #lend(bytes, use) {
    const { turner_alloc: alloc, turner_free: free } = this.exports;
    const at = alloc(bytes.length) >>> 0;
    if (!at) throw new RangeError(`there is no memory for ${bytes.length} bytes`);
    try {
      new Uint8Array(this.memory.buffer, at, bytes.length).set(bytes);
      return use(at, bytes.length);
    } finally {
      free(at, bytes.length);
    }
  }

  /** Makes a call: {ok, bytes} or {error}. */
  call(name, args = {}, files = []) {
    for (const file of files) {
      this.#lend(encoder.encode(file.name), (name, length) =>
        this.#lend(file.bytes, (at, size) => this.exports.turner_put(name, length, at, size)));
    }
    const text = encoder.encode(JSON.stringify({ ...args, do: name }));
    this.#lend(text, (at, length) => this.exports.turner_call(at, length));
    const answer = this.#json();
    if (this.exports.turner_bytes_length()) answer.bytes = this.#bytes();
    this.exports.turner_forget();
    return answer;
  }

  /** Does the next piece of rendering; whether there is more to do. */
  step() {
    return this.exports.turner_step() === 1;
  }

  /** The events since the last time: {event, detail}; a frame's detail has `pixels`. */
  events() {
    const out = [];
    while (this.exports.turner_event() === 1) {
      const event = this.#json();
      if (event.event === "frame") event.detail.pixels = new Uint8ClampedArray(this.#bytes().buffer);
      out.push(event);
    }
    this.exports.turner_forget();
    return out;
  }

  #json() {
    return JSON.parse(textAt(this.memory, this.exports.turner_json(), this.exports.turner_json_length()));
  }

  #bytes() {
    const at = this.exports.turner_bytes() >>> 0;
    return new Uint8Array(this.memory.buffer, at, this.exports.turner_bytes_length()).slice();
  }
}
