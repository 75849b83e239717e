//! What was picked, and what there is to say of it: from the exact boundary.

use csg::brep::{Bounded, CurveShape, Edge, Face, Vertex};
use csg::elementary;
use csg::{Brep, SurfaceShape};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::dimension::Dimension;

/// A part of the boundary, by its kind and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Pick {
    /// What it is.
    pub kind: PickKind,
    /// Its number in the boundary, from 0.
    pub id: usize,
}

/// What can be picked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PickKind {
    /// A face.
    Face,
    /// An edge.
    Edge,
    /// A vertex.
    Vertex,
}

/// One line of a table: a label, and what is to be read beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub label: String,
    /// Its value for people, with its unit and the bound on its error, if one is known.
    pub text: String,
    /// The number, if it is one, in the model's unit or degrees.
    pub value: Option<f64>,
    /// Where it is drawn in the picture, if it can be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimension: Option<Dimension>,
}

impl Row {
    pub(crate) fn text(label: &str, text: impl Into<String>) -> Self {
        Self {
            label: label.to_owned(),
            text: text.into(),
            value: None,
            dimension: None,
        }
    }

    /// A number that is known to rounding.
    pub(crate) fn number(label: &str, value: f64, unit: &str) -> Self {
        Self {
            value: Some(value),
            ..Self::text(label, with_unit(&number(value), unit))
        }
    }

    pub(crate) fn bounded(label: &str, bounded: Bounded, unit: &str) -> Self {
        Self {
            value: Some(bounded.value),
            ..Self::text(label, with_unit(&bounded.to_string(), unit))
        }
    }

    pub(crate) fn point(label: &str, point: DVec3) -> Self {
        Self::text(label, triple(point))
    }

    pub(crate) fn drawn(self, dimension: impl Into<Option<Dimension>>) -> Self {
        Self {
            dimension: dimension.into(),
            ..self
        }
    }
}

fn with_unit(text: &str, unit: &str) -> String {
    match unit {
        "" | "°" => format!("{text}{unit}"),
        _ => format!("{text} {unit}"),
    }
}

/// Twelve digits: what is left of a double after some dozens of operations.
pub(crate) fn number(value: f64) -> String {
    let digits = format!("{value:.11e}");
    let rounded: f64 = digits.parse().unwrap_or(value);
    // (Nothing has no sign.)
    (rounded + 0.0).to_string()
}

fn triple(point: DVec3) -> String {
    format!(
        "{}, {}, {}",
        number(point.x),
        number(point.y),
        number(point.z)
    )
}

/// One of the things that a [`Pick`] may name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Picked<'a> {
    Face(Face<'a>),
    Edge(Edge<'a>),
    Vertex(Vertex<'a>),
}

impl Pick {
    /// What it names, if there is such a thing.
    pub(crate) fn of(self, brep: &Brep) -> Option<Picked<'_>> {
        match self.kind {
            PickKind::Face => brep.faces().nth(self.id).map(Picked::Face),
            PickKind::Edge => brep.edges().nth(self.id).map(Picked::Edge),
            PickKind::Vertex => brep.vertices().nth(self.id).map(Picked::Vertex),
        }
    }
}

impl Picked<'_> {
    /// What there is to say of it, with the symbol of the model's unit.
    pub(crate) fn describe(&self, unit: &str) -> Vec<Row> {
        match self {
            Self::Face(face) => of_face(face, unit),
            Self::Edge(edge) => of_edge(edge, unit),
            Self::Vertex(vertex) => vec![Row::text("vertex", ""), Row::point("at", vertex.point())],
        }
    }
}

fn of_face(face: &Face<'_>, unit: &str) -> Vec<Row> {
    let origin = face.origin();
    let shape = face.surface().shape();
    let mut rows = vec![Row::text("face", kind(&shape))];
    if let Some(name) = &origin.name {
        rows.push(Row::text("part", &**name));
    }
    rows.push(Row::text("made by", origin.kind));
    rows.extend(of_shape(&shape, face, unit));
    rows.push(Row::bounded("area", face.area(), &format!("{unit}²")));
    rows
}

/// What a surface is called.
pub(crate) fn kind(shape: &SurfaceShape) -> &'static str {
    match shape {
        SurfaceShape::Plane { .. } => "plane",
        SurfaceShape::Sphere { .. } => "sphere",
        SurfaceShape::Cylinder { .. } => "cylinder",
        SurfaceShape::Cone { .. } => "cone",
        SurfaceShape::Ellipsoid { .. } => "ellipsoid",
        SurfaceShape::EllipticCylinder { .. } => "elliptic cylinder",
        SurfaceShape::EllipticCone { .. } => "elliptic cone",
        SurfaceShape::HyperboloidOneSheet { .. } => "hyperboloid of one sheet",
        SurfaceShape::HyperboloidTwoSheets { .. } => "hyperboloid of two sheets",
        SurfaceShape::EllipticParaboloid { .. } => "elliptic paraboloid",
        SurfaceShape::HyperbolicParaboloid { .. } => "hyperbolic paraboloid",
        SurfaceShape::HyperbolicCylinder { .. } => "hyperbolic cylinder",
        SurfaceShape::ParabolicCylinder { .. } => "parabolic cylinder",
        SurfaceShape::ParallelPlanes { .. } => "parallel planes",
        _ => "surface",
    }
}

/// The radius of a round surface.
pub(crate) fn radius(shape: &SurfaceShape) -> Option<f64> {
    match shape {
        SurfaceShape::Sphere { radius, .. } | SurfaceShape::Cylinder { radius, .. } => {
            Some(*radius)
        }
        _ => None,
    }
}

