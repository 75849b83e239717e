//! From clusters to triangles set up for filling, sorted into the tiles they
//! touch.
//!
//! A cluster outside the view volume, facing away, or behind what is already
//! drawn is left out whole. Vertices of the others are transformed once, 16 at
//! a time; triangles that face away, lie outside or contain no sample are
//! dropped 16 at a time. The few that reach behind the near plane, beyond the
//! far plane or out of the guard band go through homogeneous clipping.

use glam::{DVec4, Vec3, Vec4};

use crate::clip::{ClipVertex, clip_polygon};
use crate::fill::Record;
use crate::fixed::SUBPIXEL_BITS;
use crate::frame::{FrameMatrix, GUARD};
use crate::scene::{CLUSTER_VERTICES, Cluster, Scene};
use crate::simd::{FloatLanes, IntLanes, Kernel, LANES, Lanes, MaskLanes, triple};
use crate::tile::{TILE_BITS, Tile};

/// What this stage saw and left out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GeometryCounts {
    pub clusters_hidden: u64,
    pub triangles: u64,
    pub facing_away: u64,
    pub no_sample: u64,
    pub clipped: u64,
    pub vertices: u64,
}

/// The triangles that one thread set up, by tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    pub records: Vec<Record>,
    /// For each tile, indices into `records`.
    pub tiles: Vec<Vec<u32>>,
    pub counts: GeometryCounts,
}

impl Bins {
    pub fn clear(&mut self, tiles: usize) {
        self.records.clear();
        self.tiles.iter_mut().for_each(Vec::clear);
        self.tiles.resize_with(tiles, Vec::new);
    }
}

/// Which faces are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facing {
    pub front: bool,
    pub back: bool,
}

/// What all clusters of a frame share.
#[derive(Clone, Copy)]
pub(crate) struct GeometryContext<'a> {
    pub scene: &'a Scene,
    pub matrix: &'a FrameMatrix,
    pub facing: Facing,
    pub tiles: &'a [Tile],
    /// Tiles in a row of the picture.
    pub columns: usize,
    /// First and last sub-pixel position of a sample in its pixel.
    pub sample_range: [i32; 2],
}

/// Why a cluster is left out, or how near it comes.
pub(crate) enum Visibility {
    Outside,
    FacingAway,
    /// May be seen; greatest reversed depth of its bounding sphere.
    Possible(f32),
}

/// A plane's distance from the centre of a sphere, and its greatest change
/// within it.
fn reach(row: Vec4, centre: Vec3, radius: f32) -> (f32, f32) {
    let normal = row.truncate();
    (normal.dot(centre) + row.w, normal.length() * radius)
}

/// Culls a cluster by the view volume and by its normal cone.
pub(crate) fn cluster_visibility(
    cluster: &Cluster,
    matrix: &FrameMatrix,
    facing: Facing,
) -> Visibility {
    let [x, y, z, w] = matrix.rows;
    let [half_x, half_y] = matrix.middle.map(|m| m as f32);
    let planes = [
        w * half_x + x,
        w * half_x - x,
        w * half_y + y,
        w * half_y - y,
        w - z,
        z,
    ];
    for plane in planes {
        let (distance, change) = reach(plane, cluster.centre, cluster.radius);
        if distance < -(change * 1.0001) {
            return Visibility::Outside;
        }
    }
    if !(facing.front && facing.back) {
        let away = matrix.viewer.truncate() - cluster.centre * matrix.viewer.w;
        let slack = cluster.sine * away.length() + cluster.radius * matrix.viewer.w;
        let towards = cluster.axis.dot(away);
        if (facing.front && towards < -slack) || (facing.back && towards > slack) {
            return Visibility::FacingAway;
        }
    }
    // Depth is b + (a + r·p) / w, where b is the part of the z row along the
    // w row: exact for a perspective, whose depth depends on w alone.
    let w_normal = w.truncate();
    let length = w_normal.length_squared();
    let b = if length > 0.0 {
        z.truncate().dot(w_normal) / length
    } else {
        0.0
    };
    let (w_centre, w_change) = reach(w, cluster.centre, cluster.radius);
    let nearest_w = w_centre - w_change;
    if nearest_w <= 0.0 {
        return Visibility::Possible(1.0);
    }
    let (rest, rest_change) = reach(z - w * b, cluster.centre, cluster.radius);
    let most = rest + rest_change;
    let nearest = b + most
        / if most > 0.0 {
            nearest_w
        } else {
            w_centre + w_change
        };
    Visibility::Possible((nearest * 1.00001 + 1e-6).min(1.0))
}

