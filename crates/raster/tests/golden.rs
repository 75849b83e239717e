//! Every mode's picture against the one kept in `docs/`, which the crate's
//! page shows.
//!
//! STEREOTOMY_BLESS=1 draws them anew, to be looked at before they are kept.

mod common;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use csg::Mesh;
use glam::{DVec3, Vec3};
use raster::hidden_surface::{DepthBuffer, Painter};
use raster::{
    AntiAliasing, Camera, EdgeOptions, HiddenEdges, Image, Interpolation, Lens, Light,
    RenderOptions, Renderer, Scene, SectionPlane, StandardView, depth_image, id_image,
    normal_image, occlusion_image, render_reference,
};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;
const ASPECT: f64 = 4.0 / 3.0;

/// A hollow ball on a block, and a small ball beside them.
fn subject() -> Mesh {
    let ball = common::icosphere(DVec3::new(0.0, 0.0, 0.9), 1.0, 4);
    let mut hollow = common::icosphere(DVec3::new(0.0, 0.0, 0.9), 0.8, 4);
    for (triangle, normals) in hollow.triangles.iter_mut().zip(&mut hollow.corner_normals) {
        triangle.swap(1, 2);
        normals.swap(1, 2);
        *normals = normals.map(|n| -n);
    }
    let mut block = common::cuboid(DVec3::new(-1.2, -1.2, -0.6), DVec3::new(1.2, 1.2, 0.1));
    block.corner_normals = raster::corner_normals(&block, 0.5);
    let small = common::icosphere(DVec3::new(0.9, -1.0, 0.35), 0.25, 3);
    let mut mesh = common::colored(ball, [0.85, 0.45, 0.25]);
    for (part, colour) in [
        (hollow, [0.9, 0.8, 0.4]),
        (block, [0.55, 0.65, 0.75]),
        (small, [0.35, 0.65, 0.4]),
    ] {
        mesh = common::merge(mesh, &common::colored(part, colour));
    }
    mesh
}

/// Three plates that cut each other.
fn plates() -> Mesh {
    let mut mesh = Mesh::default();
    for (k, colour) in [[0.85, 0.3, 0.25], [0.3, 0.7, 0.35], [0.3, 0.45, 0.9]]
        .into_iter()
        .enumerate()
    {
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
        mesh = common::merge(mesh, &common::colored(plate, colour));
    }
    mesh
}

fn smooth() -> RenderOptions {
    let mut options = RenderOptions::default();
    options.anti_aliasing = AntiAliasing::Msaa8;
    options
}

