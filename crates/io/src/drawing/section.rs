//! What a plane meets of a solid.

use csg::brep::{Bounded, Coedge, CurveShape, Face};
use csg::{BoundaryOptions, Brep, Program, Solid, SurfaceShape};
use glam::{DVec2, DVec3};

use super::Drawing;
use super::outline::{Outline, Piece, Shape};
use crate::conic;

/// A plane, and how it is looked at: x and y of the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionFrame {
    /// Where x and y are 0.
    pub origin: DVec3,
    /// The direction of x, of unit length.
    pub x: DVec3,
    /// The direction of y, of unit length and at right angles to x.
    pub y: DVec3,
}

impl SectionFrame {
    /// Of a plane through a point, seen against a direction across it, with Z upwards, or Y in
    /// a plane that lies across Z. The origin is the foot of the model's.
    ///
    /// None for a direction without length, or what is not finite.
    #[must_use]
    pub fn facing(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Option<Self> {
        let point = point.into();
        let normal = normal.into().try_normalize()?;
        let origin = point.dot(normal) * normal;
        let is_level = normal.truncate() == DVec2::ZERO;
        let up = if is_level { DVec3::Y } else { DVec3::Z };
        let x = up.cross(normal).try_normalize()?;
        origin.is_finite().then_some(Self {
            origin,
            x,
            y: normal.cross(x),
        })
    }

    /// Towards the eye, of unit length.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.x.cross(self.y)
    }

    pub(super) fn flatten(&self, point: DVec3) -> DVec2 {
        self.turned(point - self.origin)
    }

    pub(super) fn turned(&self, direction: DVec3) -> DVec2 {
        DVec2::new(direction.dot(self.x), direction.dot(self.y))
    }
}

/// The section of a solid.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Section {
    /// Around each part and each hole in it; parts lie on the left.
    pub outlines: Vec<Outline>,
    /// The area of all parts, in the model's unit.
    pub area: Bounded,
    /// The length of all outlines.
    pub length: Bounded,
    /// How many parts there are.
    pub parts: usize,
    /// Whether what lies just behind the plane differs from what lies just before it, and
    /// neither is nothing: the solid has a face in the plane, and drawn is what lies behind.
    /// (Of a solid that begins or ends at the plane it is its face there.)
    pub is_at_face: bool,
}

impl Section {
    /// Cuts a solid at the plane of a frame. The boundary of the half behind it is evaluated
    /// for it, as the options say.
    ///
    /// ```
    /// use csg::Solid;
    /// use io::drawing::{Section, SectionFrame, Shape};
    ///
    /// let tube = Solid::cylinder(2.0, 0.0..5.0) - Solid::cylinder(1.0, -1.0..6.0);
    /// let frame = SectionFrame::facing([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]).expect("a plane");
    /// let section = Section::of(&tube, &frame, &Default::default())?;
    /// assert_eq!(section.outlines.len(), 2);
    /// let is_circle = |shape: &Shape| matches!(shape, Shape::Ellipse { is_circle: true, .. });
    /// assert!(is_circle(&section.outlines[0].pieces[0].shape));
    /// assert!((section.area.value - 3.0 * std::f64::consts::PI).abs() <= section.area.error);
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with the solid; as [`Program::boundary`].
    pub fn of(
        solid: &Solid,
        frame: &SectionFrame,
        options: &BoundaryOptions,
    ) -> Result<Self, csg::Error> {
        let normal = frame.normal();
        let half = |normal| -> Result<Brep, csg::Error> {
            let half = solid & Solid::half_space_through(frame.origin, normal);
            Program::lower(&half)?.boundary(options)
        };
        let mut section = Self::cap(&half(normal)?, frame, normal);
        let other = match half(-normal) {
            Ok(before) => Self::cap(&before, frame, -normal),
            // What was asked for is there.
            Err(_) if !section.outlines.is_empty() => return Ok(section),
            Err(error) => return Err(error),
        };
        let is_there = |section: &Self| !section.outlines.is_empty();
        let is_at_face = is_there(&section) && is_there(&other) && !section.is_like(&other);
        if section.outlines.is_empty() {
            section = other;
        }
        section.is_at_face = is_at_face;
        Ok(section)
    }

