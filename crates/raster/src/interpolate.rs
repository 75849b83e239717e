//! Attributes at the pixels of a block, perspective-correct.
//!
//! The triangle and the pixel give everything. With the corners in raster
//! space (X, Y, W) and the sample at (x, y), let qk = (Xk - x Wk, Yk - y Wk).
//! Then b0 = q1 × q2, b1 = q2 × q0, b2 = q0 × q1 are the homogeneous weights
//! of the corners at the sample: perspective-correct, and right for corners
//! behind the eye, so that clipped triangles need no attributes of their own
//! (Olano, Greer, *Triangle scan conversion using 2D homogeneous
//! coordinates*, 1997). Taking the sample as origin first keeps the products
//! free of cancellation.
//!
//! The weights are linear in x and y. Where a block shows few triangles, each
//! one's linear functions are found in double precision, kept for the blocks
//! around, and evaluated for 16 pixels at once. Where it shows many, each lane
//! takes the corners of its own triangle. What is chosen depends on the
//! block's triangles only, so pictures do not depend on how work is shared
//! out.

use glam::{DVec2, DVec4, Vec3, Vec4};

use crate::deferred::{Fragments, Job, MIXED, ShadeContext};
use crate::fill::{LANE_X, LANE_Y};
use crate::fixed::SUBPIXELS;
use crate::frame::FrameMatrix;
use crate::scene::{CLUSTER_VERTICES, Scene};
use crate::shade::Interpolation;
use crate::simd::vector::{Triple, load, splat, store};
use crate::simd::{FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};
use crate::smooth::ClusterView;
use crate::tile::{NO_TRIANGLE, TILE, decode};

/// So many changes of triangle from one lane of a block to the next are worth
/// finding weights lane by lane.
const SCATTERED: u32 = 9;

/// Triangles whose weights are kept: neighbouring blocks mostly show the same
/// ones.
const KEPT: usize = 128;

/// The weights of one triangle's corners in one tile, as linear functions: at
/// the sample of the pixel `origin` + (x, y), corner k weighs
/// `at[k] + x right[k] + y down[k]`, up to a positive factor common to all.
#[derive(Clone, Copy, Debug)]
struct Weights {
    triangle: i32,
    origin: [i32; 2],
    at: [f32; 3],
    right: [f32; 3],
    down: [f32; 3],
}

/// The triangles of one tile met lately, in a small direct-mapped cache.
#[derive(Clone, Debug)]
pub(crate) struct Cache([Weights; KEPT]);

impl Default for Cache {
    fn default() -> Self {
        let none = Weights {
            triangle: NO_TRIANGLE,
            origin: [0; 2],
            at: [0.0; 3],
            right: [0.0; 3],
            down: [0.0; 3],
        };
        Self([none; KEPT])
    }
}

impl Cache {
    /// Forgets all: another frame or tile begins.
    pub fn clear(&mut self) {
        for entry in &mut self.0 {
            entry.triangle = NO_TRIANGLE;
        }
    }

    #[inline(always)]
    fn get(
        &mut self,
        matrix: &FrameMatrix,
        index: i32,
        corners: &[Vec3; 3],
        [px, py]: [usize; 2],
    ) -> &Weights {
        let entry = &mut self.0[index as usize % KEPT];
        if entry.triangle != index {
            let tile = [px, py].map(|p| (p - p % TILE) as i32);
            *entry = linear_weights(matrix, corners, tile);
            entry.triangle = index;
        }
        entry
    }
}

/// A point's X, Y and W in double precision.
fn raster(matrix: &FrameMatrix, p: Vec3) -> (DVec2, f64) {
    let p = p.as_dvec3().extend(1.0);
    let row = |k: usize| DVec4::dot(matrix.precise[k], p);
    (DVec2::new(row(0), row(1)), row(3))
}

/// The middle of a pixel, in sub-pixels from the middle of the picture.
fn sample(matrix: &FrameMatrix, pixel: [i32; 2]) -> DVec2 {
    let [x, y] = [0, 1].map(|axis| pixel[axis] * SUBPIXELS + SUBPIXELS / 2 - matrix.middle[axis]);
    DVec2::new(f64::from(x), f64::from(y))
}

