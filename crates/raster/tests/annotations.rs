//! Dimensions, colours that tell something, exploded views: their numbers
//! against geometry.

use crate::common;
use csg::{Color, Mesh, MeshSurface, Mesher, Program, Solid};
use glam::DVec3;
use raster::{
    ColorBy, Dimension, Image, Legend, Lens, StandardView, color_by_deviation, draw_dimensions,
    draw_legend, draw_scale_bar, exploded, ramp, written, written_within,
};

const SIZE: u32 = 240;

fn named(mut mesh: Mesh, names: [&str; 6]) -> Mesh {
    for (surface, name) in mesh.surfaces.iter_mut().zip(names) {
        surface.name = Some(name.into());
    }
    mesh
}

/// The sides of [`common::cuboid`].
const SIDES: [&str; 6] = ["left", "right", "front", "back", "bottom", "top"];

#[test]
fn dimensions_of_a_box_are_its_sides() {
    let (low, high) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.5, 3.0, 7.0));
    let mesh = common::cuboid(low, high);
    for view in [StandardView::Iso, StandardView::Front] {
        let camera = raster::Camera::standard(&mesh, view, Lens::DEFAULT, 1.0).unwrap();
        let view = camera.view(SIZE, SIZE).unwrap();
        let found = Dimension::of_box(low, high, &view, SIZE, SIZE);
        let lengths: Vec<f64> = found.iter().map(Dimension::length).collect();
        assert!(
            lengths.contains(&2.5) && lengths.contains(&4.0),
            "{lengths:?}"
        );
        // Lines are drawn beside the model, not over it.
        let mut image = Image::new(SIZE, SIZE, [255; 4]);
        draw_dimensions(
            &found,
            "mm",
            &view,
            Color::from_linear([0.0; 3]),
            &mut image,
        );
        assert!(image.pixels.iter().filter(|p| p[0] < 200).count() > 100);
        assert_eq!(image.get(SIZE / 2, SIZE / 2), Some([255; 4]));
    }
}

#[test]
fn dimensions_between_named_faces() {
    let mesh = named(
        common::cuboid(DVec3::ZERO, DVec3::new(2.0, 3.0, 5.0)),
        SIDES,
    );
    let length = |a: &str, b: &str| Dimension::between(&mesh, a, b).map(|d| d.length());
    assert_eq!(length("left", "right"), Some(2.0));
    assert_eq!(length("back", "front"), Some(3.0));
    assert_eq!(length("top", "bottom"), Some(5.0));
    assert_eq!(length("top", "front"), None);
    assert_eq!(length("top", "lid"), None);
    // The line runs at right angles to the faces.
    let across = Dimension::between(&mesh, "left", "right").unwrap();
    assert_eq!((across.to - across.from).normalize(), DVec3::X);
    // Bent faces have no distance.
    let mut ball = common::icosphere(DVec3::ZERO, 1.0, 1);
    ball = common::colored(ball, [1.0; 3]);
    ball.surfaces[0].name = Some("round".into());
    assert_eq!(Dimension::between(&ball, "round", "round"), None);
}

#[test]
fn numbers_are_written_short() {
    for (value, text) in [
        (2.5, "2.5"),
        (40.0, "40"),
        (0.12345, "0.1235"),
        (1234.56, "1235"),
        (100.0, "100"),
        (-3.25, "-3.25"),
        (0.0, "0"),
        (f64::NAN, "0"),
    ] {
        assert_eq!(written(value), text);
    }
    // Digits that are not known are not written.
    for (value, error, text) in [
        (1.999, 2e-3, "2"),
        (1.234, 4e-3, "1.23"),
        (1.234, 6e-3, "1.2"),
        (1.234, 0.4, "1"),
        (12.34, 70.0, "12"),
        (0.7, 1e-12, "0.7"),
    ] {
        assert_eq!(written_within(value, error), text);
    }
}

/// The bar is as long as it says: a unit is ten pixels, so 5 units are 50.
#[test]
fn scale_bars_have_round_lengths() {
    for (pixel, length) in [(0.1, 50u32), (0.03, 33), (7.0, 29)] {
        let mut image = Image::new(SIZE, SIZE, [255; 4]);
        draw_scale_bar(pixel, "", Color::from_linear([0.0; 3]), &mut image);
        let rows = image.pixels.chunks(SIZE as usize);
        let longest = rows
            .map(|row| row.iter().filter(|p| p[0] < 128).count())
            .max();
        assert!(
            longest.unwrap().abs_diff(length as usize) <= 2,
            "{pixel}: {longest:?}"
        );
    }
}

fn range(legend: &Legend) -> [f64; 2] {
    match legend {
        Legend::Range { low, high, .. } => [*low, *high],
        Legend::Names(_) => panic!("no range"),
    }
}

