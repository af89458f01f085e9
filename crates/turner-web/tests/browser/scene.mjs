// Checks of the start page, the picture, the text, the parts and the explanation.

import {
  PATIENCE, SCENE, andSettles, assert, color, drop, equal, link, message, openText, picture, settled, start,
} from "./helpers.mjs";

export async function the_start_page_has_the_gallery_and_eight_steps(page, base) {
  await start(page, base);
  equal(await page.locator("#steps [data-start]").count(), 8, "steps");
  assert(await page.locator("#gallery [data-start]").count() >= 5, "the gallery has fewer than the five classic systems");
  const bare = await page.evaluate(() => Array.from(document.querySelectorAll("#main img"), image => image.outerHTML)
    .filter(image => !["width=", "height=", "alt=", "loading="].every(name => image.includes(name))));
  equal(bare.join(), "", "pictures without size or alternative text");
}

export async function a_scene_of_the_gallery_opens_and_settles(page, base) {
  await start(page, base);
  await page.locator("#gallery [data-start]").first().click();
  await settled(page);
  assert((await page.inputValue("#text")).includes("="), "the editor has no text");
  assert(new URL(page.url()).searchParams.has("start"), "the address does not name the scene");
  await page.goBack();
  await page.waitForSelector("#start:not([hidden])");
}

export async function a_step_shows_its_text_and_leads_to_the_next(page, base) {
  await start(page, base);
  await page.locator("#steps [data-start]").first().click();
  await settled(page);
  assert((await page.innerText("#step h2")).startsWith("Step 1 of 8"), "step 1 has no heading");
  assert(await page.locator("#step button", { hasText: "Previous" }).isDisabled(), "step 1 has a previous step");
  const before = await page.inputValue("#text");
  await page.click("#step button:text-is('Next')");
  await page.waitForFunction(() => document.querySelector("#step h2").textContent.startsWith("Step 2 of 8"), null, { timeout: PATIENCE });
  assert(await page.inputValue("#text") !== before, "step 2 has the text of step 1");
}

export async function the_mouse_orbits(page, base) {
  await openText(page, base);
  const before = await picture(page);
  const box = await page.locator("#canvas").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await andSettles(page, async () => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 20, { steps: 6 });
    await page.mouse.up();
    await page.waitForFunction(text => document.querySelector("#text").value !== text, SCENE, { timeout: PATIENCE });
  });
  assert(await picture(page) !== before, "the picture is the same after a drag");
  await andSettles(page, () => page.click("#undo"));
  equal(await page.inputValue("#text"), SCENE, "text after undo");
  equal(await picture(page), before, "picture after undo");
}

export async function the_keyboard_orbits_and_frames(page, base) {
  await openText(page, base);
  const before = await picture(page);
  await page.focus("#canvas");
  for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+", "f"]) {
    const text = await page.inputValue("#text");
    await andSettles(page, async () => {
      await page.keyboard.press(key);
      await page.waitForFunction(text => document.querySelector("#text").value !== text, text, { timeout: PATIENCE });
    });
  }
  assert(await picture(page) !== before, "the picture is the same after the keys");
}

