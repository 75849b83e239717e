// How long from the command to the first picture on the page, and how long a frame takes.
// CSG=target/release/csg CHROMIUM=chromium node tests/cold.js MODEL [RUNS] [OPTION…]
//
// The browser runs already, but for the last line. Each time csg is started anew, and the page opened
// in a context of its own, without a cache. Told are the medians and the least and greatest, in
// milliseconds since the command:
//
// address      the program has printed the page's address
// page         the browser begins with the page
// picture      the program's picture of the model is on the screen, as the browser tells it
//              (element timing)
// interactive  the page itself has drawn the model, and its pixels were read back
// fine         the same of the fine mesh with its exact boundary
// frame        how long one frame takes
// moving       the same while the camera moves, of more than 200,000 triangles, once it is known how
//              coarse frames must be
// no browser   as picture, by a browser that is started once the address is there, with a new profile
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync } from "node:fs";
import { rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const [model, runs = "9", ...options] = process.argv.slice(2);
const executablePath = spawnSync("sh", ["-c", `command -v ${process.env.CHROMIUM}`], { encoding: "utf8" }).stdout.trim();
const args = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const times = { address: [], page: [], picture: [], interactive: [], fine: [], frame: [], moving: [], "no browser": [] };

/** Starts csg; gives it and the page's address. */
async function served() {
  const program = spawn(process.env.CSG, ["view", model, "--no-open", ...options], { stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise((done) => program.stdout.once("data", (data) => done(String(data).trim().split("\n")[0])));
  return { program, address };
}

/** When the first picture was on the screen of a browser that was not there before. */
async function withoutBrowser() {
  const profile = mkdtempSync(join(tmpdir(), "cold-"));
  const start = Date.now();
  const { program, address } = await served();
  const started = spawn(executablePath, [
    ...args, "--headless=new", "--no-first-run", "--window-size=1280,800", "--remote-debugging-port=0", `--user-data-dir=${profile}`, address,
  ], { stdio: "ignore" });
  const ended = new Promise((done) => started.once("exit", done));
  // (It is asked when all is over.)
  await new Promise((done) => setTimeout(done, 5000));
  const [port] = readFileSync(join(profile, "DevToolsActivePort"), "utf8").split("\n");
  const browser = await chromium.connectOverCDP(`http://127.0.0.1:${port}`);
  const page = browser.contexts()[0].pages().find((one) => one.url() === address);
  const seen = await page.evaluate(() => new Promise((done) => {
    new PerformanceObserver((list) => done(performance.timeOrigin + list.getEntries()[0].renderTime)).observe({ type: "element", buffered: true });
    // (A model that takes long has no such picture.)
    setTimeout(() => done(NaN), 1000);
  }));
  await browser.close();
  started.kill();
  await ended;
  program.kill();
  // (Its children may write for a moment more.)
  await rm(profile, { recursive: true, force: true, maxRetries: 20, retryDelay: 100 });
  return seen - start;
}

const browser = await chromium.launch({ executablePath, args });
let triangles = "";
try {
  // (The first context of a browser takes longer.)
  await (await browser.newContext()).close();
  for (let run = 0; run < Number(runs); run++) {
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
    const page = await context.newPage();
    await page.addInitScript(() => {
      globalThis.seen = { page: Date.now() };
      new PerformanceObserver((list) => {
        for (const { renderTime } of list.getEntries()) seen.picture = performance.timeOrigin + renderTime;
      }).observe({ type: "element", buffered: true });
      new MutationObserver(() => {
        const { revision } = document.documentElement.dataset;
        const gl = document.getElementById("canvas").getContext("webgl2");
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        seen.interactive ??= Date.now();
        if (revision === "2") seen.fine ??= Date.now();
      }).observe(document, { attributes: true, subtree: true, attributeFilter: ["data-revision"] });
    });
    const start = Date.now();
    const { program, address } = await served();
    times.address.push(Date.now() - start);
    await page.goto(address, { waitUntil: "commit" });
    await page.waitForFunction(() => globalThis.seen?.fine, null, { timeout: 120_000 });
    const seen = await page.evaluate(() => globalThis.seen);
    for (const name of ["page", "picture", "interactive", "fine"]) times[name].push(seen[name] - start);
    const heavy = await page.evaluate(() => stereotomy.state.model.simplifiedCorners.length > 0);
    if (heavy) await page.waitForFunction(() => stereotomy.drawing.cost > 0);
    times.frame.push(await page.evaluate((count) => stereotomy.frames(count), heavy ? 3 : 20));
    if (heavy) {
      await page.evaluate(async () => {
        const end = performance.now() + 3000;
        while (performance.now() < end) {
          stereotomy.turn(0.01);
          await new Promise((done) => requestAnimationFrame(done));
        }
      });
    }
    times.moving.push(await page.evaluate(() => stereotomy.frames(20, true)));
    await page.waitForFunction(() => stereotomy.state.account !== null, null, { timeout: 120_000 });
    triangles = await page.locator("#report td").first().innerText();
    program.kill();
    await context.close();
  }
} finally {
  await browser.close();
}
for (let run = 0; run < Number(runs); run++) times["no browser"].push(await withoutBrowser());
console.log(`${model}: ${triangles} triangles, ${runs} runs`);
for (const [name, list] of Object.entries(times)) {
  const sorted = list.toSorted((a, b) => a - b);
  const [least, median, greatest] = [sorted[0], sorted[sorted.length >> 1], sorted.at(-1)].map((x) => x.toFixed(0).padStart(6));
  console.log(`${name.padEnd(12)}${median}  (${least} to ${greatest})`);
}
