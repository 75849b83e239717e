// The playground in a browser, from a server of plain files. The environment names the folder
// and the browser: PLAYGROUND, CHROMIUM.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { test } from "node:test";
import { chromium } from "playwright-core";

const KINDS = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".wasm": "application/wasm" };

test("a scene is edited, shown, asked, and saved", async () => {
  const server = createServer(async ({ url }, response) => {
    try {
      const name = url === "/" ? "/index.html" : url;
      const bytes = await readFile(join(process.env.PLAYGROUND, name));
      response.writeHead(200, { "content-type": KINDS[extname(name)] ?? "text/plain" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const found = spawnSync("sh", ["-c", `command -v ${process.env.CHROMIUM}`], { encoding: "utf8" }).stdout.trim();
  const browser = await chromium.launch({
    executablePath: found, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
  try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    const mistakes = [];
    page.on("pageerror", (error) => mistakes.push(String(error)));
    await page.addInitScript(() => {
      globalThis.workers = [];
      globalThis.Worker = class extends Worker {
        constructor(...all) {
          super(...all);
          workers.push(this);
        }
      };
    });
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    const told = (volume) => page.waitForFunction((exact) =>
      Math.abs(Number.parseFloat(document.querySelector("#measures td")?.textContent) - exact) < 1e-9, volume);
    // The flange, to begin with.
    await told(0.709425518258427);
    const text = page.getByRole("textbox", { name: "The scene's text" });
    assert.match(await text.inputValue(), /difference|union|group/);
    await text.fill("difference() { cube(size = [4, 4, 4], center = true); cylinder(h = 5, r1 = 1, r2 = 1, center = true); }");
    await told(64 - 4 * Math.PI);
    await page.getByRole("button", { name: "Fit" }).click();
    const [x, y] = await page.evaluate(() => stereotomy.seen([1.5, 0, 2]));
    await page.locator("#canvas").click({ position: { x, y } });
    await page.waitForFunction(() => stereotomy.state.answers > 0);
    assert.match(await page.locator("#picked").innerText(), /face\s+plane/);
    await text.fill("cube(size = [4, 4, 4]\n");
    const problem = page.getByRole("alert");
    await problem.getByText("line 2, column 1").waitFor();
    await text.fill("sphere(r = 2);");
    await told(32 / 3 * Math.PI);
    await problem.waitFor({ state: "hidden" });
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByLabel("Download a file").selectOption("step")]);
    assert.match(String(await readFile(await download.path())), /SPHERICAL_SURFACE/);
    // A worker that breaks off is replaced; one that cannot be had is told.
    assert.equal(await page.evaluate(() => workers.length), 1);
    await page.evaluate(() => workers[0].onmessage({ data: { id: 0, problem: "unreachable", isBroken: true } }));
    await page.route("**/worker.js", (route) => route.abort());
    await text.fill("sphere(r = 3);");
    await problem.getByText("worker.js does not run").waitFor();
    await page.unroute("**/worker.js");
    await text.fill("sphere(r = 1);");
    await told(4 / 3 * Math.PI);
    await problem.waitFor({ state: "hidden" });
    assert.equal(await page.evaluate(() => workers.length), 3);
    if (process.env.SHOT) await page.screenshot({ path: process.env.SHOT });
    assert.deepEqual(mistakes, []);
  } finally {
    await browser.close();
    server.close();
  }
});
