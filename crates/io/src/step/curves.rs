//! The curves of edges.

use std::f64::consts::{PI, TAU};

use csg::brep::{CurveShape, Edge, HalfAxes};
use csg::elementary;
use glam::{DVec3, DVec4};

use super::surfaces::is_around_vertex;
use super::text::{Entities, Id, List, Real, Reals};
use crate::spline::{self, Spline};

/// How far B-splines may stray from curves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stray {
    pub usual: f64,
    /// From those that are not known as well: along which surfaces nearly touch.
    pub most: f64,
}

/// A curve as it is written, and the parameters of its ends.
#[derive(Debug)]
pub(super) struct Course {
    pub shape: CourseShape,
    pub range: [f64; 2],
}

/// A curve by the parameter that readers give it.
#[derive(Debug)]
pub(super) enum CourseShape {
    /// point + t direction.
    Line { point: DVec3, direction: DVec3 },
    /// By the angle from one of its half axes.
    Ellipse { center: DVec3, axes: HalfAxes },
    /// center + cosh t a + sinh t b, with half axes.
    Hyperbola { center: DVec3, a: DVec3, b: DVec3 },
    /// point + t a + t² b, where a is of unit length, at right angles to b.
    Parabola { point: DVec3, a: DVec3, b: DVec3 },
    /// From 0 to 1, by points times their weights, and weights.
    Rational([DVec4; 3]),
    /// From 0 to 1.
    Quintic(Spline),
}

/// The control points of a parabola with weights of 1, which other ones come to but for the parameter.
fn without_weights(control: [DVec4; 3]) -> [DVec4; 3] {
    /// As ellipses are round.
    const SAME: f64 = 1e-12;
    let [a, b, c] = control.map(|point| point.w);
    if (b * b - a * c).abs() > SAME * b * b {
        return control;
    }
    control.map(|point| point / point.w)
}

impl Course {
    /// The curve of an edge, which runs the way its parameter grows; none if no B-spline is
    /// found that strays as little.
    pub fn of(edge: &Edge<'_>, stray: Stray) -> Option<Self> {
        let curve = edge.curve();
        let [from, to] = edge.range();
        let whole = |shape| Self {
            shape,
            range: [0.0, 1.0],
        };
        Some(match curve {
            CurveShape::Line { point, direction } => Self {
                shape: CourseShape::Line { point, direction },
                range: [from, to],
            },
            CurveShape::Ellipse { center, .. } => {
                let mut axes = curve.half_axes()?;
                // Readers look for the first end between 0 and a whole turn: it is far from both
                // where the edge begins beyond a quarter of a turn.
                if axes.long.dot(edge.at(from) - center) > 0.0 {
                    axes.turn += PI;
                    (axes.long, axes.short) = (-axes.long, -axes.short);
                }
                let begin = (from - axes.turn).rem_euclid(TAU);
                Self {
                    shape: CourseShape::Ellipse { center, axes },
                    range: [begin, begin + (to - from)],
                }
            }
            CurveShape::Hyperbola { center, a, b } => {
                // cosh t a + sinh t b = cosh(t - turn) p + sinh(t - turn) q.
                let squares = a.length_squared() + b.length_squared();
                let turn = 0.5 * elementary::atanh(-2.0 * a.dot(b) / squares);
                let (sinh, cosh) = (elementary::sinh(turn), elementary::cosh(turn));
                Self {
                    shape: CourseShape::Hyperbola {
                        center,
                        a: cosh * a + sinh * b,
                        b: sinh * a + cosh * b,
                    },
                    range: [from - turn, to - turn],
                }
            }
            // The vertex is where t is 0.
            CurveShape::Conic { point, a, b, l, k }
                if l == 0.0
                    && k == 0.0
                    && is_around_vertex(
                        [from, to].map(|t| t * a.length()),
                        b.length() / a.length_squared(),
                    ) =>
            {
                let length = a.length();
                Self {
                    shape: CourseShape::Parabola {
                        point,
                        a: a / length,
                        b: b / (length * length),
                    },
                    range: [from * length, to * length],
                }
            }
            CurveShape::Conic { .. } => {
                let control = curve.control([from, to])?;
                whole(CourseShape::Rational(without_weights(control)))
            }
            _ => whole(CourseShape::Quintic(quartic(edge, stray)?)),
        })
    }

    /// The point at a parameter.
    pub fn at(&self, t: f64) -> DVec3 {
        match &self.shape {
            CourseShape::Line { point, direction } => point + t * direction,
            CourseShape::Ellipse { center, axes } => {
                let (sin, cos) = elementary::sin_cos(t);
                center + cos * axes.long + sin * axes.short
            }
            CourseShape::Hyperbola { center, a, b } => {
                center + elementary::cosh(t) * a + elementary::sinh(t) * b
            }
            CourseShape::Parabola { point, a, b } => point + t * a + t * t * b,
            CourseShape::Rational([from, middle, to]) => {
                let point = from.lerp(*middle, t).lerp(middle.lerp(*to, t), t);
                point.truncate() / point.w
            }
            CourseShape::Quintic(spline) => spline.at(t),
        }
    }

