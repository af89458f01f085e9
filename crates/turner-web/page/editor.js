// The text of the scene: a textarea, with colours and underlines painted behind it. What is typed is checked, and
// rendered if it has no error.

import { announce, find, later, make, sentence, words } from "./dom.js";
import { Completion } from "./completion.js";
import { setupHover } from "./hover.js";
import { offset, paint, place, scan } from "./highlight.js";
import { keep, merge } from "./merge.js";

/** Milliseconds after the last key. */
const REST = 250;
/** Problems listed; a broken text can have thousands. */
const MOST = 100;
/** Lines that are painted above and below those in sight. */
const MORE = 12;

export class Editor {
  #page;
  #area = find("text");
  #paint = find("editor").querySelector(".paint");
  #gutter = find("editor").querySelector(".gutter");
  #list = find("problems");
  #problems = [];
  #turn = 0;
  /** The text of the scene that the engine has. */
  #known = "";
  #scanned = null;
  #lines = scan("");
  #marks = [];
  #rest = later(REST, () => this.#check());

  constructor(page) {
    this.#page = page;
    this.completion = new Completion(page, this.#area, () => this.#changed());
    setupHover(page, this.#area, this.#paint);
    this.#area.addEventListener("input", () => this.#changed());
    this.#area.addEventListener("scroll", () => this.#follow());
    this.#area.addEventListener("keydown", event => {
      if (event.key !== "F8") return;
      event.preventDefault();
      this.#next(event.shiftKey ? -1 : 1);
    });
    // The list of errors takes room from the text.
    new ResizeObserver(() => {
      if (this.#area === document.activeElement) this.#reveal(this.#area.selectionStart);
      this.#render();
      this.completion.follow();
    }).observe(this.#area);
    page.on("document", document => this.#take(document));
    page.on("opened", () => { this.#turn++; this.#rest.cancel(); this.#show(this.#page.document); });
  }

  get text() {
    return this.#area.value;
  }

  /** Whether the text has changes that are not part of the scene yet. */
  get waiting() {
    return !this.#area.readOnly && this.#area.value !== this.#known;
  }

  /** Waits until what was typed is rendered or found wrong. */
  async flush() {
    this.#rest.cancel();
    if (this.waiting) await this.#check();
    // The engine tells the new scene after its answer.
    if (!this.waiting && this.#page.document?.text !== this.text) await this.#page.next("document");
  }

  #changed() {
    this.#page.emit("typed");
    this.#problems = this.#problems.filter(problem => problem.severity === "error").map(problem => ({ ...problem, stale: true }));
    this.#render();
    this.#rest();
  }

  async #check() {
    const turn = ++this.#turn;
    const text = this.#area.value;
    if (text === this.#known) {
      this.#report([], this.#page.document?.warnings || []);
      return;
    }
    try {
      const { errors, warnings } = await this.#page.call("check", { text });
      if (turn !== this.#turn) return;
      this.#report(errors, warnings || []);
      if (errors.length) return;
      await this.#page.call("set_text", { text });
      if (turn === this.#turn) this.#known = text;
    } catch (error) {
      if (turn === this.#turn) this.#report([error], []);
    }
  }

  /** The scene has changed: by a gesture, in the properties, by undo, or by what was typed here. */
  #take(document) {
    this.#large(document);
    if (document.text === null || document.text === this.#area.value) {
      this.#known = document.text ?? "";
      if (document.text !== null) this.#report([], document.warnings || []);
      return;
    }
    if (this.waiting) {
      this.#join(document.text);
      return;
    }
    this.#turn++;
    this.#show(document);
  }

  /** The text of a scene with large files takes seconds to write: it is shown when it is asked for. */
  #large({ text_is_asked, revision }) {
    const line = find("large");
    line.hidden = !text_is_asked;
    if (!text_is_asked) return;
    const show = make("button", { type: "button", text: "Show the text", on: { click: async () => {
      const answer = await this.#page.attempt("text", {});
      const { document } = this.#page;
      if (answer && document.revision === revision) this.#take({ ...document, text: answer.text, text_is_asked: false });
    } } });
    line.replaceChildren("This scene is large: writing its text takes a moment. ", show);
  }

  /**
   * The scene changes while the text has changes of its own: both are kept where they do not touch the same place;
   * otherwise what was typed wins, and replaces the scene once it has no error.
   */
  #join(text) {
    const joined = merge(this.#known, this.#area.value, text);
    this.#known = text;
    if (joined === null || joined === this.#area.value) return;
    this.#put(joined);
    this.#changed();
  }

  /** Forgets what was typed and is not part of the scene. */
  discard() {
    this.#turn++;
    this.#rest.cancel();
    this.#show(this.#page.document);
  }

  /** Replaces the text; the selection stays where it was. */
  #put(text) {
    const area = this.#area;
    const { selectionStart, selectionEnd, scrollTop, scrollLeft } = area;
    const kept = keep(area.value, text, selectionStart, selectionEnd);
    area.value = text;
    area.setSelectionRange(...kept);
    area.scrollTop = scrollTop;
    area.scrollLeft = scrollLeft;
  }

  #show(document) {
    if (!document) return;
    const has = document.text !== null;
    const area = this.#area;
    const text = has ? document.text : "";
    this.#known = text;
    area.readOnly = !has || this.#page.looksOn;
    find("editor").classList.toggle("none", !has);
    area.placeholder = has ? "" : "The text is not shown. The panel Scene changes the scene, too.";
    if (area.value !== text) this.#put(text);
    this.completion.close();
    this.#report([], document.warnings || []);
  }

  #report(errors, warnings) {
    const text = this.#area.value;
    const problem = severity => found => {
      const line = found.line || 0;
      const start = line ? offset(text, line, found.column) : 0;
      let end = line && found.end_column > found.column ? offset(text, line, found.end_column) : start;
      if (line && end === start) end = wordEnd(text, start);
      return { severity, message: found.message, help: found.help, line, start, end };
    };
    const own = warnings.filter(warning => warning.line && !/\.(glb|gltf|obj|ply|stl|mtl)$/i.test(warning.file || ""));
    this.#problems = [...errors.slice(0, MOST).map(problem("error")), ...own.slice(0, MOST).map(problem("warning"))];
    this.#area.setAttribute("aria-invalid", String(errors.length > 0));
    this.#render();
    this.#items();
  }

  #items() {
    const items = this.#problems.map(problem => make("li", { class: problem.severity },
      make("button", { type: "button", on: { click: () => this.#jump(problem) } },
        make("b", { text: problem.line ? `Line ${problem.line}` : "Text" }),
        make("span", {}, ...words(sentence(problem.message))),
        problem.help ? make("span", { class: "remedy" }, ...words(sentence(problem.help))) : null)));
    this.#list.replaceChildren(...items);
    this.#page.countPanel?.("text", this.#problems.filter(problem => problem.severity === "error").length);
  }

  #jump({ start, end, message }) {
    this.#area.focus();
    this.#area.setSelectionRange(start, end);
    this.#reveal(start);
    announce(message);
  }

  #next(step) {
    const all = this.#problems;
    if (!all.length) {
      announce("No errors");
      return;
    }
    const at = this.#area.selectionStart;
    const after = step > 0 ? all.find(problem => problem.start > at) : [...all].reverse().find(problem => problem.start < at);
    this.#jump(after || (step > 0 ? all[0] : all[all.length - 1]));
  }