/// Whether hierarchical depth hides a cluster whose nearest depth is `depth`.
fn hidden(cluster: &Cluster, depth: f32, context: &GeometryContext) -> bool {
    let matrix = context.matrix;
    let [x, y, _, w] = matrix.rows;
    let (w_centre, w_change) = reach(w, cluster.centre, cluster.radius);
    let nearest_w = w_centre - w_change;
    if nearest_w <= 0.0 || depth >= 1.0 {
        return false;
    }
    let range = |row: Vec4, axis: usize| {
        let at = (row.truncate().dot(cluster.centre) + row.w) / w_centre;
        let (_, change) = reach(row - w * at, cluster.centre, cluster.radius);
        let spread = change / nearest_w + 2.0 * 256.0;
        let tile = |v: f32| (v as i32).saturating_add(matrix.middle[axis]) >> (SUBPIXEL_BITS + 3);
        (tile(at - spread), tile(at + spread))
    };
    let (x0, x1) = range(x, 0);
    let (y0, y1) = range(y, 1);
    let last = [matrix.width, matrix.height].map(|side| (side.cast_signed() - 1) >> 3);
    let (x0, x1) = (x0.max(0), x1.min(last[0]));
    let (y0, y1) = (y0.max(0), y1.min(last[1]));
    let whole = |tile: &Tile| tile.drawn && depth < tile.farthest_of_all;
    for tile_y in y0 >> 3..=y1 >> 3 {
        for tile_x in x0 >> 3..=x1 >> 3 {
            let Some(tile) = context
                .tiles
                .get(tile_y as usize * context.columns + tile_x as usize)
            else {
                return false;
            };
            if !tile.drawn {
                return false;
            }
            if whole(tile) {
                continue;
            }
            for sy in (y0 - tile_y * 8).max(0)..=(y1 - tile_y * 8).min(7) {
                for sx in (x0 - tile_x * 8).max(0)..=(x1 - tile_x * 8).min(7) {
                    if depth >= tile.farthest[(sy * 8 + sx) as usize] {
                        return false;
                    }
                }
            }
        }
    }
    true
}

/// Sets up the triangles of clusters, given with their nearest depths, into
/// `bins`.
pub(crate) struct SetUpClusters<'a> {
    pub context: GeometryContext<'a>,
    pub clusters: &'a [(f32, u32)],
    pub bins: &'a mut Bins,
}

impl Kernel for SetUpClusters<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let mut work = ClusterWork::default();
        for &(depth, index) in self.clusters {
            let cluster = &self.context.scene.clusters[index as usize];
            if hidden(cluster, depth, &self.context) {
                self.bins.counts.clusters_hidden += 1;
                continue;
            }
            set_up_cluster(s, cluster, &self.context, &mut work, self.bins);
        }
    }
}

/// The transformed vertices of one cluster.
struct ClusterWork {
    x: [i32; CLUSTER_VERTICES],
    y: [i32; CLUSTER_VERTICES],
    z: [f32; CLUSTER_VERTICES],
    /// One where a vertex needs clipping.
    outside: [i32; CLUSTER_VERTICES],
    polygon: Vec<ClipVertex>,
    scratch: Vec<ClipVertex>,
}

impl Default for ClusterWork {
    fn default() -> Self {
        Self {
            x: [0; CLUSTER_VERTICES],
            y: [0; CLUSTER_VERTICES],
            z: [0.0; CLUSTER_VERTICES],
            outside: [1; CLUSTER_VERTICES],
            polygon: Vec::new(),
            scratch: Vec::new(),
        }
    }
}

fn lanes_at<T>(values: &[T], start: usize) -> Option<&[T; LANES]> {
    values.get(start..start + LANES)?.try_into().ok()
}

fn lanes_at_mut<T>(values: &mut [T], start: usize) -> Option<&mut [T; LANES]> {
    values.get_mut(start..start + LANES)?.try_into().ok()
}

/// A row of the matrix in all lanes.
#[inline(always)]
fn splat_row<S: Lanes>(s: S, row: Vec4) -> [S::F; 4] {
    [s.f(row.x), s.f(row.y), s.f(row.z), s.f(row.w)]
}

/// A row of the matrix applied to points.
#[inline(always)]
fn apply<S: Lanes>(row: [S::F; 4], p: [S::F; 3]) -> S::F {
    (row[0] * p[0] + row[1] * p[1]) + (row[2] * p[2] + row[3])
}

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

