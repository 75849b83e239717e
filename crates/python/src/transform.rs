//! Transforms of solids. Angles are in degrees, unless radians are asked for.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pyo3::prelude::*;

use crate::arguments::{Each, angle_within_a_turn as within, axis};
use crate::errors::{call, invalid};
use crate::solid::{PySolid, checked};

#[pymethods]
impl PySolid {
    /// Moves by `offset`.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(2).translate([1, 1, 1]).mesh().bounds
    /// ((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
    fn translate(&self, offset: [f64; 3]) -> PyResult<Self> {
        checked(self.0.translate(offset), call!("translate", offset))
    }

    /// Turns about the x axis by degrees (or radians), counter-clockwise seen against it.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cylinder(1, z=5).rotate_x(90).contains([0, -4.9, 0])
    /// True
    #[pyo3(signature = (angle, *, radians=false))]
    fn rotate_x(&self, angle: f64, radians: bool) -> PyResult<Self> {
        let turned = if radians {
            self.0.rotate_x(angle)
        } else {
            self.0.rotate_x_degrees(angle)
        };
        checked(turned, call!("rotate_x", angle))
    }

    /// Turns about the y axis by degrees (or radians), counter-clockwise seen against it.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cylinder(1, z=5).rotate_y(90).contains([4.9, 0, 0])
    /// True
    #[pyo3(signature = (angle, *, radians=false))]
    fn rotate_y(&self, angle: f64, radians: bool) -> PyResult<Self> {
        let turned = if radians {
            self.0.rotate_y(angle)
        } else {
            self.0.rotate_y_degrees(angle)
        };
        checked(turned, call!("rotate_y", angle))
    }

    /// Turns about the z axis by degrees (or radians), counter-clockwise seen against it.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cuboid_between([0, 0, 0], [5, 1, 1]).rotate_z(90).contains([-0.5, 4.9, 0.5])
    /// True
    #[pyo3(signature = (angle, *, radians=false))]
    fn rotate_z(&self, angle: f64, radians: bool) -> PyResult<Self> {
        let turned = if radians {
            self.0.rotate_z(angle)
        } else {
            self.0.rotate_z_degrees(angle)
        };
        checked(turned, call!("rotate_z", angle))
    }

    /// Turns about an axis through the origin by degrees (or radians), counter-clockwise
    /// seen against it.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).rotate_about_axis([0, 0, 0], 90)
    /// Traceback (most recent call last):
    /// ValueError: rotate_about_axis(axis=[0.0, 0.0, 0.0], angle=90.0): the rotation axis is zero: give it a direction
    #[pyo3(signature = (axis, angle, *, radians=false))]
    fn rotate_about_axis(&self, axis: [f64; 3], angle: f64, radians: bool) -> PyResult<Self> {
        let turned = if radians {
            self.0.rotate_about_axis(axis, angle)
        } else {
            self.0.rotate_about_axis_degrees(axis, angle)
        };
        checked(turned, call!("rotate_about_axis", axis, angle))
    }

    /// Turns about the line through `point` along `axis` by degrees (or radians).
    ///
    /// >>> import stereotomy as st
    /// >>> turned = st.sphere(1).rotate_about_line([5, 0, 0], [0, 0, 1], 180)
    /// >>> turned.contains([10, 0, 0])
    /// True
    #[pyo3(signature = (point, axis, angle, *, radians=false))]
    fn rotate_about_line(
        &self,
        point: [f64; 3],
        axis: [f64; 3],
        angle: f64,
        radians: bool,
    ) -> PyResult<Self> {
        let turned = self
            .0
            .rotate_about_line(point, axis, within(angle, radians));
        checked(turned, call!("rotate_about_line", point, axis, angle))
    }

    /// The shortest rotation that takes one direction to another.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cylinder(1, z=5).rotate_from_to([0, 0, 1], [1, 0, 0]).contains([4.9, 0, 0])
    /// True
    fn rotate_from_to(&self, start: [f64; 3], end: [f64; 3]) -> PyResult<Self> {
        let turned = self.0.rotate_from_to(start, end);
        checked(turned, call!("rotate_from_to", start, end))
    }

    /// Turns about x, then y, then z, each by degrees (or radians).
    ///
    /// >>> import stereotomy as st
    /// >>> box = st.cuboid([2, 1.2, 0.6]).rotate_xyz(0.7, 0.5, 0.3, radians=True)
    /// >>> round(box.measure().volume, 9)
    /// 1.44
    #[pyo3(signature = (x, y, z, *, radians=false))]
    fn rotate_xyz(&self, x: f64, y: f64, z: f64, radians: bool) -> PyResult<Self> {
        let [rx, ry, rz] = [x, y, z].map(|angle| crate::arguments::angle(angle, radians));
        checked(self.0.rotate_xyz(rx, ry, rz), call!("rotate_xyz", x, y, z))
    }

