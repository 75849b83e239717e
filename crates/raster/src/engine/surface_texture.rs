//! Checkers by the parameters of surfaces.

use csg::{Color, Surface};
use glam::{DMat3, DMat4, DVec3};

use crate::prepared::Prepared;
use crate::shade::Finish;
use crate::texture::{Mapping, Texture};

/// Squares around cones, and what else has no radius of its own.
const AROUND: u32 = 12;

impl Texture {
    /// A checker by the parameters u and v of a surface, of squares about so
    /// long, and the matrix from world coordinates to those that it goes by:
    ///
    /// - planes: two lengths at right angles;
    /// - spheres and ellipsoids: longitude and latitude about the axis that is
    ///   most upright;
    /// - cylinders: the angle around the axis, and the length along it;
    /// - cones and other quadrics: likewise, with twelve squares around.
    #[must_use]
    pub fn on_surface(surface: &Surface, side: f64, colors: [Color; 2]) -> (Self, DMat4) {
        let origin = surface.anchor();
        if surface.is_plane() {
            let normal = surface.gradient(origin).normalize_or(DVec3::Z);
            let (u, v) = normal.any_orthonormal_pair();
            let texture = Self {
                mapping: Mapping::Position,
                size: DVec3::new(side, side, f64::INFINITY),
                colors,
            };
            return (
                texture,
                to_parameters(DMat3::from_cols(u, v, normal), origin),
            );
        }
        let (values, axes) = surface.principal_axes();
        // (Which rounding may decide; the pattern is one either way.)
        let flat = values.map(|value| value.abs() < 1e-9);
        let positive = values.iter().filter(|&&value| value > 0.0).count();
        let closed = flat == [false; 3] && positive % 3 == 0;
        let along = (0..3).max_by(|&i, &j| {
            let rank = |k: usize| {
                let odd = (values[k] > 0.0) == (positive == 1);
                let alone = if closed { false } else { flat[k] || odd };
                (flat[k], alone, axes.col(k).z.abs())
            };
            rank(i)
                .partial_cmp(&rank(j))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let along = along.unwrap_or(2);
        let (across, other) = ((along + 1) % 3, (along + 2) % 3);
        let constant = surface.value(origin).abs();
        let radius = |k: usize| (constant / values[k].abs()).sqrt();
        let around = |radius: f64| {
            let half = (std::f64::consts::PI * radius / side).round();
            2 * half.clamp(1.0, 1e6) as u32
        };
        let upright = axes.col(along) * axes.col(along).z.signum();
        let of = |k: usize| axes.col(k) * values[k].abs().sqrt().max(1e-9);
        if closed {
            let mean = (radius(0) + radius(1) + radius(2)) / 3.0;
            let texture = Self::sphere(DVec3::ZERO, around(mean), around(mean) / 2, colors);
            let rows =
                DMat3::from_cols(of(across), of(other), upright * values[along].abs().sqrt());
            return (texture, to_parameters(rows, origin));
        }
        let count = if constant > 0.0 && flat[along] {
            around(f64::midpoint(radius(across), radius(other)))
        } else {
            AROUND
        };
        let texture = Self::cylinder(DVec3::ZERO, count, side, colors);
        (
            texture,
            to_parameters(DMat3::from_cols(of(across), of(other), upright), origin),
        )
    }
}

/// Products with the columns, relative to an origin.
fn to_parameters(columns: DMat3, origin: DVec3) -> DMat4 {
    DMat4::from_mat3(columns.transpose()) * DMat4::from_translation(-origin)
}

impl Prepared {
    /// Dyes the surfaces of the mesh, in the order of
    /// [`csg::Mesh::surfaces`], in patterns of their own, each with the matrix
    /// from world coordinates to those that it goes by
    /// ([`Texture::on_surface`]).
    #[must_use]
    pub fn with_textures(mut self, textures: impl IntoIterator<Item = (Texture, DMat4)>) -> Self {
        for (look, (texture, to_texture)) in self.looks.iter_mut().zip(textures) {
            look.texture = Some((texture, to_texture, Finish::default()));
        }
        self
    }
}
