"""Files in every format, in and out."""

import math
import pathlib

import pytest
import scenes

import stereotomy as st


@pytest.mark.parametrize("extension", ["glb", "gltf", "obj", "stl", "ply", "off"])
def test_meshes_come_back(tmp_path: pathlib.Path, extension: str) -> None:
    path = tmp_path / f"flange.{extension}"
    solid = scenes.flange().named("flange").colored("#c8482c")
    solid.save(path, tolerance=1e-3, unit="m")
    mesh = solid.mesh(tolerance=1e-3)
    again = st.load_mesh(path)
    assert len(again.triangles) == len(mesh.triangles)
    assert again.volume == pytest.approx(mesh.volume, rel=1e-6)
    assert again.check().is_manifold


def test_3mf_is_written_and_read(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "flange.3mf"
    st.cube(1).save(str(path))
    assert path.read_bytes()[:2] == b"PK"
    assert st.load_mesh(path).volume == pytest.approx(1, rel=1e-12)


def test_step_has_the_exact_boundary(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "flange.step"
    scenes.flange().save(path, unit="in")
    text = path.read_text()
    assert text.startswith("ISO-10303-21;") and "CYLINDRICAL_SURFACE" in text
    assert "MANIFOLD_SOLID_BREP('flange'" in text and "'INCH'" in text
    with pytest.raises(st.FileError, match="not meshed: leave out tolerance"):
        scenes.flange().save(path, tolerance=1e-3)
    assert path.read_text() == text


def test_scenes_come_back(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "drilled.csg"
    scenes.drilled().save(path)
    again = st.load(path)
    assert again.measure(tolerance=1e-4).volume == pytest.approx(0.988789557199477, abs=1e-3)
    # Without parts that have no end the text says the same again.
    part = (st.cube(1.5) & st.sphere(1)) - st.cylinder(0.3, z=(-2, 2)).rotate_x(30)
    part.save(path)
    assert st.load(path).to_csg() == path.read_text() == part.to_csg()


def test_a_mesh_file_is_a_solid(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "cube.stl"
    st.cube(2).save(path)
    for solid in (st.load(path), st.read_solid(path)):
        assert (solid - st.sphere(1.2)).contains([0.9, 0.9, 0.9])
    st.cube(2).mesh().save(path, text=True)
    assert path.read_bytes().startswith(b"solid")
    assert st.load(path).mesh().volume == pytest.approx(8)


def test_bodies_that_are_the_same_are_written_once(tmp_path: pathlib.Path) -> None:
    plate = st.cuboid([8, 6, 2]) - st.cylinder(1.5, z=(-2, 2))
    plates = plate.translate([40, 0, 0]).polar_pattern(12)
    plain, once = tmp_path / "plain.glb", tmp_path / "once.glb"
    plates.save(plain, tolerance=0.01)
    plates.save(once, tolerance=0.01, instances=True)
    assert 4 * once.stat().st_size < plain.stat().st_size
    again = st.load_mesh(once)
    assert again.check().is_manifold and again.check().components == 12
    exact = 12 * (8 * 6 - math.pi * 1.5**2) * 2
    assert again.volume == pytest.approx(exact, rel=0.005)
    with pytest.raises(st.FileError, match="instances are of meshes"):
        plates.save(tmp_path / "plates.step", instances=True)


def test_ply_has_colours_of_vertices_if_asked(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "cube.ply"
    cube = st.cube(2).colored("#c8482c")
    for save in (cube.save, cube.mesh().save):
        save(path)
        plain = path.stat().st_size
        save(path, vertex_colors=True)
        assert path.stat().st_size > plain
        assert st.load_mesh(path).volume == pytest.approx(8)


def test_broken_meshes_are_mended_if_asked(tmp_path: pathlib.Path) -> None:
    good = st.cube(2).mesh()
    broken = st.Mesh(good.vertices, good.triangles[1:])
    with pytest.raises(ValueError, match="open edge"):
        broken.to_solid()
    with pytest.warns(UserWarning, match="1 x holes closed"):
        assert broken.to_solid(repair=True).mesh().volume == pytest.approx(8)
    path = tmp_path / "broken.stl"
    broken.save(path)
    for read in (st.load, st.read_solid):
        with pytest.warns(UserWarning, match="repaired"):
            assert read(path, repair=True).mesh().volume == pytest.approx(8)


def test_units_of_files_are_converted(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "inches.3mf"
    st.cube(1).save(path, unit="in")
    for read in (st.load, st.read_solid):
        assert read(path).mesh().volume == pytest.approx(25.4**3)
        assert read(path, unit="in").mesh().volume == pytest.approx(1)
    scene = tmp_path / "scene.csg"
    scene.write_text('import("inches.3mf");')
    with pytest.warns(UserWarning, match="from in to mm: 25.4 times"):
        assert st.load(scene).mesh().volume == pytest.approx(25.4**3)
    assert st.load(scene, unit="in").mesh().volume == pytest.approx(1)


def test_objects_of_a_file_are_united(tmp_path: pathlib.Path) -> None:
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    text = ""
    for number, offset in enumerate((0.0, 0.5)):
        text += f"o part{number}\n"
        text += "".join(f"v {x + offset} {y + offset} {z + offset}\n" for x, y, z in corners)
        for face in faces:
            text += "f " + " ".join(str(8 * number + corner) for corner in face) + "\n"
    path = tmp_path / "two.obj"
    path.write_text(text)
    assert st.load_mesh(path).volume == pytest.approx(2)
    assert st.read_solid(path).mesh().volume == pytest.approx(1.875)
    # The second one open.
    path.write_text(text[: text.rindex("f ")])
    scene = tmp_path / "scene.csg"
    scene.write_text('import("two.obj");')
    with pytest.raises(ValueError, match="repair=True"):
        st.load(scene)


def test_faceted_circles() -> None:
    text = "cylinder($fn = 64, $fa = 12, $fs = 2, h = 1, r1 = 1, r2 = 1, center = false);"
    assert st.from_csg(text).mesh().report.method == "boundary"  # type: ignore[union-attr]
    assert st.from_csg(text, faceted=True).mesh().report.method == "polyhedral"  # type: ignore[union-attr]


def test_warnings_are_pythons() -> None:
    with pytest.warns(UserWarning, match="line 1, column 1: sphere"):
        st.from_csg("sphere($fn = 0, $fa = 12, $fs = 2, r = -1); cube(size = [1, 1, 1], center = true);")


    with pytest.warns(UserWarning, match="has no glyph for '漢'"):
        st.text("漢")


def test_what_cannot_be_read_or_written(tmp_path: pathlib.Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere.csg"):
        st.load(tmp_path / "nowhere.csg")
    with pytest.raises(FileNotFoundError, match="nowhere.stl"):
        st.load_mesh(tmp_path / "nowhere.stl")
    with pytest.raises(st.FileError, match="no mesh format has this extension"):
        st.cube(1).save(tmp_path / "cube.xyz")
    with pytest.raises(st.FileError, match="leave out tolerance"):
        st.cube(1).save(tmp_path / "cube.csg", tolerance=1)
    with pytest.raises(FileNotFoundError):
        st.cube(1).save(tmp_path / "no" / "such" / "folder.stl")
    with pytest.raises(st.FileError, match="no triangles"):
        st.empty().save(tmp_path / "empty.stl")
    (tmp_path / "bad.csg").write_text("cube(\n  size = ")
    with pytest.raises(st.FileError, match="bad.csg:2:"):
        st.load(tmp_path / "bad.csg")
    (tmp_path / "bad.stl").write_text("nothing")
    with pytest.raises(st.FileError, match="bad.stl"):
        st.load_mesh(tmp_path / "bad.stl")
    # Nothing is left half written.
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csg", "bad.stl"]
