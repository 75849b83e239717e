//! What is seen of a solid along a direction: edges and outlines of curved faces, visible or
//! hidden.

use csg::brep::{Edge, Face};
use csg::{BoundaryOptions, Brep, Program, Solid, Surface};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::crossings::{NEAR, SHORT, cross};
use super::dimension::Dimension;
use super::outline::{Piece, Shape};
use super::section::SectionFrame;
use super::seen::Seen;
use super::{Drawing, Outline};

/// Directions closer than this, by a sine, are one: of normals on both sides of an edge, and of
/// a normal and the picture's plane.
const SAME_DIRECTION: f64 = 1e-6;

/// Of the solid's size, how near the ray from a point to the eye is not looked at: within,
/// rounding would tell.
const CLOSE: f64 = 1e-6;

/// Of the solid's size, how far B-splines may stray from curves of degree four.
const TOLERANCE: f64 = 1e-7;

/// A solid as it is drawn: parallel projection along a direction.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct View {
    /// What is seen of edges and outlines.
    pub visible: Vec<Piece>,
    /// What of them is behind the solid, but not behind other pieces.
    pub hidden: Vec<Piece>,
}

impl View {
    /// Draws a solid as it is seen against the normal of a frame.
    ///
    /// Drawn are the edges of its exact boundary at which it is not smooth, and the outlines of
    /// curved faces, which are where a polar plane meets them: lines and conics again. Where
    /// what is seen may change is where they cross; between, a ray to the eye tells. So cost
    /// grows with the square of the number of edges, and with that of surfaces.
    ///
    /// ```
    /// use csg::Solid;
    /// use io::drawing::{SectionFrame, View};
    ///
    /// // From the front a bore upright is two dashed lines.
    /// let solid = Solid::cube(2.0) - Solid::cylinder(0.5, -2.0..2.0);
    /// let frame = SectionFrame::facing([0.0; 3], [0.0, -1.0, 0.0]).expect("a direction");
    /// let view = View::of(&solid, &frame, &Default::default())?;
    /// assert_eq!((view.visible.len(), view.hidden.len()), (4, 2));
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
        let program = Program::lower(solid)?;
        let brep = program.boundary(options)?;
        let Some(bounds) = brep.bounds() else {
            return Ok(Self::default());
        };
        let size = bounds.min.distance(bounds.max);
        let eye = frame.normal();
        let tolerance = 0.1 * TOLERANCE * size;
        let seen = |edge: &Edge<'_>| Seen::of_edge(edge, frame, size, tolerance);
        let mut curves: Vec<Seen> = Vec::new();
        let drawn = brep.edges().filter(|edge| is_drawn(edge, eye));
        curves.extend(drawn.filter_map(|edge| seen(&edge)).flatten());
        // The outlines are edges of the section there.
        let planes = polar_planes(&brep, eye, size);
        let outlines: Vec<Vec<Seen>> = planes
            .par_iter()
            .map(|plane| -> Result<Vec<Seen>, csg::Error> {
                let Some(at) = SectionFrame::facing(plane.point, plane.normal) else {
                    return Ok(Vec::new());
                };
                let mut outlines = Vec::new();
                for part in solid.cut_at(at.map())? {
                    let part = Program::lower(&part.affine(at.map()))?.boundary(options)?;
                    let edges = part.edges().filter(|edge| plane.has(edge, eye));
                    outlines.extend(edges.filter_map(|edge| seen(&edge)).flatten());
                }
                Ok(outlines)
            })
            .collect::<Result<_, _>>()?;
        curves.extend(outlines.into_iter().flatten());
        let parts = parts(&curves, size);
        let sight = Sight {
            program: &program,
            eye,
            size,
        };
        let is_seen: Vec<bool> = parts
            .par_iter()
            .map(|part| sight.is_seen(part.middle(&curves)))
            .collect();
        let depths: Vec<f64> = parts
            .iter()
            .map(|part| part.middle(&curves).dot(eye))
            .collect();
        Ok(Self::put_together(
            &curves,
            &parts,
            (&is_seen, &depths),
            size,
        ))
    }

    /// Each curve's parts, those that are hidden by drawn ones left out.
    fn put_together(
        curves: &[Seen],
        parts: &[Part],
        (is_seen, depths): (&[bool], &[f64]),
        size: f64,
    ) -> Self {
        let boxes: Vec<[DVec2; 2]> = parts
            .iter()
            .map(|part| curves[part.curve].bounds(part.range))
            .collect();
        let near = 10.0 * NEAR * size;
        // Of those that lie on each other the nearest is drawn, visible ones before hidden ones.
        let mut drawn: Vec<usize> = Vec::new();
        let mut is_drawn = vec![false; parts.len()];
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|&a, &b| {
            let by_depth = depths[b].total_cmp(&depths[a]);
            is_seen[b].cmp(&is_seen[a]).then(by_depth)
        });
        for k in order {
            let part = &parts[k];
            let covers = |other: usize, point: DVec2| {
                let [low, high] = boxes[other];
                (low - near).cmple(point).all()
                    && point.cmple(high + near).all()
                    && parts[other].is_near(curves, point, near)
            };
            let is_covered = [0.21, 0.5, 0.83].into_iter().all(|share| {
                let point = part.at(curves, share);
                drawn.iter().any(|&other| covers(other, point))
            });
            if !is_covered {
                is_drawn[k] = true;
                drawn.push(k);
            }
        }
        let mut view = Self::default();
        let mut k = 0;
        while k < parts.len() {
            let first = &parts[k];
            let mut range = first.range;
            let mut next = k + 1;
            if is_drawn[k] {
                while next < parts.len()
                    && is_drawn[next]
                    && is_seen[next] == is_seen[k]
                    && parts[next].curve == first.curve
                {
                    range[1] = parts[next].range[1];
                    next += 1;
                }
                let pieces = curves[first.curve].pieces(range, TOLERANCE * size);
                let list = if is_seen[k] {
                    &mut view.visible
                } else {
                    &mut view.hidden
                };
                list.extend(pieces);
            }
            k = next;
        }
        view
    }

    /// The drawing of it, with the sizes of the whole, and the diameters of circles that are
    /// seen whole, if they are asked for.
    #[must_use]
    pub fn drawing(&self, with_dimensions: bool) -> Drawing {
        let mut drawing = Drawing {
            outlines: Vec::new(),
            visible: self.visible.clone(),
            hidden: self.hidden.clone(),
            dimensions: Vec::new(),
        };
        if with_dimensions && let Some(bounds) = drawing.bounds() {
            let size = (bounds[1] - bounds[0]).max_element();
            let mut circles: Vec<Dimension> = Vec::new();
            for piece in self.visible.iter().filter(|piece| piece.is_whole()) {
                if let Shape::Ellipse {
                    center,
                    long,
                    is_circle: true,
                    ..
                } = piece.shape
                {
                    let number = circles.len();
                    let diameter = Dimension::of_circle(center, long.length(), number, size);
                    if !circles.iter().any(|told| told.is_same_diameter(&diameter)) {
                        circles.push(diameter);
                    }
                }
            }
            drawing.dimensions = Dimension::of_box(bounds);
            drawing.dimensions.extend(circles);
        }
        drawing
    }
}

