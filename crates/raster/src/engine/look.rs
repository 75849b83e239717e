//! What surfaces look like before a picture's options are known.

use csg::Color;
use glam::DMat4;

use crate::options::RenderOptions;
use crate::shade::{Finish, Material};
use crate::texture::Texture;

/// What a part says about all of its surfaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartLook {
    pub material: Option<Material>,
    pub color: Option<Color>,
    pub finish: Option<Finish>,
    pub texture: Option<Texture>,
}

/// What is known of one surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceLook {
    material: Option<Material>,
    color: Option<Color>,
    finish: Option<Finish>,
    /// A texture, from world coordinates to its part's, and how it reflects.
    pub texture: Option<(Texture, DMat4, Finish)>,
}

impl PartLook {
    /// That of a surface with a colour of its own, if it has one.
    /// Placed by a model matrix.
    pub fn of_color(&self, own: Option<Color>, model: DMat4) -> SurfaceLook {
        let to_part = model.inverse();
        let finish = self.finish.unwrap_or_default();
        SurfaceLook {
            material: self.material,
            color: self.color.or(own),
            finish: self.finish,
            texture: self.texture.map(|texture| (texture, to_part, finish)),
        }
    }
}

impl SurfaceLook {
    pub fn of_color(color: Option<Color>) -> Self {
        Self {
            color,
            ..Self::default()
        }
    }

    /// Its material in a picture.
    pub fn material(&self, options: &RenderOptions) -> Material {
        self.material.unwrap_or_else(|| {
            let color = self.color.unwrap_or(options.default_color);
            Material::new(color, self.finish.unwrap_or(options.finish))
        })
    }

    /// Whether one sees through it.
    pub fn is_transparent(&self, options: &RenderOptions) -> bool {
        self.material(options).opacity < 1.0
    }
}
