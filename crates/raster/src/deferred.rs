//! Deferred shading: visibility is settled, and each pixel is shaded once.
//!
//! The triangle and the pixel give everything else. With the corners in
//! raster space (X, Y, W) and the sample at (x, y), let qk = (Xk - x Wk,
//! Yk - y Wk). Then b0 = q1 × q2, b1 = q2 × q0, b2 = q0 × q1 are the
//! homogeneous weights of the corners at the sample: perspective-correct, and
//! right for corners behind the eye, so that clipped triangles need no
//! attributes of their own (Olano, Greer, *Triangle scan conversion using 2D
//! homogeneous coordinates*, 1997). Taking the sample as origin first keeps
//! the products free of cancellation.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::fill::{LANE_X, LANE_Y};
use crate::fixed::SUBPIXELS;
use crate::frame::FrameMatrix;
use crate::hatch::hatch;
use crate::scene::Scene;
use crate::section::Caps;
use crate::shade::{Incident, Interpolation, Light, Material, phong};
use crate::simd::math::pow;
use crate::simd::{FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};
use crate::tile::{NO_TRIANGLE, decode};

/// A light in the coordinates of one frame's scene.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// Unit direction towards it.
    Direction(Vec3),
    Position(Vec3),
    Head,
}

/// All that shading needs to know about a frame.
pub(crate) struct ShadeContext<'a> {
    pub scene: &'a Scene,
    pub matrix: &'a FrameMatrix,
    materials: Vec<Material>,
    ambient: Vec3,
    lights: Vec<(Source, Vec3)>,
    interpolation: Interpolation,
    two_sided: bool,
    /// Whether shading depends on where on the surface a pixel lies.
    positional: bool,
    caps: Caps,
}

impl<'a> ShadeContext<'a> {
    pub fn new(
        scene: &'a Scene,
        view: &View,
        matrix: &'a FrameMatrix,
        lights: &[Light],
        materials: Vec<Material>,
        interpolation: Interpolation,
        two_sided: bool,
    ) -> Self {
        let mut ambient = Vec3::ZERO;
        let mut sources = Vec::new();
        let eye_to_world = view.world_to_eye().inverse();
        let unit = |v: DVec3| v.normalize_or_zero().as_vec3();
        for light in lights {
            match *light {
                Light::Ambient { intensity } => ambient += intensity,
                Light::Directional { towards, intensity } => {
                    sources.push((Source::Direction(unit(towards)), intensity));
                }
                Light::Camera { towards, intensity } => {
                    let towards = eye_to_world.transform_vector3(towards);
                    sources.push((Source::Direction(unit(towards)), intensity));
                }
                Light::Point {
                    position,
                    intensity,
                } => {
                    let position = (position - scene.centre).as_vec3();
                    sources.push((Source::Position(position), intensity));
                }
                Light::Head { intensity } => sources.push((Source::Head, intensity)),
            }
        }
        let positional = matrix.viewer.w != 0.0
            || sources
                .iter()
                .any(|(s, _)| matches!(s, Source::Position(_)))
            || !scene.sections.is_empty();
        Self {
            scene,
            matrix,
            materials,
            ambient,
            lights: sources,
            interpolation,
            two_sided,
            positional,
            caps: Caps::new(&scene.sections, matrix),
        }
    }

    /// Index of a triangle's material.
    fn material(&self, triangle: usize) -> usize {
        let last = self.materials.len() - 1;
        self.scene
            .triangle_surfaces
            .get(triangle)
            .map_or(last, |&surface| (surface as usize).min(last))
    }

    /// The point of a cap at one pixel of a job.
    pub fn cap_point(&self, job: &Job, section: usize, lane: usize) -> Vec3 {
        let sample = |axis: usize, within: i32| {
            let pixel = job.at[axis] as i32 + within;
            f64::from(pixel * SUBPIXELS + SUBPIXELS / 2 - self.matrix.middle[axis])
        };
        let (x, y) = (sample(0, LANE_X[lane]), sample(1, LANE_Y[lane]));
        self.caps.point(section, x, y)
    }

