//! How open each sample is.

use std::f64::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use super::grid::Grid;
use crate::frame::FrameMatrix;
use crate::prepared::Prepared;
use crate::simd::vector::{dot, inverse_sqrt, splat};
use crate::simd::{
    FloatLanes, IntLanes, Kernel, LANE_NUMBERS, LANES, Lanes, Level, MaskLanes, triple,
};

/// Samples around each pixel.
const SAMPLES: usize = 16;
/// Radius of the neighbourhood in parts of the scene's diagonal, and the most
/// in parts of the picture's longer side.
const RADIUS: f64 = 0.12;
const MOST: f64 = 0.12;
/// Turns of the spiral; coprime to the samples.
const TURNS: f64 = 7.0;
/// Strength of the darkening.
const STRENGTH: f32 = 3.0;
/// Side of the square of pixels whose spirals are turned apart.
const PATTERN: usize = 4;

/// Steps to the samples of a spiral, in parts of its radius, right and down,
/// for each lane of a vector.
type Spirals = [[[f32; LANES]; 2]; SAMPLES];

/// Those of each row of the pattern.
fn spirals() -> [Spirals; PATTERN] {
    // Bayer's 4x4 matrix turns the spirals of neighbours apart.
    const TURN: [[u8; PATTERN]; PATTERN] =
        [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    TURN.map(|turns| {
        std::array::from_fn(|k| {
            let share = (k as f64 + 0.5) / SAMPLES as f64;
            let steps = |lane: usize| {
                let angle = (share * TURNS + f64::from(turns[lane % PATTERN]) / 16.0) * TAU;
                let (sin, cos) = angle.sin_cos();
                [(cos * share) as f32, (sin * share) as f32]
            };
            let steps: [_; LANES] = std::array::from_fn(steps);
            [steps.map(|step| step[0]), steps.map(|step| step[1])]
        })
    })
}

/// The openness of all samples, row by row, without the pattern of the spirals.
pub(super) fn openness(
    level: Level,
    grid: &Grid,
    matrix: &FrameMatrix,
    scene: &Prepared,
) -> Vec<f32> {
    let (low, high) = scene.bounds();
    let context = Context {
        grid,
        whole: ((high - low).length() * RADIUS).max(f64::MIN_POSITIVE) as f32,
        scale: (matrix.rows[0].truncate().length() / 256.0 / grid.step as f64) as f32,
        most: (grid.width.max(grid.height) as f64 * MOST) as f32,
        depth: matrix.rows[3].as_vec4().to_array(),
        viewer: matrix.viewer.truncate().as_vec3(),
        is_near: matrix.viewer.w as f32,
        spirals: &spirals(),
    };
    let width = grid.width.next_multiple_of(LANES).max(LANES);
    let mut raw = vec![0.0; width * grid.height];
    let rows = raw.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, to)| level.run(OpenRow { context, y, to }));
    without_pattern(grid, &raw, width)
}

/// What the openness of a row is found from.
#[derive(Clone, Copy)]
struct Context<'a> {
    grid: &'a Grid,
    /// Radius of the neighbourhood.
    whole: f32,
    /// Samples a unit of length, times W.
    scale: f32,
    /// The largest radius in samples.
    most: f32,
    /// W of a point (x, y, z, 1).
    depth: [f32; 4],
    /// The viewer's place, if `is_near` is 1; else the direction towards him.
    viewer: Vec3,
    is_near: f32,
    spirals: &'a [Spirals; PATTERN],
}

/// Finds the openness of a row of samples, each by its spiral; 0 without a
/// surface.
struct OpenRow<'a> {
    context: Context<'a>,
    y: usize,
    to: &'a mut [f32],
}

impl Kernel for OpenRow<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let Self { context, y, to } = self;
        for (number, to) in to.chunks_exact_mut(LANES).enumerate() {
            if let Some(to) = to.first_chunk_mut() {
                open(s, &context, [number * LANES, y], to);
            }
        }
    }
}

