"""Solids, profiles and meshes through pickles, to the bit."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
import scenes

import stereotomy as st


def same_mesh(a: st.Mesh, b: st.Mesh) -> bool:
    arrays = ("vertices", "triangles", "triangle_surfaces", "corner_normals")
    return all(
        getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in arrays
    ) and (a.surfaces, a.unit) == (b.surfaces, b.unit)


PARTS: dict[str, st.Solid] = {
    "flange": scenes.flange(),
    "drilled": scenes.drilled().named("drilled").colored((0.1, 0.2, 0.3, 0.4)),
    "third": st.cube(1 / 3).rotate_about_axis([1, 2, 3], 0.1).translate([1e-9, 1e5, 0.1]),
    "text": st.text("Ab", size=3).extrude(1),
    "vase": st.polygon([[0, 0], [2, 0], [1, 3], [0, 3]]).revolve(),
    "elbow": st.rectangle([2, 1]).translate([3, 0]).revolve(90),
    "drill": st.rectangle([2, 1]).extrude(3, twist=90, steps=6),
    "cone": st.circle(1).extrude(2, apex=[0.5, 0]),
    "gear": st.gear(1, 9).extrude(1),
    "parts": (st.cube(1).named("screw") | st.sphere(0.6)).named("leaf"),
    "hull": st.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
    "tetrahedron": st.tetrahedron(1).mesh().to_solid(),
    "bolts": st.cylinder(0.1, z=1).translate([1, 0, 0]).polar_pattern(5),
    "quadrics": (st.paraboloid([1, 2]) & st.half_space([0, 0, 1], 3)) - st.infinite_cone(20),
    "wedge": st.convex_polyhedron([([-1, 0, 0], 0), ([0, -1, 0], 0), ([0, 0, -1], 0), ([1, 1, 1], 1)]),
}


@pytest.mark.parametrize("name", PARTS)
def test_solids_come_back_to_the_bit(name: str) -> None:
    solid = PARTS[name]
    for again in (pickle.loads(pickle.dumps(solid)), copy.deepcopy(solid)):
        assert same_mesh(again.mesh(tolerance=0.01), solid.mesh(tolerance=0.01))
        # The tree is the same, not only the shape.
        assert repr(again) == repr(solid)
        assert pickle.dumps(again) == pickle.dumps(solid)


def test_shared_parts_stay_shared() -> None:
    solid = st.sphere(1)
    for _ in range(60):
        solid = solid | solid.translate([1, 0, 0])
    # 2 to the 60 spheres, were they written out.
    assert len(pickle.dumps(solid)) < 20_000
    assert pickle.loads(pickle.dumps(solid)).__class__ is st.Solid


def test_deep_trees_do_not_recurse() -> None:
    solid = st.cube(1)
    for _ in range(100_000):
        solid = solid.translate([1e-5, 0, 0])
    again = pickle.loads(pickle.dumps(solid))
    assert again.mesh().bounds == solid.mesh().bounds


def test_profiles_come_back_to_the_bit() -> None:
    profile = (st.rounded_rectangle([4, 3], 1) - st.circle(0.3)) | st.text("st", size=1)
    again = pickle.loads(pickle.dumps(profile))
    for a, b in zip(again.contours(), profile.contours(), strict=True):
        assert a.tobytes() == b.tobytes()
    assert same_mesh(again.extrude(1).mesh(), profile.extrude(1).mesh())


def test_meshes_come_back_to_the_bit() -> None:
    mesh = PARTS["drilled"].mesh(unit="cm", feature_edges=20)
    for protocol in (2, 4, 5):
        again = pickle.loads(pickle.dumps(mesh, protocol))
        assert same_mesh(again, mesh)
        assert [e.tolist() for e in again.feature_edges] == [e.tolist() for e in mesh.feature_edges]
        assert again.report is None


def test_damaged_pickles_are_refused() -> None:
    function, (data,) = st.sphere(1).__reduce__()
    for damaged in (b"", data[:-1], b"\xff" * 40, b"\x00"):
        with pytest.raises(ValueError, match="no pickle of this version"):
            function(damaged)
    profile, (data,) = st.circle(1).__reduce__()
    with pytest.raises(ValueError, match="no pickle of this version"):
        profile(data[:-1])


def work(solid: st.Solid) -> st.Mesh:
    return solid.mesh(tolerance=0.01)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_worker_processes(method: str) -> None:
    # Threads of this process are there, and not in forked ones.
    work(PARTS["flange"])
    with ProcessPoolExecutor(2, mp_context=get_context(method)) as pool:
        for solid, mesh in zip(PARTS.values(), pool.map(work, PARTS.values()), strict=True):
            assert same_mesh(mesh, work(solid))
