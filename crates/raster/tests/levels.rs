//! One scene, every level of instruction set, every number of threads, every
//! order of triangles: one picture.

use crate::common;
use csg::Mesh;
use glam::{DVec3, Vec3};
use raster::{
    AntiAliasing, Buffer, Camera, EdgeOptions, HiddenEdges, Image, Interpolation, Lens, Level,
    Light, Prepared, RenderOptions, Renderer, SectionPlane, StandardView, View,
};

/// Spheres that hide and cut each other, in several colours.
fn scene() -> Mesh {
    let mut mesh = common::colored(common::icosphere(DVec3::ZERO, 1.0, 3), [0.8, 0.3, 0.2]);
    for k in 0..12 {
        let angle = f64::from(k) * 1.7;
        let centre = DVec3::new(angle.cos(), angle.sin(), (angle * 0.6).sin());
        let colour = [0.2 + 0.05 * k as f32, 0.5, 0.9 - 0.05 * k as f32];
        let sphere = common::icosphere(centre, 0.2 + 0.05 * f64::from(k % 4), 2 + k % 3);
        mesh = common::merge(mesh, &common::colored(sphere, colour));
    }
    mesh
}

fn view(mesh: &Mesh, width: u32, height: u32) -> View {
    let aspect = f64::from(width) / f64::from(height);
    let camera = Camera::standard(mesh, StandardView::Iso, Lens::DEFAULT, aspect).unwrap();
    camera.view(width, height).unwrap()
}

fn modes() -> Vec<RenderOptions> {
    let mut modes = Vec::new();
    for interpolation in [
        Interpolation::Flat,
        Interpolation::Gouraud,
        Interpolation::Phong,
    ] {
        for anti_aliasing in [
            AntiAliasing::None,
            AntiAliasing::Msaa4,
            AntiAliasing::Msaa8,
            AntiAliasing::Supersample(2),
        ] {
            let mut options = RenderOptions::default();
            options.interpolation = interpolation;
            options.anti_aliasing = anti_aliasing;
            options.two_sided = true;
            options.cull_back_faces = false;
            options.lights.push(Light::Point {
                position: DVec3::new(2.0, -3.0, 1.0),
                intensity: Vec3::new(0.4, 0.3, 0.2),
            });
            modes.push(options);
        }
    }
    modes
}

fn draw(level: Level, mesh: &Mesh, options: &RenderOptions) -> Image {
    let mut image = Image::default();
    Renderer::with_level(level)
        .draw(
            &Prepared::new(mesh),
            &view(mesh, 203, 149),
            203,
            149,
            options,
            &mut image,
        )
        .unwrap();
    image
}

#[test]
fn every_level_draws_the_same_bytes() {
    let mesh = scene();
    for options in modes() {
        let expected = draw(Level::PORTABLE, &mesh, &options);
        let covered = expected.pixels.iter().filter(|p| p[3] == 255).count();
        assert!(covered > 5_000, "{covered}");
        for &level in Level::all() {
            let image = draw(level, &mesh, &options);
            assert!(image == expected, "{} {options:?}", level.name());
        }
    }
}

#[test]
fn any_number_of_threads_draws_the_same_bytes() {
    let mesh = scene();
    for options in modes().into_iter().step_by(3) {
        let expected = draw(Level::best(), &mesh, &options);
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let image = pool.install(|| draw(Level::best(), &mesh, &options));
            assert!(image == expected, "{threads} threads");
        }
    }
}

/// A picture with its buffers: depth, normals, surfaces, and openness.
#[derive(PartialEq)]
struct Outputs {
    image: Image,
    depth: Buffer<f32>,
    normals: Buffer<Vec3>,
    surfaces: Buffer<Option<u32>>,
    open: Buffer<f32>,
}

fn outputs(
    level: Level,
    mesh: &Mesh,
    sections: &[SectionPlane],
    view: &View,
    options: &RenderOptions,
) -> Outputs {
    let scene = Prepared::with_sections(mesh, sections).unwrap();
    let mut renderer = Renderer::with_level(level);
    let mut image = Image::default();
    renderer
        .draw(&scene, view, 203, 149, options, &mut image)
        .unwrap();
    Outputs {
        image,
        depth: renderer.depth_buffer(),
        normals: renderer.normal_buffer(&scene, view),
        surfaces: renderer.surface_buffer(&scene),
        open: renderer.ambient_occlusion(&scene, view),
    }
}

