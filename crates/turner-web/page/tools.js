// The toolbar: files, undo, the view, and shortcuts of the whole page.

import { announce, download, find, make } from "./dom.js";
import { fail } from "./message.js";
import { menu } from "./menu.js";

const SHORTCUTS = [
  ["The page", [
    ["Ctrl O", "Open files"], ["Ctrl S", "Save the scene as TOML"], ["Ctrl Z", "Undo"], ["Ctrl Shift Z", "Redo"],
    ["Escape", "Close a message or a menu"], ["?", "This list"],
  ]],
  ["The picture", [
    ["Arrow keys", "Orbit"], ["Shift arrow keys", "Move the picture"], ["+ and −", "Nearer, farther"], ["F", "Frame all objects"],
    ["C", "Crosshair, moved by the arrow keys"], ["Enter", "Select below the crosshair"], ["E", "Explain the pixel"], ["Escape", "Hide the crosshair"],
  ]],
  ["The text", [
    ["Ctrl Space", "Completions"], ["F1", "Explain the word at the cursor"], ["F8", "Next error"], ["Tab", "Next control (accepts a completion)"],
  ]],
];
const DISPLAYS = [["picture", "Picture"], ["false-color", "False colours"], ["noise", "Noise"]];

export function setupTools(page) {
  page.paused = false;
  let view = { integrator: null, display: "picture" };

  menu(find("open"), () => [
    { label: "Files…", detail: "or a zip file", act: () => page.chooseFiles() },
    { label: "Folder…", detail: "pbrt, Mitsuba, glTF", act: () => page.chooseFolder() },
    null,
    { label: "Start page", act: () => page.goStart() },
  ]);

  const save = async format => {
    announce(`Saving ${format}`);
    const saved = await page.attempt("save", { format }, "Cannot save");
    if (!saved) return;
    download(saved.name, saved.bytes);
    if (saved.settled === false) page.tell(`${saved.name} is saved as far as it is rendered. Save it again when the status line says “finished”.`);
  };
  menu(find("save"), () => [
    { label: "PNG", detail: "the picture", act: () => save("png") },
    { label: "EXR", detail: "the picture, all of its light", act: () => save("exr") },
    { label: "JPEG", detail: "the picture, small", act: () => save("jpg") },
    null,
    { label: "TOML", detail: "the scene", disabled: page.document?.text === null, act: () => save("toml") },
  ]);

  const change = async next => {
    view = { ...view, ...next };
    await page.attempt("view", view);
  };
  menu(find("view"), async () => {
    const { items } = await page.call("integrators");
    const displays = DISPLAYS.map(([display, label]) =>
      ({ label, checked: view.display === display, act: () => change({ display }) }));
    const own = { label: "The scene’s integrator", detail: page.document?.integrator, checked: view.integrator === null, act: () => change({ integrator: null }) };
    const rest = items.filter(item => item.name && item.name !== page.document?.integrator).map(item =>
      ({ label: item.name, detail: /^.*?[.:](?= |$)/.exec(item.doc || "")?.[0].replace(/[.:]$/, ""), checked: view.integrator === item.name, act: () => change({ integrator: item.name }) }));
    return [...displays, null, own, ...rest];
  });
  page.on("opened", () => { view = { integrator: null, display: "picture" }; });

  const pause = find("pause");
  const setPaused = paused => {
    page.paused = paused;
    pause.setAttribute("aria-pressed", String(paused));
    pause.querySelector(".label").textContent = paused ? "Continue" : "Pause";
    page.attempt("view", { paused });
  };
  pause.addEventListener("click", () => setPaused(!page.paused));
  page.on("opened", () => { if (page.paused) setPaused(false); });
  // Nothing is rendered for a picture that is not shown.
  page.on("shown", state => {
    if (page.document && !page.looksOn) page.attempt("view", { paused: page.paused || state === "start" });
  });

  page.undo = async word => {
    if (word === "undo" && page.editor.waiting) {
      page.editor.discard();
      announce("The text is again that of the scene");
      showUndo();
      return;
    }
    if (!page.document?.[word]) {
      announce(`Nothing to ${word}`);
      return;
    }
    const done = await page.attempt(word, {});
    if (done?.label) announce(`${word === "undo" ? "Undone" : "Done again"}: ${done.label}`);
  };
  for (const word of ["undo", "redo"]) find(word).addEventListener("click", () => page.undo(word));
  const showUndo = () => {
    const steps = { undo: page.editor.waiting ? "what was typed" : page.document?.undo, redo: page.document?.redo };
    for (const [word, step] of Object.entries(steps)) {
      const button = find(word);
      // A button that loses its use keeps the focus.
      button.disabled = !step && button !== document.activeElement;
      button.setAttribute("aria-disabled", String(!step));
      button.title = step ? `${button.textContent}: ${step}` : "";
    }
  };
  page.on("document", showUndo);
  page.on("opened", showUndo);
  page.on("typed", showUndo);

  find("frame").addEventListener("click", () => page.attempt("frame", { object: null }));
  find("to-start").addEventListener("click", () => page.goStart());
  find("help").addEventListener("click", showHelp);
  page.on("problem", error => fail(error));
  shortcuts(page, save);
}

function shortcuts(page, save) {
  addEventListener("keydown", event => {
    const control = event.ctrlKey || event.metaKey;
    const inText = /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName);
    const key = event.key.toLowerCase();
    if (control && key === "o") page.chooseFiles();
    else if (control && key === "s" && page.state === "scene") save("toml");
    else if (control && key === "z" && page.state === "scene" && !ownUndo(page, event.target)) page.undo(event.shiftKey ? "redo" : "undo");
    else if (control && key === "y" && page.state === "scene" && !ownUndo(page, event.target)) page.undo("redo");
    else if (event.key === "?" && !inText) showHelp();
    else return;
    event.preventDefault();
  });
}

/** Text that is not part of the scene yet is undone by the browser. */
const ownUndo = (page, target) => target.id === "text" ? page.editor.waiting : /^(INPUT|SELECT)$/.test(target.tagName) && target.type !== "range";

function showHelp() {
  const dialog = find("dialog");
  if (dialog.open) return;
  const mac = /Mac|iPhone|iPad/.test(navigator.userAgent);
  const keys = text => text.split(" ").map(word => /^(and|keys)$/.test(word) ? ` ${word} ` : make("kbd", { text: mac && word === "Ctrl" ? "⌘" : word }));
  const groups = SHORTCUTS.map(([title, rows]) => make("section", {},
    make("h3", { text: title }),
    make("dl", {}, ...rows.flatMap(([key, what]) => [make("dt", {}, ...keys(key)), make("dd", { text: what })]))));
  dialog.replaceChildren(
    make("h2", { id: "dialog-title", text: "Keyboard and mouse" }),
    make("p", { text: "In the picture: drag to orbit, drag with Shift or the middle button to move the picture, drag with the right button to look around, turn the wheel or pinch to move nearer. A click selects; while the panel Explain is open it explains the pixel." }),
    make("div", { class: "columns" }, ...groups),
    make("p", { class: "buttons" }, make("button", { type: "button", class: "main", text: "Close", on: { click: () => dialog.close() } })));
  dialog.showModal();
}
