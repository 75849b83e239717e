//! What a plane meets of a solid.

use csg::brep::{Bounded, Coedge, CurveShape, Face};
use csg::{BoundaryOptions, Brep, Mesher, Moved, Profile, Program, Solid};
use glam::{DAffine3, DVec2, DVec3};

use super::Drawing;
use super::outline::{Outline, Piece, Shape};

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

    /// From the plane's x and y, and what is before it, to the model.
    pub(super) fn map(&self) -> DAffine3 {
        DAffine3::from_cols(self.x, self.y, self.normal(), self.origin)
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
    /// How far outlines may stray from the section: they are polygons, as it could not be told how
    /// surfaces meet. Infinite if no bound is known: then [`Self::area`] has none, either.
    pub strays: Option<f64>,
    /// What was done to surfaces that nearly coincide or touch, if it may change what is drawn: moves of
    /// no more than 1e-9 of the section's size are not told, as faces are in the plane to no more
    /// either. [`Self::area`] and [`Self::length`] count them.
    pub moved: Option<Moved>,
}

impl Section {
    /// Cuts a solid at the plane of a frame, by [`Solid::cut_at`]. The boundary of what lies just
    /// behind it is evaluated for it, as the options say, and of what lies just before it if a
    /// face may be in the plane. Where it cannot be told how surfaces meet, the outlines are
    /// polygons by a mesh ([`Self::strays`]).
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
    /// What is wrong with the solid; as [`Program::boundary`], [`csg::Error::Undecided`] only if
    /// no mesh shows the section either.
    pub fn of(
        solid: &Solid,
        frame: &SectionFrame,
        options: &BoundaryOptions,
    ) -> Result<Self, csg::Error> {
        let parts = solid.cut_at(frame.map())?;
        let mut sections = Vec::with_capacity(parts.len());
        for part in &parts {
            let program = Program::lower(part)?;
            let section = match program.boundary(options) {
                Ok(boundary) => Self::cap(&boundary),
                Err(csg::Error::Undecided(why)) => {
                    let polygons = Self::by_mesh(&program)?;
                    // What is not there may be lost.
                    if !polygons.is_there() && polygons.strays == Some(f64::INFINITY) {
                        return Err(csg::Error::Undecided(why));
                    }
                    polygons
                }
                // What was asked for is there.
                Err(_) if sections.iter().any(Self::is_there) => break,
                Err(error) => return Err(error),
            };
            sections.push(section);
        }
        let is_at_face = match &sections[..] {
            [behind, before] => behind.is_there() && before.is_there() && !behind.is_like(before),
            _ => false,
        };
        let section = sections.into_iter().find(Self::is_there);
        let section = section.unwrap_or_default();
        let size = section
            .bounds()
            .map_or(0.0, |[low, high]| (high - low).max_element());
        Ok(Self {
            is_at_face,
            moved: section.moved.filter(|moved| moved.distance > SAME * size),
            ..section
        })
    }

    /// A flat shape as the section of what it is extruded to: its Boolean operations carried out,
    /// lines, arcs and ellipses as such. ([`Self::strays`] as for other sections.)
    ///
    /// # Errors
    /// What is wrong with the profile; as [`Program::boundary`].
    pub fn of_profile(profile: &Profile, options: &BoundaryOptions) -> Result<Self, csg::Error> {
        let bounds = profile.bounds(f64::MAX);
        // (What is wrong is told where it is lowered.)
        let Ok(Some((low, high))) = bounds else {
            Program::lower(&Solid::extrude(profile, -1.0..1.0))?;
            return Ok(Self::default());
        };
        let half = 0.5 * (high - low).max_element();
        let solid = Solid::extrude(profile, -half..half);
        let frame = SectionFrame {
            origin: DVec3::ZERO,
            x: DVec3::X,
            y: DVec3::Y,
        };
        Self::of(&solid, &frame, options)
    }

    fn is_there(&self) -> bool {
        !self.outlines.is_empty()
    }

    /// The faces in the plane z = 0 of a mesh, as polygons.
    fn by_mesh(program: &Program) -> Result<Self, csg::Error> {
        let size = program.bounds()?.map_or(0.0, |b| b.size().max_element());
        if size == 0.0 {
            return Ok(Self::default());
        }
        let tolerance = STRAYS * size;
        let meshed = Mesher::new().tolerance(tolerance).mesh(program)?;
        let report = &meshed.report;
        let is_told = report.fallbacks.is_empty() && report.method != "adaptive";
        let strays = match &report.moved {
            _ if !is_told => f64::INFINITY,
            Some(moved) => tolerance + moved.distance,
            None => tolerance,
        };
        let mut section = Self {
            strays: Some(strays),
            ..Self::default()
        };
        let contours = meshed.mesh.faces_in_plane().contours(tolerance);
        for contour in contours.unwrap_or_default() {
            let next = contour.iter().cycle().skip(1);
            let sides = || contour.iter().copied().zip(next.clone().copied());
            let length: f64 = sides().map(|(from, to)| from.distance(to)).sum();
            let area: f64 = 0.5 * sides().map(|(from, to)| from.perp_dot(to)).sum::<f64>();
            section.parts += usize::from(area > 0.0);
            section.area.value += area;
            section.area.error += strays * length;
            section.length.value += length;
            let piece = |(from, to)| Piece {
                from,
                to,
                shape: Shape::Line,
            };
            section.outlines.push(Outline {
                pieces: sides().map(piece).collect(),
            });
        }
        // What lengths of polygons that stray by so much may be off has no bound.
        section.length.error = f64::INFINITY;
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
        let [one, other_corners] =
            [self, other].map(|section| section.bounds().unwrap_or_default());
        let size = (one[1] - one[0]).max_element();
        same(self.area, other.area)
            && same(self.length, other.length)
            && (0..2).all(|k| one[k].distance(other_corners[k]) <= SAME * size)
    }

