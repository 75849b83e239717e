//! What a picture looks like, apart from the mesh and the view.

use csg::Color;

use crate::RasterError;
use crate::edges::{EdgeOptions, MAX_LINE_WIDTH};
use crate::light::Light;
use crate::shade::{Finish, Interpolation, Material};

/// How jagged edges are smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum AntiAliasing {
    /// One sample in the centre of each pixel.
    #[default]
    None,
    /// Coverage and depth at 4 samples a pixel, shading once a triangle and
    /// pixel.
    Msaa4,
    /// Coverage and depth at 8 samples a pixel.
    Msaa8,
    /// Everything at n x n samples a pixel (n in 1..=8), averaged in linear
    /// light.
    Supersample(u32),
}

const MSAA4: [[i32; 2]; 4] = [[96, 32], [224, 96], [32, 160], [160, 224]];
const MSAA8: [[i32; 2]; 8] = [
    [144, 80],
    [112, 176],
    [208, 144],
    [80, 48],
    [48, 208],
    [16, 112],
    [176, 240],
    [240, 16],
];

impl AntiAliasing {
    /// The sample positions within a pixel, in 1/256 pixel from its upper left
    /// corner: those of Direct3D 11 and of Vulkan's standard sample locations.
    /// With supersampling that of each of the smaller pixels.
    #[must_use]
    pub fn samples(self) -> &'static [[i32; 2]] {
        match self {
            Self::None | Self::Supersample(_) => &crate::fill::CENTRE_SAMPLE,
            Self::Msaa4 => &MSAA4,
            Self::Msaa8 => &MSAA8,
        }
    }

    /// By how much each side of the picture is drawn larger.
    #[must_use]
    pub(crate) fn scale(self) -> u32 {
        match self {
            Self::Supersample(n) => n.clamp(1, 8),
            _ => 1,
        }
    }
}

/// What a picture looks like, apart from the mesh and the view.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Width in pixels, for what is told no other.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Colour behind the mesh; transparent by default.
    pub background: Color,
    /// Colour of surfaces that have none.
    pub default_color: Color,
    /// Colour of the caps of sections, if it is not that of surfaces without.
    pub cap_color: Option<Color>,
    /// How surfaces reflect that do not say so themselves.
    pub finish: Finish,
    /// Lights of the scene.
    pub lights: Vec<Light>,
    /// Where the reflection model is evaluated.
    pub interpolation: Interpolation,
    /// Whether triangles that face away from the viewer are left out.
    pub cull_back_faces: bool,
    /// Whether the normals of faces seen from behind are turned round.
    pub two_sided: bool,
    /// How jagged edges are smoothed.
    pub anti_aliasing: AntiAliasing,
    /// Edges drawn over the picture.
    pub edges: Option<EdgeOptions>,
    /// Whether pixels are darkened where surroundings hide light.
    pub ambient_occlusion: bool,
    /// Whether a soft shadow is cast on the plane z = least z of the scene.
    pub ground_shadow: bool,
    /// Whether the directions of the axes are drawn in the lower left corner.
    pub triad: bool,
}

impl RenderOptions {
    /// What pictures to be shown to people look like: smooth, with edges,
    /// ambient occlusion and a soft shadow. (The default has none of them.)
    #[must_use]
    pub fn presentation() -> Self {
        Self {
            anti_aliasing: AntiAliasing::Msaa4,
            edges: Some(EdgeOptions::default()),
            ambient_occlusion: true,
            ground_shadow: true,
            ..Self::default()
        }
    }

    /// Sets the picture's width and height in pixels.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        (self.width, self.height) = (width, height);
        self
    }

    /// Sets the colour behind the model.
    #[must_use]
    pub fn background(mut self, color: Color) -> Self {
        self.background = color;
        self
    }

    /// Sets the lights.
    #[must_use]
    pub fn lights(mut self, lights: impl IntoIterator<Item = Light>) -> Self {
        self.lights = lights.into_iter().collect();
        self
    }

    /// Sets how surfaces reflect that do not say so themselves.
    #[must_use]
    pub fn finish(mut self, finish: Finish) -> Self {
        self.finish = finish;
        self
    }

    /// Sets where the reflection model is evaluated.
    #[must_use]
    pub fn interpolation(mut self, interpolation: Interpolation) -> Self {
        self.interpolation = interpolation;
        self
    }

    /// Sets how jagged edges are smoothed.
    #[must_use]
    pub fn anti_aliasing(mut self, anti_aliasing: AntiAliasing) -> Self {
        self.anti_aliasing = anti_aliasing;
        self
    }

    /// Sets which edges are drawn over the picture.
    #[must_use]
    pub fn edges(mut self, edges: Option<EdgeOptions>) -> Self {
        self.edges = edges;
        self
    }

    /// The same without anything that is drawn over, under or into the faces.
    #[must_use]
    pub fn faces_only(&self) -> Self {
        Self {
            edges: None,
            ambient_occlusion: false,
            ground_shadow: false,
            triad: false,
            ..self.clone()
        }
    }

    /// Refuses what cannot be drawn.
    pub(crate) fn check(&self) -> Result<(), RasterError> {
        match &self.edges {
            Some(edges) if !(edges.width > 0.0 && edges.width <= MAX_LINE_WIDTH) => {
                Err(RasterError::BadLineWidth { width: edges.width })
            }
            _ => Ok(()),
        }
    }
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 1024,
            height: 768,
            background: Color::from_linear([0.0; 3]).with_alpha(0.0),
            default_color: Material::default_color(),
            cap_color: None,
            finish: Finish::default(),
            lights: Light::default_rig(),
            interpolation: Interpolation::Phong,
            cull_back_faces: true,
            two_sided: false,
            anti_aliasing: AntiAliasing::None,
            edges: None,
            ambient_occlusion: false,
            ground_shadow: false,
            triad: false,
        }
    }
}
