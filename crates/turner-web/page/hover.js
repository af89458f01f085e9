// What a word of the text means: a tooltip below the pointer, or below the cursor with F1.

import { announce, find, later, make, words } from "./dom.js";
import { place } from "./highlight.js";

export function setupHover(page, area, painted) {
  const tip = make("div", { role: "tooltip", class: "tip", hidden: true });
  area.parentElement.append(tip);
  let turn = 0;
  const hide = () => { turn++; tip.hidden = true; };

  const show = async (at, x, y, spoken) => {
    const mine = ++turn;
    let answer;
    try {
      answer = await page.call("hover", { text: area.value, offset: at });
    } catch {
      return;
    }
    if (mine !== turn) return;
    if (!answer.title) {
      tip.hidden = true;
      if (spoken) announce("No explanation for this word");
      return;
    }
    const facts = [answer.range, answer.default ? `default ${answer.default}` : ""].filter(Boolean).join(" · ");
    tip.replaceChildren(
      make("b", { text: answer.title }),
      make("p", {}, ...words(answer.doc || "")),
      facts ? make("p", { class: "dim", text: facts }) : "");
    tip.hidden = false;
    const width = area.clientWidth;
    tip.style.left = `${Math.max(4, Math.min(x, width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${y + tip.offsetHeight > area.clientHeight ? Math.max(4, y - tip.offsetHeight - 24) : y}px`;
    if (spoken) announce(tip.textContent);
  };

  /** The line height and the width of a character, CSS pixels. */
  const metrics = () => {
    const style = getComputedStyle(area);
    const context = document.createElement("canvas").getContext("2d");
    context.font = `${style.fontSize} ${style.fontFamily}`;
    return { height: parseFloat(style.lineHeight), width: context.measureText("0").width, left: parseFloat(style.paddingLeft), top: parseFloat(style.paddingTop) };
  };

  const wait = later(350, (x, y) => {
    const { height, width, left, top } = metrics();
    const line = Math.floor((y + area.scrollTop - top) / height);
    const column = Math.floor((x + area.scrollLeft - left) / width);
    const lines = area.value.split("\n");
    if (line < 0 || line >= lines.length || column < 0 || column >= lines[line].length) { hide(); return; }
    const at = lines.slice(0, line).reduce((sum, text) => sum + text.length + 1, 0) + column;
    show(at, x + 8, (line + 1) * height + top - area.scrollTop + 4, false);
  });

  area.addEventListener("pointermove", event => {
    if (event.pointerType === "touch" || event.buttons) return;
    const box = area.getBoundingClientRect();
    wait(event.clientX - box.left, event.clientY - box.top);
  });
  area.addEventListener("pointerleave", () => { wait.cancel(); hide(); });
  for (const event of ["input", "blur", "scroll", "pointerdown"]) area.addEventListener(event, hide);
  area.addEventListener("keydown", event => {
    if (event.key === "Escape") hide();
    if (event.key !== "F1" || !find("completions").hidden) return;
    event.preventDefault();
    const { height, width, left, top } = metrics();
    const { line, column } = place(area.value, area.selectionStart);
    show(area.selectionStart, left + (column - 1) * width - area.scrollLeft, line * height + top - area.scrollTop + 4, true);
  });
  painted.addEventListener("scroll", () => { painted.scrollTop = 0; });
}
