// The picture: draws the frames of the engine, and marks pixels in it.

import { find, later, make } from "./dom.js";
import { setupGestures } from "./gestures.js";

/** Windows where the panels lie below the picture: as in `scene.css`. */
const NARROW = "(max-width: 800px), (max-width: 1000px) and (orientation: portrait)";

export function setupViewport(page) {
  const stage = find("stage");
  const picture = find("picture");
  const canvas = find("canvas");
  const context = canvas.getContext("2d", { alpha: true });
  const buffer = document.createElement("canvas");
  const view = page.viewport = { canvas, film: { width: 480, height: 300 }, stage: "", marker: null };

  page.on("opened", () => view.mark(null));
  page.on("document", ({ film }) => {
    if (film.width !== view.film.width || film.height !== view.film.height) {
      view.film = { width: film.width, height: film.height };
      fit();
    }
    label();
  });
  page.on("shown", () => fit());
  page.on("frame", frame => {
    draw(frame);
    legend(frame.scale);
    if (view.stage !== frame.stage) {
      view.stage = frame.stage;
      canvas.dataset.stage = frame.stage;
      label();
    }
    canvas.dataset.frames = String(Number(canvas.dataset.frames || 0) + 1);
  });
  page.on("opening", ({ what }) => { picture.classList.toggle("waiting", Boolean(what)); });

  /** A preview has fewer pixels than the film: it is scaled. */
  function draw({ width, height, pixels }) {
    const { width: w, height: h } = view.film;
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    // An image cannot lie in memory that threads share.
    const own = pixels.buffer instanceof ArrayBuffer ? pixels : new Uint8ClampedArray(pixels);
    const image = new ImageData(own, width, height);
    if (width === w && height === h) {
      context.putImageData(image, 0, 0);
      return;
    }
    if (buffer.width !== width || buffer.height !== height) { buffer.width = width; buffer.height = height; }
    buffer.getContext("2d").putImageData(image, 0, 0);
    context.clearRect(0, 0, w, h);
    context.imageSmoothingQuality = "high";
    context.drawImage(buffer, 0, 0, w, h);
  }

  /** The largest rectangle of the film's shape inside the stage; small films are enlarged at most three times. */
  function fit() {
    if (find("scene").hidden) return;
    const { width, height } = view.film;
    const style = getComputedStyle(stage);
    const room = stage.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
    const tall = matchMedia(NARROW).matches ? innerHeight * 0.42 : stage.clientHeight - 44;
    const scale = Math.max(0.01, Math.min(room / width, tall / height, 3));
    picture.style.width = `${Math.round(width * scale)}px`;
    picture.style.height = `${Math.round(height * scale)}px`;
    size();
  }
  const size = later(150, () => {
    const ratio = devicePixelRatio || 1;
    const args = { width: Math.round(picture.clientWidth * ratio), height: Math.round(picture.clientHeight * ratio) };
    if (args.width && args.height && page.engine) page.call("view", args).catch(() => {});
  });
  new ResizeObserver(fit).observe(stage);

  function label() {
    const name = page.document?.name || "the scene";
    const { width, height } = view.film;
    const state = { preview: "a preview", film: "still rendering", settled: "finished" }[view.stage] || "waiting for the first picture";
    canvas.setAttribute("aria-label", `Picture of ${name}, ${width} by ${height} pixels, ${state}`);
  }

  function legend(scale) {
    const box = find("legend");
    box.hidden = !scale;
    if (!scale) return;
    const bar = make("span", { class: "ramp", "aria-hidden": "true" });
    bar.style.background = `linear-gradient(to right, ${scale.colors.join(", ")})`;
    box.replaceChildren(make("span", { text: short(scale.low) }), bar, make("span", { text: `${short(scale.high)} ${scale.unit || ""}` }));
  }

  /** Where a point of the window lies in the film, in pixels; `null` outside. */
  view.at = (clientX, clientY) => {
    const box = canvas.getBoundingClientRect();
    const x = (clientX - box.left) / box.width * view.film.width;
    const y = (clientY - box.top) / box.height * view.film.height;
    return x >= 0 && y >= 0 && x < view.film.width && y < view.film.height ? { x, y } : null;
  };

  /** Marks the pixel that is explained. */
  view.mark = pixel => {
    view.marker = pixel;
    const mark = find("marker");
    mark.hidden = !pixel;
    if (pixel) put(mark, pixel.x + 0.5, pixel.y + 0.5);
  };
  const put = (element, x, y) => {
    element.style.left = `${100 * x / view.film.width}%`;
    element.style.top = `${100 * y / view.film.height}%`;
  };
  view.put = put;

  setupGestures(page, view);
}

const short = x => Number(x.toPrecision(3)).toString();
