"""Meshes as NumPy arrays: their types, and that no copy is made."""

import gc
import weakref

import numpy as np
import pytest

import stereotomy as st


def named_mesh() -> st.Mesh:
    red = st.sphere(1).named("ball").colored("#ff0000")
    return (st.cube(1.5).named("block") & red).mesh(feature_edges=10)


def test_shapes_and_types() -> None:
    mesh = named_mesh()
    n, m = len(mesh.vertices), len(mesh.triangles)
    assert mesh.vertices.shape == (n, 3) and mesh.vertices.dtype == np.float64
    assert mesh.triangles.shape == (m, 3) and mesh.triangles.dtype == np.uint32
    assert mesh.triangle_surfaces.shape == (m,) and mesh.triangle_surfaces.dtype == np.uint32
    assert mesh.corner_normals.shape == (m, 3, 3) and mesh.corner_normals.dtype == np.float32
    # Euler: a closed mesh without handles.
    assert n - m / 2 == 2


def test_arrays_are_views_that_keep_the_mesh() -> None:
    mesh = named_mesh()
    vertices = mesh.vertices
    assert np.shares_memory(vertices, mesh.vertices)
    assert vertices.base is mesh  # type: ignore[comparison-overlap]
    for array in (vertices, mesh.triangles, mesh.triangle_surfaces, mesh.corner_normals):
        assert not array.flags.owndata and not array.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        vertices[0, 0] = 1.0
    with pytest.raises(ValueError):
        vertices.flags.writeable = True
    expected = vertices.copy()
    kept = weakref.ref(mesh)
    del mesh, array
    gc.collect()
    assert kept() is not None
    np.testing.assert_array_equal(vertices, expected)
    del vertices
    gc.collect()
    assert kept() is None


def test_normals_and_surfaces_are_those_of_the_solid() -> None:
    mesh = named_mesh()
    names = np.array([surface.name for surface in mesh.surfaces])
    on_ball = names[mesh.triangle_surfaces] == "ball"
    assert on_ball.any() and not on_ball.all()
    corners = mesh.vertices[mesh.triangles]
    # Of the unit ball's triangles the normals are the corners themselves.
    np.testing.assert_allclose(mesh.corner_normals[on_ball], corners[on_ball], atol=1e-6)
    # Those of the block are along the axes.
    assert set(np.abs(mesh.corner_normals[~on_ball]).max(axis=2).round(6).ravel()) == {1.0}
    assert {surface.color for surface in mesh.surfaces} == {None, (1.0, 0.0, 0.0, 1.0)}
    assert len(mesh.feature_edges) == 6
    for edge in mesh.feature_edges:
        assert edge[0] == edge[-1]
        radii = np.linalg.norm(mesh.vertices[edge], axis=1)
        np.testing.assert_allclose(radii, 1, atol=1e-12)
    without = st.sphere(1).mesh(normals=False)
    assert without.corner_normals.shape == (0, 3, 3)


def test_meshes_from_arrays() -> None:
    made = named_mesh()
    again = st.Mesh(
        made.vertices,
        made.triangles,
        triangle_surfaces=made.triangle_surfaces,
        surfaces=made.surfaces,
        corner_normals=made.corner_normals,
        feature_edges=made.feature_edges,
    )
    assert again.vertices.tobytes() == made.vertices.tobytes()
    assert again.corner_normals.tobytes() == made.corner_normals.tobytes()
    assert again.surfaces == made.surfaces
    assert again.volume == made.volume
    # Whatever NumPy makes numbers of.
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    for kind in ("int64", "int32", "int8", "uint8", "uint32", "uint64"):
        assert st.Mesh(corners, faces.astype(kind)).volume == pytest.approx(1 / 6)
    assert st.Mesh(np.asfortranarray(corners, dtype="float32"), faces).volume > 0
    assert len(st.Mesh([], []).vertices) == 0


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        ([[0, 0]], [], r"vertices must be an array of shape \(n, 3\)"),
        ([[0, 0, "x"]], [], "vertices must be"),
        ([[0, 0, 0]], [[0, 0, 1]], r"triangles\[0\] is \[0, 0, 1\]: there are 1 vertices"),
        ([[0, 0, 0]], [[0, 0, -1]], "triangles must be .* numbers from -1 to 0"),
        ([[0, 0, 0]], [[0, 0, 2**40]], "triangles must be .* numbers from 0 to 1099511627776"),
        ([[0, 0, 0]], [[0, 0, 0.5]], "triangles must be .* type float64"),
    ],
)
def test_wrong_arrays_are_refused(vertices: object, triangles: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        st.Mesh(vertices, triangles)  # type: ignore[arg-type]


def test_many_points_are_asked_at_once() -> None:
    points = np.random.default_rng(0).normal(size=(10_000, 3))
    inside = st.sphere(1.5).contains(points)
    assert inside.dtype == bool
    np.testing.assert_array_equal(inside, np.linalg.norm(points, axis=1) <= 1.5)
    assert st.sphere(1).contains(np.zeros((0, 3))).shape == (0,)
    with pytest.raises(ValueError, match="points must be"):
        st.sphere(1).contains([[1, 2]])


def test_many_points_have_their_distances() -> None:
    points = np.random.default_rng(1).normal(size=(300, 3))
    near = st.sphere(1.5).named("ball").nearest(points, tolerance=1e-3)
    truth = np.linalg.norm(points, axis=1) - 1.5
    assert all(abs(n.distance - d) <= n.error for n, d in zip(near, truth, strict=True))
    assert {n.face.name for n in near} == {"ball"}
    assert st.sphere(1).nearest(np.zeros((0, 3))) == []
    with pytest.raises(ValueError, match="point 0 is"):
        st.sphere(1).nearest([np.nan, 0, 0])
    with pytest.raises(ValueError, match="the solid is empty"):
        st.empty().nearest([0, 0, 0])


def test_rays_hit_where_they_should() -> None:
    hits = (st.sphere(1.5) - st.sphere(0.5)).ray([-3, 0, 0], [0.5, 0, 0])
    assert [hit.t for hit in hits] == pytest.approx([3, 5, 7, 9], abs=1e-12)
    assert [hit.enters for hit in hits] == [True, False, True, False]
    assert [hit.normal[0] for hit in hits] == pytest.approx([-1, 1, -1, 1])
    with pytest.raises(ValueError, match="a direction that is not zero"):
        st.sphere(1).ray([0, 0, 0], [0, 0, 0])


def test_contours_are_arrays() -> None:
    outer, inner = (st.rectangle([2, 2]) - st.circle(0.5)).contours(1e-4)
    assert outer.shape == (4, 2) and inner.shape[1] == 2
    x, y = inner.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(-np.pi / 4, rel=1e-3)
