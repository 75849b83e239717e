//! Measures against closed forms, near the origin and far from it.

use crate::random::Random;
use crate::shapes::{cuboid, joined, mapped, tetrahedron, torus, unit_cube, unit_tetrahedron};
use csg::Mesh;
use glam::{DMat3, DQuat, DVec3, dvec3};
use proptest::prelude::*;

/// Largest deviation of two matrices, relative to the second's largest entry.
fn relative(a: DMat3, b: DMat3) -> f64 {
    let largest = |m: DMat3| m.to_cols_array().iter().fold(0.0f64, |x, y| x.max(y.abs()));
    largest(a - b) / largest(b)
}

#[test]
fn a_box_has_its_closed_forms() {
    let size = dvec3(2.0, 3.0, 5.0);
    let measure = cuboid(dvec3(1.0, 1.0, 1.0), dvec3(3.0, 4.0, 6.0)).measure();
    assert!((measure.volume - 30.0).abs() < 1e-14);
    assert!((measure.area - 62.0).abs() < 1e-13);
    assert!((measure.centroid.unwrap() - dvec3(2.0, 2.5, 3.5)).length() < 1e-15);
    let moments = DMat3::from_diagonal(30.0 * size * size / 12.0);
    assert!(relative(measure.second_moments, moments) < 1e-15);
    let inertia = DMat3::from_diagonal(30.0 / 12.0 * dvec3(34.0, 29.0, 13.0));
    assert!(relative(measure.inertia(), inertia) < 1e-15);
}

/// Corners are integers, whose volume is one, too, over six: exactly known.
#[test]
fn volumes_are_within_their_rounding() {
    let mut random = Random(12);
    let mut coordinate = |most: usize| random.below(2 * most) as i64 - most as i64;
    let mut off = 0;
    for round in 0..2000 {
        let most = 1 << (4 + round % 16);
        // Four corners far away, and one within for every face: three triangles in its place.
        let far = coordinate(1 << 20);
        let mut corners: Vec<[i64; 3]> = Vec::new();
        let mut triangles: Vec<[u32; 3]> = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        for corner in 0..4 + round % 40 {
            corners.push([0; 3].map(|_: i64| far + coordinate(most)));
            if corner >= 4 {
                let [a, b, c] = triangles.swap_remove(round % triangles.len());
                let d = corner as u32;
                triangles.extend([[a, b, d], [b, c, d], [c, a, d]]);
            }
        }
        let of = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| corners[v as usize].map(i128::from));
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        let truth: i128 = triangles.iter().map(|&triangle| of(triangle)).sum();
        let points = corners
            .iter()
            .map(|p| DVec3::from_array(p.map(|x| x as f64)));
        let measure = Mesh::new(points.collect(), triangles).measure();
        // (Rounded once, and by the division once more.)
        let truth = truth as f64 / 6.0;
        let error = (measure.volume - truth).abs();
        let slack = 2.0 * f64::EPSILON * truth.abs();
        assert!(
            error <= measure.volume_rounding + slack,
            "{round}: {error:e} {measure:?}"
        );
        off += u32::from(error > slack);
        let size = most as f64;
        assert!(
            measure.volume_rounding < 1e-12 * size.powi(3),
            "{measure:?}"
        );
    }
    assert!(off > 20, "{off}");
}

#[test]
fn a_tetrahedron_has_its_closed_forms() {
    let measure = unit_tetrahedron().measure();
    assert!((measure.volume - 1.0 / 6.0).abs() < 1e-16);
    assert!((measure.area - (1.5 + 0.75f64.sqrt())).abs() < 1e-15);
    assert!((measure.centroid.unwrap() - DVec3::splat(0.25)).length() < 1e-16);
    // Integrals of x², xy over the unit simplex are 1/60 and 1/120; moved to
    // the centroid by the parallel-axis theorem.
    let (square, product) = (1.0 / 60.0 - 1.0 / 96.0, 1.0 / 120.0 - 1.0 / 96.0);
    let moments = DMat3::from_cols_array(&[
        square, product, product, product, square, product, product, product, square,
    ]);
    assert!(relative(measure.second_moments, moments) < 1e-14);
}

