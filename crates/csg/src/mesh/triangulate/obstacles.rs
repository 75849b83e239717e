//! Corners that may lie in an ear, found by place.

use glam::DVec2;

use super::contours::bounds;
use crate::mesh::predicates::orient;

/// A corner of the polygon in work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub point: DVec2,
    /// What it is called outside.
    pub name: u32,
    pub previous: u32,
    pub next: u32,
}

/// Corners that are not convex, in a grid: only they can lie in an ear.
#[derive(Default)]
pub(super) struct Obstacles {
    low: DVec2,
    /// Squares per unit of length, and per side.
    scale: DVec2,
    side: usize,
    /// All of them, in order.
    all: Vec<u32>,
    /// Those of each square after each other, row by row.
    corners: Vec<u32>,
    /// Where those of each square begin, and the last ones end.
    starts: Vec<u32>,
    is_left: Vec<bool>,
}

impl Obstacles {
    /// Those of a polygon, all left.
    pub fn find(&mut self, corners: &[Corner], tolerance: f64) {
        let point = |k: u32| corners[k as usize].point;
        let [low, high] = bounds(corners.iter().map(|c| c.point));
        let is_one = |&k: &u32| {
            let corner = corners[k as usize];
            let [a, c] = [corner.previous, corner.next].map(point);
            orient(a, corner.point, c) <= 2.0 * tolerance * (c - a).length()
        };
        self.all.clear();
        self.all.extend((0..corners.len() as u32).filter(is_one));
        let side = ((self.all.len() as f64 / 4.0).sqrt() as usize).max(1);
        self.low = low;
        self.scale = side as f64 / (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        self.side = side;
        self.corners.clear();
        self.corners.resize(self.all.len(), 0);
        self.starts.clear();
        self.starts.resize(side * side + 2, 0);
        self.is_left.clear();
        self.is_left.resize(corners.len(), true);
        let square_of = |grid: &Self, k: u32| {
            let [x, y] = grid.square(point(k));
            y * side + x
        };
        // By counting: what a square holds ends where the next one begins.
        for index in 0..self.all.len() {
            let square = square_of(self, self.all[index]);
            self.starts[square + 2] += 1;
        }
        for square in 2..self.starts.len() {
            self.starts[square] += self.starts[square - 1];
        }
        for index in 0..self.all.len() {
            let k = self.all[index];
            let square = square_of(self, k);
            let slot = &mut self.starts[square + 1];
            self.corners[*slot as usize] = k;
            *slot += 1;
        }
    }

    fn square(&self, point: DVec2) -> [usize; 2] {
        let at = (point - self.low) * self.scale;
        [at.x, at.y].map(|v| (v as usize).min(self.side - 1))
    }

    pub fn remove(&mut self, corner: u32) {
        self.is_left[corner as usize] = false;
    }

    /// Whether a test holds for any of those left in a box.
    pub fn any_in(&self, low: DVec2, high: DVec2, test: impl Fn(u32) -> bool) -> bool {
        let ([x0, y0], [x1, y1]) = (self.square(low), self.square(high));
        (y0..=y1).any(|y| {
            let row = y * self.side;
            let [start, end] = [row + x0, row + x1 + 1].map(|square| self.starts[square] as usize);
            self.corners[start..end]
                .iter()
                .any(|&k| self.is_left[k as usize] && test(k))
        })
    }
}
