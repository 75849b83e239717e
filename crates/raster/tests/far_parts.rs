//! A part far away leaves near ones as they are.

use crate::common;
use csg::Mesh;
use glam::DVec3;
use raster::{Camera, Image, Interpolation, Lens, Prepared, RenderOptions, Renderer};

const SIZE: u32 = 260;

fn picture(mesh: &Mesh, options: &RenderOptions) -> Image {
    let camera = Camera {
        eye: DVec3::new(3.0, -4.0, 2.5),
        target: DVec3::ZERO,
        up: DVec3::Z,
        lens: Lens::DEFAULT,
        near: 0.5,
        far: f64::INFINITY,
    };
    let view = camera.view(SIZE, SIZE).unwrap();
    let mut image = Image::default();
    Renderer::default()
        .draw(&Prepared::new(mesh), &view, SIZE, SIZE, options, &mut image)
        .unwrap();
    image
}

#[test]
fn a_far_part_does_not_spoil_near_ones() {
    let ball = common::icosphere(DVec3::new(0.2, -0.1, 0.3), 0.8, 4);
    let near = common::merge(ball, &common::cuboid(DVec3::splat(-0.9), DVec3::splat(0.1)));
    for distance in [1e5, 1e6, 1e7, 1e8] {
        for direction in [DVec3::new(1.0, -1.0, 1.0), DVec3::new(-0.3, 1.0, -0.2)] {
            let place = direction.normalize() * distance;
            let far = common::cuboid(place - DVec3::ONE, place + DVec3::ONE);
            let both = common::merge(near.clone(), &far);
            for interpolation in [
                Interpolation::Phong,
                Interpolation::Gouraud,
                Interpolation::Flat,
            ] {
                let mut options = RenderOptions::default();
                options.interpolation = interpolation;
                let alone = picture(&near, &options);
                let beside = picture(&both, &options);
                let pairs = alone
                    .pixels
                    .as_flattened()
                    .iter()
                    .zip(beside.pixels.as_flattened());
                let off = pairs.filter(|(a, b)| a.abs_diff(**b) > 8).count();
                assert_eq!(off, 0, "{distance} {direction} {interpolation:?}");
            }
        }
    }
}
