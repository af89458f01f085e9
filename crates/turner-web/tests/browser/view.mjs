// Checks of <turner-view> in a browser.
import assert from "node:assert/strict";

/** A GLB of a coloured tetrahedron that stands on a face; it looks different from all sides. */
export function tinyGlb() {
  const corners = [[-1, 0, 0.6], [1, 0, 0.6], [0, 0, -1.1], [0, 1.6, 0]];
  const faces = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]];
  const colors = [[0.9, 0.1, 0.1], [0.1, 0.7, 0.1], [0.1, 0.2, 0.9], [0.5, 0.5, 0.5]];
  const positions = new Float32Array(faces.flat().flatMap(i => corners[i]));
  const json = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: faces.map((_, i) => ({ attributes: { POSITION: i }, material: i })) }],
    materials: colors.map(c => ({ pbrMetallicRoughness: { baseColorFactor: [...c, 1], metallicFactor: 0 } })),
    accessors: faces.map((_, i) => ({
      bufferView: 0, byteOffset: 36 * i, componentType: 5126, count: 3, type: "VEC3",
      min: [0, 1, 2].map(axis => Math.min(...[0, 1, 2].map(k => positions[9 * i + 3 * k + axis]))),
      max: [0, 1, 2].map(axis => Math.max(...[0, 1, 2].map(k => positions[9 * i + 3 * k + axis]))),
    })),
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength }], buffers: [{ byteLength: positions.byteLength }],
  });
  const padded = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const head = Buffer.alloc(20);
  head.write("glTF");
  [2, 28 + padded.length + positions.byteLength, padded.length, 0x4e4f534a].forEach((v, i) => head.writeUInt32LE(v, 4 + 4 * i));
  const part = Buffer.alloc(8);
  part.writeUInt32LE(positions.byteLength, 0);
  part.writeUInt32LE(0x004e4942, 4);
  return Buffer.concat([head, padded, part, Buffer.from(positions.buffer)]);
}

/** A Radiance file of 4 x 2 pixels of one colour: mantissas and exponent. */
function tinyHdr(rgbe) {
  const head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
  return Buffer.concat([Buffer.from(head), Buffer.from(Array(8).fill(rgbe).flat())]);
}

/** A page with these views, whose policy forbids inline scripts and styles and eval. */
async function show(page, base, views) {
  const policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self';"
    + " img-src 'self' data: blob:; style-src 'self'";
  const html = `<!doctype html><meta charset="utf-8"><title>Views</title>
    <link rel="stylesheet" href="check-view.css">${views}
    <script type="module" src="turner-view.js"></script>`;
  await page.route("**/check-view.html", async route => {
    const answer = await route.fetch({ url: new URL("view.html", base).href });
    const headers = { ...answer.headers(), "content-security-policy": policy, "content-type": "text/html" };
    delete headers["content-length"];
    await route.fulfill({ status: 200, headers, body: html });
  });
  await page.route("**/check-view.css", route =>
    route.fulfill({ contentType: "text/css", body: "turner-view { width: 96px; height: 96px; }" }));
  const files = { "tiny.glb": tinyGlb(), "red.hdr": tinyHdr([200, 20, 20, 130]), "bad.glb": Buffer.from("glTF, but no more") };
  for (const [name, body] of Object.entries(files)) {
    await page.route(`**/${name}`, route => route.fulfill({ body, contentType: "application/octet-stream" }));
  }
  const refused = [];
  page.on("console", message => /Content Security Policy/.test(message.text()) && refused.push(message.text()));
  await page.goto(new URL("check-view.html", base).href);
  await until(page, () => customElements.get("turner-view") !== undefined);
  return refused;
}

/** Waits until a function of the page holds. (`waitForFunction` needs eval, which the policy forbids.) */
async function until(page, holds, patience = 60_000) {
  for (const begun = Date.now(); !await page.evaluate(holds);) {
    if (Date.now() - begun > patience) throw new Error(`never: ${holds}`);
    await new Promise(resolve => setTimeout(resolve, 50));
  }
}

const settled = (page, selector = "turner-view") => page.evaluate(async s => { await document.querySelector(s).settled; }, selector);

/** The mean colour of the middle of a view, and that of the whole. */
const colors = (page, selector = "turner-view") => page.evaluate(s => {
  const canvas = document.querySelector(s).shadowRoot.querySelector("canvas");
  const mean = (x, y, w, h) => {
    const { data } = canvas.getContext("2d").getImageData(x, y, w, h);
    return [0, 1, 2].map(c => data.reduce((sum, v, i) => sum + (i % 4 === c ? v : 0), 0) / (w * h));
  };
  const [w, h] = [canvas.width, canvas.height];
  return { middle: mean((w * 0.45) | 0, (h * 0.45) | 0, (w / 10) | 0, (h / 10) | 0), all: mean(0, 0, w, h) };
}, selector);

const VIEW = 'alt="A tetrahedron" samples="8"';

