// What the module says of scenes: a line of JSON for each file that is named.
// models.mjs MODULE.js PLAYGROUND.wasm SCENE…
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [module, wasm, ...scenes] = process.argv.slice(2);
const { instance } = await import(pathToFileURL(module));
const compiled = await WebAssembly.compile(readFileSync(wasm));
for (const scene of scenes) {
  const drawn = [];
  const ask = await instance(compiled, (bytes) => drawn.push(bytes.byteLength));
  const said = (question) => {
    try {
      return JSON.parse(new TextDecoder().decode(ask(question)));
    } catch (error) {
      return error.message;
    }
  };
  const start = performance.now();
  const problem = said({ ask: "make", text: readFileSync(scene, "utf8") });
  const seconds = (performance.now() - start) / 1e3;
  console.log(JSON.stringify({ problem, account: said({ ask: "account" }), drawn, seconds }));
}
