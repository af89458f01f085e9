// The parts of the scene as a list, and what a click in the picture selects.

import { announce, find, fresh, later, make } from "./dom.js";
import { Properties } from "./properties.js";

/** Entries of one list that are shown without a filter: a scene can have a hundred thousand objects. */
const MOST = 300;

export function setupParts(page) {
  const box = find("outline");
  const filter = find("filter");
  const properties = new Properties(page, find("properties"));
  let lists = [];
  let selected = null;
  let stale = true;

  const visible = () => page.state === "scene" && page.panel === "scene";
  const refresh = later(120, async () => {
    if (!visible()) { stale = true; return; }
    stale = false;
    try {
      ({ lists } = await page.call("outline"));
    } catch (error) {
      page.emit("problem", error);
      return;
    }
    render();
    if (selected && !all().some(entry => entry.path === selected)) select(null);
    else if (selected) properties.show(selected);
  });

  page.on("document", refresh);
  page.on("opened", () => { select(null); filter.value = ""; refresh(); });
  page.on("panel", () => { if (visible() && (stale || !lists.length)) refresh(); });
  filter.addEventListener("input", render);

  const all = () => lists.flatMap(list => list.entries);

  function render() {
    const wanted = filter.value.trim().toLowerCase();
    const matches = entry => !wanted || `${entry.label} ${entry.type || ""}`.toLowerCase().includes(wanted);
    const groups = lists.map(({ title, entries, count }) => {
      const found = entries.filter(matches);
      if (!found.length) return null;
      const id = fresh("list");
      const more = Math.max(found.length, wanted ? 0 : count || 0) - MOST;
      return make("div", { role: "group", "aria-labelledby": id },
        make("div", { class: "list-title", id, role: "presentation", text: (count || entries.length) > 1 && title !== "Settings" ? `${title} (${count || entries.length})` : title }),
        ...found.slice(0, MOST).map(option),
        more > 0 ? make("div", { class: "dim more", role: "presentation", text: `${more} more: write in the filter` }) : null);
    });
    box.replaceChildren(...groups.filter(Boolean));
    if (!box.children.length) box.append(make("p", { class: "dim more", text: wanted ? "No part has this name." : "No parts." }));
    mark();
  }

  function option(entry) {
    return make("div", {
      role: "option", id: fresh("part"), class: "part", "data-path": entry.path, "aria-selected": "false",
      on: { click: () => select(entry.path) },
    }, make("span", { text: entry.label }), entry.type && entry.type !== entry.label ? make("span", { class: "dim", text: entry.type }) : null);
  }

  function mark() {
    let active = null;
    for (const element of box.querySelectorAll("[role=option]")) {
      const on = element.dataset.path === selected;
      element.setAttribute("aria-selected", String(on));
      if (on) active = element;
    }
    if (active) box.setAttribute("aria-activedescendant", active.id);
    else box.removeAttribute("aria-activedescendant");
    return active;
  }

  function select(path) {
    selected = path;
    mark()?.scrollIntoView({ block: "nearest" });
    properties.show(path);
  }

  box.addEventListener("keydown", event => {
    const options = Array.from(box.querySelectorAll("[role=option]"));
    const now = options.findIndex(element => element.dataset.path === selected);
    const last = options.length - 1;
    const to = { ArrowDown: Math.min(last, now + 1), ArrowUp: Math.max(0, now - 1), Home: 0, End: last }[event.key];
    if (to === undefined || last < 0) return;
    event.preventDefault();
    select(options[to].dataset.path);
  });

  /** Selects what is seen at a pixel. */
  page.pick = async pixel => {
    const seen = await page.attempt("pick", { x: pixel.x, y: pixel.y });
    const part = seen?.material || seen?.object;
    if (!seen) return;
    if (!part) {
      announce("Nothing is here but the background");
      return;
    }
    if (page.panel !== "scene") page.showPanel("scene");
    if (stale || !lists.length) {
      ({ lists } = await page.call("outline"));
        stale = false;
      render();
    }
    // Materials that are written inside their object have no entry of their own.
    const own = [seen.object, seen.material].find(entry => entry && all().some(other => other.path === entry.path));
    select((own || part).path);
    properties.offer(seen);
    announce(`Selected ${(own || part).label}`);
  };
  page.select = select;
}
