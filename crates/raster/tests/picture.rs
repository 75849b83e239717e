//! Whole pictures against what geometry says they show.

use crate::common;
use glam::{DVec3, Vec3};
use raster::{Camera, Lens, Light, RenderOptions, StandardView, render};

fn lit_from_the_viewer() -> RenderOptions {
    let mut options = RenderOptions::default();
    options.lights = vec![Light::Head {
        intensity: Vec3::ONE,
    }];
    options
}

/// A sphere's outline under an orthographic projection is a circle: as many
/// pixels as its area says.
#[test]
fn sphere_covers_its_disc() {
    let mesh = common::icosphere(DVec3::new(3.0, -2.0, 1.0), 2.0, 4);
    let lens = Lens::Orthographic { height: 1.0 };
    let camera = Camera::standard(&mesh, StandardView::Iso, lens, 1.0).unwrap();
    let view = camera.view(200, 200).unwrap();
    let image = render(&mesh, &view, 200, 200, &lit_from_the_viewer()).unwrap();
    let covered = image.pixels.iter().filter(|p| p[3] == 255).count() as f64;
    let disc = std::f64::consts::PI * (100.0_f64 * 0.9).powi(2);
    assert!((covered / disc - 1.0).abs() < 0.005, "{covered} of {disc}");
    // Brightest in the middle, where the normal points at the viewer.
    let centre = image.get(100, 100).unwrap();
    assert!(
        image
            .pixels
            .iter()
            .all(|p| p[0] <= centre[0] && p[3] % 255 == 0)
    );
}

/// A cube seen from the front is a square of one colour.
#[test]
fn cube_from_the_front_is_a_flat_square() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let lens = Lens::Orthographic { height: 1.0 };
    let camera = Camera::standard(&mesh, StandardView::Front, lens, 1.0).unwrap();
    let image = render(
        &mesh,
        &camera.view(100, 100).unwrap(),
        100,
        100,
        &lit_from_the_viewer(),
    )
    .unwrap();
    let colour = image.get(50, 50).unwrap();
    for y in 0..100 {
        for x in 0..100 {
            let inside = (5..95).contains(&x) && (5..95).contains(&y);
            let expected = if inside { colour } else { [0; 4] };
            assert_eq!(image.get(x, y), Some(expected), "{x}, {y}");
        }
    }
}

/// The frame is as tight as its margin says, for every view and lens.
#[test]
fn framing_touches_the_margin() {
    let mesh = common::icosphere(DVec3::new(-7.0, 0.0, 4.0), 3.0, 3);
    for view in StandardView::ALL {
        for lens in [
            Lens::DEFAULT,
            Lens::Orthographic { height: 1.0 },
            Lens::Oblique {
                height: 1.0,
                ratio: 0.5,
                angle: 0.7,
            },
        ] {
            let camera = Camera::standard(&mesh, view, lens, 1.5).unwrap();
            let view = camera.view(300, 200).unwrap();
            let reach = mesh.positions.iter().fold(DVec3::ZERO, |reach, p| {
                reach.max(view.world_to_clip().project_point3(*p).abs())
            });
            assert!(
                reach.x.max(reach.y) > 0.89 && reach.x.max(reach.y) < 0.9001,
                "{reach}"
            );
            assert!(reach.z < 1.0, "{reach}");
        }
    }
}

#[test]
fn png_reads_back() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 1.5).unwrap();
    let image = render(
        &mesh,
        &camera.view(90, 60).unwrap(),
        90,
        60,
        &RenderOptions::default(),
    )
    .unwrap();
    let file = image.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (90, 60));
    assert_eq!(bytes, image.pixels.as_flattened());
}
