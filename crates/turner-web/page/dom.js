// Elements: made, found and announced.

export const find = id => document.getElementById(id);

/**
 * Makes an element. `props`: `class`, `text`, `on` (listeners by event), and attributes; `false`, `null` and
 * `undefined` omit an attribute.
 */
export function make(tag, props = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === false || value === null || value === undefined) continue;
    if (key === "text") element.textContent = value;
    else if (key === "class") element.className = value;
    else if (key === "on") for (const [event, act] of Object.entries(value)) element.addEventListener(event, act);
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined));
  return element;
}

/** Tells screen readers, once and politely. */
export function announce(text) {
  const region = find("announcement");
  region.textContent = "";
  requestAnimationFrame(() => { region.textContent = text; });
}

/** Runs `act` once nothing has called for `ms` milliseconds. */
export function later(ms, act) {
  let timer = 0;
  const call = (...args) => {
    clearTimeout(timer);
    timer = setTimeout(() => act(...args), ms);
  };
  call.cancel = () => clearTimeout(timer);
  return call;
}

/** Text with `code` and **strong** words, as nodes. */
export function words(text) {
  return text.split(/(`[^`]+`|\*\*[^*]+\*\*)/).map(part => {
    if (part.startsWith("`")) return make("code", { text: part.slice(1, -1) });
    if (part.startsWith("**")) return make("strong", { text: part.slice(2, -2) });
    return part;
  });
}

/** A message of the core as a sentence of its own. */
export function sentence(text) {
  const first = text.slice(0, 1).toUpperCase() + text.slice(1);
  return /[.!?:)]$/.test(first) ? first : `${first}.`;
}

let count = 0;
/** An id that no other element has. */
export const fresh = prefix => `${prefix}-${++count}`;

export const still = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Offers bytes as a download. */
export function download(name, bytes, type = "application/octet-stream") {
  const url = URL.createObjectURL(new Blob([bytes], { type }));
  const link = make("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
