"""Pictures and the view that turns."""

import base64
import pathlib
import re
import struct
from typing import Any

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
    look: dict[str, Any] = {"size": (200, 200), "view": "top", "parallel": True, "faces_only": True}
    picture = st.cube(1).render(**look)
    covered = picture.pixels[..., 3] == 255
    # A square that fills nine tenths of each side.
    rows, columns = covered.any(axis=1).sum(), covered.any(axis=0).sum()
    assert rows == pytest.approx(180, abs=1) and columns == pytest.approx(180, abs=1)
    assert covered.sum() == rows * columns
    round_one = st.sphere(1).render(**look).pixels[..., 3] == 255
    assert round_one.sum() == pytest.approx(np.pi * 90**2, rel=0.01)
    white = st.cube(1).render(size=(64, 48), background="#ffffff")
    assert white.pixels[0, 0].tolist() == [255, 255, 255, 255]
    white.save(tmp_path / "cube.png")
    assert (tmp_path / "cube.png").read_bytes() == white.png()
    near = st.cube(1).render(size=(64, 48), eye=[5, 0, 0], target=[0, 0, 0], fov=60)
    far = st.cube(1).render(size=(64, 48), eye=[9, 0, 0], target=[0, 0, 0], fov=60)
    assert (near.pixels[..., 3] == 255).sum() > (far.pixels[..., 3] == 255).sum()


def test_sections_show_what_is_inside() -> None:
    # A ball with a hollow of half its radius, cut through the middle and seen from above.
    hollow = st.sphere(1) - st.sphere(0.5)
    look: dict[str, Any] = {"size": (200, 200), "view": "top", "parallel": True, "faces_only": True}
    cut = hollow.render(
        sections=[([0, 0, 1], [0, 0, 0])],
        cap_color="#ff0000",
        ambient="#ffffff",
        lights=[([0, 0, 1], "#000000")],
        material=(1, 0, 0, 1),
        **look,
    )
    red = (cut.pixels[..., 0] > 200) & (cut.pixels[..., 1] < 60)
    # The cap is a ring, three quarters of the disc, but for its hatching.
    disc = np.pi * 90**2
    assert 0.4 * disc < red.sum() <= 0.76 * disc
    assert not red[80:120, 80:120].any()
    whole = hollow.render(**look)
    assert (whole.pixels[..., 3] == 255).sum() == pytest.approx(disc, rel=0.01)


def test_lights_are_where_they_are_said_to_be() -> None:
    look: dict[str, Any] = {"size": (120, 120), "view": "top", "parallel": True, "faces_only": True}
    for name in ("lights", "point_lights"):
        placed = {**look, name: [((5, 0, 0), "#ffffff")]}
        lit = st.sphere(1).render(ambient="#000000", **placed)
        left, right = lit.pixels[:, :60, :3].mean(), lit.pixels[:, 60:, :3].mean()
        assert right > 3 * left, name
    red = st.sphere(1).render(lights=[([0, 0, 1], "#ff0000")], ambient="#000000", **look)
    assert red.pixels[60, 60, 0] > 100 and red.pixels[60, 60, 1] < 10


def test_turntables_go_round(tmp_path: pathlib.Path) -> None:
    # A ball beside a rod: together twice as wide as thick.
    solid = st.cylinder(0.3, z=(-1, 1)) | st.sphere(0.4).translate([1, 0, 0])
    turning = solid.turntable(8, frames_per_second=5, size=(80, 60), faces_only=True)
    assert len(turning) == 8 and turning.size == (80, 60)
    widths = []
    for frame in (turning[k] for k in range(len(turning))):
        columns = np.nonzero((frame.pixels[..., 3] > 0).any(axis=0))[0]
        widths.append(int(columns[-1] - columns[0]))
    # Along and across, each twice in a turn.
    assert max(widths) > 1.4 * min(widths)
    assert all(abs(widths[k] - widths[k + 4]) <= 8 for k in range(4))
    assert turning[-1].png() == turning[7].png() != turning[0].png()
    with pytest.raises(IndexError):
        turning[8]
    turning.save(tmp_path / "a.png")
    turning.save(tmp_path / "a.gif")
    assert b"acTL" in (tmp_path / "a.png").read_bytes()
    assert (tmp_path / "a.gif").read_bytes()[:6] == b"GIF89a"
    assert b"acTL" in turning._repr_png_()
    assert len(solid.mesh().turntable(3, size=(40, 30))) == 3


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"sections": [([0, 0, 0], [0, 0, 0])]}, "normal is zero"),
        ({"sections": [([0, 0, 1], [0, 0, 0])] * 5}, "4 at most"),
        ({"sections": [1, 2]}, "normal, point"),
        ({"lights": [[0, 0, 0]]}, "lights"),
        ({"lights": 3}, "lights"),
        ({"point_lights": [([1, 2], "#ffffff")]}, "point_lights"),
        ({"material": (1, 2, 3)}, "material"),
        ({"material": (1, 1, -1, 1)}, "material"),
        ({"lights": [[0, 0, 1]] * 17}, "16 at most"),
    ],
)
def test_what_a_picture_cannot_have_is_named(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        st.cube(1).render(size=(8, 8), **options)
    with pytest.raises(ValueError, match="give 1 to 1000"):
        st.cube(1).turntable(0)


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
