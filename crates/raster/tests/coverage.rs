//! Coverage against exact integer arithmetic, and against itself: closed
//! surfaces have neither gaps nor doubled pixels.

use crate::common;
use csg::Mesh;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use raster::fixed::{FixedPoint, covers, doubled_area};
use raster::scanline::scan_convert;
use raster::{AntiAliasing, Camera, Image, Lens, Level, Prepared, RenderOptions, Renderer, View};

const SIZE: i32 = 128;

/// A view in which the picture shows x in 0..128 and y in -128..0, one unit a
/// pixel, so that multiples of 1/256 are sub-pixels exactly.
fn pixel_view() -> View {
    let half = f64::from(SIZE) / 2.0;
    let camera = Camera {
        eye: DVec3::new(half, -half, 10.0),
        target: DVec3::new(half, -half, 0.0),
        up: DVec3::Y,
        lens: Lens::Orthographic {
            height: f64::from(SIZE),
        },
        near: 1.0,
        far: 20.0,
    };
    camera.view(SIZE as u32, SIZE as u32).unwrap()
}

/// Triangles given in sub-pixels, drawn in a plane; two more vertices, which
/// no triangle uses, keep the scene's centre where it is.
fn flat_mesh(triangles: &[[FixedPoint; 3]]) -> Mesh {
    let at = |p: FixedPoint| DVec3::new(f64::from(p[0]) / 256.0, f64::from(p[1]) / -256.0, 0.0);
    let mut mesh = Mesh::new(
        vec![
            DVec3::new(-1024.0, -1024.0, 0.0),
            DVec3::new(1024.0, 1024.0, 0.0),
        ],
        vec![],
    );
    for corners in triangles {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(at));
        mesh.triangles.push([base, base + 1, base + 2]);
    }
    mesh
}

fn drawn(level: Level, mesh: &Mesh, view: &View, cull: bool) -> Vec<bool> {
    let mut options = RenderOptions::default();
    options.cull_back_faces = cull;
    let mut renderer = Renderer::with_level(level);
    let mut image = Image::default();
    renderer
        .draw(
            &Prepared::new(mesh),
            view,
            SIZE as u32,
            SIZE as u32,
            &options,
            &mut image,
        )
        .unwrap();
    let drawn: Vec<bool> = renderer
        .triangle_buffer()
        .values
        .iter()
        .map(Option::is_some)
        .collect();
    // What the picture shows is what the buffer says.
    assert!(
        image
            .pixels
            .iter()
            .zip(&drawn)
            .all(|(p, d)| (p[3] == 255) == *d)
    );
    drawn
}

fn samples() -> impl Iterator<Item = (usize, FixedPoint)> {
    (0..SIZE * SIZE).map(|k| (k as usize, [(k % SIZE) * 256 + 128, (k / SIZE) * 256 + 128]))
}

/// Sub-pixel coordinates: anywhere, exactly on a sample, or close together.
fn coordinate() -> impl Strategy<Value = i32> {
    prop_oneof![
        -40_000..80_000i32,
        (-4..SIZE + 4).prop_map(|p| p * 256 + 128),
        10_000..10_600i32,
    ]
}

