//! Triangle set-up: from the corners in raster space to edge functions and a
//! depth plane, sorted into the tiles that the triangle touches.
//!
//! Sixteen triangles at a time while they are small; the few large ones one by
//! one.

use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::fill::{PixelOfTriangle, Record, STEEP};
use crate::fixed::{SUBPIXEL_BITS, SUBPIXELS, doubled_area, edge, is_top_left};
use crate::geometry::{Bins, GeometryContext};
use crate::simd::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};
use crate::tile::TILE_BITS;

/// Triangles whose boxes have at most so many pixels either way are filled at
/// once, 16 triangles and one pixel of each at a time; there is less to do
/// than to prepare 16 pixels of one triangle. (With several samples a pixel
/// they are filled like all others, and so are those that count windings.)
const TINY: i32 = 4;

/// Triangles of so many sub-pixels or more either way are set up one by one:
/// below, edge functions within the triangle's box fit 32 bits.
const LARGE: i32 = 1 << 15;

/// First and last pixel with a sample between two sub-pixel positions, inside
/// a picture of `size`.
#[inline(always)]
fn pixel_range<S: Lanes>(
    s: S,
    low: S::I,
    high: S::I,
    size: u32,
    [first_sample, last_sample]: [i32; 2],
) -> (S::I, S::I) {
    (
        (low + s.i(255 - last_sample)).shr::<8>().max(s.i(0)),
        (high - s.i(first_sample))
            .shr::<8>()
            .min(s.i(size.cast_signed() - 1)),
    )
}

/// The corners of 16 triangles: by corner, then by triangle. X and Y in
/// sub-pixels from the middle of the picture, not snapped; reversed depth.
#[derive(Default)]
pub(crate) struct RasterCorners {
    pub x: [[f64; LANES]; 3],
    pub y: [[f64; LANES]; 3],
    pub z: [[f32; LANES]; 3],
}

/// All pixels that 16 tiny triangles can have.
pub(crate) const MOST_PIXELS: usize = LANES * (TINY * TINY) as usize;

/// What is found of 16 triangles, as vectors: see [`Record`] for each.
struct SetUp<S: Lanes> {
    c: [S::I; 3],
    right: [S::I; 3],
    down: [S::I; 3],
    /// First and last column, first and last row.
    range: [S::I; 4],
    anchor: [S::F; 2],
    z: S::F,
    slope: [S::F; 2],
    /// Least and greatest.
    z_range: [S::F; 2],
}

/// The same, stored to be taken apart.
#[derive(Default)]
pub(crate) struct Stored {
    c: [[i32; LANES]; 3],
    right: [[i32; LANES]; 3],
    down: [[i32; LANES]; 3],
    range: [[i32; LANES]; 4],
    anchor: [[f32; LANES]; 2],
    z: [f32; LANES],
    slope: [[f32; LANES]; 2],
    z_range: [[f32; LANES]; 2],
}

impl<S: Lanes> SetUp<S> {
    #[inline(always)]
    fn store(&self, to: &mut Stored) {
        for k in 0..3 {
            self.c[k].store(&mut to.c[k]);
            self.right[k].store(&mut to.right[k]);
            self.down[k].store(&mut to.down[k]);
        }
        for k in 0..4 {
            self.range[k].store(&mut to.range[k]);
        }
        for k in 0..2 {
            self.anchor[k].store(&mut to.anchor[k]);
            self.slope[k].store(&mut to.slope[k]);
            self.z_range[k].store(&mut to.z_range[k]);
        }
        self.z.store(&mut to.z);
    }
}

