// The camera and the pixels by hand: mouse, touch, wheel and keyboard.

import { announce, find, later } from "./dom.js";

/** Radians for a drag over the picture's height; the same as in Turner Studio. */
const TURN = 3;
/** A press that moves less is a click, CSS pixels. */
const CLICK = 4;
/** Steps of the keys: radians, fractions of the height, factor. */
const STEP = { turn: 0.12, pan: 0.04, dolly: 0.9 };

export function setupGestures(page, view) {
  const { canvas } = view;
  const camera = new Camera(page);
  const pointers = new Map();
  let pressed = null;

  const height = () => canvas.clientHeight || 1;

  canvas.addEventListener("pointerdown", event => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 1) pressed = { x: event.clientX, y: event.clientY, button: event.button, moved: false };
    else if (pressed) pressed.moved = true;
  });

  canvas.addEventListener("pointermove", event => {
    const last = pointers.get(event.pointerId);
    if (!last) {
      value(event);
      return;
    }
    const now = { x: event.clientX, y: event.clientY };
    if (pressed && !pressed.moved && Math.hypot(now.x - pressed.x, now.y - pressed.y) < CLICK) return;
    if (pressed) pressed.moved = true;
    if (pointers.size === 2) pinch(event.pointerId, last, now);
    else drag((now.x - last.x) / height(), (now.y - last.y) / height(), event);
    pointers.set(event.pointerId, now);
  });

  const release = event => {
    if (!pointers.delete(event.pointerId) || pointers.size) return;
    if (pressed?.moved) camera.end();
    else if (event.type === "pointerup" && pressed?.button === 0) click(view.at(event.clientX, event.clientY));
    pressed = null;
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", event => event.preventDefault());

  function drag(right, down, event) {
    if (pressed.button === 1 || event.shiftKey) camera.move("pan", right, -down);
    else if (pressed.button === 2) camera.move("look", right * TURN, -down * TURN);
    else camera.move("orbit", right * TURN, -down * TURN);
  }

  /** Two fingers: their middle moves the picture, their distance the camera. */
  function pinch(id, last, now) {
    const other = Array.from(pointers).find(([key]) => key !== id)[1];
    const before = Math.hypot(last.x - other.x, last.y - other.y);
    const after = Math.hypot(now.x - other.x, now.y - other.y);
    camera.move("pan", (now.x - last.x) / 2 / height(), -(now.y - last.y) / 2 / height());
    if (before > 1 && after > 1) camera.move("dolly", clamp(before / after, 0.5, 2));
  }

  const rest = later(250, () => camera.end());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    camera.move("dolly", clamp(1 + event.deltaY * lines * 0.002, 0.5, 2));
    rest();
  }, { passive: false });

  function click(pixel) {
    if (!pixel) return;
    if (page.panel === "explain") page.explain(Math.floor(pixel.x), Math.floor(pixel.y));
    else page.pick(pixel);
  }

  keyboard(page, view, camera, rest, click);

  // The value of the pixel under the pointer; one question at a time.
  let asking = false;
  async function value(event) {
    const pixel = view.at(event.clientX, event.clientY);
    if (!pixel || asking || event.pointerType === "touch") return;
    asking = true;
    try {
      const { linear } = await page.call("value", { x: Math.floor(pixel.x), y: Math.floor(pixel.y) });
      const numbers = linear.slice(0, 3).map(x => x.toPrecision(3)).join(", ");
      find("status-pixel").textContent = `pixel ${Math.floor(pixel.x)}, ${Math.floor(pixel.y)}: ${numbers}`;
    } catch {
      find("status-pixel").textContent = "";
    }
    asking = false;
  }
  canvas.addEventListener("pointerleave", () => { find("status-pixel").textContent = ""; });
  page.on("panel", panel => {
    const touch = matchMedia("(pointer: coarse)").matches;
    const act = panel === "explain" ? "explain" : "select";
    const looksOn = `The owner of the server moves the camera · ${touch ? "tap" : "click"}: ${act}`;
    find("hint").textContent = page.looksOn ? looksOn : touch
      ? `Drag: orbit · two fingers: pan, nearer · tap: ${act}`
      : `Drag: orbit · Shift and drag: pan · wheel: nearer · click: ${act}`;
    canvas.classList.toggle("explains", panel === "explain");
  });
}

/** Keys while the picture has the focus. */
function keyboard(page, view, camera, rest, click) {
  const { canvas } = view;
  const cross = find("crosshair");
  let pixel = null;

  const middle = () => ({ x: view.film.width / 2, y: view.film.height / 2 });
  const show = at => {
    pixel = at;
    cross.hidden = !at;
    if (at) view.put(cross, at.x, at.y);
  };
  const explain = () => {
    const at = pixel || middle();
    page.explain(Math.floor(at.x), Math.floor(at.y));
  };
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

  canvas.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow && pixel) {
      const step = event.shiftKey ? 1 : Math.max(1, Math.round(view.film.width / 60));
      const to = { x: clamp(pixel.x + arrow[0] * step, 0.5, view.film.width - 0.5), y: clamp(pixel.y - arrow[1] * step, 0.5, view.film.height - 0.5) };
      show(to);
      announce(`${Math.floor(to.x)}, ${Math.floor(to.y)}`);
    } else if (arrow) {
      if (event.shiftKey) camera.move("pan", -arrow[0] * STEP.pan, -arrow[1] * STEP.pan);
      else camera.move("orbit", -arrow[0] * STEP.turn, -arrow[1] * STEP.turn);
      rest();
    } else if (event.key === "+" || event.key === "=" || event.key === "-") {
      camera.move("dolly", event.key === "-" ? 1 / STEP.dolly : STEP.dolly);
      rest();
    } else if (event.key === "f" || event.key === "F") {
      page.attempt("frame", { object: null });
    } else if (event.key === "c" || event.key === "C") {
      show(pixel ? null : middle());
      announce(pixel ? "Crosshair in the middle of the picture" : "Crosshair hidden");
    } else if (event.key === "e" || event.key === "E") {
      explain();
    } else if (event.key === "Enter" || event.key === " ") {
      click(pixel || middle());
    } else if (event.key === "Escape" && pixel) {
      show(null);
    } else {
      return;
    }
    event.preventDefault();
  });
  canvas.addEventListener("blur", () => show(null));
  page.on("opened", () => show(null));
}

/** Collects moves and sends them to the engine, one call at a time. */
class Camera {
  #page;
  #waiting = new Map();
  #busy = false;
  #ending = false;

  constructor(page) {
    this.#page = page;
  }

  move(kind, x, y = 0, z = 0) {
    if (this.#page.looksOn) return;
    const last = this.#waiting.get(kind);
    if (!last) this.#waiting.set(kind, { kind, x, y, z });
    else if (kind === "dolly") last.x *= x;
    else Object.assign(last, { x: last.x + x, y: last.y + y, z: last.z + z });
    this.#ending = false;
    this.#send();
  }

  end() {
    if (this.#page.looksOn) return;
    this.#ending = true;
    this.#send();
  }

  async #send() {
    if (this.#busy) return;
    this.#busy = true;
    try {
      while (this.#waiting.size || this.#ending) {
        const moves = Array.from(this.#waiting.values());
        this.#waiting.clear();
        if (moves.length) for (const move of moves) await this.#page.call("gesture", move);
        else { this.#ending = false; await this.#page.call("gesture_end", {}); }
      }
    } catch (error) {
      this.#waiting.clear();
      this.#ending = false;
      this.#page.emit("problem", error);
    }
    this.#busy = false;
  }
}

const clamp = (x, low, high) => Math.max(low, Math.min(high, x));
