//! The `euc` crate: a software rasteriser whose shaders are Rust functions.

use std::time::{Duration, Instant};

use euc::rasterizer::{BackfaceCullingEnabled, Triangles};
use euc::{Interpolate, Pipeline, Target, buffer::Buffer2d};
use glam::{Mat4, Vec3, Vec4};
use raster::{Material, RenderOptions, View};

use crate::meshes::Indexed;

/// What is interpolated: a point in world coordinates and a normal.
#[derive(Clone, Copy)]
struct Varying {
    point: Vec3,
    normal: Vec3,
}

impl Interpolate for Varying {
    #[inline(always)]
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Self {
            point: a.point * x + b.point * y,
            normal: a.normal * x + b.normal * y,
        }
    }
    #[inline(always)]
    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        Self {
            point: a.point * x + b.point * y + c.point * z,
            normal: a.normal * x + b.normal * y + c.normal * z,
        }
    }
}

/// Phong shading under ambient light 0.1 and one directional light 0.9.
struct Phong<'a> {
    world_to_clip: Mat4,
    viewer: Vec4,
    towards: Vec3,
    material: Material,
    vertices: &'a [[Vec3; 2]],
}

impl Pipeline for Phong<'_> {
    type Vertex = u32;
    type VsOut = Varying;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, &index: &u32) -> ([f32; 4], Varying) {
        let [position, normal] = self.vertices[index as usize];
        let clip = self.world_to_clip * position.extend(1.0);
        (
            clip.to_array(),
            Varying {
                point: position,
                normal,
            },
        )
    }

    #[inline(always)]
    fn frag(&self, varying: &Varying) -> u32 {
        let n = varying.normal.normalize();
        let v = (self.viewer.truncate() - varying.point * self.viewer.w).normalize();
        let n_l = n.dot(self.towards);
        let mut light = self.material.diffuse * 0.1;
        if n_l > 0.0 {
            let r = n * (2.0 * n_l) - self.towards;
            let highlight = r.dot(v).max(0.0).powf(self.material.shininess);
            light += (self.material.diffuse * n_l + self.material.specular * highlight) * 0.9;
        }
        let srgb = |x: f32| {
            let x = x.clamp(0.0, 1.0);
            let y = if x <= 0.003_130_8 {
                12.92 * x
            } else {
                1.055 * x.powf(1.0 / 2.4) - 0.055
            };
            (y * 255.0 + 0.5) as u8
        };
        u32::from_le_bytes([srgb(light.x), srgb(light.y), srgb(light.z), 255])
    }
}

/// Draws frames of a mesh on one thread and returns the time of each, from
/// clearing to the last pixel, and the last picture (little-endian RGBA).
#[must_use]
pub fn draw(
    mesh: &Indexed,
    view: &View,
    (width, height): (u32, u32),
    towards: Vec3,
    frames: u32,
) -> (Vec<Duration>, Vec<u32>) {
    let phong = Phong {
        world_to_clip: view.world_to_clip().as_mat4(),
        viewer: view.centre_of_projection().as_vec4(),
        towards: towards.normalize(),
        material: Material::of_color(RenderOptions::default().default_color),
        vertices: &mesh.vertices,
    };
    let size = [width as usize, height as usize];
    let mut color = Buffer2d::new(size, 0u32);
    let mut depth = Buffer2d::new(size, 1.0f32);
    let times = (0..frames)
        .map(|_| {
            let start = Instant::now();
            color.clear(0);
            depth.clear(1.0);
            phong.draw::<Triangles<'_, Buffer2d<f32>, BackfaceCullingEnabled>, _>(
                &mesh.indices,
                &mut color,
                Some(&mut depth),
            );
            start.elapsed()
        })
        .collect();
    (times, color.as_ref().to_vec())
}
