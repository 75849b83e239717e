// The page in a browser, as a user has it. The environment names the programs: CSG, MODEL (with
// arguments of its own) and CHROMIUM.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { chromium } from "playwright-core";

// 40 x 20 x 5, with bores of radius 3 and 4 whose axes are 24 apart.
const plate = (r, s) => `difference() {
  cube(size = [40, 20, 5], center = true);
  multmatrix([[1, 0, 0, -12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cylinder(h = 10, r1 = ${r}, r2 = ${r}, center = true); }
  multmatrix([[1, 0, 0, 12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cylinder(h = 10, r1 = ${s}, r2 = ${s}, center = true); }
}
`;
const PLATE = plate(3, 4);
const volume = (r, s) => 5 * (800 - Math.PI * (r * r + s * s));

let browser;
let folder;
const running = [];

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "view-"));
  browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
});

after(async () => {
  for (const program of running) program.kill();
  await browser?.close();
  await rm(folder, { recursive: true, force: true });
});

/** The address of a page that a program serves. */
async function served(program, args, env = {}) {
  const process_ = spawn(program, args, { env: { ...process.env, ...env }, stdio: ["ignore", "pipe", "inherit"] });
  running.push(process_);
  const [line] = await new Promise((done, fail) => {
    process_.stdout.once("data", (data) => done(String(data).split("\n")));
    process_.once("exit", (code) => fail(new Error(`${program} ended with ${code}`)));
  });
  return line;
}

/** A page on a scene in a file of its own. */
async function opened(name, text, options = {}, more = []) {
  const file = join(folder, name);
  await writeFile(file, text);
  return { file, ...(await visited(await served(process.env.CSG, ["view", file, "--no-open", ...more]), options)) };
}

async function visited(address, options = {}, isThere = true) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, ...options });
  page.setDefaultTimeout(20_000);
  const mistakes = [];
  page.on("pageerror", (error) => mistakes.push(String(error)));
  page.on("console", (message) => message.type() === "error" && mistakes.push(message.text()));
  await page.goto(address);
  if (isThere) await page.waitForFunction(() => globalThis.stereotomy && stereotomy.state.account !== null);
  return { page, mistakes };
}

const measure = async (page, label, table = "#measures") =>
  page.locator(`${table} tr`, { has: page.getByRole("rowheader", { name: label, exact: true }) }).first().locator("td").innerText();
const number = (text) => Number.parseFloat(text);
/** Waits until the volume is another. */
const told = (page, exact) => page.waitForFunction((volume) =>
  Math.abs(Number.parseFloat(document.querySelector("#measures td")?.textContent) - volume) < 1e-6, exact);
const picture = (page) => page.evaluate(async () => {
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  return document.getElementById("canvas").toDataURL();
});

/** Clicks where a point of the model is seen. */
async function click(page, point, modifiers = []) {
  const [x, y] = await page.evaluate((at) => stereotomy.seen(at), point);
  const before = await page.evaluate(() => stereotomy.state.answers);
  await page.locator("#canvas").click({ position: { x, y }, modifiers });
  await page.waitForFunction((answers) => stereotomy.state.answers > answers, before);
  return page.locator("#picked").innerText();
}

