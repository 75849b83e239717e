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

use glam::{DVec3, DVec4};

use crate::corners::Corners;
use crate::deferred::{Fragments, Job, shared};
use crate::fill::{LANE_X, LANE_Y};
use crate::fixed::SUBPIXELS;
use crate::interpolant::{Cache, Interpolant, Weights};
use crate::shade::Interpolation;
use crate::shading::ShadeContext;
use crate::simd::vector::{Triple, load, splat, store};
use crate::simd::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};
use crate::tile::decode;

/// So many changes of triangle from one lane of a block to the next are worth
/// finding weights lane by lane.
const SCATTERED: u32 = 8;

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

/// Three linear functions like [`Weights`] at the pixels of a block.
#[inline(always)]
fn linear<S: Lanes>(
    s: S,
    origin: [i32; 2],
    [at, right, down]: [&[f32; 3]; 3],
    [px, py]: [usize; 2],
) -> Triple<S> {
    let offset = [px as i32 - origin[0], py as i32 - origin[1]];
    let x = (s.load_i(&LANE_X) + s.i(offset[0])).to_float();
    let y = (s.load_i(&LANE_Y) + s.i(offset[1])).to_float();
    triple!(|K| (s.f(right[K]) * x + s.f(down[K]) * y) + s.f(at[K]))
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
    let zero = s.f(0.0);
    let (mut normal, mut point) = ([zero; 3], [zero; 3]);
    let mut material = None;
    let all = s.load_i(&job.triangles);
    let mut wanted = job.wanted;
    while wanted != 0 {
        let index = job.triangles[wanted.trailing_zeros() as usize % LANES];
        let here = all.eq(s.i(index));
        wanted &= !here.bits();
        if let (_, Some(section)) = decode(index) {
            let (n, p) = cap(s, context, job, section, here);
            normal = blend::<S>(here, n, normal);
            point = blend::<S>(here, p, point);
            material = shared(material, context.cap_material());
            continue;
        }
        let kept = cache.get(context, index, job.at);
        material = shared(material, kept.material);
        let found = match &kept.interpolant {
            Interpolant::Constant(value) => splat(s, *value),
            Interpolant::Linear {
                origin,
                at,
                right,
                down,
            } => linear(s, *origin, [at, right, down], job.at),
            Interpolant::Weighted {
                weights,
                values,
                points,
            } => {
                let Weights {
                    origin,
                    at,
                    right,
                    down,
                } = weights;
                let weight = proper(s, linear(s, *origin, [at, right, down], job.at));
                if context.positional {
                    let mixed = mix::<S>(weight, triple!(|K| splat(s, points[K])));
                    point = blend::<S>(here, mixed, point);
                }
                mix::<S>(weight, triple!(|K| splat(s, values[K])))
            }
        };
        normal = blend::<S>(here, found, normal);
    }
    store::<S>(normal, &mut to.normal);
    if context.positional {
        store::<S>(point, &mut to.point);
    }
    to.material = material.unwrap_or(0);
}

/// One row of the matrix applied to 16 points.
#[inline(always)]
fn row<S: Lanes>(s: S, r: DVec4, p: [S::D; 3]) -> S::D {
    (s.d(r.x) * p[0] + s.d(r.y) * p[1]) + (s.d(r.z) * p[2] + s.d(r.w))
}

/// The same for Phong shading, each lane with its own triangle, whose corners
/// have been fetched.
#[inline(always)]
pub(crate) fn interpolate_scattered<S: Lanes>(
    s: S,
    context: &ShadeContext,
    corners: &Corners,
    job: &Job,
    to: &mut Fragments,
) {
    let matrix = context.matrix;
    // Differences of numbers that may be far larger than they: taken in double
    // precision.
    let x = sample_positions(s, &LANE_X, job.at[0], matrix.middle[0]).to_double();
    let y = sample_positions(s, &LANE_Y, job.at[1], matrix.middle[1]).to_double();
    let position = triple!(|K| s.columns(&corners.position[K]));
    let wide = triple!(|K| {
        let p = position[K];
        [p[0].to_double(), p[1].to_double(), p[2].to_double()]
    });
    let w = triple!(|K| row(s, matrix.rows[3], wide[K]));
    let qx = triple!(|K| (row(s, matrix.rows[0], wide[K]) - x * w[K]).to_single());
    let qy = triple!(|K| (row(s, matrix.rows[1], wide[K]) - y * w[K]).to_single());
    let b = [
        qx[1] * qy[2] - qy[1] * qx[2],
        qx[2] * qy[0] - qy[2] * qx[0],
        qx[0] * qy[1] - qy[0] * qx[1],
    ];
    let zero = s.f(0.0);
    let sign = (b[0] + b[1] + b[2]).lt(zero).select_f(s.f(-1.0), s.f(1.0));
    let weight = proper(s, triple!(|K| b[K] * sign));
    let normal = mix::<S>(weight, triple!(|K| s.columns(&corners.normal[K])));
    store::<S>(normal, &mut to.normal);
    if context.positional {
        store::<S>(mix::<S>(weight, position), &mut to.point);
    }
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
    let mut some = DVec3::ZERO;
    while lanes != 0 {
        let k = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        some = context.cap_point(job, section, k);
        for (lane, value) in points.iter_mut().zip(some.as_vec3().to_array()) {
            lane[k] = value;
        }
    }
    let value = if context.interpolation == Interpolation::Phong {
        plane.normal.as_vec3()
    } else {
        context.cap_colour(some, plane.normal)
    };
    (splat(s, value), load(s, &points))
}