/// Sets up those of 16 triangles whose bits are in `present`.
#[inline(always)]
pub(crate) fn set_up_triangles<S: Lanes>(
    s: S,
    corners: &RasterCorners,
    first: usize,
    present: u32,
    context: &GeometryContext,
    stored: &mut Stored,
    bins: &mut Bins,
) {
    let matrix = context.matrix;
    let x = triple!(|K| s.load_d(&corners.x[K]));
    let y = triple!(|K| s.load_d(&corners.y[K]));
    let snapped_x = triple!(|K| x[K].round());
    let snapped_y = triple!(|K| y[K].round());
    let [middle_x, middle_y] = [s.i(matrix.middle[0]), s.i(matrix.middle[1])];
    let vx = triple!(|K| snapped_x[K] + middle_x);
    let vy = triple!(|K| snapped_y[K] + middle_y);
    let (low_x, high_x) = (vx[0].min(vx[1]).min(vx[2]), vx[0].max(vx[1]).max(vx[2]));
    let (low_y, high_y) = (vy[0].min(vy[1]).min(vy[2]), vy[0].max(vy[1]).max(vy[2]));
    // Pixels with a sample between the extremes, inside the picture.
    let zero = s.i(0);
    let (px0, px1) = pixel_range(s, low_x, high_x, matrix.width, context.sample_range);
    let (py0, py1) = pixel_range(s, low_y, high_y, matrix.height, context.sample_range);
    let empty = (px1.lt(px0) | py1.lt(py0)).bits();
    let limit = s.i(LARGE);
    let large = !((high_x - low_x).lt(limit) & (high_y - low_y).lt(limit)).bits();
    let dx = [vx[1] - vx[0], vx[2] - vx[1], vx[0] - vx[2]];
    let dy = [vy[1] - vy[0], vy[2] - vy[1], vy[0] - vy[2]];
    let area = dx[2] * dy[0] - dx[0] * dy[2];
    let front = zero.lt(area * s.i(matrix.orientation)).bits();
    let flat = area.eq(zero).bits();
    let wanted = (if context.facing.front { front } else { 0 })
        | (if context.facing.back {
            !front & !flat
        } else {
            0
        });
    bins.counts.no_sample += u64::from((present & empty).count_ones());
    let small = present & !empty & !large;
    bins.counts.facing_away += u64::from((small & !wanted).count_ones());
    let mut survivors = small & wanted;
    let mut big = present & !empty & large;
    if survivors != 0 {
        // Edge functions, for corners taken clockwise, at the corner of the
        // first pixel.
        let clockwise = zero.lt(area);
        let (from_x, from_y) = (px0.shl::<8>(), py0.shl::<8>());
        let dx = triple!(|K| clockwise.select_i(dx[K], zero - dx[K]));
        let dy = triple!(|K| clockwise.select_i(dy[K], zero - dy[K]));
        let c = triple!(|K| {
            let own = dy[K].lt(zero) | (dy[K].eq(zero) & zero.lt(dx[K]));
            let bias = own.select_i(zero, s.i(1));
            dx[K] * (from_y - vy[K]) - dy[K] * (from_x - vx[K]) - bias
        });
        // Depth is a plane through the corners where they are, not where they
        // were snapped to (but see `GeometryContext::is_cut`); unless a
        // sliver has no area there. In double precision: steep faces turn
        // little errors of positions into large ones of depth.
        let z = triple!(|K| s.load_f(&corners.z[K]));
        let (x, y) = if context.is_cut() {
            (
                triple!(|K| snapped_x[K].to_double()),
                triple!(|K| snapped_y[K].to_double()),
            )
        } else {
            (x, y)
        };
        let dz1 = z[1].to_double() - z[0].to_double();
        let dz2 = z[2].to_double() - z[0].to_double();
        let (dx1, dy1) = (x[1] - x[0], y[1] - y[0]);
        let (dx2, dy2) = (x[2] - x[0], y[2] - y[0]);
        let exact_area = dx1 * dy2 - dx2 * dy1;
        let inverse = s.d(1.0) / exact_area;
        let right = ((dz1 * dy2 - dz2 * dy1) * inverse).to_single();
        let down = ((dz2 * dx1 - dz1 * dx2) * inverse).to_single();
        let snapped_area = area.to_float();
        let (zero_f, half) = (s.f(0.0), s.f(0.5));
        let sound = zero_f.lt((exact_area.to_single() - half * snapped_area) * snapped_area);
        let right = sound.select_f(right, zero_f);
        let down = sound.select_f(down, zero_f);
        let most = right.max(zero_f - right).max(down.max(zero_f - down));
        let steep = survivors & s.f(STEEP).lt(most).bits();
        survivors &= !steep;
        big |= steep;
        let left_x = (x[0] - snapped_x[0].to_double()).to_single();
        let left_y = (y[0] - snapped_y[0].to_double()).to_single();
        // Snapping moves a corner by at most half a sub-pixel each way.
        let slack = right.max(zero_f - right) + down.max(zero_f - down);
        let (z_low, z_high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
        let found = SetUp::<S> {
            c,
            right: triple!(|K| zero - dy[K]),
            down: dx,
            range: [px0, px1, py0, py1],
            anchor: [(vx[0] - from_x).to_float(), (vy[0] - from_y).to_float()],
            z: z[0] - (right * left_x + down * left_y),
            slope: [right, down],
            z_range: [(z_low - slack).max(zero_f), z_high + slack],
        };
        let at_once = !context.is_cut() && context.transparent.is_none();
        if context.sample_range[0] == context.sample_range[1] && at_once {
            let tiny = s.i(TINY);
            let tiny = survivors & (px1 - px0).lt(tiny).bits() & (py1 - py0).lt(tiny).bits();
            survivors &= !tiny;
            find_pixels(s, &found, first, tiny, context, bins);
        }
        if survivors != 0 {
            found.store(stored);
        }
        while survivors != 0 {
            let k = (survivors.trailing_zeros() as usize) % LANES;
            survivors &= survivors - 1;
            let record = Record {
                c: triple!(|K| i64::from(stored.c[K][k])),
                right: triple!(|K| stored.right[K][k]),
                down: triple!(|K| stored.down[K][k]),
                x: [stored.range[0][k] as i16, stored.range[1][k] as i16],
                y: [stored.range[2][k] as i16, stored.range[3][k] as i16],
                anchor: [stored.anchor[0][k], stored.anchor[1][k]],
                z: f64::from(stored.z[k]),
                slope: [0, 1].map(|axis| f64::from(stored.slope[axis][k])),
                z_low: stored.z_range[0][k],
                z_high: stored.z_range[1][k],
                triangle: (first + k) as i32,
                winding: if front >> k & 1 != 0 { -1 } else { 1 },
            };
            push(record, context, bins);
        }
    }
    while big != 0 {
        let k = (big.trailing_zeros() as usize) % LANES;
        big &= big - 1;
        let corners = [0, 1, 2]
            .map(|c| DVec3::new(corners.x[c][k], corners.y[c][k], f64::from(corners.z[c][k])));
        let plane = corner_plane(corners.map(|p| context.depth_corner(p)));
        set_up_one(corners, plane, first + k, context, bins);
    }
}

/// Finds the pixels of those of 16 triangles whose bits are in `tiny`, one
/// position in their boxes after the other.
#[inline(always)]
fn find_pixels<S: Lanes>(
    s: S,
    found: &SetUp<S>,
    first: usize,
    tiny: u32,
    context: &GeometryContext,
    bins: &mut Bins,
) {
    bins.counts.tiny += u64::from(tiny.count_ones());
    bins.make_room();
    let zero = s.i(0);
    let half = s.i(SUBPIXELS / 2);
    let (right, down) = (found.right, found.down);
    let mut row = triple!(|K| (found.c[K] + (right[K] + down[K]) * half).shr::<8>());
    let ([slope_x, slope_y], [low, high]) = (found.slope, found.z_range);
    let [px0, px1, py0, py1] = found.range;
    let columns = s.i(context.columns as i32);
    let low_bits = s.i(3);
    for j in 0..TINY {
        let y = py0 + s.i(j);
        let in_rows = tiny & !py1.lt(y).bits();
        if in_rows == 0 {
            break;
        }
        let sub_y = s.f((j * SUBPIXELS + SUBPIXELS / 2) as f32) - found.anchor[1];
        let mut e = row;
        for i in 0..TINY {
            let x = px0 + s.i(i);
            let in_box = in_rows & !px1.lt(x).bits();
            if in_box == 0 {
                break;
            }
            let mut inside = in_box & !(e[0] | e[1] | e[2]).lt(zero).bits();
            e = triple!(|K| e[K] + right[K]);
            if inside == 0 {
                continue;
            }
            let sub_x = s.f((i * SUBPIXELS + SUBPIXELS / 2) as f32) - found.anchor[0];
            let depth = (found.z + (slope_x * sub_x + slope_y * sub_y))
                .max(low)
                .min(high);
            let tile = y.shr::<6>() * columns + x.shr::<6>();
            let block = (y.shr::<2>() & s.i(15)).shl::<4>() | (x.shr::<2>() & s.i(15));
            let lane = (y & low_bits).shl::<2>() | (x & low_bits);
            let (mut depths, mut tiles, mut pixels) = ([0.0; LANES], [0; LANES], [0; LANES]);
            depth.store(&mut depths);
            tile.store(&mut tiles);
            (block.shl::<4>() | lane).store(&mut pixels);
            while inside != 0 {
                let k = (inside.trailing_zeros() as usize) % LANES;
                inside &= inside - 1;
                let pixel = PixelOfTriangle {
                    pixel: pixels[k] as u32,
                    depth: depths[k],
                    triangle: (first + k) as i32,
                };
                bins.push_pixel(tiles[k], pixel);
            }
        }
        row = triple!(|K| row[K] + down[K]);
    }
}

/// Sorts a record into the tiles that its box of pixels touches.
#[inline(always)]
fn push(record: Record, context: &GeometryContext, bins: &mut Bins) {
    let mut is_transparent = false;
    if let Some((shading, culls)) = context.transparent {
        is_transparent = shading.opacity(record.triangle as usize) < 1.0;
        if !is_transparent && culls && record.winding > 0 {
            return;
        }
    }
    let index = bins.records.len() as u32;
    let [tx0, tx1] = record.x.map(|v| (v >> TILE_BITS) as usize);
    let [ty0, ty1] = record.y.map(|v| (v >> TILE_BITS) as usize);
    bins.records.push(record);
    for ty in ty0..=ty1 {
        for tx in tx0..=tx1 {
            let tiles = if is_transparent {
                &mut bins.transparent
            } else {
                &mut bins.tiles
            };
            if let Some(tile) = tiles.get_mut(ty * context.columns + tx) {
                tile.push(index);
            }
        }
    }
}

/// The depth of a triangle's plane: at a point, in sub-pixels from the middle
/// of the picture, and its change for one sub-pixel right and down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthPlane {
    at: DVec2,
    z: f64,
    slope: DVec2,
}