#[test]
fn curvature_of_a_ball_is_one_by_its_radius() {
    let mut ball = common::icosphere(DVec3::ZERO, 4.0, 3);
    let [low, high] = range(&ColorBy::Curvature.apply(&mut ball));
    assert!(
        (low - 0.25).abs() < 1e-5 && (high - 0.25).abs() < 1e-5,
        "{low} {high}"
    );
}

/// A ball's triangles are off by the radius less the way to their middles; a box's
/// by nothing; and nothing is known of triangles without a surface.
#[test]
fn deviation_is_the_way_to_the_surface() {
    let lowered = |solid: &Solid| Program::lower(solid).unwrap();
    let program = lowered(&Solid::sphere(2.0).translate(DVec3::new(1.0, 2.0, 3.0)));
    let centre = DVec3::new(1.0, 2.0, 3.0);
    let mut mesh = common::icosphere(centre, 2.0, 2);
    mesh.surfaces = vec![MeshSurface::default()];
    mesh.triangle_surfaces = vec![0; mesh.triangles.len()];
    let off = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| mesh.positions[v as usize]);
        let middles = [
            (a + b) / 2.0,
            (b + c) / 2.0,
            (c + a) / 2.0,
            (a + b + c) / 3.0,
        ];
        middles
            .map(|p| 2.0 - p.distance(centre))
            .into_iter()
            .fold(0.0, f64::max)
    };
    let wanted: Vec<f64> = mesh.triangles.iter().map(|&t| off(t)).collect();
    let Legend::Range { low, high, .. } = color_by_deviation(&mut mesh, program.surfaces()) else {
        panic!("no range");
    };
    let range = wanted.iter().fold((f64::MAX, 0.0f64), |(low, high), &v| {
        (low.min(v), high.max(v))
    });
    assert!(
        (low - range.0).abs() < 1e-12 && (high - range.1).abs() < 1e-12,
        "{low} {high} {range:?}"
    );
    // The farther a triangle, the brighter.
    let step = |t: usize| mesh.triangle_surfaces[t];
    let (least, most) = (0..wanted.len()).fold((0, 0), |(least, most), t| {
        let least = if wanted[t] < wanted[least] { t } else { least };
        (least, if wanted[t] > wanted[most] { t } else { most })
    });
    assert_eq!((step(least), step(most)), (0, 63));

    let meshed = Mesher::new()
        .mesh(&lowered(&Solid::cuboid(DVec3::ONE)))
        .unwrap();
    let program = lowered(&Solid::cuboid(DVec3::ONE));
    let mut mesh = meshed.mesh;
    let legend = color_by_deviation(&mut mesh, program.surfaces());
    assert!(
        matches!(
            legend,
            Legend::Range {
                low: 0.0,
                high: 0.0,
                ..
            }
        ),
        "{legend:?}"
    );
    let mut bare = common::icosphere(DVec3::ZERO, 1.0, 1);
    bare.triangle_surfaces.clear();
    color_by_deviation(&mut bare, program.surfaces());
    assert!(
        bare.triangle_surfaces
            .iter()
            .all(|&k| k as usize >= bare.surfaces.len())
    );
}

#[test]
fn thickness_is_the_way_through() {
    let sides = DVec3::new(1.0, 2.0, 3.0);
    let mut mesh = common::cuboid(DVec3::ZERO, sides);
    let [low, high] = range(&ColorBy::Thickness.apply(&mut mesh));
    assert_eq!([low, high], [1.0, 3.0]);
    let color = |side: usize| mesh.surfaces[mesh.triangle_surfaces[2 * side] as usize].color;
    let wanted = |length: f64| Some(ramp((length - 1.0) / 2.0));
    let near = |a: Option<Color>, b: Option<Color>| {
        let (a, b) = (a.unwrap().rgb, b.unwrap().rgb);
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
    };
    for side in 0..6 {
        assert!(near(color(side), wanted(sides[side / 2])), "{side}");
    }
    // A shell's wall, from outside and from inside.
    let outside = common::icosphere(DVec3::ZERO, 1.0, 4);
    let mut inside = common::icosphere(DVec3::ZERO, 0.8, 4);
    for (triangle, normals) in inside.triangles.iter_mut().zip(&mut inside.corner_normals) {
        triangle.swap(1, 2);
        normals.swap(1, 2);
    }
    let mut shell = common::merge(outside, &inside);
    let [low, high] = range(&ColorBy::Thickness.apply(&mut shell));
    assert!(low > 0.19 && high < 0.21, "{low} {high}");
}