    /// Writes the curve.
    pub fn write(&self, to: &mut Entities) -> Id {
        match &self.shape {
            CourseShape::Line { point, direction } => {
                let point = to.point(*point);
                let direction = to.direction(*direction);
                let vector = to.share(format_args!("VECTOR('',{direction},1.)"));
                to.share(format_args!("LINE('',{point},{vector})"))
            }
            CourseShape::Ellipse { center, axes } => {
                let (long, short) = (axes.long.length(), axes.short.length());
                let placement = placed(to, *center, axes.long, axes.short);
                if axes.is_circle {
                    let radius = Real(0.5 * (long + short));
                    to.share(format_args!("CIRCLE('',{placement},{radius})"))
                } else {
                    let (long, short) = (Real(long), Real(short));
                    to.share(format_args!("ELLIPSE('',{placement},{long},{short})"))
                }
            }
            CourseShape::Hyperbola { center, a, b } => {
                let placement = placed(to, *center, *a, *b);
                let [a, b] = [a, b].map(|half| Real(half.length()));
                to.share(format_args!("HYPERBOLA('',{placement},{a},{b})"))
            }
            CourseShape::Parabola { point, a, b } => {
                let placement = placed(to, *point, *b, *a);
                let focus = Real(0.25 / b.length());
                to.share(format_args!("PARABOLA('',{placement},{focus})"))
            }
            CourseShape::Rational(control) => rational(to, control),
            CourseShape::Quintic(spline) => {
                let points = spline.points.iter().map(|&point| to.point(point));
                let points: Vec<Id> = points.collect();
                quintic(to, &points, &spline.knots)
            }
        }
    }
}

/// A curve of degree four from vertex to vertex.
fn quartic(edge: &Edge<'_>, stray: Stray) -> Option<Spline> {
    let ends = edge.vertices().map(|ends| ends.map(|end| end.point()));
    let range = edge.range();
    let at = |t: f64| match ends {
        Some([from, _]) if t == range[0] => from,
        Some([_, to]) if t == range[1] => to,
        _ => edge.at(t),
    };
    let mut tolerance = stray.usual;
    loop {
        let found = spline::fit(at, range, tolerance);
        if found.is_some() || tolerance >= stray.most {
            return found;
        }
        tolerance = (10.0 * tolerance).min(stray.most);
    }
}

/// Coordinates with x and y along half axes.
fn placed(to: &mut Entities, center: DVec3, x: DVec3, y: DVec3) -> Id {
    let x = x.normalize_or_zero();
    to.placement(center, [x.cross(y).normalize_or_zero(), x])
}

/// A rational curve of degree two, by points times their weights, and weights.
fn rational(to: &mut Entities, control: &[DVec4; 3]) -> Id {
    let points = control.map(|point| to.point(point.truncate() / point.w));
    let weights = control.map(|point| point.w / control[0].w);
    let (points, weights) = (List(&points), Reals(&weights));
    to.add(format_args!(
        "(BOUNDED_CURVE()B_SPLINE_CURVE(2,{points},.UNSPECIFIED.,.F.,.F.)\
         B_SPLINE_CURVE_WITH_KNOTS((3,3),(0.,1.),.UNSPECIFIED.)CURVE()\
         GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({weights})\
         REPRESENTATION_ITEM(''))"
    ))
}

/// A curve of degree five by its points: knots inside are there three times.
pub(super) fn quintic(to: &mut Entities, points: &[Id], knots: &[f64]) -> Id {
    let mut multiplicities = vec![3; knots.len()];
    multiplicities[0] = 6;
    multiplicities[knots.len() - 1] = 6;
    let (points, multiplicities, knots) = (List(points), List(&multiplicities), Reals(knots));
    to.add(format_args!(
        "B_SPLINE_CURVE_WITH_KNOTS('',5,{points},.UNSPECIFIED.,.F.,.F.,\
         {multiplicities},{knots},.UNSPECIFIED.)"
    ))
}

#[cfg(test)]
mod tests {
    use csg::{BoundaryOptions, Program, Solid};

    use super::*;

    /// Between the points that they were made from, too.
    #[test]
    fn splines_of_quartics_are_on_both_surfaces() {
        let bore = Solid::cylinder(0.4, -3.0..3.0).rotate_x(1.3);
        let solids = [
            Solid::cylinder(1.0, -1.5..1.5) - bore.translate([0.1, 0.0, 0.2]),
            Solid::sphere(1.0) & Solid::cylinder(0.5, -2.0..2.0).translate([0.5, 0.0, 0.0]),
            Solid::cone(1.0, -1.0..1.0) - Solid::ellipsoid([0.3, 2.0, 0.4]),
            Solid::hyperboloid_one_sheet([0.4, 0.5, 0.6]) & Solid::sphere(1.2).translate([0.2; 3]),
        ];
        let tolerance = 1e-9;
        for (k, solid) in solids.iter().enumerate() {
            let program = Program::lower(solid).expect("valid");
            let options = BoundaryOptions::new().cut_at_seams();
            let brep = program.boundary(&options).expect("a boundary");
            let quartics = brep
                .edges()
                .filter(|e| matches!(e.curve(), CurveShape::Quartic));
            let mut count = 0;
            for edge in quartics {
                count += 1;
                let stray = Stray {
                    usual: tolerance,
                    most: tolerance,
                };
                let spline = quartic(&edge, stray).expect("a spline");
                let [from, to] = edge.range();
                for step in 0..=777 {
                    let u = f64::from(step) / 777.0;
                    let point = spline.at(u);
                    let off = point.distance(edge.at(from + u * (to - from)));
                    assert!(off < 1.5 * tolerance, "{k}: {off} at {u}");
                    for face in edge.faces() {
                        let surface = face.surface();
                        let slope = surface.gradient(point).length();
                        let off = surface.value(point).abs() / slope;
                        assert!(off < 1.5 * tolerance, "{k}: {off} off {surface}");
                    }
                }
            }
            assert!(count >= 2, "{k}: {count} quartics");
        }
    }
}
