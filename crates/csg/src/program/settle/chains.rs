//! Chains of surfaces each of which nearly coincides with the next.

use glam::DVec3;

use crate::program::Surface;

/// Which surfaces are linked, by the first of each chain found so far.
pub(super) struct Chains {
    parent: Vec<u32>,
}

impl Chains {
    pub fn of(surfaces: &[Surface], reach: f64, within: f64) -> Self {
        /// Where surfaces are evaluated to be sorted, in reaches: no surface of a
        /// symmetric model is at the same distance as another one's mirror image.
        const PROBE: DVec3 = DVec3::new(0.302_775_638, 0.414_213_562, -0.236_067_978);
        let mut chains = Self {
            parent: (0..surfaces.len() as u32).collect(),
        };
        let probe = reach * PROBE;
        let mut by_value: Vec<(bool, f64, u32)> = (0..)
            .zip(surfaces)
            .map(|(index, surface)| (surface.is_plane(), surface.value(probe).abs(), index))
            .collect();
        by_value.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for (rank, &(is_plane, value, index)) in by_value.iter().enumerate() {
            let one = &surfaces[index as usize];
            // By how much values differ there at most, to first order and twice.
            let slope = if is_plane {
                1.0
            } else {
                one.gradient(probe).length() + 6.0 * (one.anchor.length() + reach)
            };
            let most = 2.0 * within * slope;
            let close = by_value[rank + 1..]
                .iter()
                .take_while(|other| other.0 == is_plane && other.1 - value <= most);
            for &(_, _, other) in close {
                if one.distance_bound(&surfaces[other as usize], reach) <= within {
                    chains.link(index, other);
                }
            }
        }
        chains
    }

    fn first(&mut self, mut index: u32) -> u32 {
        while self.parent[index as usize] != index {
            let above = self.parent[self.parent[index as usize] as usize];
            self.parent[index as usize] = above;
            index = above;
        }
        index
    }

    fn link(&mut self, a: u32, b: u32) {
        let [a, b] = [self.first(a), self.first(b)];
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The chains of several surfaces, ascending.
    pub fn longer_than_one(mut self) -> Vec<Vec<u32>> {
        let count = self.parent.len() as u32;
        let mut pairs: Vec<(u32, u32)> = (0..count).map(|k| (self.first(k), k)).collect();
        pairs.sort_unstable();
        let chains = pairs.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() > 1);
        chains
            .map(|c| c.iter().map(|pair| pair.1).collect())
            .collect()
    }
}