export const checks = [
  ["a view renders its model under a strict policy, and gives a PNG", async (page, base) => {
    const refused = await show(page, base, `<turner-view src="tiny.glb" ${VIEW}></turner-view>`);
    await settled(page);
    const { middle: [r, g, b] } = await colors(page);
    assert.ok(r > 2 * g && r > 2 * b, `${[r, g, b]}`);
    const png = await page.evaluate(async () => {
      const blob = await document.querySelector("turner-view").toBlob({ mimeType: "image/png" });
      const picture = await createImageBitmap(blob);
      return { type: blob.type, size: [picture.width, picture.height], first: [...new Uint8Array(await blob.slice(0, 4).arrayBuffer())] };
    });
    assert.deepEqual(png, { type: "image/png", size: [96, 96], first: [0x89, 0x50, 0x4e, 0x47] });
    const canvas = page.locator("turner-view canvas");
    assert.equal(await canvas.getAttribute("role"), "img");
    assert.equal(await canvas.getAttribute("aria-label"), "A tetrahedron");
    assert.ok((await page.evaluate(() => document.querySelector("turner-view").toDataURL())).startsWith("data:image/png"));
    assert.deepEqual(refused, []);
  }],
  ["mouse and keys turn the model, and camera-orbit does", async (page, base) => {
    await show(page, base, `<turner-view src="tiny.glb" ${VIEW} camera-controls></turner-view>`);
    await settled(page);
    await page.evaluate(() => {
      window.changes = [];
      document.querySelector("turner-view").addEventListener("camera-change", e => window.changes.push(e.detail.source));
    });
    await until(page, () => document.querySelector("turner-view").getCameraOrbit().radius !== null);
    const front = await colors(page);
    const box = await page.locator("turner-view").boundingBox();
    await page.mouse.move(box.x + 90, box.y + 48);
    await page.mouse.down();
    // Two thirds of the height are 120 degrees: the next face comes to the front.
    for (let i = 1; i <= 10; i++) await page.mouse.move(box.x + 90 - 6.4 * i, box.y + 48);
    await page.mouse.up();
    await settled(page);
    const { theta } = await page.evaluate(() => document.querySelector("turner-view").getCameraOrbit());
    assert.ok(Math.abs(theta - 2 * Math.PI / 3) < 0.02, `${theta}`);
    const turned = await colors(page);
    assert.ok(front.middle[0] > 2 * front.middle[1] && turned.middle[1] > 1.5 * turned.middle[0], JSON.stringify([front, turned]));
    await page.locator("turner-view canvas").focus();
    await page.keyboard.press("ArrowLeft");
    const after = await page.evaluate(() => document.querySelector("turner-view").getCameraOrbit().theta);
    assert.ok(after < theta - 0.1);
    assert.ok((await page.evaluate(() => window.changes)).includes("user-interaction"));
    await page.evaluate(() => document.querySelector("turner-view").setAttribute("camera-orbit", "240deg 75deg 105%"));
    await until(page, () => Math.abs(document.querySelector("turner-view").getCameraOrbit().theta - 4 * Math.PI / 3) < 0.01);
    await page.waitForTimeout(50);
    await settled(page);
    const { middle: [r, g, b] } = await colors(page);
    assert.ok(b > 1.5 * r && b > g, `${[r, g, b]}`);
  }],
  ["environment and exposure change the light", async (page, base) => {
    // The blue face is in front.
    const each = 'src="tiny.glb" camera-orbit="240deg 75deg 105%" ' + VIEW;
    await show(page, base, `<turner-view ${each} id="studio"></turner-view>
      <turner-view ${each} id="map" environment="red.hdr"></turner-view>
      <turner-view ${each} id="dark" exposure="0.25"></turner-view>`);
    for (const id of ["#studio", "#map", "#dark"]) await settled(page, id);
    const [studio, map, dark] = await Promise.all(["#studio", "#map", "#dark"].map(id => colors(page, id)));
    assert.ok(studio.middle[2] > 2 * studio.middle[0], JSON.stringify(studio));
    assert.ok(map.middle[2] < 1.5 * map.middle[0], JSON.stringify(map));
    assert.ok(dark.middle[2] < 0.75 * studio.middle[2], JSON.stringify([studio, dark]));
  }],
  ["the poster stays until the picture comes; a bad file has its message in place", async (page, base) => {
    const pixel = "data:image/gif;base64,R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7";
    await show(page, base, `<turner-view src="tiny.glb" poster="${pixel}" reveal="manual" ${VIEW} id="good"></turner-view>
      <turner-view src="bad.glb" ${VIEW} id="bad"></turner-view><turner-view src="missing.glb" id="missing"></turner-view>`);
    await settled(page, "#good");
    const poster = page.locator("#good img");
    assert.equal(await poster.evaluate(img => img.classList.contains("gone")), false);
    await page.evaluate(() => document.querySelector("#good").dismissPoster());
    assert.equal(await poster.evaluate(img => img.classList.contains("gone")), true);
    for (const [id, pattern] of [["bad", /glTF|GLB/i], ["missing", /404/]]) {
      const message = page.locator(`#${id} [role=alert]`);
      await message.waitFor({ state: "visible" });
      assert.match(await message.textContent(), pattern);
    }
  }],
  ["views share a module; those off screen begin when they are seen", async (page, base) => {
    let fetched = 0;
    page.on("request", request => { fetched += request.url().endsWith(".wasm") ? 1 : 0; });
    await show(page, base, `<turner-view src="tiny.glb" ${VIEW} id="one"></turner-view>
      <turner-view src="tiny.glb" ${VIEW} id="two"></turner-view><p>${"<br>".repeat(400)}</p>
      <turner-view src="tiny.glb" ${VIEW} id="below"></turner-view>`);
    await settled(page, "#one");
    await settled(page, "#two");
    assert.equal(fetched, 1);
    assert.equal(await page.evaluate(() => document.querySelector("#below").loaded), false);
    await page.evaluate(() => document.querySelector("#below").scrollIntoView());
    await settled(page, "#below");
    assert.equal(fetched, 1);
  }],
];