/// The linear weights of a triangle in a tile. Their origin is the pixel of
/// the tile nearest to the first corner, so that the functions are not
/// extended far beyond the triangle.
fn linear_weights(matrix: &FrameMatrix, corners: &[Vec3; 3], tile: [i32; 2]) -> Weights {
    let corners = corners.map(|p| raster(matrix, p));
    let (first, w) = corners[0];
    let near = if w > 0.0 { first / w } else { first };
    let origin = [0, 1].map(|axis| {
        let pixel = (near[axis] as i32).saturating_add(matrix.middle[axis]) / SUBPIXELS;
        pixel.clamp(tile[axis], tile[axis] + TILE as i32 - 1)
    });
    let here = sample(matrix, origin);
    let q = corners.map(|(p, w)| p - here * w);
    let w = corners.map(|(_, w)| w);
    let step = f64::from(SUBPIXELS);
    let (mut at, mut right, mut down) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        at[k] = q[i].perp_dot(q[j]);
        right[k] = (w[j] * q[i].y - w[i] * q[j].y) * step;
        down[k] = (w[i] * q[j].x - w[j] * q[i].x) * step;
    }
    // The sum of the weights is this over W, and W is positive where the
    // triangle is seen.
    let determinant = at[0] * w[0] + at[1] * w[1] + at[2] * w[2];
    let size = at[0].abs() + at[1].abs() + at[2].abs();
    let scale = determinant.signum() / size.max(f64::MIN_POSITIVE);
    let single = |v: [f64; 3]| v.map(|v| (v * scale) as f32);
    Weights {
        triangle: NO_TRIANGLE,
        origin,
        at: single(at),
        right: single(right),
        down: single(down),
    }
}

/// The weights of a triangle's corners at the centre of one pixel, at least 0
/// and of sum 1, in double precision.
pub(crate) fn weights_at(matrix: &FrameMatrix, corners: [Vec3; 3], x: u32, y: u32) -> [f32; 3] {
    let here = sample(matrix, [x, y].map(u32::cast_signed));
    let corners = corners.map(|p| raster(matrix, p));
    let q = corners.map(|(p, w)| p - here * w);
    let b = [
        q[1].perp_dot(q[2]),
        q[2].perp_dot(q[0]),
        q[0].perp_dot(q[1]),
    ];
    let sign = (b[0] + b[1] + b[2]).signum();
    let b = b.map(|v| (v * sign).max(0.0));
    let sum = b[0] + b[1] + b[2];
    if sum > 0.0 {
        b.map(|v| (v / sum) as f32)
    } else {
        [1.0 / 3.0; 3]
    }
}

/// The positions of a block's samples along one axis, in sub-pixels from the
/// middle of the picture.
#[inline(always)]
pub(crate) fn sample_positions<S: Lanes>(
    s: S,
    lane: &[i32; LANES],
    first: usize,
    middle: i32,
) -> S::F {
    let start = first as i32 * SUBPIXELS + SUBPIXELS / 2 - middle;
    (s.load_i(lane).shl::<8>() + s.i(start)).to_float()
}

/// Weights of any sum made such that their sum is 1. Snapping moves corners by
/// up to 1/512 pixel, so a sample may lie a little outside the true triangle:
/// it takes the nearest values inside.
#[inline(always)]
fn proper<S: Lanes>(s: S, b: [S::F; 3]) -> [S::F; 3] {
    let zero = s.f(0.0);
    let b = triple!(|K| b[K].max(zero));
    let sum = b[0] + b[1] + b[2];
    let some = zero.lt(sum);
    let inverse = s.f(1.0) / some.select_f(sum, s.f(1.0));
    let third = s.f(1.0 / 3.0);
    triple!(|K| some.select_f(b[K] * inverse, third))
}

/// The weights of one triangle's corners at the pixels of a block.
#[inline(always)]
fn weights<S: Lanes>(s: S, of: &Weights, [px, py]: [usize; 2]) -> [S::F; 3] {
    let offset = [px as i32 - of.origin[0], py as i32 - of.origin[1]];
    let x = (s.load_i(&LANE_X) + s.i(offset[0])).to_float();
    let y = (s.load_i(&LANE_Y) + s.i(offset[1])).to_float();
    let b = triple!(|K| (s.f(of.right[K]) * x + s.f(of.down[K]) * y) + s.f(of.at[K]));
    proper(s, b)
}

