// What the server packs of a model (`packing.rs`), taken apart.

/** @param {ArrayBuffer} bytes */
export function unpack(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let at = 4 + length;
  const take = (Kind, count) => {
    const array = new Kind(bytes, at, count);
    at += array.byteLength;
    return array;
  };
  const { points, triangles, simplified, segments, vertices } = head.counts;
  return {
    ...head,
    extents: take(Float64Array, 6 * head.faces.length),
    points: take(Float32Array, 3 * points),
    faceOf: take(Float32Array, points),
    normals: take(Int8Array, 4 * points),
    corners: take(Uint32Array, 3 * triangles),
    simplifiedCorners: simplified.map((count) => take(Uint32Array, 3 * count)),
    segments: take(Float32Array, 6 * segments),
    edgeOf: take(Float32Array, segments),
    edgeFaces: take(Uint32Array, 2 * head.edges.length),
    vertices: take(Float32Array, 3 * vertices),
  };
}
