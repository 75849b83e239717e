// Validates the files named on the command line with the Khronos glTF
// validator and prints one JSON line of issue counts and messages for each.
// Run with the folder that holds node_modules as NODE_PATH.
"use strict";
const fs = require("fs");
const path = require("path");
const validator = require("gltf-validator");

async function main() {
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
      uri: path.basename(file),
      maxIssues: 20,
      externalResourceFunction: async (uri) =>
        new Uint8Array(
          fs.readFileSync(path.resolve(path.dirname(file), decodeURIComponent(uri)))
        ),
    });
    const { numErrors, numWarnings, messages } = report.issues;
    const { totalVertexCount, totalTriangleCount, materialCount } = report.info;
    console.log(
      JSON.stringify({
        file, numErrors, numWarnings, messages,
        totalVertexCount, totalTriangleCount, materialCount,
      })
    );
  }
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
