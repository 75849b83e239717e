//! The points that occlusion is found from: what every so manieth pixel shows.

use glam::{DMat4, DVec3, DVec4};
use rayon::prelude::*;

use crate::camera::View;
use crate::frame::FrameMatrix;
use crate::ground::Ground;
use crate::pipeline::Renderer;
use crate::simd::{DoubleLanes, FloatLanes, Kernel, LANE_NUMBERS, LANES, Lanes, MaskLanes, triple};
use crate::viewport::Viewport;

/// The most samples of a picture: what fits a cache.
const MOST_SAMPLES: u64 = 250_000;

/// The pixels that are sampled: every `step`-th of every `step`-th row, where
/// `step` is a power of two.
pub(super) struct Grid {
    pub step: usize,
    pub width: usize,
    pub height: usize,
    /// From one row to the next: a row, whole vectors of it, and one sample of
    /// nothing before and after it.
    pub stride: usize,
    /// x, y and z relative to the scene's centre, or NaN where there is
    /// nothing; from the row of nothing before the first to that after the
    /// last.
    points: Vec<[f32; 4]>,
    /// Reversed depths likewise, 0 where there is no surface.
    depths: Vec<f32>,
}

impl Grid {
    pub fn new(
        renderer: &Renderer,
        view: &View,
        matrix: &FrameMatrix,
        ground: Option<&Ground>,
    ) -> Self {
        let pixels = u64::from(renderer.width) * u64::from(renderer.height);
        let mut step = 1;
        while pixels > MOST_SAMPLES * step * step {
            step *= 2;
        }
        let step = step as usize;
        let [width, height] =
            [renderer.width, renderer.height].map(|side| (side as usize).div_ceil(step));
        let stride = width.next_multiple_of(LANES) + 2;
        let mut points = vec![[f32::NAN; 4]; stride * (height + 2)];
        let mut depths = vec![0.0; points.len()];
        let to_scene = unprojection(view, matrix).transpose();
        let rows = points.par_chunks_mut(stride);
        let rows = rows.zip(depths.par_chunks_mut(stride)).skip(1).take(height);
        rows.enumerate().for_each(|(y, (points, depths))| {
            renderer.level.run(FillRow {
                renderer,
                to_scene: &to_scene,
                ground,
                step,
                y,
                points: &mut points[1..],
                depths: &mut depths[1..],
            });
        });
        Self {
            step,
            width,
            height,
            stride,
            points,
            depths,
        }
    }

    /// Where a sample, of which there is one more on each side, is kept.
    fn index(&self, x: usize, y: usize) -> usize {
        (y + 1) * self.stride + x + 1
    }

    /// Reversed depths of a row.
    pub fn depths(&self, y: usize) -> &[f32] {
        let first = self.index(0, y);
        &self.depths[first..first + self.width]
    }

    /// The reversed depth of a sample, of the last one for any beyond.
    pub fn depth(&self, x: usize, y: usize) -> f32 {
        self.depths[self.index(x, y)]
    }

    /// All points; the first one of the picture is the `stride + 1`-th.
    pub fn points(&self) -> &[[f32; 4]] {
        &self.points
    }

    /// Points and depths from one sample on, moved by so many columns (-1 to 1)
    /// and rows (likewise).
    #[inline(always)]
    pub fn vector<S: Lanes>(
        &self,
        s: S,
        [x, y]: [usize; 2],
        [right, down]: [usize; 2],
    ) -> ([S::F; 3], S::F) {
        let first = (y + down) * self.stride + x + right;
        let range = first..first + LANES;
        let points = self.points[range.clone()].first_chunk();
        let depths = self.depths[range].first_chunk();
        let none = ([[f32::NAN; 4]; LANES], [0.0; LANES]);
        let points = s.columns(points.unwrap_or(&none.0));
        (points, s.load_f(depths.unwrap_or(&none.1)))
    }

