"use strict";
const all = (from, what) => Array.from(from.querySelectorAll(what));
const rays = element => (element.dataset.ray || "").split(" ").filter(Boolean);

for (const section of all(document, "section")) {
  const rows = all(section, ".row");
  const depth = row => Number(row.dataset.depth);
  const views = section.querySelector(".views");
  const marked = all(section, "[data-ray]");
  const objects = all(section, "[data-object]");

  // Folding: a folded row hides its descendants.
  const refold = () => {
    let closed = Infinity;
    for (const row of rows) {
      if (depth(row) <= closed) closed = Infinity;
      row.hidden = depth(row) > closed;
      if (closed === Infinity && row.classList.contains("folded")) closed = depth(row);
    }
  };
  rows.forEach((row, i) => {
    const fold = row.querySelector(".fold");
    if (!fold) return;
    const next = rows[i + 1];
    if (!next || depth(next) <= depth(row)) fold.classList.add("leaf");
    fold.addEventListener("click", event => {
      event.preventDefault();
      row.classList.toggle("folded");
      refold();
    });
  });

  // Highlights a ray or an object in the tree and in the views.
  let pinned = null;
  const light = element => {
    for (const e of all(section, ".on:not(.light-mark)")) e.classList.remove("on");
    views.classList.toggle("busy", Boolean(element));
    if (!element) return;
    const wanted = new Set(rays(element));
    const object = element.dataset.object;
    if (!wanted.size) {
      for (const e of marked) if (e.dataset.object === object) rays(e).forEach(r => wanted.add(r));
    }
    for (const e of marked) if (rays(e).some(r => wanted.has(r))) e.classList.add("on");
    for (const e of objects) if (e.classList.contains("object") && e.dataset.object === object) e.classList.add("on");
  };
  const of = event => event.target.closest("[data-ray],.object");
  section.addEventListener("mouseover", event => light(of(event) || pinned));
  section.addEventListener("mouseleave", () => light(pinned));
  views.addEventListener("click", event => {
    const element = of(event);
    pinned = element === pinned ? null : element;
    light(pinned);
    if (!element || !element.dataset.ray) return;
    const row = rows.find(r => rays(r).includes(element.dataset.ray));
    if (!row) return;
    for (let i = rows.indexOf(row), d = depth(row); i >= 0; i--) {
      if (depth(rows[i]) < d) { d = depth(rows[i]); rows[i].classList.remove("folded"); }
    }
    refold();
    row.open = true;
    row.scrollIntoView({ block: "nearest", behavior: "smooth" });
  });
}

// The buttons show one sample at a time.
const buttons = all(document, "nav button");
const show = number => {
  for (const s of all(document, "section")) s.hidden = s.dataset.sample !== number;
  for (const b of buttons) b.classList.toggle("on", b.dataset.sample === number);
};
for (const b of buttons) b.addEventListener("click", () => show(b.dataset.sample));
const first = document.querySelector("section:not([hidden])");
if (first && buttons.length) show(first.dataset.sample);