    /// The colour at one point, for the modes that shade per corner or per
    /// triangle.
    fn colour(&self, material: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let viewer =
            (self.matrix.viewer.truncate() - point * self.matrix.viewer.w).normalize_or_zero();
        let normal = if self.two_sided && normal.dot(viewer) < 0.0 {
            -normal
        } else {
            normal
        };
        let mut incident = vec![Incident {
            towards: Vec3::ZERO,
            intensity: self.ambient,
        }];
        incident.extend(self.lights.iter().map(|&(source, intensity)| Incident {
            towards: match source {
                Source::Direction(towards) => towards,
                Source::Position(position) => (position - point).normalize_or_zero(),
                Source::Head => viewer,
            },
            intensity,
        }));
        phong(&self.materials[material], &incident, normal, viewer)
    }
}

/// Three vectors of lanes: points, directions or colours.
type Triple<S> = [<S as Lanes>::F; 3];

#[inline(always)]
fn splat<S: Lanes>(s: S, v: Vec3) -> Triple<S> {
    [s.f(v.x), s.f(v.y), s.f(v.z)]
}

#[inline(always)]
fn dot<S: Lanes>(a: Triple<S>, b: Triple<S>) -> S::F {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[inline(always)]
fn normalise<S: Lanes>(s: S, v: Triple<S>) -> Triple<S> {
    let length = dot::<S>(v, v).sqrt().max(s.f(f32::MIN_POSITIVE));
    let inverse = s.f(1.0) / length;
    triple!(|K| v[K] * inverse)
}

/// Three times 16 floats in memory.
pub(crate) type Triple16 = [[f32; LANES]; 3];

/// Some pixels of a block to be shaded: those lanes of `triangles` whose bits
/// are in `wanted`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub triangles: [i32; LANES],
    pub wanted: u32,
    /// First pixel of the block in the picture.
    pub at: [usize; 2],
}

/// A row of jobs and what is found for them. The work goes over the whole row
/// in several short passes: a processor overlaps the iterations of a short
/// loop, but not those of one that is a thousand instructions long.
#[derive(Clone, Debug, Default)]
pub(crate) struct Batch {
    pub jobs: Vec<Job>,
    normals: Vec<Triple16>,
    /// Points relative to the scene's centre, then directions to the viewer.
    points: Vec<Triple16>,
    viewers: Vec<Triple16>,
    /// Colours, linear and not clamped.
    pub colours: Vec<Triple16>,
    cache: Cache,
}

#[inline(always)]
fn load<S: Lanes>(s: S, values: &Triple16) -> Triple<S> {
    [
        s.load_f(&values[0]),
        s.load_f(&values[1]),
        s.load_f(&values[2]),
    ]
}

#[inline(always)]
fn store<S: Lanes>(v: Triple<S>, to: &mut Triple16) {
    let [a, b, c] = to;
    v[0].store(a);
    v[1].store(b);
    v[2].store(c);
}

/// Interpolated attributes of 16 pixels.
struct Attributes<S: Lanes> {
    /// Not normalised.
    normal: Triple<S>,
    /// Relative to the scene's centre.
    point: Triple<S>,
    /// The finished colour, where it is interpolated itself.
    colour: Triple<S>,
}

/// Triangles met lately, with their corners in raster space: neighbouring
/// blocks mostly show the same ones.
const CACHE: usize = 64;

/// One of them.
#[derive(Clone, Copy, Debug)]
struct Projected {
    triangle: i32,
    /// X, Y and W of each corner.
    x: [f32; 3],
    y: [f32; 3],
    w: [f32; 3],
}

/// A small direct-mapped cache.
#[derive(Clone, Debug)]
struct Cache([Projected; CACHE]);

impl Default for Cache {
    fn default() -> Self {
        let none = Projected {
            triangle: NO_TRIANGLE,
            x: [0.0; 3],
            y: [0.0; 3],
            w: [0.0; 3],
        };
        Self([none; CACHE])
    }
}

impl Cache {
    #[inline(always)]
    fn get(&mut self, context: &ShadeContext, index: i32, corners: &[Vec3; 3]) -> &Projected {
        let entry = &mut self.0[index as usize % CACHE];
        if entry.triangle != index {
            let matrix = context.matrix;
            *entry = Projected {
                triangle: index,
                x: triple!(|K| matrix.row(0, corners[K])),
                y: triple!(|K| matrix.row(1, corners[K])),
                w: triple!(|K| matrix.row(3, corners[K])),
            };
        }
        entry
    }
}

