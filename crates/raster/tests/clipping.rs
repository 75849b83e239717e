//! Triangles around, behind and through the eye, against the definition: a
//! pixel is covered if its ray meets the triangle between the near and the far
//! plane.

use crate::common;
use csg::Mesh;
use glam::{DMat3, DMat4, DVec3};
use proptest::prelude::*;
use raster::{Image, Prepared, RenderOptions, Renderer, View, projection};

const SIZE: u32 = 96;

fn view() -> View {
    View::new(
        DMat4::IDENTITY,
        projection::perspective(1.2, 1.0, 0.25, 16.0),
    )
    .unwrap()
}

fn drawn(mesh: &Mesh) -> Vec<bool> {
    let mut options = RenderOptions::default();
    options.cull_back_faces = false;
    let mut image = Image::default();
    Renderer::default()
        .draw(
            &Prepared::new(mesh),
            &view(),
            SIZE,
            SIZE,
            &options,
            &mut image,
        )
        .unwrap();
    image.pixels.iter().map(|p| p[3] == 255).collect()
}

/// Whether the ray through a position of the window meets the triangle.
fn meets(to_weights: DMat3, depths: DVec3, x: f64, y: f64) -> bool {
    let half = f64::from(SIZE) / 2.0;
    let weights = to_weights * DVec3::new(x / half - 1.0, 1.0 - y / half, 1.0);
    let depth = weights.dot(depths);
    weights.min_element() >= 0.0 && (-1.0..=1.0).contains(&depth)
}

/// Eighths, among them 0: corners on the axes, in the eye's plane, and in the
/// eye.
fn corner() -> impl Strategy<Value = [i32; 3]> {
    prop_oneof![
        4 => proptest::array::uniform3(-40..40i32),
        2 => (-40..40i32, -40..40i32).prop_map(|(x, y)| [x, y, 0]),
        1 => Just([0, 0, 0]),
        1 => (-8..8i32, -8..8i32, -140..-1i32).prop_map(|(x, y, z)| [x, y, z]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn coverage_is_that_of_rays(corners in proptest::array::uniform3(corner())) {
        let positions = corners.map(|c| DVec3::from_array(c.map(|v| f64::from(v) / 8.0)));
        // Two more vertices keep the scene's centre at the origin.
        let mut all = positions.to_vec();
        all.extend([DVec3::splat(-32.0), DVec3::splat(32.0)]);
        let drawn = drawn(&Mesh::new(all, vec![[0, 1, 2]]));
        let clip = positions.map(|p| view().world_to_clip() * p.extend(1.0));
        let matrix = DMat3::from_cols_array_2d(&clip.map(|p| [p.x, p.y, p.w]));
        if matrix.determinant().abs() < 1e-9 {
            // Seen edge-on, or without area.
            prop_assert!(drawn.iter().filter(|d| **d).count() <= SIZE as usize);
            return Ok(());
        }
        let to_weights = matrix.inverse();
        let depths = DVec3::from_array(clip.map(|p| p.z));
        for (k, drawn) in drawn.into_iter().enumerate() {
            let x = f64::from(k as u32 % SIZE) + 0.5;
            let y = f64::from(k as u32 / SIZE) + 0.5;
            let expected = meets(to_weights, depths, x, y);
            // Where 1/64 pixel changes the answer, snapping may.
            let sure = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].iter().all(|(i, j)| {
                meets(to_weights, depths, x + i / 64.0, y + j / 64.0) == expected
            });
            prop_assert!(!sure || drawn == expected, "pixel {} {}", x, y);
        }
    }
}

#[test]
fn nothing_is_seen_of_what_is_all_behind() {
    let behind = |z: f64| {
        let corners = [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)];
        let mesh = Mesh::new(
            corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec(),
            vec![[0, 1, 2]],
        );
        drawn(&mesh).into_iter().filter(|d| *d).count()
    };
    for z in [0.0, 1e-30, 0.1, 5.0, 1e6] {
        assert_eq!(behind(z), 0, "{z}");
    }
    // Between the eye and the near plane, and beyond the far one.
    assert_eq!((behind(-0.2), behind(-17.0)), (0, 0));
    assert!(behind(-0.3) > 0);
}

/// From inside a closed mesh every pixel shows its inner side.
#[test]
fn inside_a_closed_mesh_there_is_no_way_out() {
    for (radius, level) in [(0.5, 0), (1.0, 1), (3.0, 3), (15.0, 2)] {
        let mesh = common::icosphere(DVec3::new(0.01, -0.02, 0.03), radius, level);
        assert!(drawn(&mesh).into_iter().all(|d| d), "{radius}");
    }
}
