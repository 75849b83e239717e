//! Clipping by outcodes, and polygons by tables.

use glam::{DVec2, DVec3};
use raster::cohen_sutherland::{Decision, Rectangle, decide};
use raster::hidden_surface::ScanLine;
use raster::polygon_model::PolygonModel;
use raster::{Camera, Lens, RenderOptions, render_reference};

#[test]
fn outcodes_a_to_e() {
    let r = Rectangle {
        low: DVec2::ZERO,
        high: DVec2::ONE,
    };
    let at = |x: f64, y: f64| DVec2::new(x, y);
    // The texts' table: codes of both ends, and, or, what is done.
    let table = [
        ("A", 0b1001, 0b1000, 0b1000, 0b1001, Decision::Reject),
        ("B", 0b0000, 0b0000, 0b0000, 0b0000, Decision::Accept),
        ("C", 0b0001, 0b0000, 0b0000, 0b0001, Decision::Cut),
        ("D", 0b0100, 0b0010, 0b0000, 0b0110, Decision::Cut),
        ("D'", 0b0000, 0b0010, 0b0000, 0b0010, Decision::Cut),
        ("E", 0b0100, 0b0010, 0b0000, 0b0110, Decision::Cut),
        ("E'", 0b0110, 0b0010, 0b0010, 0b0110, Decision::Reject),
    ];
    for (name, a, b, and, or, decision) in table {
        assert_eq!((a & b, a | b, decide(a, b)), (and, or, decision), "{name}");
    }
    // Segments like the drawing's.
    let [a, b, c, d, e] = [
        [at(-0.5, 1.8), at(0.4, 1.2)],
        [at(0.2, 0.7), at(0.6, 0.9)],
        [at(-0.6, 0.5), at(0.4, 0.4)],
        [at(0.5, -0.4), at(1.4, 0.5)],
        [at(0.7, -0.8), at(1.9, 0.4)],
    ];
    let codes = |s: [DVec2; 2]| s.map(|p| r.outcode(p));
    assert_eq!(codes(a), [0b1001, 0b1000]);
    assert_eq!(codes(b), [0, 0]);
    assert_eq!(codes(c), [0b0001, 0]);
    assert_eq!(codes(d), [0b0100, 0b0010]);
    assert_eq!(codes(e), [0b0100, 0b0010]);
    let clip = |[p, q]: [DVec2; 2]| r.clip(p, q);
    assert_eq!(clip(a), None);
    assert_eq!(clip(b), Some((b[0], b[1])));
    let (from, to) = clip(c).unwrap();
    assert!(from.abs_diff_eq(at(0.0, 0.44), 1e-12) && to == c[1]);
    let (from, to) = clip(d).unwrap();
    assert!(from.abs_diff_eq(at(0.9, 0.0), 1e-12) && to.abs_diff_eq(at(1.0, 0.1), 1e-12));
    assert_eq!(clip(e), None);
    // E': its end cut off at the lower line is right of the rectangle.
    assert_eq!(r.outcode(at(1.5, 0.0) - at(0.0, 1e-9)), 0b0110);
}

/// The box of the printed tables.
fn printed_box() -> PolygonModel {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    PolygonModel {
        // v1..v4 above, v5..v8 below, so that f1 = v1 v5 v8 v4 looks along +x.
        vertices: vec![
            v(1.0, 0.0, 1.0),
            v(0.0, 0.0, 1.0),
            v(0.0, 1.0, 1.0),
            v(1.0, 1.0, 1.0),
            v(1.0, 0.0, 0.0),
            v(0.0, 0.0, 0.0),
            v(0.0, 1.0, 0.0),
            v(1.0, 1.0, 0.0),
        ],
        faces: [
            [1, 5, 8, 4],
            [2, 3, 7, 6],
            [1, 2, 6, 5],
            [4, 8, 7, 3],
            [1, 4, 3, 2],
            [5, 6, 7, 8],
        ]
        .iter()
        .map(|face| face.iter().map(|v| v - 1).collect())
        .collect(),
    }
}

