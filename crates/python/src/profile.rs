//! The class `Profile`: what is drawn in a plane, to be extruded or revolved.

use csg::{Join, Profile, Solid, Twist};
use glam::{DAffine2, DMat2, DVec2};
use pyo3::prelude::*;

use crate::arguments::{Corners, Each, Extent, angle};
use crate::errors::{call, invalid, shown};
use crate::solid::{PySolid, checked};

/// A set of points in the xy plane: `|` (or `+`), `&` and `-` combine profiles. Functions
/// such as `circle`, `rectangle`, `polygon` and `text` make it, and `Path`; arcs stay arcs.
///
/// >>> import stereotomy as st
/// >>> plate = st.rounded_rectangle([60, 40], radius=5)
/// >>> for x in (-20, 20):
/// ...     plate = plate - st.circle(3).translate([x, 0])
/// >>> solid = plate.extrude(4)
/// >>> solid.contains([0, 0, 2]), solid.contains([20, 0, 2])
/// (True, False)
#[pyclass(frozen, from_py_object, name = "Profile", module = "stereotomy")]
#[derive(Clone)]
pub(crate) struct PyProfile(pub(crate) Profile);

/// The profile, unless something is wrong with it.
pub(crate) fn checked_profile(
    profile: Profile,
    call: impl FnOnce() -> String,
) -> PyResult<PyProfile> {
    match profile.fault() {
        None => Ok(PyProfile(profile)),
        Some(fault) => Err(invalid(format!("{}: {fault}", call()))),
    }
}

#[pymethods]
impl PyProfile {
    fn __or__(&self, other: &Self) -> Self {
        Self(&self.0 | &other.0)
    }

    fn __add__(&self, other: &Self) -> Self {
        Self(&self.0 | &other.0)
    }

    fn __and__(&self, other: &Self) -> Self {
        Self(&self.0 & &other.0)
    }

