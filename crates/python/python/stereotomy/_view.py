"""A view that turns: a page of its own, without a server and without other files."""

from __future__ import annotations

import os
from base64 import b64encode
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._stereotomy import Mesh, Picture, Solid

#: What a notebook should hold: 64 letters a triangle.
MOST_TRIANGLES = 20_000


class View:
    """A picture that can be dragged to turn, in a notebook or as a file. Where scripts do
    not run, it is the picture.
    """

    def __init__(self, html: str) -> None:
        self._html = html

    def _repr_html_(self) -> str:
        return self._html

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a page that needs no other file."""
        head = '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>Stereotomy</title>'
        Path(path).write_text(f"{head}<body>{self._html}</body></html>", encoding="utf-8")

    def __repr__(self) -> str:
        return f"<View of {len(self._html) / 1e3:.0f} kB>"


def _corners(mesh: Mesh) -> bytes:
    """For each corner of each triangle 16 bytes: the position (3 x int16, of the largest
    extent), 2 nothing, the normal (3 x int8), 1 nothing, and the colour (4 x uint8).
    """
    import numpy as np

    corners = np.zeros(
        (len(mesh.triangles), 3),
        dtype=[("p", "<i2", 4), ("n", "i1", 4), ("c", "u1", 4)],
    )
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    scaled = (mesh.vertices - (low + high) / 2) * (2 * 32767 / (high - low).max())
    corners["p"][..., :3] = np.rint(scaled).astype("int16")[mesh.triangles]
    if len(mesh.corner_normals):
        normals = mesh.corner_normals
    else:
        a, b, c = (scaled[mesh.triangles[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        normals = np.repeat(across[:, None, :], 3, axis=1)
    corners["n"][..., :3] = np.rint(127 * normals)
    default = (0.66, 0.68, 0.72, 1.0)
    table = np.array([s.color or default for s in mesh.surfaces] or [default])
    of_triangle = mesh.triangle_surfaces if len(mesh.triangle_surfaces) else 0
    corners["c"] = np.rint(255 * table)[of_triangle].reshape(-1, 1, 4)
    return corners.tobytes()


def _lines(mesh: Mesh) -> bytes:
    """The feature edges as pairs of positions, 8 bytes each."""
    import numpy as np

    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    scaled = (mesh.vertices - (low + high) / 2) * (2 * 32767 / (high - low).max())
    pairs = [np.stack([edge[:-1], edge[1:]], axis=1).ravel() for edge in mesh.feature_edges]
    ends = np.concatenate(pairs) if pairs else np.zeros(0, dtype="uint32")
    places = np.zeros((len(ends), 4), dtype="<i2")
    places[:, :3] = np.rint(scaled[ends])
    return places.tobytes()


def _page(mesh: Mesh, picture: Picture) -> View:
    width, height = picture.size
    png = b64encode(picture.png()).decode()
    image = (
        f'<img alt="{escape(repr(mesh))}" width="{width}" height="{height}" '
        f'src="data:image/png;base64,{png}">'
    )
    if len(mesh.triangles) > MOST_TRIANGLES:
        note = f"{len(mesh.triangles)} triangles: more than a view that turns shows"
        return View(f"<div>{image}<br><small>{note}</small></div>")
    page = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    x, y, z = mesh._clear_view()
    for name, value in {
        "IMAGE": image,
        "WIDTH": str(width),
        "HEIGHT": str(height),
        "TOWARDS": f"[{-x}, {-y}, {-z}]",
        "CORNERS": b64encode(_corners(mesh)).decode(),
        "LINES": b64encode(_lines(mesh)).decode(),
    }.items():
        page = page.replace(f"@{name}@", value)
    return View(page)


def mesh_view(self: Mesh, size: tuple[int, int] = (640, 480)) -> View:
    """A view that turns; a picture alone, if there are more than 20,000 triangles."""
    return _page(self, self.render(size=size))


def solid_view(self: Solid, size: tuple[int, int] = (640, 480)) -> View:
    """A view that turns, of a mesh to a quarter of a pixel or of 20,000 triangles.

    >>> import stereotomy as st
    >>> "<canvas" in st.cube(1).view()._repr_html_()
    True
    """
    bounds = self.bounds()
    if bounds is None:
        raise ValueError("there is nothing to show: the solid is empty")
    longest = max(high - low for low, high in zip(*bounds, strict=True))
    mesh = self.mesh(
        tolerance=longest / (4 * max(size)),
        feature_edges=30,
        max_triangles=MOST_TRIANGLES,
        partial=True,
    )
    return _page(mesh, mesh.render(size=size))


def mesh_html(self: Mesh) -> str:
    """What a notebook shows."""
    return self.view()._repr_html_()


def solid_html(self: Solid) -> str:
    """What a notebook shows."""
    return self.view()._repr_html_()
