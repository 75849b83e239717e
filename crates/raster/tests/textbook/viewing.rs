//! From the world to the window: cameras, frames, viewports, view references.

use super::{close, common, rows};
use glam::{DMat3, DMat4, DVec2, DVec3, Vec3};
use raster::projection;
use raster::transform;
use raster::view_reference::{ProjectionType, ViewReference};
use raster::viewport::{depth_in_range, integer_depth};
use raster::{
    Camera, Frame, Image, Lens, Prepared, RenderOptions, Renderer, View, Viewport, YAxis, look_at,
    render,
};

/// A = T R of the viewing transform: C to the origin, N to z, U to x, V to y;
/// left-handed.
#[test]
fn viewing_from_c_along_n() {
    let (c, d, up) = (
        DVec3::new(1.0, -4.0, 2.0),
        DVec3::new(0.0, 1.0, 0.5),
        DVec3::Z,
    );
    let n = (d - c).normalize();
    let v = (up - n * up.dot(n)).normalize();
    let u = n.cross(v);
    let frame = Frame::left_handed(d - c, up);
    assert!(frame.n.abs_diff_eq(n, 1e-12) && frame.v.abs_diff_eq(v, 1e-12));
    assert!(frame.u.abs_diff_eq(u, 1e-12), "{} {u}", frame.u);
    let a = frame.world_to_eye(c);
    let t = transform::translation(-c);
    let r = DMat4::from_mat3(DMat3::from_cols(u, v, n).transpose());
    assert!(close(a, r * t));
    for (from, to) in [
        (c, DVec3::ZERO),
        (c + n, DVec3::Z),
        (c + u, DVec3::X),
        (c + v, DVec3::Y),
    ] {
        assert!(a.transform_point3(from).abs_diff_eq(to, 1e-12));
    }
}

/// The same picture through a left-handed frame.
#[test]
fn left_handed_frames_give_the_same_picture() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 2);
    let (eye, target) = (DVec3::new(3.0, -2.0, 1.5), DVec3::ZERO);
    let lens = projection::perspective(0.8, 1.0, 1.0, 9.0);
    let right = View::new(look_at(eye, target, DVec3::Z), lens).unwrap();
    let frame = Frame::left_handed(target - eye, DVec3::Z);
    let left = View::new(frame.world_to_eye(eye), projection::left_handed(lens)).unwrap();
    let [a, b] = [right, left].map(|view| {
        let mut options = RenderOptions::default();
        options
            .lights
            .retain(|light| !matches!(light, raster::Light::Camera { .. }));
        options.lights.push(raster::Light::Head {
            intensity: Vec3::ONE,
        });
        render(&mesh, &view, 80, 80, &options).unwrap()
    });
    assert_eq!(a, b);
    // Depth grows with z in a left-handed frame.
    let near = projection::left_handed(lens).project_point3(DVec3::new(0.0, 0.0, 1.0));
    assert!((near.z + 1.0).abs() < 1e-12);
}