/// What is drawn over pictures, capped sections, and triangles that are
/// clipped: every output at every level and number of threads.
#[test]
fn every_look_is_the_same_at_every_level_on_any_threads() {
    let mesh = scene();
    let outside = view(&mesh, 203, 149);
    let inside = Camera {
        eye: DVec3::new(0.3, 0.2, 0.1),
        target: DVec3::new(1.0, 0.4, -0.2),
        up: DVec3::Z,
        lens: Lens::Perspective { fov_y: 1.5 },
        near: 1e-3,
        far: 10.0,
    };
    let inside = inside.view(203, 149).unwrap();
    let cut = [DVec3::NEG_Y, DVec3::new(1.0, 0.3, 0.8)].map(|normal| SectionPlane {
        normal,
        point: DVec3::splat(0.1),
    });
    let mut edges = EdgeOptions::default();
    edges.hidden = HiddenEdges::Dash;
    edges.points = true;
    let mut wireframe = EdgeOptions::default();
    wireframe.wireframe = true;
    let mut looks = vec![RenderOptions::default(); 4];
    looks[0].edges = Some(edges);
    looks[0].triad = true;
    looks[1].edges = Some(wireframe);
    looks[1].anti_aliasing = AntiAliasing::Msaa8;
    looks[2].ambient_occlusion = true;
    looks[2].ground_shadow = true;
    looks[3].anti_aliasing = AntiAliasing::Msaa4;
    looks[3].interpolation = Interpolation::Flat;
    let pools = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap()
    });
    for (sections, view) in [(&cut[..0], &outside), (&cut[..], &outside), (&[], &inside)] {
        for options in &looks {
            let draw = |level| outputs(level, &mesh, sections, view, options);
            let expected = pools[0].install(|| draw(Level::PORTABLE));
            let covered = expected.depth.values.iter().filter(|z| **z < 1.0).count();
            assert!(covered > 3_000, "{covered}");
            for &level in Level::all() {
                for pool in &pools {
                    let same = pool.install(|| draw(level)) == expected;
                    let threads = pool.current_num_threads();
                    assert!(same, "{} on {threads} threads: {options:?}", level.name());
                }
            }
        }
    }
}

/// A renderer that keeps samples from its second frame on draws what its first
/// one shows, also where it has drawn something else between.
#[test]
fn every_frame_of_a_renderer_is_the_same() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 7);
    let (prepared, other) = (Prepared::new(&mesh), scene());
    let (view, other_view) = (view(&mesh, 203, 149), view(&other, 203, 149));
    let other = Prepared::new(&other);
    for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4, AntiAliasing::Msaa8] {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let mut renderer = Renderer::default();
        let mut draw = |scene: &Prepared, view: &View| {
            let mut image = Image::default();
            renderer
                .draw(scene, view, 203, 149, &options, &mut image)
                .unwrap();
            (image, renderer.depth_buffer())
        };
        let first = draw(&prepared, &view);
        assert!(draw(&prepared, &view) == first, "{anti_aliasing:?}");
        draw(&other, &other_view);
        assert!(draw(&prepared, &view) == first, "{anti_aliasing:?}");
    }
}

/// Where no two triangles have equal depths, their order does not matter.
#[test]
fn any_order_of_triangles_draws_the_same_bytes() {
    let mesh = scene();
    let options = RenderOptions::default();
    let expected = draw(Level::best(), &mesh, &options);
    let mut shuffled = mesh.clone();
    let count = mesh.triangles.len();
    for (k, slot) in (0..count).map(|k| (k, k * 1_009 % count)) {
        shuffled.triangles[slot] = mesh.triangles[k];
        shuffled.triangle_surfaces[slot] = mesh.triangle_surfaces[k];
        shuffled.corner_normals[slot] = mesh.corner_normals[k];
    }
    let image = draw(Level::best(), &shuffled, &options);
    let different = image
        .pixels
        .iter()
        .zip(&expected.pixels)
        .filter(|(a, b)| a != b)
        .count();
    assert_eq!(different, 0);
}

#[test]
fn equal_depths_show_what_was_drawn_first() {
    let red = common::colored(common::cuboid(DVec3::ZERO, DVec3::ONE), [1.0, 0.0, 0.0]);
    let blue = common::colored(common::cuboid(DVec3::ZERO, DVec3::ONE), [0.0, 0.0, 1.0]);
    for (mesh, channel) in [
        (common::merge(red.clone(), &blue), 0),
        (common::merge(blue, &red), 2),
    ] {
        let image = draw(Level::best(), &mesh, &RenderOptions::default());
        for pixel in image.pixels.iter().filter(|p| p[3] > 0) {
            assert!(pixel[channel] > pixel[2 - channel], "{pixel:?}");
        }
    }
}
