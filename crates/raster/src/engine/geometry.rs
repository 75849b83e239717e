//! From clusters to triangles set up for filling, sorted into the tiles they
//! touch.
//!
//! A cluster outside the view volume, facing away, or behind what is already
//! drawn is left out whole. Vertices of the others are transformed once, 16 at
//! a time; triangles that face away, lie outside or contain no sample are
//! dropped 16 at a time. The few that reach behind the near plane, beyond the
//! far plane or out of the guard band go through homogeneous clipping.

use glam::{DVec3, DVec4};

use crate::clip::{ClipVertex, clip_polygon};
use crate::cluster::{CLUSTER_VERTICES, Cluster};
use crate::cull::hidden;
use crate::fill::{PixelOfTriangle, Record};
use crate::frame::{FrameMatrix, GUARD};
use crate::options::RenderOptions;
use crate::prepared::Prepared;
use crate::set_up::{
    MOST_PIXELS, RasterCorners, Stored, corner_plane, depth_plane, set_up_one, set_up_triangles,
};
use crate::shading::ShadeContext;
use crate::simd::{DoubleLanes, FloatLanes, IntLanes, Kernel, LANES, Lanes, MaskLanes, triple};
use crate::tile::Tile;

/// What this stage saw and left out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GeometryCounts {
    pub clusters_hidden: u64,
    pub triangles: u64,
    pub facing_away: u64,
    pub no_sample: u64,
    pub clipped: u64,
    pub vertices: u64,
    /// Triangles of a few pixels, filled at once.
    pub tiny: u64,
}

/// The triangles that one thread set up, by tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    pub records: Vec<Record>,
    /// For each tile, indices into `records`.
    pub tiles: Vec<Vec<u32>>,
    /// The same of triangles that are seen through.
    pub transparent: Vec<Vec<u32>>,
    /// For each tile, pixels of triangles too small to be worth a record.
    pub pixels: Vec<Vec<PixelOfTriangle>>,
    /// Pixels on their way to one tile: mostly many in a row are for the same.
    run: Vec<PixelOfTriangle>,
    run_length: usize,
    run_tile: i32,
    pub counts: GeometryCounts,
}

/// Pixels that wait, at most, for those of another tile.
const RUN: usize = 4 * MOST_PIXELS;

impl Bins {
    pub fn clear(&mut self, tiles: usize) {
        self.records.clear();
        self.tiles.iter_mut().for_each(Vec::clear);
        self.tiles.resize_with(tiles, Vec::new);
        self.transparent.iter_mut().for_each(Vec::clear);
        self.transparent.resize_with(tiles, Vec::new);
        self.pixels.iter_mut().for_each(Vec::clear);
        self.pixels.resize_with(tiles, Vec::new);
        self.run.resize(RUN, PixelOfTriangle::default());
    }

    /// Sees to it that those of 16 triangles find room.
    #[inline(always)]
    pub fn make_room(&mut self) {
        if self.run_length > RUN - MOST_PIXELS {
            self.end_run();
        }
    }

    /// Adds a pixel of a small triangle to a tile.
    #[inline(always)]
    pub fn push_pixel(&mut self, tile: i32, pixel: PixelOfTriangle) {
        if tile != self.run_tile {
            self.end_run();
            self.run_tile = tile;
        }
        if let Some(to) = self.run.get_mut(self.run_length) {
            *to = pixel;
            self.run_length += 1;
        }
    }

    /// Brings the pixels that wait to their tile.
    pub fn end_run(&mut self) {
        if let Some(all) = self.pixels.get_mut(self.run_tile as usize) {
            all.extend_from_slice(&self.run[..self.run_length]);
        }
        self.run_length = 0;
    }
}

/// Which faces are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facing {
    pub front: bool,
    pub back: bool,
}

impl Facing {
    /// Back faces show where they are asked for, or the solid is cut open, or
    /// seen through.
    pub fn of(scene: &Prepared, options: &RenderOptions) -> Self {
        Self {
            front: true,
            back: !options.cull_back_faces
                || !scene.sections.is_empty()
                || scene.is_transparent(options),
        }
    }
}

/// What all clusters of a frame share.
#[derive(Clone, Copy)]
pub(crate) struct GeometryContext<'a> {
    pub scene: &'a Prepared,
    pub matrix: &'a FrameMatrix,
    pub facing: Facing,
    pub tiles: &'a [Tile],
    /// Tiles in a row of the picture.
    pub columns: usize,
    /// First and last sub-pixel position of a sample in its pixel.
    pub sample_range: [i32; 2],
    /// Where some triangles are seen through: how they are shaded; and whether
    /// the backs of the others are left out.
    pub transparent: Option<(&'a ShadeContext<'a>, bool)>,
}

