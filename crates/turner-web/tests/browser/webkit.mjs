// WebKit, as GNOME ships it, by WebDriver (W3C Recommendation): what the checks use of Playwright's pages.
//
// The driver has no word for some of it, e.g. to answer requests in place of a server; `Unsupported` is thrown then.
import { spawn } from "node:child_process";
import { createServer } from "node:net";

/** Thrown by what the driver cannot do. */
export class Unsupported extends Error {}

/** The name of an element in answers. */
const ELEMENT = "element-6066-11e4-a52e-4f735466cecf";

const BROWSER = {
  binary: process.env.MINI_BROWSER ?? "/usr/lib/x86_64-linux-gnu/webkit2gtk-4.1/MiniBrowser",
  args: ["--automation"],
};

const KEYS = {
  Enter: "\uE007", Tab: "\uE004", Escape: "\uE00C", Backspace: "\uE003", Delete: "\uE017", Space: " ", Home: "\uE011", End: "\uE010",
  ArrowLeft: "\uE012", ArrowUp: "\uE013", ArrowRight: "\uE014", ArrowDown: "\uE015", PageUp: "\uE00E", PageDown: "\uE00F",
  Shift: "\uE008", Control: "\uE009", Alt: "\uE00A",
};

const pause = ms => new Promise(resolve => setTimeout(resolve, ms));

