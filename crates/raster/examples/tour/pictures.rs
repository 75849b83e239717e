//! One picture for each stage of the pipeline, in the order of the tour. The
//! stages' modes stand side by side.

use csg::Mesh;
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3};
use raster::hidden_surface::{DepthBuffer, Painter};
use raster::transform::{self, Shear};
use raster::{
    AntiAliasing, Camera, EdgeOptions, Frame, HiddenEdges, Image, Interpolation, Lens, Light,
    Prepared, ProjectionAngle, RasterError, RenderOptions, Renderer, SectionPlane, StandardView,
    View, Viewport, contact_sheet, depth_image, id_image, normal_image, occlusion_image,
    render_reference, turntable, turntable_camera,
};

use crate::common;

type Result<T> = std::result::Result<T, RasterError>;

/// Size of a panel in pixels, at scale 1.
const PANEL: (u32, u32) = (160, 120);
const ASPECT: f64 = 4.0 / 3.0;

const ORANGE: [f32; 3] = [0.85, 0.45, 0.25];
const YELLOW: [f32; 3] = [0.9, 0.8, 0.4];
const BLUE: [f32; 3] = [0.55, 0.65, 0.75];
const GREEN: [f32; 3] = [0.35, 0.65, 0.4];

/// All pictures with their names; panels are `scale` times as large as on the
/// page.
pub fn all(scale: u32) -> Result<Vec<(&'static str, Image)>> {
    let tour = Tour::new(scale);
    Ok(vec![
        ("transforms", tour.transforms()?),
        ("viewing", tour.viewing()?),
        ("projection", tour.projection()?),
        ("clipping", tour.clipping()?),
        ("viewport", tour.viewport()?),
        ("filling", tour.filling()?),
        ("hidden-surfaces", tour.hidden_surfaces()?),
        ("shading", tour.shading()?),
        ("anti-aliasing", tour.anti_aliasing()?),
        ("outputs", tour.outputs()?),
        ("engineering", tour.engineering()?),
        ("series", tour.series()?),
    ])
}

/// The frames of a turntable about the subject.
#[allow(dead_code, reason = "the kept pictures do not move")]
pub fn turntable_frames(scale: u32, frames: u32) -> Result<Vec<Image>> {
    Tour::new(scale).turntable(frames)
}

struct Tour {
    width: u32,
    height: u32,
    mesh: Mesh,
    scene: Prepared,
}

impl Tour {
    fn new(scale: u32) -> Self {
        let mesh = subject();
        Self {
            width: PANEL.0 * scale,
            height: PANEL.1 * scale,
            scene: Prepared::new(&mesh),
            mesh,
        }
    }

    fn draw(&self, scene: &Prepared, view: &View, options: &RenderOptions) -> Result<Image> {
        let mut image = Image::default();
        let (width, height) = (self.width, self.height);
        Renderer::default().draw(scene, view, width, height, options, &mut image)?;
        Ok(image)
    }

    /// A view of the subject.
    fn view(&self, view: StandardView, lens: Lens) -> Result<View> {
        let camera = Camera::standard(&self.mesh, view, lens, ASPECT)?;
        camera.view(self.width, self.height)
    }

    fn iso(&self) -> Result<View> {
        self.view(StandardView::Iso, Lens::DEFAULT)
    }

    /// A view of another mesh.
    fn view_of(&self, mesh: &Mesh) -> Result<View> {
        let camera = Camera::standard(mesh, StandardView::Iso, Lens::DEFAULT, ASPECT)?;
        camera.view(self.width, self.height)
    }

