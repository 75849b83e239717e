//! Scenes of parts: places, materials, lights, and what is seen through.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common;
use csg::{Color, Mesh};
use glam::{DMat4, DQuat, DVec2, DVec3, Vec3};
use raster::{
    AntiAliasing, Camera, Finish, Image, Interpolation, Lens, Light, Material, Part, Prepared,
    RenderOptions, Renderer, Scene, StandardView, Texture, transform::Shear,
};

const SIZE: u32 = 120;

fn options() -> RenderOptions {
    RenderOptions::default().size(SIZE, SIZE)
}

fn camera() -> Camera {
    Camera::looking_at(DVec3::new(4.0, -6.0, 3.0), DVec3::ZERO)
}

/// A camera straight above that sees 2 units: x to the right, y upwards.
fn above() -> Camera {
    Camera::looking_at(DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.0 })
}

fn worst(a: &Image, b: &Image) -> u8 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

fn lit(intensity: f32) -> Light {
    Light::Ambient {
        intensity: Vec3::splat(intensity),
    }
}

/// A square of side 2 at a height, in a plane that rises along x.
fn square(height: f64, slope: f64) -> Mesh {
    let corner = |x: f64, y: f64| DVec3::new(x, y, height + slope * x);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])
}

/// Normals go by the adjugate transposed: a sphere squashed and sheared by a
/// model matrix is the ellipsoid that was made so, with its exact normals; also
/// where the matrix mirrors.
#[test]
fn model_matrices_carry_points_and_normals() {
    for model in [
        DMat4::from_scale(DVec3::new(0.5, 1.0, 2.0)),
        raster::transform::shear(Shear::XByZ, 0.8) * DMat4::from_rotation_x(0.4),
        DMat4::from_scale(DVec3::new(-1.0, 1.5, 0.7)) * DMat4::from_rotation_z(0.3),
    ] {
        let sphere = common::icosphere(DVec3::ZERO, 1.0, 4);
        let image = Scene::new()
            .add(Part::new(sphere.clone()).transformed(model))
            .render(&camera(), &options())
            .unwrap();
        // The gradient of |M^-1 p|^2 is M^-T M^-1 p.
        let inverse = model.inverse();
        let mut made = sphere.clone();
        for p in &mut made.positions {
            *p = model.transform_point3(*p);
        }
        for (triangle, normals) in made.triangles.iter_mut().zip(&mut made.corner_normals) {
            for (v, normal) in triangle.iter().zip(normals.iter_mut()) {
                let local = inverse.transform_point3(made.positions[*v as usize]);
                let gradient = inverse.transpose().transform_vector3(local);
                *normal = gradient.normalize().as_vec3();
            }
            if model.determinant() < 0.0 {
                triangle.swap(1, 2);
                normals.swap(1, 2);
            }
        }
        let truth = Scene::new()
            .add(made)
            .render(&camera(), &options())
            .unwrap();
        assert!(truth.pixels.iter().filter(|p| p[3] > 0).count() > 500);
        assert!(
            worst(&image, &truth) <= 2,
            "{model}: {}",
            worst(&image, &truth)
        );
    }
}

#[test]
fn instances_are_parts_in_several_places() {
    let mesh = Arc::new(common::cuboid(DVec3::splat(-0.3), DVec3::splat(0.3)));
    let places = [DVec3::X, DVec3::NEG_X, DVec3::Z].map(DMat4::from_translation);
    let one = Scene::new().add(Part::new(mesh.clone()).instances(places));
    let many = places.iter().fold(Scene::new(), |scene, &place| {
        scene.add(Part::new(mesh.clone()).transformed(place))
    });
    let [a, b] = [one, many].map(|scene| scene.render(&camera(), &options()).unwrap());
    assert_eq!(a, b);
    let prepared = Scene::new()
        .add(Part::new(mesh.clone()).instances(places))
        .add(mesh)
        .prepare();
    assert_eq!(prepared.triangle_count(), 4 * 12);
    assert_eq!(
        [0, 11, 12, 35, 36].map(|t| prepared.part_of(t)),
        [0, 0, 1, 2, 3]
    );
}