/** A browser whose contexts are sessions of a driver. */
export async function launch(program) {
  const port = await new Promise(resolve => {
    const server = createServer().listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
  const driver = spawn(program, [`--port=${port}`], { stdio: "ignore" });
  const call = async (method, path, body) => {
    const answer = await fetch(`http://127.0.0.1:${port}${path}`, { method, body: body && JSON.stringify(body) });
    const { value } = await answer.json();
    if (value?.error) throw new Error(`${value.error}: ${value.message}`);
    return value;
  };
  for (let left = 50; ; left--) {
    try {
      await call("GET", "/status");
      break;
    } catch (error) {
      if (!left) throw error;
      await pause(100);
    }
  }
  const session = async () => {
    const wanted = { alwaysMatch: { "webkitgtk:browserOptions": BROWSER } };
    const { sessionId, capabilities } = await call("POST", "/session", { capabilities: wanted });
    await call("POST", `/session/${sessionId}/timeouts`, { script: 120_000, pageLoad: 60_000 });
    const own = (method, path, body) => call(method, `/session/${sessionId}${path}`, body);
    return { own, version: capabilities.browserVersion };
  };
  const first = await session();
  await first.own("DELETE", "");
  return {
    version: () => first.version,
    newContext: async ({ serviceWorkers, acceptDownloads, ...other }) => {
      if (Object.keys(other).length) throw new Unsupported(Object.keys(other).join(", "));
      const { own } = await session();
      return { newPage: async () => lacking(new Page(own), "page"), close: () => own("DELETE", "") };
    },
    close: async () => driver.kill(),
  };
}

/** An object whose missing methods throw `Unsupported`. */
function lacking(object, name) {
  return new Proxy(object, {
    get: (target, key) => {
      if (key in target || typeof key === "symbol" || key === "then") {
        const value = target[key];
        return typeof value === "function" ? value.bind(target) : value;
      }
      return () => { throw new Unsupported(`${name}.${key}`); };
    },
  });
}

/** A page: see Playwright's class of this name. */
class Page {
  constructor(own) {
    this.own = own;
    const press = async combination => {
      const keys = combination.split(/\+(?=.)/).map(key => KEYS[key] ?? key);
      const down = keys.map(value => ({ type: "keyDown", value }));
      await this.act({ type: "key", id: "keys", actions: [...down, ...keys.reverse().map(value => ({ type: "keyUp", value }))] });
    };
    const type = text => this.act({
      type: "key", id: "keys",
      actions: [...text].flatMap(value => [{ type: "keyDown", value }, { type: "keyUp", value }]),
    });
    this.keyboard = lacking({ press, type }, "page.keyboard");
    const mouse = action => this.act({ type: "pointer", id: "mouse", parameters: { pointerType: "mouse" }, actions: [action] });
    this.mouse = lacking({
      move: (x, y) => mouse({ type: "pointerMove", duration: 20, x: Math.round(x), y: Math.round(y) }),
      down: () => mouse({ type: "pointerDown", button: 0 }),
      up: () => mouse({ type: "pointerUp", button: 0 }),
    }, "page.mouse");
  }

  act(source) {
    return this.own("POST", "/actions", { actions: [source] });
  }

  async goto(url) {
    await this.own("POST", "/url", { url });
  }

  async reload() {
    await this.own("POST", "/refresh", {});
  }

  async goBack() {
    await this.own("POST", "/back", {});
  }

  waitForTimeout(ms) {
    return pause(ms);
  }

  /** Runs a function in the page. As in Playwright, an error there is thrown here. */
  async evaluate(work, argument = null) {
    const script = `
      const done = arguments[arguments.length - 1];
      (async () => (${work})(...arguments))().then(
        value => done({ value: value === undefined ? null : value }),
        error => done({ error: String(error?.stack ?? error) + " " + (error?.message ?? "") }));`;
    const { value, error } = await this.own("POST", "/execute/async", { script, args: [argument] });
    if (error) throw new Error(error);
    return value;
  }

  async waitForFunction(work, argument = null, { timeout = 30_000 } = {}) {
    for (const begun = Date.now(); ;) {
      if (await this.evaluate(`async argument => Boolean(await (${work})(argument))`, argument)) return;
      if (Date.now() - begun > timeout) throw new Error(`timeout: ${work}`);
      await pause(50);
    }
  }

  /** Waits for an element that is seen, or in `state` "attached" or "hidden". */
  async waitForSelector(selector, { timeout = 30_000, state = "visible" } = {}) {
    if (!["visible", "attached", "hidden"].includes(state)) throw new Unsupported(state);
    await this.waitForFunction(([selector, state]) => {
      const found = document.querySelector(selector);
      const box = found?.getBoundingClientRect();
      const seen = Boolean(box && box.width && box.height && getComputedStyle(found).visibility === "visible");
      return state === "attached" ? Boolean(found) : seen === (state === "visible");
    }, [checked(selector), state], { timeout });
  }

  async element(selector) {
    await this.waitForSelector(selector, { state: "attached" });
    return (await this.own("POST", "/element", { using: "css selector", value: selector }))[ELEMENT];
  }

  async click(selector, options = {}) {
    if (Object.keys(options).length) throw new Unsupported(`click with ${Object.keys(options)}`);
    const [, plain, text] = /^(.*):text-is\(["'](.*)["']\)$/.exec(selector) ?? [];
    if (text) {
      await new Locator(this, [plain, text, true]).click();
      return;
    }
    await this.waitForSelector(selector);
    await this.own("POST", `/element/${await this.element(selector)}/click`, {});
  }

  async fill(selector, text) {
    await this.focus(selector);
    await this.evaluate(([selector, text]) => {
      const field = document.querySelector(selector);
      field.value = text;
      field.dispatchEvent(new Event("input", { bubbles: true }));
      field.dispatchEvent(new Event("change", { bubbles: true }));
    }, [checked(selector), text]);
  }

  locator(selector, { hasText = "" } = {}) {
    if (typeof hasText !== "string") throw new Unsupported(`a locator with ${hasText}`);
    return lacking(new Locator(this, [selector, hasText, false]), "locator");
  }

  async setInputFiles(selector, file) {
    if (typeof file !== "string") throw new Unsupported("files without a path");
    await this.own("POST", `/element/${await this.element(selector)}/value`, { text: file });
  }

  async focus(selector) {
    await this.waitForSelector(selector);
    await this.evaluate(selector => document.querySelector(selector).focus(), selector);
  }

  async inputValue(selector) {
    await this.waitForSelector(selector, { state: "attached" });
    return this.evaluate(selector => document.querySelector(selector).value, selector);
  }

  async innerText(selector) {
    await this.waitForSelector(selector, { state: "attached" });
    return this.evaluate(selector => document.querySelector(selector).innerText, selector);
  }

  async getAttribute(selector, name) {
    await this.waitForSelector(selector, { state: "attached" });
    return this.evaluate(([selector, name]) => document.querySelector(selector).getAttribute(name), [selector, name]);
  }
}

/** The elements of a selector, in the page; perhaps those alone that hold a text, or whose text it is. */
const ALL = `([selector, text, whole]) => [...document.querySelectorAll(selector)].filter(
  e => !text || (whole ? e.textContent.trim() === text : e.textContent.includes(text)))`;

/** Such elements, or one of them: see Playwright's class of this name. */
class Locator {
  constructor(page, what, index = 0) {
    checked(what[0]);
    Object.assign(this, { page, what, index });
  }

  first() {
    return this.nth(0);
  }

  nth(index) {
    return lacking(new Locator(this.page, this.what, index), "locator");
  }

  count() {
    return this.page.evaluate(`what => (${ALL})(what).length`, this.what);
  }

  allInnerTexts() {
    return this.page.evaluate(`what => (${ALL})(what).map(e => e.innerText)`, this.what);
  }

  /** What a function makes of the element. */
  async of(work) {
    await this.page.waitForFunction(`([what, i]) => (${ALL})(what)[i]`, [this.what, this.index]);
    return this.page.evaluate(`([what, i]) => (${work})((${ALL})(what)[i])`, [this.what, this.index]);
  }

  isVisible() {
    return this.of(e => e.getClientRects().length > 0);
  }

  async isHidden() {
    return !await this.isVisible();
  }

  innerText() {
    return this.of(e => e.innerText);
  }

  getAttribute(name) {
    return this.of(`e => e.getAttribute(${JSON.stringify(name)})`);
  }

  isDisabled() {
    return this.of(e => e.disabled === true);
  }

  focus() {
    return this.of(e => e.focus());
  }

  boundingBox() {
    return this.of(e => {
      const { x, y, width, height } = e.getBoundingClientRect();
      return { x, y, width, height };
    });
  }

  async click() {
    await this.of(e => e.scrollIntoView({ block: "nearest" }));
    const { x, y, width, height } = await this.boundingBox();
    await this.page.mouse.move(x + width / 2, y + height / 2);
    await this.page.mouse.down();
    await this.page.mouse.up();
  }
}

/** A selector, if it is one of CSS. */
function checked(selector) {
  if (/^(text|xpath|role)=|>>|:has-text|:visible|:text/.test(selector)) throw new Unsupported(`the selector ${selector}`);
  return selector;
}