    /// A letter as it is, moved, scaled along a slanted frame, sheared,
    /// rotated and mirrored.
    fn transforms(&self) -> Result<Image> {
        let axis = DVec3::new(1.0, 0.0, 1.0).normalize();
        let frame = DMat3::from_cols(axis, DVec3::Y, axis.cross(DVec3::Y));
        let maps = [
            (DMat4::IDENTITY, BLUE),
            (
                transform::scaling_in_frame(frame, DVec3::new(1.6, 1.0, 0.8)),
                ORANGE,
            ),
            (transform::shear(Shear::XByZ, 0.6), GREEN),
            (transform::rotation(DVec3::new(1.0, 1.0, 1.0), 1.2), YELLOW),
            (transform::scaling(DVec3::new(-1.0, 1.0, 1.0)), ORANGE),
        ];
        let mut mesh = Mesh::default();
        for (k, (map, color)) in maps.into_iter().enumerate() {
            let place = transform::translation(DVec3::X * (2.8 * k as f64));
            let letter = common::colored(letter(), color);
            mesh = common::merge(mesh, &mapped(letter, place * map));
        }
        let lens = Lens::Orthographic { height: 1.0 };
        let aspect = 4.0 * ASPECT;
        let direction = DVec3::new(-0.3, 1.0, -0.4);
        let camera = Camera::framing(&mesh, direction, DVec3::Z, lens, aspect)?;
        let mut image = Image::default();
        let (width, height) = (4 * self.width, self.height);
        let view = camera.view(width, height)?;
        let scene = Prepared::new(&mesh);
        let mut options = smooth();
        options.edges = Some(EdgeOptions::default());
        Renderer::default().draw(&scene, &view, width, height, &options, &mut image)?;
        Ok(image)
    }

    /// A camera with its axes U, V, N and its view volume, and what it sees.
    fn viewing(&self) -> Result<Image> {
        let camera = Camera {
            eye: DVec3::new(2.2, -3.4, 2.0),
            target: DVec3::new(0.0, 0.0, 0.5),
            up: DVec3::Z,
            lens: Lens::Perspective { fov_y: 0.75 },
            near: 1.6,
            far: 6.5,
        };
        let seen = camera.view(self.width, self.height)?;
        let mut mesh = self.mesh.clone();
        // The corners of the clip cube, back in the world.
        let corners: Vec<DVec3> = (0..8)
            .map(|i| {
                let sign = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
                let ndc = DVec4::new(sign(1), sign(2), sign(4), 1.0);
                let world = seen.clip_to_world() * ndc;
                world.truncate() / world.w
            })
            .collect();
        for (a, b) in (0..8).flat_map(|i| [1, 2, 4].map(|bit| (i, i ^ bit))) {
            if a < b {
                let rod = rod(corners[a], corners[b], 0.02);
                mesh = common::merge(mesh, &common::colored(rod, [0.3, 0.3, 0.35]));
            }
        }
        let frame = Frame::right_handed(camera.target - camera.eye, camera.up);
        let axes = [
            (frame.u, [0.85, 0.2, 0.2]),
            (frame.v, [0.2, 0.65, 0.25]),
            (frame.n, [0.25, 0.4, 0.9]),
        ];
        for (axis, color) in axes {
            let rod = rod(camera.eye, camera.eye + axis * 0.9, 0.05);
            mesh = common::merge(mesh, &common::colored(rod, color));
        }
        mesh.corner_normals.clear();
        let lens = Lens::DEFAULT;
        let direction = DVec3::new(-1.0, 0.25, -0.45);
        let from_aside = Camera::framing(&mesh, direction, DVec3::Z, lens, ASPECT)?;
        let from_aside = from_aside.view(self.width, self.height)?;
        Ok(row(&[
            self.draw(&Prepared::new(&mesh), &from_aside, &smooth())?,
            self.draw(&self.scene, &seen, &smooth())?,
        ]))
    }

    /// Perspective, orthographic, cavalier and cabinet.
    fn projection(&self) -> Result<Image> {
        let oblique = |ratio| Lens::Oblique {
            height: 1.0,
            ratio,
            angle: std::f64::consts::FRAC_PI_4,
        };
        let lenses = [
            (StandardView::Iso, Lens::Perspective { fov_y: 1.1 }),
            (StandardView::Iso, Lens::Orthographic { height: 1.0 }),
            (StandardView::Front, oblique(1.0)),
            (StandardView::Front, oblique(0.5)),
        ];
        let draw = |(view, lens)| self.draw(&self.scene, &self.view(view, lens)?, &smooth());
        Ok(row(&lenses
            .into_iter()
            .map(draw)
            .collect::<Result<Vec<_>>>()?))
    }