fn of_shape(shape: &SurfaceShape, face: &Face<'_>, unit: &str) -> Vec<Row> {
    let radii = |radii: &[f64]| {
        let names = ["radius a", "radius b", "radius c"];
        let rows = names.iter().zip(radii);
        rows.map(|(name, &radius)| Row::number(name, radius, unit))
            .collect()
    };
    match shape {
        SurfaceShape::Plane { point, .. } => vec![Row::point("normal", face.normal(*point))],
        SurfaceShape::Sphere { center, radius } => vec![
            Row::number("radius", *radius, unit).drawn(Dimension::Sphere { center: *center }),
            Row::point("centre", *center),
        ],
        SurfaceShape::Cylinder {
            point,
            axis,
            radius,
        } => vec![
            Row::number("radius", *radius, unit).drawn(Dimension::Circle {
                centers: ends_along(face, *point, *axis),
                axis: *axis,
            }),
            Row::point("axis through", *point),
            Row::point("axis along", *axis),
        ],
        SurfaceShape::Cone {
            point,
            axis,
            slope,
            radius,
        } => vec![
            Row::number("half angle", elementary::atan(*slope).to_degrees(), "°"),
            match radius {
                0.0 => Row::point("apex", *point),
                _ => Row::point("axis through", *point),
            },
            Row::point("axis along", *axis),
        ],
        SurfaceShape::Ellipsoid { radii: r, .. }
        | SurfaceShape::HyperboloidOneSheet { radii: r, .. }
        | SurfaceShape::HyperboloidTwoSheets { radii: r, .. } => radii(r),
        SurfaceShape::EllipticCylinder { radii: r, .. }
        | SurfaceShape::HyperbolicCylinder { radii: r, .. } => radii(r),
        _ => Vec::new(),
    }
}

/// The points of an axis between which a face lies.
fn ends_along(face: &Face<'_>, point: DVec3, axis: DVec3) -> [DVec3; 2] {
    let places = face.points();
    let along = places.iter().map(|&place| (place - point).dot(axis));
    let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| {
        [low.min(t), high.max(t)]
    });
    [low, high].map(|t| point + t * axis)
}

fn of_edge(edge: &Edge<'_>, unit: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut length = None;
    match edge.curve() {
        CurveShape::Line { direction, .. } => {
            let [from, to] = edge.range().map(|t| edge.at(t));
            length = Dimension::distance(from, to);
            rows.push(Row::text("edge", "line"));
            rows.push(Row::point("along", direction));
        }
        curve @ CurveShape::Ellipse { center, a, b } => {
            if let Some((_, axis, radius)) = circle(&curve) {
                let centers = [center; 2];
                rows.push(Row::text("edge", "circle"));
                rows.push(
                    Row::number("radius", radius, unit).drawn(Dimension::Circle { centers, axis }),
                );
                rows.push(Row::point("axis along", axis));
            } else {
                rows.push(Row::text("edge", "ellipse"));
                let [long, short] = semi_axes(a, b);
                rows.push(Row::number("radius a", long, unit));
                rows.push(Row::number("radius b", short, unit));
            }
            rows.push(Row::point("centre", center));
        }
        CurveShape::Hyperbola { .. } => rows.push(Row::text("edge", "hyperbola")),
        CurveShape::Conic { l, k, .. } => {
            let kind = if l == 0.0 && k == 0.0 {
                "parabola"
            } else {
                "conic"
            };
            rows.push(Row::text("edge", kind));
        }
        _ => rows.push(Row::text("edge", "curve of degree four")),
    }
    rows.push(Row::bounded("length", edge.length(), unit).drawn(length));
    rows
}

/// What is a circle: of conjugate half diameters, that differ by no more than rounding does.
const ROUND: f64 = 1e-12;

/// The centre, axis and radius of a circle, if the curve is one.
pub(crate) fn circle(curve: &CurveShape) -> Option<(DVec3, DVec3, f64)> {
    let CurveShape::Ellipse { center, a, b } = *curve else {
        return None;
    };
    let radius = a.length();
    let is_round =
        (radius - b.length()).abs() <= ROUND * radius && a.dot(b).abs() <= ROUND * radius * radius;
    is_round.then(|| (center, a.cross(b).normalize_or_zero(), radius))
}

/// The half axes of an ellipse with these conjugate half diameters, the longer one first
/// (Apollonius: a² + b² and the area are the same for all pairs).
fn semi_axes(a: DVec3, b: DVec3) -> [f64; 2] {
    let squares = a.length_squared() + b.length_squared();
    let area = a.cross(b).length();
    let (sum, difference) = (
        (squares + 2.0 * area).sqrt(),
        (squares - 2.0 * area).max(0.0).sqrt(),
    );
    [0.5 * (sum + difference), 0.5 * (sum - difference)]
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn numbers_have_no_more_digits_than_are_known() {
        assert_eq!(number(0.1 + 0.2), "0.3");
        assert_eq!(number(-0.0), "0");
        assert_eq!(number(1_234.567_890_123_45), "1234.56789012");
        assert_eq!(number(1e-9), "0.000000001");
    }

    #[test]
    fn conjugate_diameters_give_the_axes() {
        // Of x = 3 cos t, y = 2 sin t, at t and a quarter further.
        for t in [0.0, 0.4, 1.1] {
            let (s, c) = f64::sin_cos(t);
            let [a, b] = semi_axes(dvec3(3.0 * c, 2.0 * s, 0.0), dvec3(-3.0 * s, 2.0 * c, 0.0));
            assert!(
                (a - 3.0).abs() < 1e-14 && (b - 2.0).abs() < 1e-14,
                "{a} {b}"
            );
        }
    }
}
