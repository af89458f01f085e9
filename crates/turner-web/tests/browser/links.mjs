// Checks of addresses: a scene, a scene of the gallery, and a pixel in the link.

import { randomBytes } from "node:crypto";
import { PATIENCE, SCENE, assert, drop, equal, glb, link, message, openText, settled, start } from "./helpers.mjs";

/** What Share copies, read from the dialog that is shown where copying is not allowed. */
async function shared(page) {
  await page.evaluate(() => { navigator.clipboard.writeText = () => Promise.reject(new Error("not allowed")); });
  await page.click("#share");
  await page.waitForSelector("dialog .address", { timeout: PATIENCE });
  const address = await page.inputValue("dialog .address");
  await page.click("dialog button:text-is('Close')");
  return address;
}

export async function a_link_opens_the_scene_as_sent(page, base) {
  await openText(page, base);
  const edited = SCENE.replace("A red ball", "A red ball, 球 Ω").replace("radius = 1\n", "radius = 1.2\n");
  await page.fill("#text", edited);
  const address = await shared(page);
  assert(address.includes("#s="), `the link is ${address}`);
  await page.goto("about:blank");
  await page.goto(address);
  await settled(page);
  equal(await page.inputValue("#text"), edited, "text of the link");
}

export async function a_text_above_8_kb_is_no_link(page, base) {
  await openText(page, base, `${SCENE}# ${"x".repeat(20)}\n`);
  // As if pasted: some drivers type what they fill in.
  await page.evaluate(text => {
    const area = document.querySelector("#text");
    area.value = text;
    area.dispatchEvent(new Event("input", { bubbles: true }));
  }, `${SCENE}# ${randomBytes(9000).toString("hex")}\n`);
  await page.click("#share");
  assert((await message(page)).includes("8,192"), "the message does not state the limit");
}

export async function a_damaged_link_leaves_a_message(page, base) {
  for (const hash of ["s=AAAA", "s=%%%", `s=${"A".repeat(20_000)}`]) {
    await page.goto("about:blank");
    await page.goto(`${base}#${hash}`);
    assert((await message(page)).includes("link"), `the message for #${hash.slice(0, 10)} does not speak of the link`);
    await page.waitForSelector("#gallery [data-start]", { timeout: PATIENCE });
  }
}

export async function a_link_explains_its_pixel(page, base) {
  await page.goto("about:blank");
  await page.goto(link(`${base}?explain=48,32`, SCENE));
  await page.waitForSelector(".explanation section:not([hidden]) .row", { timeout: PATIENCE });
  assert((await page.innerText(".explanation")).includes("48,32"), "another pixel is explained");
  const address = await shared(page);
  assert(address.includes("explain=48,32"), `the link of an explained pixel is ${address}`);
}

export async function a_link_to_the_gallery_opens_its_scene(page, base) {
  await start(page, base);
  const id = await page.locator("#steps [data-start]").first().getAttribute("data-start");
  await page.goto("about:blank");
  await page.goto(`${base}?start=${encodeURIComponent(id)}`);
  await settled(page);
  await page.waitForSelector("#step:not([hidden])", { timeout: PATIENCE });
}

export async function an_edited_scene_of_the_gallery_keeps_its_files_in_a_link(page, base) {
  await start(page, base);
  await page.locator("#steps [data-start]").nth(1).click();
  await settled(page);
  const edited = `${await page.inputValue("#text")}\n# edited\n`;
  await page.fill("#text", edited);
  const address = await shared(page);
  assert(address.includes("start=") && address.includes("#s="), `the link is ${address}`);
  await page.goto("about:blank");
  await page.goto(address);
  await settled(page);
  equal(await page.inputValue("#text"), edited, "text of the link");
}

export async function a_scene_with_a_model_is_no_link(page, base) {
  await start(page, base);
  await drop(page, [["triangle.glb", glb()]]);
  await settled(page);
  await page.click("#share");
  assert((await message(page)).includes("triangle.glb"), "the message does not name the model");
}

export async function an_edited_scene_survives_a_reload(page, base) {
  await start(page, base);
  await page.locator("#steps [data-start]").nth(1).click();
  await settled(page);
  const edited = `${await page.inputValue("#text")}\n# edited\n`;
  await page.fill("#text", edited);
  await page.waitForFunction(() => location.hash.startsWith("#s="), null, { timeout: PATIENCE });
  await page.reload();
  await settled(page);
  equal(await page.inputValue("#text"), edited, "text after a reload");
  await page.click("#to-start");
  await page.waitForSelector("#start:not([hidden])");
  await page.goBack();
  await page.waitForSelector("#scene:not([hidden])");
  equal(await page.inputValue("#text"), edited, "text after Back");
}
