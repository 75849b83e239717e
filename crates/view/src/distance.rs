//! Distances and angles between two things that were picked: from their surfaces and curves,
//! which go on beyond the faces and edges themselves.

use csg::SurfaceShape;
use csg::brep::CurveShape;
use csg::elementary;
use glam::DVec3;

use crate::dimension::Dimension;
use crate::pick::{Picked, Row, circle};

/// What is measured of a pick.
#[derive(Clone, Copy, Debug)]
enum Element {
    /// A point, and what it is of the pick.
    Point(DVec3, &'static str),
    /// A line: its point beside the middle of the pick, and its direction, of unit length.
    Line([DVec3; 2], &'static str),
    /// A plane: its point beside the middle of the pick, and its normal, of unit length.
    Plane([DVec3; 2]),
}

impl Element {
    /// The same, if that is where the middle of the pick is.
    fn beside(self, middle: DVec3) -> Self {
        match self {
            Self::Point(..) => self,
            Self::Line(line, what) => Self::Line([foot_on_line(middle, line), line[1]], what),
            Self::Plane(plane) => Self::Plane([foot_on_plane(middle, plane), plane[1]]),
        }
    }
}

/// What lies at a smaller angle (its sine) is parallel: directions are known to some 1e-15.
const PARALLEL: f64 = 1e-12;

/// What can be measured between two picks, in this unit.
pub(crate) fn between(one: &Picked<'_>, other: &Picked<'_>, unit: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let [firsts, seconds] = [one, other].map(|picked| {
        let middle = middle(picked);
        elements(picked).into_iter().map(move |e| e.beside(middle))
    });
    for first in firsts {
        for second in seconds.clone() {
            measure(first, second, unit, &mut rows);
        }
    }
    if let (Some((gap, ends)), Some(shapes)) = (gap(one, other), shapes(one, other)) {
        let row = Row::number(&format!("gap between {shapes}"), gap, unit);
        rows.push(row.drawn(Dimension::Distance { ends }));
    }
    rows
}

/// Beside which point of a pick's line or plane its dimensions are drawn.
fn middle(picked: &Picked<'_>) -> DVec3 {
    match picked {
        Picked::Vertex(vertex) => vertex.point(),
        Picked::Edge(edge) => {
            let [from, to] = edge.range();
            edge.at(0.5 * (from + to))
        }
        Picked::Face(face) => match face.bounds() {
            Some(bounds) => bounds.min.midpoint(bounds.max),
            None => DVec3::ZERO,
        },
    }
}

/// What a pick is measured by: a circle by its centre and its axis.
fn elements(picked: &Picked<'_>) -> Vec<Element> {
    match picked {
        Picked::Vertex(vertex) => vec![Element::Point(vertex.point(), "vertex")],
        Picked::Edge(edge) => match edge.curve() {
            CurveShape::Line { point, direction } => {
                vec![Element::Line([point, direction], "line")]
            }
            curve @ CurveShape::Ellipse { center, .. } => {
                let axis = circle(&curve).map(|(_, axis, _)| Element::Line([center, axis], "axis"));
                [Some(Element::Point(center, "centre")), axis]
                    .into_iter()
                    .flatten()
                    .collect()
            }
            CurveShape::Hyperbola { center, .. } => vec![Element::Point(center, "centre")],
            _ => Vec::new(),
        },
        Picked::Face(face) => match face.surface().shape() {
            SurfaceShape::Plane { point, normal } => vec![Element::Plane([point, normal])],
            SurfaceShape::Sphere { center, .. } => vec![Element::Point(center, "centre")],
            SurfaceShape::Cylinder { point, axis, .. } => {
                vec![Element::Line([point, axis], "axis")]
            }
            SurfaceShape::Cone {
                point,
                axis,
                radius,
                ..
            } => {
                let apex = (radius == 0.0).then_some(Element::Point(point, "apex"));
                [Some(Element::Line([point, axis], "axis")), apex]
                    .into_iter()
                    .flatten()
                    .collect()
            }
            SurfaceShape::Ellipsoid { placement, .. }
            | SurfaceShape::HyperboloidOneSheet { placement, .. }
            | SurfaceShape::HyperboloidTwoSheets { placement, .. } => {
                vec![Element::Point(placement.origin, "centre")]
            }
            SurfaceShape::EllipticCylinder { placement, .. }
            | SurfaceShape::HyperbolicCylinder { placement, .. } => {
                vec![Element::Line([placement.origin, placement.axes[2]], "axis")]
            }
            SurfaceShape::EllipticCone { placement, .. } => vec![
                Element::Line([placement.origin, placement.axes[2]], "axis"),
                Element::Point(placement.origin, "apex"),
            ],
            SurfaceShape::EllipticParaboloid { placement, .. }
            | SurfaceShape::HyperbolicParaboloid { placement, .. } => {
                vec![Element::Point(placement.origin, "vertex")]
            }
            _ => Vec::new(),
        },
    }
}

fn measure(first: Element, second: Element, unit: &str, rows: &mut Vec<Row>) {
    use Element::{Line, Plane, Point};
    let distance = |what: String, value: f64, [from, to]: [DVec3; 2]| {
        Row::number(&format!("distance, {what}"), value, unit).drawn(Dimension::distance(from, to))
    };
    match (first, second) {
        (Point(p, a), Point(q, b)) => {
            rows.push(distance(format!("{a} to {b}"), p.distance(q), [p, q]));
            rows.push(Row::point("along x, y, z", q - p));
        }
        (Point(p, a), Line(line, b)) | (Line(line, b), Point(p, a)) => {
            let ends = [p, foot_on_line(p, line)];
            rows.push(distance(format!("{a} to {b}"), off_line(p, line), ends));
        }
        (Point(p, a), Plane(plane)) | (Plane(plane), Point(p, a)) => {
            let ends = [p, foot_on_plane(p, plane)];
            rows.push(distance(format!("{a} to plane"), off_plane(p, plane), ends));
        }
        (Line([p, d], a), Line([q, e], b)) => {
            let feet = nearest([p, d], [q, e]);
            let across = d.cross(e);
            let sine = across.length();
            let is_parallel = sine <= PARALLEL;
            // (Of directions that lie at no more than a right angle.)
            let sides = [d, if d.dot(e) < 0.0 { -e } else { e }];
            let drawn = (!is_parallel).then_some(Dimension::Angle {
                at: feet[0],
                along: sides,
            });
            let row = angle(&format!("{a} to {b}"), between_lines(d, e));
            rows.push(row.drawn(drawn));
            let value = if is_parallel {
                off_line(q, [p, d])
            } else {
                (q - p).dot(across / sine).abs()
            };
            rows.push(distance(format!("{a} to {b}"), value, feet));
        }
        (Line([p, d], a), Plane([q, n])) | (Plane([q, n]), Line([p, d], a)) => {
            let sine = d.dot(n).abs();
            let shadow = d - d.dot(n) * n;
            // (Upright on the plane, the line has none.)
            let shadow = match shadow.length() <= PARALLEL {
                true => n.any_orthonormal_vector(),
                false => shadow.normalize(),
            };
            let drawn = (sine > PARALLEL).then(|| Dimension::Angle {
                at: p + (q - p).dot(n) / d.dot(n) * d,
                along: [d, shadow],
            });
            let radians = elementary::atan2(sine, d.cross(n).length());
            rows.push(angle(&format!("{a} to plane"), radians).drawn(drawn));
            if sine <= PARALLEL {
                let ends = [p, foot_on_plane(p, [q, n])];
                rows.push(distance(
                    format!("{a} to plane"),
                    off_plane(p, [q, n]),
                    ends,
                ));
            }
        }
        (Plane([p, n]), Plane([q, m])) => {
            let along = n.cross(m);
            let is_parallel = along.length() <= PARALLEL;
            let drawn = (!is_parallel).then(|| between_planes([p, n], [q, m]));
            rows.push(angle("between the planes", between_lines(n, m)).drawn(drawn));
            if is_parallel {
                let value = off_plane(q, [p, n]);
                let from = p.midpoint(foot_on_plane(q, [p, n]));
                let ends = [from, foot_on_plane(from, [q, m])];
                rows.push(distance("between the planes".to_owned(), value, ends));
            }
        }
    }
}

fn angle(what: &str, radians: f64) -> Row {
    Row::number(&format!("angle, {what}"), radians.to_degrees(), "°")
}

/// From 0 to a right angle.
fn between_lines(d: DVec3, e: DVec3) -> f64 {
    elementary::atan2(d.cross(e).length(), d.dot(e).abs())
}

/// The angle of planes that are not parallel, of sides that point to where they were picked as far
/// as one of no more than a right angle does.
fn between_planes([p, n]: [DVec3; 2], [q, m]: [DVec3; 2]) -> Dimension {
    let along = n.cross(m).normalize_or_zero();
    let [one, other] = [n, m].map(|normal| along.cross(normal).normalize_or_zero());
    // From a point of the first plane within it to the second one.
    let from = p.midpoint(foot_on_plane(q, [p, n]));
    let at = from + (q - from).dot(m) / one.dot(m) * one;
    let towards = |side: DVec3, picked: DVec3| match (picked - at).dot(side) < 0.0 {
        true => -side,
        false => side,
    };
    let one = towards(one, p);
    let other = match one.dot(other) {
        cosine if cosine.abs() <= PARALLEL => towards(other, q),
        cosine if cosine < 0.0 => -other,
        _ => other,
    };
    Dimension::Angle {
        at,
        along: [one, other],
    }
}

/// The points of two lines that are nearest to each other: of parallel ones beside the middle
/// between their points.
fn nearest([p, d]: [DVec3; 2], [q, e]: [DVec3; 2]) -> [DVec3; 2] {
    let across = d.cross(e);
    let square = across.length_squared();
    if square <= PARALLEL * PARALLEL {
        let from = p.midpoint(foot_on_line(q, [p, d]));
        return [from, foot_on_line(from, [q, e])];
    }
    let between = q - p;
    [
        p + between.cross(e).dot(across) / square * d,
        q + between.cross(d).dot(across) / square * e,
    ]
}

fn foot_on_line(point: DVec3, [on, direction]: [DVec3; 2]) -> DVec3 {
    on + (point - on).dot(direction) * direction
}

fn foot_on_plane(point: DVec3, [on, normal]: [DVec3; 2]) -> DVec3 {
    point - (point - on).dot(normal) * normal
}

fn off_line(point: DVec3, [on, direction]: [DVec3; 2]) -> f64 {
    (point - on).cross(direction).length()
}

fn off_plane(point: DVec3, [on, normal]: [DVec3; 2]) -> f64 {
    (point - on).dot(normal).abs()
}

/// A sphere or a cylinder by its middle (a cylinder's with the direction) and its radius, and
/// a plane as one of radius 0.
#[derive(Clone, Copy)]
enum Body {
    Sphere(DVec3, f64),
    Cylinder([DVec3; 2], f64),
    Plane([DVec3; 2]),
}

fn body(picked: &Picked<'_>) -> Option<Body> {
    let Picked::Face(face) = picked else {
        return None;
    };
    match face.surface().shape() {
        SurfaceShape::Sphere { center, radius } => Some(Body::Sphere(center, radius)),
        SurfaceShape::Cylinder {
            point,
            axis,
            radius,
        } => {
            let point = foot_on_line(middle(picked), [point, axis]);
            Some(Body::Cylinder([point, axis], radius))
        }
        SurfaceShape::Plane { point, normal } => Some(Body::Plane([point, normal])),
        _ => None,
    }
}

/// The least distance of two surfaces of constant distance that lie beside each other, and from
/// where to where it is: none where they cross, or where one is in the other.
fn gap(one: &Picked<'_>, other: &Picked<'_>) -> Option<(f64, [DVec3; 2])> {
    let (feet, radii) = match (body(one)?, body(other)?) {
        (Body::Sphere(p, r), Body::Sphere(q, s)) => ([p, q], [r, s]),
        (Body::Sphere(p, r), Body::Cylinder(line, s))
        | (Body::Cylinder(line, s), Body::Sphere(p, r)) => ([p, foot_on_line(p, line)], [r, s]),
        (Body::Sphere(p, r), Body::Plane(plane)) | (Body::Plane(plane), Body::Sphere(p, r)) => {
            ([p, foot_on_plane(p, plane)], [r, 0.0])
        }
        (Body::Cylinder([p, d], r), Body::Cylinder([q, e], s))
            if d.cross(e).length() <= PARALLEL =>
        {
            (nearest([p, d], [q, e]), [r, s])
        }
        (Body::Cylinder([p, d], r), Body::Plane([q, n]))
        | (Body::Plane([q, n]), Body::Cylinder([p, d], r))
            if d.dot(n).abs() <= PARALLEL =>
        {
            ([p, foot_on_plane(p, [q, n])], [r, 0.0])
        }
        _ => return None,
    };
    let [p, q] = feet;
    let along = (q - p).normalize_or_zero();
    let gap = p.distance(q) - radii[0] - radii[1];
    (gap > 0.0).then_some((gap, [p + radii[0] * along, q - radii[1] * along]))
}

fn shapes(one: &Picked<'_>, other: &Picked<'_>) -> Option<String> {
    let name = |body: Body| match body {
        Body::Sphere(..) => "sphere",
        Body::Cylinder(..) => "cylinder",
        Body::Plane(..) => "plane",
    };
    Some(format!("{} and {}", name(body(one)?), name(body(other)?)))
}

#[cfg(test)]
mod tests {
    use csg::{BoundaryOptions, Brep, Program, Solid};
    use glam::dvec3;

    use super::*;

    fn boundary(solid: &Solid) -> Brep {
        let program = Program::lower(solid).expect("valid");
        program.boundary(&BoundaryOptions::new()).expect("decided")
    }

    fn value(rows: &[Row], label: &str) -> f64 {
        let row = rows.iter().find(|row| row.label == label);
        row.and_then(|row| row.value)
            .unwrap_or_else(|| panic!("no {label} in {rows:?}"))
    }

    /// What is drawn measures what is said.
    #[test]
    fn dimensions_are_as_long_and_as_wide_as_they_say() {
        let bore = |x: f64, r: f64| Solid::cylinder(r, -3.0..3.0).translate([x, 0.0, 0.0]);
        let wedge = Solid::cuboid([6.0, 2.0, 2.0]) & Solid::half_space([1.0, 0.3, 1.0], 1.5);
        let skew = Solid::cylinder(0.2, -3.0..3.0).rotate_x(1.1);
        let ball = Solid::sphere(0.5).translate([0.0, 0.0, 4.0]);
        let solid = (wedge - bore(-1.5, 0.25) - skew.translate([-0.5, 0.0, 0.0])) | ball;
        let brep = boundary(
            &solid
                .rotate_x(0.3)
                .rotate_z(1.1)
                .translate([5.0, -7.0, 11.0]),
        );
        let faces = brep.faces().map(Picked::Face);
        let edges = brep.edges().map(Picked::Edge);
        let all: Vec<_> = faces
            .chain(edges)
            .chain(brep.vertices().map(Picked::Vertex))
            .collect();
        let (mut distances, mut angles) = (0, 0);
        for row in all
            .iter()
            .flat_map(|one| all.iter().flat_map(move |other| between(one, other, "mm")))
        {
            let (Some(dimension), Some(value)) = (&row.dimension, row.value) else {
                continue;
            };
            let drawn = match dimension {
                Dimension::Distance { ends: [from, to] } => {
                    distances += 1;
                    from.distance(*to)
                }
                Dimension::Angle {
                    along: [one, other],
                    ..
                } => {
                    angles += 1;
                    assert!(
                        (one.length() - 1.0).abs() < 1e-12 && (other.length() - 1.0).abs() < 1e-12
                    );
                    between_lines(*one, *other).to_degrees()
                }
                other => panic!("{other:?} between two picks"),
            };
            assert!((drawn - value).abs() < 1e-9, "{row:?} is drawn as {drawn}");
        }
        assert!(distances > 500 && angles > 100, "{distances}, {angles}");
    }

    /// Both sides of an angle between planes are in their planes, and its vertex is on both.
    #[test]
    fn angles_between_planes_are_where_they_meet() {
        let block = Solid::cuboid([6.0, 2.0, 2.0]) & Solid::half_space([1.0, 0.3, 1.0], 1.5);
        let brep = boundary(&block.rotate_x(0.3).translate([5.0, -7.0, 11.0]));
        let planes: Vec<_> = brep.faces().collect();
        let mut tried = 0;
        for (one, other) in planes
            .iter()
            .flat_map(|a| planes.iter().map(move |b| (a, b)))
        {
            let rows = between(&Picked::Face(*one), &Picked::Face(*other), "mm");
            let Some(Dimension::Angle { at, along }) = &rows[0].dimension else {
                continue;
            };
            tried += 1;
            for (face, side) in [one, other].into_iter().zip(along) {
                let SurfaceShape::Plane { point, normal } = face.surface().shape() else {
                    panic!("a plane");
                };
                assert!(off_plane(*at, [point, normal]) < 1e-12);
                assert!(side.dot(normal).abs() < 1e-12);
            }
        }
        assert!(tried > 20, "{tried}");
    }

    fn curved(brep: &Brep) -> Vec<Picked<'_>> {
        let curved = brep.faces().filter(|face| !face.surface().is_plane());
        curved.map(Picked::Face).collect()
    }

    #[test]
    fn bores_of_a_turned_block_are_as_far_apart_as_they_were_drilled() {
        let bore = |x: f64, r: f64| Solid::cylinder(r, -3.0..3.0).translate([x, 0.0, 0.0]);
        let block = Solid::cuboid([6.0, 2.0, 2.0]) - bore(-1.5, 0.25) - bore(1.75, 0.5);
        let turned = block
            .rotate_x(0.3)
            .rotate_z(1.1)
            .translate([5.0, -7.0, 11.0]);
        let brep = boundary(&turned);
        let bores = curved(&brep);
        let rows = between(&bores[0], &bores[1], "mm");
        assert!((value(&rows, "distance, axis to axis") - 3.25).abs() < 1e-13);
        assert!(value(&rows, "angle, axis to axis").abs() < 1e-12);
        assert!((value(&rows, "gap between cylinder and cylinder") - 2.5).abs() < 1e-13);
        // Circles, planes and vertices.
        let circles: Vec<Picked<'_>> = brep
            .edges()
            .filter(|edge| circle(&edge.curve()).is_some())
            .map(Picked::Edge)
            .collect();
        let radius = |picked: &Picked<'_>| match picked {
            Picked::Edge(edge) => circle(&edge.curve()).expect("a circle").2,
            _ => unreachable!("edges"),
        };
        let ends: Vec<_> = circles.iter().filter(|c| radius(c) < 0.3).collect();
        let rows = between(ends[0], ends[1], "mm");
        assert!((value(&rows, "distance, centre to centre") - 2.0).abs() < 1e-13);
        let planes: Vec<Picked<'_>> = brep
            .faces()
            .filter(|face| face.surface().is_plane())
            .map(Picked::Face)
            .collect();
        let mut parallel: Vec<f64> = Vec::new();
        for (k, one) in planes.iter().enumerate() {
            for other in &planes[k + 1..] {
                let rows = between(one, other, "mm");
                let angle = value(&rows, "angle, between the planes");
                if angle > 1.0 {
                    assert!((angle - 90.0).abs() < 1e-12);
                    assert_eq!(rows.len(), 1);
                } else {
                    parallel.push(value(&rows, "distance, between the planes"));
                }
            }
        }
        parallel.sort_by(f64::total_cmp);
        for (found, exact) in parallel.iter().zip([2.0, 2.0, 6.0]) {
            assert!((found - exact).abs() < 1e-13, "{found}");
        }
    }

