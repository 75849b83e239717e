//! What a triangle gives to the pixels of a tile: its corners' weights as
//! linear functions, found in double precision and kept for the blocks around
//! (see [`interpolate`](crate::interpolate)).

use glam::{DVec2, DVec3, DVec4, Vec3};

use crate::fixed::SUBPIXELS;
use crate::frame::FrameMatrix;
use crate::shade::Interpolation;
use crate::shading::ShadeContext;
use crate::tile::{NO_TRIANGLE, TILE};

/// Triangles whose weights are kept: neighbouring blocks mostly show the same
/// ones.
const KEPT: usize = 256;

/// The weights of one triangle's corners in one tile, as linear functions: at
/// the sample of the pixel `origin` + (x, y), corner k weighs
/// `at[k] + x right[k] + y down[k]`, up to a positive factor common to all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    pub origin: [i32; 2],
    pub at: [f32; 3],
    pub right: [f32; 3],
    pub down: [f32; 3],
}

/// How the normal (or finished colour) of a triangle is found in one tile.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Interpolant {
    /// The same everywhere.
    Constant(Vec3),
    /// As a linear function like [`Weights`], of the right direction and some
    /// length.
    Linear {
        origin: [i32; 2],
        at: [f32; 3],
        right: [f32; 3],
        down: [f32; 3],
    },
    /// By weights, from values at the corners.
    Weighted {
        weights: Weights,
        values: [Vec3; 3],
        /// The corners themselves.
        points: [Vec3; 3],
    },
}

/// A triangle met lately.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    triangle: i32,
    pub material: usize,
    pub interpolant: Interpolant,
}

/// The triangles of one tile met lately, in a small direct-mapped cache.
#[derive(Clone, Debug)]
pub(crate) struct Cache(Box<[Kept]>);

impl Default for Cache {
    fn default() -> Self {
        let none = Kept {
            triangle: NO_TRIANGLE,
            material: 0,
            interpolant: Interpolant::Constant(Vec3::ZERO),
        };
        // (On the heap: threads that steal work put many of these on a stack.)
        Self(vec![none; KEPT].into())
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
    pub fn get(&mut self, context: &ShadeContext, index: i32, [px, py]: [usize; 2]) -> &Kept {
        let entry = &mut self.0[index as usize % KEPT];
        if entry.triangle != index {
            let tile = [px, py].map(|p| (p - p % TILE) as i32);
            *entry = Kept {
                triangle: index,
                material: context.material(index as usize),
                interpolant: interpolant(context, index as usize, tile),
            };
        }
        entry
    }
}

/// Prepares to interpolate a triangle in the tile of that first pixel.
#[inline(never)]
fn interpolant(context: &ShadeContext, triangle: usize, tile: [i32; 2]) -> Interpolant {
    let (Some(corners), Some(normals)) = (
        context.scene.corners(triangle),
        context.scene.corner_normals(triangle),
    ) else {
        return Interpolant::Constant(Vec3::ZERO);
    };
    let values = match context.interpolation {
        Interpolation::Phong => normals,
        Interpolation::Gouraud => context.corner_colours(triangle, &corners, &normals),
        Interpolation::Flat => [context.flat_colour(triangle, &corners); 3],
    };
    if values[0] == values[1] && values[0] == values[2] && !context.positional {
        return Interpolant::Constant(values[0]);
    }
    let weights = linear_weights(context.matrix, &corners, tile);
    let fat = (0..3).all(|k| {
        let (right, down) = (weights.right[k], weights.down[k]);
        right * right + down * down < STEEP * STEEP
    });
    let normals_only = context.interpolation == Interpolation::Phong && !context.positional;
    if !(fat && normals_only && context.centred) {
        return Interpolant::Weighted {
            weights,
            values,
            points: corners.map(DVec3::as_vec3),
        };
    }
    let sum = |w: [f32; 3]| (values[0] * w[0] + values[1] * w[1] + values[2] * w[2]).to_array();
    Interpolant::Linear {
        origin: weights.origin,
        at: sum(weights.at),
        right: sum(weights.right),
        down: sum(weights.down),
    }
}

/// Snapping moves corners by up to 1/512 pixel, so a covered pixel's centre may
/// lie a little outside the true triangle. Where weights change by less than
/// this in a pixel (of a sum about 1), that makes no difference that could be
/// seen; where they change more, or a pixel may be covered at other samples
/// than its centre, they are kept at 0 or above.
const STEEP: f32 = 16.0;

/// A point's X, Y and W in double precision.
fn raster(matrix: &FrameMatrix, p: DVec3) -> (DVec2, f64) {
    let p = p.extend(1.0);
    let row = |k: usize| DVec4::dot(matrix.rows[k], p);
    (DVec2::new(row(0), row(1)), row(3))
}

/// The middle of a pixel, in sub-pixels from the middle of the picture.
pub(crate) fn sample(matrix: &FrameMatrix, pixel: [i32; 2]) -> DVec2 {
    let [x, y] = [0, 1].map(|axis| pixel[axis] * SUBPIXELS + SUBPIXELS / 2 - matrix.middle[axis]);
    DVec2::new(f64::from(x), f64::from(y))
}

/// The linear weights of a triangle in a tile. Their origin is the pixel of
/// the tile nearest to the first corner, so that the functions are not
/// extended far beyond the triangle.
fn linear_weights(matrix: &FrameMatrix, corners: &[DVec3; 3], tile: [i32; 2]) -> Weights {
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
        origin,
        at: single(at),
        right: single(right),
        down: single(down),
    }
}

/// The weights of a triangle's corners at the centre of one pixel, at least 0
/// and of sum 1, in double precision.
pub(crate) fn weights_at(matrix: &FrameMatrix, corners: [DVec3; 3], x: u32, y: u32) -> [f32; 3] {
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
