//! Scenes of several parts, and their pictures in one step.

use csg::{Color, Mesh};
use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::RasterError;
use crate::camera::{Camera, Lens};
use crate::framing::Framing;
use crate::image::Image;
use crate::light::Light;
use crate::look::SurfaceLook;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::options::RenderOptions;
use crate::part::Part;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::shade::{Finish, Material};
use crate::transform::normal_matrix;
use crate::viewpoint::clear_view;

/// Parts with their materials and places, and lights.
///
/// ```
/// use raster::{Camera, Finish, Light, Part, RenderOptions, Scene};
/// # use glam::DVec3;
/// # use csg::{Color, Mesh};
/// # let mesh = Mesh::new(vec![DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2]]);
/// let part = Part::new(mesh).at(DVec3::Z);
/// let scene = Scene::new()
///     .add(part)
///     .color(Color::from_srgb([0.8, 0.4, 0.2]))
///     .finish(Finish::new(0.5, 0.5, 0.8, 4.0));
/// let camera = Camera::looking_at(DVec3::new(3.0, -4.0, 3.0), DVec3::ZERO);
/// let image = scene.render(&camera, &RenderOptions::default().size(64, 48))?;
/// # assert_eq!(image.width, 64);
/// # Ok::<(), raster::RasterError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    parts: Vec<Part>,
    lights: Vec<Light>,
}

impl Scene {
    /// An empty scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a part: a mesh, or a [`Part`] with its places and material.
    #[must_use]
    #[allow(clippy::should_implement_trait, reason = "no sum of two scenes")]
    pub fn add(mut self, part: impl Into<Part>) -> Self {
        self.parts.push(part.into());
        self
    }

    /// Changes the part added last; an empty scene stays as it is.
    fn change(mut self, change: impl FnOnce(Part) -> Part) -> Self {
        if let Some(part) = self.parts.pop() {
            self.parts.push(change(part));
        }
        self
    }

    /// Gives the part added last a material ([`Part::material`]).
    #[must_use]
    pub fn material(self, material: Material) -> Self {
        self.change(|part| part.material(material))
    }

    /// Gives the part added last a colour ([`Part::color`]).
    #[must_use]
    pub fn color(self, color: Color) -> Self {
        self.change(|part| part.color(color))
    }

    /// Says how the part added last reflects ([`Part::finish`]).
    #[must_use]
    pub fn finish(self, finish: Finish) -> Self {
        self.change(|part| part.finish(finish))
    }

    /// Adds a light. Without any, those of the options shine.
    #[must_use]
    pub fn light(mut self, light: Light) -> Self {
        self.lights.push(light);
        self
    }

    /// The parts, in the order in which they were added.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// All parts in their places as one mesh; and for each of its surfaces what
    /// it looks like.
    #[must_use]
    pub fn to_mesh(&self) -> Mesh {
        self.baked().0
    }

    fn baked(&self) -> (Mesh, Vec<SurfaceLook>, Vec<u32>) {
        let mut all = Mesh::default();
        let (mut looks, mut ends) = (Vec::new(), Vec::new());
        let mut bodies = 0;
        let with_edges = self
            .parts
            .iter()
            .any(|part| !part.mesh.feature_edges.is_empty());
        for part in &self.parts {
            let mut own = (*part.mesh).clone();
            own.corner_normals = corner_normals(&own, CREASE_ANGLE);
            if with_edges && own.feature_edges.is_empty() {
                own.feature_edges = Prepared::new(&own).feature_edges().to_vec();
            }
            for &model in &part.models {
                append(&mut all, &own, model);
                // Bodies are numbered in each mesh.
                let mut most = 0;
                let first = all.surfaces.len() - own.surfaces.len();
                for surface in all.surfaces[first..].iter_mut().filter(|s| s.body > 0) {
                    most = surface.body.max(most);
                    surface.body += bodies;
                }
                bodies += most;
                looks.extend(
                    own.surfaces
                        .iter()
                        .map(|s| part.look.of_color(s.color, model)),
                );
                // For triangles without a surface.
                looks.push(part.look.of_color(None, model));
                all.surfaces.push(csg::MeshSurface::default());
                ends.push(all.triangles.len() as u32);
            }
        }
        (all, looks, ends)
    }