fn with_edges(hidden: HiddenEdges) -> RenderOptions {
    let mut options = smooth();
    let mut edges = EdgeOptions::default();
    edges.hidden = hidden;
    options.edges = Some(edges);
    options
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Image {
    let mut image = Image::default();
    let view = camera.view(WIDTH, HEIGHT).unwrap();
    Renderer::default()
        .draw(scene, &view, WIDTH, HEIGHT, options, &mut image)
        .unwrap();
    image
}

fn pictures() -> Vec<(&'static str, Image)> {
    let mesh = subject();
    let scene = Scene::new(&mesh);
    let camera = |view, lens| Camera::standard(&mesh, view, lens, ASPECT).unwrap();
    let iso = camera(StandardView::Iso, Lens::DEFAULT);
    let mut pictures = vec![
        (
            "perspective",
            draw(
                &scene,
                &camera(StandardView::Iso, Lens::Perspective { fov_y: 1.1 }),
                &smooth(),
            ),
        ),
        (
            "orthographic",
            draw(
                &scene,
                &camera(StandardView::Iso, Lens::Orthographic { height: 1.0 }),
                &smooth(),
            ),
        ),
        (
            "cabinet",
            draw(
                &scene,
                &camera(
                    StandardView::Front,
                    Lens::Oblique {
                        height: 1.0,
                        ratio: 0.5,
                        angle: 0.7,
                    },
                ),
                &smooth(),
            ),
        ),
        ("aliased", draw(&scene, &iso, &RenderOptions::default())),
        ("multisampled", draw(&scene, &iso, &smooth())),
        ("edges", draw(&scene, &iso, &with_edges(HiddenEdges::Omit))),
        (
            "hidden-edges",
            draw(&scene, &iso, &with_edges(HiddenEdges::Dash)),
        ),
    ];
    // Close by: clipped at the near plane and beyond the sides.
    let inside = Camera {
        eye: DVec3::new(0.3, -0.45, 1.0),
        target: DVec3::new(0.0, 0.3, 0.7),
        up: DVec3::Z,
        lens: Lens::Perspective { fov_y: 1.8 },
        near: 0.05,
        far: 10.0,
    };
    pictures.push(("inside", draw(&scene, &inside, &smooth())));
    let coarse = common::icosphere(DVec3::ZERO, 1.0, 1);
    let ball = Camera::standard(&coarse, StandardView::Iso, Lens::DEFAULT, ASPECT).unwrap();
    let coarse = Scene::new(&coarse);
    for (name, interpolation) in [
        ("flat", Interpolation::Flat),
        ("gouraud", Interpolation::Gouraud),
        ("phong", Interpolation::Phong),
    ] {
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
        pictures.push((name, draw(&coarse, &ball, &options)));
    }
    let mut wire = smooth();
    let mut edges = EdgeOptions::default();
    edges.wireframe = true;
    edges.points = true;
    edges.width = 0.7;
    wire.edges = Some(edges);
    pictures.push(("wireframe", draw(&coarse, &ball, &wire)));
    let cut = SectionPlane {
        normal: DVec3::NEG_Y,
        point: DVec3::new(0.0, -0.2, 0.0),
    };
    let section = Scene::with_sections(&mesh, &[cut]).unwrap();
    pictures.push((
        "section",
        draw(&section, &iso, &with_edges(HiddenEdges::Omit)),
    ));
    let mut presentation = with_edges(HiddenEdges::Omit);
    presentation.ground_shadow = true;
    presentation.ambient_occlusion = true;
    presentation.triad = true;
    pictures.push(("presentation", draw(&scene, &iso, &presentation)));

    let view = iso.view(WIDTH, HEIGHT).unwrap();
    let mut renderer = Renderer::default();
    renderer
        .draw(
            &scene,
            &view,
            WIDTH,
            HEIGHT,
            &RenderOptions::default(),
            &mut Image::default(),
        )
        .unwrap();
    pictures.extend([
        ("depth", depth_image(&renderer.depth_buffer())),
        (
            "normals",
            normal_image(&renderer.normal_buffer(&scene, &view)),
        ),
        ("surfaces", id_image(&renderer.surface_buffer(&scene))),
        ("triangles", id_image(&renderer.triangle_buffer())),
        (
            "occlusion",
            occlusion_image(&renderer.ambient_occlusion(&scene, &view)),
        ),
    ]);

    let plates = plates();
    let camera = Camera::standard(&plates, StandardView::Iso, Lens::DEFAULT, ASPECT).unwrap();
    let view = camera.view(WIDTH, HEIGHT).unwrap();
    let mut options = RenderOptions::default();
    options.cull_back_faces = false;
    options.two_sided = true;
    let mut depth = DepthBuffer::new((WIDTH * HEIGHT) as usize);
    let painted = render_reference(&plates, &view, WIDTH, HEIGHT, &options, &mut Painter).unwrap();
    let right = render_reference(&plates, &view, WIDTH, HEIGHT, &options, &mut depth).unwrap();
    pictures.extend([("painter", painted), ("depth-buffer", right)]);
    pictures
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0u32, |word, b| word << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for k in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= chunk.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}

/// Keeps the pictures, and for the crate's page as link definitions.
fn bless(pictures: &[(&str, Image)]) {
    let mut links = String::new();
    for (name, image) in pictures {
        let file = image.to_png().unwrap();
        std::fs::write(path(name).with_extension("png"), &file).unwrap();
        if !["wireframe", "edges", "occlusion"].contains(name) {
            let _ = writeln!(links, "[{name}]: data:image/png;base64,{}", base64(&file));
        }
    }
    std::fs::write(path("pictures.md"), links).unwrap();
}

#[test]
fn pictures_are_as_they_were() {
    let pictures = pictures();
    if std::env::var_os("STEREOTOMY_BLESS").is_some() {
        bless(&pictures);
    }
    for (name, image) in &pictures {
        let file = std::fs::File::open(path(name).with_extension("png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file))
            .read_info()
            .unwrap();
        let mut kept = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut kept).unwrap();
        let drawn = image.pixels.as_flattened();
        assert_eq!(drawn.len(), kept.len(), "{name}");
        // The standard library's powers may differ in the last bit from one
        // platform to another.
        let worst = drawn.iter().zip(&kept).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{name} differs by {worst:?} of 255");
    }
}