/// The perspective-correct weights of a triangle's corners at the given
/// samples (sub-pixels from the middle of the picture), at least 0 and of
/// sum 1.
#[inline(always)]
fn weights<S: Lanes>(s: S, corners: &Projected, x: S::F, y: S::F) -> [S::F; 3] {
    let w = triple!(|K| s.f(corners.w[K]));
    let qx = triple!(|K| s.f(corners.x[K]) - x * w[K]);
    let qy = triple!(|K| s.f(corners.y[K]) - y * w[K]);
    let b = [
        qx[1] * qy[2] - qy[1] * qx[2],
        qx[2] * qy[0] - qy[2] * qx[0],
        qx[0] * qy[1] - qy[0] * qx[1],
    ];
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let sign = (b[0] + b[1] + b[2]).lt(zero).select_f(s.f(-1.0), one);
    // Snapping moves corners by up to 1/512 pixel, so a sample may lie a
    // little outside the true triangle: it takes the nearest values inside.
    let b = triple!(|K| (b[K] * sign).max(zero));
    let sum = b[0] + b[1] + b[2];
    let some = zero.lt(sum);
    let inverse = one / some.select_f(sum, one);
    let third = s.f(1.0 / 3.0);
    triple!(|K| some.select_f(b[K] * inverse, third))
}