/// The same of sixteen.
#[inline(always)]
fn open<S: Lanes>(s: S, context: &Context, at: [usize; 2], to: &mut [f32; LANES]) {
    let grid = context.grid;
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let (here, depth) = grid.vector(s, at, [1, 1]);
    let surface = zero.lt(depth);
    if surface.bits() == 0 {
        return;
    }
    let w = (here[0] * s.f(context.depth[0]) + here[1] * s.f(context.depth[1]))
        + (here[2] * s.f(context.depth[2]) + s.f(context.depth[3]));
    let unit = s.f(context.scale) / w;
    let pixels = (s.f(context.whole) * unit).min(s.f(context.most));
    let radius = pixels / unit;
    let viewer = splat(s, context.viewer);
    let viewer = triple!(|K| viewer[K] - here[K] * s.f(context.is_near));
    let normal = normal(s, grid, at, here, viewer);
    let slack = s.f(0.01) * radius;
    let per_square = one / (radius * radius);
    let row = s.i(at[1] as i32);
    let column = (s.load_f(&LANE_NUMBERS) + s.f(at[0] as f32)).round();
    let (width, height) = (s.i(grid.width as i32), s.i(grid.height as i32));
    let (before, next) = (s.i(-1), s.i(1));
    let points = grid.points();
    let mut sum = zero;
    for [right, down] in &context.spirals[at[1] % PATTERN] {
        let x = column + (s.load_f(right) * pixels).round();
        let y = row + (s.load_f(down) * pixels).round();
        let inside = before.lt(x) & x.lt(width) & before.lt(y) & y.lt(height);
        let x = x.max(before).min(width);
        let y = y.max(before).min(height);
        let mut places = [0; LANES];
        ((y + next) * s.i(grid.stride as i32) + (x + next)).store(&mut places);
        let mut others = [[0.0; 4]; LANES];
        for (other, place) in others.iter_mut().zip(places) {
            *other = points.get(place as usize).copied().unwrap_or_default();
        }
        let other = s.columns(&others);
        let v = triple!(|K| other[K] - here[K]);
        let squared = dot::<S>(v, v);
        let near = one - squared * per_square;
        let rise = (dot::<S>(v, normal) - slack) / (squared.sqrt() + slack);
        // (False for NaN: where there is nothing.)
        let counts = inside & zero.lt(near) & zero.lt(rise);
        sum = sum + counts.select_f(near * rise, zero);
    }
    let open = (one - s.f(STRENGTH / SAMPLES as f32) * sum)
        .max(zero)
        .min(one);
    surface.select_f(open, zero).store(to);
}

/// The unit normals at sixteen samples, towards the viewer: from the nearer of
/// their neighbours either way, so that they do not mix two surfaces.
#[inline(always)]
fn normal<S: Lanes>(
    s: S,
    grid: &Grid,
    at: [usize; 2],
    here: [S::F; 3],
    viewer: [S::F; 3],
) -> [S::F; 3] {
    let zero = s.f(0.0);
    let far = s.f(f32::INFINITY);
    let mut sides = [[zero; 3]; 2];
    for (side, (after, before)) in sides.iter_mut().zip([([2, 1], [0, 1]), ([1, 2], [1, 0])]) {
        let (next, depth) = grid.vector(s, at, after);
        let forth = triple!(|K| next[K] - here[K]);
        let length = zero.lt(depth).select_f(dot::<S>(forth, forth), far);
        let (last, depth) = grid.vector(s, at, before);
        let back = triple!(|K| here[K] - last[K]);
        let other = zero.lt(depth).select_f(dot::<S>(back, back), far);
        let is_back = other.lt(length);
        let any = other.lt(far) | length.lt(far);
        let nearer = triple!(|K| is_back.select_f(back[K], forth[K]));
        *side = triple!(|K| any.select_f(nearer[K], zero));
    }
    let [[a, b, c], [d, e, f]] = sides;
    let cross = [b * f - c * e, c * d - a * f, a * e - b * d];
    let away = dot::<S>(cross, viewer).lt(zero);
    let length = inverse_sqrt(s, dot::<S>(cross, cross));
    let length = away.select_f(zero - length, length);
    triple!(|K| cross[K] * length)
}

/// Means over the 4x4 pattern, leaving out samples without a surface.
fn without_pattern(grid: &Grid, raw: &[f32], width: usize) -> Vec<f32> {
    let mut smooth = vec![1.0; raw.len()];
    let rows = smooth.par_chunks_mut(width).enumerate();
    rows.for_each_init(Vec::new, |sums, (y, row)| {
        // Sums of columns, after two and before one that are empty.
        sums.clear();
        sums.resize(grid.width + PATTERN, [0.0f32; 2]);
        for line in y.saturating_sub(PATTERN / 2)..(y + PATTERN / 2).min(grid.height) {
            let raw = &raw[line * width..];
            let found = raw.iter().zip(grid.depths(line));
            for (sum, (open, &depth)) in sums[PATTERN / 2..].iter_mut().zip(found) {
                sum[0] += open;
                sum[1] += f32::from(u8::from(depth > 0.0));
            }
        }
        let around = sums.windows(PATTERN).zip(grid.depths(y));
        for (to, (around, &depth)) in row.iter_mut().zip(around) {
            if depth > 0.0 {
                let sum = |k: usize| (around[0][k] + around[1][k]) + (around[2][k] + around[3][k]);
                *to = sum(0) / sum(1);
            }
        }
    });
    smooth
}
