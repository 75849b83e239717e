"""The reference scenes, and what their volumes are.

S1, S3, S4, S6, S7, S8 have closed forms, which are computed here; S2 and S5 were integrated,
to about 1e-15 and 1e-9.
"""

import math

import numpy as np

import stereotomy as st


def bores(radius: float) -> list[st.Solid]:
    along_z = st.infinite_cylinder(radius)
    return [along_z, along_z.rotate_x(90), along_z.rotate_y(90)]


def drilled() -> st.Solid:
    return (st.cube(1.5) & st.sphere(1)) - st.union(bores(0.5))


def menger(level: int) -> st.Solid:
    """Of side 2: at each level bars through the middle of each square of the grid."""
    bars = []
    for k in range(1, level + 1):
        side, squares = 2 / 3**k, 3 ** (k - 1)
        places = (np.arange(squares) - (squares - 1) / 2) * 2 / squares
        for a in places:
            for b in places:
                bars.append(st.cuboid([side, side, 3]).translate([a, b, 0]))
                bars.append(st.cuboid([side, 3, side]).translate([a, 0, b]))
                bars.append(st.cuboid([3, side, side]).translate([0, a, b]))
    return st.cube(2) - st.union(bars)


def cheese(count: int) -> st.Solid:
    centers = np.random.default_rng(1).random((count, 3)) * 2 - 1
    ball = st.sphere(0.35 * (1 / count) ** (1 / 3))
    return st.cube(2) - st.union(ball.translate(center) for center in centers)


def shell(thickness: float) -> st.Solid:
    return st.sphere(1) - st.sphere(1 - thickness)


def flange() -> st.Solid:
    bolts = st.infinite_cylinder(0.08).translate([0.75, 0, 0]).polar_pattern(8)
    keyway = st.cuboid_between([-0.06, 0, -1], [0.06, 0.38, 1])
    body = st.cylinder(1, z=0.2) | st.cylinder(0.45, z=0.7)
    return body - st.infinite_cylinder(0.3) - bolts - keyway


def flange_volume() -> float:
    half, radius = 0.06, 0.3
    # What of the keyway lies beyond the bore: its depth over its width, less the circle.
    under = half * math.sqrt(radius**2 - half**2) + radius**2 * math.asin(half / radius)
    keyway = 0.7 * (0.38 * 2 * half - under)
    body = math.pi * (0.2 + 0.5 * 0.45**2 - 0.7 * 0.3**2 - 8 * 0.2 * 0.08**2)
    return body - keyway


# The scene, its volume, and its handles (None where the text says nothing).
SCENES: dict[str, tuple[st.Solid, float, int | None]] = {
    "S1 sphere": (st.sphere(1), 4 / 3 * math.pi, 0),
    "S2 drilled": (drilled(), 0.988789557199477, 5),
    "S3 tricylinder": (st.intersection(bores(1)), 8 * (2 - math.sqrt(2)), 0),
    "S4 Menger 1": (menger(1), 8 * 20 / 27, 5),
    "S4 Menger 2": (menger(2), 8 * (20 / 27) ** 2, 81),
    "S5 cheese 100": (cheese(100), 7.829200300267373, None),
    "S6 rotated box": (
        st.cuboid([2, 1.2, 0.6]).rotate_xyz(0.7, 0.5, 0.3, radians=True),
        1.44,
        0,
    ),
    "S7 shell 0.01": (shell(0.01), 4 / 3 * math.pi * (1 - 0.99**3), 0),
    "S8 flange": (flange(), flange_volume(), 9),
}