fn corner() -> impl Strategy<Value = FixedPoint> {
    proptest::array::uniform2(coordinate())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn coverage_is_exact_at_every_level(corners in proptest::array::uniform3(corner())) {
        let mesh = flat_mesh(&[corners]);
        let view = pixel_view();
        for &level in Level::all() {
            let drawn = drawn(level, &mesh, &view, false);
            for (k, sample) in samples() {
                prop_assert_eq!(drawn[k], covers(corners, sample), "{} {:?}", level.name(), sample);
            }
        }
        // Only one side is the front.
        let front = drawn(Level::best(), &mesh, &view, true).into_iter().any(|d| d);
        prop_assert!(!front || doubled_area(corners) < 0);
    }

    /// With several samples a pixel is as opaque as its share of samples that
    /// are covered, each of them by the same exact arithmetic.
    #[test]
    fn multisampled_coverage_is_exact(corners in proptest::array::uniform3(corner())) {
        let (mesh, view, size) = (flat_mesh(&[corners]), pixel_view(), SIZE as u32);
        for anti_aliasing in [AntiAliasing::Msaa4, AntiAliasing::Msaa8] {
            let mut options = RenderOptions::default();
            options.cull_back_faces = false;
            options.anti_aliasing = anti_aliasing;
            let mut image = Image::default();
            Renderer::default()
                .draw(&Prepared::new(&mesh), &view, size, size, &options, &mut image)
                .unwrap();
            let positions = anti_aliasing.samples();
            for (k, [x, y]) in samples() {
                let at = |[dx, dy]: [i32; 2]| [x - 128 + dx, y - 128 + dy];
                let hits = positions.iter().filter(|p| covers(corners, at(**p))).count();
                let opacity = 255.0 * hits as f64 / positions.len() as f64;
                prop_assert_eq!(f64::from(image.pixels[k][3]), opacity.round_ties_even());
            }
        }
    }

    #[test]
    fn scan_lines_cover_the_same_and_interpolate_linearly(corners in proptest::array::uniform3(corner())) {
        let plane = |p: FixedPoint| 0.5 + 0.01 * f64::from(p[0]) - 0.003 * f64::from(p[1]);
        let mut covered = vec![false; (SIZE * SIZE) as usize];
        let mut worst = 0.0f64;
        scan_convert(corners, corners.map(|p| [plane(p)]), SIZE, SIZE, |span| {
            for x in span.start..span.end {
                covered[(span.y * SIZE + x) as usize] = true;
                let value = span.values[0] + span.step[0] * f64::from(x - span.start);
                let exact = plane([x * 256 + 128, span.y * 256 + 128]);
                worst = worst.max((value - exact).abs());
            }
        });
        for (k, sample) in samples() {
            prop_assert_eq!(covered[k], covers(corners, sample), "{:?}", sample);
        }
        prop_assert!(worst < 1e-6, "{}", worst);
    }

    /// A fan around a point inside a convex polygon covers what the polygon
    /// covers, each pixel once.
    #[test]
    fn fans_have_no_gaps_and_no_doubles(
        radius in 20.0..60.0f64, count in 3..9usize, turn in 0.0..1.0f64, hub in proptest::array::uniform2(54..74i32), on_samples in any::<bool>(),
    ) {
        let place = |p: DVec2| {
            let p = (p + 64.0) * 256.0;
            let round = |v: f64| if on_samples { (v / 256.0).round() as i32 * 256 + 128 } else { v.round() as i32 };
            [round(p.x), round(p.y)]
        };
        let rim: Vec<FixedPoint> = (0..count)
            .map(|k| place(DVec2::from_angle((k as f64 / count as f64 + turn) * std::f64::consts::TAU) * radius))
            .collect();
        let hub = hub.map(|v| v * 256 + 128);
        let fan: Vec<[FixedPoint; 3]> = (0..count).map(|k| [hub, rim[k], rim[(k + 1) % count]]).collect();
        prop_assume!(fan.iter().all(|t| doubled_area(*t) > 0));
        let view = pixel_view();
        let mut hits = vec![0; (SIZE * SIZE) as usize];
        for triangle in &fan {
            for (hit, drawn) in hits.iter_mut().zip(drawn(Level::best(), &flat_mesh(&[*triangle]), &view, false)) {
                *hit += i32::from(drawn);
            }
        }
        let polygon: Vec<[FixedPoint; 3]> = (2..count).map(|k| [rim[0], rim[k - 1], rim[k]]).collect();
        for (k, sample) in samples() {
            let expected = polygon.iter().any(|t| covers(*t, sample));
            prop_assert_eq!(hits[k], i32::from(expected), "{:?}", sample);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// The two halves of a quadrilateral cover what its other two halves do,
    /// each pixel once; slivers and corners on samples among them.
    #[test]
    fn quads_are_covered_once_whatever_the_diagonal(
        low in proptest::array::uniform2(coordinate()), size in proptest::array::uniform2(1..40_000i32),
        moved in proptest::array::uniform4(proptest::array::uniform2(-60..60i32)),
        thin in any::<bool>(),
    ) {
        let size = if thin { [size[0], size[1] % 300 + 1] } else { size };
        let sides = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let mut quad = [[0; 2]; 4];
        for (k, corner) in quad.iter_mut().enumerate() {
            let inset = [moved[k][0].min(size[0] / 4), moved[k][1].min(size[1] / 4)];
            *corner = [0, 1].map(|axis| low[axis] + sides[k][axis] * size[axis] + inset[axis]);
        }
        let halves = |a: usize| {
            [[quad[a], quad[(a + 1) % 4], quad[(a + 2) % 4]], [quad[a], quad[(a + 2) % 4], quad[(a + 3) % 4]]]
        };
        let (one, other) = (halves(0), halves(1));
        // Convex: both diagonals are inside.
        prop_assume!(one.iter().chain(&other).all(|t| doubled_area(*t) > 0));
        let view = pixel_view();
        let cover = |triangles: &[[FixedPoint; 3]]| drawn(Level::best(), &flat_mesh(triangles), &view, false);
        let whole = cover(&one);
        prop_assert_eq!(&whole, &cover(&other));
        let parts = one.map(|half| cover(&[half]));
        for (k, whole) in whole.into_iter().enumerate() {
            let hits = parts.iter().filter(|part| part[k]).count();
            prop_assert_eq!(hits, usize::from(whole));
        }
    }
}

/// The front faces of a closed convex mesh hit each covered pixel exactly
/// once, in perspective and at any attitude.
#[test]
fn front_faces_of_a_closed_mesh_hit_each_pixel_once() {
    for (level, eye) in [
        (0, DVec3::new(3.0, 1.0, 2.0)),
        (1, DVec3::new(-2.0, 2.5, 0.3)),
        (2, DVec3::new(0.0, -2.0, 1.0)),
        (3, DVec3::new(1.3, 0.4, -1.1)),
    ] {
        let mesh = common::icosphere(DVec3::ZERO, 1.0, level);
        let camera = Camera {
            eye,
            target: DVec3::new(0.1, 0.0, 0.0),
            up: DVec3::Z,
            lens: Lens::Perspective { fov_y: 0.9 },
            near: 0.1,
            far: 10.0,
        };
        let view = camera.view(SIZE as u32, SIZE as u32).unwrap();
        let mut hits = vec![0; (SIZE * SIZE) as usize];
        for triangle in &mesh.triangles {
            let one = Mesh::new(mesh.positions.clone(), vec![*triangle]);
            for (hit, drawn) in hits.iter_mut().zip(drawn(Level::best(), &one, &view, true)) {
                *hit += i32::from(drawn);
            }
        }
        let whole = drawn(Level::best(), &mesh, &view, true);
        assert!(whole.iter().filter(|d| **d).count() > 2_000);
        for (k, hit) in hits.into_iter().enumerate() {
            assert_eq!(hit, i32::from(whole[k]), "level {level}, pixel {k}");
        }
    }
}
