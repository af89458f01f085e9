// Fields of values that consist of others: vectors, transforms, and what has no field of its own.

import { make } from "./dom.js";
import { brief, current, digits, isBusy, isLong } from "./value.js";

/** The names of the numbers of a kind like "[x, y, z]". */
export function tuple(kind) {
  const match = /^\[([^[\]{}|…]+)\]$/.exec(kind);
  if (!match) return null;
  const parts = match[1].split(",").map(word => word.trim());
  const plain = parts.every(word => /^[\w ]+$/.test(word) && !/^(text|integer|color|material|texture)$/.test(word));
  return plain && parts.length >= 2 && parts.length <= 4 ? parts : null;
}

/** Numbers beside one another. */
export function vector(parts, id, label, set) {
  let value = null;
  // The numbers that are not changed keep all of their digits.
  const change = i => {
    const values = inputs.map((input, j) => j === i || !Array.isArray(value) ? input.valueAsNumber : value[j]);
    if (values.every(Number.isFinite)) set(values, null);
  };
  const inputs = parts.map((part, i) => make("input", {
    type: "number", step: "any", id: i ? null : id, "aria-label": `${label} ${part}`,
    on: { change: () => change(i) },
  }));
  return {
    element: make("div", { class: "vector" }, ...inputs),
    update(key) {
      value = current(key);
      inputs.forEach((input, i) => {
        if (!isBusy(input)) input.value = Array.isArray(value) ? digits(value[i], 4) : "";
        input.placeholder = typeof value === "string" ? value : "";
      });
    },
  };
}

const STEPS = [["translate", [0, 0, 0]], ["rotate", [0, 0, 0]], ["scale", [1, 1, 1]]];

/** The three steps of a simple transform; others are written. */
export function transform(id, label, set) {
  let value = null;
  const change = (name, neutral, numbers) => {
    const next = { ...value, [name]: numbers };
    if (numbers.every((x, i) => x === neutral[i])) delete next[name];
    set(Object.keys(next).length ? next : null, null);
  };
  const rows = STEPS.map(([name, neutral]) =>
    vector(["x", "y", "z"], `${id}-${name}`, `${label} ${name}`, numbers => change(name, neutral, numbers)));
  const simple = make("div", { class: "transform" }, ...rows.flatMap((row, i) => [make("span", { class: "dim", text: STEPS[i][0] }), row.element]));
  const text = written(id, label, set);
  return {
    element: make("div", { class: "either" }, simple, text.element),
    update(key) {
      value = key.value ?? null;
      const numbers = steps(value);
      simple.hidden = !numbers;
      text.element.hidden = Boolean(numbers);
      if (numbers) rows.forEach((row, i) => row.update({ value: numbers[i] }));
      else text.update(key);
    },
  };
}

/** The numbers of the steps; `null` for a transform that has others. */
function steps(value) {
  if (value !== null && (typeof value !== "object" || Array.isArray(value))) return null;
  if (Object.keys(value || {}).some(name => !STEPS.some(([own]) => own === name))) return null;
  const all = STEPS.map(([name, neutral]) => {
    const own = value?.[name] ?? neutral;
    return name === "scale" && typeof own === "number" ? [own, own, own] : own;
  });
  return all.every(own => Array.isArray(own) && own.length === 3) ? all : null;
}

/** A value as it is written, in JSON: a list, a table, a text. Long ones are edited in the panel Text. */
export function written(id, label, set) {
  const input = make("input", { type: "text", id, class: "written", "aria-label": `${label}, as JSON`, autocomplete: "off", spellcheck: "false", placeholder: "none", title: "A value in JSON, such as [1, 2] or \"text\"" });
  const output = make("output", { class: "dim raw", "aria-label": label, title: "Edit it in the panel Text" });
  input.addEventListener("change", () => {
    const text = input.value.trim();
    try {
      input.setCustomValidity("");
      set(text ? JSON.parse(text) : null, null);
    } catch {
      input.setCustomValidity("This is not JSON: write text in quotes, and lists in brackets.");
      input.reportValidity();
    }
  });
  return {
    element: make("div", { class: "either" }, input, output),
    update(key) {
      const value = current(key);
      const long = value !== null && isLong(value);
      input.hidden = long;
      output.hidden = !long;
      if (long) output.textContent = brief(value);
      else if (!isBusy(input)) input.value = value === null ? "" : JSON.stringify(value);
    },
  };
}
