// The engine behind `turner serve`: calls and events over a WebSocket, pictures as changed tiles. The messages are described
// in `crates/turner-serve/src/socket.rs` and `tiles.rs`.
import { Engine, EngineError } from "./engine.js";

/** Bytes of a part of a file. */
const PART = 1 << 20;

/** Bytes that may wait in the socket while files are sent. */
const AHEAD = 8 << 20;

/** Waits before a lost connection is tried again, milliseconds. */
const WAITS = [500, 1000, 2000, 5000];

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** A session of `turner serve`. */
class RemoteEngine extends Engine {
  #url;
  #socket = null;
  #isClosed = false;
  #tries = 0;
  /** Messages are sent in order, also while files wait for the network. */
  #sending = Promise.resolve();
  /** Pictures are drawn in order. */
  #drawing = Promise.resolve();
  #picture = { width: 0, height: 0, pixels: new Uint8ClampedArray() };
  /** The last events of each kind, for listeners that come later. */
  #last = new Map();
  /** "owner", or "viewer", who changes nothing. */
  role = "owner";
  isolated = true;

  constructor(url) {
    super();
    this.#url = url;
  }

  /** Connects; resolves when the session answers. */
  start() {
    return new Promise((resolve, reject) => {
      const socket = new WebSocket(this.#url);
      this.#socket = socket;
      socket.binaryType = "arraybuffer";
      let isStarted = false;
      socket.onmessage = ({ data }) => {
        if (this.#socket !== socket) return;
        if (typeof data !== "string") {
          this.#receive(socket, data);
          return;
        }
        const message = JSON.parse(data);
        if (!message.started) {
          this.take(message);
          return;
        }
        ({ threads: this.threads, isolated: this.isolated, memory: this.memory, role: this.role } = message);
        isStarted = true;
        this.#tries = 0;
        resolve(this);
      };
      socket.onclose = ({ reason }) => {
        if (this.#socket !== socket) return;
        this.#socket = null;
        this.#picture = { width: 0, height: 0, pixels: new Uint8ClampedArray() };
        if (this.#isClosed) return;
        if (!isStarted) {
          reject(new EngineError({ message: reason || "the server does not answer", help: "Check that turner serve runs, and use the address that it printed." }));
          return;
        }
        this.fail(reason || "the connection to the server was lost", "The page connects again as soon as the server answers.");
        this.#again();
      };
    });
  }

  /** Connects again, after a while. */
  #again() {
    const wait = WAITS[Math.min(this.#tries++, WAITS.length - 1)];
    setTimeout(() => {
      if (!this.#isClosed) this.start().catch(() => this.#again());
    }, wait);
  }

  addEventListener(name, listener, options) {
    super.addEventListener(name, listener, options);
    const detail = this.#last.get(name);
    if (detail) queueMicrotask(() => listener.call(this, new CustomEvent(name, { detail })));
  }

  take(data) {
    if (data.event === "document" || data.event === "status") this.#last.set(data.event, data.detail);
    if (data.event === "fault") {
      this.fail(data.detail.message);
      return;
    }
    super.take(data);
  }

  send({ id, name, args, files }) {
    const socket = this.#socket;
    if (socket?.readyState !== WebSocket.OPEN) {
      this.take({ id, error: { message: "there is no connection to the server" } });
      return;
    }
    this.#sending = this.#sending.then(async () => {
      for (const file of files) {
        for (let at = 0; at === 0 || at < file.bytes.length; at += PART) {
          while (socket.bufferedAmount > AHEAD) await new Promise(resolve => setTimeout(resolve, 10));
          if (socket.readyState !== WebSocket.OPEN) return;
          socket.send(part(id, file.name, file.bytes.subarray(at, at + PART)));
        }
      }
      socket.send(JSON.stringify({ id, name, args }));
    });
  }

  /** A binary message. */
  #receive(socket, buffer) {
    const view = new DataView(buffer);
    if (view.getUint8(0) === 2) {
      const end = 8 + view.getUint32(4, true);
      const message = JSON.parse(decoder.decode(new Uint8Array(buffer, 8, end - 8)));
      message.ok.bytes = new Uint8Array(buffer.slice(end));
      this.take(message);
      return;
    }
    this.#drawing = this.#drawing.then(async () => {
      if (this.#socket !== socket) return;
      const { number, detail } = await this.#draw(buffer, view);
      if (this.#socket !== socket) return;
      socket.send(JSON.stringify({ seen: number }));
      super.take({ event: "frame", detail: { ...detail, pixels: this.#picture.pixels } });
    });
  }

  /** Puts the tiles of a message into the picture. */
  async #draw(buffer, view) {
    const flags = view.getUint8(1);
    const [number, width, height, count, length] = [4, 8, 12, 16, 20].map(at => view.getUint32(at, true));
    if (this.#picture.width !== width || this.#picture.height !== height) {
      this.#picture = { width, height, pixels: new Uint8ClampedArray(4 * width * height) };
    }
    const texts = 24 + 8 * count;
    const detail = JSON.parse(decoder.decode(new Uint8Array(buffer, texts, length)));
    let bytes = new Uint8Array(buffer, texts + length);
    const isPacked = (flags & 2) !== 0;
    if (isPacked) bytes = await inflate(bytes);
    const { pixels } = this.#picture;
    let from = 0;
    for (let i = 0; i < count; i++) {
      const [x, y, w, h] = [0, 2, 4, 6].map(at => view.getUint16(24 + 8 * i + at, true));
      for (let row = y; row < y + h; row++) {
        from = putRow(pixels, 4 * (row * width + x), bytes, from, w, flags);
      }
    }
    return { number, detail };
  }

  close() {
    this.#isClosed = true;
    this.#socket?.close();
  }
}

/** Puts a row of pixels from `from` to `to`; where the next row begins. Flags: 1 RGBA, 2 differences. */
function putRow(pixels, to, bytes, from, count, flags) {
  const hasAlpha = (flags & 1) !== 0;
  let [r, g, b, a] = [0, 0, 0, hasAlpha ? 0 : 255];
  const keep = (flags & 2) !== 0 ? 255 : 0;
  for (const end = to + 4 * count; to < end; to += 4) {
    r = (r & keep) + bytes[from++] & 255;
    g = (g & keep) + bytes[from++] & 255;
    b = (b & keep) + bytes[from++] & 255;
    if (hasAlpha) a = (a & keep) + bytes[from++] & 255;
    pixels[to] = r;
    pixels[to + 1] = g;
    pixels[to + 2] = b;
    pixels[to + 3] = a;
  }
  return from;
}

/** Bytes of the zlib format. */
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A message with a part of a file. */
function part(id, name, bytes) {
  const text = encoder.encode(name);
  const message = new Uint8Array(12 + text.length + bytes.length);
  const view = new DataView(message.buffer);
  view.setUint8(0, 3);
  view.setUint32(4, id, true);
  view.setUint32(8, text.length, true);
  message.set(text, 12);
  message.set(bytes, 12 + text.length);
  return message;
}

/** Connects to the socket of `turner serve`. */
export function connect(url) {
  return new RemoteEngine(url).start();
}
