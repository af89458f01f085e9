// Checks of access and of safety: names, keyboard, contrast, small screens, motion, and what the page may load.

import { PATIENCE, SCENE, andSettles, assert, drop, equal, glb, openText, settled, start } from "./helpers.mjs";
import { lowContrast } from "./contrast.mjs";

const TABS = ["text", "scene", "explain", "check", "notes"];

/** Shows each state of the page, and calls `look(name)`. */
async function tour(page, base, look) {
  await start(page, base);
  await look("start");
  await openText(page, base);
  await page.fill("#text", SCENE.replace("radius = 1\n", "radus = 1\n"));
  await page.waitForSelector("#problems .error", { timeout: PATIENCE });
  await look("an error");
  await andSettles(page, () => page.fill("#text", SCENE.replace("#d02010", "#c01010")));
  for (const tab of TABS) {
    await page.click(`#tab-${tab}`);
    if (tab === "scene") {
      await page.click("[data-path='material.red']");
      await page.waitForSelector("#properties h2", { timeout: PATIENCE });
    }
    if (tab === "explain") {
      await page.click("#canvas");
      await page.waitForSelector(".explanation section:not([hidden]) .row", { timeout: PATIENCE });
    }
    if (tab === "check") {
      await page.click("#panel-check button");
      await page.waitForSelector("#panel-check button:text-is('Check again')", { timeout: PATIENCE });
    }
    await look(tab);
  }
  await page.click("#view");
  await page.waitForSelector("[role=menu]");
  await look("a menu");
  await page.keyboard.press("Escape");
  await page.click("#help");
  await look("help");
  await page.keyboard.press("Escape");
}

export async function every_control_has_a_name(page, base) {
  const session = await page.context().newCDPSession(page);
  const wanted = new Set(["button", "link", "textbox", "searchbox", "checkbox", "slider", "spinbutton", "combobox", "listbox", "option", "tab", "tabpanel", "menu", "menuitem", "menuitemradio", "dialog", "image", "application", "progressbar", "ColorWell"]);
  const missing = [];
  await tour(page, base, async where => {
    const { nodes } = await session.send("Accessibility.getFullAXTree");
    for (const node of nodes) {
      if (!node.ignored && wanted.has(node.role?.value) && !node.name?.value?.trim()) missing.push(`${where}: ${node.role.value}`);
    }
  });
  equal(missing.join(", "), "", "controls without a name");
}

export async function text_has_contrast_in_both_schemes(page, base) {
  const low = [];
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
    await tour(page, base, async where => {
      for (const { text, ratio } of await page.evaluate(lowContrast)) low.push(`${colorScheme}, ${where}: “${text}” ${ratio.toFixed(2)}`);
    });
  }
  equal(Array.from(new Set(low)).slice(0, 12).join("; "), "", "text with a contrast below AA");
}

