"""Times manifold3d on a scene of many primitives.

many.py FILE SECONDS

FILE holds {difference, parts}: parts are united, or taken from the first of them. Each is its kind,
its numbers and the segments of its circles. Prints one line of JSON, {seconds, volume, triangles}:
the least of up to three passes, from the parts to the mesh. Ends by an alarm after so many SECONDS.
"""

import json
import signal
import sys
import time
from functools import cache

from manifold3d import Manifold, OpType

TURNS = [(0, 90, 0), (-90, 0, 0), (0, 0, 0)]


@cache
def ball(radius, n):
    return Manifold.sphere(radius, n)


@cache
def rod(axis, length, radius, n):
    return Manifold.cylinder(length, radius, radius, n).rotate(TURNS[axis])


def solid(kind, *numbers):
    if kind == "ball":
        at, radius, n = numbers
        return ball(radius, n).translate(at)
    if kind == "shell":
        outer, inner, *segments = numbers
        return ball(outer, segments[0]) - ball(inner, segments[1])
    if kind == "rod":
        axis, at, length, radius, n = numbers
        return rod(axis, length, radius, n).translate(at)
    low, size = numbers
    return Manifold.cube(size).translate(low)


signal.alarm(int(sys.argv[2]))
with open(sys.argv[1]) as file:
    scene = json.load(file)
operation = OpType.Subtract if scene["difference"] else OpType.Add
best, begun = float("inf"), time.perf_counter()
for _ in range(3):
    start = time.perf_counter()
    ball.cache_clear()
    rod.cache_clear()
    result = Manifold.batch_boolean([solid(*part) for part in scene["parts"]], operation)
    triangles = result.num_tri()  # evaluates
    result.to_mesh64()
    best = min(best, time.perf_counter() - start)
    if time.perf_counter() - begun > 5.0:
        break
print(json.dumps({"seconds": best, "volume": result.volume(), "triangles": triangles}))