/// The plane with Z/W = a X/W + b Y/W + c through a triangle's corners in
/// raster space, before clipping; `None` if it is seen edge-on.
pub(crate) fn depth_plane([p, q, r]: [DVec4; 3]) -> Option<DepthPlane> {
    let window = |v: DVec4| DVec3::new(v.x, v.y, v.w);
    let matrix = DMat3::from_cols(window(p), window(q), window(r)).transpose();
    let plane = matrix.inverse() * DVec3::new(p.z, q.z, r.z);
    (matrix.determinant() != 0.0 && plane.is_finite()).then_some(DepthPlane {
        at: DVec2::ZERO,
        z: plane.z,
        slope: plane.truncate(),
    })
}

/// The plane through corners after the division. From differences to one of
/// them, which keeps slivers far from the middle of the picture exact; `None`
/// if one has less than half of its area before its corners are snapped.
pub(crate) fn corner_plane([p, q, r]: [DVec3; 3]) -> Option<DepthPlane> {
    let (d1, d2) = (q - p, r - p);
    let area = d1.x * d2.y - d2.x * d1.y;
    let [p0, q0, r0] = [p, q, r].map(|v| v.truncate().round());
    let snapped = (q0 - p0).perp_dot(r0 - p0);
    let slope = DVec2::new(d1.z * d2.y - d2.z * d1.y, d2.z * d1.x - d1.z * d2.x) / area;
    ((area - snapped / 2.0) * snapped > 0.0 && slope.is_finite()).then_some(DepthPlane {
        at: p.truncate(),
        z: p.z,
        slope,
    })
}