#[test]
fn look_at_has_the_printed_rows() {
    let (e, t, u) = (
        DVec3::new(3.0, 4.0, 5.0),
        DVec3::new(0.5, 1.0, -1.0),
        DVec3::Y,
    );
    let z = (e - t) / (e - t).length();
    let x = u.cross(z) / u.cross(z).length();
    let y = z.cross(x);
    let printed = rows([
        [x.x, x.y, x.z, -e.dot(x)],
        [y.x, y.y, y.z, -e.dot(y)],
        [z.x, z.y, z.z, -e.dot(z)],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(look_at(e, t, u), printed));
}

#[test]
fn viewport_is_a_matrix() {
    let viewport = Viewport {
        x: 30.0,
        y: 20.0,
        width: 400.0,
        height: 320.0,
        y_axis: YAxis::Up,
    };
    let z_max = f64::from(u32::MAX);
    let printed = rows([
        [200.0, 0.0, 0.0, 200.0 + 30.0],
        [0.0, 160.0, 0.0, 160.0 + 20.0],
        [0.0, 0.0, z_max / 2.0, z_max / 2.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert_eq!(viewport.matrix(z_max), printed);
    for y_axis in [YAxis::Up, YAxis::Down] {
        let viewport = Viewport { y_axis, ..viewport };
        let ndc = DVec3::new(-0.3, 0.6, 0.2);
        let found = viewport.matrix(1.0).transform_point3(ndc);
        assert!(found.abs_diff_eq(viewport.from_ndc(ndc), 1e-12));
    }
    assert_eq!(depth_in_range(-1.0, 2.0, 7.0), 2.0);
    assert_eq!(depth_in_range(1.0, 2.0, 7.0), 7.0);
}

/// Integers up to z_max in a buffer: those of the depths that the planes have.
#[test]
fn depths_are_integers_up_to_z_max() {
    let mesh = common::cuboid(DVec3::new(-0.5, -0.5, -0.5), DVec3::new(0.5, 0.5, 0.5));
    let camera = Camera::looking_at(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.0 })
        .depths(0.5, 4.5);
    let view = camera.view(32, 32).unwrap();
    let mut renderer = Renderer::default();
    let (prepared, options) = (Prepared::new(&mesh), RenderOptions::default());
    renderer
        .draw(&prepared, &view, 32, 32, &options, &mut Image::default())
        .unwrap();
    for bits in [1, 8, 16, 24, 32] {
        let depths = renderer.integer_depth_buffer(bits);
        let z_max = u32::MAX >> (32 - bits);
        // The top at distance 2.5 is in the middle of 0.5..4.5.
        assert_eq!(depths.get(16, 16), Some(integer_depth(0.5, bits)));
        assert_eq!(depths.get(16, 16), Some(z_max.div_ceil(2)));
        assert_eq!(depths.get(0, 0), Some(z_max));
        let file = raster::integer_depth_png(&depths, bits).unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(file));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let wide = bytes.len() / (32 * 32);
        let number = bytes[..wide]
            .iter()
            .fold(0u32, |n, &b| n << 8 | u32::from(b));
        assert_eq!(number, z_max >> bits.saturating_sub(16), "{bits}");
    }
}

/// A camera turned by Euler angles is `look_at` along its -Z, Y upwards.
#[test]
fn cameras_turn_by_euler_angles() {
    let eye = DVec3::new(1.0, 2.0, 3.0);
    let e = transform::Euler {
        heading: 0.7,
        pitch: -0.3,
        roll: 0.2,
    }
    .to_matrix();
    let camera = Camera::turned(eye, e, 5.0);
    let inverse = transform::from_frame(e, eye);
    assert!(close(camera.world_to_eye() * inverse, DMat4::IDENTITY));
    assert!(camera.view(64, 48).is_ok());
}

/// project, then unproject(x, y, z_object): the point with that z in its own
/// coordinates.
#[test]
fn unprojecting_to_a_plane_of_the_object() {
    let model =
        transform::translation(DVec3::new(0.5, -0.2, 0.1)) * transform::rotation(DVec3::X, 0.4);
    for lens in [Lens::DEFAULT, Lens::Orthographic { height: 4.0 }] {
        let camera = Camera::looking_at(DVec3::new(3.0, -5.0, 2.0), DVec3::ZERO)
            .lens(lens)
            .depths(1.0, 20.0);
        let view = camera.view(400, 320).unwrap();
        let viewport = Viewport::of_image(400, 320);
        for local in [DVec3::new(0.3, 0.4, 0.7), DVec3::new(-1.0, 0.2, -0.6)] {
            let at = viewport
                .project(&view, model.transform_point3(local))
                .unwrap();
            let found = viewport
                .unproject_at_z(&view, model, at.truncate(), local.z)
                .unwrap();
            assert!(found.abs_diff_eq(local, 1e-9), "{found} {local}");
        }
    }
    // In the eye's plane, w = 0: seen nowhere.
    let camera = Camera::looking_at(DVec3::Z * 3.0, DVec3::ZERO);
    let view = camera.view(10, 10).unwrap();
    let viewport = Viewport::of_image(10, 10);
    assert_eq!(viewport.project(&view, DVec3::new(1.0, 0.0, 3.0)), None);
}

/// VRP, VPN, VUP, window, PRP and DOP make the picture that a camera makes.
#[test]
fn view_references_make_pictures() {
    let mesh = common::merge(
        common::icosphere(DVec3::ZERO, 0.8, 3),
        &common::cuboid(DVec3::splat(0.1), DVec3::ONE),
    );
    let (direction, up) = (DVec3::new(-1.0, 1.5, -0.8).normalize(), DVec3::Z);
    let draw = |view: &View| render(&mesh, view, 96, 96, &RenderOptions::default()).unwrap();
    for projection in [ProjectionType::Perspective, ProjectionType::Parallel] {
        let reference = ViewReference {
            vrp: DVec3::ZERO,
            vpn: -direction * 2.0,
            vup: up,
            prp: DVec3::new(0.0, 0.0, 6.0),
            window_low: DVec2::splat(-1.6),
            window_high: DVec2::splat(1.6),
            front: 3.0,
            back: -3.0,
            projection,
        };
        assert_eq!(
            reference.direction_of_projection(),
            DVec3::new(0.0, 0.0, -6.0)
        );
        let lens = match projection {
            ProjectionType::Perspective => Lens::Perspective {
                fov_y: 2.0 * (1.6f64 / 6.0).atan(),
            },
            ProjectionType::Parallel => Lens::Orthographic { height: 3.2 },
        };
        let camera = Camera::looking_at(-direction * 6.0, DVec3::ZERO)
            .lens(lens)
            .depths(3.0, 9.0);
        let [a, b] = [reference.view().unwrap(), camera.view(96, 96).unwrap()].map(|v| draw(&v));
        let pairs = a.pixels.iter().zip(&b.pixels);
        let off = pairs
            .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 2))
            .count();
        assert!(off < 4, "{projection:?}: {off}");
    }
}
