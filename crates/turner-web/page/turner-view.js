// <turner-view src="model.glb">: a ray-traced model in a page. See docs/guides/web-pages.md.
import { startLocal } from "./engine.js";
import { ViewCamera, framed, listen, parseFov, parseOrbit } from "./view-camera.js";
import { filesOf } from "./view-files.js";

/** Most pixels of a side of the film, and most threads of a view. */
const MAX_SIDE = 2048;
const MAX_THREADS = 4;

/** Samples per pixel without the attribute. */
const SAMPLES = 16;

/** Milliseconds after the last change of size until the film has it. */
const SETTLES = 200;

const STYLE = `
  :host { display: block; position: relative; width: 300px; height: 300px; contain: strict; overflow: hidden; }
  :host([hidden]) { display: none; }
  canvas, img, p { position: absolute; inset: 0; width: 100%; height: 100%; }
  canvas, img { object-fit: contain; }
  canvas { outline-offset: -2px; }
  canvas[tabindex] { cursor: grab; touch-action: pan-y; }
  canvas[tabindex]:active { cursor: grabbing; }
  img { pointer-events: none; transition: opacity .3s; }
  img.gone { opacity: 0; }
  p { box-sizing: border-box; margin: 0; padding: 1em; display: grid; place-content: center; text-align: center;
      font: 14px/1.4 system-ui, sans-serif; color: #222; background: #f4f4f4; overflow-wrap: anywhere; }
  [hidden] { display: none !important; }
  @media (prefers-reduced-motion: reduce) { img { transition: none; } }
`;
const sheet = new CSSStyleSheet();
sheet.replaceSync(STYLE);

/** The compiled module, which all views share. */
let module = null;

function compiled() {
  module ??= WebAssembly.compileStreaming(fetch(TurnerView.wasm))
    .catch(async () => WebAssembly.compile(await (await fetch(TurnerView.wasm)).arrayBuffer()))
    .catch(error => {
      module = null;
      throw error;
    });
  return module;
}

/** A promise with its ends. */
function deferred() {
  const out = {};
  out.promise = new Promise((resolve, reject) => Object.assign(out, { resolve, reject }));
  // Nobody needs to wait for it.
  out.promise.catch(() => {});
  return out;
}

export class TurnerView extends HTMLElement {
  /** The module's address. */
  static wasm = new URL("turner.wasm", import.meta.url).href;

  static observedAttributes = [
    "src", "alt", "poster", "camera-orbit", "camera-controls", "field-of-view", "environment", "exposure", "samples",
  ];

