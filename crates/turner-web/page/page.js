// The page: starts the engine, opens scenes, and joins the parts of the page. See `turner-web/README.md`.

import { announce, find } from "./dom.js";
import { clear, fail, tell } from "./message.js";
import { Editor } from "./editor.js";
import { setupChecks } from "./checks.js";
import { setupExplain } from "./explain.js";
import { setupFiles } from "./files.js";
import { setupLinks } from "./links.js";
import { setupParts } from "./parts.js";
import { setupStart } from "./start.js";
import { setupStatus } from "./status.js";
import { setupTabs } from "./tabs.js";
import { setupTools } from "./tools.js";
import { setupViewport } from "./viewport.js";
import { isolate } from "./isolate.js";

/** Events of the engine that the parts of the page listen to, on the page itself: engines may come later. */
const EVENTS = ["frame", "status", "document", "fault"];

class Page extends EventTarget {
  engine = null;
  /** The last event `document`: what is open. */
  document = null;
  /** The address of what is open. */
  shown = "";
  /** "start" or "scene". */
  state = "start";
  /** What was opened: {start: id} of the gallery or the tutorial, {files: names that its text may read}, {link: true}. */
  origin = {};
  #opening = 0;
  #documents = 0;

  on(event, act) {
    this.addEventListener(event, e => act(e.detail));
  }

  emit(event, detail) {
    this.dispatchEvent(new CustomEvent(event, { detail }));
  }

  /** Calls the engine once it runs. */
  async call(name, args, files) {
    const engine = await this.ready;
    return engine.call(name, args, files);
  }

  /** Calls the engine; an error becomes a message. `undefined` after an error. */
  async attempt(name, args, title) {
    try {
      return await this.call(name, args);
    } catch (error) {
      fail(error, title);
      return undefined;
    }
  }

  /** Opens a scene. `actions(error)` are buttons of the message after an error. Returns whether it is open now; an error leaves what is shown as it is. */
  async open(what, origin, act, actions = () => []) {
    const turn = ++this.#opening;
    clear();
    document.body.classList.add("busy");
    announce(`Opening ${what}`);
    this.emit("opening", { what });
    const documents = this.#documents;
    try {
      await act();
      if (documents === this.#documents) await this.next("document");
      if (turn !== this.#opening) return false;
      // The text of the gallery: a scene with it needs no text in its link.
      this.origin = { ...origin, text: origin.edited ? null : this.document?.text };
      this.emit("opened", origin);
      this.show("scene");
      return true;
    } catch (error) {
      if (turn === this.#opening) fail(error, `Cannot open ${what}`, actions(error));
      return false;
    } finally {
      if (turn === this.#opening) document.body.classList.remove("busy");
      this.emit("opening", { what: null });
    }
  }

  /** Waits for an event, at most two seconds. */
  next(event) {
    return new Promise(resolve => {
      this.addEventListener(event, resolve, { once: true });
      setTimeout(resolve, 2000);
    });
  }

  /** An event of the engine. */
  receive(name, detail) {
    if (name === "document") {
      this.#documents++;
      this.document = detail;
      find("scene-name").textContent = detail.name || "";
      find("scene-title").textContent = detail.name || "Scene";
      if (this.state === "scene") document.title = `${detail.changed ? "• " : ""}${detail.name} – Turner`;
    }
    this.emit(name, detail);
  }

  /** Shows the start page or the scene. */
  show(state) {
    if (state === "scene" && !this.document) state = "start";
    const changed = state !== this.state;
    this.state = state;
    document.body.dataset.state = state;
    find("start").hidden = state !== "start";
    find("scene").hidden = state !== "scene";
    document.title = state === "scene" ? `${this.document.name} – Turner` : "Turner";
    this.emit("shown", state);
    if (!changed) return;
    scrollTo(0, 0);
    if (state === "scene") find("canvas").focus({ preventScroll: true });
    else find("main").focus({ preventScroll: true });
  }
}

const page = new Page();
/** "owner" or "viewer" where `turner serve` serves the page: it renders there. */
const served = document.querySelector('meta[name="turner-serve"]')?.content;
/** Whether the page changes nothing: it shows what the owner of the server does. */
page.looksOn = served === "viewer";
if (page.looksOn) {
  document.body.classList.add("looks-on");
  find("hint").textContent = "The owner of the server moves the camera · click: select";
  find("canvas-keys").textContent = "The owner of the server changes the scene. C shows a crosshair that the arrow keys move; Enter selects below it, E explains the pixel, Escape hides it.";
}
page.ready = served ? connectEngine() : isolate().then(startEngine);
page.ready.then(engine => page.emit("ready", engine), error => {
  find("loading").hidden = true;
  const help = "Use a browser of 2023 or later that allows WebAssembly, and load the page again.";
  fail(error.help ? error : Object.assign(new Error(error.message || String(error)), { help }), "The renderer does not start");
});

async function startEngine(how) {
  // The page is about to be loaded again, with threads.
  if (how === "reload") await new Promise(() => {});
  const { startLocal } = await import("./engine.js");
  return listen(await startLocal());
}

async function connectEngine() {
  const { connect } = await import("./remote.js");
  return listen(await connect(new URL("socket", location.href.replace(/^http/, "ws"))));
}

function listen(engine) {
  for (const name of EVENTS) engine.addEventListener(name, event => page.receive(name, event.detail));
  page.engine = engine;
  return engine;
}

page.on("fault", ({ message, help }) => {
  const text = page.editor.text;
  const error = { message, help: help || "The renderer has started again. Your text is kept: make the scene smaller, or undo the last change." };
  const again = ["Render the text again", () => page.open("the text", page.origin, () => page.call("set_text", { text }))];
  fail(error, "The renderer stopped", text ? [again] : []);
});

// Whoever looks on sees what the owner opens.
if (page.looksOn) page.on("document", () => page.show("scene"));

page.editor = new Editor(page);
setupTabs(page);
setupViewport(page);
setupStatus(page);
setupTools(page);
setupParts(page);
setupExplain(page);
setupChecks(page);
setupFiles(page);
setupStart(page);
setupLinks(page);

addEventListener("unhandledrejection", event => {
  event.preventDefault();
  fail(event.reason instanceof Error ? event.reason : new Error(String(event.reason)));
});
page.tell = tell;
