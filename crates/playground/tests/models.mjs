// What the module says of scenes, and of every file that it makes of them a checksum: a line of
// JSON for each scene that is named. With KEEP, the name of a folder, the files stay there.
// models.mjs MODULE.js PLAYGROUND.wasm FORMAT,… SCENE…
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [module, wasm, formats, ...scenes] = process.argv.slice(2);
const { instance } = await import(pathToFileURL(module));
const compiled = await WebAssembly.compile(readFileSync(wasm));

/** Length and FNV-1a of bytes, as in `same.rs`. */
function sum(buffer) {
  const bytes = new Uint8Array(buffer);
  let hash = 0x811c9dc5;
  for (let k = 0; k < bytes.length; k++) hash = Math.imul(hash ^ bytes[k], 0x01000193);
  return `${bytes.length} bytes, ${(hash >>> 0).toString(16)}`;
}

for (const [number, scene] of scenes.entries()) {
  const drawn = [];
  const ask = await instance(compiled, (bytes) => drawn.push(sum(bytes)));
  const said = (question, read) => {
    try {
      return read(ask(question));
    } catch (error) {
      return error.message;
    }
  };
  // As text: numbers are to stay as they are written.
  const text = (bytes) => new TextDecoder().decode(bytes);
  const start = performance.now();
  const problem = said({ ask: "make", text: readFileSync(scene, "utf8") }, text);
  const seconds = (performance.now() - start) / 1e3;
  const files = formats.split(",").map((format) => said({ ask: "file", format }, (bytes) => {
    if (process.env.KEEP) writeFileSync(join(process.env.KEEP, `${number}.${format}`), new Uint8Array(bytes));
    return sum(bytes);
  }));
  console.log(JSON.stringify({ problem, account: said({ ask: "account" }, text), drawn, files, seconds }));
}
