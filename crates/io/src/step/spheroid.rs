//! Ellipsoids of revolution that nothing cuts: one face, as a whole sphere is.

use csg::SurfaceShape;
use csg::brep::{Face, Shell};
use glam::DVec3;

use super::surfaces::is_round;
use super::text::{Entities, Flag, Id, Quoted, Real};

/// A meridian turned around the axis.
struct Spheroid {
    origin: DVec3,
    /// Half axes: along the axis of revolution, and across it.
    axis: DVec3,
    across: DVec3,
}

/// Writes the one face of a shell that is a whole ellipsoid of revolution, of one origin: cut at one
/// meridian, which is on both sides of it. None of another shell.
pub(super) fn write(to: &mut Entities, shell: &Shell<'_>) -> Option<Id> {
    let mut faces = shell.faces();
    let face = faces.next()?;
    // Faces of a shell meet: where all are on one surface there are no edges but seams.
    let is_same = |other: Face<'_>| {
        other.surface_index() == face.surface_index()
            && other.is_along_gradient() == face.is_along_gradient()
            && other.origin() == face.origin()
    };
    if !faces.all(is_same) {
        return None;
    }
    let spheroid = Spheroid::of(face.surface().shape())?;
    let surface = spheroid.surface(to);
    let meridian = spheroid.meridian(to);
    let poles = [-1.0, 1.0].map(|sign| {
        let pole = to.point(spheroid.origin + sign * spheroid.axis);
        to.add(format_args!("VERTEX_POINT('',{pole})"))
    });
    let [south, north] = poles;
    let edge = to.add(format_args!(
        "EDGE_CURVE('',{south},{north},{meridian},.T.)"
    ));
    let [up, down] = [true, false].map(|is_up| {
        let along = Flag(is_up);
        to.add(format_args!("ORIENTED_EDGE('',*,*,{edge},{along})"))
    });
    let around = to.add(format_args!("EDGE_LOOP('',({up},{down}))"));
    let bound = to.add(format_args!("FACE_OUTER_BOUND('',{around},.T.)"));
    let points = face.points().into_iter();
    let outward = points.map(|p| (p - spheroid.origin).dot(face.normal(p)));
    let is_outward = Flag(outward.sum::<f64>() > 0.0);
    let name = Quoted(face.origin().name.as_deref().unwrap_or_default()).to_string();
    Some(to.add(format_args!(
        "ADVANCED_FACE({name},({bound}),{surface},{is_outward})"
    )))
}

impl Spheroid {
    fn of(shape: SurfaceShape) -> Option<Self> {
        let SurfaceShape::Ellipsoid { placement, radii } = shape else {
            return None;
        };
        let round = |k: usize| is_round([radii[(k + 1) % 3], radii[(k + 2) % 3]]);
        let k = (0..3).find(|&k| round(k))?;
        let [x, y] = [(k + 1) % 3, (k + 2) % 3];
        Some(Self {
            origin: placement.origin,
            axis: radii[k] * placement.axes[k],
            across: 0.5 * (radii[x] + radii[y]) * placement.axes[x],
        })
    }

    /// Half an ellipse from pole to pole.
    fn meridian(&self, to: &mut Entities) -> Id {
        // The long half axis comes first; angles grow from the lower pole to the upper one.
        let [first, second] = if self.axis.length() > self.across.length() {
            [self.axis, -self.across]
        } else {
            [self.across, self.axis]
        };
        let (long, short) = (first.length(), second.length());
        let directions = [first.cross(second), first].map(DVec3::normalize_or_zero);
        let placement = to.placement(self.origin, directions);
        let (long, short) = (Real(long), Real(short));
        to.share(format_args!("ELLIPSE('',{placement},{long},{short})"))
    }

    fn surface(&self, to: &mut Entities) -> Id {
        let ellipse = self.meridian(to);
        let [from, until] = [-1.0, 1.0].map(|sign| to.point(self.origin + sign * self.axis));
        let half = to.add(format_args!(
            "TRIMMED_CURVE('',{ellipse},({from}),({until}),.T.,.CARTESIAN.)"
        ));
        let direction = to.direction(self.axis.normalize_or_zero());
        let origin = to.point(self.origin);
        let axis = to.share(format_args!("AXIS1_PLACEMENT('',{origin},{direction})"));
        to.add(format_args!("SURFACE_OF_REVOLUTION('',{half},{axis})"))
    }
}