#[cfg(test)]
mod tests {
    use csg::Mesh;
    use glam::{DMat3, DMat4, Vec3};
    use proptest::prelude::*;

    use super::*;
    use crate::camera::View;
    use crate::frame::FrameMatrix;
    use crate::interpolant::sample;
    use crate::options::RenderOptions;
    use crate::prepared::Prepared;
    use crate::simd::{Kernel, Level};
    use crate::smooth::ClusterView;
    use crate::tile::BLOCK;

    const SIZE: u32 = 512;

    /// Interpolates a block of the first triangle, in one way or the other.
    struct OneBlock<'a> {
        context: &'a ShadeContext<'a>,
        job: Job,
        by_lane: bool,
    }

    impl Kernel for OneBlock<'_> {
        type Output = Fragments;
        #[inline(always)]
        fn run<S: Lanes>(self, s: S) -> Fragments {
            let mut to = Fragments::default();
            let (context, job) = (self.context, &self.job);
            if self.by_lane {
                let mut corners = Corners::default();
                to.material = corners.fetch(context, &mut ClusterView::default(), job);
                interpolate_scattered(s, context, &corners, job, &mut to);
            } else {
                interpolate_few(s, context, &mut Cache::default(), job, &mut to);
            }
            to
        }
    }

    proptest! {
        /// Corners up to ten thousand times as far away as others; the normal
        /// against the corners' weights in the plane of the triangle, found
        /// in double precision.
        #[test]
        fn attributes_are_perspective_correct(
            corners in proptest::array::uniform3((-0.9..0.9f64, -0.9..0.9f64, 0.0..1.0f64)),
            normals in proptest::array::uniform3(proptest::array::uniform3(0.1..1.0f32)),
            weights in proptest::array::uniform3(0.1..1.0f64),
        ) {
            let eye_to_clip = crate::projection::perspective(1.0, 1.0, 0.1, 1e4);
            let view = View::new(DMat4::IDENTITY, eye_to_clip).unwrap();
            let half = 0.5f64.tan();
            let positions = corners.map(|(x, y, far)| {
                let distance = 0.2 * 1e4f64.powf(far);
                DVec3::new(x * half, y * half, -1.0) * distance
            });
            let mut mesh = Mesh::new(positions.to_vec(), vec![[0, 1, 2]]);
            mesh.corner_normals = vec![normals.map(|n| Vec3::from_array(n).normalize())];
            let scene = Prepared::new(&mesh);
            let matrix = FrameMatrix::new(&view, scene.centre, SIZE, SIZE);
            let options = RenderOptions::default();
            let context = ShadeContext::new(&scene, &view, &matrix, &options);
            let raster = [0, 1, 2].map(|k| {
                let row = |row| matrix.row(row, scene.positions[k].as_dvec3());
                DVec3::new(row(0), row(1), row(3))
            });
            // In pixels: slivers have no precise attributes.
            let seen = raster.map(|p| p.truncate() / p.z / f64::from(SUBPIXELS));
            let area = (seen[1] - seen[0]).perp_dot(seen[2] - seen[0]).abs();
            let longest = (0..3).map(|k| seen[k].distance(seen[(k + 1) % 3])).fold(0.0, f64::max);
            prop_assume!(area / longest > 32.0);
            let total = weights[0] + weights[1] + weights[2];
            let at = (seen[0] * weights[0] + seen[1] * weights[1] + seen[2] * weights[2]) / total;
            let block = [at.x, at.y].map(|v| {
                let pixel = (v + f64::from(SIZE) / 2.0) as usize;
                pixel - pixel % BLOCK
            });
            let to_weights = DMat3::from_cols(raster[0], raster[1], raster[2]).inverse();
            for by_lane in [false, true] {
                let job = Job { triangles: [0; LANES], wanted: 0xffff, at: block };
                let found = Level::best().run(OneBlock { context: &context, job, by_lane });
                for lane in 0..LANES {
                    let pixel = [block[0] as i32 + LANE_X[lane], block[1] as i32 + LANE_Y[lane]];
                    let weight = to_weights * sample(&matrix, pixel).extend(1.0);
                    if weight.min_element() <= 0.0 {
                        continue;
                    }
                    let corner = |k: usize| mesh.corner_normals[0][k].as_dvec3() * weight[k];
                    let exact = (corner(0) + corner(1) + corner(2)).normalize();
                    let normal = found.normal.map(|axis| f64::from(axis[lane]));
                    let error = DVec3::from_array(normal).normalize() - exact;
                    prop_assert!(error.abs().max_element() < 1e-5, "{by_lane}: {error}");
                }
            }
        }
    }
}
