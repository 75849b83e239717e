//! Tiles: squares of the picture with a visibility buffer (depth and triangle
//! for each sample), each worked on by one thread at a time.

use std::sync::Mutex;

use crate::simd::{FloatLanes, IntLanes, Lanes, MaskLanes};
use crate::transparent::Fragment;

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

/// One value for one sample of each pixel of a tile: by block, row by row; 16
/// pixels a block, row by row.
pub(crate) type OfPixels<T> = [[T; BLOCK_PIXELS]; BLOCKS * BLOCKS];

/// The visibility buffer of a picture. Only tiles that are drawn have memory,
/// one after the other, so that few pages are touched, and large ones serve.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles {
    pub of_picture: Vec<Tile>,
    /// Samples a pixel that are kept.
    samples: usize,
    /// How many tiles have memory in this frame.
    used: usize,
    /// Reversed depth (1 near, 0 far), a plane for each of them of each tile.
    depth: Vec<OfPixels<f32>>,
    /// The triangle's number, likewise.
    triangle: Vec<OfPixels<i32>>,
    /// The winding, likewise, where it is counted.
    winding: Vec<OfPixels<i32>>,
    /// For each tile what is seen through, where anything is.
    fragments: Vec<Vec<Fragment>>,
}

/// What the tiles of a frame keep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Samples a pixel.
    pub samples: usize,
    /// Whether windings are counted.
    pub winding: bool,
    /// Whether anything is seen through.
    pub transparent: bool,
    /// Whether tiles of four samples or more are filled in blocks of 2x2 pixels.
    pub in_quads: bool,
}

impl Tiles {
    /// Makes room for so many tiles, none of them drawn.
    pub fn begin(&mut self, tiles: usize, layout: Layout) {
        let Layout {
            samples,
            winding,
            transparent,
            in_quads,
        } = layout;
        self.fragments.iter_mut().for_each(Vec::clear);
        let lists = if transparent { tiles } else { 0 };
        self.fragments.resize_with(lists, Vec::new);
        self.of_picture.clear();
        self.of_picture.resize_with(tiles, || Tile {
            in_quads,
            ..Tile::default()
        });
        (self.samples, self.used) = (samples, 0);
        if self.depth.len() != tiles * samples {
            // Zeros from the system, which the threads that draw touch first.
            self.depth = vec![[[0.0; BLOCK_PIXELS]; BLOCKS * BLOCKS]; tiles * samples];
            self.triangle = vec![[[0; BLOCK_PIXELS]; BLOCKS * BLOCKS]; tiles * samples];
        }
        let counted = if winding { tiles * samples } else { 0 };
        if self.winding.len() != counted {
            self.winding = vec![[[0; BLOCK_PIXELS]; BLOCKS * BLOCKS]; counted];
        }
    }

