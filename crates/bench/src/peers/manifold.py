"""Times manifold3d on a reference scene.

manifold.py SCENE FOLDER N...

For each number N of segments of a circle prints one line of JSON, {n, seconds,
volume, triangles}, and leaves the mesh in FOLDER/N.positions (little-endian
float64) and FOLDER/N.triangles (uint32). The time is that of building and
evaluating the solid alone, the least of a few passes.
"""

import json
import math
import sys
import time

import numpy
from manifold3d import Manifold, OpType


def rod(axis, radius, n, half=2.0):
    cylinder = Manifold.cylinder(2 * half, radius, radius, n, True)
    return cylinder.rotate([(0, 90, 0), (90, 0, 0), (0, 0, 0)][axis])


def drilled(n):
    blank = Manifold.cube((1.5, 1.5, 1.5), True) ^ Manifold.sphere(1.0, n)
    return blank - (rod(0, 0.5, n) + rod(1, 0.5, n) + rod(2, 0.5, n))


def tricylinder(n):
    return rod(0, 1.0, n) ^ rod(1, 1.0, n) ^ rod(2, 1.0, n)


def flange(n):
    solid = Manifold.cylinder(0.2, 1.0, 1.0, n) + Manifold.cylinder(0.7, 0.45, 0.45, n)
    taken = [rod(2, 0.3, n)]
    taken.append(Manifold.cube((0.12, 0.38, 4.0)).translate((-0.06, 0.0, -2.0)))
    for i in range(8):
        angle = i * math.pi / 4
        at = (0.75 * math.cos(angle), 0.75 * math.sin(angle), 0.0)
        taken.append(rod(2, 0.08, n).translate(at))
    for hole in taken:
        solid -= hole
    return solid


def menger(level):
    bars = []
    for k in range(level):
        tiles = 3**k
        tile = 2.0 / tiles
        middles = [(2 * i + 1) / tiles - 1.0 for i in range(tiles)]
        for axis in range(3):
            size = [tile / 3.0] * 3
            size[axis] = 4.0
            bar = Manifold.cube(size, True)
            for u in middles:
                for v in middles:
                    at = [0.0] * 3
                    at[(axis + 1) % 3], at[(axis + 2) % 3] = u, v
                    bars.append(bar.translate(at))
    return Manifold.batch_boolean(
        [Manifold.cube((2.0, 2.0, 2.0), True)] + bars, OpType.Subtract
    )


def cheese(n, count):
    blank = Manifold.cube((2.0, 2.0, 2.0), True)
    hole = Manifold.sphere(0.35 * count ** (-1.0 / 3.0), n)
    places = 2.0 * numpy.random.default_rng(1).random((count, 3)) - 1.0
    holes = [hole.translate(place) for place in places.tolist()]
    return Manifold.batch_boolean([blank] + holes, OpType.Subtract)


# No finer circles are tried once a mesh took so many seconds.
MOST = 2.0

SCENES = {
    "S1": lambda n: Manifold.sphere(1.0, n),
    "S2": drilled,
    "S3": tricylinder,
    "S8": flange,
    "S4-2": lambda n: menger(2),
    "S4-3": lambda n: menger(3),
    "S5-100": lambda n: cheese(n, 100),
    "S5-1000": lambda n: cheese(n, 1000),
}


def main():
    scene, folder = sys.argv[1:3]
    if scene not in SCENES:
        return
    for n in map(int, sys.argv[3:]):
        best, passes, spent = math.inf, 0, 0.0
        while passes < 3 and spent < 2.0 or spent < 0.1:
            start = time.perf_counter()
            solid = SCENES[scene](n)
            triangles = solid.num_tri()  # evaluates
            seconds = time.perf_counter() - start
            best, passes, spent = min(best, seconds), passes + 1, spent + seconds
        mesh = solid.to_mesh64()
        numpy.asarray(mesh.vert_properties)[:, :3].astype("<f8").tofile(
            f"{folder}/{n}.positions"
        )
        numpy.asarray(mesh.tri_verts).astype("<u4").tofile(f"{folder}/{n}.triangles")
        answer = {"n": n, "seconds": best, "volume": solid.volume(), "triangles": triangles}
        print(json.dumps(answer), flush=True)
        if best > MOST:
            break


main()
