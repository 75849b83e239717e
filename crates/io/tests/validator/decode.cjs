// Decodes the files named on the command line with gltf-transform and meshoptimizer, and prints
// one JSON line for each: its volume, how many triangles it has, and what it is compressed with.
"use strict";
const { NodeIO } = require("@gltf-transform/core");
const { EXTMeshoptCompression, KHRMeshQuantization } = require("@gltf-transform/extensions");
const { MeshoptDecoder } = require("meshoptimizer");

async function main() {
  await MeshoptDecoder.ready;
  const io = new NodeIO()
    .registerExtensions([EXTMeshoptCompression, KHRMeshQuantization])
    .registerDependencies({ "meshopt.decoder": MeshoptDecoder });
  for (const file of process.argv.slice(2)) {
    const root = (await io.read(file)).getRoot();
    let volume = 0;
    let triangles = 0;
    let worst = 0;
    for (const node of root.listNodes().filter((node) => node.getMesh())) {
      const m = node.getWorldMatrix();
      const at = (p) => [0, 1, 2].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
      for (const primitive of node.getMesh().listPrimitives()) {
        const places = primitive.getAttribute("POSITION");
        const indices = primitive.getIndices();
        triangles += indices.getCount() / 3;
        for (let k = 0; k < indices.getCount(); k += 3) {
          const [a, b, c] = [0, 1, 2].map((i) => at(places.getElement(indices.getScalar(k + i), [])));
          volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
            a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
        }
        const normals = primitive.getAttribute("NORMAL");
        for (let k = 0; normals && k < normals.getCount(); k++) {
          worst = Math.max(worst, Math.abs(Math.hypot(...normals.getElement(k, [])) - 1));
        }
      }
    }
    const extensions = root.listExtensionsRequired().map((extension) => extension.extensionName);
    console.log(JSON.stringify({ volume, triangles, worst, extensions: extensions.sort() }));
  }
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