    /// From inside a hollow ball: clipped at the near plane and beyond the
    /// sides.
    fn clipping(&self) -> Result<Image> {
        let ball = common::icosphere(DVec3::ZERO, 1.0, 2);
        let hollow = Prepared::new(&common::colored(inside_out(ball), YELLOW));
        let inside = Camera {
            eye: DVec3::new(0.3, -0.75, 0.2),
            target: DVec3::ZERO,
            up: DVec3::Z,
            lens: Lens::Perspective { fov_y: 1.8 },
            near: 0.05,
            far: 10.0,
        };
        let mut options = smooth();
        let mut edges = EdgeOptions::default();
        edges.wireframe = true;
        edges.width = 0.7;
        options.edges = Some(edges);
        let view = inside.view(self.width, self.height)?;
        self.draw(&hollow, &view, &options)
    }

    /// The same view on a screen of few pixels, and where a point of the world
    /// falls on either.
    fn viewport(&self) -> Result<Image> {
        const PIXEL: u32 = 8;
        let point = DVec3::new(0.9, -1.25, 0.35);
        let view = self.iso()?;
        let mut pictures = Vec::new();
        for side in [PIXEL, 1] {
            let (width, height) = (self.width / side, self.height / side);
            let mut image = Image::default();
            let options = RenderOptions::default();
            Renderer::default().draw(&self.scene, &view, width, height, &options, &mut image)?;
            let viewport = Viewport::of_image(width, height);
            if let Some(window) = viewport.project(&view, point) {
                let at = DVec2::new(window.x, window.y).floor().as_uvec2();
                let half = PIXEL / side / 2;
                let mark = Image::new(2 * half + 1, 2 * half + 1, [220, 20, 20, 255]);
                image.paste(&mark, at.x - half, at.y - half);
            }
            pictures.push(enlarged(&image, side));
        }
        pictures.swap(0, 1);
        Ok(row(&pictures))
    }

    /// The triangle of each pixel; pixels enlarged.
    fn filling(&self) -> Result<Image> {
        const PIXEL: u32 = 4;
        let ball = common::icosphere(DVec3::ZERO, 1.0, 1);
        let (view, options) = (self.view_of(&ball)?, RenderOptions::default());
        let (width, height) = (self.width / PIXEL, self.height / PIXEL);
        let mut renderer = Renderer::default();
        let mut shaded = Image::default();
        renderer.draw(
            &Prepared::new(&ball),
            &view,
            width,
            height,
            &options,
            &mut shaded,
        )?;
        Ok(enlarged(&id_image(&renderer.triangle_buffer()), PIXEL))
    }

    /// The painter's algorithm and the depth buffer.
    fn hidden_surfaces(&self) -> Result<Image> {
        let plates = plates();
        let view = self.view_of(&plates)?;
        let mut options = RenderOptions::default();
        options.cull_back_faces = false;
        options.two_sided = true;
        let (width, height) = (self.width, self.height);
        let mut depth = DepthBuffer::new((width * height) as usize);
        Ok(row(&[
            render_reference(&plates, &view, width, height, &options, &mut Painter)?,
            render_reference(&plates, &view, width, height, &options, &mut depth)?,
        ]))
    }

    /// Flat, Gouraud and Phong.
    fn shading(&self) -> Result<Image> {
        let ball = common::icosphere(DVec3::ZERO, 1.0, 1);
        let view = self.view_of(&ball)?;
        let scene = Prepared::new(&ball);
        let modes = [
            Interpolation::Flat,
            Interpolation::Gouraud,
            Interpolation::Phong,
        ];
        let draw = |interpolation| {
            let mut options = smooth();
            options.interpolation = interpolation;
            options.lights = vec![
                Light::Ambient {
                    intensity: Vec3::splat(0.1),
                },
                Light::Camera {
                    towards: DVec3::new(-0.5, 0.8, 1.0),
                    intensity: Vec3::splat(1.4),
                },
            ];
            self.draw(&scene, &view, &options)
        };
        Ok(row(&modes
            .into_iter()
            .map(draw)
            .collect::<Result<Vec<_>>>()?))
    }

