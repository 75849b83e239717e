//! Edges that a diagonal may cross, found by height.

use std::ops::RangeInclusive;

use super::contours::Region;

/// Edges by the strips of a plane along x that they pass through, each named by the corner it
/// starts from.
#[derive(Default)]
pub(super) struct Strips {
    low: f64,
    /// Strips per unit of length.
    scale: f64,
    strips: Vec<Vec<u32>>,
    /// How many of these are in use.
    count: usize,
}

impl Strips {
    /// As many as some corners are worth, unless edges are so long that they would be named in
    /// more than a few.
    pub fn part(&mut self, region: &Region<'_>, corners: usize) {
        /// Corners for each strip, and names for each edge. Tune speed only.
        const CORNERS: usize = 8;
        const NAMES: f64 = 4.0;
        let contours = region.holes.iter().chain([&region.outer]);
        let climbs = contours.flat_map(|contour| {
            let pairs = contour.iter().zip(contour.iter().cycle().skip(1));
            pairs.map(|(a, b)| (a.0.y - b.0.y).abs())
        });
        let [low, high] = region.bounds.map(|corner| corner.y);
        let height = (high - low).max(f64::MIN_POSITIVE);
        let most = NAMES * corners as f64 * height / climbs.sum::<f64>().max(height);
        self.count = (corners / CORNERS).min(most as usize).max(1);
        (self.low, self.scale) = (low, self.count as f64 / height);
        if self.strips.len() < self.count {
            self.strips.resize(self.count, Vec::new());
        }
        self.strips[..self.count].iter_mut().for_each(Vec::clear);
    }

    fn at(&self, y: f64) -> usize {
        (((y - self.low) * self.scale) as usize).min(self.count - 1)
    }

    /// The strips that two heights are in, and all between.
    fn range(&self, [a, b]: [f64; 2]) -> RangeInclusive<usize> {
        self.at(a.min(b))..=self.at(a.max(b))
    }

    /// Adds an edge that leads from one height to another.
    pub fn add(&mut self, corner: u32, ends: [f64; 2]) {
        let range = self.range(ends);
        self.strips[range]
            .iter_mut()
            .for_each(|strip| strip.push(corner));
    }

    /// All edges that come between two heights, some of them more than once, and others.
    pub fn between(&self, heights: [f64; 2]) -> impl Iterator<Item = &u32> {
        self.strips[self.range(heights)].iter().flatten()
    }
}
