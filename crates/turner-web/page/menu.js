// Menus of the toolbar: a button and a list of commands, by mouse and by keyboard.

import { make } from "./dom.js";

let open = null;

/**
 * `items()`: [{label, detail, act, checked, disabled} | null (a rule)], asked for each time the menu opens; it may be a
 * promise.
 */
export function menu(button, items) {
  button.addEventListener("click", () => toggle(button, items));
  button.addEventListener("keydown", event => {
    if (event.key !== "ArrowDown") return;
    event.preventDefault();
    toggle(button, items);
  });
}

async function toggle(button, items) {
  const was = open && open.button === button;
  close(false);
  if (was) return;
  const list = make("div", { role: "menu", class: "menu", "aria-label": button.textContent, on: { keydown: keys, focusout: leave } });
  const state = open = { button, list };
  button.setAttribute("aria-expanded", "true");
  let all;
  try {
    all = await items();
  } catch (error) {
    all = [{ label: error.message, disabled: true }];
  }
  if (open !== state) return;
  for (const item of all) list.append(entry(item));
  button.after(list);
  place(button, list);
  entries(list)[0]?.focus();
}

function entry(item) {
  if (!item) return make("hr", { role: "separator" });
  const radio = item.checked !== undefined;
  return make("button", {
    type: "button",
    role: radio ? "menuitemradio" : "menuitem",
    tabindex: "-1",
    "aria-checked": radio ? String(item.checked) : null,
    "aria-disabled": item.disabled ? "true" : null,
    on: { click: () => { if (item.disabled) return; close(true); item.act(); } },
  }, make("span", { text: item.label }), item.detail ? make("span", { class: "dim detail", text: item.detail }) : null);
}

const entries = list => Array.from(list.querySelectorAll("button"));

function keys(event) {
  const all = entries(open.list);
  const now = all.indexOf(document.activeElement);
  const to = { ArrowDown: now + 1, ArrowUp: now - 1 + all.length, Home: 0, End: all.length - 1 }[event.key];
  if (to !== undefined) {
    event.preventDefault();
    all[to % all.length]?.focus();
  } else if (event.key === "Escape") {
    event.stopPropagation();
    close(true);
  } else if (event.key === "Tab") {
    close(true);
  } else if (event.key.length === 1) {
    const letter = event.key.toLowerCase();
    const next = [...all.slice(now + 1), ...all.slice(0, now + 1)].find(b => b.textContent.trim().toLowerCase().startsWith(letter));
    next?.focus();
  }
}

function leave(event) {
  if (open && !open.list.contains(event.relatedTarget) && event.relatedTarget !== open.button) close(false);
}

function close(back) {
  if (!open) return;
  const { button, list } = open;
  open = null;
  button.setAttribute("aria-expanded", "false");
  list.remove();
  if (back) button.focus();
}

/** Below the button, inside the window. */
function place(button, list) {
  const at = button.getBoundingClientRect();
  const width = list.offsetWidth;
  const left = Math.max(8, Math.min(at.left, innerWidth - width - 8));
  list.style.left = `${left}px`;
  list.style.top = `${at.bottom + 4}px`;
  list.style.maxHeight = `${innerHeight - at.bottom - 16}px`;
}

addEventListener("pointerdown", event => {
  if (open && !open.list.contains(event.target) && !open.button.contains(event.target)) close(false);
});
addEventListener("resize", () => close(false));
