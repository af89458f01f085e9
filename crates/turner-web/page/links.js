// Links: a scene in the address, a scene of the gallery, and a pixel that is explained.

import { announce, find, later, make } from "./dom.js";
import { fail, tell } from "./message.js";
import { deflate, inflate } from "./zip.js";

/** Most bytes of compressed text in a link: longer addresses are cut off by mail programs and chats. */
const MOST = 8192;
/** Most bytes of text that a link may expand to. */
const EXPANDED = 2 ** 20;

export function setupLinks(page) {
  find("share").addEventListener("click", () => share(page));

  /** Goes to the start page; the browser's Back returns to the scene. */
  page.goStart = () => {
    if (page.state === "start") return;
    history.pushState({ state: "start" }, "", bare());
    page.show("start");
  };

  /** Puts what was opened into the address. */
  page.remember = ({ start }) => {
    const address = bare(start ? { start } : {});
    if (history.state?.state !== "scene" || location.href !== address.href) history.pushState({ state: "scene" }, "", address);
    page.shown = location.href;
  };

  // An edited scene is kept in the address: a reload does not lose it, and the address is the link.
  const keep = later(1000, async () => {
    if (page.state !== "scene" || page.document.text === null || page.document.text === page.origin.text && !location.hash) return;
    const { address } = await addressOf(page);
    if (!address || page.state !== "scene") return;
    history.replaceState({ state: "scene" }, "", address);
    page.shown = location.href;
  });
  page.on("document", keep);
  page.on("opened", () => { keep.cancel(); page.shown = location.href; });

  addEventListener("popstate", ({ state }) => {
    const asks = location.hash.startsWith("#s=") || /[?&]start=/.test(location.search);
    if (asks && location.href !== page.shown) follow(page);
    else if (asks || state?.state === "scene") page.show("scene");
    else page.show("start");
  });
  // A link that is pasted while the page is open.
  addEventListener("hashchange", () => { if (location.hash.startsWith("#s=")) follow(page); });

  page.ready.then(() => follow(page), () => {});
}

/** Opens what the address asks for. */
async function follow(page) {
  const query = new URLSearchParams(location.search);
  let opened = false;
  if (location.hash.startsWith("#s=")) {
    const packed = location.hash.slice(3);
    const start = query.get("start");
    opened = await page.open("the scene of the link", start ? { start, edited: true } : { link: true }, async () => {
      const bytes = await unpack(packed);
      // An edited scene of the gallery keeps the gallery's files.
      if (start) {
        await page.call("open_start", { id: start });
        await page.call("set_text", { text: new TextDecoder().decode(bytes) });
      } else {
        await page.call("open", { main: "scene.toml" }, [{ name: "scene.toml", bytes }]);
      }
    });
  } else if (query.has("start")) {
    opened = await page.openStart(query.get("start"), false);
  } else if (page.document) {
    // `turner serve SCENE` has a scene already.
    page.show("scene");
    opened = true;
  }
  if (!opened || !query.has("explain")) return;
  const [x, y] = (query.get("explain") || "").split(",").map(Number);
  const film = page.document?.film;
  if (film && Number.isInteger(x) && Number.isInteger(y) && x >= 0 && y >= 0 && x < film.width && y < film.height) page.explain(x, y);
  else fail(Object.assign(new Error(`the link explains the pixel “${query.get("explain").slice(0, 40)}”, which is not in the picture`), { help: film ? `Columns go from 0 to ${film.width - 1}, rows from 0 to ${film.height - 1}.` : "" }));
}

async function unpack(packed) {
  const broken = help => Object.assign(new Error("the link is damaged: its scene cannot be read"), { help });
  const help = "Copy the whole link again: mail programs cut long lines.";
  if (packed.length > Math.ceil(MOST * 4 / 3)) throw broken(`A link holds at most ${MOST} bytes of compressed text. ${help}`);
  let text;
  try {
    const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), c => c.charCodeAt(0));
    text = await inflate(bytes, EXPANDED);
  } catch {
    throw broken(help);
  }
  if (!text) throw broken(`The text of a link has at most ${EXPANDED} bytes.`);
  return text;
}

export async function pack(text) {
  const bytes = await deflate(new TextEncoder().encode(text));
  if (bytes.length > MOST) return { bytes: bytes.length, packed: null };
  const packed = btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  return { bytes: bytes.length, packed };
}

/** The address of the page with other parameters; the token of `turner serve` is in its path. */
function bare(parameters = {}) {
  const address = new URL(location.pathname, location.href);
  for (const [key, value] of Object.entries(parameters)) address.searchParams.set(key, value);
  return address;
}

/** The address that opens the scene as it is: {address}, or {error} if there is none. */
async function addressOf(page) {
  const { document: scene, origin, explained } = page;
  const link = bare(origin.start ? { start: origin.start } : {});
  if (explained) link.searchParams.set("explain", `${explained.x},${explained.y}`);
  const isOriginal = scene.text === null ? !scene.changed : scene.text === origin.text;
  if (!origin.start || !isOriginal) {
    const text = scene.text ?? (await page.call("text", {})).text;
    const missing = (origin.files || []).filter(name => text.includes(name.split("/").pop()));
    if (missing.length) {
      return refuse(`the scene reads ${missing.slice(0, 3).join(", ")}${missing.length > 3 ? " …" : ""}, and a link holds only text`, "Send the files themselves, as a folder or a zip file.");
    }
    const { bytes, packed } = await pack(text);
    if (!packed) {
      return refuse(`the text of this scene has ${bytes.toLocaleString("en")} bytes when compressed; a link holds at most ${MOST.toLocaleString("en")}`, "Save it as TOML, and send the file.");
    }
    link.hash = `s=${packed}`;
  }
  // The comma of a pixel is legal as it is.
  return { address: link.href.replace("%2C", ",") };
}

const refuse = (message, help) => ({ error: Object.assign(new Error(message), { help }) });

async function share(page) {
  await page.editor.flush();
  let found;
  try {
    found = await addressOf(page);
  } catch (error) {
    found = { error };
  }
  if (found.error) {
    fail(found.error, "Cannot make a link");
    return;
  }
  try {
    await navigator.clipboard.writeText(found.address);
    tell("The link is copied.");
  } catch {
    show(found.address);
  }
}

/** Where the browser does not let the page copy. */
function show(address) {
  const dialog = find("dialog");
  const field = make("textarea", { readonly: true, rows: "4", "aria-label": "Link to this scene", class: "address" });
  field.value = address;
  dialog.replaceChildren(
    make("h2", { id: "dialog-title", text: "Link to this scene" }),
    make("p", { text: "Copy this address." }), field,
    make("p", { class: "buttons" }, make("button", { type: "button", class: "main", text: "Close", on: { click: () => dialog.close() } })));
  dialog.showModal();
  field.select();
  announce("The link is selected: copy it");
}