    #[test]
    fn skew_axes_and_balls() {
        let across = Solid::cylinder(0.25, -2.0..2.0).rotate_x(std::f64::consts::FRAC_PI_3);
        let rods = Solid::cylinder(0.5, -2.0..2.0) | across.translate([3.0, 0.0, 0.0]);
        let brep = boundary(&(rods | Solid::sphere(0.5).translate([0.0, 0.0, 6.0])));
        let rods: Vec<_> = curved(&brep);
        let pair = |test: &dyn Fn(&[Row]) -> bool| {
            let all = rods
                .iter()
                .flat_map(|a| rods.iter().map(move |b| between(a, b, "mm")));
            all.into_iter()
                .find(|rows| test(rows))
                .expect("such a pair")
        };
        let skew = pair(&|rows| {
            rows.iter()
                .any(|row| row.label == "angle, axis to axis" && row.value > Some(1.0))
        });
        assert!((value(&skew, "angle, axis to axis") - 60.0).abs() < 1e-12);
        assert!((value(&skew, "distance, axis to axis") - 3.0).abs() < 1e-14);
        let ball = pair(&|rows| {
            rows.iter()
                .any(|row| row.label == "distance, centre to axis")
        });
        assert!(value(&ball, "distance, centre to axis") < 3.1);
    }

    #[test]
    fn vertices() {
        let brep = boundary(&Solid::cuboid_between([0.0; 3], [1.0, 2.0, 2.0]));
        let at = |point: DVec3| {
            let found = brep.vertices().find(|v| v.point().distance(point) < 1e-12);
            Picked::Vertex(found.expect("a corner"))
        };
        let rows = between(&at(DVec3::ZERO), &at(dvec3(1.0, 2.0, 2.0)), "mm");
        assert!((value(&rows, "distance, vertex to vertex") - 3.0).abs() < 1e-15);
        assert_eq!(rows[1].text, "1, 2, 2");
    }
}
