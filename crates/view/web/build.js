// Makes the script of the page, and the licences of what is in it, in the folder that is named
// first; or those of the playground, if `playground` is named second.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [out, kind] = process.argv.slice(2);
const scripts = kind === "playground" ? { view: "src/playground.js", worker: "src/worker.js" } : { view: "src/main.js" };
const { metafile } = await build({
  absWorkingDir: here,
  entryPoints: scripts,
  bundle: true,
  minify: true,
  format: "esm",
  target: ["es2022"],
  legalComments: "none",
  metafile: true,
  outdir: out,
});
const names = Object.keys(metafile.inputs).map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path)?.[1]);
const licences = [...new Set(names)].filter(Boolean).sort().map((name) => {
  const folder = join(here, "node_modules", name);
  const { version, homepage } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  return `${name} ${version} (${homepage})\n\n${readFileSync(join(folder, "LICENSE"), "utf8").trim()}\n`;
});
writeFileSync(join(out, "LICENSES.txt"), `view.js has parts of:\n\n${licences.join("\n")}`);