/// Transforms a cluster's vertices; returns whether any needs clipping.
#[inline(always)]
fn transform<S: Lanes>(
    s: S,
    cluster: &Cluster,
    context: &GeometryContext,
    work: &mut ClusterWork,
) -> bool {
    let matrix = context.matrix;
    let rows = [
        splat_row(s, matrix.rows[0]),
        splat_row(s, matrix.rows[1]),
        splat_row(s, matrix.rows[2]),
        splat_row(s, matrix.rows[3]),
    ];
    let (zero, guard) = (s.f(0.0), s.f(GUARD));
    let middle = [s.i(matrix.middle[0]), s.i(matrix.middle[1])];
    let mut any = false;
    for start in (0..cluster.vertices as usize).step_by(LANES) {
        let from = cluster.first_vertex as usize + start;
        let [xs, ys, zs] = &context.scene.cluster_vertices;
        let (Some(px), Some(py), Some(pz)) =
            (lanes_at(xs, from), lanes_at(ys, from), lanes_at(zs, from))
        else {
            return true;
        };
        let (px, py, pz) = (s.load_f(px), s.load_f(py), s.load_f(pz));
        let p = [px, py, pz];
        let (x, y) = (apply::<S>(rows[0], p), apply::<S>(rows[1], p));
        let (z, w) = (apply::<S>(rows[2], p), apply::<S>(rows[3], p));
        let limit = guard * w;
        let inside = zero.lt(w)
            & z.le(w)
            & zero.le(z)
            & x.le(limit)
            & (zero - limit).le(x)
            & y.le(limit)
            & (zero - limit).le(y);
        let keep = |v: S::F| inside.select_f(v, zero);
        let divisor = inside.select_f(w, s.f(1.0));
        let outside = inside.select_i(s.i(0), s.i(1));
        let fx = (keep(x) / divisor).round() + middle[0];
        let fy = (keep(y) / divisor).round() + middle[1];
        any |= inside.bits() != 0xffff;
        let (Some(to_x), Some(to_y), Some(to_z), Some(to_outside)) = (
            lanes_at_mut(&mut work.x, start),
            lanes_at_mut(&mut work.y, start),
            lanes_at_mut(&mut work.z, start),
            lanes_at_mut(&mut work.outside, start),
        ) else {
            return true;
        };
        fx.store(to_x);
        fy.store(to_y);
        (keep(z) / divisor).store(to_z);
        outside.store(to_outside);
    }
    any
}

#[inline(always)]
fn set_up_cluster<S: Lanes>(
    s: S,
    cluster: &Cluster,
    context: &GeometryContext,
    work: &mut ClusterWork,
    bins: &mut Bins,
) {
    let any_outside = transform(s, cluster, context, work);
    bins.counts.vertices += u64::from(cluster.vertices);
    bins.counts.triangles += u64::from(cluster.triangles);
    let first = cluster.first_triangle as usize;
    let end = first + cluster.triangles as usize;
    // Corners are taken in the order 0, 2, 1, which is clockwise as seen for
    // a front face.
    let mut corners = Corners {
        x: [[0; LANES]; 3],
        y: [[0; LANES]; 3],
        z: [[0.0; LANES]; 3],
    };
    for start in (first..end).step_by(LANES) {
        let count = LANES.min(end - start);
        let mut to_clip = 0u32;
        for (k, local) in context.scene.local[start..start + count].iter().enumerate() {
            let vertices = triple!(|K| local[[0, 2, 1][K]] as usize % CLUSTER_VERTICES);
            for (c, v) in vertices.into_iter().enumerate() {
                corners.x[c][k] = work.x[v];
                corners.y[c][k] = work.y[v];
                corners.z[c][k] = work.z[v];
            }
            if any_outside {
                let [a, b, c] = triple!(|K| work.outside[vertices[K]]);
                to_clip |= (a | b | c).cast_unsigned() << k;
            }
        }
        let present = (1u32 << count) - 1;
        set_up_triangles(s, &corners, start, present & !to_clip, context, bins);
        let mut rest = to_clip & present;
        while rest != 0 {
            let k = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            clip_and_set_up(start + k, context, work, bins);
        }
    }
}

/// The corners of 16 triangles: by corner, then by triangle.
struct Corners {
    x: [[i32; LANES]; 3],
    y: [[i32; LANES]; 3],
    z: [[f32; LANES]; 3],
}