    /// All tiles, each for one thread; those that are wanted get memory, if
    /// they have none yet.
    pub fn buffers(&mut self, wanted: impl Fn(usize) -> bool) -> Vec<TileBuffer<'_>> {
        let samples = self.samples.max(1);
        let depth = self.depth.chunks_mut(samples);
        let triangle = self.triangle.chunks_mut(samples);
        let winding = self.winding.chunks_mut(samples).map(Some);
        let winding = winding.chain(std::iter::repeat_with(|| None));
        let mut planes: Vec<_> = depth.zip(triangle).zip(winding).collect();
        let used = &mut self.used;
        let mut fragments = self.fragments.iter_mut();
        self.of_picture
            .iter_mut()
            .enumerate()
            .map(|(index, tile)| {
                if tile.slot.is_none() && wanted(index) {
                    tile.slot = Some(*used);
                    *used += 1;
                }
                let own = tile.slot.and_then(|slot| planes.get_mut(slot));
                let ((depth, triangle), winding) = own.map(std::mem::take).unwrap_or_default();
                TileBuffer {
                    tile,
                    depth,
                    triangle,
                    winding: winding.unwrap_or_default(),
                    fragments: fragments.next(),
                }
            })
            .collect()
    }

    /// The depths of the first samples of a block of a tile, if anything was drawn in
    /// the tile.
    pub fn block_depths(&self, tile: usize, block: usize) -> Option<&[f32; BLOCK_PIXELS]> {
        let tile = self.of_picture.get(tile).filter(|tile| tile.drawn)?;
        self.depth.get(tile.slot? * self.samples)?.get(block)
    }

    /// Number and depth of the first sample of a pixel of a tile, if anything
    /// was drawn there.
    pub fn first_sample(&self, tile: usize, x: usize, y: usize) -> Option<(i32, f32)> {
        let tile = self.of_picture.get(tile).filter(|tile| tile.drawn)?;
        let plane = tile.slot? * self.samples;
        let block = y / BLOCK * BLOCKS + x / BLOCK;
        let lane = y % BLOCK * BLOCK + x % BLOCK;
        let number = self.triangle.get(plane)?.get(block)?[lane];
        (number != NO_TRIANGLE).then(|| (number, self.depth[plane][block][lane]))
    }
}

/// What is known of a tile without looking at its pixels.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// Where its planes are, once this frame may draw here.
    slot: Option<usize>,
    /// Whether blocks are 2x2 pixels of four samples each, not 4x4 of one, as
    /// long as the tile is filled.
    in_quads: bool,
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
            slot: None,
            in_quads: false,
            drawn: false,
            farthest: [0.0; SQUARES * SQUARES],
            farthest_of_all: 0.0,
        }
    }
}

/// The visibility buffer of one tile, while a thread works on it; without
/// planes where nothing is to be drawn.
pub(crate) struct TileBuffer<'a> {
    pub tile: &'a mut Tile,
    /// Reversed depth, a plane for each sample.
    pub depth: &'a mut [OfPixels<f32>],
    /// The triangle's number, likewise.
    pub triangle: &'a mut [OfPixels<i32>],
    /// How many more faces show their backs than their fronts at each sample,
    /// hidden ones included, likewise; or nothing, where that is not counted.
    pub winding: &'a mut [OfPixels<i32>],
    /// What is seen through, where anything may be.
    pub fragments: Option<&'a mut Vec<Fragment>>,
}

/// One sample of each pixel of a tile, or four, in blocks row by row.
pub(crate) struct Plane<'a> {
    pub depth: &'a mut [[f32; BLOCK_PIXELS]],
    pub triangle: &'a mut [[i32; BLOCK_PIXELS]],
    /// Nothing, where it is not counted.
    pub winding: &'a mut [[i32; BLOCK_PIXELS]],
}

/// Samples of each pixel in blocks of 2x2 pixels.
pub(crate) const SAMPLES_OF_QUAD: usize = 4;

/// The planes of one tile, for each sample.
#[derive(Debug, Default)]
pub(crate) struct Planes {
    depth: Vec<OfPixels<f32>>,
    triangle: Vec<OfPixels<i32>>,
    /// Nothing, where windings are not counted.
    winding: Vec<OfPixels<i32>>,
}

/// Planes that threads take while they work on a tile, and give back.
#[derive(Debug, Default)]
pub(crate) struct PlanePool(Mutex<Vec<Planes>>);

impl Clone for PlanePool {
    /// (What is there is nothing but memory.)
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PlanePool {
    /// Lends planes of so many samples, whatever they hold; with windings, if they
    /// are wanted.
    pub fn with<T>(
        &self,
        samples: usize,
        windings: bool,
        work: impl FnOnce(&mut Planes) -> T,
    ) -> T {
        let mut planes = match self.0.lock() {
            Ok(mut all) => all.pop().unwrap_or_default(),
            Err(_) => Planes::default(),
        };
        let none = [[0; BLOCK_PIXELS]; BLOCKS * BLOCKS];
        let nowhere = [[0.0; BLOCK_PIXELS]; BLOCKS * BLOCKS];
        planes.depth.resize(samples, nowhere);
        planes.triangle.resize(samples, none);
        let counted = if windings { samples } else { 0 };
        planes.winding.resize(counted, none);
        let result = work(&mut planes);
        if let Ok(mut all) = self.0.lock() {
            all.push(planes);
        }
        result
    }
}

impl TileBuffer<'_> {
    /// Whether anything is drawn in it.
    pub fn has_planes(&self) -> bool {
        !self.depth.is_empty()
    }

