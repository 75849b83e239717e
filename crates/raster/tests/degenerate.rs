//! Input that makes no sense: no panic, and no stray pixel.

use crate::common;
use csg::Mesh;
use glam::{DMat4, DVec3};
use raster::{
    AntiAliasing, Camera, Image, Lens, MAX_SIZE, Prepared, RasterError, RenderOptions, Renderer,
    StandardView, View, render,
};

fn view(width: u32, height: u32) -> View {
    let camera = Camera {
        eye: DVec3::new(3.0, -2.0, 1.5),
        target: DVec3::ZERO,
        up: DVec3::Z,
        lens: Lens::DEFAULT,
        near: 0.5,
        far: 9.0,
    };
    camera.view(width, height).unwrap()
}

fn covered(mesh: &Mesh) -> usize {
    let image = render(mesh, &view(64, 48), 64, 48, &RenderOptions::default()).unwrap();
    image.pixels.iter().filter(|p| p[3] != 0).count()
}

#[test]
fn triangles_without_sense_draw_nothing() {
    let ok = [DVec3::ZERO, DVec3::X, DVec3::Y];
    for bad in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        1e300,
        -1e300,
        1e30,
    ] {
        for axis in 0..3 {
            let mut positions = ok.to_vec();
            positions[0][axis] = bad;
            for triangle in [[0, 1, 2], [0, 2, 1], [1, 2, 0]] {
                let mesh = Mesh::new(positions.clone(), vec![triangle]);
                // (Beside a corner so far away the two others are one point.)
                assert_eq!(covered(&mesh), 0, "{bad} {axis}");
            }
        }
    }
    for triangles in [
        vec![[0, 0, 1]],
        vec![[1, 1, 1]],
        vec![[0, 1, 3]],
        vec![[u32::MAX; 3]],
    ] {
        assert_eq!(
            covered(&Mesh::new(ok.to_vec(), triangles.clone())),
            0,
            "{triangles:?}"
        );
    }
    assert_eq!(covered(&Mesh::new(vec![], vec![[0, 1, 2]])), 0);
    assert_eq!(covered(&Mesh::default()), 0);
    let denormal = Mesh::new(ok.map(|p| p * 5e-324).to_vec(), vec![[0, 1, 2], [0, 2, 1]]);
    assert_eq!(covered(&denormal), 0);
}

/// Bad triangles among good ones change nothing.
#[test]
fn bad_triangles_leave_the_others_alone() {
    let good = common::icosphere(DVec3::ZERO, 0.5, 2);
    let expected = render(&good, &view(64, 48), 64, 48, &RenderOptions::default()).unwrap();
    let mut mesh = good.clone();
    let base = mesh.positions.len() as u32;
    mesh.positions.extend([
        DVec3::NAN,
        DVec3::splat(f64::INFINITY),
        DVec3::new(0.0, f64::NEG_INFINITY, 0.0),
    ]);
    let mut triangles = Vec::new();
    let mut normals = Vec::new();
    for (k, triangle) in good.triangles.iter().enumerate() {
        triangles.extend([
            *triangle,
            [base, triangle[0], triangle[1]],
            [triangle[0], base + 1, base + 2],
            [triangle[0], triangle[0], triangle[1]],
            [triangle[0], u32::MAX, triangle[1]],
        ]);
        normals.extend([good.corner_normals[k]; 5]);
    }
    mesh.triangles = triangles;
    mesh.corner_normals = normals;
    let image = render(&mesh, &view(64, 48), 64, 48, &RenderOptions::default()).unwrap();
    assert!(image == expected);
}

/// A triangle far larger than the view volume covers all of it.
#[test]
fn a_triangle_around_the_view_volume_fills_the_picture() {
    for size in [1e2, 1e4, 1e6, 1e9, 1e15, 1e30] {
        let view = view(64, 48);
        let away = (DVec3::ZERO - DVec3::new(3.0, -2.0, 1.5)).normalize();
        let right = away.cross(DVec3::Z).normalize();
        let up = right.cross(away);
        let corner = |u: f64, v: f64| (right * u + up * v) * size;
        let mesh = Mesh::new(
            vec![corner(-3.0, -1.0), corner(3.0, -1.0), corner(0.0, 3.0)],
            vec![[0, 1, 2]],
        );
        let image = render(&mesh, &view, 64, 48, &RenderOptions::default()).unwrap();
        let covered = image.pixels.iter().filter(|p| p[3] == 255).count();
        // The mesh is kept in single precision relative to its own size, so
        // beyond that its plane may miss the view volume; there must not be
        // part of a picture.
        if size <= 1e6 {
            assert_eq!(covered, 64 * 48, "{size}");
        } else {
            assert!(covered == 64 * 48 || covered == 0, "{size}: {covered}");
        }
    }
}