/// Sets up one triangle of any size. Corners are in the order 0, 2, 1, in
/// sub-pixels from the middle of the picture, with their depths.
pub(crate) fn set_up_one(
    corners: [DVec3; 3],
    plane: Option<DepthPlane>,
    triangle: usize,
    context: &GeometryContext,
    bins: &mut Bins,
) {
    let matrix = context.matrix;
    let mut points = corners.map(|p| {
        [
            p.x.round_ties_even() as i32 + matrix.middle[0],
            p.y.round_ties_even() as i32 + matrix.middle[1],
        ]
    });
    let area = doubled_area(points);
    let front = area * i64::from(matrix.orientation) > 0;
    let wanted = if front {
        context.facing.front
    } else {
        context.facing.back
    };
    if area == 0 || !wanted {
        bins.counts.facing_away += 1;
        return;
    }
    if area < 0 {
        points.swap(1, 2);
    }
    let [first_sample, last_sample] = context.sample_range;
    let range = |axis: usize, size: u32| {
        let v = points.map(|p| p[axis]);
        let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
        [
            ((low + 255 - last_sample) >> SUBPIXEL_BITS).max(0),
            ((high - first_sample) >> SUBPIXEL_BITS).min(size.cast_signed() - 1),
        ]
    };
    let (x, y) = (range(0, matrix.width), range(1, matrix.height));
    if x[0] > x[1] || y[0] > y[1] {
        bins.counts.no_sample += 1;
        return;
    }
    let from = [x[0] * SUBPIXELS, y[0] * SUBPIXELS];
    let (mut c, mut right, mut down) = ([0; 3], [0; 3], [0; 3]);
    for k in 0..3 {
        let (a, b) = (points[k], points[(k + 1) % 3]);
        let bias = i64::from(!is_top_left(a, b));
        c[k] = edge(a, b, from) - bias;
        right[k] = a[1] - b[1];
        down[k] = b[0] - a[0];
    }
    let depths = corners.map(|p| p.z as f32);
    let plane = plane.unwrap_or(DepthPlane {
        at: DVec2::ZERO,
        z: corners[0].z,
        slope: DVec2::ZERO,
    });
    // Depth is anchored at a corner, or where the picture comes nearest to it.
    let inside = |axis: usize, [low, high]: [i32; 2]| {
        points[0][axis].clamp(low * SUBPIXELS, high * SUBPIXELS + SUBPIXELS)
    };
    let anchor = [inside(0, x), inside(1, y)];
    let from_middle = DVec2::from([0, 1].map(|axis| f64::from(anchor[axis] - matrix.middle[axis])));
    let slope = plane.slope.to_array();
    let slack = (slope[0].abs() + slope[1].abs()) as f32;
    let record = Record {
        c,
        right,
        down,
        x: x.map(|v| v as i16),
        y: y.map(|v| v as i16),
        anchor: [0, 1].map(|axis| (anchor[axis] - from[axis]) as f32),
        z: plane.slope.dot(from_middle - plane.at) + plane.z,
        slope,
        z_low: (depths[0].min(depths[1]).min(depths[2]) - slack).max(0.0),
        z_high: depths[0].max(depths[1]).max(depths[2]) + slack,
        triangle: triangle as i32,
        winding: if front { -1 } else { 1 },
    };
    push(record, context, bins);
}