    /// Whether something is seen through.
    pub fn sees_through(&self) -> bool {
        self.fragments
            .as_ref()
            .is_some_and(|found| !found.is_empty())
    }

    /// The same tile, empty, on other planes. What is known of hidden depths
    /// still holds if all that was drawn is drawn again.
    pub fn on<'b>(&'b mut self, planes: &'b mut Planes) -> TileBuffer<'b> {
        if let Some(fragments) = &mut self.fragments {
            fragments.clear();
        }
        let known = (self.tile.farthest, self.tile.farthest_of_all);
        let mut other = TileBuffer {
            tile: self.tile,
            depth: &mut planes.depth,
            triangle: &mut planes.triangle,
            winding: &mut planes.winding,
            fragments: self.fragments.as_deref_mut(),
        };
        other.begin(false);
        (other.tile.farthest, other.tile.farthest_of_all) = known;
        other
    }

    /// Keeps the first sample of each pixel.
    pub fn keep_first(&mut self, planes: &Planes) {
        if let (Some(depth), Some(triangle)) = (self.depth.first_mut(), self.triangle.first_mut())
            && let (Some(from), Some(numbers)) = (planes.depth.first(), planes.triangle.first())
        {
            *depth = *from;
            *triangle = *numbers;
        }
    }

    /// Makes the tile ready for its first triangle of a frame, which leaves
    /// nothing of what is there if `covered`.
    pub fn begin(&mut self, covered: bool) {
        if !covered {
            self.depth.as_flattened_mut().fill([0.0; BLOCK_PIXELS]);
            let numbers = self.triangle.as_flattened_mut();
            numbers.fill([NO_TRIANGLE; BLOCK_PIXELS]);
        }
        self.winding.as_flattened_mut().fill([0; BLOCK_PIXELS]);
        *self.tile = Tile {
            slot: self.tile.slot,
            in_quads: self.tile.in_quads,
            drawn: true,
            ..Tile::default()
        };
    }

    /// Whether blocks are 2x2 pixels of four samples each, not 4x4 of one, as
    /// long as the tile is filled.
    pub fn in_quads(&self) -> bool {
        self.tile.in_quads && self.depth.len() >= SAMPLES_OF_QUAD
    }

    /// The planes, of one sample or of four.
    #[inline(always)]
    pub fn planes(&mut self) -> impl Iterator<Item = Plane<'_>> {
        let group = if self.in_quads() { SAMPLES_OF_QUAD } else { 1 };
        let mut winding = self.winding.chunks_mut(group);
        let planes = self.depth.chunks_mut(group);
        planes
            .zip(self.triangle.chunks_mut(group))
            .map(move |(depth, triangle)| Plane {
                depth: depth.as_flattened_mut(),
                triangle: triangle.as_flattened_mut(),
                winding: winding.next().unwrap_or_default().as_flattened_mut(),
            })
    }

    /// Leaves the first samples in the first plane, one of each pixel in blocks
    /// of 4x4, where they were in blocks of 2x2. (The others are lost.)
    pub fn part_first_samples(&mut self) {
        if self.in_quads() {
            part_first(self.depth.as_flattened_mut());
            part_first(self.triangle.as_flattened_mut());
        }
    }

    /// Brings the hierarchical depth up to date.
    #[inline(always)]
    pub fn update_farthest<S: Lanes>(&mut self, s: S) {
        let quads = self.in_quads();
        let (group, bits) = if quads { (SAMPLES_OF_QUAD, 2) } else { (1, 1) };
        for (square, farthest) in self.tile.farthest.iter_mut().enumerate() {
            let (sx, sy) = (square % SQUARES, square / SQUARES);
            let mut least = s.f(f32::INFINITY);
            for plane in self.depth.chunks(group) {
                let plane = plane.as_flattened();
                for dy in 0..1 << bits {
                    let first = (((sy << bits) + dy) << (3 + bits)) + (sx << bits);
                    for block in &plane[first..first + (1 << bits)] {
                        least = s.load_f(block).min(least);
                    }
                }
            }
            let mut lanes = [0.0; BLOCK_PIXELS];
            least.store(&mut lanes);
            *farthest = lanes.into_iter().fold(f32::INFINITY, f32::min);
        }
        let farthest = self.tile.farthest.iter().copied();
        self.tile.farthest_of_all = farthest.fold(f32::INFINITY, f32::min);
    }
}

