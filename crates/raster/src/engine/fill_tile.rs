//! Kernels that work on one tile: what a batch of triangles leaves in it.

use crate::fill::{FillCounts, Lattice, fill, fill_pixels};
use crate::geometry::Bins;
use crate::simd::{Kernel, Lanes};
use crate::tile::TileBuffer;
use crate::transparent::collect;

/// Whether there is anything to be filled into a tile.
pub(crate) fn any_in(bins: &[Bins], tile: usize) -> bool {
    bins.iter().any(|bins| {
        let records = !bins.tiles[tile].is_empty() || !bins.transparent[tile].is_empty();
        records || !bins.pixels[tile].is_empty()
    })
}

/// Brings the hierarchical depth of one tile up to date.
pub(crate) struct UpdateFarthest<'a, 'b> {
    pub tile: &'a mut TileBuffer<'b>,
}

impl Kernel for UpdateFarthest<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        self.tile.update_farthest(s);
    }
}

/// Fills the triangles of one batch into one tile.
pub(crate) struct FillTile<'a, 'b> {
    pub tile: &'a mut TileBuffer<'b>,
    pub index: usize,
    pub bins: &'a [Bins],
    pub origin: [i32; 2],
    pub samples: &'static [[i32; 2]],
}

impl Kernel for FillTile<'_, '_> {
    type Output = FillCounts;
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) -> FillCounts {
        let mut counts = FillCounts::default();
        let lattices = Lattice::of(self.samples, self.tile.in_quads());
        for bins in self.bins {
            let pixels = &bins.pixels[self.index];
            if !pixels.is_empty() {
                if !self.tile.tile.drawn {
                    self.tile.begin(false);
                }
                counts.any = true;
                fill_pixels(self.tile, pixels);
            }
            for &entry in &bins.tiles[self.index] {
                counts.any = true;
                let record = &bins.records[entry as usize];
                fill(s, self.tile, self.origin, record, &lattices, &mut counts);
            }
            let transparent = &bins.transparent[self.index];
            if !transparent.is_empty() {
                if !self.tile.tile.drawn {
                    self.tile.begin(false);
                }
                counts.any = true;
                let records = transparent
                    .iter()
                    .map(|&entry| &bins.records[entry as usize]);
                collect(self.tile, self.origin, records, self.samples);
            }
        }
        counts
    }
}
