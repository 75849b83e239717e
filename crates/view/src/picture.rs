//! The first thing seen on the page: the model drawn here, as the page will draw it, while the
//! browser still reads the script and makes its shaders.
//!
//! What is here of eye, lights, colours and lines is there in `camera.js` and `drawing.js`; a
//! test of the page compares the pictures.

use std::f32::consts::PI;

use csg::Color;
use glam::{DVec3, Vec3};
use raster::{
    AntiAliasing, Camera, EdgeOptions, Finish, Image, Light, RasterError, RenderOptions, Scene,
};
use serde::Deserialize;

use crate::packing::{self, Lines};
use crate::shown::{Settings, Shown};

/// To the eye: `corner` among the views of `camera.js`.
const TO_EYE: DVec3 = DVec3::new(0.6, -1.0, 0.6);
/// The tangent of half the angle of view, upwards: of 15 degrees.
const TANGENT: f64 = 0.267_949_192_431_122_7;

/// Parts of the radius by which lines come nearer: more than chords are off.
const NEARER: f64 = 4.0 * Settings::TOLERANCE;

/// Colours of a page.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Theme {
    Light,
    Dark,
}

impl Theme {
    /// Of the page's ground, lines, and faces that have no colour.
    fn colors(self) -> [Color; 3] {
        let encoded: [[u8; 3]; 3] = match self {
            Self::Light => [[0xf4, 0xf5, 0xf7], [0x1d, 0x1f, 0x24], [178, 184, 196]],
            Self::Dark => [[0x1b, 0x1d, 0x21], [0x0b, 0x0c, 0x0e], [148, 156, 170]],
        };
        encoded.map(|rgb| Color::from_srgb(rgb.map(|x| f32::from(x) / 255.0)))
    }
}

/// The model as the page shows it first, in so many pixels.
///
/// # Errors
/// Too large a picture, or too small.
pub(crate) fn first(
    shown: &Shown,
    width: u32,
    height: u32,
    theme: Theme,
) -> Result<Image, RasterError> {
    let (center, radius) = packing::ball(shown);
    let radius = if radius > 0.0 { radius } else { 1.0 };
    // Half of the narrower angle of view, by its sine.
    let tangent = TANGENT * (f64::from(width) / f64::from(height)).min(1.0);
    let distance = 1.02 * radius / (tangent / (1.0 + tangent * tangent).sqrt());
    let to_eye = TO_EYE.normalize();
    let mut camera = Camera::looking_at(center + distance * to_eye, center);
    // (The eye is at least 3.9 radii away.)
    camera.near = distance - 1.1 * radius;

    let [background, lines, faces] = theme.colors();
    // What Lambert's law sends to one side of what arrives from all.
    let reflected = |color: Vec3| color / PI;
    let ground = Color::from_srgb([0x8a, 0x8f, 0x9a].map(|x: u8| f32::from(x) / 255.0));
    let lights = [
        Light::Environment {
            up: DVec3::Z,
            sky: reflected(Vec3::splat(1.6)),
            ground: reflected(1.6 * Vec3::from(ground.rgb)),
        },
        Light::Directional {
            towards: to_eye + 0.4 * DVec3::Z,
            intensity: reflected(Vec3::splat(2.0)),
        },
    ];
    let mut mesh = shown.mesh.clone();
    let segments = Lines::of(shown).segments;
    mesh.feature_edges = (mesh.positions.len() as u32..)
        .step_by(2)
        .zip(&segments)
        .map(|(k, _)| vec![k, k + 1])
        .collect();
    // Nearer to the eye than triangles, which are other chords: where they are seen is the same.
    let nearer = 1.0 - NEARER * radius / distance;
    let ends = segments.iter().flatten();
    mesh.positions.extend(ends.map(|&end| {
        let end = center + Vec3::from(end).as_dvec3();
        camera.eye + nearer * (end - camera.eye)
    }));
    let edges = EdgeOptions::default()
        // (Without any, others would be looked for.)
        .features(!segments.is_empty())
        .silhouettes(false)
        .width(1.0)
        .color(lines);
    let mut options = RenderOptions::default()
        .size(width, height)
        .background(background)
        .lights(lights)
        .finish(Finish::new(1.0, 1.0, 0.0, 1.0))
        .anti_aliasing(AntiAliasing::Msaa4)
        .edges(Some(edges));
    options.default_color = faces;
    options.two_sided = true;
    Scene::new().add(mesh).render(&camera, &options)
}
