// The camera of <turner-view>: angles and distances as in `camera-orbit`, and the hands that move it.

const RADIANS = Math.PI / 180;

/** As model-viewer has it: from the front, a little above, everything in the picture. */
const DEFAULT = { theta: 0, phi: 75 * RADIANS, radius: 105, unit: "%" };

/** The least angle between the view and the vertical. */
const POLE = 2 * RADIANS;

/** Nearest and farthest distance, as factors of the one at which everything is in the picture. */
const [NEAREST, FARTHEST] = [0.2, 4];

/** Radians of a drag over the height of the view, and of an arrow key. */
const DRAG = Math.PI;
const KEY = Math.PI / 24;

/** Factors of the distance of a zoom key, and of a notch of a wheel of 100 pixels. */
const ZOOM = 0.9;
const WHEEL = 0.001;

/** Milliseconds after the last key or wheel until the move ends. */
const PAUSE = 250;

const ANGLES = { deg: RADIANS, rad: 1, "": RADIANS };

function angle(text, otherwise) {
  const [, number, unit] = /^(-?[\d.]+)(deg|rad|)$/.exec(text ?? "") ?? [];
  return Number.isFinite(Number.parseFloat(number)) ? Number(number) * ANGLES[unit] : otherwise;
}

/** `theta phi radius` of an attribute: radians, and a radius in percent or in units of the scene. */
export function parseOrbit(text) {
  const [theta, phi, radius] = (text ?? "").trim().split(/\s+/);
  const [, number, unit] = /^([\d.]+)(%|m|cm|mm|)$/.exec(radius ?? "") ?? [];
  const value = Number(number);
  const scale = { cm: 0.01, mm: 0.001 }[unit] ?? 1;
  return {
    theta: angle(theta, DEFAULT.theta),
    phi: Math.min(Math.max(angle(phi, DEFAULT.phi), POLE), Math.PI - POLE),
    radius: value > 0 ? value * scale : DEFAULT.radius,
    unit: value > 0 && unit !== "%" ? "m" : "%",
  };
}

/** Degrees of `field-of-view`; undefined for `auto`. */
export function parseFov(text) {
  const degrees = angle(text?.trim(), NaN) / RADIANS;
  return degrees > 0 && degrees < 180 ? degrees : undefined;
}

/** `studio.camera` that frames everything from these angles. */
export function framed({ theta, phi }) {
  return `orbit:${(theta / RADIANS).toFixed(4)},${(90 - phi / RADIANS).toFixed(4)}`;
}

/** The camera of a session that has a picture. */
export class ViewCamera {
  #engine;
  #late = 0;
  /** Distance at which everything is in the picture. */
  #ideal = 1;
  theta = 0;
  phi = 0;
  /** In units of the scene. */
  radius = 1;

  constructor(engine, { theta, phi }) {
    this.#engine = engine;
    Object.assign(this, { theta, phi });
  }

  /** Takes the studio's camera over, so that it can move: floor and lights stay where they are. */
  async take(hasLights) {
    const engine = this.#engine;
    await engine.call("gesture", { kind: "orbit", x: 0, y: 0 });
    await engine.call("gesture_end");
    const { keys } = await engine.call("part", { path: "camera" });
    const of = name => keys.find(key => key.name === name)?.value ?? [0, 0, 0];
    const [from, to] = [of("position"), of("look_at")];
    this.radius = this.#ideal = Math.hypot(...from.map((v, i) => v - to[i])) || 1;
    const edits = [["studio.camera", null], ["studio.ground", true]];
    if (!hasLights) edits.push(["studio.rotation", this.theta / RADIANS]);
    await engine.call("set", { edits, label: "View", merge: "view" });
  }

  /** Moves to an orbit of an attribute. */
  async to({ theta, phi, radius, unit }) {
    const wanted = unit === "%" ? this.#ideal * radius / DEFAULT.radius : radius;
    this.by(theta - this.theta, phi - this.phi, wanted / this.radius);
    await this.end();
  }

  /** Moves by angles and a factor of the distance, within the limits. */
  by(theta, phi, factor = 1) {
    const next = Math.min(Math.max(this.phi + phi, POLE), Math.PI - POLE);
    const radius = Math.min(Math.max(this.radius * factor, NEAREST * this.#ideal), FARTHEST * this.#ideal);
    // The engine is told how the model turns under the hand.
    const calls = [];
    if (theta || next !== this.phi) calls.push({ kind: "orbit", x: -theta, y: next - this.phi });
    if (radius !== this.radius) calls.push({ kind: "dolly", x: radius / this.radius });
    this.theta += theta;
    [this.phi, this.radius] = [next, radius];
    for (const call of calls) this.#engine.call("gesture", call).catch(() => {});
    return calls.length > 0;
  }

  /** Ends the move: the picture refines. */
  end() {
    clearTimeout(this.#late);
    return this.#engine.call("gesture_end").catch(() => {});
  }

  /** Ends the move soon, unless it goes on. */
  endSoon() {
    clearTimeout(this.#late);
    this.#late = setTimeout(() => this.end(), PAUSE);
  }
}

/** Listens to mouse, touch and keys on an element. `moved(theta, phi, factor)` gets moves, `ended(soon)` their ends. */
export function listen(element, moved, ended) {
  const points = new Map();
  const spread = () => {
    const [a, b] = [...points.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  const scale = () => DRAG / Math.max(1, element.clientHeight);
  const on = (name, handler) => element.addEventListener(name, handler, { passive: false });
  on("pointerdown", event => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    points.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  on("pointermove", event => {
    const last = points.get(event.pointerId);
    if (!last) return;
    const before = points.size === 2 ? spread() : 0;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    points.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (points.size === 1) moved(-dx * scale(), -dy * scale(), 1);
    else if (points.size === 2 && before > 0) moved(0, 0, before / Math.max(1, spread()));
  });
  const up = event => {
    if (points.delete(event.pointerId) && !points.size) ended(false);
  };
  on("pointerup", up);
  on("pointercancel", up);
  on("wheel", event => {
    event.preventDefault();
    moved(0, 0, Math.exp(Math.max(-300, Math.min(300, event.deltaY * (event.deltaMode ? 16 : 1))) * WHEEL));
    ended(true);
  });
  const keys = {
    ArrowLeft: [-KEY, 0, 1], ArrowRight: [KEY, 0, 1], ArrowUp: [0, -KEY, 1], ArrowDown: [0, KEY, 1],
    "+": [0, 0, ZOOM], "=": [0, 0, ZOOM], PageUp: [0, 0, ZOOM], "-": [0, 0, 1 / ZOOM], PageDown: [0, 0, 1 / ZOOM],
  };
  on("keydown", event => {
    const move = keys[event.key];
    if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    moved(...move);
    ended(true);
  });
}
