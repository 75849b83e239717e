//! What a frame did, and what it did not have to do.

use std::fmt;

/// Counts of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// Clusters of the scene.
    pub clusters: u64,
    /// Of these, outside the view volume.
    pub clusters_outside: u64,
    /// Of these, with no triangle facing the viewer.
    pub clusters_facing_away: u64,
    /// Of these, behind what was already drawn.
    pub clusters_hidden: u64,
    /// Vertices transformed.
    pub vertices_transformed: u64,
    /// Triangles of the scene.
    pub triangles: u64,
    /// Triangles of the clusters that were left.
    pub triangles_looked_at: u64,
    /// Of these, facing away or without area.
    pub triangles_facing_away: u64,
    /// Of these, without a sample inside the picture.
    pub triangles_without_sample: u64,
    /// Of these, clipped at the near or far plane or the guard band.
    pub triangles_clipped: u64,
    /// Larger triangles set up for filling (pieces count, after clipping).
    pub triangles_set_up: u64,
    /// Triangles of up to 4x4 pixels, filled as they were set up.
    pub triangles_tiny: u64,
    /// The pixels they cover.
    pub tiny_pixels: u64,
    /// Pairs of a triangle and a tile it may touch.
    pub bin_entries: u64,
    /// Of these pairs, behind what was already drawn.
    pub bin_entries_hidden: u64,
    /// Blocks of 4x4 samples looked at by the filler.
    pub blocks: u64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Of these, with nothing drawn.
    pub tiles_empty: u64,
    /// Pixels shaded.
    pub pixels_shaded: u64,
}

impl fmt::Display for Stats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, count) in [
            ("clusters", self.clusters),
            ("  outside the view", self.clusters_outside),
            ("  facing away", self.clusters_facing_away),
            ("  hidden", self.clusters_hidden),
            ("vertices transformed", self.vertices_transformed),
            ("triangles", self.triangles),
            ("  looked at", self.triangles_looked_at),
            ("  facing away", self.triangles_facing_away),
            ("  without a sample", self.triangles_without_sample),
            ("  clipped", self.triangles_clipped),
            ("  set up", self.triangles_set_up),
            ("  tiny", self.triangles_tiny),
            ("pixels of tiny ones", self.tiny_pixels),
            ("bin entries", self.bin_entries),
            ("  hidden", self.bin_entries_hidden),
            ("blocks filled", self.blocks),
            ("tiles", self.tiles),
            ("  empty", self.tiles_empty),
            ("pixels shaded", self.pixels_shaded),
        ] {
            writeln!(f, "{name:<22}{count:>12}")?;
        }
        Ok(())
    }
}
