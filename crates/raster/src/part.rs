//! Parts of a scene.

use std::sync::Arc;

use csg::{Color, Mesh};
use glam::{DMat4, DVec3};

use crate::look::PartLook;
use crate::shade::{Finish, Material};
use crate::texture::Texture;

/// A mesh, the places where it is, and what it looks like. Many places share
/// one mesh.
#[derive(Clone, Debug)]
pub struct Part {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) models: Vec<DMat4>,
    pub(crate) look: PartLook,
}

impl Part {
    /// A mesh where it is, in the colours of its surfaces.
    #[must_use]
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Self {
        Self {
            mesh: mesh.into(),
            models: vec![DMat4::IDENTITY],
            look: PartLook::default(),
        }
    }

    /// Places the part by a model matrix, after those it is placed by already.
    #[must_use]
    pub fn transformed(mut self, model: DMat4) -> Self {
        for placed in &mut self.models {
            *placed = model * *placed;
        }
        self
    }

    /// Moves the part.
    #[must_use]
    pub fn at(self, offset: DVec3) -> Self {
        self.transformed(DMat4::from_translation(offset))
    }

    /// Draws the part once for each of these model matrices (instances).
    #[must_use]
    pub fn instances(mut self, models: impl IntoIterator<Item = DMat4>) -> Self {
        self.models = models.into_iter().collect();
        self
    }

    /// All surfaces of the part are of this material.
    #[must_use]
    pub fn material(mut self, material: Material) -> Self {
        self.look.material = Some(material);
        self
    }

    /// All surfaces of the part have this colour; one whose alpha is below 1 is
    /// seen through.
    #[must_use]
    pub fn color(mut self, color: Color) -> Self {
        self.look.color = Some(color);
        self
    }

    /// How all surfaces of the part reflect, whatever their colours.
    #[must_use]
    pub fn finish(mut self, finish: Finish) -> Self {
        self.look.finish = Some(finish);
        self
    }

    /// A pattern of two colours in place of one.
    #[must_use]
    pub fn texture(mut self, texture: Texture) -> Self {
        self.look.texture = Some(texture);
        self
    }
}

impl From<Mesh> for Part {
    fn from(mesh: Mesh) -> Self {
        Self::new(mesh)
    }
}

impl From<Arc<Mesh>> for Part {
    fn from(mesh: Arc<Mesh>) -> Self {
        Self::new(mesh)
    }
}

impl From<&Mesh> for Part {
    fn from(mesh: &Mesh) -> Self {
        Self::new(mesh.clone())
    }
}
