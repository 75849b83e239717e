//! From clusters to triangles set up for filling, sorted into the tiles they
//! touch.
//!
//! A cluster outside the view volume, facing away, or behind what is already
//! drawn is left out whole. Vertices of the others are transformed once, 16 at
//! a time; triangles that face away, lie outside or contain no sample are
//! dropped 16 at a time. The few that reach behind the near plane, beyond the
//! far plane or out of the guard band go through homogeneous clipping.

use glam::{DMat3, DVec3, DVec4, Vec3, Vec4};

use crate::clip::{ClipVertex, clip_polygon};
use crate::cull::hidden;
use crate::fill::Record;
use crate::fixed::{SUBPIXEL_BITS, doubled_area};
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
    /// In sub-pixels from the middle of the picture, not snapped.
    x: [f32; CLUSTER_VERTICES],
    y: [f32; CLUSTER_VERTICES],
    z: [f32; CLUSTER_VERTICES],
    /// One where a vertex needs clipping.
    outside: [i32; CLUSTER_VERTICES],
    polygon: Vec<ClipVertex>,
    scratch: Vec<ClipVertex>,
}

impl Default for ClusterWork {
    fn default() -> Self {
        Self {
            x: [0.0; CLUSTER_VERTICES],
            y: [0.0; CLUSTER_VERTICES],
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
        any |= inside.bits() != 0xffff;
        let (Some(to_x), Some(to_y), Some(to_z), Some(to_outside)) = (
            lanes_at_mut(&mut work.x, start),
            lanes_at_mut(&mut work.y, start),
            lanes_at_mut(&mut work.z, start),
            lanes_at_mut(&mut work.outside, start),
        ) else {
            return true;
        };
        (keep(x) / divisor).store(to_x);
        (keep(y) / divisor).store(to_y);
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
        x: [[0.0; LANES]; 3],
        y: [[0.0; LANES]; 3],
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
    x: [[f32; LANES]; 3],
    y: [[f32; LANES]; 3],
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
    let fx = triple!(|K| s.load_f(&x[K]));
    let fy = triple!(|K| s.load_f(&y[K]));
    let [middle_x, middle_y] = [s.i(matrix.middle[0]), s.i(matrix.middle[1])];
    let vx = triple!(|K| fx[K].round() + middle_x);
    let vy = triple!(|K| fy[K].round() + middle_y);
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
        // Depth is a plane through the corners where they are, not where they
        // were snapped to; unless a sliver has no area there.
        let vz = triple!(|K| s.load_f(&z[K]));
        let (dz1, dz2) = (vz[1] - vz[0], vz[2] - vz[0]);
        let (dx1f, dy1f) = (fx[1] - fx[0], fy[1] - fy[0]);
        let (dx2f, dy2f) = (fx[2] - fx[0], fy[2] - fy[0]);
        let area_f = dx1f * dy2f - dx2f * dy1f;
        let snapped_area = area.to_float();
        let (zero_f, half) = (s.f(0.0), s.f(0.5));
        let sound = zero_f.lt((area_f - half * snapped_area) * snapped_area);
        let inverse = s.f(1.0) / sound.select_f(area_f, snapped_area);
        let right = (dz1 * dy2f - dz2 * dy1f) * inverse;
        let down = (dz2 * dx1f - dz1 * dx2f) * inverse;
        let right = sound.select_f(right, zero_f);
        let down = sound.select_f(down, zero_f);
        // Snapping moves a corner by at most half a sub-pixel each way.
        let slack = right.max(zero_f - right) + down.max(zero_f - down);
        let moved_x = (vx[0] - middle_x).to_float() - fx[0];
        let moved_y = (vy[0] - middle_y).to_float() - fy[0];
        let mut depth = [[0f32; LANES]; 5];
        (vz[0] + (right * moved_x + down * moved_y)).store(&mut depth[0]);
        right.store(&mut depth[1]);
        down.store(&mut depth[2]);
        (vz[0].min(vz[1]).min(vz[2]) - slack)
            .max(zero_f)
            .store(&mut depth[3]);
        (vz[0].max(vz[1]).max(vz[2]) + slack).store(&mut depth[4]);
        let (mut snapped_x, mut snapped_y) = ([[0i32; LANES]; 3], [[0i32; LANES]; 3]);
        for k in 0..3 {
            vx[k].store(&mut snapped_x[k]);
            vy[k].store(&mut snapped_y[k]);
        }
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
                x: [snapped_x[0][k], snapped_x[b][k], snapped_x[c][k]],
                y: [snapped_y[0][k], snapped_y[b][k], snapped_y[c][k]],
                z: depth[0][k],
                dz: [depth[1][k], depth[2][k]],
                z_low: depth[3][k],
                z_high: depth[4][k],
                triangle: (first + k) as i32,
            };
            let range = [tiles[0][k], tiles[1][k], tiles[2][k], tiles[3][k]];
            push(record, range, context, bins);
        }
    }
    while big != 0 {
        let k = (big.trailing_zeros() as usize) % LANES;
        big &= big - 1;
        let corner = |c: usize| Vec3::new(x[c][k], y[c][k], z[c][k]);
        let corners = [corner(0), corner(1), corner(2)];
        let plane = depth_plane(corners.map(|p| p.extend(1.0).as_dvec4()));
        set_up_one(corners, plane, first + k, context, bins);
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

/// The depth of a triangle's plane as (a, b, c) with Z/W = a X/W + b Y/W + c,
/// from its corners in raster space, clipped or not; `None` if it is seen
/// edge-on.
fn depth_plane([p, q, r]: [DVec4; 3]) -> Option<DVec3> {
    let window = |v: DVec4| DVec3::new(v.x, v.y, v.w);
    let matrix = DMat3::from_cols(window(p), window(q), window(r)).transpose();
    let plane = matrix.inverse() * DVec3::new(p.z, q.z, r.z);
    (matrix.determinant() != 0.0 && plane.is_finite()).then_some(plane)
}

/// Sets up one triangle of any size. Corners are in the order 0, 2, 1, in
/// sub-pixels from the middle of the picture, with their depths.
fn set_up_one(
    corners: [Vec3; 3],
    plane: Option<DVec3>,
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
        (
            ((low + 255 - last_sample) >> SUBPIXEL_BITS).max(0),
            ((high - first_sample) >> SUBPIXEL_BITS).min(size.cast_signed() - 1),
        )
    };
    let (px0, px1) = range(0, matrix.width);
    let (py0, py1) = range(1, matrix.height);
    if px0 > px1 || py0 > py1 {
        bins.counts.no_sample += 1;
        return;
    }
    let depths = corners.map(|p| p.z);
    let plane = plane.unwrap_or(DVec3::new(0.0, 0.0, f64::from(depths[0])));
    let [x, y] = [0, 1].map(|axis| f64::from(points[0][axis] - matrix.middle[axis]));
    let (right, down) = (plane.x as f32, plane.y as f32);
    let slack = right.abs() + down.abs();
    let record = Record {
        x: points.map(|p| p[0]),
        y: points.map(|p| p[1]),
        z: (plane.x * x + plane.y * y + plane.z) as f32,
        dz: [right, down],
        z_low: (depths[0].min(depths[1]).min(depths[2]) - slack).max(0.0),
        z_high: depths[0].max(depths[1]).max(depths[2]) + slack,
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
    let divided = |v: &ClipVertex| {
        let [x, y, z, w] = v.position.to_array().map(|c| c as f32);
        Vec3::new(x / w, y / w, (z / w).clamp(0.0, 1.0))
    };
    let plane = depth_plane(corners);
    for k in 2..polygon.len() {
        let fan = [
            divided(&polygon[0]),
            divided(&polygon[k - 1]),
            divided(&polygon[k]),
        ];
        set_up_one(fan, plane, triangle, context, bins);
    }
}
