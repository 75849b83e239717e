"""Meshes for other libraries, which are imported when they are asked for."""

from __future__ import annotations

import importlib

# Type checkers know the name; `typing` itself would be most of the time that an import takes.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from ._stereotomy import Mesh, Solid


def _library(module: str, package: str, extra: str) -> Any:
    """The module, or an error that says how to install it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise ModuleNotFoundError(
            f"{package} is not installed: pip install {package} (or stereotomy[{extra}])",
            name=module,
        ) from None


def mesh_to_trimesh(self: Mesh) -> Any:
    """The mesh as a `trimesh.Trimesh`: the same vertices and faces in the same order, the
    surfaces' numbers as the face attribute "surface", and their colours if there are any.

    >>> import stereotomy as st
    >>> st.cube(2).to_trimesh().is_watertight
    True
    """
    trimesh = _library("trimesh", "trimesh", "trimesh")
    surfaces = self.triangle_surfaces
    colors = None
    if any(surface.color for surface in self.surfaces):
        import numpy

        default = (0.6, 0.6, 0.6, 1.0)
        table = numpy.array([surface.color or default for surface in self.surfaces])
        colors = (255 * table).round().astype("uint8")[surfaces]
    return trimesh.Trimesh(
        vertices=self.vertices,
        faces=self.triangles.astype("int64"),
        face_attributes={"surface": surfaces} if len(surfaces) else None,
        face_colors=colors,
        process=False,
    )


def mesh_to_manifold(self: Mesh) -> Any:
    """The mesh as a `manifold3d.Manifold`, in double precision.

    >>> import stereotomy as st
    >>> round(st.cube(2).to_manifold().volume(), 9)
    8.0
    """
    manifold3d = _library("manifold3d", "manifold3d", "manifold")
    mesh = manifold3d.Mesh64(
        # It takes no arrays that cannot be written to.
        vert_properties=self.vertices.copy(),
        tri_verts=self.triangles.astype("uint64"),
    )
    manifold = manifold3d.Manifold(mesh)
    if manifold.status() != manifold3d.Error.NoError:
        raise ValueError(f"manifold3d refuses the mesh: {manifold.status().name}")
    return manifold


def mesh_to_pyvista(self: Mesh) -> Any:
    """The mesh as a `pyvista.PolyData`, with the surfaces' numbers as the cell array
    "surface".
    """
    pyvista = _library("pyvista", "pyvista", "pyvista")
    poly = pyvista.PolyData.from_regular_faces(self.vertices, self.triangles)
    if len(self.triangle_surfaces):
        poly.cell_data["surface"] = self.triangle_surfaces
    return poly


def solid_to_trimesh(self: Solid, **options: Any) -> Any:
    """The solid's mesh as a `trimesh.Trimesh`; takes the options of `mesh`."""
    return self.mesh(**options).to_trimesh()


def solid_to_manifold(self: Solid, **options: Any) -> Any:
    """The solid's mesh as a `manifold3d.Manifold`; takes the options of `mesh`."""
    return self.mesh(**options).to_manifold()


def solid_to_pyvista(self: Solid, **options: Any) -> Any:
    """The solid's mesh as a `pyvista.PolyData`; takes the options of `mesh`."""
    return self.mesh(**options).to_pyvista()
