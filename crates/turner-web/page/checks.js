// What the doctor finds, and the warnings of the scene.

import { announce, find, make, sentence, words } from "./dom.js";
import { position } from "./message.js";

const SEVERITIES = { error: "Error", warning: "Warning", note: "Note", info: "Note", hint: "Hint" };

export function setupChecks(page) {
  doctor(page, find("panel-check"));
  notes(page, find("panel-notes"));
}

/** The doctor renders a little: it runs when it is asked. */
function doctor(page, panel) {
  const results = make("div", { class: "findings" });
  const button = make("button", { type: "button", class: "main", text: "Check the scene", on: { click: run } });
  panel.append(
    make("p", { text: "Finds out why a picture is black, noisy, washed out or slow, and offers remedies." }),
    make("p", { class: "buttons" }, button), results);
  let turn = 0;

  page.on("opened", () => { turn++; results.replaceChildren(); page.countPanel("check", 0); });

  async function run() {
    const mine = ++turn;
    button.disabled = true;
    results.replaceChildren(make("p", { class: "dim", text: "Checking …" }));
    try {
      const { findings } = await page.call("doctor", {});
      if (mine !== turn) return;
      results.replaceChildren(...findings.map(finding));
      if (!findings.length) results.append(make("p", { text: "Nothing found: the scene is well lit, and renders without needless noise." }));
      page.countPanel("check", findings.length);
      announce(findings.length ? `${findings.length} findings` : "Nothing found");
    } catch (error) {
      if (mine === turn) results.replaceChildren(make("p", { class: "wrong", text: error.message }), make("p", { text: error.help || "" }));
    } finally {
      button.disabled = false;
      button.textContent = "Check again";
    }
  }

  /** `edits`: those of each remedy; a finding can have several. */
  function finding({ severity, message, why, help, edits = [] }) {
    const remedies = typeof edits[0]?.[0] === "string" ? [edits] : edits.filter(remedy => remedy.length);
    const buttons = remedies.map(remedy => make("button", {
      type: "button", text: `Set ${remedy.map(([path, value]) => `${path} = ${JSON.stringify(value)}`).join(", ").slice(0, 90)}`,
      on: { click: async () => { if (await page.attempt("set", { edits: remedy, label: "Remedy of the doctor", merge: null })) run(); } },
    }));
    return make("article", { class: `finding ${severity}` },
      make("p", {}, make("b", { text: `${SEVERITIES[severity] || severity}: ` }), ...words(sentence(message))),
      why ? make("p", { class: "dim" }, ...words(sentence(why))) : null,
      help ? make("p", { class: "dim" }, ...words(sentence(help))) : null,
      buttons.length ? make("p", { class: "buttons" }, ...buttons) : null);
  }
}

function notes(page, panel) {
  page.on("document", ({ warnings = [], triangles, integrator, film }) => {
    const items = warnings.map(warning => make("li", {},
      make("b", { text: `${warning.kind}: ` }), warning.message,
      warning.file || warning.line ? make("span", { class: "dim place", text: position(warning) }) : null));
    const facts = [
      film ? `${film.width} × ${film.height} pixels, ${film.samples} samples` : "",
      integrator ? `integrator ${integrator}` : "",
      triangles ? `${triangles.toLocaleString("en")} triangles` : "",
    ].filter(Boolean).join(" · ");
    panel.replaceChildren(
      make("p", { class: "dim", text: facts }),
      items.length ? make("ul", { class: "notes" }, ...items) : make("p", { text: "No warnings: the whole scene is rendered as it is written." }));
    page.countPanel("notes", warnings.length);
  });
}
