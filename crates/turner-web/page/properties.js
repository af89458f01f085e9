// The keys of a part as fields, made from the scene format: what a key takes, its range and its meaning come from the
// engine.

import { fresh, make, words } from "./dom.js";
import { field } from "./fields.js";

export class Properties {
  #page;
  #box;
  #path = null;
  #shown = "";
  #fields = new Map();
  #turn = 0;
  #encoded = false;
  #links = make("p", { class: "links", hidden: true });

  constructor(page, box) {
    this.#page = page;
    this.#box = box;
    this.#empty();
  }

  /** Shows a part, or brings its values up to date. */
  async show(path) {
    const turn = ++this.#turn;
    if (path !== this.#path) this.#links.hidden = true;
    this.#path = path;
    if (!path) {
      this.#empty();
      return;
    }
    let part;
    try {
      part = await this.#page.call("part", { path });
      this.#encoded = await this.#isEncoded();
    } catch (error) {
      if (turn !== this.#turn) return;
      this.#shown = "";
      this.#box.replaceChildren(make("p", { class: "dim", text: error.message }));
      return;
    }
    if (turn !== this.#turn) return;
    const form = JSON.stringify([path, part.label, part.type, part.keys.map(key => [key.name, key.kind])]);
    if (form === this.#shown) {
      for (const key of part.keys) this.#fields.get(key.name)?.update(key);
      this.#lock();
      return;
    }
    this.#shown = form;
    this.#build(part);
  }

  /** Whether the film writes values unchanged: the numbers of colours are display values then. */
  async #isEncoded() {
    const { keys } = await this.#page.call("part", { path: "film" });
    const transfer = keys.find(key => key.name === "transfer");
    if (transfer?.set) return transfer.value === "none";
    return !["path", "direct"].includes(this.#page.document?.integrator);
  }

  /** After a click in the picture: ways to the object and to its material. */
  offer({ object, material }) {
    const ways = [object, material].filter(Boolean);
    this.#links.replaceChildren(...ways.map(({ path, label }) =>
      make("button", { type: "button", text: label, on: { click: () => this.#page.select(path) } })));
    this.#links.hidden = ways.length < 2;
  }

  #empty() {
    this.#shown = "";
    this.#fields.clear();
    this.#box.replaceChildren(make("p", { class: "dim", text: "Select a part in the list, or click an object in the picture." }));
  }

  #build(part) {
    this.#fields.clear();
    const rows = part.keys.map(key => this.#row(part, key));
    this.#box.replaceChildren(
      this.#links,
      make("h2", { text: part.label }),
      this.#frame(),
      this.#types(part),
      part.doc ? make("p", { class: "dim doc" }, ...words(part.doc)) : "",
      make("div", { class: "keys" }, ...rows));
    this.#lock();
  }

  /** Fields that cannot be changed here are shown as such. */
  #lock() {
    if (!this.#page.looksOn) return;
    for (const control of this.#box.querySelectorAll("input, select, textarea, .keys button")) control.disabled = true;
  }

  /** A button that moves the camera to the object. */
  #frame() {
    const object = /^object\.(\d+)$/.exec(this.#path);
    if (!object || this.#page.looksOn) return "";
    const act = () => this.#page.attempt("frame", { object: Number(object[1]) }, "Cannot frame it");
    return make("p", { class: "links" }, make("button", { type: "button", text: "Frame this object", on: { click: act } }));
  }

  #types(part) {
    if (!part.types?.length) return part.type ? make("p", { class: "dim", text: part.type }) : "";
    const id = fresh("type");
    const select = make("select", { id, on: { change: () => this.#set("type", select.value, null).catch(error => this.#page.emit("problem", error)) } },
      ...part.types.map(type => make("option", { value: type.name, title: type.doc, text: type.name, selected: type.name === part.type })));
    return make("div", { class: "key" }, make("label", { for: id, text: "type" }), make("div", { class: "value" }, select));
  }

  #row(part, key) {
    const id = fresh("key");
    const doc = make("p", { class: "doc", id: `${id}-doc`, hidden: true });
    const problem = make("p", { class: "wrong", id: `${id}-wrong`, role: "alert", hidden: true });
    const set = async (value, merge) => {
      problem.hidden = true;
      try {
        await this.#set(key.name, value, merge);
      } catch (error) {
        problem.textContent = [error.message, error.help].filter(Boolean).join(" ");
        problem.hidden = false;
      }
    };
    const control = field(key, id, set, { names: part.names, encoded: this.#encoded });
    const reset = make("button", {
      type: "button", class: "reset", "aria-label": `Reset ${key.name} to its default`, title: "Reset to the default", text: "↺",
      on: { click: () => set(null, null) },
    });
    const name = make("button", {
      type: "button", class: "name", "aria-expanded": "false", "aria-controls": doc.id, "aria-label": `${key.name.replaceAll("_", " ")}: meaning`,
      text: key.name.replaceAll("_", " "), title: key.doc,
      on: { click: () => { doc.hidden = !doc.hidden; name.setAttribute("aria-expanded", String(!doc.hidden)); } },
    });
    const update = next => {
      const facts = [next.range, next.default !== null && next.default !== undefined ? `default ${next.default}` : ""].filter(Boolean).join("; ");
      doc.replaceChildren(...words([next.doc, facts].filter(Boolean).join(" · ")));
      row.classList.toggle("set", next.set);
      reset.style.visibility = next.set ? "" : "hidden";
      control.update(next);
    };
    const row = make("div", { class: "key" }, name, make("div", { class: "value" }, control.element), reset, doc, problem);
    update(key);
    this.#fields.set(key.name, { update });
    return row;
  }

  #set(name, value, merge) {
    const path = `${this.#path}.${name}`;
    return this.#page.call("set", { edits: [[path, value]], label: `Change ${name.replaceAll("_", " ")}`, merge });
  }
}