    /// The drawing of it: its parts, filled.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        Drawing::of_outlines(self.outlines.clone())
    }

    /// Whether measures of both are one.
    fn is_like(&self, other: &Self) -> bool {
        let same = |one: Bounded, other: Bounded| {
            let larger = one.value.abs().max(other.value.abs());
            (one.value - other.value).abs() <= one.error + other.error + SAME * larger
        };
        let corners = |section: &Self| {
            let bounds = section.outlines.iter().map(Outline::bounds);
            bounds.reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])])
        };
        let [one, other_corners] = [corners(self), corners(other)].map(Option::unwrap_or_default);
        let size = (one[1] - one[0]).max_element();
        same(self.area, other.area)
            && same(self.length, other.length)
            && (0..2).all(|k| one[k].distance(other_corners[k]) <= SAME * size)
    }

    /// The faces in the plane of a half of the solid, whose outward normal is given.
    fn cap(half: &Brep, frame: &SectionFrame, normal: DVec3) -> Self {
        let mut section = Self::default();
        let turn = normal.dot(frame.normal()).signum();
        for face in half.faces().filter(|face| is_in(face, frame, normal)) {
            section.parts += 1;
            let area = face.area();
            section.area.value += area.value;
            section.area.error += area.error;
            for around in face.loops() {
                let pieces = around.coedges().map(|coedge| {
                    let length = coedge.edge().length();
                    section.length.value += length.value;
                    section.length.error += length.error;
                    piece(&coedge, frame)
                });
                let mut pieces: Vec<Piece> = pieces.collect();
                if turn < 0.0 {
                    pieces.reverse();
                    pieces.iter_mut().for_each(reverse);
                }
                section.outlines.push(Outline { pieces });
            }
        }
        section
    }
}

/// Measures of both halves' caps are one, of their size: rounding of another boundary.
const SAME: f64 = 1e-9;

/// Is a face's plane that of the section, by the sine of an angle and by distances, of the
/// largest coordinate?
const SAME_PLANE: f64 = 1e-11;

/// Whether a face lies in the plane and faces the way of a normal.
fn is_in(face: &Face<'_>, frame: &SectionFrame, normal: DVec3) -> bool {
    let SurfaceShape::Plane { point, .. } = face.surface().shape() else {
        return false;
    };
    let off = (point - frame.origin).dot(normal).abs();
    let far = point.length().max(frame.origin.length());
    let own = face.normal(point);
    own.dot(normal) > 0.0 && own.cross(normal).length() < SAME_PLANE && off <= SAME_PLANE * far
}

/// The other way round.
fn reverse(piece: &mut Piece) {
    std::mem::swap(&mut piece.from, &mut piece.to);
    if let Shape::Ellipse { range, .. } = &mut piece.shape {
        range.reverse();
    }
}

/// A coedge as it is drawn.
fn piece(coedge: &Coedge<'_>, frame: &SectionFrame) -> Piece {
    let edge = coedge.edge();
    let range = edge.range();
    let ends = match edge.vertices() {
        Some(vertices) => vertices.map(|vertex| vertex.point()),
        None => [edge.at(range[0]); 2],
    };
    let [from, to] = ends.map(|end| frame.flatten(end));
    let curve = edge.curve();
    let shape = match (curve, curve.half_axes()) {
        (CurveShape::Ellipse { center, .. }, Some(axes)) => {
            let [long, short] = [axes.long, axes.short].map(|axis| frame.turned(axis));
            Shape::Ellipse {
                center: frame.flatten(center),
                long,
                short,
                range: range.map(|t| t - axes.turn),
                is_circle: axes.is_circle,
            }
        }
        // Else a plane and a quadric meet in a line.
        _ => match conic::control(&curve, range) {
            Some([first, middle, last]) => Shape::Conic {
                control: frame.flatten(middle.truncate() / middle.w),
                weight: middle.w / (first.w * last.w).sqrt(),
            },
            None => Shape::Line,
        },
    };
    let mut piece = Piece { from, to, shape };
    if !coedge.is_forward() {
        reverse(&mut piece);
    }
    piece
}
