// The start page: the tutorial's steps and the gallery; and the text of a step above the editor.

import { find, make, words } from "./dom.js";
import { clear } from "./message.js";

export function setupStart(page) {
  let steps = [];
  page.on("ready", async () => {
    find("loading").hidden = true;
    const [tutorial, gallery] = await Promise.all([page.attempt("tutorial", {}), page.attempt("gallery", {})]);
    steps = tutorial?.steps || [];
    showSteps(page, steps);
    showGallery(page, gallery?.groups || []);
    if (page.origin.start) showStep(page, steps);
  });

  /** Opens a scene of the gallery or a step. `remember`: as a new entry of the browser's history. */
  page.openStart = async (id, remember = true) => {
    const opened = await page.open(`“${titleOf(id)}”`, { start: id }, () => page.call("open_start", { id }));
    if (opened && remember) page.remember({ start: id });
    return opened;
  };
  const titleOf = id => steps.find(step => step.id === id)?.title || document.querySelector(`[data-start="${CSS.escape(id)}"] .card-name`)?.textContent || id;

  page.on("opened", () => {
    showStep(page, steps);
    page.showPanel("text");
  });
}

function showSteps(page, steps) {
  const list = find("steps").querySelector("ol");
  list.replaceChildren(...steps.map((step, i) => make("li", {}, card(page, step.id, `${i + 1}. ${plain(step.title)}`, ""))));
  find("steps").hidden = !steps.length;
}

function showGallery(page, groups) {
  const box = find("gallery");
  box.replaceChildren(...groups.map(({ name, entries }) => make("section", {},
    make("h2", { text: name }),
    make("ul", { class: "cards" }, ...entries.map(entry => make("li", {}, card(page, entry.id, entry.name, entry.about)))))));
  box.hidden = !groups.length;
}

/** A picture and a name that open a scene. Links, so that they can be copied and opened in another tab. */
function card(page, id, name, about) {
  const picture = make("img", { src: `images/${encodeURIComponent(id)}.jpg`, width: "320", height: "200", loading: "lazy", alt: "" });
  const plain = make("span", { class: "no-picture", "aria-hidden": "true", text: name.replace(/^\d+\. /, "").slice(0, 1) });
  picture.addEventListener("error", () => picture.replaceWith(plain));
  const link = make("a", { class: "card", href: `?start=${encodeURIComponent(id)}`, "data-start": id }, picture,
    make("span", { class: "card-name", text: name }),
    about ? make("span", { class: "dim", text: about }) : null);
  link.addEventListener("click", event => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    clear();
    page.openStart(id);
  });
  return link;
}

/** The paragraphs of a step, and the way to its neighbours. */
function showStep(page, steps) {
  const box = find("step");
  const at = steps.findIndex(step => step.id === page.origin.start);
  box.hidden = at < 0;
  if (at < 0) return;
  const step = steps[at];
  const go = (to, label) => make("button", {
    type: "button", text: label, disabled: !steps[to],
    on: { click: async () => { if (await page.openStart(steps[to].id)) box.querySelector("h2").focus(); } },
  });
  box.replaceChildren(
    make("h2", { tabindex: "-1", text: `Step ${at + 1} of ${steps.length}: ${plain(step.title)}` }),
    make("div", { class: "paragraphs", tabindex: "0", role: "group", "aria-label": "Explanation of the step" }, ...step.text.map(paragraph)),
    make("p", { class: "buttons" }, go(at - 1, "Previous"), go(at + 1, "Next")));
}

/** A paragraph with `code` and **strong** words; a block of code stays as it is written. */
function paragraph(text) {
  const block = /^```\w*\n([^]*?)\n?```$/.exec(text.trim());
  if (block) return make("pre", { text: block[1] });
  return text.startsWith("> ") ? make("blockquote", {}, ...words(text.slice(2))) : make("p", {}, ...words(text));
}

/** A title without its number. */
const plain = title => title.replace(/^\d+\. */, "");
