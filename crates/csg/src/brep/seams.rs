//! At which seams faces are cut, if they are to be cut at all.

use glam::DVec3;

use crate::arrangement::{Arrangement, Frame, HalfEdge, Other};
use crate::program::{Surface, SurfaceShape};

/// The seams that are edges: of cylinders and cones one line, of whole spheres half a great
/// circle, of other surfaces all. (Of a sphere that others cut, too, a face with poles inside could
/// be cut at a meridian, but circles that come near a pole are steep there in longitude and
/// latitude: Open CASCADE, which lays images of edges through some points, found the volumes of
/// such solids off by up to 3e-4.)
pub(super) struct Seams {
    /// For each surface that line; none where all seams are edges.
    of_surface: Vec<Option<Line>>,
}

/// The half of a seam on one side of another one: on a cylinder and on half a cone a straight
/// line, on a sphere a meridian from pole to pole.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    seam: usize,
    other: usize,
    is_beyond: bool,
}

impl Line {
    /// All of a surface with so many seams.
    fn all(seams: usize) -> impl Iterator<Item = Self> {
        let pairs = (0..seams).flat_map(move |seam| (0..seams).map(move |other| (seam, other)));
        let lines = pairs.filter(|(seam, other)| seam != other);
        lines.flat_map(|(seam, other)| {
            [false, true].map(|is_beyond| Self {
                seam,
                other,
                is_beyond,
            })
        })
    }

    /// Whether a half-edge that lies on a seam lies on it.
    fn has(self, all: &Arrangement, half_edge: &HalfEdge) -> bool {
        let frame = all.frame(half_edge.curve.first);
        let other = frame.and_then(|frame| frame.seams.get(self.other));
        let is_beyond = |other: &Surface| {
            let [from, to] = all.chord(half_edge);
            other.value(from.midpoint(to)) > 0.0
        };
        half_edge.curve.other == Other::Seam(self.seam as u16)
            && other.is_some_and(|other| is_beyond(other) == self.is_beyond)
    }
}

impl Seams {
    /// Of the lines on a cylinder, a cone or a whole sphere that which fewest pieces of its faces
    /// are cut at: none, where faces do not go all around.
    pub fn new(all: &Arrangement, surfaces: &[Surface]) -> Self {
        let mut is_whole = vec![true; surfaces.len()];
        for half_edge in all.half_edges.iter().filter(|half| !half.curve.is_seam()) {
            is_whole[all.faces[half_edge.face.index()].plane.index()] = false;
        }
        let mut lines: Vec<Vec<(Line, u32)>> = surfaces
            .iter()
            .zip(&all.frames)
            .zip(&is_whole)
            .map(|((surface, frame), &is_whole)| {
                let seams = frame.as_ref().map_or(0, |frame| frame.seams.len());
                let is_round = match surface.shape() {
                    SurfaceShape::Cylinder { .. } | SurfaceShape::Cone { .. } => seams == 2,
                    SurfaceShape::Sphere { .. } => seams == 3 && is_whole,
                    _ => false,
                };
                let lines = Line::all(if is_round { seams } else { 0 });
                lines.map(|line| (line, 0)).collect()
            })
            .collect();
        for half_edge in all.half_edges.iter().filter(|half| half.curve.is_seam()) {
            for (line, count) in &mut lines[half_edge.curve.first.index()] {
                *count += u32::from(line.has(all, half_edge));
            }
        }
        let least = |lines: Vec<(Line, u32)>| lines.into_iter().min_by_key(|&(_, count)| count);
        Self {
            of_surface: lines
                .into_iter()
                .map(|lines| least(lines).map(|(line, _)| line))
                .collect(),
        }
    }

    /// Whether a face is cut at a half-edge that lies on a seam.
    pub fn has(&self, all: &Arrangement, half_edge: &HalfEdge) -> bool {
        let chosen = self.of_surface[half_edge.curve.first.index()];
        chosen.is_none_or(|line| line.has(all, half_edge))
    }

    /// Of each sphere that is cut at a meridian the unit directions from its centre to a pole and
    /// to the middle of the meridian.
    pub fn meridians(&self, all: &Arrangement) -> Vec<Option<[DVec3; 2]>> {
        let lines = self.of_surface.iter().zip(&all.frames);
        let meridian = |(line, frame): (&Option<Line>, &Option<Frame>)| {
            let (line, frame) = (line.as_ref()?, frame.as_ref()?);
            // The seams of spheres are at right angles.
            let [pole, middle] = [3usize.checked_sub(line.seam + line.other)?, line.other];
            let [pole, middle] = [frame.seams.get(pole)?, frame.seams.get(middle)?]
                .map(|plane| plane.linear.normalize_or_zero());
            Some([pole, if line.is_beyond { middle } else { -middle }])
        };
        lines.map(meridian).collect()
    }
}
