//! Pictures of what the visibility buffer holds: depth, normals, surfaces,
//! openness.

use crate::RasterError;
use crate::buffer_images::{depth_image, id_image, normal_image};
use crate::buffers::Buffer;
use crate::camera::View;
use crate::edges::{MAX_LINE_WIDTH, draw_edges};
use crate::frame::FrameMatrix;
use crate::image::Image;
use crate::options::{AntiAliasing, RenderOptions};
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::stats::Stats;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Show {
    /// The model in its colours.
    #[default]
    Color,
    /// Its distance: near white, far dark.
    Depth,
    /// Its normals, as red, green and blue.
    Normals,
    /// Its surfaces, each in a colour.
    Surfaces,
    /// How open it is to light from everywhere, on a ground; and its edges, if
    /// the options have some.
    Occlusion,
}

impl Renderer {
    /// Draws one frame of what `show` says, smoothed as the options say:
    /// samples are drawn and averaged as they are encoded.
    ///
    /// # Errors
    /// Those of [`Renderer::draw`].
    #[allow(clippy::too_many_arguments, reason = "those of `draw`")]
    pub fn draw_shown(
        &mut self,
        scene: &Prepared,
        view: &View,
        width: u32,
        height: u32,
        options: &RenderOptions,
        show: Show,
        image: &mut Image,
    ) -> Result<Stats, RasterError> {
        if show == Show::Color {
            return self.draw(scene, view, width, height, options, image);
        }
        let scale = match options.anti_aliasing {
            AntiAliasing::None => 1,
            AntiAliasing::Msaa4 => 2,
            AntiAliasing::Msaa8 => 3,
            AntiAliasing::Supersample(n) => n.clamp(1, 8),
        };
        let plain = RenderOptions {
            anti_aliasing: AntiAliasing::None,
            ..options.faces_only()
        };
        let [w, h] = [width, height].map(|side| side.saturating_mul(scale));
        let mut large = Image::default();
        options.check()?;
        let stats = self.draw(scene, view, w, h, &plain, &mut large)?;
        let mut shown = match show {
            Show::Depth => depth_image(&self.depth_buffer()),
            Show::Normals => normal_image(&self.normal_buffer(scene, view)),
            Show::Surfaces => id_image(&self.surface_buffer(scene)),
            Show::Color | Show::Occlusion => openness_image(
                &self.occlusion(scene, view, true),
                &self.reversed_depth_buffer(),
            ),
        };
        if let (Show::Occlusion, Some(edges)) = (show, &options.edges) {
            let matrix = FrameMatrix::new(view, scene.centre, w, h);
            let mut wider = edges.clone();
            wider.width = (edges.width * f64::from(scale)).min(MAX_LINE_WIDTH);
            (self.width, self.height, self.scale) = (w, h, 1);
            draw_edges(self, scene, &matrix, &wider, &mut shown);
        }
        *image = shown.shrink_encoded(scale);
        Ok(stats)
    }
}

/// Openness as a grey picture, transparent where there is nothing.
fn openness_image(openness: &Buffer<f32>, depth: &Buffer<f32>) -> Image {
    let values = openness.values.iter().zip(&depth.values);
    let pixels = values.map(|(open, &depth)| {
        let grey = (open * 255.0).round() as u8;
        if depth > 0.0 {
            [grey, grey, grey, 255]
        } else {
            [0; 4]
        }
    });
    Image {
        width: openness.width,
        height: openness.height,
        pixels: pixels.collect(),
    }
}
