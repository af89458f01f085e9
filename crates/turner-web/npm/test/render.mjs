// Pictures, errors, progress and cancel.
import assert from "node:assert/strict";
import { after, test } from "node:test";
import { ball, box, cleanups, decodePng, installed } from "./helpers.mjs";

const { Turner, TurnerError, render } = await installed();
const one = new Turner({ threads: 1 });
const two = new Turner({ threads: 2 });
after(async () => {
  one.close();
  two.close();
  for (const cleanup of cleanups) await cleanup();
});

test("threads and runs make no difference to the pixels", async () => {
  const scene = ball(40, 30);
  const first = await one.render(scene);
  assert.deepEqual([first.width, first.height, first.data.length], [40, 30, 4800]);
  assert.ok(new Set(first.data).size > 20);
  assert.deepEqual(await one.render(scene), first);
  assert.deepEqual((await two.render(scene)).data, first.data);
  assert.deepEqual([one.threads, two.threads], [1, 2]);
});

test("a PNG has the pixels of rgba; other formats have their signatures", async () => {
  const glb = await box();
  const options = { width: 48, height: 32, samples: 2 };
  const rgba = await render(glb, options);
  const png = await render(glb, { ...options, format: "png" });
  const decoded = decodePng(png.data);
  assert.deepEqual([decoded.width, decoded.height], [48, 32]);
  assert.deepEqual(Buffer.from(decoded.data), Buffer.from(rgba.data.buffer, rgba.data.byteOffset, rgba.data.length));
  const starts = { jpg: [0xff, 0xd8], webp: [0x52, 0x49, 0x46, 0x46], exr: [0x76, 0x2f, 0x31, 0x01] };
  for (const [format, start] of Object.entries(starts)) {
    const { data } = await render(glb, { ...options, format });
    assert.deepEqual([...data.subarray(0, start.length)], start, format);
  }
  const linear = await render(glb, { ...options, format: "linear" });
  assert.ok(linear.data instanceof Float32Array && linear.data.length === 48 * 32 * 4);
});

test("options reach the scene; the program keeps its bytes", async () => {
  const glb = await box();
  const size = glb.length;
  const options = { width: 32, height: 32, samples: 1 };
  const front = await render(glb, { ...options, camera: "orbit:0,0" });
  const side = await render(glb, { ...options, camera: { orbit: [60, 30] } });
  assert.notDeepEqual(front.data, side.data);
  assert.equal(glb.length, size);
  const set = await render(ball(32, 32), { set: { "object.0.radius": 0.5, "studio.backdrop": [1, 0, 0] } });
  assert.deepEqual([...set.data.subarray(0, 4)], [255, 0, 0, 255]);
  const wide = await render(glb, { samples: 1, width: 64 });
  assert.deepEqual([wide.width, wide.height], [64, 48]);
});

test("AOVs are arrays with channels", async () => {
  const { aovs } = await one.render(ball(16, 12), { aovs: ["depth", "normal", "object_id"] });
  assert.deepEqual(Object.keys(aovs), ["normal", "depth", "object_id"]);
  const { normal, depth, object_id: ids } = aovs;
  assert.ok(depth.data instanceof Float32Array && depth.data.length === 16 * 12);
  assert.equal(normal.channels.length, 3);
  assert.ok(ids.data instanceof Uint32Array && ids.data.includes(1));
  const middle = 6 * 16 + 8;
  const length = Math.hypot(...normal.data.subarray(middle * 3, middle * 3 + 3));
  assert.ok(Math.abs(length - 1) < 0.02, `${length}`);
});

test("files of a scene", async () => {
  const scene = "[film]\nwidth = 20\nheight = 20\n[[object]]\ntype = \"model\"\nfile = \"parts/box.glb\"\n";
  const files = { "scene.toml": scene, "parts/box.glb": await box() };
  const { width } = await one.render({ files, main: "scene.toml" });
  assert.equal(width, 20);
  await assert.rejects(one.render({ files }), { name: "TurnerError", message: /which of the files/ });
});

test("errors have message, help and line", async () => {
  const misspelt = await one.render("[film]\nwidht = 10").catch(error => error);
  assert.ok(misspelt instanceof TurnerError);
  assert.equal(misspelt.line, 2);
  assert.match(misspelt.message, /widht/);
  assert.match(misspelt.help, /width/);
  const glb = await box();
  const broken = await one.render(glb.subarray(0, 200)).catch(error => error);
  assert.ok(broken instanceof TurnerError && broken.message.length > 10, String(broken));
  await assert.rejects(one.render(new Uint8Array(8)), { name: "TurnerError", message: /format/ });
  await assert.rejects(one.render(ball(8, 8), { format: "tiff2" }), { name: "TurnerError" });
  await assert.rejects(one.render(ball(8, 8), { set: { "film.samples": "many" } }), { name: "TurnerError" });
  assert.equal((await one.render(ball(8, 8))).width, 8);
});

test("progress grows and ends at 1", async () => {
  const seen = [];
  await one.render(ball(64, 48), { samples: 64, onProgress: ({ fraction }) => seen.push(fraction) });
  assert.equal(seen[0], 0);
  assert.equal(seen.at(-1), 1);
  assert.ok(seen.length > 3, `${seen}`);
  seen.reduce((last, next) => (assert.ok(next >= last, `${seen}`), next));
});

for (const threads of [1, 2]) {
  test(`a cancel ends within 0.2 s, and the next picture comes: ${threads} threads`, async () => {
    const turner = new Turner({ threads });
    try {
      const expected = await turner.render(ball(16, 16));
      const abort = new AbortController();
      const long = turner.render(ball(1600, 1200), { samples: 100_000, signal: abort.signal });
      const next = turner.render(ball(16, 16));
      await new Promise(resolve => setTimeout(resolve, 400));
      const begun = performance.now();
      abort.abort();
      await assert.rejects(long, { name: "AbortError" });
      assert.ok(performance.now() - begun < 200);
      assert.deepEqual((await next).data, expected.data);
      assert.ok(performance.now() - begun < 4000, `${performance.now() - begun}`);
      const gone = AbortSignal.abort();
      await assert.rejects(turner.render(ball(16, 16), { signal: gone }), { name: "AbortError" });
    } finally {
      turner.close();
    }
  });
}

test("a closed Turner says so", async () => {
  const turner = new Turner({ threads: 1 });
  turner.close();
  await assert.rejects(turner.render(ball(8, 8)), { name: "TurnerError", message: /closed/ });
});