export async function a_phone_needs_no_sideways_scrolling(page, base) {
  await page.setViewportSize({ width: 390, height: 844 });
  await tour(page, base, async where => {
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert(wide <= 390, `${where}: the page is ${wide} pixels wide on a phone of 390`);
  });
  await page.setViewportSize({ width: 320, height: 640 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert(wide <= 320, `the page is ${wide} pixels wide on a phone of 320`);
}

/** Presses Tab until `selector` has the focus; each stop must be visible and have an outline. */
async function tabTo(page, selector, most = 60) {
  for (let i = 0; i < most; i++) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(selector => {
      const element = document.activeElement;
      const box = element.getBoundingClientRect();
      const { outlineStyle, outlineWidth } = getComputedStyle(element);
      return {
        found: element.matches(selector), tag: element.tagName, id: element.id,
        seen: element.tagName === "BODY" || box.width > 0 && box.height > 0 && outlineStyle !== "none" && parseFloat(outlineWidth) >= 1,
      };
    }, selector);
    assert(at.seen, `the focus is not visible on ${at.tag} ${at.id}`);
    if (at.found) return;
  }
  throw new Error(`${selector} is not reached with Tab`);
}

export async function the_keyboard_alone_is_enough(page, base) {
  await start(page, base);
  await page.evaluate(() => document.body.focus());
  await tabTo(page, "#steps [data-start]");
  await page.keyboard.press("Enter");
  await settled(page);
  equal(await page.evaluate(() => document.activeElement.id), "canvas", "focus after a scene was opened");
  // From the picture to the panels and through them.
  await tabTo(page, "[role=tab][aria-selected=true]");
  await page.keyboard.press("ArrowRight");
  equal(await page.getAttribute("#tab-scene", "aria-selected"), "true", "the right arrow selects the next panel");
  await tabTo(page, "#outline");
  await page.waitForSelector("#outline [role=option]", { timeout: PATIENCE });
  await page.keyboard.press("ArrowDown");
  await page.waitForSelector("#properties h2", { timeout: PATIENCE });
  await tabTo(page, "#properties button, #properties select, #properties input");
  // Explain the pixel under a crosshair.
  await page.focus("#canvas");
  await page.keyboard.press("c");
  equal(await page.getAttribute("#crosshair", "hidden"), null, "hidden crosshair after C");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("e");
  await page.waitForSelector(".explanation section:not([hidden]) .row", { timeout: PATIENCE });
  // A menu opens, moves and closes, and gives the focus back.
  await page.focus("#save");
  await page.keyboard.press("Enter");
  await page.waitForSelector("[role=menu]");
  await page.keyboard.press("ArrowDown");
  equal((await page.evaluate(() => document.activeElement.textContent)).slice(0, 3), "EXR", "second entry of Save");
  await page.keyboard.press("Escape");
  equal(await page.evaluate(() => document.activeElement.id), "save", "focus after the menu");
  // The text lets the focus go; behind the last control Firefox goes on to its own.
  await page.click("#tab-text");
  await tabTo(page, "#text");
  await page.keyboard.press("Tab");
  assert(await page.evaluate(() => document.activeElement.id !== "text"), "the text keeps the focus");
}

export async function nothing_moves_with_reduced_motion(page, base) {
  await page.emulateMedia({ reducedMotion: "reduce" });
  await start(page, base);
  const moving = await page.evaluate(() => Array.from(document.querySelectorAll("*")).filter(element => {
    const { animationName, transitionDuration } = getComputedStyle(element);
    return animationName !== "none" || transitionDuration.split(",").some(time => parseFloat(time) > 0);
  }).length);
  equal(moving, 0, "elements with an animation or a transition");
}
nothing_moves_with_reduced_motion.options = { driver: "chromium" };

export async function nothing_is_loaded_from_elsewhere_and_the_console_is_empty(page, base) {
  const wrong = [];
  const origin = new URL(base).origin;
  const own = url => url === "about:blank" || /^(data|blob):/.test(url) || new URL(url).origin === origin;
  page.on("request", request => { if (!own(request.url())) wrong.push(`request to ${request.url()}`); });
  page.on("websocket", socket => { if (!own(socket.url().replace(/^ws/, "http"))) wrong.push(`socket to ${socket.url()}`); });
  page.on("console", line => {
    // The driver says that it blocks service workers.
    const isOwn = /blocked by Playwright/.test(line.text());
    if (!isOwn && (line.type() === "error" || line.type() === "warning")) wrong.push(`console: ${line.text()}`);
  });
  page.on("pageerror", error => wrong.push(`error: ${error.message}`));
  await page.addInitScript(() => addEventListener("securitypolicyviolation", event =>
    console.error(`violates ${event.violatedDirective}: ${event.blockedURI} ${event.sample}`)));
  await tour(page, base, async () => {});
  await andSettles(page, () => drop(page, [["triangle.glb", glb()]]));
  equal(Array.from(new Set(wrong)).join("; "), "", "what the page did");
  equal((await page.context().cookies()).length, 0, "cookies");
}

export async function the_policy_forbids_eval_inline_scripts_and_other_origins(page, base) {
  await start(page, base);
  const policy = await page.getAttribute("meta[http-equiv=Content-Security-Policy]", "content");
  const rules = new Map(policy.split(";").map(rule => rule.trim().split(/\s+/)).map(([name, ...values]) => [name, values]));
  equal(rules.get("default-src").join(" "), "'none'", "default-src");
  equal(rules.get("script-src").join(" "), "'self' 'wasm-unsafe-eval'", "script-src");
  equal(rules.get("connect-src").join(" "), "'self'", "connect-src");
  const ran = await page.evaluate(async () => {
    const script = document.createElement("script");
    script.textContent = "window.inlineRan = true";
    document.head.append(script);
    const button = document.createElement("div");
    button.setAttribute("onclick", "window.handlerRan = true");
    document.body.append(button);
    button.click();
    const fetched = await fetch("https://example.com/").then(() => true, () => false);
    return [Boolean(window.inlineRan), Boolean(window.handlerRan), fetched].join();
  });
  equal(ran, "false,false,false", "inline script, inline handler, request to another origin");
}

/** On a host without the headers that threads need, and without a service worker that adds them. */
export async function one_thread_renders_and_is_said(page, base) {
  await page.addInitScript(() => Object.defineProperty(navigator, "serviceWorker", { get: () => undefined }));
  await start(page, base);
  assert((await page.innerText("#host")).includes("Cross-Origin-Opener-Policy"), "the start page does not name the headers");
  await openText(page, base);
  assert((await page.innerText("#status-host")).startsWith("one thread"), "the status line does not say that one thread renders");
}
one_thread_renders_and_is_said.options = { plain: true };
