// Why a pixel has its colour: the tree of its rays, linked with the views of the scene.

import { announce, find, make, still } from "./dom.js";

const all = (from, what) => Array.from(from.querySelectorAll(what));
const rays = element => (element.dataset.ray || "").split(" ").filter(Boolean);

/** A promise with what resolves it. */
function deferred() {
  let resolve;
  const promise = new Promise(done => { resolve = done; });
  return { promise, resolve };
}

export function setupExplain(page) {
  const panel = find("panel-explain");
  let turn = 0;

  const empty = () => {
    page.explained = null;
    page.viewport.mark(null);
    panel.replaceChildren(make("p", { class: "dim prompt", text: "Click a pixel of the picture: this panel shows every ray behind its colour, what it hit and what it contributed. With the keyboard: C shows a crosshair, E explains." }));
  };
  empty();
  page.on("opened", () => { turn++; empty(); });

  // The tree is that of the scene as it was.
  const again = make("p", { class: "again", hidden: true }, "The scene has changed since. ",
    make("button", { type: "button", text: "Explain again", on: { click: () => page.explain(page.explained.x, page.explained.y) } }));
  page.on("document", () => { again.hidden = false; });

  // A scene that was just opened has nothing to explain until its first picture.
  let drawn = deferred();
  page.on("opened", () => { drawn = deferred(); });
  page.on("frame", () => drawn.resolve());
  page.on("status", ({ error }) => { if (error) drawn.resolve(); });

  /** Explains a pixel of the film. */
  page.explain = async (x, y) => {
    const mine = ++turn;
    if (page.panel !== "explain") page.showPanel("explain");
    page.viewport.mark({ x, y });
    panel.setAttribute("aria-busy", "true");
    panel.replaceChildren(make("p", { class: "dim prompt", text: `Tracing the rays of pixel ${x}, ${y} …` }));
    let answer;
    await drawn.promise;
    if (mine !== turn) return;
    try {
      answer = await page.call("explain", { x, y, sample: null, format: "page" });
    } catch (error) {
      if (mine !== turn) return;
      panel.replaceChildren(make("p", { class: "wrong", text: error.message }), error.help ? make("p", { text: error.help }) : "");
      panel.removeAttribute("aria-busy");
      page.explained = null;
      return;
    }
    if (mine !== turn) return;
    const root = fragment(answer.text);
    again.hidden = true;
    panel.replaceChildren(again, root);
    panel.removeAttribute("aria-busy");
    wire(root);
    page.explained = { x, y };
    announce(`Pixel ${x}, ${y} is explained in the panel Explain`);
    page.emit("explained", { x, y });
  };
}

/** The fragment as elements. It comes from the engine, which escapes names; still nothing in it may act. */
function fragment(text) {
  const parsed = new DOMParser().parseFromString(text, "text/html");
  for (const element of all(parsed, "script, style, link, meta, title, base, iframe, object, embed")) element.remove();
  for (const element of all(parsed, "*")) {
    for (const { name, value } of Array.from(element.attributes)) {
      if (/^on/i.test(name) || /href|src|action/i.test(name) && !value.startsWith("#")) element.removeAttribute(name);
    }
  }
  // The page has a first heading of its own.
  for (const heading of all(parsed, "h1")) {
    const smaller = parsed.createElement("h2");
    smaller.className = "pixel";
    smaller.append(...heading.childNodes);
    heading.replaceWith(smaller);
  }
  for (const svg of all(parsed, ".views svg")) {
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", "The rays in views of the scene from above, the side and the front");
  }
  const root = make("div", { class: "explanation" });
  root.append(...parsed.body.childNodes);
  return root;
}

/** Makes an explanation live: folds, highlights, and shows one sample at a time. */
export function wire(root) {
  for (const section of all(root, "section")) wireSample(section);
  const buttons = all(root, "nav button");
  const show = number => {
    for (const section of all(root, "section")) section.hidden = section.dataset.sample !== number;
    for (const button of buttons) {
      const on = button.dataset.sample === number;
      button.classList.toggle("on", on);
      button.setAttribute("aria-pressed", String(on));
    }
  };
  for (const button of buttons) {
    button.setAttribute("aria-label", button.title);
    button.addEventListener("click", () => show(button.dataset.sample));
  }
  const first = root.querySelector("section:not([hidden])");
  if (first && buttons.length) show(first.dataset.sample);
}

function wireSample(section) {
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
    if (!next || depth(next) <= depth(row)) {
      fold.classList.add("leaf");
      return;
    }
    fold.setAttribute("aria-label", `Descendants of ${row.querySelector(".what")?.textContent.trim() || "the ray"}`);
    fold.setAttribute("aria-expanded", "true");
    fold.addEventListener("click", event => {
      event.preventDefault();
      const folded = row.classList.toggle("folded");
      fold.setAttribute("aria-expanded", String(!folded));
      refold();
    });
  });
  if (!views) return;

  // Highlights a ray or an object in the tree and in the views.
  let pinned = null;
  const light = element => {
    for (const e of all(section, ".marked")) e.classList.remove("marked");
    views.classList.toggle("busy", Boolean(element));
    if (!element) return;
    const wanted = new Set(rays(element));
    const object = element.dataset.object;
    if (!wanted.size) {
      for (const e of marked) if (e.dataset.object === object) rays(e).forEach(ray => wanted.add(ray));
    }
    for (const e of marked) if (rays(e).some(ray => wanted.has(ray))) e.classList.add("marked");
    for (const e of objects) if (e.classList.contains("object") && e.dataset.object === object) e.classList.add("marked");
  };
  const of = event => event.target.closest("[data-ray],.object");
  section.addEventListener("mouseover", event => light(of(event) || pinned));
  section.addEventListener("mouseleave", () => light(pinned));
  section.addEventListener("focusin", event => light(of(event) || pinned));
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
    row.scrollIntoView({ block: "nearest", behavior: still() ? "auto" : "smooth" });
  });
}
