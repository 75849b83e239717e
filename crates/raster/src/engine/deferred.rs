//! Deferred shading: visibility is settled, and each pixel is shaded once.
//!
//! [`interpolate`](crate::interpolate) says what each pixel of a block shows; here that is lit by
//! the Phong reflection model (see [`shade`](crate::shade)), 16 pixels at a
//! time. Vectors are not normalised first: their scalar products are divided
//! by their lengths, which takes fewer operations.

use glam::DVec3;

use crate::corners::Corners;
use crate::fill::{LANE_X, LANE_Y};
use crate::fixed::SUBPIXELS;
use crate::hatch::hatch;
use crate::interpolant::Cache;
use crate::interpolate::{interpolate_few, interpolate_scattered, sample_positions, scattered};
use crate::light::Source;
use crate::shade::Interpolation;
use crate::shading::ShadeContext;
use crate::simd::math::pow;
use crate::simd::vector::{Triple, Triple16, dot, inverse_sqrt, load, splat, store};
use crate::simd::{FloatLanes, Kernel, LANES, Lanes, Level, MaskLanes, triple};
use crate::smooth::ClusterView;
use crate::tile::{NO_TRIANGLE, decode};

/// Some pixels of a block to be shaded: those lanes of `triangles` whose bits
/// are in `wanted`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub triangles: [i32; LANES],
    pub wanted: u32,
    /// First pixel of the block in the picture.
    pub at: [usize; 2],
}

impl ShadeContext<'_> {
    /// The material that the pixels of a job share, or [`MIXED`].
    #[inline(always)]
    pub fn material_of(&self, job: &Job) -> usize {
        if self.materials.len() == 1 {
            return 0;
        }
        let mut wanted = job.wanted;
        let mut material = None;
        while wanted != 0 {
            let lane = wanted.trailing_zeros() as usize % LANES;
            wanted &= wanted - 1;
            material = shared(material, self.material(job.triangles[lane] as usize));
        }
        material.unwrap_or(0)
    }

    /// The point of a cap at one pixel of a job.
    pub fn cap_point(&self, job: &Job, section: usize, lane: usize) -> DVec3 {
        let sample = |axis: usize, within: i32| {
            let pixel = job.at[axis] as i32 + within;
            f64::from(pixel * SUBPIXELS + SUBPIXELS / 2 - self.matrix.middle[axis])
        };
        let (x, y) = (sample(0, LANE_X[lane]), sample(1, LANE_Y[lane]));
        self.caps.point(section, x, y)
    }
}

/// The material of pixels that do not share one.
pub(crate) const MIXED: usize = usize::MAX;

/// The material of some pixels and one more, if they have one in common.
#[inline(always)]
pub(crate) fn shared(before: Option<usize>, one: usize) -> Option<usize> {
    match before {
        None => Some(one),
        Some(before) if before == one => Some(one),
        Some(_) => Some(MIXED),
    }
}

/// What the pixels of a job show.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Fragments {
    /// Of any length; or colours, where these are interpolated themselves.
    pub normal: Triple16,
    /// Relative to the scene's centre; only where shading depends on it.
    pub point: Triple16,
    /// The material they share, or [`MIXED`].
    pub material: usize,
}

/// A row of jobs and what is found for them. The work goes over the whole row
/// in a few short passes: a processor overlaps the iterations of a short
/// loop, but not those of one that is a thousand instructions long.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub jobs: Vec<Job>,
    fragments: Vec<Fragments>,
    /// Colours, linear and not clamped.
    pub colours: Vec<Triple16>,
    pub cache: Cache,
    corners: Box<[Corners]>,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            jobs: Vec::new(),
            fragments: Vec::new(),
            colours: Vec::new(),
            cache: Cache::default(),
            corners: vec![Corners::default(); AT_ONCE].into(),
        }
    }
}

/// Jobs whose corners are fetched together, before any of them is
/// interpolated: fetching waits for memory, and the waits overlap.
const AT_ONCE: usize = 16;