  #canvas = document.createElement("canvas");
  #poster = document.createElement("img");
  #message = document.createElement("p");
  #engine = null;
  /** The camera, once it is taken over from the studio. */
  #camera = null;
  #environment = undefined;
  #load = null;
  #settled = deferred();
  #first = deferred();
  #isVisible = false;
  #isRevealed = false;
  #size = [0, 0];
  #late = 0;
  #faults = 0;
  #watch = new IntersectionObserver(entries => this.#seen(entries.at(-1).isIntersecting));
  #measure = new ResizeObserver(() => this.#resize());

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = [sheet];
    this.#message.setAttribute("role", "alert");
    this.#message.hidden = this.#poster.hidden = true;
    this.#poster.alt = "";
    root.append(this.#canvas, this.#poster, this.#message);
    listen(this.#canvas, (...by) => this.#move(...by), soon => this.#ended(soon));
  }

  /** Whether the model is read. */
  loaded = false;

  /** Resolves when the picture has all its samples; rejects when there is none. Every change begins a new one. */
  get settled() {
    return this.#settled.promise;
  }

  get src() {
    return this.getAttribute("src");
  }

  set src(src) {
    this.setAttribute("src", src);
  }

  connectedCallback() {
    this.#describe();
    this.#watch.observe(this);
    this.#measure.observe(this);
    if (this.getAttribute("loading") === "eager") this.#begin();
  }

  disconnectedCallback() {
    this.#watch.disconnect();
    this.#measure.disconnect();
    clearTimeout(this.#late);
    this.#stop();
  }

  attributeChangedCallback(name, before, after) {
    if (before === after || !this.isConnected) return;
    this.#describe();
    if (name === "src" || name === "environment") {
      this.#stop();
      if (this.#isVisible || this.getAttribute("loading") === "eager") this.#begin();
    } else if (this.loaded) {
      this.#change(name).catch(error => this.#fail(error));
    }
  }

  /** The picture with all its samples as a file. mimeType: image/png, image/jpeg or image/webp. */
  async toBlob({ mimeType = "image/png" } = {}) {
    await this.settled;
    const format = { "image/png": "png", "image/jpeg": "jpg", "image/webp": "webp" }[mimeType];
    if (!format) throw new TypeError(`there are no pictures of type ${mimeType}`);
    const { bytes } = await this.#engine.call("save", { format });
    return new Blob([bytes], { type: mimeType });
  }

  /** The shown picture as a data: URL. */
  toDataURL(type = "image/png", quality = undefined) {
    return this.#canvas.toDataURL(type, quality);
  }

  /** The orbit: theta and phi in radians, radius in units of the scene, null while the studio frames the model. */
  getCameraOrbit() {
    const { theta, phi, radius = null } = this.#camera ?? { ...parseOrbit(this.getAttribute("camera-orbit")), radius: null };
    return { theta, phi, radius, toString: () => `${theta}rad ${phi}rad ${radius === null ? "auto" : `${radius}m`}` };
  }

  /** Takes the poster away, with reveal="manual". */
  dismissPoster() {
    this.#isRevealed = true;
    this.#unveil();
  }

  #tell(name, detail = {}) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }

  /** What the attributes say without the engine. */
  #describe() {
    const canvas = this.#canvas;
    const moves = this.hasAttribute("camera-controls");
    canvas.setAttribute("role", moves ? "application" : "img");
    canvas.setAttribute("aria-label", this.getAttribute("alt") ?? "");
    if (moves) {
      canvas.tabIndex = 0;
      canvas.setAttribute("aria-roledescription", "3D model");
      canvas.setAttribute("aria-keyshortcuts", "ArrowLeft ArrowRight ArrowUp ArrowDown + -");
    } else {
      for (const name of ["tabindex", "aria-roledescription", "aria-keyshortcuts"]) canvas.removeAttribute(name);
    }
    const poster = this.getAttribute("poster");
    if (poster && this.#poster.getAttribute("src") !== poster) {
      this.#poster.src = poster;
      this.#poster.hidden = false;
    }
  }

  #seen(isVisible) {
    this.#isVisible = isVisible;
    if (isVisible && !this.#load) this.#begin();
    // Before that, `#open` says it.
    else if (this.loaded) this.#engine.call("view", { paused: !isVisible }).catch(() => {});
  }

  #stop() {
    this.#load?.abort();
    this.#engine?.close();
    this.#settled.reject(new DOMException("the view has another model", "AbortError"));
    [this.#engine, this.#camera, this.#load, this.loaded] = [null, null, null, false];
    this.#settled = deferred();
    this.#first = deferred();
    this.#message.hidden = true;
  }

  #begin() {
    const src = this.getAttribute("src");
    if (!src) return;
    const load = this.#load = new AbortController();
    this.#open(new URL(src, document.baseURI).href, load.signal)
      .catch(error => load.signal.aborted ? undefined : this.#fail(error));
  }

  async #open(src, signal) {
    const environment = this.getAttribute("environment");
    const map = environment && environment !== "studio" ? new URL(environment, document.baseURI).href : undefined;
    const progress = fraction => this.#tell("progress", { totalProgress: 0.5 * fraction, reason: "load" });
    const threads = Math.min(navigator.hardwareConcurrency || 1, MAX_THREADS);
    const [files, engine] = await Promise.all([
      filesOf(src, map, signal, progress),
      compiled().then(wasm => startLocal({ wasm, threads })),
    ]);
    if (signal.aborted) return engine.close();
    this.#engine = engine;
    this.#environment = files.environment;
    engine.addEventListener("frame", ({ detail }) => this.#show(detail));
    engine.addEventListener("status", ({ detail }) => this.#status(detail));
    engine.addEventListener("fault", ({ detail }) => this.#fault(detail.message));
    await engine.call("view", { paused: true });
    await engine.call("open", { main: files.main }, files.files);
    await this.#set(this.#edits());
    const isSeen = this.#isVisible;
    await engine.call("view", { width: this.#size[0], height: this.#size[1], paused: !isSeen });
    if (signal.aborted) return;
    this.loaded = true;
    if (this.#isVisible !== isSeen) this.#seen(this.#isVisible);
    this.#tell("load", { url: src });
    const orbit = parseOrbit(this.getAttribute("camera-orbit"));
    if (this.hasAttribute("camera-controls") || orbit.unit !== "%" || orbit.radius !== 105) await this.#take(orbit);
  }

  /** Everything that the attributes change of the scene. */
  #edits() {
    const edits = [...this.#filmEdits(), ["studio.camera", framed(parseOrbit(this.getAttribute("camera-orbit")))]];
    const fov = parseFov(this.getAttribute("field-of-view"));
    if (fov) edits.push(["studio.fov", fov]);
    if (this.#environment) edits.push(["light", [{ type: "environment", file: this.#environment }]]);
    return edits;
  }

  #filmEdits() {
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [this.clientWidth || 300, this.clientHeight || 300].map(side => side * scale);
    const fit = Math.min(1, MAX_SIDE / Math.max(width, height));
    this.#size = [width, height].map(side => Math.max(1, Math.round(side * fit)));
    const samples = Number.parseInt(this.getAttribute("samples") ?? "", 10);
    const exposure = Number.parseFloat(this.getAttribute("exposure") ?? "");
    return [
      ["film.width", this.#size[0]], ["film.height", this.#size[1]],
      ["film.samples", samples > 0 ? samples : SAMPLES],
      ["film.exposure", exposure > 0 ? Math.log2(exposure) : 0],
    ];
  }

  #set(edits) {
    this.#unsettle();
    return this.#engine.call("set", { edits, label: "View", merge: "view" });
  }

  /** The picture begins anew. */
  #unsettle() {
    if (this.#settled.isDone) this.#settled = deferred();
  }

  async #change(name) {
    if (name === "camera-orbit") {
      const orbit = parseOrbit(this.getAttribute(name));
      this.#unsettle();
      await this.#take(null);
      await this.#camera.to(orbit);
      this.#tell("camera-change", { source: "none" });
    } else if (name === "camera-controls") {
      if (this.hasAttribute(name)) await this.#take(null);
    } else if (name === "field-of-view") {
      const fov = parseFov(this.getAttribute(name)) ?? 28;
      await this.#set(this.#camera ? [["camera.fov", fov]] : [["studio.fov", fov]]);
    } else if (name === "exposure" || name === "samples") {
      await this.#set(this.#filmEdits());
    }
  }

  /** Takes the camera over once there is a picture, and moves it to the orbit. */
  async #take(orbit) {
    if (!this.#camera) {
      const engine = this.#engine;
      await this.#first.promise;
      const camera = new ViewCamera(engine, parseOrbit(this.getAttribute("camera-orbit")));
      await camera.take(this.#environment !== undefined);
      if (engine !== this.#engine) return;
      this.#camera = camera;
    }
    if (orbit) await this.#camera.to(orbit);
  }

  #move(theta, phi, factor) {
    if (!this.#camera || !this.hasAttribute("camera-controls")) return;
    if (!this.#camera.by(theta, phi, factor)) return;
    this.#unsettle();
    this.#tell("camera-change", { source: "user-interaction" });
  }

  #ended(soon) {
    if (soon) this.#camera?.endSoon();
    else this.#camera?.end();
  }

  #resize() {
    clearTimeout(this.#late);
    this.#late = setTimeout(() => {
      const before = `${this.#size}`;
      const edits = this.#filmEdits();
      if (!this.loaded || `${this.#size}` === before) return;
      this.#set(edits).catch(error => this.#fail(error));
    }, SETTLES);
  }

  #show({ width, height, pixels, stage }) {
    const canvas = this.#canvas;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    canvas.getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
    this.#first.resolve();
    this.#unveil();
    // Before that, the picture lacks what the attributes say.
    if (stage !== "settled" || !this.loaded) return;
    this.#settled.isDone = true;
    this.#settled.resolve(this);
    this.#tell("settled");
  }

  #unveil() {
    const isReady = this.#canvas.width !== 300 || this.loaded;
    if (isReady && (this.#isRevealed || this.getAttribute("reveal") !== "manual")) this.#poster.classList.add("gone");
  }

  #status({ samples, total, error }) {
    if (error) this.#fail(error);
    else if (total) this.#tell("progress", { totalProgress: 0.5 + 0.5 * samples / total, reason: "render" });
  }

  /** The renderer has stopped, and the engine has started another one: once, the model is read again. */
  #fault(message) {
    const src = this.getAttribute("src");
    this.#stop();
    if (this.#faults++ === 0 && src) this.#begin();
    else this.#fail(new Error(message));
  }

  #fail(error) {
    const text = error.help ? `${error.message}\n${error.help}` : error.message;
    this.#message.textContent = text;
    this.#message.hidden = false;
    this.#settled.isDone = true;
    this.#settled.reject(error);
    this.#tell("error", { type: this.loaded ? "render" : "load", message: error.message, help: error.help });
  }
}

customElements.define("turner-view", TurnerView);