#[test]
fn polygon_tables() {
    let model = printed_box();
    assert_eq!(model.edges().len(), 12);
    assert!(model.is_closed());
    // V - E + F = 2.
    assert_eq!(
        model.vertices.len() + model.faces.len(),
        model.edges().len() + 2
    );
    let axes = [
        DVec3::X,
        DVec3::NEG_X,
        DVec3::NEG_Y,
        DVec3::Y,
        DVec3::Z,
        DVec3::NEG_Z,
    ];
    for (face, axis) in axes.into_iter().enumerate() {
        assert!(model.vector_area(face).abs_diff_eq(axis, 1e-12), "{face}");
        // N = U1 x U2 with U1 = v1 - v0, U2 = v2 - v0.
        let [v0, v1, v2] = [0, 1, 2].map(|k| model.vertices[model.faces[face][k] as usize]);
        assert_eq!((v1 - v0).cross(v2 - v0), axis);
        // Back-face removal, exact for a convex model.
        let eye = DVec3::new(5.0, -4.0, 0.5);
        let wanted = matches!(face, 0 | 2);
        assert_eq!(model.faces_viewer(face, eye), wanted, "{face}");
    }
    let mesh = model.to_mesh();
    assert_eq!(mesh.triangles.len(), 12);
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    // Turned round, the face's outside is its inside.
    let mut turned = model.clone();
    turned.faces[0].reverse();
    assert!(!turned.is_closed());
    assert!(turned.vector_area(0).abs_diff_eq(DVec3::NEG_X, 1e-12));
}

/// A prism over a star of ten corners.
fn star() -> PolygonModel {
    let corner = |k: u32, z: f64| {
        let radius = if k.is_multiple_of(2) { 1.0 } else { 0.4 };
        (DVec2::from_angle(f64::from(k) * 0.2 * std::f64::consts::PI) * radius).extend(z)
    };
    let mut model = PolygonModel::default();
    for z in [0.0, 0.5] {
        model.vertices.extend((0..10).map(|k| corner(k, z)));
    }
    model.faces.push((10..20).collect());
    model.faces.push((0..10).rev().collect());
    for k in 0..10 {
        let next = (k + 1) % 10;
        model.faces.push(vec![k, next, next + 10, k + 10]);
    }
    model
}

/// Ten triangles between neighbours at angle pi/5.
fn star_area() -> f64 {
    10.0 * 0.5 * 0.4 * (0.2 * std::f64::consts::PI).sin()
}

/// Concave faces are cut into triangles whose areas add up to theirs.
#[test]
fn concave_polygons_become_triangles() {
    let model = star();
    assert!(model.is_closed());
    let mesh = model.to_mesh();
    assert_eq!(mesh.triangles.len(), 2 * 8 + 10 * 2);
    let area = star_area();
    assert!((mesh.volume() - 0.5 * area).abs() < 1e-12);
    for face in 0..2 {
        let own = (0..mesh.triangles.len()).filter(|&t| mesh.triangle_surfaces[t] == face);
        let sum: f64 = own
            .map(|t| {
                let [a, b, c] = mesh.corners(t);
                let area = (b - a).cross(c - a).z / 2.0;
                assert!(area * if face == 0 { 1.0 } else { -1.0 } > 0.0);
                area.abs()
            })
            .sum();
        assert!((sum - area).abs() < 1e-12);
    }
}

/// Its picture from above, a row at a time, is the star: as many pixels as its
/// area has, and none of a notch.
#[test]
fn polygons_of_many_sides_are_scan_converted() {
    const SIZE: u32 = 200;
    let camera = Camera::looking_at(DVec3::Z * 4.0, DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.0 })
        .depths(1.0, 8.0);
    let view = camera.view(SIZE, SIZE).unwrap();
    let options = RenderOptions::default();
    let mesh = star().to_mesh();
    let rows = &mut ScanLine::new(SIZE);
    let image = render_reference(&mesh, &view, SIZE, SIZE, &options, rows).unwrap();
    let covered = image.pixels.iter().filter(|pixel| pixel[3] > 0).count();
    let side = 2.0 / f64::from(SIZE);
    // Centres decide: off by less than a pixel along the outline.
    let outline = 10.0 * DVec2::X.distance(DVec2::from_angle(0.2 * std::f64::consts::PI) * 0.4);
    let off = covered as f64 * side * side - star_area();
    assert!(off.abs() < side * outline, "{off}");
    let at = |angle: f64, radius: f64| {
        let p = DVec2::from_angle(angle) * radius;
        let [x, y] = [p.x + 1.0, 1.0 - p.y].map(|v| (v / side) as u32);
        image.get(x, y).unwrap()[3] > 0
    };
    for k in 0..5 {
        let tip = f64::from(k) * 0.4 * std::f64::consts::PI;
        assert!(at(tip, 0.9) && !at(tip + 0.2 * std::f64::consts::PI, 0.5));
    }
}
