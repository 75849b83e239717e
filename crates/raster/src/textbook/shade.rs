//! The Phong reflection model.
//!
//! I = Ka Ia + sum over lights of (Kd Iin (L·N) + Ks Iin (R·V)^n), per
//! channel, in linear light (Phong, *Illumination for computer generated
//! pictures*, CACM 18(6), 1975).

use csg::Color;
use glam::Vec3;

/// Where the reflection model is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Once a triangle, with its plane's normal, at its centroid.
    Flat,
    /// At the corners; colours are interpolated (Gouraud, *Continuous shading
    /// of curved surfaces*, IEEE Trans. C-20(6), 1971).
    Gouraud,
    /// At every pixel, with interpolated normals.
    #[default]
    Phong,
}

/// The coefficients of the reflection model, whatever the colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// Ka: the share of ambient light reflected in the surface's colour.
    pub ambient: f32,
    /// Kd: the same of light from a direction, to all sides.
    pub diffuse: f32,
    /// Ks: the share reflected in the light's colour, around the mirrored
    /// direction.
    pub specular: f32,
    /// The exponent n: the greater, the smaller and sharper the highlight.
    pub shininess: f32,
}

impl Finish {
    /// From Ka, Kd, Ks and n.
    #[must_use]
    pub const fn new(ambient: f32, diffuse: f32, specular: f32, shininess: f32) -> Self {
        Self {
            ambient,
            diffuse,
            specular,
            shininess,
        }
    }
}

impl Default for Finish {
    /// Slightly glossy.
    fn default() -> Self {
        Self::new(1.0, 1.0, 0.15, 30.0)
    }
}

/// How a surface reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Ambient reflection: Ka times the colour, linear per channel.
    pub ambient: Vec3,
    /// Diffuse reflection: Kd times the colour, linear per channel.
    pub diffuse: Vec3,
    /// Specular reflection Ks, linear per channel.
    pub specular: Vec3,
    /// The exponent n of the specular lobe.
    pub shininess: f32,
    /// 1 is opaque; below, what is behind shines through.
    pub opacity: f32,
}

impl Material {
    /// A colour, as opaque as its alpha says, that reflects in some way.
    #[must_use]
    pub fn new(color: Color, finish: Finish) -> Self {
        let own = Vec3::from_array(color.rgb);
        Self {
            ambient: own * finish.ambient,
            diffuse: own * finish.diffuse,
            specular: Vec3::splat(finish.specular),
            shininess: finish.shininess,
            opacity: color.alpha,
        }
    }

    /// A slightly glossy material of a colour.
    #[must_use]
    pub fn of_color(color: Color) -> Self {
        Self::new(color, Finish::default())
    }

    /// The colour of parts that have none: a light steel.
    #[must_use]
    pub fn default_color() -> Color {
        Color::from_srgb([0.70, 0.75, 0.80])
    }
}

/// A light as it arrives at a point: the unit direction towards it and its
/// intensity; direction zero for ambient light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit direction towards the light, or zero.
    pub towards: Vec3,
    /// Intensity per channel.
    pub intensity: Vec3,
}

/// The light reflected towards the viewer, linear per channel, not clamped.
/// `normal` and `viewer` are unit vectors.
#[must_use]
pub fn phong(material: &Material, lights: &[Incident], normal: Vec3, viewer: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for light in lights {
        if light.towards == Vec3::ZERO {
            sum += material.ambient * light.intensity;
            continue;
        }
        let n_l = normal.dot(light.towards);
        if n_l > 0.0 {
            let reflected = normal * (2.0 * n_l) - light.towards;
            let r_v = reflected.dot(viewer).max(0.0);
            sum += light.intensity
                * (material.diffuse * n_l + material.specular * r_v.powf(material.shininess));
        }
    }
    sum
}
