// Decodes the files named on the command line with gltf-transform and meshoptimizer, and prints
// one JSON line for each: its volume, how many triangles it has, and what it is compressed with.
"use strict";
const { NodeIO } = require("@gltf-transform/core");
const { EXTMeshGPUInstancing, EXTMeshoptCompression, KHRMeshQuantization } = require("@gltf-transform/extensions");
const { MeshoptDecoder } = require("meshoptimizer");

// Where each instance of a node's mesh is, within the node.
function places(node) {
  const instances = node.getExtension("EXT_mesh_gpu_instancing");
  if (!instances) return [(p) => p];
  const [moves, turns] = ["TRANSLATION", "ROTATION"].map((name) => instances.getAttribute(name));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  return Array.from({ length: moves.getCount() }, (_, k) => {
    const t = moves.getElement(k, []);
    const q = turns ? turns.getElement(k, []) : [0, 0, 0, 1];
    return (p) => {
      const u = cross(q, p).map((x) => 2 * x);
      const v = cross(q, u);
      return [0, 1, 2].map((r) => p[r] + q[3] * u[r] + v[r] + t[r]);
    };
  });
}

async function main() {
  await MeshoptDecoder.ready;
  const io = new NodeIO()
    .registerExtensions([EXTMeshGPUInstancing, EXTMeshoptCompression, KHRMeshQuantization])
    .registerDependencies({ "meshopt.decoder": MeshoptDecoder });
  for (const file of process.argv.slice(2)) {
    const root = (await io.read(file)).getRoot();
    let volume = 0;
    let triangles = 0;
    let worst = 0;
    for (const node of root.listNodes().filter((node) => node.getMesh())) {
      const m = node.getWorldMatrix();
      for (const place of places(node)) for (const primitive of node.getMesh().listPrimitives()) {
        const at = (local) => {
          const p = place(local);
          return [0, 1, 2].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
        };
        const positions = primitive.getAttribute("POSITION");
        const indices = primitive.getIndices();
        triangles += indices.getCount() / 3;
        for (let k = 0; k < indices.getCount(); k += 3) {
          const [a, b, c] = [0, 1, 2].map((i) => at(positions.getElement(indices.getScalar(k + i), [])));
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
