//! The fast filler: triangles by edge functions, 16 pixels at a time.
//!
//! An edge function (see [`fixed`](crate::fixed)) is linear, and samples are
//! 256 sub-pixels apart, so at the sample (i, j) of a tile it is
//! `c + 256 (dx j - dy i)`. It is not negative exactly if
//! `floor(c / 256) + dx j - dy i` is not: shifting c right by 8 bits loses nothing, and leaves numbers
//! that fit 32 bits for triangles of any size within the guard band. c itself
//! is computed in 32 bits for triangles of less than 64 pixels, in 64 for
//! larger ones. The top-left rule subtracts 1 from c beforehand at the edges
//! that do not own their samples.

use crate::fixed::SUBPIXEL_BITS;
use crate::simd::{FloatLanes, IntLanes, Lanes, MaskLanes, triple};
use crate::tile::{BLOCK, BLOCKS, Plane, SQUARES, TILE, Tile};

/// A triangle set up for filling: oriented clockwise as seen (y downwards).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record {
    /// Corners in sub-pixels from the picture's top left corner.
    pub x: [i32; 3],
    pub y: [i32; 3],
    /// Reversed depth at the first corner.
    pub z: f32,
    /// Its change for one sub-pixel right and down.
    pub dz: [f32; 2],
    /// Least and greatest depth of the corners.
    pub z_low: f32,
    pub z_high: f32,
    /// Number of the triangle in drawing order.
    pub triangle: i32,
}

/// Extents below this many sub-pixels keep edge functions inside a tile
/// within 32 bits.
pub(crate) const SMALL: i32 = (TILE as i32) << SUBPIXEL_BITS;

/// The sub-pixel positions, from a pixel's corner, of its samples.
pub(crate) const CENTRE_SAMPLE: [[i32; 2]; 1] = [[128, 128]];

/// Counts of a filler's work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FillCounts {
    /// Triangles that hierarchical depth hid.
    pub hidden: u64,
    /// Blocks of 4x4 samples looked at.
    pub blocks: u64,
}

/// What the filler needs of the three edges: c >> 8 at the tile's first
/// pixel, and the change for one pixel right and down.
struct Edges {
    c: [i32; 3],
    right: [i32; 3],
    down: [i32; 3],
}

/// Fills one triangle into every sample plane of a tile whose first pixel is
/// `origin`, a picture of `size`.
#[inline(always)]
pub(crate) fn fill<S: Lanes>(
    s: S,
    tile: &mut Tile,
    origin: [i32; 2],
    size: [i32; 2],
    record: &Record,
    samples: &[[i32; 2]],
    counts: &mut FillCounts,
) {
    // The pixels that may have a sample inside, within the tile.
    let last = TILE as i32 - 1;
    let (first_sample, last_sample) = if samples.len() == 1 {
        (128, 128)
    } else {
        (0, 255)
    };
    let range = |v: [i32; 3], axis: usize| {
        let low = v[0].min(v[1]).min(v[2]);
        let high = v[0].max(v[1]).max(v[2]);
        let limit = last.min(size[axis] - 1 - origin[axis]);
        (
            (((low - last_sample + 255) >> SUBPIXEL_BITS) - origin[axis]).max(0),
            (((high - first_sample) >> SUBPIXEL_BITS) - origin[axis]).min(limit),
            high - low,
        )
    };
    let (x0, x1, width) = range(record.x, 0);
    let (y0, y1, height) = range(record.y, 1);
    if x0 > x1 || y0 > y1 {
        return;
    }
    // Hierarchical depth: hidden if every 8x8 square it touches is nearer.
    let mut hidden = true;
    for square_y in y0 >> 3..=y1 >> 3 {
        for square_x in x0 >> 3..=x1 >> 3 {
            let square = square_y as usize * SQUARES + square_x as usize;
            hidden &= record.z_high < tile.farthest[square];
        }
    }
    if hidden {
        counts.hidden += 1;
        return;
    }
    let small = width < SMALL && height < SMALL;
    let (z_low, z_high) = (s.f(record.z_low), s.f(record.z_high));
    for (plane, sample) in tile.planes.iter_mut().zip(samples) {
        let start = [
            (origin[0] << SUBPIXEL_BITS) + sample[0],
            (origin[1] << SUBPIXEL_BITS) + sample[1],
        ];
        let edges = set_up(record, start, small);
        fill_plane(
            s,
            plane,
            &edges,
            [x0, x1, y0, y1],
            DepthPlane {
                z: s.f(record.z),
                dx: s.f(record.dz[0]),
                dy: s.f(record.dz[1]),
                x: (start[0] - record.x[0]) as f32,
                y: (start[1] - record.y[0]) as f32,
                low: z_low,
                high: z_high,
            },
            record.triangle,
            counts,
        );
    }
}

