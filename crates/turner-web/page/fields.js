// The field of a value: chosen by the kind that the scene format states for its key.

import { make } from "./dom.js";
import { hexOf, isColor } from "./color.js";
import { transform, tuple, vector, written } from "./compound.js";
import { brief, current, digits, isBusy } from "./value.js";

/** The lists of names that the engine sends with a part. */
const PLURAL = { material: "materials", texture: "textures", medium: "media", group: "groups" };

/** A field: {element, update(key)}. `set(value, merge)` edits the scene; changes with the same `merge` are one undo step. */
export function field(key, id, set, { names = {}, encoded = false }) {
  const kind = (key.kind || "").trim();
  const label = key.name.replaceAll("_", " ");
  if (key.words?.length && !kind.startsWith("[")) return choice(key.words, id, label, set);
  if (kind === "bool" || kind === "true | false") return toggle(id, label, set);
  if (/^(number|integer)$/.test(kind)) return number(key, id, label, set, kind === "integer");
  if (/^colou?r\b|\| *texture|colou?r or texture/.test(kind)) return color(id, label, set, encoded);
  if (/^(material|medium|group|texture)$/.test(kind)) return part(names[PLURAL[kind]] || [], id, label, set);
  const parts = tuple(kind);
  if (parts) return vector(parts, id, label, set);
  if (/^("text"|text|word)$/.test(kind)) return text(id, label, set);
  if (kind === "transform") return transform(id, label, set);
  return written(id, label, set);
}

function choice(words, id, label, set) {
  const select = make("select", { id, "aria-label": label, on: { change: () => set(select.value, null) } },
    ...words.map(([word, doc]) => make("option", { value: word, text: word, title: doc })));
  return {
    element: select,
    update(key) {
      const value = current(key);
      if (!words.some(([word]) => word === value)) {
        if (!select.querySelector(".other")) select.prepend(make("option", { class: "other", value: "", disabled: true }));
        select.firstChild.textContent = value === null ? "none" : brief(value);
        select.value = "";
      } else {
        select.value = value;
      }
    },
  };
}

function toggle(id, label, set) {
  const box = make("input", { type: "checkbox", id, "aria-label": label, on: { change: () => set(box.checked, null) } });
  return { element: box, update(key) { box.checked = current(key) === true; } };
}

/** The ends of a range that has two; `null` for an open one. */
const ends = bounds => Array.isArray(bounds) && bounds.every(Number.isFinite) ? bounds : null;

function number(key, id, label, set, whole) {
  const range = ends(key.bounds);
  let drag = 0;
  const send = (value, merge) => { if (Number.isFinite(value)) set(whole ? Math.round(value) : value, merge); };
  const input = make("input", { type: "number", id, "aria-label": label, step: whole ? "1" : "any", inputmode: "decimal", on: { change: () => send(input.valueAsNumber, null) } });
  // A wider range than this has no use as a slider.
  const slides = range && range[1] - range[0] <= 360;
  const slider = slides ? make("input", {
    type: "range", min: range[0], max: range[1], step: whole ? 1 : (range[1] - range[0]) / 200, "aria-label": `${label}, slider`,
    on: {
      input: () => { input.value = digits(slider.valueAsNumber); send(Number(input.value), `${id}-${drag}`); },
      change: () => { drag++; },
    },
  }) : null;
  return {
    element: make("div", { class: "number" }, slider, input),
    update(next) {
      const value = current(next);
      if (!isBusy(input)) input.value = digits(value);
      if (slider && !isBusy(slider)) slider.value = typeof value === "number" ? value : range[0];
      input.placeholder = typeof value === "string" ? value : "";
    },
  };
}

function color(id, label, set, encoded) {
  let drag = 0;
  const picker = make("input", { type: "color", id, "aria-label": `${label}, colour picker`, on: { input: () => set(picker.value, `${id}-${drag}`), change: () => { drag++; } } });
  const input = make("input", { type: "text", "aria-label": label, autocomplete: "off", spellcheck: "false", on: { change: () => { const value = read(input.value); if (value !== undefined) set(value, null); } } });
  return {
    element: make("div", { class: "color" }, picker, input),
    update(next) {
      const value = current(next);
      const plain = isColor(value);
      picker.hidden = !plain;
      input.placeholder = "none";
      if (plain && !isBusy(picker)) picker.value = hexOf(value, encoded);
      // A texture that is written in place is a table: it is edited in the text.
      input.readOnly = value !== null && typeof value === "object" && !Array.isArray(value);
      input.title = input.readOnly ? "A texture: edit it in the panel Text" : "A name, #rrggbb, [r, g, b] in linear light, a number, or the name of a texture";
      if (!isBusy(input)) input.value = value === null ? "" : brief(value);
    },
  };
}

/** What was written: JSON, or text. */
function read(text) {
  const trimmed = text.trim();
  if (!trimmed) return null;
  try {
    return JSON.parse(trimmed);
  } catch {
    return trimmed;
  }
}

/** Another part of the scene by its name. */
function part(names, id, label, set) {
  const select = make("select", { id, "aria-label": label, on: { change: () => set(select.value || null, null) } });
  return {
    element: select,
    update(key) {
      const value = current(key);
      const inline = value !== null && typeof value === "object";
      const all = new Set(names);
      if (typeof value === "string") all.add(value);
      select.replaceChildren(make("option", { value: "", text: inline ? `own (${value.type || "default"})` : "none" }),
        ...Array.from(all).map(name => make("option", { value: name, text: name })));
      select.value = typeof value === "string" ? value : "";
    },
  };
}

function text(id, label, set) {
  const input = make("input", { type: "text", id, "aria-label": label, on: { change: () => set(input.value || null, null) } });
  return { element: input, update(key) { if (!isBusy(input)) input.value = current(key) ?? ""; } };
}