    /// The scene made ready to be drawn any number of times. Every place of a
    /// part costs memory of its own.
    #[must_use]
    pub fn prepare(&self) -> Prepared {
        let (mesh, looks, ends) = self.baked();
        Prepared::from(mesh).with_looks(looks, ends)
    }

    /// A camera that sees the whole scene: isometric, turned where one face
    /// would hide the rest, so that the shadow is seen where the options want
    /// one.
    ///
    /// # Errors
    /// [`RasterError::NothingToFrame`] for a scene without finite vertices.
    pub fn camera(&self, options: &RenderOptions) -> Result<Camera, RasterError> {
        let mesh = self.to_mesh();
        let framing = Framing {
            direction: clear_view(&mesh, &[]),
            up: DVec3::Z,
            lens: Lens::DEFAULT,
            aspect: f64::from(options.width.max(1)) / f64::from(options.height.max(1)),
            shadow: options.ground_shadow,
        };
        framing.camera(&mesh)
    }

    /// Draws the scene as a camera sees it. To draw it more than once,
    /// [`prepare`](Self::prepare) it and keep a [`Renderer`].
    ///
    /// # Errors
    /// Those of [`Camera::view`] and [`Renderer::draw`].
    pub fn render(&self, camera: &Camera, options: &RenderOptions) -> Result<Image, RasterError> {
        let (width, height) = (options.width, options.height);
        let view = camera.view(width, height)?;
        let mut options = options.clone();
        if !self.lights.is_empty() {
            options.lights.clone_from(&self.lights);
        }
        let mut image = Image::default();
        let prepared = self.prepare();
        Renderer::default().draw(&prepared, &view, width, height, &options, &mut image)?;
        Ok(image)
    }
}

/// Adds a mesh, placed by a model matrix, to another: points by the matrix,
/// normals by its [`normal_matrix`], triangles turned round where it mirrors.
fn append(all: &mut Mesh, part: &Mesh, model: DMat4) {
    let linear = DMat3::from_mat4(model);
    let (normals, mirrors) = (normal_matrix(linear), linear.determinant() < 0.0);
    let turn = |[a, b, c]: [u32; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
    let base = all.positions.len() as u32;
    let placed = part.positions.iter().map(|&p| model.transform_point3(p));
    all.positions.extend(placed);
    let triangles = part.triangles.iter();
    // (Vertices that are not there stay so.)
    let moved = |v: u32| v.saturating_add(base);
    let known = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < part.positions.len());
    all.triangles.extend(triangles.map(|t| {
        if known(t) {
            turn(t.map(moved))
        } else {
            [u32::MAX; 3]
        }
    }));
    let placed = |n: Vec3| (normals * n.as_dvec3()).normalize_or_zero().as_vec3();
    let corners = part.corner_normals.iter();
    all.corner_normals.extend(corners.map(|&[a, b, c]| {
        let [b, c] = if mirrors { [c, b] } else { [b, c] };
        [a, b, c].map(placed)
    }));
    let first = all.surfaces.len() as u32;
    let none = part.surfaces.len() as u32;
    if part.triangle_surfaces.len() == part.triangles.len() {
        let own = part.triangle_surfaces.iter();
        all.triangle_surfaces
            .extend(own.map(|&s| first + s.min(none)));
    } else {
        let own = std::iter::repeat_n(first + none, part.triangles.len());
        all.triangle_surfaces.extend(own);
    }
    all.surfaces.extend(part.surfaces.iter().cloned());
    let lines = part.feature_edges.iter();
    all.feature_edges
        .extend(lines.map(|line| line.iter().map(|&v| moved(v)).collect()));
}