    /// The corners of a box around all outlines.
    fn bounds(&self) -> Option<[DVec2; 2]> {
        let bounds = self.outlines.iter().map(Outline::bounds);
        bounds.reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])])
    }

    /// The faces of a solid in the plane z = 0.
    fn cap(part: &Brep) -> Self {
        let mut section = Self {
            moved: part.moved(),
            ..Self::default()
        };
        // Over the sine of the angle in which a surface meets the plane.
        let mut flattest = 1.0f64;
        for face in part.faces().filter(Face::is_in_plane) {
            let is_seen_from_behind = face.normal(DVec3::ZERO).z < 0.0;
            section.parts += 1;
            let area = face.area();
            section.area.value += area.value;
            section.area.error += area.error;
            for around in face.loops() {
                let pieces = around.coedges().map(|coedge| {
                    let edge = coedge.edge();
                    let beside = coedge.twin().face().normal(edge.at(edge.range()[0]));
                    flattest = flattest.max(beside.truncate().length_recip());
                    let length = edge.length();
                    section.length.value += length.value;
                    section.length.error += length.error;
                    piece(&coedge)
                });
                let mut pieces: Vec<Piece> = pieces.collect();
                if is_seen_from_behind {
                    pieces.reverse();
                    pieces.iter_mut().for_each(reverse);
                }
                section.outlines.push(Outline { pieces });
            }
        }
        // Most surfaces run straight across the plane: an outline moves by as much as they do.
        let moved = section.moved.map_or(0.0, |moved| moved.distance);
        let off = moved * flattest;
        section.area.error += off * section.length.value;
        section.length.error += off * section.outlines.iter().map(stretch).sum::<f64>();
        section
    }
}

/// By how much an outline gets longer at most, of a small distance by which its pieces move: twice the
/// tangent of half the angle at each corner, and along curves the angle by which they turn.
fn stretch(outline: &Outline) -> f64 {
    const CHORDS: u32 = 32;
    let share = |k: u32| f64::from(k) / f64::from(CHORDS);
    let chords = outline.pieces.iter().flat_map(|piece| {
        let chord = move |k: u32| piece.at(share(k + 1)) - piece.at(share(k));
        (0..CHORDS).map(chord)
    });
    let chords: Vec<DVec2> = chords.filter_map(DVec2::try_normalize).collect();
    let next = chords.iter().cycle().skip(1);
    let corners = chords.iter().zip(next);
    corners
        .map(|(one, next)| 2.0 * one.perp_dot(*next).abs() / (1.0 + one.dot(*next)))
        .sum()
}

/// Measures of both halves' caps are one, of their size: rounding of another boundary. Planes are one
/// to boundaries if they are as near.
const SAME: f64 = 1e-9;

/// How far polygons may stray from the section, of its size, where it cannot be told how surfaces
/// meet: seen at no scale at which the whole is drawn.
const STRAYS: f64 = 1e-5;

/// The other way round.
fn reverse(piece: &mut Piece) {
    std::mem::swap(&mut piece.from, &mut piece.to);
    if let Shape::Ellipse { range, .. } = &mut piece.shape {
        range.reverse();
    }
}

/// A coedge as it is drawn.
fn piece(coedge: &Coedge<'_>) -> Piece {
    let edge = coedge.edge();
    let range = edge.range();
    let ends = match edge.vertices() {
        Some(vertices) => vertices.map(|vertex| vertex.point()),
        None => [edge.at(range[0]); 2],
    };
    let [from, to] = ends.map(DVec3::truncate);
    let curve = edge.curve();
    let shape = match (curve, curve.half_axes()) {
        (CurveShape::Ellipse { center, .. }, Some(axes)) => {
            let [long, short] = [axes.long, axes.short].map(DVec3::truncate);
            Shape::Ellipse {
                center: center.truncate(),
                long,
                short,
                range: range.map(|t| t - axes.turn),
                is_circle: axes.is_circle,
            }
        }
        // Else a plane and a quadric meet in a line.
        _ => match curve.control(range) {
            Some([first, middle, last]) => Shape::Conic {
                control: middle.truncate().truncate() / middle.w,
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