impl Drawing {
    /// Outlines, filled, and nothing else.
    #[must_use]
    pub fn of_outlines(outlines: Vec<Outline>) -> Self {
        Self {
            outlines,
            ..Self::default()
        }
    }
}

/// Shares along an edge at which it is looked at.
const LOOKED_AT: [f64; 3] = [0.18, 0.53, 0.86];

/// Whether the boundary is not smooth at an edge, or is seen edge-on there.
fn is_drawn(edge: &Edge<'_>, eye: DVec3) -> bool {
    let [from, to] = edge.range();
    let faces = edge.faces();
    let normals = LOOKED_AT.map(|share| {
        let point = edge.at(from + share * (to - from));
        faces.map(|face| face.normal(point))
    });
    let is_sharp = normals
        .iter()
        .any(|[one, other]| one.cross(*other).length() > SAME_DIRECTION || one.dot(*other) < 0.0);
    let is_outline = normals
        .iter()
        .flatten()
        .all(|normal| normal.dot(eye).abs() < SAME_DIRECTION);
    is_sharp || is_outline && faces.iter().any(|face| !face.surface().is_plane())
}

/// A plane that meets a quadric where its normals are across the view.
struct PolarPlane {
    surfaces: Vec<Surface>,
    point: DVec3,
    normal: DVec3,
    /// How far points of the solid may be off by rounding.
    near: f64,
}

/// Of all curved faces, each once.
fn polar_planes(brep: &Brep, eye: DVec3, size: f64) -> Vec<PolarPlane> {
    let mut planes: Vec<PolarPlane> = Vec::new();
    let mut last = None;
    for face in brep.faces() {
        if last == Some(face.surface_index()) || face.surface().is_plane() {
            continue;
        }
        last = Some(face.surface_index());
        let Some(plane) = PolarPlane::of(&face, eye, size) else {
            continue;
        };
        match planes.iter_mut().find(|known| known.is_same(&plane)) {
            Some(known) => known.surfaces.extend(plane.surfaces),
            None => planes.push(plane),
        }
    }
    planes
}

impl PolarPlane {
    /// None where all normals are across the view, or none is.
    fn of(face: &Face<'_>, eye: DVec3, size: f64) -> Option<Self> {
        let surface = face.surface();
        let about = *face.points().first()?;
        let gradient = surface.gradient(about);
        let along =
            |axis: DVec3| (surface.gradient(about + size * axis) - gradient).dot(eye) / size;
        let normal = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
        let value = gradient.dot(eye);
        let length = normal.length();
        if length * size <= 1e-9 * gradient.length() {
            return None;
        }
        let point = about - value / (length * length) * normal;
        Some(Self {
            surfaces: vec![surface],
            point,
            normal: normal / length,
            near: NEAR * size,
        })
    }

