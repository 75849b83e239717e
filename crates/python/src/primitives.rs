//! Functions that make solids: primitives, polyhedra and Boolean operations of many.

use csg::{Plane, Solid};
use pyo3::prelude::*;

use crate::arguments::{Extent, angle};
use crate::arrays;
use crate::errors::call;
use crate::solid::{PySolid, checked, checked_whole};

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(empty, module)?)?;
    module.add_function(wrap_pyfunction!(space, module)?)?;
    module.add_function(wrap_pyfunction!(half_space, module)?)?;
    module.add_function(wrap_pyfunction!(half_space_through, module)?)?;
    module.add_function(wrap_pyfunction!(quadric, module)?)?;
    module.add_function(wrap_pyfunction!(cube, module)?)?;
    module.add_function(wrap_pyfunction!(cuboid, module)?)?;
    module.add_function(wrap_pyfunction!(cuboid_between, module)?)?;
    module.add_function(wrap_pyfunction!(sphere, module)?)?;
    module.add_function(wrap_pyfunction!(ellipsoid, module)?)?;
    module.add_function(wrap_pyfunction!(cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(infinite_cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(elliptic_cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(infinite_elliptic_cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(cone, module)?)?;
    module.add_function(wrap_pyfunction!(frustum, module)?)?;
    module.add_function(wrap_pyfunction!(infinite_cone, module)?)?;
    module.add_function(wrap_pyfunction!(paraboloid, module)?)?;
    module.add_function(wrap_pyfunction!(hyperboloid_one_sheet, module)?)?;
    module.add_function(wrap_pyfunction!(hyperboloid_two_sheets, module)?)?;
    module.add_function(wrap_pyfunction!(convex_polyhedron, module)?)?;
    module.add_function(wrap_pyfunction!(prism, module)?)?;
    module.add_function(wrap_pyfunction!(polyhedron, module)?)?;
    module.add_function(wrap_pyfunction!(hull, module)?)?;
    module.add_function(wrap_pyfunction!(hull_of_balls, module)?)?;
    module.add_function(wrap_pyfunction!(union, module)?)?;
    module.add_function(wrap_pyfunction!(intersection, module)?)?;
    module.add_function(wrap_pyfunction!(difference, module)?)
}

/// The solid without any point.
#[pyfunction]
fn empty() -> PySolid {
    PySolid(Solid::empty())
}

/// All points.
#[pyfunction]
fn space() -> PySolid {
    PySolid(Solid::space())
}

/// The points p with normal . p <= offset for the unit vector along `normal`, which
/// points outwards.
///
/// >>> import stereotomy as st
/// >>> st.half_space([0, 0, 1], offset=2).contains([5, 5, 1.9])
/// True
#[pyfunction]
#[pyo3(signature = (normal, offset=0.0))]
fn half_space(normal: [f64; 3], offset: f64) -> PyResult<PySolid> {
    checked(
        Solid::half_space(normal, offset),
        call!("half_space", normal, offset),
    )
}

/// The half-space behind the plane through `point` with the outward normal `normal`.
///
/// >>> import stereotomy as st
/// >>> st.half_space_through(point=[0, 0, 2], normal=[0, 0, 3]).contains([0, 0, 1])
/// True
#[pyfunction]
fn half_space_through(point: [f64; 3], normal: [f64; 3]) -> PyResult<PySolid> {
    checked(
        Solid::half_space_through(point, normal),
        call!("half_space_through", point, normal),
    )
}

/// The points with c0 x² + c1 y² + c2 z² + c3 xy + c4 yz + c5 zx + c6 x + c7 y + c8 z
/// + c9 <= 0.
///
/// >>> import stereotomy as st
/// >>> st.quadric([1, 1, 0, 0, 0, 0, 0, 0, -1, 0]).contains([1, 1, 3])
/// True
#[pyfunction]
fn quadric(coefficients: [f64; 10]) -> PyResult<PySolid> {
    checked(Solid::quadric(coefficients), call!("quadric", coefficients))
}

/// A cube around the origin.
///
/// >>> import stereotomy as st
/// >>> round(st.cube(2).measure().volume, 9)
/// 8.0
#[pyfunction]
fn cube(side: f64) -> PyResult<PySolid> {
    checked(Solid::cube(side), call!("cube", side))
}

/// A box of these side lengths around the origin.
///
/// >>> import stereotomy as st
/// >>> round(st.cuboid([1, 2, 3]).measure().volume, 9)
/// 6.0
#[pyfunction]
fn cuboid(sides: [f64; 3]) -> PyResult<PySolid> {
    checked(Solid::cuboid(sides), call!("cuboid", sides))
}

/// The box from its least to its greatest corner.
///
/// >>> import stereotomy as st
/// >>> st.cuboid_between([0, 0, 0], [1, 2, 3]).mesh().bounds
/// ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
#[pyfunction]
fn cuboid_between(min: [f64; 3], max: [f64; 3]) -> PyResult<PySolid> {
    checked(
        Solid::cuboid_between(min, max),
        call!("cuboid_between", min, max),
    )
}

/// A ball around the origin.
///
/// >>> import stereotomy as st
/// >>> st.sphere(-1)
/// Traceback (most recent call last):
/// ValueError: sphere(radius=-1.0): a radius is -1: it must be positive and finite
#[pyfunction]
fn sphere(radius: f64) -> PyResult<PySolid> {
    checked(Solid::sphere(radius), call!("sphere", radius))
}

/// An ellipsoid around the origin with these semi-axes.
///
/// >>> import stereotomy as st
/// >>> st.ellipsoid([1, 2, 3]).contains([0, 0, 2.9])
/// True
#[pyfunction]
fn ellipsoid(radii: [f64; 3]) -> PyResult<PySolid> {
    checked(Solid::ellipsoid(radii), call!("ellipsoid", radii))
}

/// A cylinder around the z axis; `z` is its height, from 0, or (low, high).
///
/// >>> import stereotomy as st
/// >>> st.cylinder(1, z=2).contains([0.9, 0, 1.9])
/// True
/// >>> st.cylinder(radius=1, z=(-1, 1)).contains([0, 0, 1.9])
/// False
#[pyfunction]
fn cylinder(radius: f64, z: Extent) -> PyResult<PySolid> {
    checked(
        Solid::cylinder(radius, z.0.clone()),
        call!("cylinder", radius, z),
    )
}

/// A cylinder around the z axis without ends, as for bores.
///
/// >>> import stereotomy as st
/// >>> st.infinite_cylinder(1).contains([0.9, 0, 1e9])
/// True
#[pyfunction]
fn infinite_cylinder(radius: f64) -> PyResult<PySolid> {
    checked(
        Solid::infinite_cylinder(radius),
        call!("infinite_cylinder", radius),
    )
}

/// A cylinder around the z axis over an ellipse with semi-axes along x and y.
///
/// >>> import stereotomy as st
/// >>> st.elliptic_cylinder([1, 2], z=3).contains([0, 1.9, 1])
/// True
#[pyfunction]
fn elliptic_cylinder(radii: [f64; 2], z: Extent) -> PyResult<PySolid> {
    checked(
        Solid::elliptic_cylinder(radii, z.0.clone()),
        call!("elliptic_cylinder", radii, z),
    )
}

/// An elliptic cylinder around the z axis without ends.
///
/// >>> import stereotomy as st
/// >>> st.infinite_elliptic_cylinder([1, 2]).contains([0, 1.9, 1e9])
/// True
#[pyfunction]
fn infinite_elliptic_cylinder(radii: [f64; 2]) -> PyResult<PySolid> {
    checked(
        Solid::infinite_elliptic_cylinder(radii),
        call!("infinite_elliptic_cylinder", radii),
    )
}

/// A cone of this radius at the lower end, its apex at the upper.
///
/// >>> import stereotomy as st
/// >>> st.cone(1, z=2).contains([0, 0, 1.9])
/// True
#[pyfunction]
fn cone(radius: f64, z: Extent) -> PyResult<PySolid> {
    checked(Solid::cone(radius, z.0.clone()), call!("cone", radius, z))
}

/// A cone cut off: the radii at its lower and upper end.
///
/// >>> import stereotomy as st
/// >>> st.frustum(bottom=2, top=1, z=3).contains([1.5, 0, 1])
/// True
#[pyfunction]
fn frustum(bottom: f64, top: f64, z: Extent) -> PyResult<PySolid> {
    checked(
        Solid::frustum(bottom, top, z.0.clone()),
        call!("frustum", bottom, top, z),
    )
}

/// A cone that opens upwards from the origin without end; the angle between its axis and
/// its side in degrees.
///
/// >>> import stereotomy as st
/// >>> st.infinite_cone(half_angle=45).contains([0.9, 0, 1])
/// True
#[pyfunction]
#[pyo3(signature = (half_angle, *, radians=false))]
fn infinite_cone(half_angle: f64, radians: bool) -> PyResult<PySolid> {
    checked(
        Solid::infinite_cone(angle(half_angle, radians)),
        call!("infinite_cone", half_angle),
    )
}

/// The points with z >= (x/a)² + (y/b)².
///
/// >>> import stereotomy as st
/// >>> st.paraboloid([1, 2]).contains([0, 2, 1.1])
/// True
#[pyfunction]
fn paraboloid(scales: [f64; 2]) -> PyResult<PySolid> {
    checked(Solid::paraboloid(scales), call!("paraboloid", scales))
}

/// The points with (x/a)² + (y/b)² - (z/c)² <= 1.
///
/// >>> import stereotomy as st
/// >>> st.hyperboloid_one_sheet([1, 1, 1]).contains([0.9, 0, 0])
/// True
#[pyfunction]
fn hyperboloid_one_sheet(radii: [f64; 3]) -> PyResult<PySolid> {
    checked(
        Solid::hyperboloid_one_sheet(radii),
        call!("hyperboloid_one_sheet", radii),
    )
}

/// The points with (z/c)² - (x/a)² - (y/b)² >= 1.
///
/// >>> import stereotomy as st
/// >>> st.hyperboloid_two_sheets([1, 1, 1]).contains([0, 0, -1.1])
/// True
#[pyfunction]
fn hyperboloid_two_sheets(radii: [f64; 3]) -> PyResult<PySolid> {
    checked(
        Solid::hyperboloid_two_sheets(radii),
        call!("hyperboloid_two_sheets", radii),
    )
}

/// What lies behind all planes, each (outward normal, offset): p with
/// normal . p <= offset.
///
/// >>> import stereotomy as st
/// >>> corner = st.convex_polyhedron([([-1, 0, 0], 0), ([0, -1, 0], 0), ([0, 0, -1], 0), ([1, 1, 1], 1)])
/// >>> round(6 * corner.measure().volume, 9)
/// 1.0
#[pyfunction]
fn convex_polyhedron(planes: Vec<([f64; 3], f64)>) -> PyResult<PySolid> {
    let made = planes.iter().map(|&(normal, offset)| Plane {
        normal: normal.into(),
        offset,
    });
    checked(
        Solid::convex_polyhedron(made),
        call!("convex_polyhedron", planes),
    )
}

/// A prism along z over a convex polygon.
///
/// >>> import stereotomy as st
/// >>> round(st.prism([[0, 0], [2, 0], [0, 1]], z=3).measure().volume, 9)
/// 3.0
#[pyfunction]
fn prism(polygon: Vec<[f64; 2]>, z: Extent) -> PyResult<PySolid> {
    checked(
        Solid::prism(polygon.iter().copied(), z.0.clone()),
        call!("prism", polygon, z),
    )
}

/// The solid that faces bound: an array of vertices of shape (n, 3), and for each face
/// the indices of its corners, counter-clockwise seen from outside. Faces that are open,
/// inside out or run through each other are an error with their places.
///
/// >>> import stereotomy as st
/// >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
/// >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
/// >>> round(6 * st.polyhedron(corners, faces).measure().volume, 9)
/// 1.0
#[pyfunction]
fn polyhedron(vertices: &Bound<'_, PyAny>, faces: Vec<Vec<u32>>) -> PyResult<PySolid> {
    let vertices: Vec<[f64; 3]> = arrays::rows("vertices", vertices)?;
    checked_whole(
        Solid::polyhedron(vertices.iter().copied(), &faces),
        call!("polyhedron", vertices, faces),
    )
}

/// The least convex solid around points, an array of shape (n, 3).
///
/// >>> import stereotomy as st
/// >>> corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
/// >>> round(st.hull(corners).measure().volume, 9)
/// 1.0
#[pyfunction]
fn hull(points: &Bound<'_, PyAny>) -> PyResult<PySolid> {
    let points: Vec<[f64; 3]> = arrays::rows("points", points)?;
    checked_whole(Solid::hull(points.iter().copied()), call!("hull", points))
}

/// The least convex solid around balls of one radius.
///
/// >>> import stereotomy as st
/// >>> st.hull_of_balls([[0, 0, 0], [2, 0, 0]], radius=1).contains([1, 0, 0.99])
/// True
#[pyfunction]
fn hull_of_balls(centers: &Bound<'_, PyAny>, radius: f64) -> PyResult<PySolid> {
    let centers: Vec<[f64; 3]> = arrays::rows("centers", centers)?;
    let points: Vec<_> = centers.iter().copied().map(Into::into).collect();
    let call = call!("hull_of_balls", centers, radius);
    match Solid::hull_of_balls(&points, radius) {
        Some(solid) => checked_whole(solid, call),
        None => Err(crate::errors::invalid(format!(
            "{}: three and more centers must be finite and not in one plane",
            call()
        ))),
    }
}

/// The points in any of the solids.
///
/// >>> import stereotomy as st
/// >>> row = st.union(st.sphere(1).translate([3 * k, 0, 0]) for k in range(4))
/// >>> row.mesh().check().components
/// 4
#[pyfunction]
fn union(solids: &Bound<'_, PyAny>) -> PyResult<PySolid> {
    Ok(PySolid(Solid::union(all("union", solids)?)))
}

/// The points in all of the solids.
///
/// >>> import stereotomy as st
/// >>> st.intersection([st.cube(2), st.sphere(1.2)]).contains([0.9, 0.9, 0.9])
/// False
#[pyfunction]
fn intersection(solids: &Bound<'_, PyAny>) -> PyResult<PySolid> {
    Ok(PySolid(Solid::intersection(all("intersection", solids)?)))
}

/// The first solid without all the others.
///
/// >>> import stereotomy as st
/// >>> st.difference([st.cube(2), st.sphere(1.2)]).contains([0.9, 0.9, 0.9])
/// True
#[pyfunction]
fn difference(solids: &Bound<'_, PyAny>) -> PyResult<PySolid> {
    Ok(PySolid(Solid::difference(all("difference", solids)?)))
}

/// The solids of any iterable.
fn all(function: &str, solids: &Bound<'_, PyAny>) -> PyResult<Vec<Solid>> {
    let mut all = Vec::new();
    for solid in solids.try_iter()? {
        all.push(solid?.extract::<PySolid>()?.0);
    }
    if all.is_empty() {
        return Err(crate::errors::invalid(format!(
            "{function}(solids=[]): give at least one solid (empty() for none)"
        )));
    }
    Ok(all)
}
