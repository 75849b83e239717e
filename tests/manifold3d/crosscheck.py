"""Answers questions about solids and meshes by manifold3d.

Reads one JSON object a line from standard input and writes one a line to
standard output, in the same order:

{"solid": NODE, "segments": N}
    -> {"volume": V, "tessellation": T}
    The volume of the polyhedral solid whose circles have N segments, and a
    bound of its difference from the round one.

{"positions": FILE, "triangles": FILE}
    -> {"status": "NoError", "volume": V, "genus": G}
    What manifold3d says of a mesh: raw little-endian float64 positions and
    uint64 vertex indices.
"""

import json
import math
import sys

import manifold3d
import numpy
from manifold3d import Manifold, Mesh64, OpType

OPERATIONS = {
    "union": OpType.Add,
    "intersection": OpType.Intersect,
    "difference": OpType.Subtract,
}


class Builder:
    """Builds a solid and adds up what its primitives lack.

    Every polyhedral primitive is inscribed in its round one. A point that two
    Boolean combinations see differently is one that some pair of primitives
    sees differently, so the volumes of what the primitives lack add up to a
    bound for any combination of them.
    """

    def __init__(self, segments):
        self.segments = segments
        self.lacking = 0.0

    def inscribed(self, polyhedron, exact_volume, scale):
        self.lacking += scale * (exact_volume - polyhedron.volume())
        return polyhedron

    def build(self, node, scale=1.0):
        """`scale` is the factor that the maps above multiply volumes by."""
        ((kind, value),) = node.items()
        if kind == "empty":
            return Manifold()
        if kind == "cuboid":
            low, high = numpy.array(value[0]), numpy.array(value[1])
            return Manifold.cube(high - low).translate(low)
        if kind == "sphere":
            sphere = Manifold.sphere(value, self.segments)
            return self.inscribed(sphere, 4 / 3 * math.pi * value**3, scale)
        if kind == "frustum":
            bottom, top, start, end = value
            height = end - start
            exact = math.pi * height * (bottom**2 + bottom * top + top**2) / 3
            if bottom == 0:
                # manifold3d wants the point of a cone above.
                solid = Manifold.cylinder(height, top, 0, self.segments)
                solid = solid.mirror([0, 0, 1]).translate([0, 0, end])
            else:
                solid = Manifold.cylinder(height, bottom, top, self.segments)
                solid = solid.translate([0, 0, start])
            return self.inscribed(solid, exact, scale)
        if kind == "hull":
            return Manifold.hull_points(value)
        if kind == "planes":
            planes = numpy.array(value)
            offsets = planes[:, 3] / numpy.linalg.norm(planes[:, :3], axis=1)
            # Larger than any polyhedron that is not a needle.
            side = 1e3 * numpy.abs(offsets).max()
            solid = Manifold.cube([side] * 3, True)
            for normal, offset in zip(planes[:, :3], offsets):
                # What is kept lies along the normal.
                solid = solid.trim_by_plane(-normal, -offset)
            return solid
        if kind == "mesh":
            positions = numpy.array(value[0], dtype="<f8")
            triangles = numpy.array(value[1], dtype="<u8")
            return Manifold(Mesh64(positions, triangles))
        if kind == "map":
            matrix, inner = value
            matrix = numpy.array(matrix, order="C")
            factor = abs(numpy.linalg.det(matrix[:, :3]))
            return self.build(inner, scale * factor).transform(matrix)
        operands = [self.build(operand, scale) for operand in value]
        return Manifold.batch_boolean(operands, OPERATIONS[kind])


def answer(question):
    if "solid" in question:
        builder = Builder(question["segments"])
        solid = builder.build(question["solid"])
        if solid.status() != manifold3d.Error.NoError:
            raise RuntimeError(f"manifold3d: {solid.status()}")
        return {"volume": solid.volume(), "tessellation": builder.lacking}
    positions = numpy.fromfile(question["positions"], "<f8").reshape(-1, 3)
    triangles = numpy.fromfile(question["triangles"], "<u8").reshape(-1, 3)
    solid = Manifold(Mesh64(positions, triangles))
    return {
        "status": solid.status().name,
        "volume": solid.volume(),
        "genus": solid.genus(),
    }


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)
