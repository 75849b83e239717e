//! Functions that make ready-made solids: bodies, holes, fasteners.

use csg::{Screw, Solid};
use pyo3::prelude::*;

use crate::arguments::Extent;
use crate::errors::{call, invalid};
use crate::solid::{PySolid, checked_whole};

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(torus, module)?)?;
    module.add_function(wrap_pyfunction!(capsule, module)?)?;
    module.add_function(wrap_pyfunction!(tube, module)?)?;
    module.add_function(wrap_pyfunction!(rounded_cuboid, module)?)?;
    module.add_function(wrap_pyfunction!(chamfered_cuboid, module)?)?;
    module.add_function(wrap_pyfunction!(chamfered_cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(rounded_cylinder, module)?)?;
    module.add_function(wrap_pyfunction!(wedge, module)?)?;
    module.add_function(wrap_pyfunction!(pyramid, module)?)?;
    module.add_function(wrap_pyfunction!(regular_prism, module)?)?;
    module.add_function(wrap_pyfunction!(tetrahedron, module)?)?;
    module.add_function(wrap_pyfunction!(octahedron, module)?)?;
    module.add_function(wrap_pyfunction!(dodecahedron, module)?)?;
    module.add_function(wrap_pyfunction!(icosahedron, module)?)?;
    module.add_function(wrap_pyfunction!(threaded_rod, module)?)?;
    module.add_function(wrap_pyfunction!(counterbore, module)?)?;
    module.add_function(wrap_pyfunction!(countersink, module)?)?;
    module.add_function(wrap_pyfunction!(nut_trap, module)?)?;
    module.add_function(wrap_pyfunction!(slot, module)?)
}

/// A torus around the z axis: all points within `minor` of a circle of radius `major`.
/// (It is not a surface of its own yet: the circle that is turned becomes 32 chords of the
/// same area.)
///
/// >>> import stereotomy as st
/// >>> st.torus(3, 1).contains([3.9, 0, 0]), st.torus(3, 1).contains([1.9, 0, 0])
/// (True, False)
#[pyfunction]
fn torus(major: f64, minor: f64) -> PyResult<PySolid> {
    checked_whole(Solid::torus(major, minor), call!("torus", major, minor))
}

/// All points within `radius` of a stretch of the z axis.
///
/// >>> import stereotomy as st
/// >>> st.capsule(1, z=(-2, 2)).contains([0, 0, 2.9])
/// True
#[pyfunction]
fn capsule(radius: f64, z: Extent) -> PyResult<PySolid> {
    checked_whole(
        Solid::capsule(radius, z.0.clone()),
        call!("capsule", radius, z),
    )
}

/// A tube around the z axis.
///
/// >>> import stereotomy as st
/// >>> st.tube(outer=1, inner=2, z=1)
/// Traceback (most recent call last):
/// ValueError: tube(outer=1.0, inner=2.0, z=(0.0, 1.0)): the inner radius is 2: it must be less than 1
#[pyfunction]
fn tube(outer: f64, inner: f64, z: Extent) -> PyResult<PySolid> {
    checked_whole(
        Solid::tube(outer, inner, z.0.clone()),
        call!("tube", outer, inner, z),
    )
}

/// A box around the origin with all edges rounded.
///
/// >>> import stereotomy as st
/// >>> st.rounded_cuboid([2, 2, 2], radius=0.5).contains([0.95, 0.95, 0.95])
/// False
#[pyfunction]
fn rounded_cuboid(sides: [f64; 3], radius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::rounded_cuboid(sides, radius),
        call!("rounded_cuboid", sides, radius),
    )
}

/// A box around the origin with all edges cut off at 45°.
///
/// >>> import stereotomy as st
/// >>> st.chamfered_cuboid([2, 2, 2], chamfer=0.5).contains([0.9, 0.9, 0])
/// False
#[pyfunction]
fn chamfered_cuboid(sides: [f64; 3], chamfer: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::chamfered_cuboid(sides, chamfer),
        call!("chamfered_cuboid", sides, chamfer),
    )
}

/// A cylinder around the z axis with its rims cut off at 45°.
///
/// >>> import stereotomy as st
/// >>> st.chamfered_cylinder(1, z=2, chamfer=0.25).contains([0.95, 0, 1.95])
/// False
#[pyfunction]
fn chamfered_cylinder(radius: f64, z: Extent, chamfer: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::chamfered_cylinder(radius, z.0.clone(), chamfer),
        call!("chamfered_cylinder", radius, z, chamfer),
    )
}

/// A cylinder around the z axis with rounded rims.
///
/// >>> import stereotomy as st
/// >>> st.rounded_cylinder(1, z=2, fillet=0.25).contains([0.95, 0, 1.95])
/// False
#[pyfunction]
fn rounded_cylinder(radius: f64, z: Extent, fillet: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::rounded_cylinder(radius, z.0.clone(), fillet),
        call!("rounded_cylinder", radius, z, fillet),
    )
}

/// Half of a box from the origin to these sides: a ramp of full height at x = 0 and of none
/// at its other end.
///
/// >>> import stereotomy as st
/// >>> round(st.wedge([1, 2, 3]).measure().volume, 9)
/// 3.0
#[pyfunction]
fn wedge(sides: [f64; 3]) -> PyResult<PySolid> {
    checked_whole(Solid::wedge(sides), call!("wedge", sides))
}