    /// The nearest and the farthest depth of any surface.
    pub fn depth_range(&self) -> (f32, f32) {
        let surfaces = self.depths.iter().filter(|&&depth| depth > 0.0);
        surfaces.fold((0.0, 1.0), |(near, far), &depth| {
            (f32::max(near, depth), f32::min(far, depth))
        })
    }
}

/// Pixels, with reversed depth, to points relative to the scene's centre.
fn unprojection(view: &View, matrix: &FrameMatrix) -> DMat4 {
    let viewport = Viewport::of_image(matrix.width, matrix.height);
    let to_ndc = DMat4::from_cols(
        DVec4::new(2.0 / viewport.width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -2.0 / viewport.height, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -2.0, 0.0),
        DVec4::new(-1.0, 1.0, 1.0, 1.0),
    );
    DMat4::from_translation(-matrix.centre) * view.clip_to_world() * to_ndc
}

/// Fills a row of the grid.
struct FillRow<'a> {
    renderer: &'a Renderer,
    /// Transposed: a column for each of x, y, z and w.
    to_scene: &'a DMat4,
    ground: Option<&'a Ground>,
    step: usize,
    y: usize,
    points: &'a mut [[f32; 4]],
    depths: &'a mut [f32],
}

impl Kernel for FillRow<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let py = self.y * self.step;
        let middle = py as f64 + 0.5;
        let columns = self.to_scene;
        let of_axes = [columns.x_axis, columns.y_axis, columns.z_axis];
        let ground = self.ground.map(Ground::in_window);
        let (zero, one) = (s.f(0.0), s.f(1.0));
        let nothing = s.f(f32::NAN);
        let rows = self.points.chunks_exact_mut(LANES);
        let rows = rows.zip(self.depths.chunks_exact_mut(LANES)).enumerate();
        for (number, (points, depths)) in rows {
            let first = number * LANES;
            let mut found = [0.0; LANES];
            let mut any = ground.is_some();
            for (k, depth) in found.iter_mut().enumerate() {
                let px = (first + k) * self.step;
                if let Some((_, here)) = self.renderer.number(px as u32, py as u32) {
                    *depth = here;
                    any = true;
                }
            }
            if !any {
                continue;
            }
            depths.copy_from_slice(&found);
            let lanes = s.load_f(&LANE_NUMBERS).to_double();
            let x = (s.d(first as f64) + lanes) * s.d(self.step as f64) + s.d(0.5);
            let depth = s.load_f(&found);
            let mut is_there = zero.lt(depth);
            let mut seen = depth;
            if let Some([before, plane]) = ground {
                let of_ground = on_row(s, plane, middle, x);
                let before = zero.lt(on_row(s, before, middle, x));
                let on_ground = before & zero.le(of_ground) & of_ground.le(one);
                seen = is_there.select_f(depth, of_ground);
                is_there = is_there | on_ground;
            }
            let z = seen.to_double();
            let w = transformed(s, columns.w_axis, middle, x, z);
            let point = triple!(|K| transformed(s, of_axes[K], middle, x, z) / w);
            let point = triple!(|K| is_there.select_f(point[K].to_single(), nothing));
            let mut values = [[0.0; LANES]; 3];
            triple!(|K| point[K].store(&mut values[K]));
            for (k, to) in points.iter_mut().enumerate() {
                *to = [values[0][k], values[1][k], values[2][k], 0.0];
            }
        }
    }
}

/// What a linear function of the window is in a row of pixels.
#[inline(always)]
fn on_row<S: Lanes>(s: S, function: DVec3, y: f64, x: S::D) -> S::F {
    (s.d(function.x) * x + s.d(function.y * y + function.z)).to_single()
}

/// A row of a matrix applied to points (x, y, z, 1) of a row of pixels.
#[inline(always)]
fn transformed<S: Lanes>(s: S, row: DVec4, y: f64, x: S::D, z: S::D) -> S::D {
    (s.d(row.x) * x + s.d(row.z) * z) + s.d(row.y * y + row.w)
}
