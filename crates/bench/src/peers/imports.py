"""Times manifold3d on two meshes: reading each, and the difference.

imports.py FOLDER

FOLDER holds a.positions, b.positions (little-endian float64), a.triangles and b.triangles
(uint32). Prints one line of JSON, {import, difference, volume, triangles}: seconds for the first
mesh alone, and for both with their difference, the least of a few passes.
"""

import json
import sys
import time
from pathlib import Path

import numpy
from manifold3d import Manifold, Mesh64

folder = Path(sys.argv[1])


def mesh(name):
    positions = numpy.fromfile(folder / f"{name}.positions", "<f8").reshape(-1, 3)
    triangles = numpy.fromfile(folder / f"{name}.triangles", "<u4").reshape(-1, 3)
    return Mesh64(positions, triangles.astype(numpy.uint64))


def solid(mesh):
    made = Manifold(mesh)
    # It puts work off until somebody asks.
    made.num_tri()
    return made


meshes = [mesh("a"), mesh("b")]
times = []
for _ in range(3):
    begun = time.perf_counter()
    first = solid(meshes[0])
    imported = time.perf_counter() - begun
    difference = first - solid(meshes[1])
    difference.to_mesh64()
    times.append((imported, time.perf_counter() - begun))
print(
    json.dumps(
        {
            "import": min(t[0] for t in times),
            "difference": min(t[1] for t in times),
            "volume": difference.volume(),
            "triangles": difference.num_tri(),
        }
    )
)