/// Sets up those of 16 triangles whose bits are in `present`.
#[inline(always)]
fn set_up_triangles<S: Lanes>(
    s: S,
    Corners { x, y, z }: &Corners,
    first: usize,
    present: u32,
    context: &GeometryContext,
    bins: &mut Bins,
) {
    let matrix = context.matrix;
    let vx = [s.load_i(&x[0]), s.load_i(&x[1]), s.load_i(&x[2])];
    let vy = [s.load_i(&y[0]), s.load_i(&y[1]), s.load_i(&y[2])];
    let (low_x, high_x) = (vx[0].min(vx[1]).min(vx[2]), vx[0].max(vx[1]).max(vx[2]));
    let (low_y, high_y) = (vy[0].min(vy[1]).min(vy[2]), vy[0].max(vy[1]).max(vy[2]));
    // Pixels with a sample between the extremes, inside the picture.
    let zero = s.i(0);
    let (px0, px1) = pixel_range(s, low_x, high_x, matrix.width, context.sample_range);
    let (py0, py1) = pixel_range(s, low_y, high_y, matrix.height, context.sample_range);
    let empty = (px1.lt(px0) | py1.lt(py0)).bits();
    let limit = s.i(1 << 15);
    let large = !((high_x - low_x).lt(limit) & (high_y - low_y).lt(limit)).bits();
    let (dx1, dy1) = (vx[1] - vx[0], vy[1] - vy[0]);
    let (dx2, dy2) = (vx[2] - vx[0], vy[2] - vy[0]);
    let area = dx1 * dy2 - dx2 * dy1;
    let front = s.i(0).lt(area * s.i(matrix.orientation)).bits();
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
    let survivors = small & wanted;
    let mut big = present & !empty & large;
    if survivors != 0 {
        let vz = [s.load_f(&z[0]), s.load_f(&z[1]), s.load_f(&z[2])];
        let inverse = s.f(1.0) / area.to_float();
        let (dz1, dz2) = (vz[1] - vz[0], vz[2] - vz[0]);
        let (dx1, dy1) = (dx1.to_float(), dy1.to_float());
        let (dx2, dy2) = (dx2.to_float(), dy2.to_float());
        let mut slopes = [[0f32; LANES]; 4];
        ((dz1 * dy2 - dz2 * dy1) * inverse).store(&mut slopes[0]);
        ((dz2 * dx1 - dz1 * dx2) * inverse).store(&mut slopes[1]);
        vz[0].min(vz[1]).min(vz[2]).store(&mut slopes[2]);
        vz[0].max(vz[1]).max(vz[2]).store(&mut slopes[3]);
        let clockwise = zero.lt(area).bits();
        let mut tiles = [[0i32; LANES]; 4];
        px0.shr::<6>().store(&mut tiles[0]);
        px1.shr::<6>().store(&mut tiles[1]);
        py0.shr::<6>().store(&mut tiles[2]);
        py1.shr::<6>().store(&mut tiles[3]);
        let mut rest = survivors;
        while rest != 0 {
            let k = (rest.trailing_zeros() as usize) % LANES;
            rest &= rest - 1;
            let (b, c) = if clockwise >> k & 1 == 1 {
                (1, 2)
            } else {
                (2, 1)
            };
            let record = Record {
                x: [x[0][k], x[b][k], x[c][k]],
                y: [y[0][k], y[b][k], y[c][k]],
                z: z[0][k],
                dz: [slopes[0][k], slopes[1][k]],
                z_low: slopes[2][k],
                z_high: slopes[3][k],
                triangle: (first + k) as i32,
            };
            let range = [tiles[0][k], tiles[1][k], tiles[2][k], tiles[3][k]];
            push(record, range, context, bins);
        }
    }
    while big != 0 {
        let k = (big.trailing_zeros() as usize) % LANES;
        big &= big - 1;
        let corner = |c: usize| (x[c][k], y[c][k], z[c][k]);
        set_up_one([corner(0), corner(1), corner(2)], first + k, context, bins);
    }
}

fn push(
    record: Record,
    [tx0, tx1, ty0, ty1]: [i32; 4],
    context: &GeometryContext,
    bins: &mut Bins,
) {
    let index = bins.records.len() as u32;
    bins.records.push(record);
    for ty in ty0..=ty1 {
        for tx in tx0..=tx1 {
            if let Some(tile) = bins
                .tiles
                .get_mut(ty as usize * context.columns + tx as usize)
            {
                tile.push(index);
            }
        }
    }
}

