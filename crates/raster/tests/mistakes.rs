//! What cannot be drawn is refused by name.

use crate::common;
use glam::{DVec3, Vec3};
use raster::{
    Camera, EdgeOptions, Image, Interpolation, Lens, Light, Prepared, RasterError, RenderOptions,
    Renderer, StandardView, hidden_surface::DepthBuffer, render, render_reference,
};

fn camera() -> Camera {
    Camera {
        eye: DVec3::new(3.0, -3.0, 2.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        lens: Lens::DEFAULT,
        near: 1.0,
        far: 10.0,
    }
}

#[test]
fn every_mistake_of_a_camera_has_its_error() {
    let error = |change: &dyn Fn(&mut Camera)| {
        let mut camera = camera();
        change(&mut camera);
        camera.view(64, 48).unwrap_err()
    };
    assert!(camera().view(64, 48).is_ok());
    for target in [DVec3::new(3.0, -3.0, 2.0), DVec3::NAN] {
        let found = error(&|c| c.target = target);
        assert!(matches!(found, RasterError::EyeAtTarget { .. }), "{found}");
    }
    for up in [DVec3::ZERO, DVec3::new(3.0, -3.0, 2.0), DVec3::INFINITY] {
        let found = error(&|c| c.up = up);
        assert!(matches!(found, RasterError::UpAlongView { .. }), "{found}");
    }
    let parallel = Lens::Orthographic { height: 2.0 };
    for lens in [Lens::DEFAULT, parallel] {
        for (near, far) in [
            (2.0, 2.0),
            (3.0, 2.0),
            (-1.0, 2.0),
            (f64::NAN, 2.0),
            (1.0, f64::NAN),
        ] {
            let found = error(&|c| (c.near, c.far, c.lens) = (near, far, lens));
            assert!(
                matches!(found, RasterError::BadDepthRange { .. }),
                "{near} {far}: {found}"
            );
        }
    }
    let found = error(&|c| c.near = 0.0);
    assert!(
        matches!(found, RasterError::BadDepthRange { .. }),
        "{found}"
    );
    for fov_y in [0.0, -1.0, std::f64::consts::PI, f64::NAN] {
        let found = error(&|c| c.lens = Lens::Perspective { fov_y });
        assert!(
            matches!(found, RasterError::BadFieldOfView { .. }),
            "{found}"
        );
    }
    for height in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let found = error(&|c| c.lens = Lens::Orthographic { height });
        assert!(matches!(found, RasterError::BadWindow { .. }), "{found}");
    }
}

#[test]
fn a_view_for_other_proportions_is_refused() {
    let scene = Prepared::new(&common::cuboid(DVec3::ZERO, DVec3::ONE));
    let view = camera().view(64, 48).unwrap();
    let mut image = Image::default();
    let mut draw = |width, height| {
        let options = RenderOptions::default();
        Renderer::default().draw(&scene, &view, width, height, &options, &mut image)
    };
    for (width, height) in [(64, 48), (128, 96), (127, 96), (33, 25)] {
        assert!(draw(width, height).is_ok(), "{width} {height}");
    }
    for (width, height) in [(64, 64), (48, 64), (128, 100)] {
        let error = draw(width, height).unwrap_err();
        assert!(matches!(error, RasterError::OtherAspect { .. }), "{error}");
    }
}

#[test]
fn lines_of_no_width_are_refused_and_wide_ones_are_drawn() {
    let scene = Prepared::new(&common::cuboid(DVec3::ZERO, DVec3::ONE));
    let view = camera().view(64, 48).unwrap();
    let draw = |width: f64| {
        let mut options = RenderOptions::default();
        let mut edges = EdgeOptions::default();
        edges.width = width;
        options.edges = Some(edges);
        let mut image = Image::default();
        Renderer::default().draw(&scene, &view, 64, 48, &options, &mut image)
    };
    for width in [-1.0, 0.0, f64::NAN, f64::INFINITY, 1e9] {
        let error = draw(width).unwrap_err();
        assert!(matches!(error, RasterError::BadLineWidth { .. }), "{error}");
    }
    for width in [1e-3, 1.0, raster::MAX_LINE_WIDTH] {
        assert!(draw(width).is_ok(), "{width}");
    }
}

/// No direction, no light: with every way of shading, and in the reference.
#[test]
fn light_from_nowhere_gives_none() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let view = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 1.0)
        .unwrap()
        .view(32, 32)
        .unwrap();
    let intensity = Vec3::ONE;
    for towards in [DVec3::ZERO, DVec3::NAN] {
        for light in [
            Light::Directional { towards, intensity },
            Light::Camera { towards, intensity },
        ] {
            for interpolation in [
                Interpolation::Flat,
                Interpolation::Gouraud,
                Interpolation::Phong,
            ] {
                let mut options = RenderOptions::default();
                options.lights = vec![light];
                options.interpolation = interpolation;
                let fast = render(&mesh, &view, 32, 32, &options).unwrap();
                let mut depths = DepthBuffer::new(32 * 32);
                let slow = render_reference(&mesh, &view, 32, 32, &options, &mut depths).unwrap();
                for image in [fast, slow] {
                    let lit = image.pixels.iter().filter(|p| p[..3] != [0; 3]).count();
                    assert_eq!(lit, 0, "{light:?} {interpolation:?}");
                    assert!(image.pixels.iter().any(|p| p[3] == 255));
                }
            }
        }
    }
}