    fn is_same(&self, other: &Self) -> bool {
        self.normal.cross(other.normal).length() < 1e-9
            && (self.point - other.point).dot(self.normal).abs() < self.near
    }

    /// Whether an edge of a section lies in the plane, and on one of the surfaces where its
    /// normals are across the view.
    fn has(&self, edge: &Edge<'_>, eye: DVec3) -> bool {
        let [from, to] = edge.range();
        let points = LOOKED_AT.map(|share| edge.at(from + share * (to - from)));
        let is_in = |point: &DVec3| (*point - self.point).dot(self.normal).abs() <= self.near;
        let is_outline = |surface: &Surface| {
            points.iter().all(|&point| {
                let gradient = surface.gradient(point);
                let length = gradient.length();
                surface.value(point).abs() <= self.near * length
                    && gradient.dot(eye).abs() <= SAME_DIRECTION * length
            })
        };
        points.iter().all(is_in) && self.surfaces.iter().any(is_outline)
    }
}

/// A part of a curve along which what is seen does not change.
struct Part {
    curve: usize,
    range: [f64; 2],
}

impl Part {
    /// Not in the middle, where symmetric solids have something behind it.
    fn middle(&self, curves: &[Seen]) -> DVec3 {
        let [from, to] = self.range;
        curves[self.curve].point(from + 0.4871 * (to - from))
    }

    fn at(&self, curves: &[Seen], share: f64) -> DVec2 {
        let [from, to] = self.range;
        curves[self.curve].at(from + share * (to - from))
    }

    fn is_near(&self, curves: &[Seen], point: DVec2, near: f64) -> bool {
        let mut curve = curves[self.curve].clone();
        curve.range = self.range;
        curve.nearest(point).1 <= near
    }
}

/// All curves, cut where they cross or end on each other.
fn parts(curves: &[Seen], size: f64) -> Vec<Part> {
    let crossings: Vec<(usize, usize, Vec<f64>, Vec<f64>)> = (0..curves.len())
        .into_par_iter()
        .flat_map_iter(|k| {
            let pairs = (k + 1..curves.len()).map(move |other| {
                let (mut places, mut others) = (Vec::new(), Vec::new());
                let lists = [&mut places, &mut others];
                cross(&curves[k], &curves[other], size, lists);
                (k, other, places, others)
            });
            pairs.filter(|(_, _, places, others)| !places.is_empty() || !others.is_empty())
        })
        .collect();
    let mut places: Vec<Vec<f64>> = curves.iter().map(|curve| curve.range.to_vec()).collect();
    for (k, other, own, others) in crossings {
        places[k].extend(own);
        places[other].extend(others);
    }
    let mut parts = Vec::new();
    for (curve, mut places) in places.into_iter().enumerate() {
        let seen = &curves[curve];
        let [from, to] = seen.range;
        places.sort_by(f64::total_cmp);
        // What is shorter is not told from what is beside it.
        let short = 2.0 * SHORT * size;
        let mut ends: Vec<f64> = vec![from];
        for place in places {
            let is_new = |other: f64| {
                place - other > 1e-12 * (to - from)
                    && seen.at(place).distance(seen.at(other)) > short
            };
            let is_inner = place < to && seen.at(place).distance(seen.at(to)) > short;
            // (All around an ellipse both ends are the same place.)
            if is_inner && ends.last().is_none_or(|&last| is_new(last)) {
                ends.push(place);
            }
        }
        ends.push(to);
        parts.extend(ends.windows(2).map(|pair| Part {
            curve,
            range: [pair[0], pair[1]],
        }));
    }
    parts
}

/// Rays to the eye.
struct Sight<'a> {
    program: &'a Program,
    eye: DVec3,
    size: f64,
}

impl Sight<'_> {
    /// Whether nothing of the solid is between a point and the eye: the ray passes surfaces at
    /// roots of polynomials of degree two, and is in the solid or not from one to the next.
    fn is_seen(&self, point: DVec3) -> bool {
        let close = CLOSE * self.size;
        let mut roots = vec![close, 2.0 * self.size];
        for surface in self.program.surfaces() {
            let square = 0.5 * surface.curvature_along(self.eye);
            let linear = surface.gradient(point).dot(self.eye);
            let constant = surface.value(point);
            roots.extend(quadratic(square, linear, constant));
        }
        roots.retain(|root| *root >= close && *root <= 2.0 * self.size);
        roots.sort_by(f64::total_cmp);
        roots.windows(2).all(|pair| {
            let is_thin = pair[1] - pair[0] < close;
            is_thin
                || !self
                    .program
                    .contains(point + 0.5 * (pair[0] + pair[1]) * self.eye)
        })
    }
}

/// The real roots of a x² + b x + c.
fn quadratic(a: f64, b: f64, c: f64) -> impl Iterator<Item = f64> {
    let root = (b * b - 4.0 * a * c).sqrt();
    let q = -0.5 * (b + if b < 0.0 { -root } else { root });
    [q / a, c / q].into_iter().filter(|root| root.is_finite())
}
