"""Pictures and the view that turns."""

import base64
import pathlib
import re
import struct

import numpy as np
import pytest
import scenes

import stereotomy as st


def test_a_solid_shows_itself() -> None:
    shown = st.sphere(1)._repr_mimebundle_()
    assert "<canvas" in str(shown["text/html"])
    png = st.sphere(1)._repr_png_()
    assert png is not None and png == shown["image/png"]
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == (640, 480)


def test_what_cannot_be_seen_is_text() -> None:
    for solid in (st.infinite_cylinder(1), st.empty()):
        assert solid._repr_html_() is None and solid._repr_png_() is None
        assert solid._repr_mimebundle_() == {}
        assert repr(solid).startswith("<Solid ")


def test_pictures_show_what_is_there(tmp_path: pathlib.Path) -> None:
    look = {"size": (200, 200), "view": "top", "parallel": True, "faces_only": True}
    picture = st.cube(1).render(**look)  # type: ignore[arg-type]
    covered = picture.pixels[..., 3] == 255
    # A square that fills nine tenths of each side.
    rows, columns = covered.any(axis=1).sum(), covered.any(axis=0).sum()
    assert rows == pytest.approx(180, abs=1) and columns == pytest.approx(180, abs=1)
    assert covered.sum() == rows * columns
    round_one = st.sphere(1).render(**look).pixels[..., 3] == 255  # type: ignore[arg-type]
    assert round_one.sum() == pytest.approx(np.pi * 90**2, rel=0.01)
    white = st.cube(1).render(size=(64, 48), background="#ffffff")
    assert white.pixels[0, 0].tolist() == [255, 255, 255, 255]
    white.save(tmp_path / "cube.png")
    assert (tmp_path / "cube.png").read_bytes() == white.png()
    near = st.cube(1).render(size=(64, 48), eye=[5, 0, 0], target=[0, 0, 0], fov=60)
    far = st.cube(1).render(size=(64, 48), eye=[9, 0, 0], target=[0, 0, 0], fov=60)
    assert (near.pixels[..., 3] == 255).sum() > (far.pixels[..., 3] == 255).sum()


def test_profiles_are_drawings() -> None:
    from xml.etree import ElementTree

    svg = (st.rectangle([4, 2]) - st.rectangle([1, 1])).translate([10, 5])._repr_svg_()
    assert svg is not None
    drawing = ElementTree.fromstring(svg)
    x, y, width, height = (float(number) for number in drawing.attrib["viewBox"].split())
    assert (x + width / 2, y + height / 2) == pytest.approx((10, -5))
    assert (width, height) == pytest.approx((4.4, 2.4))
    path = drawing[0].attrib["d"]
    assert path.count("Z") == 2 and path.count("L") == 6
    assert st.empty_profile()._repr_svg_() is None


def test_views_are_pages_of_their_own(tmp_path: pathlib.Path) -> None:
    red = (st.cube(1.5).colored("#ff0000") & st.sphere(1)).view(size=(320, 240))
    html = red._repr_html_()
    assert not re.search(r"https?:|src=\"(?!data:)|@[A-Z]+@", html)
    corners, lines = re.findall(r'bytes\("([^"]*)"\)', html)
    kinds = np.dtype([("p", "<i2", 4), ("n", "i1", 4), ("c", "u1", 4)])
    read = np.frombuffer(base64.b64decode(corners), dtype=kinds)
    assert len(read) % 3 == 0 and len(read) > 100
    # The largest extent, from -1 to 1 in 16 bits, is the box's or the ball's of 1.5.
    places = read["p"][:, :3] / 32767
    assert np.abs(places).max() == pytest.approx(1, abs=1e-4)
    assert np.linalg.norm(places * 0.75, axis=1).max() <= 1.0001
    normals = read["n"][:, :3] / 127
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=0.02)
    assert [255, 0, 0, 255] in read["c"].tolist()
    assert len(base64.b64decode(lines)) % 16 == 0 and lines
    red.save(tmp_path / "view.html")
    assert (tmp_path / "view.html").read_text().startswith("<!DOCTYPE html>")


def test_large_meshes_are_pictures_alone() -> None:
    mesh = st.sphere(1).mesh(cells=128)
    assert len(mesh.triangles) > 20_000
    html = mesh._repr_html_()
    assert html is not None
    assert "<canvas" not in html and "data:image/png" in html
    # A solid is meshed so that it can be turned.
    fine = st.union(st.sphere(1).translate([2.5 * k, 0, 0]) for k in range(40))
    assert "<canvas" in fine.view()._repr_html_()
    # Of flat faces no mesh has fewer triangles.
    flat = scenes.menger(3)
    assert "more than a view that turns shows" in flat.view()._repr_html_()