    fn __sub__(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0)
    }

    fn __repr__(&self) -> String {
        match self.0.bounds(1e-3) {
            Ok(Some((low, high))) => format!(
                "<Profile from ({:.6}, {:.6}) to ({:.6}, {:.6})>",
                low.x, low.y, high.x, high.y
            ),
            Ok(None) => "<Profile without points>".to_owned(),
            Err(fault) => format!("<Profile: {fault}>"),
        }
    }

    /// Moves by `offset`.
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([2, 2]).translate([1, 1]).bounds()
    /// ((0.0, 0.0), (2.0, 2.0))
    fn translate(&self, offset: [f64; 2]) -> PyResult<Self> {
        checked_profile(self.0.translate(offset), call!("translate", offset))
    }

    /// Turns about the origin, counter-clockwise, by degrees (or radians).
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([4, 2]).rotate(90).area()
    /// 8.0
    #[pyo3(signature = (angle, *, radians=false))]
    fn rotate(&self, angle: f64, radians: bool) -> PyResult<Self> {
        let turned = self.0.rotate(crate::arguments::angle(angle, radians));
        checked_profile(turned, call!("rotate", angle))
    }

    /// Scales about the origin: by one factor, or by two along x and y, negative ones
    /// mirror.
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([1, 1]).scale([2, 3]).area()
    /// 6.0
    fn scale(&self, factor: Each<2>) -> PyResult<Self> {
        let scaled = self.0.scale_xy(factor.array());
        checked_profile(scaled, call!("scale", factor))
    }

    /// Mirrors in the line through the origin across `normal`.
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle_between([1, 0], [2, 1]).mirror([1, 0]).bounds()
    /// ((-2.0, 0.0), (-1.0, 1.0))
    fn mirror(&self, normal: [f64; 2]) -> PyResult<Self> {
        checked_profile(self.0.mirror(normal), call!("mirror", normal))
    }

    /// The image under an affine map: two rows of three numbers, the last column the
    /// offset (a third row 0, 0, 1 may be there).
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([1, 1]).affine([[2, 1, 0], [0, 1, 0]]).area()
    /// 2.0
    fn affine(&self, matrix: Vec<[f64; 3]>) -> PyResult<Self> {
        let call = call!("affine", matrix);
        let ([a, b] | [a, b, [0.0, 0.0, 1.0]]) = *matrix.as_slice() else {
            let wanted = "give two rows of three numbers, or three of which the last is 0, 0, 1";
            return Err(invalid(format!("{}: {wanted}", call())));
        };
        let columns = DMat2::from_cols(DVec2::new(a[0], b[0]), DVec2::new(a[1], b[1]));
        let map = DAffine2::from_mat2_translation(columns, DVec2::new(a[2], b[2]));
        checked_profile(self.0.affine(map), call)
    }

    /// The profile grown by a distance to all sides, or shrunk by a negative one. `join`
    /// says how sides are joined around corners: "round", "bevel", "square", "mitre" (up
    /// to `limit` distances from the corner) or "chords" (so many as `chords` to a turn).
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([2, 2]).offset(1, join="mitre").area()
    /// 16.0
    #[pyo3(signature = (distance, join="round", *, limit=2.0, chords=32))]
    fn offset(&self, distance: f64, join: &str, limit: f64, chords: usize) -> PyResult<Self> {
        let known = [
            ("round", Join::Round),
            ("bevel", Join::Bevel),
            ("square", Join::Square),
            ("mitre", Join::Mitre(limit)),
            ("chords", Join::Chords(chords)),
        ];
        let how = crate::arguments::word("join", join, &known)?;
        if !(limit >= 1.0 && limit.is_finite()) {
            return Err(invalid(format!(
                "limit is {limit}: give a finite number of distances, at least 1"
            )));
        }
        checked_profile(
            self.0.offset(distance, how),
            call!("offset", distance, join),
        )
    }

    /// The least convex set around the profile: exact if it is a union of circles and polygons,
    /// else with arcs as chords within 1e-4 of its size.
    ///
    /// >>> import stereotomy as st
    /// >>> (st.rectangle([2, 1]) - st.rectangle([1, 5])).hull().area()
    /// 2.0
    fn hull(&self) -> PyResult<Self> {
        checked_profile(self.0.hull(), call!("hull"))
    }

    /// The same profile with chords in place of arcs, straying at most `tolerance` from
    /// them, and its Boolean operations carried out.
    ///
    /// >>> import stereotomy as st
    /// >>> len(st.circle(1).flattened(0.1).contours()[0])
    /// 7
    fn flattened(&self, tolerance: f64) -> PyResult<Self> {
        checked_profile(self.0.flattened(tolerance), call!("flattened", tolerance))
    }

    /// The profile as closed polygons, arrays of shape (n, 2): outer contours
    /// counter-clockwise, holes clockwise, arcs cut into chords that stray at most
    /// `tolerance`.
    ///
    /// >>> import stereotomy as st
    /// >>> [len(contour) for contour in (st.rectangle([2, 2]) - st.rectangle([1, 1])).contours()]
    /// [4, 4]
    #[pyo3(signature = (tolerance=1e-3))]
    fn contours<'py>(
        &self,
        py: Python<'py>,
        tolerance: f64,
    ) -> PyResult<Vec<Bound<'py, numpy::PyArray2<f64>>>> {
        use numpy::PyArrayMethods;
        let contours = self
            .0
            .contours(tolerance)
            .map_err(|fault| invalid(format!("{}: {fault}", call!("contours", tolerance)())))?;
        let arrays = contours.into_iter().map(|contour| {
            let shape = [contour.len(), 2];
            let flat: Vec<f64> = contour.iter().flat_map(DVec2::to_array).collect();
            numpy::PyArray1::from_vec(py, flat).reshape(shape)
        });
        arrays.collect()
    }

    /// (Least, greatest) coordinates, arcs within `tolerance`; None if there are no points.
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([2, 4]).bounds()
    /// ((-1.0, -2.0), (1.0, 2.0))
    #[pyo3(signature = (tolerance=1e-3))]
    fn bounds(&self, tolerance: f64) -> PyResult<Corners<(f64, f64)>> {
        let bounds = self.0.bounds(tolerance);
        let bounds = bounds
            .map_err(|fault| invalid(format!("{}: {fault}", call!("bounds", tolerance)())))?;
        Ok(bounds.map(|(low, high)| (low.into(), high.into())))
    }

    /// The area, arcs within `tolerance`.
    ///
    /// >>> import math, stereotomy as st
    /// >>> abs(st.circle(1).area(1e-9) - math.pi) < 1e-8
    /// True
    #[pyo3(signature = (tolerance=1e-3))]
    fn area(&self, tolerance: f64) -> PyResult<f64> {
        let area = self.0.area(tolerance);
        area.map_err(|fault| invalid(format!("{}: {fault}", call!("area", tolerance)())))
    }

    /// The profile moved along z; `z` is the height, from 0, or (low, high). On the way it
    /// may be scaled (by 1 at the lower end to `scale` at the upper), drawn together to the
    /// point above `apex`, or turned by `twist` degrees (or radians) in `steps` flat layers.
    ///
    /// >>> import stereotomy as st
    /// >>> square = st.rectangle([2, 2])
    /// >>> round(square.extrude(3).measure().volume, 9)
    /// 12.0
    /// >>> round(square.extrude(3, apex=[0, 0]).measure().volume, 9)
    /// 4.0
    /// >>> square.extrude(3, twist=90, steps=8).contains([0.9, 0.9, 1.5])
    /// False
    #[pyo3(signature = (z, *, scale=None, apex=None, twist=None, steps=None, radians=false))]
    #[allow(clippy::too_many_arguments, reason = "Python's keywords")]
    fn extrude(
        &self,
        z: Extent,
        scale: Option<Each<2>>,
        apex: Option<[f64; 2]>,
        twist: Option<f64>,
        steps: Option<usize>,
        radians: bool,
    ) -> PyResult<PySolid> {
        let call = || {
            let given = [
                Some(shown("z", &z)),
                scale.map(|scale| shown("scale", &scale)),
                apex.map(|apex| shown("apex", &apex)),
                twist.map(|twist| shown("twist", &twist)),
                steps.map(|steps| shown("steps", &steps)),
            ];
            let given: Vec<String> = given.into_iter().flatten().collect();
            format!("extrude({})", given.join(", "))
        };
        let extent = z.0.clone();
        let solid = match (scale, apex, twist.is_some() || steps.is_some()) {
            (None, None, false) => Solid::extrude(&self.0, extent),
            (Some(scale), None, false) => Solid::extrude_scaled(&self.0, extent, scale.array()),
            (None, Some(apex), false) => Solid::extrude_to_point(&self.0, extent, apex),
            (scale, None, true) => {
                let radians = angle(twist.unwrap_or(0.0), radians);
                let scale = scale.map_or(DVec2::ONE, |scale| scale.array().into());
                match steps {
                    None => Solid::extrude_twisted(&self.0, extent, radians, scale),
                    Some(steps) => {
                        let twist = Twist {
                            radians,
                            scale,
                            steps,
                        };
                        Solid::extrude_in_steps(&self.0, extent, twist)
                    }
                }
            }
            (_, Some(_), _) => {
                let problem = "an apex goes with neither scale nor twist";
                return Err(invalid(format!("{}: {problem}", call())));
            }
        };
        checked(solid, call)
    }

    /// The profile turned about its y axis, which becomes the z axis, by `angle` degrees (or
    /// radians) from the xz plane; its x is the distance from the axis and must not be
    /// negative. With `steps` in so many flat steps, else round.
    ///
    /// >>> import math, stereotomy as st
    /// >>> ring = st.rectangle_between([1, 0], [2, 1]).revolve()
    /// >>> abs(ring.measure(tolerance=1e-5).volume - 3 * math.pi) < 1e-3
    /// True
    /// >>> round(st.rectangle_between([0, 0], [1, 1]).revolve(steps=4).measure().volume, 9)
    /// 2.0
    #[pyo3(signature = (angle=None, *, steps=None, radians=false))]
    fn revolve(
        &self,
        angle: Option<f64>,
        steps: Option<usize>,
        radians: bool,
    ) -> PyResult<PySolid> {
        let turn = angle.map(|angle| crate::arguments::angle(angle, radians));
        let solid = match (turn, steps) {
            (None, None) => Solid::revolve(&self.0),
            (Some(turn), None) => Solid::revolve_by(&self.0, turn),
            (turn, Some(steps)) => {
                let turn = turn.unwrap_or(std::f64::consts::TAU);
                Solid::revolve_in_steps(&self.0, turn, steps)
            }
        };
        checked(solid, || {
            let given = [
                angle.map(|angle| shown("angle", &angle)),
                steps.map(|steps| shown("steps", &steps)),
            ];
            let given: Vec<String> = given.into_iter().flatten().collect();
            format!("revolve({})", given.join(", "))
        })
    }
}