/// The sum of the corners' values, weighted.
#[inline(always)]
fn mix<S: Lanes>(weight: [S::F; 3], values: [Triple<S>; 3]) -> Triple<S> {
    let [a, b, c] = values;
    triple!(|K| (weight[0] * a[K] + weight[1] * b[K]) + weight[2] * c[K])
}

#[inline(always)]
fn blend<S: Lanes>(here: S::M, new: Triple<S>, old: Triple<S>) -> Triple<S> {
    triple!(|K| here.select_f(new[K], old[K]))
}

/// Whether a block shows so many triangles that it is better interpolated lane
/// by lane.
#[inline(always)]
pub(crate) fn scattered(triangles: &[i32; LANES]) -> bool {
    let changes = (1..LANES).map(|k| u32::from(triangles[k - 1] != triangles[k]));
    changes.sum::<u32>() >= SCATTERED
}

/// Interpolates what the pixels of a job show, one triangle after the other.
/// Points are found only where shading asks for them; with Gouraud and flat
/// shading the "normals" are finished colours.
#[inline(always)]
pub(crate) fn interpolate_few<S: Lanes>(
    s: S,
    context: &ShadeContext,
    cache: &mut Cache,
    job: &Job,
    to: &mut Fragments,
) {
    let scene = context.scene;
    let zero = s.f(0.0);
    let (mut normal, mut point) = ([zero; 3], [zero; 3]);
    let mut material = None;
    let all = s.load_i(&job.triangles);
    let mut wanted = job.wanted;
    while wanted != 0 {
        let index = job.triangles[wanted.trailing_zeros() as usize % LANES];
        let here = all.eq(s.i(index));
        wanted &= !here.bits();
        let (triangle, section) = decode(index);
        let own = match section {
            None => context.material(triangle),
            Some(_) => context.cap_material(),
        };
        material = match material {
            None => Some(own),
            Some(one) if one == own => material,
            Some(_) => Some(MIXED),
        };
        if let Some(section) = section {
            let (n, p) = cap(s, context, job, section, here);
            normal = blend::<S>(here, n, normal);
            point = blend::<S>(here, p, point);
            continue;
        }
        let (Some(vertices), Some(normals)) =
            (scene.triangles.get(triangle), scene.normals.get(triangle))
        else {
            continue;
        };
        let corners = triple!(|K| scene.positions[vertices[K] as usize]);
        let values = match context.interpolation {
            Interpolation::Phong => *normals,
            Interpolation::Gouraud => context.corner_colours(triangle, &corners, normals),
            Interpolation::Flat => [context.flat_colour(triangle, &corners); 3],
        };
        let plain = values[0] == values[1] && values[0] == values[2] && !context.positional;
        if plain {
            normal = blend::<S>(here, splat(s, values[0]), normal);
            continue;
        }
        let weight = weights(
            s,
            cache.get(context.matrix, index, &corners, job.at),
            job.at,
        );
        let mixed = mix::<S>(weight, triple!(|K| splat(s, values[K])));
        normal = blend::<S>(here, mixed, normal);
        if context.positional {
            let mixed = mix::<S>(weight, triple!(|K| splat(s, corners[K])));
            point = blend::<S>(here, mixed, point);
        }
    }
    store::<S>(normal, &mut to.normal);
    if context.positional {
        store::<S>(point, &mut to.point);
    }
    to.material = material.unwrap_or(0);
}

/// One row of the matrix applied to 16 points.
#[inline(always)]
fn row<S: Lanes>(s: S, r: Vec4, p: Triple<S>) -> S::F {
    (s.f(r.x) * p[0] + s.f(r.y) * p[1]) + (s.f(r.z) * p[2] + s.f(r.w))
}

/// The corners of 16 triangles and their normals: x, y and z by corner.
#[derive(Clone, Debug, Default)]
pub(crate) struct Corners {
    position: [[[f32; LANES]; 3]; 3],
    normal: [[[f32; LANES]; 3]; 3],
}