/// Blocks of 2x2 pixels along a side of a tile.
const QUADS: usize = TILE / 2;

/// One of four samples of 4x4 pixels, from their blocks of 2x2.
#[inline(always)]
fn part<T: Copy + Default>(quads: [&[T; BLOCK_PIXELS]; 4], sample: usize) -> [T; BLOCK_PIXELS] {
    let mut lanes = [T::default(); BLOCK_PIXELS];
    for (k, pair) in lanes.as_chunks_mut::<2>().0.iter_mut().enumerate() {
        let (x, y) = (k % 2, k / 2);
        let first = sample * 4 + y % 2 * 2;
        pair.copy_from_slice(&quads[y / 2 * 2 + x][first..first + 2]);
    }
    lanes
}

/// The blocks of 2x2 pixels of a block of 4x4.
#[inline(always)]
fn quads_of<T>(quads: &[[T; BLOCK_PIXELS]], block: usize) -> Option<[&[T; BLOCK_PIXELS]; 4]> {
    let first = block / BLOCKS * 2 * QUADS + block % BLOCKS * 2;
    let (above, below) = (quads.get(first..)?, quads.get(first + QUADS..)?);
    let ([a, b, ..], [c, d, ..]) = (above, below) else {
        return None;
    };
    Some([a, b, c, d])
}

/// Writes the first samples to the first blocks. (None is read after that.)
fn part_first<T: Copy + Default>(quads: &mut [[T; BLOCK_PIXELS]]) {
    for block in 0..BLOCKS * BLOCKS {
        if let Some(four) = quads_of(quads, block) {
            quads[block] = part(four, 0);
        }
    }
}

/// Most samples of a pixel.
pub(crate) const MOST_SAMPLES: usize = 8;

/// The triangles of a block of 4x4 pixels, for each sample, from blocks of 2x2.
#[inline(always)]
pub(crate) fn part_block<S: Lanes>(
    s: S,
    planes: &[OfPixels<i32>],
    block: usize,
) -> [[i32; BLOCK_PIXELS]; MOST_SAMPLES] {
    let mut parted = [[NO_TRIANGLE; BLOCK_PIXELS]; MOST_SAMPLES];
    let groups = planes.chunks(SAMPLES_OF_QUAD);
    for (group, parted) in groups.zip(parted.chunks_mut(SAMPLES_OF_QUAD)) {
        let Some(four) = quads_of(group.as_flattened(), block) else {
            continue;
        };
        // Mostly they show one triangle, or nothing.
        let one = four[0][0];
        let mut alike = 0xffff;
        for quad in four {
            alike &= s.load_i(quad).eq(s.i(one)).bits();
        }
        for (sample, to) in parted.iter_mut().enumerate() {
            *to = if alike == 0xffff {
                [one; BLOCK_PIXELS]
            } else {
                part(four, sample)
            };
        }
    }
    parted
}
