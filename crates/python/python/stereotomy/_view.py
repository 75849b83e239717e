"""A view that turns: a page of its own, without a server and without other files."""

from __future__ import annotations

from ._stereotomy import _write_file

# Type checkers know the name; `typing` itself would be most of the time that an import takes.
TYPE_CHECKING = False
if TYPE_CHECKING:
    import os

    import numpy as np
    from numpy.typing import NDArray

    from ._stereotomy import Mesh, Picture, Profile, Solid

#: What a notebook should hold: 64 letters a triangle.
MOST_TRIANGLES = 20_000


class View:
    """A picture that can be dragged to turn, in a notebook or as a file. Where scripts do
    not run, it is the picture.
    """

    def __init__(self, html: str, png: bytes) -> None:
        self._html = html
        self._png = png

    def _repr_html_(self) -> str:
        return self._html

    def _repr_png_(self) -> bytes:
        return self._png

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a page that needs no other file."""
        head = '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>Stereotomy</title>'
        _write_file(path, f"{head}<body>{self._html}</body></html>".encode())

    def __repr__(self) -> str:
        return f"<View of {len(self._html) / 1e3:.0f} kB>"


def _corners(mesh: Mesh, places: NDArray[np.float64]) -> bytes:
    """For each corner of each triangle 16 bytes: the place (3 x int16), 2 nothing, the normal
    (3 x int8), 1 nothing, and the colour (4 x uint8).
    """
    import numpy as np

    corners = np.zeros(
        (len(mesh.triangles), 3),
        dtype=[("p", "<i2", 4), ("n", "i1", 4), ("c", "u1", 4)],
    )
    corners["p"][..., :3] = np.rint(32767 * places).astype("int16")[mesh.triangles]
    normals: NDArray[np.floating] = mesh.corner_normals
    if not len(normals):
        a, b, c = (places[mesh.triangles[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        normals = np.repeat(across[:, None, :], 3, axis=1)
    corners["n"][..., :3] = np.rint(127 * normals)
    default = (0.66, 0.68, 0.72, 1.0)
    table = np.array([s.color or default for s in mesh.surfaces] or [default])
    of_triangle = mesh.triangle_surfaces if len(mesh.triangle_surfaces) else 0
    corners["c"] = np.rint(255 * table)[of_triangle].reshape(-1, 1, 4)
    return corners.tobytes()


def _lines(mesh: Mesh, places: NDArray[np.float64]) -> bytes:
    """The feature edges as pairs of places, 8 bytes each."""
    import numpy as np

    pairs = [np.stack([edge[:-1], edge[1:]], axis=1).ravel() for edge in mesh.feature_edges]
    ends = np.concatenate(pairs) if pairs else np.zeros(0, dtype="uint32")
    lines = np.zeros((len(ends), 4), dtype="<i2")
    lines[:, :3] = np.rint(32767 * places[ends])
    return lines.tobytes()


def _page(mesh: Mesh, picture: Picture) -> View:
    from base64 import b64encode
    from html import escape
    from pathlib import Path

    import numpy as np

    width, height = picture.size
    png = picture.png()
    image = (
        f'<img alt="{escape(repr(mesh))}" width="{width}" height="{height}" '
        f'src="data:image/png;base64,{b64encode(png).decode()}">'
    )
    if len(mesh.triangles) > MOST_TRIANGLES:
        note = f"{len(mesh.triangles)} triangles: more than a view that turns shows"
        return View(f"<div>{image}<br><small>{note}</small></div>", png)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    places = (mesh.vertices - middle) / half
    page = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    # As the picture has it, where the largest extent goes from -1 to 1.
    eye, target = ((np.array(place) - middle) / half for place in mesh._camera(picture.size))
    for name, value in {
        "IMAGE": image,
        "WIDTH": str(width),
        "HEIGHT": str(height),
        "EYE": str((eye - target).tolist()),
        "TARGET": str(target.tolist()),
        "CORNERS": b64encode(_corners(mesh, places)).decode(),
        "LINES": b64encode(_lines(mesh, places)).decode(),
    }.items():
        page = page.replace(f"@{name}@", value)
    return View(page, png)


def _check_size(size: tuple[int, int]) -> None:
    if min(size) < 1:
        raise ValueError(f"view: size is {size}: give numbers of pixels from 1")


def mesh_view(self: Mesh, size: tuple[int, int] = (640, 480)) -> View:
    """A view that turns; a picture alone, if there are more than 20,000 triangles."""
    _check_size(size)
    return _page(self, self.render(size=size))


def solid_view(self: Solid, size: tuple[int, int] = (640, 480)) -> View:
    """A view that turns, of a mesh to a quarter of a pixel, or to a pixel or four where that
    would take more than 20,000 triangles; a picture alone, if those do as well.

    >>> import stereotomy as st
    >>> "<canvas" in st.cube(1).view()._repr_html_()
    True
    """
    bounds = self.bounds()
    if bounds is None:
        raise ValueError("there is nothing to show: the solid is empty")
    _check_size(size)
    pixel = max(high - low for low, high in zip(*bounds, strict=True)) / max(size)
    mesh = self.mesh(tolerance=pixel / 4, feature_edges=30)
    picture = mesh.render(size=size)
    for tolerance in (pixel, 4 * pixel):
        # Of flat faces no mesh has fewer triangles.
        is_flat = mesh.report is not None and mesh.report.method == "polyhedral"
        if is_flat or len(mesh.triangles) <= MOST_TRIANGLES:
            break
        mesh = self.mesh(tolerance=tolerance, feature_edges=30)
    return _page(mesh, picture)


def _shown(self: Mesh | Solid) -> View | None:
    """The view; without end, or empty, a solid is shown as text."""
    try:
        return self.view()
    except ValueError:
        return None


def repr_html(self: Mesh | Solid) -> str | None:
    """What a notebook shows, if there is anything to see."""
    view = _shown(self)
    return None if view is None else view._repr_html_()


def repr_png(self: Mesh | Solid) -> bytes | None:
    """What a notebook shows where there is no HTML."""
    view = _shown(self)
    return None if view is None else view._repr_png_()


def repr_mimebundle(
    self: Mesh | Solid, include: object = None, exclude: object = None
) -> dict[str, str | bytes]:
    """Both at once, of one mesh."""
    view = _shown(self)
    if view is None:
        return {}
    return {"text/html": view._repr_html_(), "image/png": view._repr_png_()}


def profile_svg(self: Profile) -> str | None:
    """What a notebook shows of a profile: its outlines, filled, the y axis upwards."""
    bounds = self.bounds()
    if bounds is None:
        return None
    (x0, y0), (x1, y1) = bounds
    width, height = x1 - x0, y1 - y0
    margin = 0.05 * max(width, height)
    scale = 320 / max(width, height)
    contours = self.contours(max(width, height) / 2000)
    path = "".join(
        "M" + "L".join(f"{x:.9g},{-y:.9g}" for x, y in contour.tolist()) + "Z"
        for contour in contours
    )
    box = (x0 - margin, -y1 - margin, width + 2 * margin, height + 2 * margin)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" '
        f'width="{box[2] * scale:.0f}" height="{box[3] * scale:.0f}" '
        f'viewBox="{" ".join(f"{number:.9g}" for number in box)}">'
        f'<path d="{path}" fill="#a8adb8" stroke="#1a1a1f" stroke-width="{1 / scale:.3g}" '
        'fill-rule="evenodd"/></svg>'
    )