/// A wedge of eight triangles: from 0 to its full thickness there is no place
/// whose colour tells another one than it has, and the mesh is still closed.
#[test]
fn thickness_shows_no_triangles() {
    const STEP: f64 = 1.0 / 63.0;
    let (length, height, width) = (4.0, 3.0, 2.0);
    let corner = |y: f64| {
        let [tip, end, top] = [(0.0, 0.0), (length, 0.0), (length, height)];
        [tip, end, top].map(|(x, z)| DVec3::new(x, y, z))
    };
    let positions = [corner(0.0), corner(width)].concat();
    let triangles = vec![
        [0, 1, 2],
        [3, 5, 4],
        [0, 3, 4],
        [0, 4, 1],
        [1, 4, 5],
        [1, 5, 2],
        [2, 5, 3],
        [2, 3, 0],
    ];
    let mut mesh = Mesh::new(positions, triangles);
    let volume = mesh.volume();
    let [low, high] = range(&ColorBy::Thickness.apply(&mut mesh));
    assert_eq!(low, 0.0);
    assert!((high - length).abs() < 1e-4, "{high}");
    // Straight inwards: up to the slope; across; back to the slope; down the
    // slope's normal, to the floor or to the wall.
    let thickness = |p: DVec3, normal: DVec3| {
        if normal.z < -0.9 {
            p.x * height / length
        } else if normal.y.abs() > 0.9 {
            width
        } else if normal.x > 0.9 {
            length - p.z * length / height
        } else {
            (p.z * 5.0 / 4.0).min((length - p.x) * 5.0 / 3.0)
        }
    };
    let mut sides = std::collections::HashMap::new();
    for (triangle, &corners) in mesh.triangles.iter().enumerate() {
        let at = corners.map(|v| mesh.positions[v as usize]);
        let normal = (at[1] - at[0]).cross(at[2] - at[0]).normalize();
        let wanted = at.map(|p| thickness(p, normal) / high);
        let color = mesh.surfaces[mesh.triangle_surfaces[triangle] as usize].color;
        for share in wanted {
            // Green grows all along the map. A triangle's mean is up to two thirds of
            // a step off, and its colour another half.
            let green = |share: f64| ramp(share).rgb[1];
            let off = STEP * 7.001 / 6.0;
            let near = green(share - off)..=green(share + off);
            let own = color.unwrap().rgb[1];
            assert!(near.contains(&own), "{at:?}: {own} for {share}");
        }
        for k in 0..3 {
            *sides.entry([corners[k], corners[(k + 1) % 3]]).or_insert(0) += 1;
        }
    }
    assert!(
        sides
            .iter()
            .all(|([a, b], count)| *count == 1 && sides.contains_key(&[*b, *a]))
    );
    assert!((mesh.volume() - volume).abs() < 1e-12);
    let edges = mesh.feature_edges.iter().flat_map(|line| line.windows(2));
    for ends in edges.clone() {
        assert!(sides.contains_key(&[ends[0], ends[1]]));
    }
    let long = edges
        .map(|ends| mesh.positions[ends[0] as usize].distance(mesh.positions[ends[1] as usize]));
    let around = 2.0 * (3.0 + 4.0 + 5.0) + 3.0 * width;
    assert!((long.sum::<f64>() - around).abs() < 1e-9);
}

#[test]
fn draft_is_how_faces_lean() {
    let mut mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    assert_eq!(range(&ColorBy::Draft.apply(&mut mesh)), [-90.0, 90.0]);
    let color = |side: usize| mesh.surfaces[mesh.triangle_surfaces[2 * side] as usize].color;
    assert_eq!(color(5), Some(ramp(1.0)));
    assert_eq!(color(4), Some(ramp(0.0)));
    assert_eq!(color(0), color(3));
}

#[test]
fn parts_are_told_apart_and_moved_apart() {
    let one = common::cuboid(DVec3::splat(-1.0), DVec3::splat(-0.5));
    let other = common::cuboid(DVec3::splat(0.5), DVec3::splat(1.0));
    let mut mesh = common::merge(one, &other);
    let apart = exploded(&mesh, 2.0);
    assert_eq!(apart.positions[0], DVec3::splat(-1.0 - 0.75 * 2.0));
    assert_eq!(apart.positions[8], DVec3::splat(0.5 + 0.75 * 2.0));
    assert_eq!(exploded(&mesh, 0.0).positions, mesh.positions);
    let Legend::Names(names) = ColorBy::Part.apply(&mut mesh) else {
        panic!("no names");
    };
    assert_eq!(names.len(), 2);
    assert_ne!(names[0].1, names[1].1);
    assert_eq!(mesh.triangle_surfaces, [[0; 12], [1; 12]].concat());
}

#[test]
fn surfaces_are_named_in_the_legend() {
    let mut mesh = named(common::cuboid(DVec3::ZERO, DVec3::ONE), SIDES);
    let legend = ColorBy::Surface.apply(&mut mesh);
    let Legend::Names(names) = &legend else {
        panic!("no names");
    };
    assert_eq!(
        names
            .iter()
            .map(|(name, _)| name.as_str())
            .collect::<Vec<_>>(),
        SIDES
    );
    let mut image = Image::new(SIZE, SIZE, [255; 4]);
    draw_legend(&legend, Color::from_linear([0.0; 3]), &mut image);
    for (_, color) in names {
        let encoded = color.to_srgb().map(|c| (c * 255.0).round() as u8);
        assert!(image.pixels.iter().filter(|p| p[..3] == encoded).count() > 20);
    }
}