/// Finds the colours of all jobs of a batch.
pub(crate) fn shade(level: Level, context: &ShadeContext, batch: &mut Batch) {
    let count = batch.jobs.len();
    if batch.fragments.len() < count {
        batch.fragments.resize(count, Fragments::default());
        batch.colours.resize(count, [[0.0; LANES]; 3]);
    }
    level.run(InterpolateJobs { context, batch });
    if context.interpolation == Interpolation::Phong {
        level.run(LightJobs { context, batch });
    } else {
        for (fragments, colour) in batch.fragments.iter().zip(&mut batch.colours) {
            *colour = fragments.normal;
        }
    }
    if !context.scene.sections.is_empty() {
        hatch(context, batch);
    }
}

/// The first pass: what the pixels show.
struct InterpolateJobs<'a> {
    context: &'a ShadeContext<'a>,
    batch: &'a mut Batch,
}

impl Kernel for InterpolateJobs<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let Self { context, batch } = self;
        // Lane by lane only where all is interpolated in the plain way.
        let scene = context.scene;
        let plain = context.interpolation == Interpolation::Phong
            && scene.sections.is_empty()
            && scene.remainders.is_empty();
        let by_lane = |job: &Job| plain && scattered(&job.triangles);
        let mut cluster = ClusterView::default();
        let fragments = batch.fragments.chunks_mut(AT_ONCE);
        for (jobs, fragments) in batch.jobs.chunks(AT_ONCE).zip(fragments) {
            let to = batch.corners.iter_mut().zip(fragments.iter_mut());
            for (job, (corners, to)) in jobs.iter().zip(to) {
                if by_lane(job) {
                    to.material = corners.fetch(context, &mut cluster, job);
                }
            }
            let to = batch.corners.iter().zip(fragments);
            for (job, (corners, to)) in jobs.iter().zip(to) {
                if by_lane(job) {
                    interpolate_scattered(s, context, corners, job, to);
                } else {
                    interpolate_few(s, context, &mut batch.cache, job, to);
                }
            }
        }
    }
}

/// The second pass: what light they send to the viewer.
struct LightJobs<'a> {
    context: &'a ShadeContext<'a>,
    batch: &'a mut Batch,
}

impl Kernel for LightJobs<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let found = self.batch.jobs.iter().zip(&self.batch.fragments);
        for ((job, fragments), colour) in found.zip(&mut self.batch.colours) {
            light(s, self.context, job, fragments, colour);
        }
    }
}

/// The materials of 16 pixels.
struct Materials<S: Lanes> {
    ambient: Triple<S>,
    diffuse: Triple<S>,
    specular: Triple<S>,
    shininess: S::F,
}

#[inline(always)]
fn materials<S: Lanes>(
    s: S,
    context: &ShadeContext,
    job: &Job,
    fragments: &Fragments,
) -> Materials<S> {
    let shared = context.materials.get(fragments.material);
    if let Some(m) = shared.filter(|_| !context.textured) {
        return Materials {
            ambient: splat(s, m.ambient),
            diffuse: splat(s, m.diffuse),
            specular: splat(s, m.specular),
            shininess: s.f(m.shininess),
        };
    }
    let mut lanes = [[0f32; LANES]; 10];
    let mut last = (NO_TRIANGLE, 0);
    for (k, &index) in job.triangles.iter().enumerate() {
        if index != last.0 {
            let own = match decode(index) {
                (triangle, None) => context.material(triangle),
                (_, Some(_)) => context.cap_material(),
            };
            last = (index, own);
        }
        let m = if context.textured {
            let [x, y, z] = fragments.point.map(|lanes| f64::from(lanes[k]));
            context.textured(last.1, DVec3::new(x, y, z))
        } else {
            context.materials[last.1]
        };
        let values = [m.ambient, m.diffuse, m.specular].map(|v| v.to_array());
        for (lane, value) in lanes.iter_mut().zip(values.as_flattened()) {
            lane[k] = *value;
        }
        lanes[9][k] = m.shininess;
    }
    Materials {
        ambient: triple!(|K| s.load_f(&lanes[K])),
        diffuse: triple!(|K| s.load_f(&lanes[3 + K])),
        specular: triple!(|K| s.load_f(&lanes[6 + K])),
        shininess: s.load_f(&lanes[9]),
    }
}