export async function a_material_is_edited_in_the_properties(page, base) {
  await openText(page, base);
  await page.click("#tab-scene");
  await page.click("[data-path='material.red']");
  const field = page.getByRole("textbox", { name: "color", exact: true });
  await andSettles(page, async () => {
    await field.fill("#10a020");
    await field.press("Enter");
  });
  const [r, g, b] = await color(page, 0.5, 0.5);
  assert(g > 1.5 * r && g > 1.5 * b, `the ball is [${r}, ${g}, ${b}] after its colour became green`);
  assert(!(await page.inputValue("#text")).includes("#d02010"), "the text has the old colour");
  equal(await page.getByLabel("color, colour picker").inputValue(), "#10a020", "colour of the picker");
  const material = async () => /\[material\.red\][^[]*/.exec(await page.inputValue("#text"))[0];
  await andSettles(page, () => page.getByRole("button", { name: "Reset color to its default" }).click());
  assert(!(await material()).includes("color"), "the text has a colour after its reset");
}

export async function a_click_selects_a_material(page, base) {
  await openText(page, base);
  await page.click("#canvas");
  await page.waitForSelector("#properties h2", { timeout: PATIENCE });
  equal(await page.getAttribute("#tab-scene", "aria-selected"), "true", "the panel Scene is selected");
  await page.waitForSelector("#properties .links:not([hidden])", { timeout: PATIENCE });
}

export async function a_material_is_edited_in_the_text(page, base) {
  await openText(page, base);
  await andSettles(page, () => page.fill("#text", SCENE.replace("#d02010", "#1030d0")));
  const [r, g, b] = await color(page, 0.5, 0.5);
  assert(b > 1.5 * r && b > 1.5 * g, `the ball is [${r}, ${g}, ${b}] after its colour became blue`);
  equal(await page.inputValue("#text"), SCENE.replace("#d02010", "#1030d0"), "text after the edit");
}

export async function an_error_is_shown_at_its_line(page, base) {
  await openText(page, base);
  const before = await picture(page);
  const broken = SCENE.replace("radius = 1\n", "radus = 1\n");
  const line = broken.split("\n").findIndex(text => text.startsWith("radus")) + 1;
  await page.fill("#text", broken);
  await page.waitForSelector("#problems .error", { timeout: PATIENCE });
  assert((await page.innerText("#problems .error")).includes(`Line ${line}`), "the list does not name the line");
  assert((await page.locator(".paint .mark.error").allInnerTexts()).join("").includes("radus"), "the word is not underlined");
  equal(await page.getAttribute("#text", "aria-invalid"), "true", "aria-invalid");
  equal(await picture(page), before, "picture with an error in the text");
  await page.click("#problems .error button");
  equal(await page.evaluate(() => document.activeElement.id), "text", "focus after a click on the error");
  await andSettles(page, () => page.fill("#text", SCENE.replace("#d02010", "#10a020")));
  equal(await page.locator("#problems .error").count(), 0, "errors after the correction");
}

export async function completion_by_keyboard(page, base) {
  await openText(page, base);
  const at = SCENE.indexOf("color = \"#d02010\"");
  await page.focus("#text");
  await page.evaluate(at => document.querySelector("#text").setSelectionRange(at, at), at);
  await page.keyboard.type("roug", { delay: 30 });
  await page.waitForSelector("#completions:not([hidden]) [role=option]", { timeout: PATIENCE });
  const active = await page.getAttribute("#text", "aria-activedescendant");
  assert(active && (await page.innerText(`#${active}`)).includes("roughness"), "the first completion is not roughness");
  await page.keyboard.press("Enter");
  assert((await page.inputValue("#text")).slice(at).startsWith("roughness"), "Enter does not insert the completion");
  await page.keyboard.press("Escape");
  assert(await page.locator("#completions").isHidden(), "Escape does not close the completions");
}

export async function a_pixel_is_explained(page, base) {
  await openText(page, base);
  await page.click("#tab-explain");
  await page.click("#canvas");
  await page.waitForSelector(".explanation section:not([hidden]) .row", { timeout: PATIENCE });
  assert((await page.innerText(".explanation")).includes("ball"), "the explanation does not name the ball");
  const samples = page.locator(".explanation nav button");
  if (await samples.count() > 1) {
    await samples.nth(1).click();
    equal(await page.locator(".explanation section:not([hidden])").count(), 1, "samples shown");
  }
  await page.locator(".explanation section:not([hidden]) summary .what").first().click();
  assert(await page.locator(".explanation section:not([hidden]) details[open] dl").first().isVisible(), "a click does not open the details of a ray");
}

export async function a_draft_with_an_error_survives_a_gesture(page, base) {
  await openText(page, base);
  const draft = SCENE.replace("name = \"small\"", "name = ");
  await page.fill("#text", draft);
  await page.waitForSelector("#problems .error", { timeout: PATIENCE });
  await page.focus("#canvas");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(text => document.querySelector("#text").value !== text, draft, { timeout: PATIENCE });
  const text = await page.inputValue("#text");
  assert(text.includes("name = \n"), "the draft is lost");
  assert(!text.includes("position = [0, 1, 6]"), "the camera of the gesture is not in the text");
  await page.click("#undo");
  assert((await page.inputValue("#text")).includes("name = \"small\""), "Undo keeps the draft");
}

export async function the_view_shows_false_colours_and_debug_views(page, base) {
  await openText(page, base);
  const before = await picture(page);
  const choose = async name => {
    await page.click("#view");
    await page.locator("[role=menuitemradio]", { has: page.locator(`span:text-is("${name}")`) }).click();
  };
  await choose("False colours");
  await page.waitForSelector("#legend:not([hidden])", { timeout: PATIENCE });
  await choose("Picture");
  await page.waitForSelector("#legend[hidden]", { state: "attached", timeout: PATIENCE });
  await andSettles(page, () => choose("normals"));
  assert(await picture(page) !== before, "the normals look like the picture");
  await andSettles(page, () => choose("The scene’s integrator"));
  equal(await picture(page), before, "picture after the debug view");
}

export async function pause_stops_the_picture(page, base) {
  const long = SCENE.replace("samples = 4", "samples = 200000").replace("# A red ball", "integrator = { type = \"path\" }");
  await page.goto("about:blank");
  await page.goto(link(base, long));
  await page.waitForFunction(() => Number(document.querySelector("#canvas").dataset.frames) > 2, null, { timeout: PATIENCE });
  await page.click("#pause");
  await page.waitForFunction(() => document.querySelector("#status-text").textContent.startsWith("paused"), null, { timeout: PATIENCE });
  await page.waitForTimeout(500);
  const samples = () => page.innerText("#status-text");
  const before = await samples();
  await page.waitForTimeout(1500);
  equal(await samples(), before, "status line of a paused picture");
  await page.click("#pause");
  await page.waitForFunction(() => document.querySelector("#status-text").textContent.includes("left"), null, { timeout: PATIENCE });
}

export async function the_doctor_says_why_a_picture_is_black(page, base) {
  const dark = SCENE.replace("type = \"point\"\n", "type = \"point\"\nintensity = 0\n").replace("\"slategray\"", "\"black\"");
  await openText(page, base, `[integrator]\ntype = "path"\n\n${dark}`);
  await page.click("#tab-check");
  await page.click("#panel-check button");
  await page.waitForSelector(".finding", { timeout: PATIENCE });
  assert(/light/i.test(await page.innerText(".findings")), "no finding speaks of light");
}

export async function two_fingers_move_the_camera(page, base) {
  await openText(page, base);
  const before = await picture(page);
  await andSettles(page, () => page.evaluate(() => {
    const canvas = document.querySelector("#canvas");
    canvas.setPointerCapture = () => {};
    const box = canvas.getBoundingClientRect();
    const fire = (type, pointerId, x, y) => canvas.dispatchEvent(new PointerEvent(type, {
      pointerId, pointerType: "touch", clientX: box.left + x, clientY: box.top + y, bubbles: true, cancelable: true,
    }));
    fire("pointerdown", 1, 60, 60);
    fire("pointerdown", 2, 100, 60);
    for (let i = 1; i <= 8; i++) {
      fire("pointermove", 1, 60 - 4 * i, 60);
      fire("pointermove", 2, 100 + 4 * i, 60);
    }
    fire("pointerup", 1, 28, 60);
    fire("pointerup", 2, 132, 60);
  }));
  assert(await picture(page) !== before, "the picture is the same after two fingers moved apart");
  const position = /position = \[([^\]]*)\]/.exec(await page.inputValue("#text"))[1].split(",").map(Number);
  assert(Math.hypot(...position.map((x, i) => x - [0, 0.5, 0][i])) < 5, `the camera is not nearer: [${position}]`);
}