#[test]
fn sizes_from_nothing_to_the_largest() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 2);
    for (width, height) in [
        (0, 0),
        (0, 7),
        (7, 0),
        (1, 1),
        (1, 9),
        (9, 1),
        (65, 63),
        (3, 129),
    ] {
        for anti_aliasing in [
            AntiAliasing::None,
            AntiAliasing::Msaa4,
            AntiAliasing::Supersample(3),
        ] {
            let mut options = RenderOptions::default();
            options.anti_aliasing = anti_aliasing;
            let view = view(width, height);
            let image = render(&mesh, &view, width, height, &options).unwrap();
            assert_eq!((image.width, image.height), (width, height));
            assert_eq!(image.pixels.len(), width as usize * height as usize);
            let drawn = image.pixels.iter().filter(|p| p[3] > 0).count();
            assert_eq!(drawn > 0, width * height > 0, "{width}x{height}");
            assert_eq!(image.to_png().is_err(), width * height == 0);
        }
    }
    let too_large = render(
        &mesh,
        &view(9, 9),
        MAX_SIZE + 1,
        1,
        &RenderOptions::default(),
    );
    assert!(matches!(too_large, Err(RasterError::SizeTooLarge { .. })));
    // A strip of the largest width, and one of the largest height: what they
    // show is the middle of a larger picture.
    for (width, height) in [(MAX_SIZE, 8), (8, MAX_SIZE)] {
        let mut image = Image::default();
        let mut renderer = Renderer::default();
        let options = RenderOptions::default();
        renderer
            .draw(
                &Prepared::new(&mesh),
                &view(width, height),
                width,
                height,
                &options,
                &mut image,
            )
            .unwrap();
        assert!(image.pixels.iter().any(|p| p[3] > 0));
    }
}

/// The largest square: the visibility buffer is made only where something is
/// drawn.
#[test]
fn the_largest_picture_is_exact_at_its_far_corner() {
    let size = f64::from(MAX_SIZE);
    let camera = Camera {
        eye: DVec3::new(0.0, 0.0, 5.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        lens: Lens::Orthographic { height: size },
        near: 1.0,
        far: 9.0,
    };
    // Ten by ten pixels at the bottom right corner, and ten at the top left.
    let half = size / 2.0;
    let square = |x: f64, y: f64| {
        [
            DVec3::new(x, y, 0.0),
            DVec3::new(x + 10.0, y, 0.0),
            DVec3::new(x + 10.0, y + 10.0, 0.0),
            DVec3::new(x, y + 10.0, 0.0),
        ]
    };
    let mut positions = square(half - 10.0, -half).to_vec();
    positions.extend(square(-half, half - 10.0));
    let mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    let view = camera.view(MAX_SIZE, MAX_SIZE).unwrap();
    let mut image = Image::default();
    let stats = Renderer::default()
        .draw(
            &Prepared::new(&mesh),
            &view,
            MAX_SIZE,
            MAX_SIZE,
            &RenderOptions::default(),
            &mut image,
        )
        .unwrap();
    assert_eq!(stats.pixels_shaded, 200);
    let last = MAX_SIZE - 1;
    for (x, y, inside) in [
        (last, last, true),
        (last - 9, last - 9, true),
        (last - 10, last, false),
        (0, 0, true),
        (9, 9, true),
        (10, 0, false),
    ] {
        assert_eq!(image.get(x, y).unwrap()[3] == 255, inside, "{x} {y}");
    }
}

#[test]
fn views_without_sense_are_refused() {
    let camera = Camera {
        eye: DVec3::ONE,
        target: DVec3::ZERO,
        up: DVec3::Z,
        lens: Lens::DEFAULT,
        near: 0.1,
        far: 10.0,
    };
    for bad in [
        Camera {
            target: camera.eye,
            ..camera
        },
        Camera {
            up: camera.eye,
            ..camera
        },
        Camera {
            up: DVec3::ZERO,
            ..camera
        },
        Camera {
            near: 10.0,
            ..camera
        },
        Camera {
            near: 0.0,
            ..camera
        },
        Camera {
            eye: DVec3::NAN,
            ..camera
        },
        Camera {
            lens: Lens::Perspective { fov_y: 0.0 },
            ..camera
        },
        Camera {
            lens: Lens::Orthographic { height: 0.0 },
            ..camera
        },
    ] {
        assert!(bad.view(9, 9).is_err(), "{bad:?}");
    }
    assert!(View::new(DMat4::ZERO, DMat4::IDENTITY).is_err());
    let nothing = Camera::standard(&Mesh::default(), StandardView::Iso, Lens::DEFAULT, 1.0);
    assert!(matches!(nothing, Err(RasterError::NothingToFrame)));
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 0);
    assert!(Camera::framing(&mesh, DVec3::Z, DVec3::Z, Lens::DEFAULT, 1.0).is_err());
    // One point is framed as if it had a size.
    let point = Mesh::new(vec![DVec3::new(5.0, 6.0, 7.0)], vec![]);
    let camera = Camera::standard(&point, StandardView::Top, Lens::DEFAULT, 1.0).unwrap();
    assert!(camera.view(9, 9).is_ok());
}
