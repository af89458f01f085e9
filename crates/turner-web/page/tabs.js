// The panels beside the picture: one is shown at a time.

import { find } from "./dom.js";

export function setupTabs(page) {
  const list = find("tabs");
  const tabs = Array.from(list.querySelectorAll("[role=tab]"));
  const name = tab => tab.id.slice("tab-".length);

  page.panel = "text";
  page.showPanel = wanted => {
    page.panel = wanted;
    for (const tab of tabs) {
      const on = name(tab) === wanted;
      tab.setAttribute("aria-selected", String(on));
      tab.tabIndex = on ? 0 : -1;
      find(tab.getAttribute("aria-controls")).hidden = !on;
    }
    page.emit("panel", wanted);
  };

  /** The number beside a tab's name, such as that of the warnings. */
  page.countPanel = (panel, count) => {
    const tab = find(`tab-${panel}`);
    tab.dataset.count = count || "";
    const word = tab.firstChild.textContent;
    if (count) tab.setAttribute("aria-label", `${word}, ${count}`);
    else tab.removeAttribute("aria-label");
  };

  for (const tab of tabs) tab.addEventListener("click", () => page.showPanel(name(tab)));
  list.addEventListener("keydown", event => {
    const now = tabs.findIndex(tab => tab.tabIndex === 0);
    const last = tabs.length - 1;
    const to = { ArrowRight: now === last ? 0 : now + 1, ArrowLeft: now ? now - 1 : last, Home: 0, End: last }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    page.showPanel(name(tabs[to]));
    tabs[to].focus();
  });
}
