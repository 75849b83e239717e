//! One picture for each stage and mode of the pipeline.
//!
//! `cargo run --release -p raster --example tour -- FOLDER`

use std::fs::{self, File};
use std::path::Path;

use csg::{Color, Mesh, Mesher, Program, Solid};
use glam::{DVec3, Vec3};
use raster::hidden_surface::{DepthBuffer, Painter};
use raster::{
    AntiAliasing, Camera, EdgeOptions, HiddenEdges, Image, Interpolation, Lens, Light,
    RenderOptions, Renderer, Scene, SectionPlane, StandardView, contact_sheet, depth_image,
    id_image, normal_image, occlusion_image, render_reference, turntable, turntable_camera,
    write_apng,
};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;

/// A cube rounded by a sphere, with a bore along each axis.
fn subject() -> Result<Mesh> {
    let blank =
        (Solid::cube(1.5) & Solid::sphere(1.0)).colored(Color::from_srgb([0.75, 0.78, 0.82]));
    let bore = Solid::cylinder(0.5, -1.0..1.0).colored(Color::from_srgb([0.85, 0.45, 0.25]));
    let quarter = std::f64::consts::FRAC_PI_2;
    let bores = bore.clone() | bore.rotate_x(quarter) | bore.rotate_y(quarter);
    let program = Program::lower(&(blank - bores))?;
    Ok(Mesher::new().cells(96).mesh(&program)?.mesh)
}

fn save(folder: &Path, name: &str, image: &Image) -> Result<()> {
    fs::write(folder.join(name).with_extension("png"), image.to_png()?)?;
    Ok(())
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "tour".to_owned());
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    let mesh = subject()?;
    let scene = Scene::new(&mesh);
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let mut renderer = Renderer::default();
    let iso = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, aspect)?;
    let view = iso.view(WIDTH, HEIGHT)?;
    let mut plain = RenderOptions::default();
    plain.anti_aliasing = AntiAliasing::Msaa8;
    let mut draw =
        |scene: &Scene, camera: &Camera, options: &RenderOptions, name: &str| -> Result<()> {
            let mut image = Image::default();
            renderer.draw(
                scene,
                &camera.view(WIDTH, HEIGHT)?,
                WIDTH,
                HEIGHT,
                options,
                &mut image,
            )?;
            save(folder, name, &image)
        };

    // Projections.
    for (name, lens) in [
        ("perspective", Lens::Perspective { fov_y: 0.9 }),
        ("orthographic", Lens::Orthographic { height: 1.0 }),
        (
            "cabinet",
            Lens::Oblique {
                height: 1.0,
                ratio: 0.5,
                angle: 0.7,
            },
        ),
    ] {
        let direction = if name == "cabinet" {
            StandardView::Front
        } else {
            StandardView::Iso
        };
        draw(
            &scene,
            &Camera::standard(&mesh, direction, lens, aspect)?,
            &plain,
            name,
        )?;
    }
    // Interpolation.
    let coarse = Scene::new(&coarse_ball());
    let ball = Camera::standard(&coarse_ball(), StandardView::Iso, Lens::DEFAULT, aspect)?;
    for (name, interpolation) in [
        ("flat", Interpolation::Flat),
        ("gouraud", Interpolation::Gouraud),
        ("phong", Interpolation::Phong),
    ] {
        let mut options = plain.clone();
        options.interpolation = interpolation;
        options.lights = shiny_lights();
        draw(&coarse, &ball, &options, name)?;
    }
    // Anti-aliasing.
    for (name, mode) in [
        ("aliased", AntiAliasing::None),
        ("msaa4", AntiAliasing::Msaa4),
        ("msaa8", AntiAliasing::Msaa8),
        ("supersampled", AntiAliasing::Supersample(4)),
    ] {
        let mut options = plain.clone();
        options.anti_aliasing = mode;
        draw(&scene, &iso, &options, name)?;
    }
    // What engineers look at.
    let mut edges = plain.clone();
    edges.edges = Some(EdgeOptions::default());
    draw(&scene, &iso, &edges, "edges")?;
    let mut hidden = edges.clone();
    if let Some(edges) = &mut hidden.edges {
        edges.hidden = HiddenEdges::Dash;
    }
    draw(&scene, &iso, &hidden, "hidden-edges")?;
    let mut wire = plain.clone();
    let mut wireframe = EdgeOptions::default();
    wireframe.wireframe = true;
    wireframe.width = 0.5;
    wire.edges = Some(wireframe);
    draw(&coarse, &ball, &wire, "wireframe")?;
    let cut = [SectionPlane {
        normal: DVec3::NEG_Y,
        point: DVec3::new(0.0, -0.1, 0.0),
    }];
    let section = Scene::with_sections(&mesh, &cut)?;
    draw(&section, &iso, &edges, "section")?;
    let mut presentation = edges.clone();
    presentation.ground_shadow = true;
    presentation.ambient_occlusion = true;
    presentation.triad = true;
    draw(&scene, &iso, &presentation, "presentation")?;

    // Buffers.
    let mut image = Image::default();
    let single = RenderOptions::default();
    renderer.draw(&scene, &view, WIDTH, HEIGHT, &single, &mut image)?;
    save(folder, "depth", &depth_image(&renderer.depth_buffer()))?;
    save(
        folder,
        "normals",
        &normal_image(&renderer.normal_buffer(&scene, &view)),
    )?;
    save(
        folder,
        "surfaces",
        &id_image(&renderer.surface_buffer(&scene)),
    )?;
    save(folder, "triangles", &id_image(&renderer.triangle_buffer()))?;
    save(
        folder,
        "occlusion",
        &occlusion_image(&renderer.ambient_occlusion(&scene, &view)),
    )?;

    // Hidden surfaces: where the painter fails.
    let crossing = crossing_plates();
    let camera = Camera::standard(&crossing, StandardView::Iso, Lens::DEFAULT, aspect)?;
    let view = camera.view(WIDTH, HEIGHT)?;
    let mut options = RenderOptions::default();
    options.cull_back_faces = false;
    options.two_sided = true;
    let painted = render_reference(&crossing, &view, WIDTH, HEIGHT, &options, &mut Painter)?;
    save(folder, "painter", &painted)?;
    let mut depth = DepthBuffer::new((WIDTH * HEIGHT) as usize);
    let right = render_reference(&crossing, &view, WIDTH, HEIGHT, &options, &mut depth)?;
    save(folder, "depth-buffer", &right)?;

    // Series.
    save(
        folder,
        "sheet",
        &contact_sheet(&mesh, &scene, Lens::DEFAULT, 640, 480, &edges)?,
    )?;
    let camera = turntable_camera(&mesh, StandardView::Iso, Lens::DEFAULT, aspect)?;
    let frames = turntable(&scene, &camera, 24, WIDTH, HEIGHT, &edges)?;
    write_apng(&frames, 12, File::create(folder.join("turntable.png"))?)?;
    Ok(())
}