  /** Scrolls until the line of an offset is visible. */
  #reveal(at) {
    const height = parseFloat(getComputedStyle(this.#area).lineHeight);
    const top = (place(this.text, at).line - 1) * height;
    const { scrollTop, clientHeight } = this.#area;
    if (top < scrollTop) this.#area.scrollTop = Math.max(0, top - clientHeight / 3);
    else if (top > scrollTop + clientHeight - 2.5 * height) this.#area.scrollTop = top - clientHeight + 4 * height;
  }

  #render() {
    const text = this.#area.value;
    if (text !== this.#scanned) {
      this.#scanned = text;
      this.#lines = scan(text);
      this.#gutter.style.minWidth = `calc(${Math.max(2, String(this.#lines.length).length)}ch + 18px)`;
    }
    this.#marks = this.#problems.filter(problem => problem.line && !problem.stale)
      .map(({ start, end, severity }) => ({ start, end, kind: severity }));
    this.#follow();
  }

  /** Paints the lines in sight and their numbers behind the textarea. */
  #follow() {
    const { scrollTop, scrollLeft, clientHeight } = this.#area;
    const lines = this.#lines;
    const height = parseFloat(getComputedStyle(this.#area).lineHeight) || 20;
    const first = Math.min(lines.length - 1, Math.max(0, Math.floor(scrollTop / height) - MORE));
    const last = Math.min(lines.length, Math.ceil((scrollTop + clientHeight) / height) + MORE);
    const stop = last < lines.length ? lines[last].start - 1 : this.#scanned.length;
    paint(this.#paint, this.#scanned, lines[first], stop, this.#marks);
    const top = first * height - scrollTop;
    this.#paint.style.transform = `translate(${-scrollLeft}px, ${top}px)`;
    const bad = new Map();
    for (const { line, severity } of [...this.#problems].reverse()) if (line) bad.set(line, severity);
    const numbers = Array.from({ length: last - first }, (_, i) => first + i + 1);
    const column = make("div", {}, ...numbers.map(line => make("span", { class: bad.get(line) || null, text: `${line}\n` })));
    column.style.transform = `translateY(${top}px)`;
    this.#gutter.replaceChildren(column);
  }
}

/** The end of the word at an offset, at least one character. */
function wordEnd(text, start) {
  const word = /^[\w."-]+/.exec(text.slice(start, start + 200));
  return Math.min(text.length, start + (word ? word[0].length : 1));
}