/// r = Ka Or Ar + Kd Or Ir (L N) + Ks Ir (R V)^n for each channel, with the
/// coefficients of the texts' pictures, two lights and colours everywhere.
#[test]
fn materials_are_those_of_the_texts() {
    let color = Color::from_linear([0.6, 0.3, 0.9]);
    let ambient = Vec3::new(0.2, 0.4, 0.1);
    let lights = [
        (DVec3::new(0.3, 0.2, 1.0), Vec3::new(0.5, 0.3, 0.2)),
        (DVec3::new(-0.5, 0.1, 0.8), Vec3::new(0.1, 0.3, 0.25)),
    ];
    for (ka, kd, ks, n) in [(0.5, 0.5, 0.8, 4.0), (0.5, 0.5, 0.6, 10.0)] {
        let scene = lights.iter().fold(
            Scene::new()
                .add(square(0.0, 0.0))
                .color(color)
                .finish(Finish::new(ka, kd, ks, n))
                .light(Light::Ambient { intensity: ambient }),
            |scene, &(towards, intensity)| scene.light(Light::Directional { towards, intensity }),
        );
        for interpolation in [
            Interpolation::Flat,
            Interpolation::Gouraud,
            Interpolation::Phong,
        ] {
            let image = scene
                .render(&above(), &options().interpolation(interpolation))
                .unwrap();
            let mut wanted = Vec3::from(color.rgb) * ambient * ka;
            for (towards, intensity) in lights {
                let l = towards.normalize();
                let reflected = DVec3::new(-l.x, -l.y, l.z);
                let (l_n, r_v) = (l.z as f32, reflected.z as f32);
                wanted += intensity * (Vec3::from(color.rgb) * (kd * l_n) + ks * r_v.powf(n));
            }
            let encoded = Color::from_linear(wanted.to_array()).to_srgb();
            let found = image.get(60, 60).unwrap();
            for (found, wanted) in found.iter().zip(encoded) {
                assert!(
                    (f32::from(*found) - wanted * 255.0).abs() < 0.6,
                    "{found} {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_material_stands_for_all_surfaces_of_its_part_only() {
    let red = Material::of_color(Color::from_linear([1.0, 0.0, 0.0]));
    let mut left = square(0.0, 0.0);
    for p in &mut left.positions {
        p.x = p.x / 2.0 - 0.5;
    }
    let right = Part::new(left.clone()).at(DVec3::X);
    let scene = Scene::new()
        .add(common::colored(left, [0.0, 0.0, 1.0]))
        .material(red)
        .add(right)
        .color(Color::from_linear([0.0, 1.0, 0.0]))
        .light(lit(1.0));
    let image = scene.render(&above(), &options()).unwrap();
    assert_eq!(image.get(30, 60), Some([255, 0, 0, 255]));
    assert_eq!(image.get(90, 60), Some([0, 255, 0, 255]));
}

/// Two sheets that cut each other: on either side the nearer one is in front;
/// a third, opaque one behind both, or none.
#[test]
fn transparency_is_right_where_parts_cut_each_other() {
    let (red, green, blue) = ([0.8, 0.1, 0.1], [0.1, 0.7, 0.2], [0.2, 0.2, 0.9]);
    let sheet = |rgb, alpha| Color::from_linear(rgb).with_alpha(alpha);
    for floor in [true, false] {
        for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4, AntiAliasing::Msaa8] {
            let mut scene = Scene::new().light(lit(1.0));
            if floor {
                scene = scene.add(square(-2.0, 0.0)).color(Color::from_linear(blue));
            }
            // (Whatever comes first.)
            scene = scene
                .add(square(0.0, 0.5))
                .color(sheet(red, 0.6))
                .add(square(0.0, -0.5))
                .color(sheet(green, 0.3));
            let image = scene
                .render(&above(), &options().anti_aliasing(anti_aliasing))
                .unwrap();
            let behind = floor.then_some((blue, 1.0));
            for (x, mut layers) in [
                (30, vec![(green, 0.3), (red, 0.6)]),
                (90, vec![(red, 0.6), (green, 0.3)]),
            ] {
                layers.extend(behind);
                let (found, wanted) = (image.get(x, 47).unwrap(), common::blended(&layers));
                let off = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max();
                assert!(
                    off <= Some(1),
                    "{floor} {anti_aliasing:?} {x}: {found:?} {wanted:?}"
                );
            }
        }
    }
}

/// A ball seen through shows its far wall as well: two layers within its
/// outline, smooth at the outline, and nothing behind an opaque wall.
#[test]
fn hollow_things_have_two_walls() {
    let glass = Color::from_linear([0.5; 3]).with_alpha(0.5);
    let ball = common::icosphere(DVec3::ZERO, 0.8, 4);
    let scene = Scene::new().add(ball.clone()).color(glass).light(lit(1.0));
    let smooth = options().anti_aliasing(AntiAliasing::Msaa8);
    let image = scene.render(&above(), &smooth).unwrap();
    assert_eq!(
        image.get(60, 60),
        Some(common::blended(&[([0.5; 3], 0.5); 2]))
    );
    let between = image
        .pixels
        .iter()
        .filter(|p| (10..180).contains(&p[3]))
        .count();
    assert!(between > 100, "{between}");
    let wall = Part::new(square(0.0, 0.0))
        .at(DVec3::Z)
        .color(Color::from_linear([1.0; 3]));
    let hidden = scene.add(wall.clone()).render(&above(), &smooth).unwrap();
    let alone = Scene::new()
        .add(wall)
        .light(lit(1.0))
        .render(&above(), &smooth)
        .unwrap();
    assert_eq!(worst(&hidden, &alone), 0);
}

/// The light of two half-spheres: all of the sky's from below, half of each
/// from the side.
#[test]
fn environments_light_by_the_normal() {
    let (sky, ground) = (Vec3::new(0.4, 0.6, 0.9), Vec3::new(0.3, 0.2, 0.1));
    let color = Color::from_linear([1.0; 3]);
    for (up, share) in [
        (DVec3::Z, 1.0),
        (DVec3::NEG_Z * 3.0, 0.0),
        (DVec3::X, 0.5),
        (DVec3::new(3f64.sqrt(), 0.0, 1.0), 0.75),
    ] {
        for interpolation in [
            Interpolation::Flat,
            Interpolation::Gouraud,
            Interpolation::Phong,
        ] {
            let image = Scene::new()
                .add(square(0.0, 0.0))
                .color(color)
                .light(Light::Environment { up, sky, ground })
                .render(&above(), &options().interpolation(interpolation))
                .unwrap();
            let wanted = Color::from_linear(ground.lerp(sky, share).to_array()).to_srgb();
            let found = image.get(60, 60).unwrap();
            for (found, wanted) in found.iter().zip(wanted) {
                assert!(
                    (f32::from(*found) - wanted * 255.0).abs() < 0.6,
                    "{found} {wanted}"
                );
            }
        }
    }
}

/// Squares of a quarter, by position: those of the part, wherever it is.
#[test]
fn checkers_have_squares() {
    let (white, black) = (Color::from_linear([1.0; 3]), Color::from_linear([0.0; 3]));
    let texture = Texture::checker(0.25, [white, black]);
    let part = Part::new(square(0.01, 0.0)).texture(texture);
    for model in [
        DMat4::IDENTITY,
        DMat4::from_rotation_z(std::f64::consts::FRAC_PI_2),
    ] {
        let scene = Scene::new()
            .add(part.clone().transformed(model))
            .finish(Finish::new(1.0, 1.0, 0.0, 1.0))
            .light(lit(1.0));
        let image = scene.render(&above(), &options()).unwrap();
        for k in 0..SIZE * SIZE {
            let (x, y) = (k % SIZE, k / SIZE);
            // 15 pixels a square; a quarter turn about the middle swaps colours
            // of no square.
            let odd = (x / 15 + y / 15) % 2 == 1;
            let turned = model != DMat4::IDENTITY;
            let wanted = if odd == turned {
                [0, 0, 0, 255]
            } else {
                [255; 4]
            };
            assert_eq!(image.get(x, y), Some(wanted), "{x} {y} {turned}");
        }
    }
}

/// A globe of twelve by six squares: their colours at the middle of each.
#[test]
fn spheres_and_cylinders_have_parameters() {
    let (white, black) = (Color::from_linear([1.0; 3]), Color::from_linear([0.0; 3]));
    let globe = Texture::sphere(DVec3::ONE, 12, 6, [white, black]);
    let tower = Texture::cylinder(DVec3::ONE, 12, 0.5, [white, black]);
    for k in 0..12 * 6 {
        let (column, row) = (k % 12, k / 12);
        let longitude = (f64::from(column) + 0.5) / 12.0 * TAU - std::f64::consts::PI;
        let latitude = ((f64::from(row) + 0.5) / 6.0 - 0.5) * std::f64::consts::PI;
        let around = DVec3::new(longitude.cos(), longitude.sin(), 0.0);
        let on_globe = DVec3::ONE + around * latitude.cos() * 2.0 + DVec3::Z * latitude.sin() * 2.0;
        let wanted = Vec3::splat(f32::from((column + row) % 2 == 0));
        assert_eq!(globe.color(on_globe), wanted, "{column} {row}");
        let on_tower = DVec3::ONE + around * 3.0 + DVec3::Z * (f64::from(row) * 0.5 + 0.2);
        assert_eq!(tower.color(on_tower), wanted, "{column} {row}");
    }
}

/// Pictures are saved, and errors are told.
#[test]
fn pictures_are_saved() {
    let scene = Scene::new().add(common::cuboid(DVec3::ZERO, DVec3::ONE));
    let options = RenderOptions::presentation().size(64, 48);
    let image = scene
        .render(&scene.camera(&options).unwrap(), &options)
        .unwrap();
    let path = std::env::temp_dir().join(format!("raster-{}.png", std::process::id()));
    image.save(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), image.to_png().unwrap());
    std::fs::remove_file(&path).unwrap();
    assert!(image.save(path.join("nowhere")).is_err());
    assert!(Scene::new().camera(&options).is_err());
}

/// Steps along the parameters of planes, spheres, cylinders and cones in any
/// place are steps of the pattern.
#[test]
fn checkers_go_by_the_parameters_of_surfaces() {
    let colors = [0.0, 1.0].map(|v| Color::from_linear([v; 3]));
    let (offset, turn) = (DVec3::new(3.0, -1.0, 2.0), DQuat::from_rotation_x(0.6));
    let placed = |p: DVec3| turn * p + offset;
    let side = 0.25;
    let curved = |solid: &csg::Solid| {
        let solid = solid.rotate_x(0.6).translate(offset);
        let program = csg::Program::lower(&solid).unwrap();
        let surface = program.surfaces().iter().find(|s| !s.is_plane());
        let surface = *surface.unwrap_or(&program.surfaces()[0]);
        Texture::on_surface(&surface, side, colors)
    };
    let at = |(texture, matrix): &(Texture, DMat4), p: DVec3| {
        texture.parameters(matrix.transform_point3(placed(p)))
    };
    let step = |a: DVec3, b: DVec3, count: f64| {
        let d = (a - b).abs();
        let u = d.x.min((count - d.x).abs());
        DVec2::new(u, d.y)
    };
    let around =
        |radius: f64, angle: f64, z: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), z);

    let cylinder = curved(&csg::Solid::cylinder(0.7, 0.0..2.0));
    // Even, so that the pattern closes: the nearest to the length of a turn.
    let count = 2.0 * (std::f64::consts::PI * 0.7 / side).round();
    let cone = curved(&csg::Solid::cone(1.0, 0.0..2.0));
    for (texture, count) in [(&cylinder, count), (&cone, 12.0)] {
        for (angle, z) in [(0.1, 0.3), (2.0, 1.1), (-2.5, 0.9)] {
            let radius = if count == 12.0 { 1.0 - z / 2.0 } else { 0.7 };
            let here = at(texture, around(radius, angle, z));
            let next = at(texture, around(radius, angle + TAU / count, z));
            assert!(step(here, next, count).abs_diff_eq(DVec2::X, 1e-9));
            let radius = if count == 12.0 {
                radius - side / 2.0
            } else {
                0.7
            };
            let above = at(texture, around(radius, angle, z + side));
            assert!(step(here, above, count).abs_diff_eq(DVec2::Y, 1e-9));
        }
    }

    let ball = curved(&csg::Solid::sphere(0.5));
    let count = 2.0 * (std::f64::consts::PI * 0.5 / side).round();
    // (A sphere's axis is upright however it was turned.)
    let on_ball = |longitude: f64, latitude: f64| {
        let p = around(0.5 * f64::cos(latitude), longitude, 0.5 * latitude.sin());
        at(&ball, turn.inverse() * p)
    };
    let here = on_ball(0.4, 0.2);
    let east = on_ball(0.4 + TAU / count, 0.2);
    assert!(step(here, east, count).abs_diff_eq(DVec2::X, 1e-9));
    let north = on_ball(0.4, 0.2 + TAU / count);
    assert!(step(here, north, count).abs_diff_eq(DVec2::Y, 1e-9));

    let plane = curved(&csg::Solid::cuboid(DVec3::ONE));
    let corner = at(&plane, DVec3::splat(0.5));
    let found: Vec<f64> = DVec3::AXES
        .map(|axis| (at(&plane, DVec3::splat(0.5) - axis * side) - corner).length())
        .to_vec();
    // One across, two along; nothing changes across.
    assert_eq!(found.iter().filter(|d| **d < 1e-9).count(), 1, "{found:?}");
    assert_eq!(found.iter().filter(|d| (**d - 1.0).abs() < 1e-9).count(), 2);
}

