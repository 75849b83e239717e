//! At which seams faces are cut, if they are to be cut at all.

use crate::arrangement::{Arrangement, HalfEdge};
use crate::program::{Surface, SurfaceShape};

/// The seams that are edges: of cylinders and cones one line, of other surfaces all.
pub(super) struct Seams {
    /// For each surface the number of that line; none where all seams are edges.
    of_surface: Vec<Option<u8>>,
}

impl Seams {
    /// Of the four lines in which its seams meet a cylinder, or a half of a cone, that which
    /// fewest pieces of its faces are cut at: none, where faces do not go all around.
    pub fn new(all: &Arrangement, surfaces: &[Surface]) -> Self {
        let is_round = |surface: &Surface| {
            let shape = surface.shape();
            matches!(
                shape,
                SurfaceShape::Cylinder { .. } | SurfaceShape::Cone { .. }
            )
        };
        let mut of_surface: Vec<Option<u8>> = surfaces
            .iter()
            .map(|surface| is_round(surface).then_some(0))
            .collect();
        let mut counts = vec![[0u32; 4]; surfaces.len()];
        for half_edge in all.half_edges.iter().filter(|half| half.curve.is_seam()) {
            if let Some(line) = line(all, half_edge) {
                counts[half_edge.curve.surfaces[0] as usize][line as usize] += 1;
            }
        }
        for (line, counts) in of_surface.iter_mut().zip(&counts) {
            let least = (0u8..4).min_by_key(|&line| counts[line as usize]);
            *line = line.and(least);
        }
        Self { of_surface }
    }

    /// Whether a face is cut at a half-edge that lies on a seam.
    pub fn has(&self, all: &Arrangement, half_edge: &HalfEdge) -> bool {
        let chosen = self.of_surface[half_edge.curve.surfaces[0] as usize];
        chosen.is_none_or(|chosen| line(all, half_edge) == Some(chosen))
    }
}

/// On which of four lines a half-edge lies: in which of two seams, and on which side of the
/// other one.
fn line(all: &Arrangement, half_edge: &HalfEdge) -> Option<u8> {
    let frame = all.frames[half_edge.curve.surfaces[0] as usize].as_ref()?;
    let seam = half_edge.curve.seam as usize;
    let other = frame.seams.get(1usize.checked_sub(seam)?)?;
    let end = all.half_edges[half_edge.twin as usize].from;
    let [from, to] = [half_edge.from, end].map(|point| all.points[point as usize]);
    let is_beyond = other.value(from.midpoint(to)) > 0.0;
    Some(2 * seam as u8 + u8::from(is_beyond))
}