/// Depth over a tile: z at a corner, slopes, and the distance of the tile's
/// first sample from that corner.
#[derive(Clone, Copy)]
struct DepthPlane<S: Lanes> {
    z: S::F,
    dx: S::F,
    dy: S::F,
    x: f32,
    y: f32,
    low: S::F,
    high: S::F,
}

#[inline(always)]
fn set_up(record: &Record, start: [i32; 2], small: bool) -> Edges {
    let mut edges = Edges {
        c: [0; 3],
        right: [0; 3],
        down: [0; 3],
    };
    for (k, next) in [1, 2, 0].into_iter().enumerate() {
        let dx = record.x[next] - record.x[k];
        let dy = record.y[next] - record.y[k];
        let (px, py) = (start[0] - record.x[k], start[1] - record.y[k]);
        let own = dy < 0 || (dy == 0 && dx > 0);
        let bias = i32::from(!own);
        edges.c[k] = if small {
            (dx * py - dy * px - bias) >> SUBPIXEL_BITS
        } else {
            let c = i64::from(dx) * i64::from(py) - i64::from(dy) * i64::from(px);
            let c = (c - i64::from(bias)) >> SUBPIXEL_BITS;
            // Beyond this the sign cannot change within a tile.
            c.clamp(-(1 << 30), 1 << 30) as i32
        };
        edges.right[k] = -dy;
        edges.down[k] = dx;
    }
    edges
}

/// Column and row of each lane in its block.
pub(crate) const LANE_X: [i32; 16] = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3];
pub(crate) const LANE_Y: [i32; 16] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

#[inline(always)]
fn fill_plane<S: Lanes>(
    s: S,
    plane: &mut Plane,
    edges: &Edges,
    [x0, x1, y0, y1]: [i32; 4],
    depth: DepthPlane<S>,
    triangle: i32,
    counts: &mut FillCounts,
) {
    let block = BLOCK as i32;
    let (bx0, bx1, by0, by1) = (x0 / block, x1 / block, y0 / block, y1 / block);
    let (lane_x, lane_y) = (s.load_i(&LANE_X), s.load_i(&LANE_Y));
    let (right, down) = (edges.right, edges.down);
    let zero = s.i(0);
    let id = s.i(triangle);
    let mut row = triple!(|K| {
        let c = edges.c[K]
            .wrapping_add(right[K].wrapping_mul(bx0 * block))
            .wrapping_add(down[K].wrapping_mul(by0 * block));
        s.i(c) + s.i(right[K]) * lane_x + s.i(down[K]) * lane_y
    });
    let step = triple!(|K| s.i(right[K] * block));
    let step_down = triple!(|K| s.i(down[K] * block));
    let sub_x = (lane_x.shl::<8>()).to_float() + s.f(depth.x);
    let sub_y = (lane_y.shl::<8>()).to_float() + s.f(depth.y);
    for by in by0..=by1 {
        let mut e = row;
        let zy = depth.dy * (sub_y + s.f((by * block * 256) as f32));
        for bx in bx0..=bx1 {
            counts.blocks += 1;
            let outside = (e[0] | e[1] | e[2]).lt(zero);
            if outside.bits() != 0xffff {
                let index = by as usize * BLOCKS + bx as usize;
                let zx = depth.dx * (sub_x + s.f((bx * block * 256) as f32));
                let z = (depth.z + (zx + zy)).max(depth.low).min(depth.high);
                let (depths, triangles) = (&mut plane.depth[index], &mut plane.triangle[index]);
                let old = s.load_f(depths);
                let old_id = s.load_i(triangles);
                // Equal depths go to the triangle drawn first.
                let nearer = old.lt(z) | (old.eq(z) & id.lt(old_id));
                let pass = nearer & !outside;
                pass.select_f(z, old).store(depths);
                pass.select_i(id, old_id).store(triangles);
            }
            e = [e[0] + step[0], e[1] + step[1], e[2] + step[2]];
        }
        row = [
            row[0] + step_down[0],
            row[1] + step_down[1],
            row[2] + step_down[2],
        ];
    }
}