/// Every surface gets its own pattern in a picture.
#[test]
fn surfaces_are_dyed_one_by_one() {
    let [red, white, blue] = [[1.0, 0.0, 0.0], [1.0; 3], [0.0, 0.0, 1.0]].map(Color::from_linear);
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let plain = |color| (Texture::checker(1e3, [color; 2]), DMat4::IDENTITY);
    // left, right, front, back, bottom, top
    let dyes = [white, red, blue, white, white, white].map(plain);
    let scene = Prepared::new(&mesh).with_textures(dyes);
    let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 1.0).unwrap();
    let mut image = Image::default();
    let (view, options) = (camera.view(64, 64).unwrap(), RenderOptions::default());
    let mut renderer = Renderer::default();
    renderer
        .draw(&scene, &view, 64, 64, &options, &mut image)
        .unwrap();
    let surfaces = renderer.surface_buffer(&scene);
    let mut seen = [0; 6];
    for (pixel, surface) in image.pixels.iter().zip(&surfaces.values) {
        let Some(surface) = surface else { continue };
        seen[*surface as usize] += 1;
        match surface {
            1 => assert!(pixel[0] > 2 * pixel[2], "{pixel:?}"),
            2 => assert!(pixel[2] > 2 * pixel[0], "{pixel:?}"),
            _ => assert!(pixel[0].abs_diff(pixel[2]) < 30, "{pixel:?}"),
        }
    }
    assert!(
        seen.iter().filter(|count| **count > 100).count() == 3,
        "{seen:?}"
    );
}
