// Completions of the text: a listbox at the cursor. The focus stays in the text; `aria-activedescendant` names the entry.

import { announce, fresh, later, make, words } from "./dom.js";
import { place } from "./highlight.js";

/** Entries shown. */
const MOST = 200;

export class Completion {
  #page;
  #area;
  #changed;
  #list = make("div", { role: "listbox", class: "completions", id: "completions", "aria-label": "Completions", hidden: true });
  #doc = make("div", { class: "completion-doc", "aria-hidden": "true" });
  #items = [];
  #range = [0, 0];
  #chosen = 0;
  #turn = 0;
  #ask = later(80, () => this.#request(false));
  #inserting = false;

  constructor(page, area, changed) {
    this.#page = page;
    this.#area = area;
    this.#changed = changed;
    area.setAttribute("aria-controls", "completions");
    area.parentElement.append(this.#list);
    area.addEventListener("keydown", event => this.#key(event));
    area.addEventListener("input", event => this.#typed(event));
    area.addEventListener("blur", () => this.close());
    area.addEventListener("scroll", () => this.follow());
    area.addEventListener("pointerdown", () => this.close());
  }

  get #isOpen() {
    return !this.#list.hidden;
  }

  close() {
    this.#turn++;
    this.#ask.cancel();
    this.#list.hidden = true;
    this.#area.removeAttribute("aria-activedescendant");
  }

  #typed(event) {
    if (this.#inserting) return;
    const before = this.#area.value.slice(0, this.#area.selectionStart);
    const deletes = event.inputType?.startsWith("delete");
    // A word, or the place of a value or a section, asks for completions.
    if (deletes ? this.#isOpen : /[\w"-]$|= ?$|\[$/.test(before) && !/#[^\n]*$/.test(before)) this.#ask();
    else this.close();
  }

  #key(event) {
    if ((event.ctrlKey || event.metaKey) && event.key === " ") {
      event.preventDefault();
      this.#request(true);
      return;
    }
    // Completions that are on their way are not wanted any more.
    if (!this.#isOpen && event.key === "Escape") this.close();
    if (!this.#isOpen || event.ctrlKey || event.metaKey || event.altKey) return;
    const last = this.#items.length - 1;
    const to = {
      ArrowDown: this.#chosen === last ? 0 : this.#chosen + 1,
      ArrowUp: this.#chosen ? this.#chosen - 1 : last,
      PageDown: Math.min(last, this.#chosen + 8),
      PageUp: Math.max(0, this.#chosen - 8),
    }[event.key];
    if (to !== undefined) this.#choose(to);
    else if (event.key === "Enter" || event.key === "Tab" && !event.shiftKey) this.#accept(this.#chosen);
    else if (event.key === "Escape") { event.stopPropagation(); this.close(); }
    else return;
    event.preventDefault();
  }

  async #request(asked) {
    const turn = ++this.#turn;
    const { value: text, selectionStart: at } = this.#area;
    let answer;
    try {
      answer = await this.#page.call("complete", { text, offset: at });
    } catch {
      return;
    }
    if (turn !== this.#turn || this.#area.value !== text) return;
    const items = (answer.items || []).slice(0, MOST);
    const typed = text.slice(answer.from, at);
    // Nothing to say: no entries, or the only one is already there.
    if (!items.length || !asked && items.length === 1 && items[0].insert === typed) {
      this.close();
      if (asked) announce("No completions here");
      return;
    }
    this.#items = items;
    this.#range = [answer.from, answer.to];
    this.#show(text, at);
  }

  #show(text, at) {
    this.#list.replaceChildren(...this.#items.map((item, i) => make("div", {
      role: "option", id: fresh("completion"), class: "completion", "aria-selected": "false",
      on: { pointerdown: event => { event.preventDefault(); this.#accept(i); } },
    }, make("span", { text: item.label }), make("span", { class: "dim", text: item.detail || "" }))), this.#doc);
    this.#list.hidden = false;
    this.#choose(0);
    this.#place(text, at);
    announce(`${this.#items.length} completions`);
  }

  /** Stays at the cursor when the text moves below it. */
  follow() {
    if (this.#isOpen) this.#place(this.#area.value, this.#area.selectionStart);
  }

  /** Below the cursor, or above it where there is no room. */
  #place(text, at) {
    const style = getComputedStyle(this.#area);
    const height = parseFloat(style.lineHeight);
    const { line } = place(text, at);
    const start = place(text, this.#range[0]);
    const left = parseFloat(style.paddingLeft) + (start.column - 1) * this.#width(style) - this.#area.scrollLeft;
    const top = parseFloat(style.paddingTop) + line * height - this.#area.scrollTop;
    // On phones the text can be longer than the window, and the tabs lie over its lower edge.
    const box = this.#area.getBoundingClientRect();
    const tabs = document.getElementById("tabs").getBoundingClientRect();
    const edge = tabs.top > box.top ? tabs.top : innerHeight;
    const room = Math.min(box.bottom, edge) - box.top;
    const size = this.#list.offsetHeight;
    this.#list.style.left = `${Math.max(4, Math.min(left, this.#area.clientWidth - this.#list.offsetWidth - 4))}px`;
    this.#list.style.top = `${top + size > room && top - height > size ? top - height - size : top}px`;
  }

  /** Width of a character of the text, CSS pixels. */
  #width(style) {
    const context = document.createElement("canvas").getContext("2d");
    context.font = `${style.fontSize} ${style.fontFamily}`;
    return context.measureText("0").width;
  }

  #choose(index) {
    const options = this.#list.querySelectorAll("[role=option]");
    options[this.#chosen]?.setAttribute("aria-selected", "false");
    this.#chosen = index;
    const option = options[index];
    if (!option) return;
    option.setAttribute("aria-selected", "true");
    option.scrollIntoView({ block: "nearest" });
    this.#area.setAttribute("aria-activedescendant", option.id);
    const { doc, detail } = this.#items[index];
    this.#doc.replaceChildren(...words(doc || detail || ""));
    this.#doc.hidden = !this.#doc.textContent;
  }

  #accept(index) {
    const item = this.#items[index];
    const [from, to] = this.#range;
    this.close();
    if (!item) return;
    this.#inserting = true;
    this.#area.focus();
    this.#area.setSelectionRange(from, to);
    // `insertText` keeps the browser's undo; where it is missing, the text is replaced without it.
    if (!document.execCommand("insertText", false, item.insert)) {
      this.#area.setRangeText(item.insert, from, to, "end");
    }
    this.#inserting = false;
    this.#changed();
    if (item.kind === "key") this.#request(false);
  }
}
