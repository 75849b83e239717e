//! Tiles: squares of the picture with a visibility buffer (depth and triangle
//! for each sample), each worked on by one thread at a time.

/// Width and height of a tile in pixels.
pub(crate) const TILE: usize = 64;
/// log2 of [`TILE`].
pub(crate) const TILE_BITS: u32 = 6;
/// Width and height of a block, whose pixels lie together in memory.
pub(crate) const BLOCK: usize = 4;
/// Blocks along a side of a tile.
pub(crate) const BLOCKS: usize = TILE / BLOCK;
/// Pixels of a block: one vector.
pub(crate) const BLOCK_PIXELS: usize = BLOCK * BLOCK;
/// The triangle number of pixels that show none.
pub(crate) const NO_TRIANGLE: i32 = i32::MAX;

/// The number of a sample that shows the cap of section plane `section` (in
/// 0..4) in front of the back of a triangle: negative, so that it cannot be a
/// triangle's.
pub(crate) fn capped(triangle: i32, section: usize) -> i32 {
    -1 - (triangle * 4 + section as i32 % 4)
}

/// The triangle and the section plane, if it is a cap, behind a sample's
/// number.
#[inline(always)]
pub(crate) fn decode(number: i32) -> (usize, Option<usize>) {
    if number >= 0 {
        (number as usize, None)
    } else {
        let code = (-1 - number) as usize;
        (code / 4, Some(code % 4))
    }
}

/// Depth (reversed: 1 near, 0 far) and triangle of one sample in each pixel.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    /// By block, row by row; 16 pixels a block, row by row.
    pub depth: Box<[[f32; BLOCK_PIXELS]; BLOCKS * BLOCKS]>,
    pub triangle: Box<[[i32; BLOCK_PIXELS]; BLOCKS * BLOCKS]>,
}

impl Plane {
    fn new() -> Self {
        Self {
            depth: Box::new([[0.0; BLOCK_PIXELS]; BLOCKS * BLOCKS]),
            triangle: Box::new([[NO_TRIANGLE; BLOCK_PIXELS]; BLOCKS * BLOCKS]),
        }
    }
}

/// The visibility buffer of one tile.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// One for each sample; none while nothing was drawn.
    pub planes: Vec<Plane>,
    /// Whether this frame drew here; if not, the planes hold old data.
    pub drawn: bool,
    /// A depth at or in front of which every sample of each 8x8 pixel square
    /// lies: what is farther is hidden (hierarchical depth).
    pub farthest: [f32; SQUARES * SQUARES],
    /// The same for the whole tile.
    pub farthest_of_all: f32,
}

/// Squares of hierarchical depth along a side of a tile.
pub(crate) const SQUARES: usize = TILE / 8;

impl Default for Tile {
    fn default() -> Self {
        Self {
            planes: Vec::new(),
            drawn: false,
            farthest: [0.0; SQUARES * SQUARES],
            farthest_of_all: 0.0,
        }
    }
}

impl Tile {
    /// Makes the tile ready for its first triangle of a frame, which leaves
    /// nothing of what is there if `covered`.
    pub fn begin(&mut self, samples: usize, covered: bool) {
        if self.planes.len() != samples {
            self.planes.clear();
            self.planes.resize_with(samples, Plane::new);
        } else if !covered {
            for plane in &mut self.planes {
                plane.depth.fill([0.0; BLOCK_PIXELS]);
                plane.triangle.fill([NO_TRIANGLE; BLOCK_PIXELS]);
            }
        }
        self.farthest = [0.0; SQUARES * SQUARES];
        self.farthest_of_all = 0.0;
        self.drawn = true;
    }

    /// Brings the hierarchical depth up to date.
    #[inline(always)]
    pub fn update_farthest(&mut self) {
        for (square, farthest) in self.farthest.iter_mut().enumerate() {
            let (sx, sy) = (square % SQUARES, square / SQUARES);
            let mut lanes = [f32::INFINITY; BLOCK_PIXELS];
            for plane in &self.planes {
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let block = &plane.depth[(sy * 2 + dy) * BLOCKS + sx * 2 + dx];
                    for (lane, z) in lanes.iter_mut().zip(block) {
                        *lane = if *z < *lane { *z } else { *lane };
                    }
                }
            }
            *farthest = lanes.into_iter().fold(f32::INFINITY, f32::min);
        }
        self.farthest_of_all = self.farthest.iter().copied().fold(f32::INFINITY, f32::min);
    }
}