/// [`weights`] for the centre of one pixel, in double precision.
pub(crate) fn weights_at(matrix: &FrameMatrix, corners: [Vec3; 3], x: u32, y: u32) -> [f32; 3] {
    let sample = [x, y].map(|v| f64::from(v.cast_signed() * SUBPIXELS + SUBPIXELS / 2));
    let [x, y] = [0, 1].map(|axis| sample[axis] - f64::from(matrix.middle[axis]));
    let q = corners.map(|p| {
        let w = f64::from(matrix.row(3, p));
        [
            f64::from(matrix.row(0, p)) - x * w,
            f64::from(matrix.row(1, p)) - y * w,
        ]
    });
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let b = [cross(q[1], q[2]), cross(q[2], q[0]), cross(q[0], q[1])];
    let sign = if b[0] + b[1] + b[2] < 0.0 { -1.0 } else { 1.0 };
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
fn sample_positions<S: Lanes>(s: S, lane: &[i32; LANES], first: usize, middle: i32) -> S::F {
    let start = first as i32 * SUBPIXELS + SUBPIXELS / 2 - middle;
    (s.load_i(lane).shl::<8>() + s.i(start)).to_float()
}

/// Interpolation over one triangle, in those lanes that show it.
struct Mix<S: Lanes> {
    s: S,
    weight: [S::F; 3],
    here: S::M,
}

impl<S: Lanes> Mix<S> {
    #[inline(always)]
    fn over(&self, values: [Vec3; 3], old: Triple<S>) -> Triple<S> {
        let (s, weight) = (self.s, self.weight);
        let [a, b, c] = [
            values[0].to_array(),
            values[1].to_array(),
            values[2].to_array(),
        ];
        triple!(|K| {
            let v = (weight[0] * s.f(a[K]) + weight[1] * s.f(b[K])) + weight[2] * s.f(c[K]);
            self.here.select_f(v, old[K])
        })
    }
}

/// Interpolates what the pixels of a job show.
#[inline(always)]
fn interpolate<S: Lanes>(
    s: S,
    context: &ShadeContext,
    cache: &mut Cache,
    job: &Job,
) -> Attributes<S> {
    let triangles = &job.triangles;
    let mut wanted = job.wanted;
    let [px, py] = job.at;
    let zero = s.f(0.0);
    let mut result = Attributes {
        normal: [zero; 3],
        point: [zero; 3],
        colour: [zero; 3],
    };
    let scene = context.scene;
    let x = sample_positions(s, &LANE_X, px, context.matrix.middle[0]);
    let y = sample_positions(s, &LANE_Y, py, context.matrix.middle[1]);
    let all = s.load_i(triangles);
    while wanted != 0 {
        let index = triangles[wanted.trailing_zeros() as usize % LANES];
        let here = all.eq(s.i(index));
        wanted &= !here.bits();
        let (triangle, section) = decode(index);
        if let Some(section) = section {
            interpolate_cap(s, context, job, section, here, &mut result);
            continue;
        }
        let (Some(vertices), Some(normals)) =
            (scene.triangles.get(triangle), scene.normals.get(triangle))
        else {
            continue;
        };
        let corners = triple!(|K| scene.positions[vertices[K] as usize]);
        let weight = weights(s, cache.get(context, index, &corners), x, y);
        let mix = Mix { s, weight, here };
        match context.interpolation {
            Interpolation::Phong => {
                result.normal = mix.over(*normals, result.normal);
                if context.positional {
                    result.point = mix.over(corners, result.point);
                }
            }
            Interpolation::Gouraud => {
                let material = context.material(triangle);
                let colours =
                    std::array::from_fn(|k| context.colour(material, corners[k], normals[k]));
                result.colour = mix.over(colours, result.colour);
            }
            Interpolation::Flat => {
                let [a, b, c] = corners;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let middle = (a + b + c) / 3.0;
                let colour = context.colour(context.material(triangle), middle, normal);
                result.colour = mix.over([colour; 3], result.colour);
            }
        }
    }
    result
}

/// [`interpolate`] for the cap of a section, which has the default colour: it
/// lies inside the solid, on none of its surfaces.
#[inline(always)]
fn interpolate_cap<S: Lanes>(
    s: S,
    context: &ShadeContext,
    job: &Job,
    section: usize,
    here: S::M,
    result: &mut Attributes<S>,
) {
    let Some(plane) = context.scene.sections.get(section) else {
        return;
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
    let normal = splat(s, plane.normal);
    let colour = if context.interpolation == Interpolation::Phong {
        Vec3::ZERO
    } else {
        context.colour(context.materials.len() - 1, some, plane.normal)
    };
    let (point, colour) = (load(s, &points), splat(s, colour));
    let old = (result.normal, result.point, result.colour);
    result.normal = triple!(|K| here.select_f(normal[K], old.0[K]));
    result.point = triple!(|K| here.select_f(point[K], old.1[K]));
    result.colour = triple!(|K| here.select_f(colour[K], old.2[K]));
}

/// The materials of 16 pixels.
struct Materials<S: Lanes> {
    ambient: Triple<S>,
    diffuse: Triple<S>,
    specular: Triple<S>,
    shininess: S::F,
}

#[inline(always)]
fn materials<S: Lanes>(s: S, context: &ShadeContext, triangles: &[i32; LANES]) -> Materials<S> {
    let of = |number: i32| match decode(number) {
        (triangle, None) => &context.materials[context.material(triangle)],
        (_, Some(_)) => &context.materials[context.materials.len() - 1],
    };
    if context.materials.len() == 1 {
        let m = &context.materials[0];
        return Materials {
            ambient: splat(s, m.ambient),
            diffuse: splat(s, m.diffuse),
            specular: splat(s, m.specular),
            shininess: s.f(m.shininess),
        };
    }
    let mut lanes = [[0f32; LANES]; 10];
    let mut last = (NO_TRIANGLE, &context.materials[0]);
    for (k, &index) in triangles.iter().enumerate() {
        if index != last.0 {
            last = (index, of(index));
        }
        let m = last.1;
        let values = [m.ambient, m.diffuse, m.specular].map(|v| v.to_array());
        for (lane, value) in lanes.iter_mut().zip(values.as_flattened()) {
            lane[k] = *value;
        }
        lanes[9][k] = m.shininess;
    }
    let three = |first: usize| {
        [
            s.load_f(&lanes[first]),
            s.load_f(&lanes[first + 1]),
            s.load_f(&lanes[first + 2]),
        ]
    };
    Materials {
        ambient: three(0),
        diffuse: three(3),
        specular: three(6),
        shininess: s.load_f(&lanes[9]),
    }
}

/// Finds the colours of all jobs of a batch.
#[inline(always)]
pub(crate) fn shade<S: Lanes>(s: S, context: &ShadeContext, batch: &mut Batch) {
    let count = batch.jobs.len();
    let zero16 = [[0.0; LANES]; 3];
    for list in [
        &mut batch.normals,
        &mut batch.points,
        &mut batch.viewers,
        &mut batch.colours,
    ] {
        if list.len() < count {
            list.resize(count, zero16);
        }
    }
    let phong = context.interpolation == Interpolation::Phong;
    for (k, job) in batch.jobs.iter().enumerate() {
        let found = interpolate(s, context, &mut batch.cache, job);
        if phong {
            store::<S>(found.normal, &mut batch.normals[k]);
            store::<S>(found.point, &mut batch.points[k]);
        } else {
            store::<S>(found.colour, &mut batch.colours[k]);
        }
    }
    if phong {
        prepare(s, context, batch);
        for &(source, intensity) in &context.lights {
            light(s, context, batch, source, intensity);
        }
    }
    if !context.scene.sections.is_empty() {
        hatch(context, batch);
    }
}

/// Normalises normals, finds the directions to the viewer, and starts the
/// colours with ambient light.
#[inline(always)]
fn prepare<S: Lanes>(s: S, context: &ShadeContext, batch: &mut Batch) {
    let eye = splat(s, context.matrix.viewer.truncate());
    let w = s.f(context.matrix.viewer.w);
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let ambient = splat(s, context.ambient);
    for (((job, normal16), (point16, viewer16)), colour16) in batch
        .jobs
        .iter()
        .zip(&mut batch.normals)
        .zip(batch.points.iter().zip(&mut batch.viewers))
        .zip(&mut batch.colours)
    {
        let material = materials(s, context, &job.triangles);
        store::<S>(triple!(|K| material.ambient[K] * ambient[K]), colour16);
        let point = load(s, point16);
        let viewer = normalise(s, triple!(|K| eye[K] - point[K] * w));
        let mut normal = normalise(s, load(s, normal16));
        if context.two_sided {
            let sign = dot::<S>(normal, viewer).lt(zero).select_f(s.f(-1.0), one);
            normal = triple!(|K| normal[K] * sign);
        }
        store::<S>(normal, normal16);
        store::<S>(viewer, viewer16);
    }
}

/// x^n < 2^-14 where x <= 1 - 14 ln 2 / n, because ln x <= x - 1.
const HIGHLIGHT_REACH: f32 = 14.0 * std::f32::consts::LN_2;

/// Adds the diffuse and specular reflection of one light.
#[inline(always)]
fn light<S: Lanes>(
    s: S,
    context: &ShadeContext,
    batch: &mut Batch,
    source: Source,
    intensity: Vec3,
) {
    let zero = s.f(0.0);
    let intensity = splat(s, intensity);
    for (k, job) in batch.jobs.iter().enumerate() {
        let normal = load(s, &batch.normals[k]);
        let viewer = load(s, &batch.viewers[k]);
        let towards = match source {
            Source::Direction(towards) => splat(s, towards),
            Source::Position(position) => {
                let position = splat(s, position);
                let point = load(s, &batch.points[k]);
                normalise(s, triple!(|K| position[K] - point[K]))
            }
            Source::Head => viewer,
        };
        let n_l = dot::<S>(normal, towards);
        let lit = zero.lt(n_l);
        if lit.bits() & job.wanted == 0 {
            continue;
        }
        let material = materials(s, context, &job.triangles);
        let double = n_l + n_l;
        let reflected = triple!(|K| normal[K] * double - towards[K]);
        let r_v = dot::<S>(reflected, viewer).max(zero);
        // Below 2^-14 a highlight is not seen.
        let seen = lit & (s.f(1.0) - s.f(HIGHLIGHT_REACH) / material.shininess).lt(r_v);
        let highlight = if seen.bits() & job.wanted == 0 {
            zero
        } else {
            seen.select_f(pow(s, r_v, material.shininess), zero)
        };
        let diffuse = n_l.max(zero);
        let old = load(s, &batch.colours[k]);
        let colour = triple!(|K| old[K]
            + intensity[K] * (material.diffuse[K] * diffuse + material.specular[K] * highlight));
        store::<S>(colour, &mut batch.colours[k]);
    }
}
