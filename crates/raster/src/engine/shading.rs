//! What shading needs to know about a frame, and the colour of single points.

use csg::Color;
use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::caps::Caps;
use crate::frame::FrameMatrix;
use crate::light::Source;
use crate::options::RenderOptions;
use crate::prepared::Prepared;
use crate::shade::{Incident, Interpolation, Material, phong};

/// All that shading needs to know about a frame.
pub(crate) struct ShadeContext<'a> {
    pub scene: &'a Prepared,
    pub matrix: &'a FrameMatrix,
    pub materials: Vec<Material>,
    /// Index of the material of triangles without a surface.
    last: usize,
    pub ambient: Vec3,
    pub lights: Vec<(Source, Vec3)>,
    pub interpolation: Interpolation,
    /// Whether all pixels that a triangle covers have their centre in it.
    pub centred: bool,
    pub two_sided: bool,
    /// Whether shading depends on where on the surface a pixel lies, not only
    /// on where it is seen.
    pub positional: bool,
    pub caps: Caps,
    /// Whether surfaces have textures, and whether some are seen through.
    pub textured: bool,
    pub transparent: bool,
}

impl<'a> ShadeContext<'a> {
    pub fn new(
        scene: &'a Prepared,
        view: &View,
        matrix: &'a FrameMatrix,
        options: &RenderOptions,
    ) -> Self {
        let mut ambient = Vec3::ZERO;
        let mut sources = Vec::new();
        for light in &options.lights {
            let intensity = light.intensity();
            match light.source(view) {
                Some(Source::Everywhere) => ambient += intensity,
                Some(Source::Position(position)) => {
                    sources.push((Source::Position(position - scene.centre), intensity));
                }
                Some(source) => sources.push((source, intensity)),
                None => {}
            }
        }
        let positional = sources
            .iter()
            .any(|(s, _)| matches!(s, Source::Position(_)));
        let looks = scene.looks.iter();
        let mut materials: Vec<_> = looks.map(|look| look.material(options)).collect();
        let textured = scene.looks.iter().any(|look| look.texture.is_some());
        let transparent = scene.is_transparent(options);
        // Where all are alike, nobody need look which one it is.
        if !textured && materials.iter().all(|material| *material == materials[0]) {
            materials.truncate(1);
        }
        let last = materials.len() - 1;
        materials.extend(
            options
                .cap_color
                .map(|color| Material::new(color, options.finish)),
        );
        Self {
            scene,
            matrix,
            materials,
            last,
            ambient,
            lights: sources,
            interpolation: options.interpolation,
            centred: options.anti_aliasing.samples().len() == 1,
            // Of solids cut open, backs are seen where a silhouette passes exactly
            // through a sample, as near as the front.
            two_sided: options.two_sided || !scene.sections.is_empty() || transparent,
            positional: positional || textured,
            textured,
            transparent,
            caps: Caps::new(&scene.sections, matrix),
        }
    }

    /// Index of a triangle's material.
    #[inline(always)]
    pub fn material(&self, triangle: usize) -> usize {
        let last = self.last;
        if last == 0 {
            return 0;
        }
        self.scene
            .triangle_surfaces
            .get(triangle)
            .map_or(last, |&surface| (surface as usize).min(last))
    }

    /// How opaque a triangle is.
    pub fn opacity(&self, triangle: usize) -> f32 {
        self.materials[self.material(triangle)].opacity
    }

    /// A material with its texture's colour at a point.
    pub fn textured(&self, material: usize, point: DVec3) -> Material {
        let plain = self.materials[material];
        let look = self.scene.looks.get(material).and_then(|look| look.texture);
        match look {
            Some((texture, to_part, finish)) => {
                let at = to_part.transform_point3(point + self.scene.centre);
                let color = Color::from_linear(texture.color(at).to_array());
                Material {
                    opacity: plain.opacity,
                    ..Material::new(color, finish)
                }
            }
            None => plain,
        }
    }

    /// Index of the material of the caps of sections: the default colour, for
    /// they lie inside the solid, on none of its surfaces.
    pub fn cap_material(&self) -> usize {
        self.materials.len() - 1
    }

    /// The colour of a cap at one point.
    pub fn cap_colour(&self, point: DVec3, normal: DVec3) -> Vec3 {
        self.colour(self.cap_material(), point, normal.as_vec3())
    }

    /// The colours of a triangle's corners, for Gouraud shading.
    pub fn corner_colours(
        &self,
        triangle: usize,
        corners: &[DVec3; 3],
        normals: &[Vec3; 3],
    ) -> [Vec3; 3] {
        let material = self.material(triangle);
        [0, 1, 2].map(|k| self.colour(material, corners[k], normals[k]))
    }

    /// The colour of a whole triangle, for flat shading.
    pub fn flat_colour(&self, triangle: usize, [a, b, c]: &[DVec3; 3]) -> Vec3 {
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        self.colour(self.material(triangle), (a + b + c) / 3.0, normal)
    }

    /// The colour at one point, for the modes that shade per corner or per
    /// triangle.
    fn colour(&self, material: usize, point: DVec3, normal: Vec3) -> Vec3 {
        let viewer = self.matrix.viewer.truncate() - point * self.matrix.viewer.w;
        let viewer = viewer.normalize_or_zero().as_vec3();
        let normal = if self.two_sided && normal.dot(viewer) < 0.0 {
            -normal
        } else {
            normal
        };
        let mut incident = vec![Incident {
            towards: Vec3::ZERO,
            intensity: self.ambient,
        }];
        let lights = self.lights.iter();
        incident
            .extend(lights.map(|&(source, intensity)| source.at(point, normal, viewer, intensity)));
        let material = self.textured(material, point);
        phong(&material, &incident, normal, viewer)
    }
}