impl GeometryContext<'_> {
    /// Whether section planes cut the solid open. Then windings are counted,
    /// for which hidden triangles matter, too; and depth is a plane through the
    /// corners where they are snapped to, instead of where they are, so that of
    /// two faces that share a silhouette the front is the nearer one up to its
    /// very edge.
    #[inline(always)]
    pub fn is_cut(&self) -> bool {
        !self.scene.sections.is_empty()
    }

    /// A corner, in sub-pixels, as its triangle's depth takes it.
    pub fn depth_corner(&self, p: DVec3) -> DVec3 {
        if self.is_cut() {
            DVec3::new(p.x.round_ties_even(), p.y.round_ties_even(), p.z)
        } else {
            p
        }
    }
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
        let mut corners = RasterCorners::default();
        let mut stored = Stored::default();
        for &(depth, index) in self.clusters {
            let cluster = &self.context.scene.clusters[index as usize];
            if !self.context.is_cut() && hidden(cluster, depth, &self.context) {
                self.bins.counts.clusters_hidden += 1;
                continue;
            }
            set_up_cluster(
                s,
                cluster,
                &self.context,
                &mut work,
                &mut corners,
                &mut stored,
                self.bins,
            );
        }
        self.bins.end_run();
    }
}

/// The transformed vertices of one cluster.
struct ClusterWork {
    /// In sub-pixels from the middle of the picture, not snapped.
    x: [f64; CLUSTER_VERTICES],
    y: [f64; CLUSTER_VERTICES],
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
fn splat_row<S: Lanes>(s: S, row: DVec4) -> [S::D; 4] {
    [s.d(row.x), s.d(row.y), s.d(row.z), s.d(row.w)]
}

/// A row applied to points: the order of operations of
/// [`FrameMatrix::row`].
#[inline(always)]
fn apply<S: Lanes>(row: [S::D; 4], p: [S::D; 3]) -> S::D {
    (row[0] * p[0] + row[1] * p[1]) + (row[2] * p[2] + row[3])
}

/// Transforms a cluster's vertices; returns whether any needs clipping. In
/// double precision: what 32 bits leave of a position in a large picture is
/// too little for the depth of steep faces.
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
        let Some(points) = lanes_at(&context.scene.cluster_vertices, from) else {
            return true;
        };
        let points = s.columns(points);
        let mut p = triple!(|K| points[K].to_double());
        if let Some(rest) = lanes_at(&context.scene.cluster_remainders, from) {
            let rest = s.columns(rest);
            p = triple!(|K| p[K] + rest[K].to_double());
        }
        let (dx, dy) = (apply::<S>(rows[0], p), apply::<S>(rows[1], p));
        let (dz, dw) = (apply::<S>(rows[2], p), apply::<S>(rows[3], p));
        let inverse = s.d(1.0) / dw;
        let (x, y) = (dx.to_single(), dy.to_single());
        let (z, w) = (dz.to_single(), dw.to_single());
        let limit = guard * w;
        let inside = zero.lt(w)
            & z.le(w)
            & zero.le(z)
            & x.le(limit)
            & (zero - limit).le(x)
            & y.le(limit)
            & (zero - limit).le(y);
        any |= inside.bits() != 0xffff;
        let (Some(to_x), Some(to_y), Some(to_z), Some(to_outside)) = (
            lanes_at_mut(&mut work.x, start),
            lanes_at_mut(&mut work.y, start),
            lanes_at_mut(&mut work.z, start),
            lanes_at_mut(&mut work.outside, start),
        ) else {
            return true;
        };
        // Vertices outside are not looked at again.
        (dx * inverse).store(to_x);
        (dy * inverse).store(to_y);
        (dz * inverse).to_single().store(to_z);
        inside.select_i(s.i(0), s.i(1)).store(to_outside);
    }
    any
}

#[inline(always)]
fn set_up_cluster<S: Lanes>(
    s: S,
    cluster: &Cluster,
    context: &GeometryContext,
    work: &mut ClusterWork,
    corners: &mut RasterCorners,
    stored: &mut Stored,
    bins: &mut Bins,
) {
    let any_outside = transform(s, cluster, context, work);
    bins.counts.vertices += u64::from(cluster.vertices);
    bins.counts.triangles += u64::from(cluster.triangles);
    let first = cluster.first_triangle as usize;
    let end = first + cluster.triangles as usize;
    // Corners are taken in the order 0, 2, 1, which is clockwise as seen for
    // a front face.
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
        set_up_triangles(s, corners, start, present & !to_clip, context, stored, bins);
        let mut rest = to_clip & present;
        while rest != 0 {
            let k = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            clip_and_set_up(start + k, context, work, bins);
        }
    }
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
    let Some([a, b, c]) = scene.corners(triangle) else {
        return;
    };
    let corners = [a, c, b].map(|p| DVec4::from_array([0, 1, 2, 3].map(|row| matrix.row(row, p))));
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
    // Divided like vertices that were not clipped, so that a vertex shared
    // with an unclipped triangle lands on the same spot. (Clipping leaves it in
    // the guard band but for rounding, which is large where corners are huge.)
    let guard = f64::from(GUARD);
    let divided = |v: &ClipVertex| {
        let p = v.position;
        let inverse = 1.0 / p.w;
        DVec3::new(
            (p.x * inverse).clamp(-guard, guard),
            (p.y * inverse).clamp(-guard, guard),
            (p.z * inverse).clamp(0.0, 1.0),
        )
    };
    let whole = depth_plane(corners);
    for k in 2..polygon.len() {
        let fan = [
            divided(&polygon[0]),
            divided(&polygon[k - 1]),
            divided(&polygon[k]),
        ];
        let plane = if context.is_cut() {
            corner_plane(fan.map(|p| context.depth_corner(p)))
        } else {
            whole
        };
        set_up_one(fan, plane, triangle, context, bins);
    }
}