#[test]
fn a_torus_converges_to_its_closed_forms_at_second_order() {
    let (major, minor) = (2.0f64, 0.5f64);
    let pi = std::f64::consts::PI;
    let volume = 2.0 * pi * pi * major * minor * minor;
    let area = 4.0 * pi * pi * major * minor;
    // About its axis: V (R² + 3/4 r²).
    let spin = volume * (major * major + 0.75 * minor * minor);
    let error = |n: u32| {
        let measure = torus(major, minor, 2 * n, n).measure();
        assert!(measure.centroid.unwrap().length() < 1e-13);
        [
            1.0 - measure.volume / volume,
            1.0 - measure.area / area,
            1.0 - measure.inertia().z_axis.z / spin,
        ]
    };
    for (coarse, fine) in error(64).into_iter().zip(error(128)) {
        assert!((3.9..4.1).contains(&(coarse / fine)), "{coarse} {fine}");
        assert!(fine < 2e-3);
    }
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    // Coordinates that are exact in both places, so only the sums can err.
    let near = cuboid(DVec3::ZERO, dvec3(1.5, 0.25, 2.0));
    let offset = dvec3(1e6, -1e6, 3e6);
    let far = mapped(&near, |p| p + offset).measure();
    let near = near.measure();
    assert!((far.volume / 0.75 - 1.0).abs() < 4e-16);
    assert!((far.area - near.area).abs() <= 4e-16 * near.area);
    assert!(relative(far.second_moments, near.second_moments) < 4e-16);
    assert_eq!(far.centroid.unwrap(), offset + near.centroid.unwrap());
}

#[test]
fn many_triangles_lose_no_digits() {
    // A cube whose top is cut into 2 x 512 x 512 triangles: every coordinate
    // is a binary fraction, the truth is 1.
    let n = 512u32;
    let mut mesh = unit_cube();
    mesh.triangles.retain(|t| !t.iter().all(|&v| v >= 4));
    let step = 1.0 / f64::from(n);
    for i in 0..n {
        for j in 0..n {
            let first = mesh.positions.len() as u32;
            for (di, dj) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                mesh.positions.push(dvec3(
                    f64::from(i + di) * step,
                    f64::from(j + dj) * step,
                    1.0,
                ));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
    }
    let measure = mesh.measure();
    assert!(
        (measure.volume - 1.0).abs() < 3e-16,
        "{:e}",
        measure.volume - 1.0
    );
    assert!((measure.area - 6.0).abs() < 1e-15);
    assert!((measure.centroid.unwrap() - DVec3::splat(0.5)).length() < 3e-16);
}

#[test]
fn two_parts_add_and_inversion_negates() {
    let first = unit_cube();
    let second = mapped(&unit_tetrahedron(), |p| p + dvec3(5.0, 0.0, 0.0));
    let both = joined(&first, &second);
    assert!((both.volume() - 7.0 / 6.0).abs() < 1e-15);
    let parts = both.components();
    assert_eq!(parts.count, 2);
    assert_eq!(parts.of_triangles[..12], [Some(0); 12]);
    assert_eq!(parts.of_triangles[12..], [Some(1); 4]);
    let mut inside_out = both.clone();
    for triangle in &mut inside_out.triangles {
        triangle.swap(0, 1);
    }
    assert!((inside_out.volume() + 7.0 / 6.0).abs() < 1e-15);
    assert!((inside_out.area() - both.area()).abs() < 1e-15);
}

#[test]
fn nothing_has_no_centroid() {
    let empty = Mesh::default().measure();
    assert_eq!((empty.volume, empty.area, empty.centroid), (0.0, 0.0, None));
    let flat = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).measure();
    assert_eq!((flat.volume, flat.area, flat.centroid), (0.0, 0.5, None));
    assert_eq!(flat.inertia(), DMat3::ZERO);
}

fn point(size: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
}

proptest! {
    /// A rigid motion moves the centroid, turns the moments, and changes
    /// neither volume nor area.
    #[test]
    fn measures_follow_rigid_motions(
        corners in prop::array::uniform4(point(1.0)),
        axis in point(1.0).prop_filter("an axis", |a| a.length() > 0.1),
        angle in -3.0f64..3.0,
        offset in point(100.0),
    ) {
        let mesh = tetrahedron(corners);
        let turn = DQuat::from_axis_angle(axis.normalize(), angle);
        let moved = mapped(&mesh, |p| turn * p + offset).measure();
        let still = mesh.measure();
        prop_assume!(still.volume.abs() > 1e-3);
        let [a, b, c, d] = corners;
        let volume = (b - a).cross(c - a).dot(d - a) / 6.0;
        prop_assert!((still.volume - volume).abs() < 1e-15);
        // The positions themselves are rounded at 100: 1e-14 each.
        prop_assert!((moved.volume - volume).abs() < 1e-12);
        prop_assert!((moved.area - still.area).abs() < 1e-12);
        let centroid = (a + b + c + d) / 4.0;
        prop_assert!((still.centroid.unwrap() - centroid).length() < 1e-13);
        prop_assert!((moved.centroid.unwrap() - (turn * centroid + offset)).length() < 1e-11);
        let r = DMat3::from_quat(turn);
        let turned = r * still.second_moments * r.transpose();
        prop_assert!(relative(moved.second_moments, turned) < 1e-10);
    }
}
