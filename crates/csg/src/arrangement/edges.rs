//! The given edges of polyhedra beside curved surfaces.

use glam::DVec3;
use smallvec::SmallVec;

use super::curve::Curve;
use super::roots::Roots;
use super::scene::Scene;
use crate::program::{Ends, Given, Surface, SurfaceId};

impl Scene<'_> {
    /// The given edges in which two surfaces alone meet, if these carry faces of one
    /// polyhedron and of nothing else.
    pub fn only_edges(&self, pair: [SurfaceId; 2]) -> Option<&[Ends]> {
        let given = self.given?;
        let are_of_one = given.are_of_one(pair[0], pair[1]);
        are_of_one.then(|| given.edges_of(pair))
    }

    /// Where the edges that faces on two planes share cross a surface.
    pub fn on_edges(&self, pair: [SurfaceId; 2], surface: &Surface) -> SmallVec<[DVec3; 2]> {
        let mut points = SmallVec::new();
        let Some(given) = self.given else {
            return points;
        };
        let mut roots = Roots::default();
        for &ends in given.edges_of(pair) {
            let Some((line, stretch)) = along(given, ends) else {
                continue;
            };
            roots.clear();
            line.meet(surface, stretch, self.tolerances(), &mut roots);
            points.extend(roots.simple.iter().map(|&t| line.at(t)));
        }
        points
    }

    /// Of the planes through a curve, and other surfaces, the two that
    /// it is traced by: the first that are beside each other and not of one
    /// polyhedron. None if all are: then its edges are.
    pub fn first_of_through(
        &self,
        through: &[SurfaceId],
        are_beside: impl Fn(SurfaceId, SurfaceId) -> bool,
    ) -> Option<[SurfaceId; 2]> {
        let given = self.given?;
        let rest = |k: usize| through[k + 1..].iter();
        let pairs = (0..through.len()).flat_map(|k| rest(k).map(move |&b| [through[k], b]));
        let mut pairs = pairs.filter(|&[a, b]| are_beside(a, b) && !given.are_of_one(a, b));
        pairs.next()
    }
}

/// The line along an edge, and where on it that begins and ends.
pub(super) fn along(given: &Given, ends: Ends) -> Option<(Curve, [f64; 2])> {
    let (point, direction, stretch) = given.line_of(ends)?;
    Some((Curve::Line { point, direction }, stretch))
}
