//! The first thing seen on the page: the model drawn here, as the page will draw it, while the
//! browser still reads the script and makes its shaders.
//!
//! Eye, lights and colours of both are in `look.json`; a test of the page compares the pictures.

use std::f32::consts::PI;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use csg::{Color, elementary};
use glam::{DVec3, Vec3};
use raster::{
    AntiAliasing, Camera, EdgeOptions, Finish, Image, Lens, Light, Prepared, RasterError,
    RenderOptions, Renderer, Scene,
};
use serde::Deserialize;

use crate::packing::{self, Lines};
use crate::shown::{Settings, Shown};

/// Pixels of each side. The page shows the picture as large as fits, and spans the same angle
/// along its narrower side.
const SIDE: u32 = 640;

/// Parts of the radius by which lines come nearer: more than chords are off.
const NEARER: f64 = 4.0 * Settings::TOLERANCE;

/// How the page looks at first, to its script as well.
#[derive(Debug, Deserialize)]
struct Look {
    /// Towards the eye.
    eye: [f64; 3],
    /// Degrees that the narrower side of the picture spans.
    field: f64,
    /// How far the eye is away, of what shows all of a ball around the model.
    margin: f64,
    /// The brightness of what comes from above.
    sky: f32,
    /// The colour from below, as bright.
    ground: Rgb,
    /// The brightness of the lamp beside the eye.
    lamp: f32,
    /// How far above the eye it is, of its distance.
    lamp_up: f64,
    light: Theme,
    dark: Theme,
}

/// Colours of a page.
#[derive(Debug, Deserialize)]
struct Theme {
    lines: Rgb,
    /// Of faces that have no colour.
    faces: Rgb,
}

/// sRGB.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Rgb([u8; 3]);

impl From<Rgb> for Color {
    fn from(Rgb(parts): Rgb) -> Self {
        Self::from_srgb(parts.map(|part| f32::from(part) / 255.0))
    }
}

/// The model as the page shows it first: PNG pictures without a background, for a light page and
/// for a dark one.
pub(crate) struct FirstPictures {
    look: Look,
    scene: Prepared,
    camera: Camera,
    edges: EdgeOptions,
}

impl FirstPictures {
    /// `None` if it cannot be drawn.
    pub(crate) fn of(shown: &Shown) -> Option<Self> {
        let look: Look = serde_json::from_str(include_str!("../web/src/look.json")).ok()?;
        let (center, radius) = packing::ball(shown);
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let half = 0.5 * look.field.to_radians();
        let distance = look.margin * radius / elementary::sin(half);
        let eye = center + distance * DVec3::from(look.eye).normalize();
        let mut camera = Camera::looking_at(eye, center);
        camera.lens = Lens::Perspective { fov_y: 2.0 * half };
        // (The eye is at least 3.9 radii away.)
        camera.near = distance - 1.1 * radius;
        let lines = Lines::of(shown).segments;
        // (Without any, others would be looked for.)
        let edges = EdgeOptions::default().features(!lines.is_empty());
        Some(Self {
            scene: scene(shown, &lines, &camera, radius / distance),
            edges: edges.silhouettes(false).width(1.0),
            look,
            camera,
        })
    }

    /// A `data:` address; `None` if it cannot be drawn.
    pub(crate) fn address(&self, is_dark: bool) -> Option<String> {
        let theme = if is_dark {
            &self.look.dark
        } else {
            &self.look.light
        };
        let mut options = options(&self.look, self.camera.eye - self.camera.target);
        options.default_color = theme.faces.into();
        let lines = self.edges.clone().color(theme.lines.into());
        let image = draw(&self.scene, &self.camera, &options.edges(Some(lines))).ok()?;
        let png = STANDARD.encode(image.to_png().ok()?);
        Some(format!("data:image/png;base64,{png}"))
    }
}

/// Triangles and lines, these nearer to the eye than triangles, which are other chords: where
/// they are seen is the same.
fn scene(shown: &Shown, lines: &[[[f32; 3]; 2]], camera: &Camera, size: f64) -> Prepared {
    let mut mesh = shown.mesh.clone();
    mesh.feature_edges = (mesh.positions.len() as u32..)
        .step_by(2)
        .zip(lines)
        .map(|(k, _)| vec![k, k + 1])
        .collect();
    let nearer = 1.0 - NEARER * size;
    let ends = lines.iter().flatten();
    mesh.positions.extend(ends.map(|&end| {
        let end = camera.target + Vec3::from(end).as_dvec3();
        camera.eye + nearer * (end - camera.eye)
    }));
    Scene::new().add(mesh).prepare()
}

/// Lights and faces.
fn options(look: &Look, to_eye: DVec3) -> RenderOptions {
    // What Lambert's law sends to one side of what arrives from all.
    let reflected = |color: Vec3| color / PI;
    let ground = Color::from(look.ground);
    let lights = [
        Light::Environment {
            up: DVec3::Z,
            sky: reflected(Vec3::splat(look.sky)),
            ground: reflected(look.sky * Vec3::from(ground.rgb)),
        },
        Light::Directional {
            towards: to_eye.normalize() + look.lamp_up * DVec3::Z,
            intensity: reflected(Vec3::splat(look.lamp)),
        },
    ];
    let mut options = RenderOptions::default()
        .lights(lights)
        .finish(Finish::new(1.0, 1.0, 0.0, 1.0))
        .anti_aliasing(AntiAliasing::Msaa4);
    options.two_sided = true;
    options
}

fn draw(scene: &Prepared, camera: &Camera, options: &RenderOptions) -> Result<Image, RasterError> {
    let view = camera.view(SIDE, SIDE)?;
    let mut image = Image::default();
    Renderer::default().draw(scene, &view, SIDE, SIDE, options, &mut image)?;
    Ok(image)
}
