//! A line common to two planes, and the part of it in a block.

use glam::DVec3;

use super::block::Block;
use super::ids::Position;
use super::scene::{Plane, Scene};
use crate::numeric::tolerance::PARALLEL_PLANES;
use crate::program::{Ends, Given};

/// A line with the interval of it that lies in a block.
pub(super) struct Line {
    pub point: DVec3,
    pub direction: DVec3,
    pub start: f64,
    pub end: f64,
}

impl Line {
    /// The whole line common to two planes of a block, the same to the bit in
    /// every block; none if they are parallel.
    pub fn of_pair(scene: &Scene<'_>, block: &Block, pair: [Position; 2]) -> Option<Self> {
        let [p, q] = pair.map(|position| scene.plane(block.id(position)));
        let direction = p.normal.cross(q.normal);
        let square = direction.length_squared();
        if square < PARALLEL_PLANES * PARALLEL_PLANES {
            return None;
        }
        let point =
            (q.normal.cross(direction) * p.offset + direction.cross(p.normal) * q.offset) / square;
        Some(Self {
            point,
            direction: direction / square.sqrt(),
            start: f64::NEG_INFINITY,
            end: f64::INFINITY,
        })
    }

    /// The line along a given edge of faces on two planes of a block, from end to end, in
    /// the direction of [`Self::of_pair`].
    pub fn along_edge(
        scene: &Scene<'_>,
        block: &Block,
        pair: [Position; 2],
        given: &Given,
        ends: Ends,
    ) -> Option<Self> {
        let [p, q] = pair.map(|position| scene.plane(block.id(position)).normal);
        let [from, to] = ends.map(|vertex| given.vertex(vertex));
        let runs_back = p.cross(q).dot(to - from) < 0.0;
        let ends = if runs_back { [ends[1], ends[0]] } else { ends };
        let (point, direction, [start, end]) = given.line_of(ends)?;
        Some(Self {
            point,
            direction,
            start,
            end,
        })
    }

    /// Clips the line to a box (Liang and Barsky, *A New Concept and Method for
    /// Line Clipping*, 1984); false if nothing is left.
    pub fn clip(&mut self, low: DVec3, high: DVec3) -> bool {
        for axis in 0..3 {
            let (at, slope) = (self.point[axis], self.direction[axis]);
            if slope == 0.0 {
                if !(low[axis] <= at && at < high[axis]) {
                    return false;
                }
                continue;
            }
            let (mut enter, mut leave) = ((low[axis] - at) / slope, (high[axis] - at) / slope);
            if slope < 0.0 {
                std::mem::swap(&mut enter, &mut leave);
            }
            self.start = self.start.max(enter);
            self.end = self.end.min(leave);
        }
        self.start < self.end
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.point + t * self.direction
    }

    /// Where along the line a point lies.
    pub fn along(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.direction)
    }

    /// Whether all of a clipped line lies in a plane.
    pub fn lies_in(&self, scene: &Scene<'_>, plane: &Plane) -> bool {
        let value = plane.value(self.point);
        let slope = plane.normal.dot(self.direction);
        let ends = [self.start, self.end].map(|t| (value + slope * t).abs());
        ends[0].max(ends[1]) <= scene.on_plane
    }
}
