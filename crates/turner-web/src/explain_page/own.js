// The page of an explanation: the picture, the explanation of the chosen pixel, and the core that makes it.

/** Bytes of a zlib stream in base64. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The core with the scene open, ready to explain. */
async function openScene() {
  const module = await WebAssembly.compile(await unpacked(find("module").textContent));
  let fault = "";
  const { memory, limit } = newMemory();
  const core = await Core.create(module, memory, message => { fault = message; });
  core.begin(limit);
  const files = await Promise.all(Array.from(document.querySelectorAll("script.file"), async script =>
    ({ name: script.dataset.name, bytes: await unpacked(script.textContent) })));
  const { error } = core.call("open", { main: document.body.dataset.main }, files);
  if (error) throw new Error(error.message);
  // The scene is prepared once a first picture of it was drawn.
  core.call("view", { width: 64, height: 64 });
  for (let shown = false; !shown;) {
    const more = core.step();
    for (const { event, detail } of core.events()) {
      shown ||= event === "frame";
      if (event === "status" && detail.error) throw new Error(detail.error.message);
    }
    if (!more && !shown) throw new Error(fault || "the scene cannot be prepared");
  }
  return core;
}

const picture = find("picture");
const image = picture.querySelector("img");
const explained = find("explained");
const size = { x: image.width, y: image.height };
let at = { x: Math.floor(size.x / 2), y: Math.floor(size.y / 2) };
let core;

function mark() {
  const dot = find("mark");
  dot.hidden = false;
  dot.style.left = `${((at.x + 0.5) / size.x) * 100}%`;
  dot.style.top = `${((at.y + 0.5) / size.y) * 100}%`;
}

async function explain() {
  mark();
  explained.setAttribute("aria-busy", "true");
  explained.replaceChildren(make("p", { class: "dim", text: `Tracing the rays of pixel ${at.x}, ${at.y} …` }));
  // The text is shown before the work begins.
  await new Promise(resolve => setTimeout(resolve, 30));
  try {
    core ??= openScene();
    const { ok, error } = (await core).call("explain", { x: at.x, y: at.y, sample: null, format: "page" });
    if (error) throw new Error(error.message);
    const root = fragment(ok.text);
    explained.replaceChildren(root);
    wire(root);
  } catch (error) {
    core = undefined;
    explained.replaceChildren(make("p", { class: "wrong", text: error.message }));
  }
  explained.removeAttribute("aria-busy");
}

picture.addEventListener("click", event => {
  const box = image.getBoundingClientRect();
  const pixel = (v, from, length, count) => Math.min(count - 1, Math.max(0, Math.floor(((v - from) / length) * count)));
  at = { x: pixel(event.clientX, box.left, box.width, size.x), y: pixel(event.clientY, box.top, box.height, size.y) };
  explain();
});
picture.addEventListener("keydown", event => {
  const step = event.shiftKey ? 10 : 1;
  const [x, y] = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key] ?? [0, 0];
  if (x || y) {
    event.preventDefault();
    at = { x: Math.min(size.x - 1, Math.max(0, at.x + x)), y: Math.min(size.y - 1, Math.max(0, at.y + y)) };
    mark();
  } else if (event.key === "Enter") {
    explain();
  }
});

const first = document.body.dataset.pixel.split(",").map(Number);
if (first.length === 2) {
  at = { x: Math.min(size.x - 1, first[0]), y: Math.min(size.y - 1, first[1]) };
  window.addEventListener("load", explain);
}