/// Sets up one triangle of any size, corners in the order 0, 2, 1.
fn set_up_one(
    corners: [(i32, i32, f32); 3],
    triangle: usize,
    context: &GeometryContext,
    bins: &mut Bins,
) {
    let matrix = context.matrix;
    let [a, mut b, mut c] = corners;
    let difference = |p: (i32, i32, f32)| (i64::from(p.0 - a.0), i64::from(p.1 - a.1));
    let area = {
        let ((dx1, dy1), (dx2, dy2)) = (difference(b), difference(c));
        dx1 * dy2 - dx2 * dy1
    };
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
    let area = if area < 0 {
        std::mem::swap(&mut b, &mut c);
        -area
    } else {
        area
    };
    let ((dx1, dy1), (dx2, dy2)) = (difference(b), difference(c));
    let [first_sample, last_sample] = context.sample_range;
    let range = |v: [i32; 3], size: u32| {
        let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
        (
            ((low + 255 - last_sample) >> SUBPIXEL_BITS).max(0),
            ((high - first_sample) >> SUBPIXEL_BITS).min(size.cast_signed() - 1),
        )
    };
    let (px0, px1) = range([a.0, b.0, c.0], matrix.width);
    let (py0, py1) = range([a.1, b.1, c.1], matrix.height);
    if px0 > px1 || py0 > py1 {
        bins.counts.no_sample += 1;
        return;
    }
    let (dz1, dz2) = (
        f64::from(b.2) - f64::from(a.2),
        f64::from(c.2) - f64::from(a.2),
    );
    let slope =
        |u: i64, v: i64, sign: f64| (sign * (dz1 * u as f64 - dz2 * v as f64) / area as f64) as f32;
    let record = Record {
        x: [a.0, b.0, c.0],
        y: [a.1, b.1, c.1],
        z: a.2,
        dz: [slope(dy2, dy1, 1.0), slope(dx2, dx1, -1.0)],
        z_low: a.2.min(b.2).min(c.2),
        z_high: a.2.max(b.2).max(c.2),
        triangle: triangle as i32,
    };
    push(
        record,
        [px0, px1, py0, py1].map(|v| v >> TILE_BITS),
        context,
        bins,
    );
}

/// The planes that a triangle is clipped against in raster space (X, Y, Z,
/// W): near, far, and the four sides of the guard band.
const CLIP_PLANES: [DVec4; 6] = [
    DVec4::new(0.0, 0.0, -1.0, 1.0),
    DVec4::new(0.0, 0.0, 1.0, 0.0),
    DVec4::new(1.0, 0.0, 0.0, GUARD as f64),
    DVec4::new(-1.0, 0.0, 0.0, GUARD as f64),
    DVec4::new(0.0, 1.0, 0.0, GUARD as f64),
    DVec4::new(0.0, -1.0, 0.0, GUARD as f64),
];

/// Clips one triangle and sets up what is left of it.
fn clip_and_set_up(
    triangle: usize,
    context: &GeometryContext,
    work: &mut ClusterWork,
    bins: &mut Bins,
) {
    bins.counts.clipped += 1;
    let (scene, matrix) = (context.scene, context.matrix);
    let [a, b, c] = scene.triangles[triangle];
    let at = |v: u32| scene.positions.get(v as usize).copied();
    let (Some(a), Some(b), Some(c)) = (at(a), at(c), at(b)) else {
        return;
    };
    let corners = [a, b, c].map(|p| {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| f64::from(matrix.row(row, p)));
        DVec4::new(x, y, z, w)
    });
    if !corners.iter().all(|p| p.is_finite()) {
        return;
    }
    let (polygon, scratch) = (&mut work.polygon, &mut work.scratch);
    polygon.clear();
    for (k, position) in corners.into_iter().enumerate() {
        let mut weights = [0.0; 3];
        weights[k] = 1.0;
        polygon.push(ClipVertex { position, weights });
    }
    for plane in CLIP_PLANES {
        if corners.iter().any(|p| plane.dot(*p) < 0.0) {
            clip_polygon(polygon, plane, scratch);
            std::mem::swap(polygon, scratch);
        }
    }
    if polygon.iter().any(|v| v.position.w <= 0.0) {
        // Only the eye itself has w = 0 between the near and far planes.
        return;
    }
    // Divided in single precision like vertices that were not clipped, so
    // that a vertex shared with an unclipped triangle lands on the same spot.
    let snapped = |v: &ClipVertex| {
        let [x, y, z, w] = v.position.to_array().map(|c| c as f32);
        (
            (x / w).round_ties_even() as i32 + matrix.middle[0],
            (y / w).round_ties_even() as i32 + matrix.middle[1],
            (z / w).clamp(0.0, 1.0),
        )
    };
    for k in 2..polygon.len() {
        let fan = [
            snapped(&polygon[0]),
            snapped(&polygon[k - 1]),
            snapped(&polygon[k]),
        ];
        set_up_one(fan, triangle, context, bins);
    }
}
