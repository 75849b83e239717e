"""Stereotomy: solids as Boolean combinations of half-spaces, cut exactly, and turned into
meshes, measures, pictures and files.

Functions such as `sphere`, `cuboid` and `cylinder` make solids, which `|`, `&` and `-`
combine; `circle`, `polygon`, `text` and `Path` make profiles, to be extruded or revolved.
Angles are in degrees, unless `radians=True` is said. In a notebook a solid shows itself.

>>> import stereotomy as st
>>> flange = st.cylinder(1, z=0.2) | st.cylinder(0.45, z=0.7)
>>> bolt = st.infinite_cylinder(0.08).translate([0.75, 0, 0])
>>> flange = flange - st.infinite_cylinder(0.3) - bolt.polar_pattern(8)
>>> mesh = flange.mesh(tolerance=1e-4)
>>> mesh.report.is_proven, mesh.check().genus
(True, 9)
"""

from collections.abc import Callable

from . import _adapters, _view, distributed
from ._stereotomy import *  # noqa: F403
from ._stereotomy import Mesh, Profile, Solid
from ._view import View

__all__ = [
    "Animation", "Check", "Fallback", "FileError", "LimitReached", "Measure", "Mesh", "Moved", "Nearest", "Path",
    "Picture", "Profile", "RayHit", "Report", "Solid", "Surface", "Unbounded", "View", "__version__",
    "capsule", "chamfered_cuboid", "chamfered_cylinder", "circle", "cone",
    "convex_polyhedron", "counterbore", "countersink", "cube", "cuboid", "cuboid_between",
    "cylinder", "difference", "distributed", "dodecahedron", "ellipse", "ellipsoid", "elliptic_cylinder",
    "empty", "empty_profile", "from_csg", "frustum", "gear", "half_space",
    "half_space_through", "hull", "hull_of_balls", "hull_of_solids", "hull_profile", "hyperboloid_one_sheet",
    "hyperboloid_two_sheets", "icosahedron", "infinite_cone", "infinite_cylinder",
    "infinite_elliptic_cylinder", "intersection", "knurled", "load", "load_mesh",
    "nut_trap", "octahedron", "paraboloid", "polygon", "polygons", "polyhedron", "prism",
    "pyramid", "quadric", "read_solid", "rectangle", "rectangle_between", "regular_polygon",
    "regular_prism", "rounded_cuboid", "rounded_cylinder", "rounded_rectangle", "slot",
    "slot_profile", "space", "sphere", "tetrahedron", "text", "threaded_rod", "torus",
    "tube", "union", "wedge",
]

# What is written in Python becomes methods of the native classes.
_added: dict[type, dict[str, Callable[..., object]]] = {
    Mesh: {
        "to_trimesh": _adapters.mesh_to_trimesh,
        "to_manifold": _adapters.mesh_to_manifold,
        "to_pyvista": _adapters.mesh_to_pyvista,
        "view": _view.mesh_view,
        "_repr_html_": _view.repr_html,
        "_repr_png_": _view.repr_png,
        "_repr_mimebundle_": _view.repr_mimebundle,
    },
    Profile: {"_repr_svg_": _view.profile_svg},
    Solid: {
        "to_trimesh": _adapters.solid_to_trimesh,
        "to_manifold": _adapters.solid_to_manifold,
        "to_pyvista": _adapters.solid_to_pyvista,
        "view": _view.solid_view,
        "_repr_html_": _view.repr_html,
        "_repr_png_": _view.repr_png,
        "_repr_mimebundle_": _view.repr_mimebundle,
    },
}
for _class, _methods in _added.items():
    for _name, _method in _methods.items():
        setattr(_class, _name, _method)
