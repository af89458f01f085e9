// Checks of files: dropped, in a zip file, in a folder, hostile; and of those that are saved.

import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { PATIENCE, SCENE, andSettles, assert, color, drop, equal, glb, message, openText, settled, start, zip } from "./helpers.mjs";

export async function a_dropped_glb_is_rendered(page, base) {
  await start(page, base);
  await drop(page, [["triangle.glb", glb()]]);
  await settled(page);
  const [r, g, b] = await color(page, 0.5, 0.55);
  assert(r > 1.3 * g && r > 1.3 * b, `the red triangle is [${r}, ${g}, ${b}]`);
}

export async function a_zip_with_a_folder_is_opened(page, base) {
  await start(page, base);
  await drop(page, [["ball.zip", zip([["ball/readme.txt", "A ball."], ["ball/scene.toml", SCENE]])]]);
  await settled(page);
  equal(await page.inputValue("#text"), SCENE, "text of the zipped scene");
}

export async function png_exr_and_toml_are_saved(page, base) {
  await openText(page, base);
  const magic = { PNG: [0x89, 0x50, 0x4e, 0x47], EXR: [0x76, 0x2f, 0x31, 0x01], TOML: [...Buffer.from("# A ")] };
  for (const [format, bytes] of Object.entries(magic)) {
    await page.click("#save");
    const [download] = await Promise.all([
      page.waitForEvent("download", { timeout: PATIENCE }),
      page.locator("[role=menuitem]", { hasText: new RegExp(`^${format}`) }).click(),
    ]);
    const found = await readFile(await download.path());
    assert(bytes.every((byte, i) => found[i] === byte), `${download.suggestedFilename()} does not begin as ${format} does`);
    if (format === "TOML") equal(found.toString(), SCENE, "saved text");
  }
}
png_exr_and_toml_are_saved.options = { driver: "chromium" };

export async function a_hostile_file_leaves_a_message_and_a_living_page(page, base) {
  await start(page, base);
  const broken = glb();
  broken.writeUInt32LE(0xfffffff0, 12);
  const hostile = [
    [["cut.glb", glb().subarray(0, 40)]],
    [["sizes.glb", broken]],
    [["noise.ply", Buffer.from("ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n")]],
    [["scene.toml", "[[object]]\ntype = \"sphere\"\nradius = 1e999\n"]],
    [["deep.toml", `a = ${"[".repeat(100_000)}`]],
    [["up.zip", zip([["../scene.toml", SCENE]])]],
    [["lie.zip", zip([["scene.toml", "#".repeat(1_000_000)]], () => 10)]],
    [["many.zip", zip(Array.from({ length: 10_001 }, (_, i) => [`${i}.toml`, ""]))]],
    [["notes.txt", "no scene"]],
  ];
  for (const files of hostile) {
    await drop(page, files);
    const text = await message(page);
    assert(text.length > 20, `${files[0][0]}: the message is “${text}”`);
    await page.click("#message .close");
  }
  await drop(page, [["scene.toml", SCENE]]);
  await settled(page);
}

export async function a_scene_that_needs_too_much_memory_leaves_a_message(page, base) {
  await openText(page, base);
  await page.fill("#text", SCENE.replace("width = 96", "width = 60000").replace("height = 64", "height = 60000"));
  await page.waitForFunction(() => document.querySelector("#problems .error") || !document.querySelector("#message").hidden, null, { timeout: PATIENCE });
  await page.evaluate(() => document.querySelector("#message .close")?.click());
  await andSettles(page, () => page.fill("#text", SCENE.replace("#d02010", "#10a020")));
}

export async function a_folder_is_opened(page, base) {
  await start(page, base);
  const folder = await mkdtemp(join(tmpdir(), "turner-"));
  try {
    await mkdir(join(folder, "ball", "parts"), { recursive: true });
    const [settings, rest] = [SCENE.slice(0, SCENE.indexOf("[material.red]")), SCENE.slice(SCENE.indexOf("[material.red]"))];
    await writeFile(join(folder, "ball", "scene.toml"), `include = ["parts/ball.toml"]\n${settings}`);
    await writeFile(join(folder, "ball", "parts", "ball.toml"), rest);
    await page.setInputFiles("#folder", join(folder, "ball"));
    await settled(page);
    const [r, g, b] = await color(page, 0.5, 0.5);
    assert(r > 1.5 * g && r > 1.5 * b, `the ball of the folder is [${r}, ${g}, ${b}]`);
  } finally {
    await rm(folder, { recursive: true });
  }
}
a_folder_is_opened.options = { driver: "chromium" };

export async function one_of_several_scenes_is_chosen(page, base) {
  await start(page, base);
  await drop(page, [["one.toml", SCENE], ["two.toml", `${SCENE}# two\n`]]);
  assert((await message(page)).includes("one.toml"), "the message does not list the scenes");
  await page.click("#message button:text-is('two.toml')");
  await settled(page);
  equal(await page.inputValue("#text"), `${SCENE}# two\n`, "text of the chosen scene");
}