fn shiny_lights() -> Vec<Light> {
    vec![
        Light::Ambient {
            intensity: Vec3::splat(0.1),
        },
        Light::Camera {
            towards: DVec3::new(-0.5, 0.8, 1.0),
            intensity: Vec3::splat(1.2),
        },
    ]
}

fn coarse_ball() -> Mesh {
    let program = Program::lower(&Solid::sphere(1.0)).expect("a sphere");
    Mesher::new().cells(8).mesh(&program).expect("a mesh").mesh
}

/// Three plates that overlap each other in a circle and cut each other.
fn crossing_plates() -> Mesh {
    let mut mesh = Mesh::default();
    for (k, color) in [[0.85, 0.3, 0.25], [0.3, 0.7, 0.35], [0.3, 0.45, 0.9]]
        .into_iter()
        .enumerate()
    {
        let axis = |u: f64, v: f64| {
            let mut p = DVec3::ZERO;
            p[k] = u;
            p[(k + 1) % 3] = v;
            p
        };
        let base = mesh.positions.len() as u32;
        mesh.positions.extend([
            axis(-1.0, -0.6),
            axis(1.0, -0.6),
            axis(1.0, 0.6),
            axis(-1.0, 0.6),
        ]);
        mesh.triangles
            .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        mesh.triangle_surfaces.extend([k as u32; 2]);
        mesh.surfaces.push(csg::MeshSurface {
            color: Some(Color::from_srgb(color)),
            ..csg::MeshSurface::default()
        });
    }
    mesh
}