    /// One sample a pixel, four, eight, and everything sixteen times; pixels
    /// enlarged.
    fn anti_aliasing(&self) -> Result<Image> {
        const PIXEL: u32 = 4;
        let view = self.iso()?;
        let (width, height) = (self.width / PIXEL, self.height / PIXEL);
        let modes = [
            AntiAliasing::None,
            AntiAliasing::Msaa4,
            AntiAliasing::Msaa8,
            AntiAliasing::Supersample(4),
        ];
        let draw = |mode| {
            let mut options = RenderOptions::default();
            options.anti_aliasing = mode;
            let mut image = Image::default();
            Renderer::default().draw(&self.scene, &view, width, height, &options, &mut image)?;
            Ok(enlarged(&image, PIXEL))
        };
        Ok(row(&modes
            .into_iter()
            .map(draw)
            .collect::<Result<Vec<_>>>()?))
    }

    /// Depth, normals, surfaces and ambient occlusion.
    fn outputs(&self) -> Result<Image> {
        let view = self.iso()?;
        let mut renderer = Renderer::default();
        let mut image = Image::default();
        let (width, height) = (self.width, self.height);
        let options = RenderOptions::default();
        renderer.draw(&self.scene, &view, width, height, &options, &mut image)?;
        Ok(row(&[
            depth_image(&renderer.depth_buffer()),
            normal_image(&renderer.normal_buffer(&self.scene, &view)),
            id_image(&renderer.surface_buffer(&self.scene)),
            occlusion_image(&renderer.ambient_occlusion(&self.scene, &view)),
        ]))
    }

    /// Hidden edges, wireframe and vertices, a section, and a presentation
    /// with edges, shadow, occlusion and axes.
    fn engineering(&self) -> Result<Image> {
        let view = self.iso()?;
        let mut hidden = smooth();
        let mut edges = EdgeOptions::default();
        edges.hidden = HiddenEdges::Dash;
        hidden.edges = Some(edges);
        let mut wire = smooth();
        let mut edges = EdgeOptions::default();
        edges.wireframe = true;
        edges.points = true;
        edges.width = 0.7;
        wire.edges = Some(edges);
        let ball = common::icosphere(DVec3::ZERO, 1.0, 1);
        let cut = SectionPlane {
            normal: DVec3::NEG_Y,
            point: DVec3::new(0.0, -0.2, 0.0),
        };
        let section = Prepared::with_sections(&self.mesh, &[cut])?;
        let mut presentation = with_edges();
        presentation.ground_shadow = true;
        presentation.ambient_occlusion = true;
        presentation.triad = true;
        Ok(row(&[
            self.draw(&self.scene, &view, &hidden)?,
            self.draw(&Prepared::new(&ball), &self.view_of(&ball)?, &wire)?,
            self.draw(&section, &view, &with_edges())?,
            self.draw(&self.scene, &view, &presentation)?,
        ]))
    }

    /// A contact sheet, and three frames of a turntable.
    fn series(&self) -> Result<Image> {
        let (width, height) = (self.width, self.height);
        let options = with_edges();
        let sheet = contact_sheet(
            &self.mesh,
            &self.scene,
            Lens::DEFAULT,
            ProjectionAngle::Third,
            width,
            height,
            &options,
        )?;
        let mut pictures = vec![sheet];
        pictures.extend(self.turntable(3)?);
        Ok(row(&pictures))
    }

    fn turntable(&self, frames: u32) -> Result<Vec<Image>> {
        let camera = turntable_camera(&self.mesh, StandardView::Iso, Lens::DEFAULT, ASPECT)?;
        let (width, height) = (self.width, self.height);
        turntable(&self.scene, &camera, frames, width, height, &with_edges())
    }
}

fn smooth() -> RenderOptions {
    let mut options = RenderOptions::default();
    options.anti_aliasing = AntiAliasing::Msaa8;
    options
}

fn with_edges() -> RenderOptions {
    let mut options = smooth();
    options.edges = Some(EdgeOptions::default());
    options
}

/// Pictures of one size side by side.
fn row(pictures: &[Image]) -> Image {
    let (width, height) = pictures
        .first()
        .map_or((0, 0), |image| (image.width, image.height));
    let mut all = Image::new(width * pictures.len() as u32, height, [0; 4]);
    for (image, k) in pictures.iter().zip(0..) {
        all.paste(image, k * width, 0);
    }
    all
}

/// A picture whose pixels are squares of `side` pixels.
fn enlarged(image: &Image, side: u32) -> Image {
    let mut large = Image::new(image.width * side, image.height * side, [0; 4]);
    for (pixel, k) in image.pixels.iter().zip(0..) {
        let (x, y) = (k % image.width, k / image.width);
        large.paste(&Image::new(side, side, *pixel), x * side, y * side);
    }
    large
}

