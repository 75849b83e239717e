"""Volumes of the reference scenes, by this package, manifold3d and trimesh."""

import math

import pytest
import scenes

import stereotomy as st


def test_the_closed_forms_are_the_printed_numbers() -> None:
    printed = {
        "S1 sphere": 4.188790204786391,
        "S3 tricylinder": 4.68629150101524,
        "S4 Menger 1": 5.925925925925926,
        "S4 Menger 2": 4.38957475994513,
        "S7 shell 0.01": 0.1244112578723606,
        "S8 flange": 0.709425518258427,
    }
    for name, number in printed.items():
        assert math.isclose(scenes.SCENES[name][1], number, rel_tol=1e-13), name


@pytest.mark.parametrize("name", scenes.SCENES)
def test_volumes_agree(name: str) -> None:
    solid, volume, genus = scenes.SCENES[name]
    mesh = solid.mesh(tolerance=1e-4)
    report = mesh.report
    assert report is not None and report.is_proven, report
    assert report.deviation is not None and report.deviation <= 1e-4
    # No point of either boundary is farther from the other: of the volume between them the
    # area and the deviation are a bound (and a percent for the area's own error).
    bound = 1.01 * report.deviation * mesh.area + 1e-9
    assert abs(mesh.volume - volume) <= bound
    check = mesh.check()
    assert check.is_manifold and not check.defects
    if genus is not None:
        assert check.genus == genus
    # Others find the same mesh closed, and in it the same volume.
    theirs = mesh.to_manifold()
    assert math.isclose(theirs.volume(), mesh.volume, rel_tol=1e-9)
    trimesh = mesh.to_trimesh()
    assert trimesh.is_watertight and trimesh.is_winding_consistent
    assert math.isclose(trimesh.volume, mesh.volume, rel_tol=1e-9)
    assert math.isclose(trimesh.area, mesh.area, rel_tol=1e-9)


@pytest.mark.parametrize("name", scenes.SCENES)
def test_exact_measures_are_within_their_bounds(name: str) -> None:
    solid, volume, _ = scenes.SCENES[name]
    measure = solid.measure()
    assert measure.volume_error is not None and measure.area_error is not None
    assert measure.volume_error < 1e-9
    # S5's number is itself good to about 1e-9 of it only, the others to rounding.
    printed = 1e-9 if name.startswith("S5") else 4e-15
    assert abs(measure.volume - volume) <= measure.volume_error + printed * volume
    mesh = solid.mesh(tolerance=1e-3).measure()
    assert mesh.volume_error is None
    assert mesh.area == pytest.approx(measure.area, rel=2e-2)
    assert mesh.centroid == pytest.approx(measure.centroid, abs=1e-3)


def test_measures_of_a_box() -> None:
    a, b, c = 1.0, 2.0, 3.0
    measure = st.cuboid([a, b, c]).translate([5, 6, 7]).measure()
    assert math.isclose(measure.volume, a * b * c, rel_tol=1e-12)
    assert math.isclose(measure.area, 2 * (a * b + b * c + c * a), rel_tol=1e-12)
    assert measure.centroid == pytest.approx((5, 6, 7), rel=1e-12)
    mass = a * b * c
    moments = [mass * (b**2 + c**2) / 12, mass * (a**2 + c**2) / 12, mass * (a**2 + b**2) / 12]
    for k in range(3):
        assert measure.inertia[k][k] == pytest.approx(moments[k], rel=1e-12)
        assert measure.second_moments[k][(k + 1) % 3] == pytest.approx(0, abs=1e-12)


def test_other_ways_of_meshing() -> None:
    ball = st.sphere(1)
    lattice = ball.mesh(cells=32)
    assert lattice.report is not None and lattice.report.method == "exact"
    # Vertices are on the sphere to rounding.
    import numpy as np

    radii = np.linalg.norm(lattice.vertices, axis=1)
    assert np.abs(radii - 1).max() < 1e-12
    sized = ball.mesh(cell_size=2 / 32)
    assert sized.report is not None and sized.report.cell_size == pytest.approx(2 / 32)
    draft = ball.mesh(cells=16, draft=True)
    assert draft.report is not None and draft.report.method == "draft"
    bounded = ball.mesh(bounds=([-2, -2, -2], [2, 2, 2]), cells=32)
    assert bounded.report is not None and bounded.report.bounds == ((-2, -2, -2), (2, 2, 2))
    fine = ball.mesh(tolerance=0.1, angle=5)
    assert len(fine.triangles) > len(ball.mesh(tolerance=0.1).triangles)
    assert ball.mesh(unit="in").unit == "in"
    limited = ball.mesh(tolerance=1e-5, max_triangles=1000, partial=True)
    assert limited.report is not None and limited.report.limits_reached
    assert len(limited.triangles) <= 1000


def test_sections_are_those_of_the_formulas() -> None:
    # A ball at height z: a circle of radius sqrt(1 - z²).
    for z in (0.0, 0.5):
        area = st.sphere(1).section(z=z, tolerance=1e-4).area()
        assert area == pytest.approx(math.pi * (1 - z * z), rel=2e-3)
    # A cylinder cut along a slant: an ellipse, 1 / cos 45° as long.
    rod = st.cylinder(1, z=(-5, 5)).section(normal=[1, 0, 1], tolerance=1e-4)
    assert rod.area() == pytest.approx(math.pi * math.sqrt(2), rel=2e-3)
    low, high = rod.bounds() or ((0, 0), (0, 0))
    assert high[1] == pytest.approx(math.sqrt(2), rel=1e-3)
    assert low[0] == pytest.approx(-1, rel=1e-3)
    with pytest.raises(st.Unbounded):
        st.infinite_cylinder(1).section(z=0)