impl Corners {
    /// Fetches a triangle from its cluster, where what belongs together lies
    /// together: neighbouring pixels show triangles of few clusters.
    #[inline(always)]
    fn gather(&mut self, scene: &Scene, cluster: &ClusterView, triangle: usize, lane: usize) {
        let Some(local) = scene.local.get(triangle) else {
            return;
        };
        for c in 0..3 {
            let vertex = usize::from(local[c]) % CLUSTER_VERTICES;
            for axis in 0..3 {
                self.position[c][axis][lane] = cluster.positions[axis][vertex];
                self.normal[c][axis][lane] = cluster.normals[axis][vertex];
            }
        }
        if cluster.smooth {
            return;
        }
        if let Some(normals) = scene.normals.get(triangle) {
            for (to, normal) in self.normal.iter_mut().zip(normals) {
                for axis in 0..3 {
                    to[axis][lane] = normal[axis];
                }
            }
        }
    }
}

/// The same for Phong shading, each lane with its own triangle.
#[inline(always)]
pub(crate) fn interpolate_scattered<S: Lanes>(
    s: S,
    context: &ShadeContext,
    corners: &mut Corners,
    job: &Job,
    to: &mut Fragments,
) {
    let (scene, matrix) = (context.scene, context.matrix);
    let mut wanted = job.wanted;
    let mut material = None;
    let mut cluster: Option<ClusterView> = None;
    while wanted != 0 {
        let lane = wanted.trailing_zeros() as usize % LANES;
        wanted &= wanted - 1;
        let triangle = job.triangles[lane] as usize;
        if !cluster
            .as_ref()
            .is_some_and(|c| c.triangles.contains(&triangle))
        {
            cluster = scene.cluster_view(triangle);
        }
        if let Some(cluster) = &cluster {
            corners.gather(scene, cluster, triangle, lane);
        }
        let own = context.material(triangle);
        material = match material {
            None => Some(own),
            Some(one) if one == own => material,
            Some(_) => Some(MIXED),
        };
    }
    let x = sample_positions(s, &LANE_X, job.at[0], matrix.middle[0]);
    let y = sample_positions(s, &LANE_Y, job.at[1], matrix.middle[1]);
    let position = triple!(|K| load(s, &corners.position[K]));
    let w = triple!(|K| row(s, matrix.rows[3], position[K]));
    let qx = triple!(|K| row(s, matrix.rows[0], position[K]) - x * w[K]);
    let qy = triple!(|K| row(s, matrix.rows[1], position[K]) - y * w[K]);
    let b = [
        qx[1] * qy[2] - qy[1] * qx[2],
        qx[2] * qy[0] - qy[2] * qx[0],
        qx[0] * qy[1] - qy[0] * qx[1],
    ];
    let zero = s.f(0.0);
    let sign = (b[0] + b[1] + b[2]).lt(zero).select_f(s.f(-1.0), s.f(1.0));
    let weight = proper(s, triple!(|K| b[K] * sign));
    let normal = mix::<S>(weight, triple!(|K| load(s, &corners.normal[K])));
    store::<S>(normal, &mut to.normal);
    if context.positional {
        store::<S>(mix::<S>(weight, position), &mut to.point);
    }
    to.material = material.unwrap_or(0);
}

/// Normal (or finished colour) and points of the cap of a section.
#[inline(always)]
fn cap<S: Lanes>(
    s: S,
    context: &ShadeContext,
    job: &Job,
    section: usize,
    here: S::M,
) -> (Triple<S>, Triple<S>) {
    let zero = [s.f(0.0); 3];
    let Some(plane) = context.scene.sections.get(section) else {
        return (zero, zero);
    };
    let mut points = [[0f32; LANES]; 3];
    let mut lanes = here.bits();
    let mut some = Vec3::ZERO;
    while lanes != 0 {
        let k = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        some = context.cap_point(job, section, k);
        for (lane, value) in points.iter_mut().zip(some.to_array()) {
            lane[k] = value;
        }
    }
    let value = if context.interpolation == Interpolation::Phong {
        plane.normal
    } else {
        context.cap_colour(some, plane.normal)
    };
    (splat(s, value), load(s, &points))
}