    /// Turns about z, then y, then x, each by degrees (or radians).
    #[pyo3(signature = (z, y, x, *, radians=false))]
    fn rotate_zyx(&self, z: f64, y: f64, x: f64, radians: bool) -> PyResult<Self> {
        let [rz, ry, rx] = [z, y, x].map(|angle| crate::arguments::angle(angle, radians));
        checked(self.0.rotate_zyx(rz, ry, rx), call!("rotate_zyx", z, y, x))
    }

    /// Turns about z, then x, then z again, each by degrees (or radians).
    #[pyo3(signature = (first, x, last, *, radians=false))]
    fn rotate_zxz(&self, first: f64, x: f64, last: f64, radians: bool) -> PyResult<Self> {
        let [a, b, c] = [first, x, last].map(|angle| crate::arguments::angle(angle, radians));
        checked(
            self.0.rotate_zxz(a, b, c),
            call!("rotate_zxz", first, x, last),
        )
    }

    /// The Euler transform: roll about z, then pitch about x, then heading about y, each in
    /// degrees (or radians).
    #[pyo3(signature = (heading, pitch, roll, *, radians=false))]
    fn rotate_euler(&self, heading: f64, pitch: f64, roll: f64, radians: bool) -> PyResult<Self> {
        let [h, p, r] = [heading, pitch, roll].map(|angle| crate::arguments::angle(angle, radians));
        checked(
            self.0.rotate_euler(h, p, r),
            call!("rotate_euler", heading, pitch, roll),
        )
    }

    /// Turns by a quaternion (x, y, z, w), of any length but zero.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cylinder(1, z=5).rotate_by([1, 0, 0, 1]).contains([0, -4.9, 0])
    /// True
    fn rotate_by(&self, quaternion: [f64; 4]) -> PyResult<Self> {
        let turned = self.0.rotate_by(DQuat::from_array(quaternion));
        checked(turned, call!("rotate_by", quaternion))
    }

    /// Scales from the origin: by one factor, or by three along x, y and z; negative ones
    /// mirror.
    ///
    /// >>> import stereotomy as st
    /// >>> round(st.cube(1).scale([1, 2, 3]).measure().volume, 9)
    /// 6.0
    fn scale(&self, factor: Each<3>) -> PyResult<Self> {
        let scaled = self.0.scale_xyz(factor.array());
        checked(scaled, call!("scale", factor))
    }

    /// Scales with `point` staying where it is.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(2).scale_about([1, 1, 1], 2).mesh().bounds
    /// ((-3.0, -3.0, -3.0), (1.0, 1.0, 1.0))
    fn scale_about(&self, point: [f64; 3], factor: Each<3>) -> PyResult<Self> {
        let scaled = self.0.scale_about(point, factor.array());
        checked(scaled, call!("scale_about", point, factor))
    }

    /// Scales along one direction from the origin, not across it.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).scale_along([1, 0, 0], 3).contains([2.9, 0, 0])
    /// True
    fn scale_along(&self, direction: [f64; 3], factor: f64) -> PyResult<Self> {
        let scaled = self.0.scale_along(direction, factor);
        checked(scaled, call!("scale_along", direction, factor))
    }

    /// Shears: adds `factor` times the coordinate along the axis `by` to the one along
    /// `moved`, two of "x", "y" and "z".
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(2).shear("x", by="z", factor=1).contains([1.5, 0, 0.9])
    /// True
    fn shear(&self, moved: &str, by: &str, factor: f64) -> PyResult<Self> {
        let sheared = self.0.shear(axis("moved", moved)?, axis("by", by)?, factor);
        checked(sheared, call!("shear", moved, by, factor))
    }

    /// Mirrors in the plane through `point` across `normal`.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).mirror([1, 0, 0], point=[3, 0, 0]).contains([6, 0, 0])
    /// True
    #[pyo3(signature = (normal, point=[0.0; 3]), text_signature = "($self, normal, point=(0.0, 0.0, 0.0))")]
    fn mirror(&self, normal: [f64; 3], point: [f64; 3]) -> PyResult<Self> {
        let mirrored = self.0.mirror(point, normal);
        checked(mirrored, call!("mirror", normal, point))
    }

    /// The image under an affine map: three rows of four numbers, the last column the
    /// offset (a fourth row 0, 0, 0, 1 may be there).
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).affine([[1, 0, 0, 5], [0, 2, 0, 0], [0, 0, 1, 0]]).contains([5, 1.9, 0])
    /// True
    fn affine(&self, matrix: Vec<[f64; 4]>) -> PyResult<Self> {
        let call = call!("affine", matrix);
        let ([a, b, c] | [a, b, c, [0.0, 0.0, 0.0, 1.0]]) = *matrix.as_slice() else {
            let wanted = "give three rows of four numbers, or four of which the last is 0, 0, 0, 1";
            return Err(invalid(format!("{}: {wanted}", call())));
        };
        let column = |k: usize| DVec3::new(a[k], b[k], c[k]);
        let map = DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(1), column(2)),
            translation: column(3),
        };
        checked(self.0.affine(map), call)
    }
}
