//! Depth against exact arithmetic.

use crate::common;
use csg::Mesh;
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use raster::{Camera, Image, Lens, Prepared, RenderOptions, Renderer, StandardView, View};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

/// Draws a mesh and compares every pixel's depth with the depth of its
/// triangle's plane there, in units of 2^-24. Returns the worst, the steepest
/// change in a pixel that occurs, and the number of pixels.
fn worst(mesh: &Mesh, view: &View) -> (f64, f64, usize) {
    let mut renderer = Renderer::default();
    let mut options = RenderOptions::default();
    options.cull_back_faces = false;
    let scene = Prepared::new(mesh);
    renderer
        .draw(&scene, view, WIDTH, HEIGHT, &options, &mut Image::default())
        .unwrap();
    let depth = renderer.reversed_depth_buffer();
    let ids = renderer.triangle_buffer();
    let planes = common::reversed_depth_planes(mesh, view, [WIDTH, HEIGHT]);
    let (mut worst, mut steepest, mut count) = (0.0f64, 0.0f64, 0);
    for (k, id) in ids.values.iter().enumerate() {
        let Some(id) = *id else { continue };
        let plane = planes[id as usize];
        let pixel = [k as u32 % WIDTH, k as u32 / WIDTH];
        let found = f64::from(depth.values[k]);
        let bounds = common::depth_bounds(mesh, view, [WIDTH, HEIGHT], id, plane);
        let units = common::depth_error(found, plane, bounds, pixel);
        worst = worst.max(units);
        let slope = plane.truncate().length();
        steepest = steepest.max(slope);
        count += 1;
    }
    (worst, steepest, count)
}

/// Near and far planes close around the model, so that depth takes up its
/// whole range and faces are steep.
#[test]
fn depth_is_within_two_units_of_24_bits() {
    let ball = common::icosphere(DVec3::ZERO, 1.0, 5);
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    for lens in [
        Lens::Perspective { fov_y: 0.9 },
        Lens::Perspective { fov_y: 2.0 },
        Lens::Orthographic { height: 1.0 },
        Lens::Oblique {
            height: 1.0,
            ratio: 0.5,
            angle: 0.7,
        },
    ] {
        let camera = Camera::standard(&ball, StandardView::Iso, lens, aspect).unwrap();
        let (units, steepest, count) = worst(&ball, &camera.view(WIDTH, HEIGHT).unwrap());
        println!("{lens:?}: {units:.2} units, {steepest:.1e} a pixel, {count} pixels");
        assert!(count > 20_000);
        assert!(steepest > 0.01, "{steepest}");
        assert!(units <= 2.0, "{lens:?}: {units}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Large triangles at any attitude, with corners anywhere around the view
    /// volume.
    #[test]
    fn depth_of_large_triangles_is_exact(
        corners in proptest::array::uniform3(proptest::array::uniform3(-300i32..300)),
    ) {
        let at = |c: [i32; 3]| DVec3::from_array(c.map(|v| f64::from(v) / 64.0));
        // Vertices at both ends keep the scene's centre at the origin.
        let mut positions = vec![DVec3::splat(-8.0), DVec3::splat(8.0)];
        positions.extend(corners.map(at));
        let mesh = Mesh::new(positions, vec![[2, 3, 4]]);
        let camera = Camera {
            eye: DVec3::new(2.0, -3.0, 1.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            lens: Lens::Perspective { fov_y: 1.0 },
            near: 0.5,
            far: 12.0,
        };
        let view = camera.view(WIDTH, HEIGHT).unwrap();
        let [a, b, c] = corners.map(at);
        let normal = (b - a).cross(c - a);
        // Seen nearly edge-on there is no plane to speak of.
        prop_assume!(normal.dot(camera.eye - a).abs() > 0.05 * normal.length());
        prop_assume!(normal.length() > 0.5);
        let (units, _, _) = worst(&mesh, &view);
        prop_assert!(units <= 2.0, "{}", units);
    }
}

/// The plane of [`common::reversed_depth_planes`] against a projection of
/// points in it.
#[test]
fn the_exact_plane_is_right() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 1);
    let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 1.0).unwrap();
    let view = camera.view(100, 100).unwrap();
    let viewport = raster::Viewport::of_image(100, 100);
    let planes = common::reversed_depth_planes(&mesh, &view, [100, 100]);
    for (id, plane) in planes.into_iter().enumerate() {
        let [a, b, c] = mesh.corners(id);
        let middle = DMat3::from_cols(a, b, c) * DVec3::new(0.2, 0.3, 0.5);
        let seen = viewport.project(&view, middle).unwrap();
        let depth = plane.dot(DVec3::new(seen.x, seen.y, 1.0));
        assert!((depth - (1.0 - seen.z)).abs() < 1e-6);
    }
}