export async function a_fault_of_the_renderer_keeps_the_text(page, base) {
  await page.addInitScript(() => {
    const Original = Worker;
    window.Worker = class extends Original {
      constructor(...options) {
        super(...options);
        window.renderer = this;
      }
    };
  });
  await openText(page, base);
  await page.evaluate(() => window.renderer.dispatchEvent(new MessageEvent("message", { data: { fault: "a test" } })));
  assert((await message(page)).includes("a test"), "the message does not say what happened");
  equal(await page.inputValue("#text"), SCENE, "text after the fault");
  await andSettles(page, () => page.click("#message button:text-is('Render the text again')"));
  equal(await page.inputValue("#text"), SCENE, "text after the renderer has started again");
}

export async function a_long_text_is_painted_where_it_is_seen(page, base) {
  const more = Array.from({ length: 2000 }, (_, i) => `[[object]]\ntype = "sphere"\ncenter = [${i % 50}, ${Math.floor(i / 50)}, -30]\nradius = 0.4\n\n`);
  await start(page, base);
  await drop(page, [["scene.toml", `${SCENE}\n${more.join("")}# the end`]]);
  await page.waitForSelector("#scene:not([hidden])", { timeout: PATIENCE });
  assert((await page.innerText(".paint")).startsWith("# A red ball"), "the first line is not painted");
  await page.focus("#text");
  await page.keyboard.press("Control+End");
  await page.waitForFunction(() => document.querySelector(".paint").textContent.includes("# the end"), null, { timeout: PATIENCE });
  const painted = await page.locator(".gutter span").count();
  assert(painted < 200, `${painted} lines are painted`);
}