/// A pyramid over a regular polygon, its first corner on +x.
///
/// >>> import stereotomy as st
/// >>> round(st.pyramid(4, circumradius=2, z=3).measure().volume, 9)
/// 8.0
#[pyfunction]
fn pyramid(corners: usize, circumradius: f64, z: Extent) -> PyResult<PySolid> {
    checked_whole(
        Solid::pyramid(corners, circumradius, z.0.clone()),
        call!("pyramid", corners, circumradius, z),
    )
}

/// A prism over a regular polygon, its first corner on +x.
///
/// >>> import stereotomy as st
/// >>> round(st.regular_prism(4, circumradius=1, z=3).measure().volume, 9)
/// 6.0
#[pyfunction]
fn regular_prism(corners: usize, circumradius: f64, z: Extent) -> PyResult<PySolid> {
    checked_whole(
        Solid::regular_prism(corners, circumradius, z.0.clone()),
        call!("regular_prism", corners, circumradius, z),
    )
}

/// A regular tetrahedron around the origin: its 4 corners are at a distance of `circumradius`.
///
/// >>> import stereotomy as st
/// >>> st.tetrahedron(1).mesh().check().vertices
/// 4
#[pyfunction]
fn tetrahedron(circumradius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::tetrahedron(circumradius),
        call!("tetrahedron", circumradius),
    )
}

/// A regular octahedron around the origin: its 6 corners are at a distance of `circumradius`.
///
/// >>> import stereotomy as st
/// >>> st.octahedron(1).mesh().check().vertices
/// 6
#[pyfunction]
fn octahedron(circumradius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::octahedron(circumradius),
        call!("octahedron", circumradius),
    )
}

/// A regular dodecahedron around the origin: its 20 corners are at a distance of `circumradius`.
///
/// >>> import stereotomy as st
/// >>> st.dodecahedron(1).mesh().check().vertices
/// 20
#[pyfunction]
fn dodecahedron(circumradius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::dodecahedron(circumradius),
        call!("dodecahedron", circumradius),
    )
}

/// A regular icosahedron around the origin: its 12 corners are at a distance of `circumradius`.
///
/// >>> import stereotomy as st
/// >>> st.icosahedron(1).mesh().check().vertices
/// 12
#[pyfunction]
fn icosahedron(circumradius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::icosahedron(circumradius),
        call!("icosahedron", circumradius),
    )
}

/// A right-handed threaded rod from z = 0 along z, in flat steps, so many to a turn. The
/// pitch is that of the coarse metric thread (ISO 261) of the diameter, if it has one and no
/// other is given.
///
/// >>> import stereotomy as st
/// >>> bolt = st.threaded_rod(diameter=8, length=5)
/// >>> bolt.contains([3.3, 0, 2]), bolt.contains([4.1, 0, 2])
/// (True, False)
/// >>> st.threaded_rod(diameter=7, length=5)
/// Traceback (most recent call last):
/// ValueError: threaded_rod(diameter=7.0, length=5.0): no coarse metric thread has this diameter: give a pitch
#[pyfunction]
#[pyo3(signature = (diameter, length, *, pitch=None, steps=16))]
fn threaded_rod(diameter: f64, length: f64, pitch: Option<f64>, steps: usize) -> PyResult<PySolid> {
    let call = call!("threaded_rod", diameter, length);
    let Some(pitch) = pitch.or_else(|| Screw::metric(diameter).map(|screw| screw.pitch)) else {
        let problem = "no coarse metric thread has this diameter: give a pitch";
        return Err(invalid(format!("{}: {problem}", call())));
    };
    let screw = Screw {
        diameter,
        pitch,
        steps,
    };
    checked_whole(Solid::threaded_rod(screw, length), call)
}

/// A hole of a screw with a cylindrical head, downwards from z = 0: a bore of `depth`, and a
/// wider one of `head_depth`. To be subtracted.
///
/// >>> import stereotomy as st
/// >>> hole = st.counterbore(radius=2, depth=10, head_radius=4, head_depth=3)
/// >>> hole.contains([3, 0, -2]), hole.contains([3, 0, -4])
/// (True, False)
#[pyfunction]
fn counterbore(radius: f64, depth: f64, head_radius: f64, head_depth: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::counterbore(radius, depth, head_radius, head_depth),
        call!("counterbore", radius, depth, head_radius, head_depth),
    )
}

/// A hole of a screw with a conical head of 90°, downwards from z = 0. To be subtracted.
///
/// >>> import stereotomy as st
/// >>> st.countersink(radius=2, depth=10, head_radius=4).contains([3.9, 0, -0.05])
/// True
#[pyfunction]
fn countersink(radius: f64, depth: f64, head_radius: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::countersink(radius, depth, head_radius),
        call!("countersink", radius, depth, head_radius),
    )
}

/// A pocket for a hexagonal nut, downwards from z = 0, two of its corners on the x axis.
///
/// >>> import stereotomy as st
/// >>> st.nut_trap(across_flats=13, depth=6).contains([0, 6.4, -1])
/// True
#[pyfunction]
fn nut_trap(across_flats: f64, depth: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::nut_trap(across_flats, depth),
        call!("nut_trap", across_flats, depth),
    )
}

/// A slotted hole, downwards from z = 0: all that a cutter of `radius` takes away on its way
/// of `length` along x, centred. (Its outline is `slot_profile`.)
///
/// >>> import stereotomy as st
/// >>> st.slot(length=4, radius=1, depth=2).contains([2.9, 0, -1])
/// True
#[pyfunction]
fn slot(length: f64, radius: f64, depth: f64) -> PyResult<PySolid> {
    checked_whole(
        Solid::slot(length, radius, depth),
        call!("slot", length, radius, depth),
    )
}