/// x^n < 2^-14 where x <= 1 - 14 ln 2 / n, because ln x <= x - 1.
const HIGHLIGHT_REACH: f32 = 14.0 * std::f32::consts::LN_2;

/// The light that the pixels of a job send to the viewer.
#[inline(always)]
fn light<S: Lanes>(
    s: S,
    context: &ShadeContext,
    job: &Job,
    fragments: &Fragments,
    to: &mut Triple16,
) {
    let matrix = context.matrix;
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let normal = load(s, &fragments.normal);
    let x = sample_positions(s, &LANE_X, job.at[0], matrix.middle[0]);
    let y = sample_positions(s, &LANE_Y, job.at[1], matrix.middle[1]);
    let [at, right, down] = triple!(|K| splat(s, matrix.towards_viewer[K]));
    let viewer = triple!(|K| at[K] + (right[K] * x + down[K] * y));
    let viewer_length = inverse_sqrt(s, dot::<S>(viewer, viewer));
    let mut normal_length = inverse_sqrt(s, dot::<S>(normal, normal));
    let mut n_v = dot::<S>(normal, viewer) * (normal_length * viewer_length);
    if context.two_sided {
        let sign = n_v.lt(zero).select_f(s.f(-1.0), one);
        normal_length = normal_length * sign;
        n_v = n_v * sign;
    }
    let material = materials(s, context, job, fragments);
    let mut ambient = splat(s, context.ambient);
    for &(source, ground) in &context.lights {
        if let Source::Halves(up, sky) = source {
            let up = dot::<S>(normal, splat(s, up.as_vec3())) * normal_length;
            let share = (one + up) * s.f(0.5);
            let (ground, more) = (splat(s, ground), splat(s, sky - ground));
            ambient = triple!(|K| ambient[K] + (ground[K] + more[K] * share));
        }
    }
    let mut colour = triple!(|K| material.ambient[K] * ambient[K]);
    for &(source, intensity) in &context.lights {
        let (n_l, l_v) = match source {
            Source::Direction(towards) => {
                let towards = splat(s, towards.as_vec3());
                (
                    dot::<S>(normal, towards) * normal_length,
                    dot::<S>(viewer, towards) * viewer_length,
                )
            }
            Source::Position(position) => {
                let position = splat(s, position.as_vec3());
                let point = load(s, &fragments.point);
                let towards = triple!(|K| position[K] - point[K]);
                let length = inverse_sqrt(s, dot::<S>(towards, towards));
                (
                    dot::<S>(normal, towards) * (normal_length * length),
                    dot::<S>(viewer, towards) * (viewer_length * length),
                )
            }
            Source::Viewer => (n_v, one),
            Source::Everywhere | Source::Halves(..) => continue,
        };
        let lit = zero.lt(n_l);
        if lit.bits() & job.wanted == 0 {
            continue;
        }
        // R = 2 (N·L) N - L.
        let r_v = (n_l + n_l) * n_v - l_v;
        let intensity = splat(s, intensity);
        let diffuse = n_l.max(zero);
        // Below 2^-14 a highlight is not seen.
        let seen = lit & (one - s.f(HIGHLIGHT_REACH) / material.shininess).lt(r_v.max(zero));
        if seen.bits() & job.wanted == 0 {
            colour = triple!(|K| colour[K] + intensity[K] * (material.diffuse[K] * diffuse));
        } else {
            let highlight = seen.select_f(pow(s, r_v.max(zero), material.shininess), zero);
            colour = triple!(|K| colour[K]
                + intensity[K]
                    * (material.diffuse[K] * diffuse + material.specular[K] * highlight));
        }
    }
    store::<S>(colour, to);
}
