// Messages: what went wrong, where, and what to do.

import { announce, find, make, sentence, words } from "./dom.js";

/** Shows an error of the engine or of the page until it is closed. `actions`: buttons, as [label, function]. */
export function fail(error, title = "", actions = []) {
  const place = position(error);
  const buttons = actions.map(([label, act]) =>
    make("button", { type: "button", text: label, on: { click: () => { clear(); act(); } } }));
  show("error",
    make("p", {}, make("strong", { text: title ? `${title}: ` : "" }), error.message || String(error)),
    error.excerpt ? make("pre", { text: error.excerpt }) : null,
    place ? make("p", { class: "dim", text: place }) : null,
    error.help ? make("p", {}, ...words(sentence(error.help))) : null,
    buttons.length ? make("p", { class: "buttons" }, ...buttons) : null);
}

/** Shows a note that does not interrupt. */
export function tell(text) {
  show("note", make("p", { text }));
  announce(text);
}

export function clear() {
  const box = find("message");
  box.hidden = true;
  box.replaceChildren();
}

/** "scene.toml, line 3, column 7" */
export function position(error) {
  const parts = [];
  if (error.file) parts.push(error.file);
  if (error.line) parts.push(`line ${error.line}`);
  if (error.line && error.column) parts.push(`column ${error.column}`);
  return parts.join(", ");
}

function show(kind, ...content) {
  const box = find("message");
  const close = make("button", { type: "button", class: "close", "aria-label": "Close the message", text: "×", on: { click: clear } });
  box.className = `message ${kind}`;
  box.setAttribute("role", kind === "error" ? "alert" : "status");
  box.replaceChildren(make("div", {}, ...content), close);
  box.hidden = false;
}

addEventListener("keydown", event => {
  if (event.key === "Escape" && !event.defaultPrevented) clear();
});