/// A hollow ball on a block, and a small ball beside them.
fn subject() -> Mesh {
    let ball = common::icosphere(DVec3::new(0.0, 0.0, 0.9), 1.0, 4);
    let hollow = inside_out(common::icosphere(DVec3::new(0.0, 0.0, 0.9), 0.8, 4));
    let mut block = common::cuboid(DVec3::new(-1.2, -1.2, -0.6), DVec3::new(1.2, 1.2, 0.1));
    block.corner_normals = raster::corner_normals(&block, 0.5);
    let small = common::icosphere(DVec3::new(0.9, -1.0, 0.35), 0.25, 3);
    let mut mesh = common::colored(ball, ORANGE);
    for (part, color) in [(hollow, YELLOW), (block, BLUE), (small, GREEN)] {
        mesh = common::merge(mesh, &common::colored(part, color));
    }
    mesh
}

/// A mesh whose faces look the other way.
fn inside_out(mut mesh: Mesh) -> Mesh {
    for (triangle, normals) in mesh.triangles.iter_mut().zip(&mut mesh.corner_normals) {
        triangle.swap(1, 2);
        normals.swap(1, 2);
        *normals = normals.map(|n| -n);
    }
    mesh
}

/// The letter F, which no symmetry maps to itself.
fn letter() -> Mesh {
    /// Its outline in x and z, counterclockwise as seen from the front.
    const OUTLINE: [[f64; 2]; 10] = [
        [-0.6, -1.0],
        [-0.2, -1.0],
        [-0.2, -0.2],
        [0.4, -0.2],
        [0.4, 0.2],
        [-0.2, 0.2],
        [-0.2, 0.6],
        [0.6, 0.6],
        [0.6, 1.0],
        [-0.6, 1.0],
    ];
    const FACE: [[u32; 3]; 8] = [
        [0, 1, 2],
        [2, 3, 4],
        [2, 4, 5],
        [6, 7, 8],
        [6, 8, 9],
        [0, 2, 5],
        [0, 5, 6],
        [0, 6, 9],
    ];
    let side = |y: f64| OUTLINE.map(|[x, z]| DVec3::new(x, y, z));
    let positions = [side(-0.25), side(0.25)].concat();
    let mut triangles = FACE.to_vec();
    triangles.extend(FACE.map(|[a, b, c]| [a + 10, c + 10, b + 10]));
    for k in 0..10 {
        let next = (k + 1) % 10;
        triangles.extend([[k, k + 10, next + 10], [k, next + 10, next]]);
    }
    Mesh::new(positions, triangles)
}

/// A mesh under an affine map; mirrored triangles are turned round again.
fn mapped(mut mesh: Mesh, map: DMat4) -> Mesh {
    for p in &mut mesh.positions {
        *p = map.transform_point3(*p);
    }
    if DMat3::from_mat4(map).determinant() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    mesh
}

/// A thin square bar from one point to another.
fn rod(from: DVec3, to: DVec3, thickness: f64) -> Mesh {
    let length = from.distance(to);
    let half = DVec3::new(thickness / 2.0, thickness / 2.0, 0.0);
    let bar = common::cuboid(-half, DVec3::new(half.x, half.y, length));
    let turn = transform::rotation_between(DVec3::Z, to - from);
    mapped(bar, transform::translation(from) * turn)
}

/// Three plates that cut each other.
fn plates() -> Mesh {
    let mut mesh = Mesh::default();
    let colors = [[0.85, 0.3, 0.25], [0.3, 0.7, 0.35], [0.3, 0.45, 0.9]];
    for (k, color) in colors.into_iter().enumerate() {
        let at = |u: f64, v: f64| {
            let mut p = DVec3::ZERO;
            p[k] = u;
            p[(k + 1) % 3] = v;
            p
        };
        let plate = Mesh::new(
            vec![at(-1.0, -0.6), at(1.0, -0.6), at(1.0, 0.6), at(-1.0, 0.6)],
            vec![[0, 1, 2], [0, 2, 3]],
        );
        mesh = common::merge(mesh, &common::colored(plate, color));
    }
    mesh
}
