"""Bad input: what is wrong, with which argument, and how to mend it."""

from collections.abc import Callable
from typing import Any

import pytest

import stereotomy

# What is wrong here is what the types would say.
st: Any = stereotomy


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: st.sphere(-1), "sphere(radius=-1.0): a radius is -1: it must be positive"),
        (lambda: st.sphere(float("nan")), "sphere(radius=NaN): a radius is NaN"),
        (lambda: st.cuboid([1, 0, 1]), "cuboid(sides=[1.0, 0.0, 1.0]): a side of the box is 0"),
        (lambda: st.cylinder(1, z=(1, 0)), "cylinder(radius=1.0, z=(1.0, 0.0)): the height is -1"),
        (lambda: st.half_space([0, 0, 0]), "half_space(normal=[0.0, 0.0, 0.0], offset=0.0)"),
        (lambda: st.cube(1).scale(0), "scale(factor=0.0): the map is singular"),
        (lambda: st.cube(1).rotate_z(90, radians=True), "rotate_z(angle=90.0): the angle is 90 rad"),
        (lambda: st.cube(1).mirror([0, 0, 0]), "mirror(normal=[0.0, 0.0, 0.0]"),
        (lambda: st.cube(1).shear("x", "w", 1), 'by is "w": give one of "x", "y", "z"'),
        (lambda: st.cube(1).linear_pattern(0, [1, 0, 0]), "linear_pattern(count=0"),
        (lambda: st.cube(1).colored("red"), "color is 'red': give \"#rrggbb\""),
        (lambda: st.cube(1).colored((0, 0, 2)), "color is (0, 0, 2)"),
        (lambda: st.union([]), "union(solids=[]): give at least one solid"),
        (lambda: st.hull([[0, 0, 0], [1, 1, 1]]), "hull(points=[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])"),
        (lambda: st.polygon([[0, 0], [1, 1]]), "polygon(corners=[[0.0, 0.0], [1.0, 1.0]]): a contour"),
        (lambda: st.rectangle([1, -1]), "rectangle(sides=[1.0, -1.0]): a side is -1"),
        (lambda: st.circle(1).extrude(0), "extrude(z=(0.0, 0.0)): the height is 0"),
        (lambda: st.circle(1).extrude(1, apex=[0, 0], scale=2), "an apex goes with neither scale"),
        (lambda: st.circle(1).revolve(400), "revolve(angle=400.0)"),
        (lambda: st.circle(1).offset(1, join="rund"), 'join is "rund": give one of "round"'),
        (lambda: st.gear(module=-1, teeth=12), "gear(module=-1.0, teeth=12"),
        (lambda: st.text("a", size=0), 'text(text="a", size=0.0): the size is 0'),
        (lambda: st.text("a", font="No Such Font"), "no font of the family `No Such Font`"),
        (lambda: st.tube(1, 2, 1), "tube(outer=1.0, inner=2.0"),
        (lambda: st.polyhedron([[0, 0, 0]], [[0, 0, 7]]), "polyhedron(vertices="),
        (lambda: st.cube(1).mesh(tolerance=-1), "a tolerance of -1: give a positive distance"),
        (lambda: st.cube(1).mesh(cells=0), "0 cells: ask for"),
        (lambda: st.cube(1).mesh(max_seconds=-1), "max_seconds is -1: give a positive number"),
        (lambda: st.cube(1).mesh(unit="parsec"), 'unit is "parsec": give one of "um", "mm"'),
        (lambda: st.cube(1).section(), "section: give either z, a height, or normal"),
        (lambda: st.cube(1).render(view="above"), 'view is "above": give one of "front"'),
        (lambda: st.cube(1).render(fov=0), "fov is 0: give degrees between 0 and 180"),
        (lambda: st.empty().render(), "there is nothing to draw"),
        (lambda: st.empty().view(), "there is nothing to show"),
    ],
)
def test_wrong_values_name_the_argument(call: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError) as raised:
        call()
    assert message in str(raised.value)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: st.sphere("1"), "radius"),
        (lambda: st.cylinder(1, z=[1, 2, 3]), "z"),
        (lambda: st.cuboid([1, 2]), "sides"),
        (lambda: st.cube(1).translate(None), "offset"),
        (lambda: st.cube(1).mesh(tolerance="fine"), "tolerance"),
        (lambda: st.cube(1).mesh(cells=1.5), "cells"),
        (lambda: st.cube(1).mesh(progress=3), "progress"),
        (lambda: st.cube(1).mesh(tolerence=1), "tolerence"),
        (lambda: st.cube(1).measure(colour=1), "colour"),
        (lambda: st.cube(1).render(sise=(1, 1)), "sise"),
        (lambda: st.sphere(), "radius"),
    ],
)
def test_wrong_types_name_the_argument(call: Callable[[], object], name: str) -> None:
    with pytest.raises((TypeError, ValueError)) as raised:
        call()
    notes = getattr(raised.value, "__notes__", [])
    assert name in "\n".join([str(raised.value), *notes])


def test_operators_take_solids_only() -> None:
    with pytest.raises(TypeError, match="unsupported operand"):
        st.cube(1) | 3
    with pytest.raises(TypeError, match="unsupported operand"):
        st.cube(1) - st.circle(1)


def test_solids_without_end() -> None:
    with pytest.raises(st.Unbounded, match="towards about"):
        st.half_space([0, 0, 1]).mesh()
    assert issubclass(st.Unbounded, ValueError)
    with pytest.raises(st.Unbounded):
        st.space().bounds()
    assert st.empty().bounds() is None


def test_limits() -> None:
    with pytest.raises(st.LimitReached, match="1000 triangles.*partial=True"):
        st.sphere(1).mesh(tolerance=1e-6, max_triangles=1000)


def test_a_mesh_that_bounds_no_solid() -> None:
    mesh = st.cube(1).mesh()
    with pytest.raises(ValueError, match="open edge"):
        st.Mesh(mesh.vertices, mesh.triangles[1:]).to_solid()