test("a plate is shown, turns, and says what is clicked", async () => {
  const { page, mistakes } = await opened("plate.csg", PLATE);
  assert.equal(await page.title(), "plate");
  assert.ok(Math.abs(number(await measure(page, "volume")) - volume(3, 4)) < 1e-8);
  assert.equal(await measure(page, "size"), "40 × 20 × 5 mm");
  await page.locator("#density").fill("7.85");
  const mass = number((await page.locator("#mass").innerText()).replace("Mass ", ""));
  assert.ok(Math.abs(mass - 7.85e-3 * volume(3, 4)) < 1e-9, String(mass));
  await page.locator("#density").fill("-1");
  assert.equal(await page.locator("#mass").innerText(), "");

  // Dragging and keys turn it; keys turn it back.
  const first = await picture(page);
  const eye = await page.evaluate(() => stereotomy.eye());
  await page.locator("#canvas").focus();
  await page.keyboard.press("ArrowLeft");
  assert.ok((await picture(page)) !== first);
  await page.keyboard.press("ArrowRight");
  const back = await page.evaluate(() => stereotomy.eye());
  back.forEach((x, k) => assert.ok(Math.abs(x - eye[k]) < 1e-9));
  await page.mouse.move(400, 400);
  await page.mouse.down();
  await page.mouse.move(500, 380, { steps: 4 });
  await page.mouse.up();
  const turned = await page.evaluate(() => stereotomy.eye());
  assert.ok(Math.hypot(...turned.map((x, k) => x - eye[k])) > 5);
  assert.match(await page.locator("#picked").innerText(), /Nothing yet/);

  // From above, in parallel: the mouse is over what it is over.
  await page.keyboard.press("5");
  await page.keyboard.press("p");
  await page.keyboard.press("f");
  const face = await click(page, [0, 0, 2.5]);
  assert.match(face, /plane/);
  assert.match(face, /normal\s+0, 0, 1/);
  assert.ok(Math.abs(number(await measure(page, "area", "#picked table")) - volume(3, 4) / 5) < 1e-9);
  // An edge, and another one: two circles, whose centres are as far apart as the axes.
  const circle = await click(page, [-15, 0, 2.5]);
  assert.match(circle, /circle/);
  assert.match(circle, /radius\s+3 mm/);
  const between = await click(page, [12, 4, 2.5], ["Control"]);
  assert.match(between, /radius\s+4 mm/);
  assert.match(between, /distance, centre to centre\s+24 mm/);
  // Corners.
  assert.match(await click(page, [20, 10, 2.5]), /at\s+20, 10, 2.5/);
  assert.match(await click(page, [-20, -10, 2.5], ["Control"]), /along x, y, z\s+-40, -20, 0/);
  // Nothing.
  const canvas = await page.locator("#canvas").boundingBox();
  await page.mouse.click(canvas.x + 5, canvas.y + 5);
  assert.match(await page.locator("#picked").innerText(), /Nothing/);

  // The wall of a bore, from a corner; and its distance from the other one and from a side.
  await page.keyboard.press("0");
  const wall = await click(page, [12 - 4 * Math.SQRT1_2, 4 * Math.SQRT1_2, 2]);
  assert.match(wall, /cylinder/);
  assert.match(wall, /radius\s+4 mm/);
  assert.match(await click(page, [0, -10, 0], ["Control"]), /distance, axis to plane\s+10 mm[\s\S]*gap between cylinder and plane\s+6 mm/);
  await click(page, [0, 0, 2.5]);
  assert.match(await click(page, [0, -10, 0], ["Control"]), /angle, between the planes\s+90°/);
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("saving makes it again, mistakes are shown and mended, the camera stays", async () => {
  const { page, file, mistakes } = await opened("edited.csg", PLATE);
  await page.locator("#canvas").focus();
  for (const key of ["ArrowUp", "ArrowLeft", "+"]) await page.keyboard.press(key);
  const eye = await page.evaluate(() => stereotomy.eye());
  await writeFile(file, plate(2, 4));
  await told(page, volume(2, 4));
  assert.deepEqual(await page.evaluate(() => stereotomy.eye()), eye);

  await writeFile(file, PLATE.replace("cube(size", "cubbe(size"));
  const problem = page.getByRole("alert");
  await problem.waitFor({ state: "visible" });
  const text = await problem.innerText();
  assert.match(text, /edited\.csg:2:3: `cubbe` cannot be read \(`cube` is meant\?\)/);
  assert.match(text, /2 │ {3}cubbe\(size/);
  // What was there before still is, and can be asked.
  await told(page, volume(2, 4));
  await page.keyboard.press("5");
  assert.match(await click(page, [0, 0, 2.5]), /plane/);
  await writeFile(file, plate(3, 0.5));
  await told(page, volume(3, 0.5));
  await problem.waitFor({ state: "hidden" });

  // A model without an end, and one of which nothing is left.
  await writeFile(file, "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);\n");
  await page.getByText("nothing is left of the model").waitFor();
  await writeFile(file, PLATE);
  await told(page, volume(3, 4));
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("a slider makes the model again", async () => {
  const address = await served(process.env.MODEL, ["--radius", "2", "view", "--no-open"], { STEREOTOMY_VIEW_MODEL: "1", RUST_BACKTRACE: "0" });
  const { page, mistakes } = await visited(address);
  const exact = (radius, holes) => 1000 - 10 * Math.PI * radius ** 2 * holes;
  await told(page, exact(2, 1));
  const radius = page.getByRole("slider", { name: "radius" });
  assert.equal(await radius.inputValue(), "2");
  await radius.focus();
  await page.keyboard.press("ArrowRight");
  await told(page, exact(2.01, 1));
  await radius.fill("1.5");
  await told(page, exact(1.5, 1));
  await page.getByRole("checkbox", { name: "solid" }).check();
  await told(page, 1000);
  await page.getByRole("checkbox", { name: "solid" }).uncheck();
  await told(page, exact(1.5, 1));
  // What the model does not take, and what it dies of.
  await page.getByRole("spinbutton", { name: "radius, as a number" }).fill("-1");
  await page.keyboard.press("Enter");
  await page.getByRole("alert").getByText("give a radius above 0").waitFor();
  await radius.fill("4");
  await page.getByRole("alert").getByText("the model panicked: too wide").waitFor();
  await radius.fill("1");
  await told(page, exact(1, 1));
  await page.getByRole("alert").waitFor({ state: "hidden" });
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("parts are hidden, the plane cuts, edges and faces go", async () => {
  const { page, file, mistakes } = await opened("cut.csg", PLATE);
  await page.locator("#canvas").focus();
  await page.keyboard.press("5");
  const seen = async (point) => (await click(page, point)).replaceAll(/\s+/g, " ");
  assert.match(await seen([0, 0, 2.5]), /normal 0, 0, 1/);
  // Without the block the bores' walls are left; from above they are not seen face on.
  await page.getByLabel("Show only cylinder").click();
  assert.match(await seen([0, 0, 2.5]), /Nothing/);
  // Nor are the block's edges and corners, but for those that it has in common with them.
  assert.match(await seen([20, 0, 2.5]), /Nothing/);
  assert.match(await seen([20, 10, 2.5]), /Nothing/);
  assert.match(await seen([-15, 0, 2.5]), /circle/);
  await page.getByRole("button", { name: "Show all" }).click();
  assert.match(await seen([20, 10, 2.5]), /at 20, 10, 2.5/);
  assert.match(await seen([0, 0, 2.5]), /normal 0, 0, 1/);
  // The bottom is seen where what is above is cut away.
  const cleared = async () => {
    await page.locator("#canvas").focus();
    await page.keyboard.press("Escape");
    return picture(page);
  };
  const whole = await cleared();
  await page.getByRole("button", { name: "Section" }).click();
  await page.getByLabel("Across").selectOption("z");
  await page.getByRole("button", { name: "Other side" }).click();
  const cut = await cleared();
  assert.ok(cut !== whole);
  assert.match(await page.locator("#cut-place").innerText(), /z = 0 mm/);
  assert.match(await seen([0, 0, 0]), /normal 0, 0, -1/);
  await page.getByLabel("Where the section plane is").fill("0.05");
  const place = async () => number((await page.locator("#cut-place").innerText()).replace("z = ", ""));
  const first = await place();
  // A twentieth of the way to the farthest corner.
  assert.ok(Math.abs(first - 0.05 * Math.hypot(20, 10, 2.5)) < 1e-3, String(first));
  // In the picture, along the axis as it is seen.
  await page.locator("#canvas").focus();
  await page.keyboard.press("0");
  await page.keyboard.down("Alt");
  await page.mouse.move(500, 400);
  await page.mouse.down();
  await page.mouse.move(500, 390, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.up("Alt");
  assert.ok((await place()) > first + 0.1);
  await page.keyboard.press("5");
  await page.getByRole("button", { name: "Section" }).click();
  assert.ok((await cleared()) === whole);
  await page.getByRole("button", { name: "Edges" }).click();
  assert.ok((await cleared()) !== whole);
  await page.getByRole("button", { name: "Edges" }).click();
  // Keys do what they do beside a button, too, in capitals as well; the button has what presses it.
  await page.getByRole("button", { name: "Faces" }).click();
  assert.match(await seen([0, 0, 2.5]), /Nothing/);
  await page.getByRole("button", { name: "Faces" }).focus();
  await page.keyboard.press("A");
  assert.match(await seen([0, 0, 2.5]), /normal 0, 0, 1/);
  await page.getByRole("button", { name: "Faces" }).focus();
  await page.keyboard.press("Enter");
  assert.match(await seen([0, 0, 2.5]), /Nothing/);
  // Of another model the same parts are open and hidden.
  await page.getByText("cylinder2 faces").click();
  await page.getByRole("button", { name: "cylinder, radius 3", exact: true }).waitFor();
  await page.getByLabel("Show cuboid").uncheck();
  await writeFile(file, plate(3.5, 4));
  await page.getByRole("button", { name: "cylinder, radius 3.5", exact: true }).waitFor();
  assert.equal(await page.getByLabel("Show cuboid").isChecked(), false);
  assert.deepEqual(mistakes, []);
  await page.close();
});

/** The texts of the dimensions that are drawn. */
const drawn = async (page) => {
  await picture(page);
  return page.evaluate(() => stereotomy.drawing.dimensions.drawn.map(({ text }) => text));
};

test("sizes are drawn as in drawings, beside the model, and can be read from everywhere", async () => {
  for (const colorScheme of ["light", "dark"]) {
    const { page, file, mistakes } = await opened(`sizes-${colorScheme}.csg`, PLATE, { colorScheme });
    const before = await picture(page);
    await page.locator("#canvas").focus();
    await page.keyboard.press("d");
    assert.equal(await page.getByRole("button", { name: "Dimensions" }).getAttribute("aria-pressed"), "true");
    assert.deepEqual(await drawn(page), ["40 mm", "20 mm", "5 mm"]);
    assert.ok((await picture(page)) !== before);
    const svg = spawnSync(process.env.CSG, ["drawing", file, "--dimensions", "--view", "top", "-o", "-"], { encoding: "utf8" }).stdout;
    const texts = [...svg.matchAll(/>([^<>]+ mm)</g)].map(([, text]) => text);
    assert.ok(texts.includes("40 mm") && texts.includes("20 mm"), String(texts));
    // Numbers follow the camera, are in the picture, have nothing of the model behind them, and are upright.
    const places = new Set();
    const views = ["0", "1", "2", "3", "4", "5", "6", "0 ArrowLeft ArrowLeft ArrowUp", "0 ArrowDown ArrowDown ArrowDown ArrowDown ArrowRight"];
    for (const keys of [...views, "p", ...views]) {
      for (const key of keys.split(" ")) await page.keyboard.press(key);
      await page.keyboard.press("f");
      await picture(page);
      const numbers = await page.evaluate(() => stereotomy.drawing.dimensions.drawn.map(({ text, seen, layout }) => ({
        text, seen, turn: layout.label.turn, behind: stereotomy.picked(...seen),
      })));
      // Of the axis along which one looks there is nothing to be seen.
      assert.ok(numbers.length === 3 || (numbers.length === 2 && /^[1-6p]$/.test(keys)), `${keys}: ${numbers.length}`);
      for (const { text, seen: [x, y], turn, behind } of numbers) {
        assert.ok(x > 20 && x < 930 && y > 10 && y < 750, `${keys}: ${text} at ${x}, ${y}`);
        assert.equal(behind, null, `${keys}: ${text}`);
        // (Upwards, a little beyond is no harm.)
        assert.ok(Math.abs(turn) < 1.9, `${keys}: ${text} is turned by ${turn}`);
        places.add(`${text} ${x.toFixed(1)} ${y.toFixed(1)}`);
      }
    }
    assert.ok(places.size > 25, String(places.size));
    // They are in the picture that is saved: of their colour beside the number there is something.
    const inked = async () => {
      const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Picture" }).click()]);
      const png = (await readFile(await download.path())).toString("base64");
      return page.evaluate(async (data) => {
        const image = new Image();
        image.src = `data:image/png;base64,${data}`;
        await image.decode();
        const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
        context.drawImage(image, 0, 0);
        const [x, y] = stereotomy.drawing.dimensions.drawn[0]?.seen ?? [0, 0];
        const { data: pixels } = context.getImageData(x - 20, y - 20, 40, 40);
        let bluish = 0;
        for (let k = 0; k < pixels.length; k += 4) bluish += pixels[k + 2] > pixels[k] + 60;
        return bluish;
      }, png);
    };
    assert.ok((await inked()) > 40);
    await page.getByRole("button", { name: "Dimensions" }).click();
    assert.deepEqual(await drawn(page), []);
    assert.equal(await inked(), 0);
    await page.getByRole("button", { name: "Dimensions" }).click();
    // Of what is shown alone: the two bores.
    await page.getByLabel("Show only cylinder").click();
    assert.deepEqual(await drawn(page), ["31 mm", "8 mm", "5 mm"]);
    assert.deepEqual(mistakes, []);
    await page.close();
  }
});

test("what is picked is drawn, and stays if it is kept", async () => {
  const { page, file, mistakes } = await opened("kept.csg", PLATE);
  await page.locator("#canvas").focus();
  await page.keyboard.press("d");
  const sizes = ["40 mm", "20 mm", "5 mm"];
  // The wall of a bore; two circles; two planes.
  await click(page, [12 - 4 * Math.SQRT1_2, 4 * Math.SQRT1_2, 2]);
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm"]);
  await page.getByRole("button", { name: "Keep radius in the picture" }).click();
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm"]);
  await click(page, [-15, 0, 2.5]);
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm", "⌀6 mm"]);
  await click(page, [12, 4, 2.5], ["Control"]);
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm", "24 mm"]);
  await page.getByRole("button", { name: "Keep distance, centre to centre in the picture" }).click();
  await click(page, [0, 0, 2.5]);
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm", "24 mm"]);
  await click(page, [0, -10, 0], ["Control"]);
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm", "24 mm", "90°"]);
  // The line of a distance is as long as it says, and as far apart as what it measures.
  const line = await page.evaluate(() => {
    const { drawn } = stereotomy.drawing.dimensions;
    // (First two lines that lead there, then the line itself.)
    const [, , , , from, to] = drawn.find(({ text }) => text === "24 mm").layout.segments;
    return [from.distanceTo(to), Math.abs(to.x - from.x)];
  });
  for (const length of line) assert.ok(Math.abs(length - 24) < 1e-9, String(line));
  await page.locator("#canvas").focus();
  await page.keyboard.press("Escape");
  assert.deepEqual(await drawn(page), [...sizes, "⌀8 mm", "24 mm"]);
  // Another model: measured again, and left out where it has other faces.
  await writeFile(file, plate(3, 4.5).replace("40, 20, 5", "50, 20, 5"));
  await page.waitForFunction(() => stereotomy.drawing.dimensions.drawn.some(({ text }) => text === "⌀9 mm"));
  assert.deepEqual(await drawn(page), ["50 mm", "20 mm", "5 mm", "⌀9 mm", "24 mm"]);
  await page.getByRole("button", { name: "Remove distance, centre to centre" }).click();
  assert.deepEqual(await drawn(page), ["50 mm", "20 mm", "5 mm", "⌀9 mm"]);
  await writeFile(file, "cube(size = [10, 20, 30], center = true);");
  await page.waitForFunction(() => stereotomy.drawing.dimensions.drawn[0]?.text === "10 mm");
  assert.deepEqual(await drawn(page), ["10 mm", "20 mm", "30 mm"]);
  assert.equal(await page.getByText("Kept dimensions").isVisible(), false);
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("dimensions that are kept are in rows", async () => {
  const third = "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cylinder(h = 10, r1 = 2, r2 = 2, center = true); }";
  const { page, mistakes } = await opened("rows.csg", PLATE.replace(/\}\n$/, `${third} }`));
  await page.locator("#canvas").focus();
  for (const key of "5df") await page.keyboard.press(key);
  const rims = [[-15, 0, 2.5], [-2, 0, 2.5], [8, 0, 2.5]];
  for (const [one, other] of [[0, 1], [1, 2], [0, 2]]) {
    await click(page, rims[one]);
    await click(page, rims[other], ["Control"]);
    await page.getByRole("button", { name: "Keep distance, centre to centre" }).click();
  }
  for (const rim of rims) {
    await click(page, rim);
    await page.getByRole("button", { name: "Keep radius" }).click();
  }
  await page.locator("#canvas").focus();
  await page.keyboard.press("Escape");
  // (Its height is not seen from above.)
  assert.equal((await drawn(page)).length, 8);
  /** Where each number is, how it lies, and how large it is; and the lines' own places, from above. */
  const laidOut = () => page.evaluate(() => stereotomy.drawing.dimensions.drawn.map(({ text, color, seen: [x, y], layout: { label, segments } }) => {
    const { width, height } = [...stereotomy.drawing.dimensions.labels].find(([key]) => key.endsWith(` ${color} ${text}`))[1].userData;
    return { text, turn: label.turn, width: width - 8, height: height - 8, x: x + label.side * width / 2, y, line: segments[4]?.y };
  }));
  const isOn = (number, [x, y]) => {
    const [cos, sin] = [Math.cos(number.turn), -Math.sin(number.turn)];
    const [dx, dy] = [x - number.x, y - number.y];
    return Math.abs(dx * cos + dy * sin) < number.width / 2 && Math.abs(dy * cos - dx * sin) < number.height / 2;
  };
  for (const key of ["5", "0", "1", "3", "ArrowUp", "ArrowLeft", "p"]) {
    await page.keyboard.press(key);
    await picture(page);
    const numbers = await laidOut();
    // (Distances at whose ends one looks are not drawn.)
    assert.equal(numbers.length, { 5: 8, 1: 8, 3: 5, 0: 9 }[key] ?? numbers.length);
    for (const one of numbers) {
      const along = Array.from({ length: 21 }, (_, k) => (k - 10) / 20 * one.width);
      for (const other of numbers) {
        const met = other !== one && along.some((off) => isOn(other, [one.x + off * Math.cos(one.turn), one.y - off * Math.sin(one.turn)]));
        assert.ok(!met, `${key}: ${one.text} is on ${other.text}`);
      }
    }
  }
  // From above: the two short ones in one row, the long one below, and the size below that.
  for (const key of "5pf") await page.keyboard.press(key);
  await picture(page);
  const numbers = await laidOut();
  const [short, other, long, whole] = ["12 mm", "12 mm", "24 mm", "40 mm"].map((name, k) =>
    numbers.filter(({ text }) => text === name)[k === 1 ? 1 : 0].line);
  assert.ok(short === other && short > long && long > whole, JSON.stringify(numbers));
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("every format is downloaded, and the picture", async () => {
  const { page, mistakes } = await opened("files.csg", PLATE);
  const begins = {
    step: "ISO-10303-21;", glb: "glTF", gltf: "{", "3mf": "PK", stl: "", obj: "", ply: "ply\n", off: "OFF", csg: "difference()",
  };
  const select = page.getByLabel("Download a file");
  const offered = await select.locator("option").evaluateAll((options) => options.map((option) => option.value).filter(Boolean));
  assert.deepEqual(offered.sort(), Object.keys(begins).sort());
  for (const [format, begin] of Object.entries(begins)) {
    const [download] = await Promise.all([page.waitForEvent("download"), select.selectOption(format)]);
    assert.equal(download.suggestedFilename(), `files.${format}`);
    const bytes = await readFile(await download.path());
    assert.ok(bytes.length > 100 && bytes.subarray(0, begin.length).equals(Buffer.from(begin)), format);
    if (format === "stl") assert.equal(bytes.length, 84 + 50 * bytes.readUInt32LE(80));
    if (format === "gltf") {
      const { buffers } = JSON.parse(bytes);
      assert.equal(Buffer.from(buffers[0].uri.split(",")[1], "base64").length, buffers[0].byteLength);
    }
    if (format === "step") assert.equal(String(bytes).match(/CYLINDRICAL_SURFACE/g).length, 2);
  }
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Picture" }).click()]);
  const png = await readFile(await download.path());
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("it is dark where the user wants that, and has names for who hears it", async () => {
  const { page, mistakes } = await opened("dark.csg", PLATE, { colorScheme: "dark" });
  const brightness = (color) => Math.max(...color.match(/\d+/g).slice(0, 3).map(Number));
  const colors = await page.evaluate(() => {
    const style = getComputedStyle(document.body);
    return [style.backgroundColor, style.color];
  });
  assert.ok(brightness(colors[0]) < 60 && brightness(colors[1]) > 200, String(colors));
  const corner = () => page.evaluate(() => {
    const gl = document.getElementById("canvas").getContext("webgl2");
    const pixel = new Uint8Array(4);
    gl.readPixels(2, 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel];
  });
  assert.ok(Math.max(...(await corner()).slice(0, 3)) < 60);
  await page.emulateMedia({ colorScheme: "light" });
  await picture(page);
  assert.ok(Math.min(...(await corner()).slice(0, 3)) > 200);
  // Whatever takes the focus has a name.
  for (const control of await page.locator(":is(button, select, input, canvas, summary):visible").all()) {
    const tree = await control.ariaSnapshot();
    assert.match(tree, /"[^"]+"|: \S|- text|- application/, tree);
  }
  assert.match(await page.locator("#canvas").getAttribute("aria-label"), /Arrow keys turn/);
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("the first picture is what the page draws", async () => {
  // A round part with faces of its own colours, and one wholly without edges.
  const models = [
    ["plate", `color([0.8, 0.2, 0.1]) { ${PLATE} }`, "light"],
    ["ball", "sphere(r = 7);", "dark"],
  ];
  for (const [name, text, colorScheme] of models) {
    const { page, mistakes } = await opened(`first-${name}.csg`, text, { colorScheme });
    assert.equal(await page.locator(".first").count(), 0, "the page's own drawing is in its place");
    // As large as the picture itself.
    await page.locator("#stage").evaluate((stage) => Object.assign(stage.style, { flex: "none", width: "640px", height: "640px" }));
    await page.waitForFunction(() => document.getElementById("canvas").width === 640);
    await page.keyboard.press("f");
    await picture(page);
    const { size, off, far } = await page.evaluate(async (theme) => {
      const canvas = document.getElementById("canvas");
      const { width, height } = canvas;
      const pixels = (image) => {
        const context = new OffscreenCanvas(width, height).getContext("2d");
        context.fillStyle = getComputedStyle(document.body).backgroundColor;
        context.fillRect(0, 0, width, height);
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, width, height).data;
      };
      const text = await (await fetch("./")).text();
      const told = new Image();
      told.src = new DOMParser().parseFromString(text, "text/html").querySelector(`.first.${theme}`).src;
      await told.decode();
      const [one, other] = [pixels(canvas), pixels(told)];
      let [sum, far] = [0, 0];
      for (let k = 0; k < one.length; k++) {
        sum += Math.abs(one[k] - other[k]);
        far += Math.abs(one[k] - other[k]) > 32;
      }
      return { size: [width, height, told.width, told.height], off: sum / one.length, far: far / one.length };
    }, colorScheme);
    assert.deepEqual(size, [640, 640, 640, 640]);
    // Lines are filtered otherwise; faces are the same within how numbers are rounded.
    if (process.env.SHOT) console.log(name, colorScheme, off, far);
    assert.ok(off < 0.5 && far < 0.005, `${name}, ${colorScheme}: ${off} levels off, ${far} far off`);
    assert.deepEqual(mistakes, []);
    await page.close();
  }
});

test("the first picture is on a page whose script never comes", async () => {
  const file = join(folder, "alone.csg");
  await writeFile(file, PLATE);
  const address = await served(process.env.CSG, ["view", file, "--no-open"]);
  for (const colorScheme of ["light", "dark"]) {
    // Wider than high, and higher than wide.
    const viewport = colorScheme === "light" ? { width: 1280, height: 700 } : { width: 900, height: 1000 };
    const page = await browser.newPage({ colorScheme, viewport });
    await page.route("**/*.js", (route) => route.abort());
    await page.goto(address);
    assert.equal(await page.locator(".first:visible").count(), 1);
    assert.match(await page.locator(".first:visible").getAttribute("class"), new RegExp(colorScheme));
    const told = await page.locator("#stage").screenshot();
    await page.unroute("**/*.js");
    await page.reload();
    await page.waitForFunction(() => globalThis.stereotomy && stereotomy.state.account !== null);
    await picture(page);
    const drawn = await page.locator("#stage").screenshot();
    const off = await page.evaluate(async (both) => {
      const [one, other] = await Promise.all(both.map(async (bytes) => {
        const image = new Image();
        image.src = `data:image/png;base64,${bytes}`;
        await image.decode();
        const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, image.width, image.height).data;
      }));
      return one.reduce((sum, level, k) => sum + Math.abs(level - other[k]), 0) / one.length;
    }, [told, drawn].map((png) => png.toString("base64")));
    // It is enlarged or made smaller, and nothing moves.
    if (process.env.SHOT) console.log(colorScheme, off);
    assert.ok(off < 1, `${colorScheme}: ${off} levels off`);
    await page.close();
  }
});

test("a million triangles turn without any being sent to the graphics card again", async () => {
  const balls = Array.from({ length: 216 }, (_, k) =>
    `multmatrix([[1, 0, 0, ${3 * (k % 6)}], [0, 1, 0, ${3 * (Math.floor(k / 6) % 6)}], [0, 0, 1, ${3 * Math.floor(k / 36)}], [0, 0, 0, 1]]) { sphere(r = 1); }`);
  const { page, mistakes } = await opened("balls.csg", balls.join("\n"), {}, ["--tolerance", "0.001"]);
  await page.waitForFunction(() => stereotomy.drawing.cost > 0);
  const turned = await page.evaluate(async () => {
    const { drawing, state } = stereotomy;
    const gl = document.getElementById("canvas").getContext("webgl2");
    const { info } = drawing.renderer;
    let sent = 0;
    for (const name of ["bufferData", "bufferSubData"]) {
      const plain = gl[name].bind(gl);
      gl[name] = (...all) => { sent++; plain(...all); };
    }
    const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const turn = async (step) => {
      Object.assign(drawing, { step, wasSlow: false });
      const before = info.render.frame;
      stereotomy.turn(0.1);
      while (info.render.frame === before) await frame();
      const { calls, triangles } = info.render;
      const { width } = canvas;
      // (What this one has cost is not learned by the next one.)
      gl.finish();
      await new Promise((done) => setTimeout(done, 50));
      return { calls, triangles, width };
    };
    const now = performance.now.bind(performance);
    const canvas = document.getElementById("canvas");
    const triangles = state.model.corners.length / 3;
    const fewer = state.model.simplifiedCorners.map((corners) => corners.length / 3);
    // On a fast machine, on slower ones, and when the camera has come to rest.
    const turns = [];
    for (const step of [0, 1, 2, 3]) turns.push(await turn(step));
    const whole = canvas.clientWidth;
    // All of them again, as soon as the last frame in motion is done and nothing has moved for a while.
    const rested = async () => {
      const end = now() + 15_000;
      while (info.render.triangles !== triangles && now() < end) await frame();
      return { triangles: info.render.triangles, width: canvas.width };
    };
    const rest = await rested();
    // Frames that take too long make those that follow coarser, one that does so alone does not.
    Object.assign(drawing, { step: 0, wasSlow: false, lastEnd: 0 });
    let clock = 0;
    const steps = [];
    const draw = async (cost) => {
      performance.now = () => (clock += cost);
      await drawing.drawMoving(stereotomy.camera());
      steps.push(drawing.step);
    };
    for (const cost of [100, 10, 100, 100, 10, 10, 100, 100, 100, 100]) await draw(cost);
    delete performance.now;
    await turn(3);
    return { triangles, fewer, turns, whole, rest, steps, again: await rested(), sent };
  });
  if (process.env.SHOT) console.log(JSON.stringify(turned));
  const { triangles, fewer, turns, whole, rest, steps, again, sent } = turned;
  assert.ok(triangles > 1e6, String(triangles));
  assert.ok(fewer.length === 2 && fewer[0] > 2e4 && fewer[0] <= 1e5 && fewer[1] > 2e3 && fewer[1] <= 1e4, String(fewer));
  assert.deepEqual(turns.map((one) => one.triangles), [triangles, ...fewer, fewer[1]]);
  // The coarsest with half as many pixels a side, or a third.
  assert.deepEqual(turns.map((one) => one.width), [1, 1, 2, 3].map((part) => Math.floor(whole / part)));
  for (const end of [rest, again]) assert.deepEqual(end, { triangles, width: whole });
  assert.deepEqual(steps, [0, 0, 0, 1, 1, 1, 1, 2, 2, 3]);
  // Faces and edges, each in one.
  assert.ok(turns.every(({ calls }) => calls <= 2), JSON.stringify(turns));
  // (The numbers of the fewer ones go there once.)
  assert.ok(sent <= 2, `${sent} buffers sent`);
  assert.deepEqual(mistakes, []);
  await page.close();
});

test("a browser without WebGL says so", async () => {
  const file = join(folder, "no-webgl.csg");
  await writeFile(file, PLATE);
  const address = await served(process.env.CSG, ["view", file, "--no-open"]);
  const page = await browser.newPage();
  await page.addInitScript(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more);
    };
  });
  await page.goto(address);
  await page.getByRole("alert").getByText("cannot draw in 3D").waitFor();
  // What the program drew is there.
  assert.equal(await page.locator(".first:visible").count(), 1);
  await page.close();
});

test("where there is no first picture, the page begins all the same", async () => {
  const file = join(folder, "no-picture.csg");
  await writeFile(file, "cube(size = [1, 1, 1]");
  const { page, mistakes } = await visited(await served(process.env.CSG, ["view", file, "--no-open"]), {}, false);
  await page.locator("#problem").waitFor();
  await writeFile(file, "cube(size = [1, 1, 1], center = true);");
  await page.waitForFunction(() => stereotomy.state.account !== null);
  assert.equal(await page.locator(".first").count(), 0);
  assert.deepEqual(mistakes, []);
  await page.close();
});
