//! What a picture is like if nobody says more.

use crate::common;
use csg::Mesh;
use glam::{DMat3, DVec3};
use raster::{
    AntiAliasing, EdgeOptions, Framing, HiddenEdges, Image, Lens, Prepared, RenderOptions,
    Renderer, SectionPlane, Show, StandardView, View, clear_view,
};

const SIZE: u32 = 160;

fn framing(direction: DVec3, lens: Lens, shadow: bool) -> Framing {
    Framing {
        direction,
        up: DVec3::Z,
        lens,
        aspect: 1.0,
        shadow,
    }
}

fn drawn(mesh: &Mesh, view: &View, options: &RenderOptions) -> Image {
    raster::render(mesh, view, SIZE, SIZE, options).unwrap()
}

/// The shadow lies within the picture: nothing of it is at the border, with
/// either kind of projection and from many sides; and it is there.
#[test]
fn shadows_are_framed() {
    let high = DVec3::new(0.4, 0.3, 3.0);
    for mesh in [
        common::icosphere(DVec3::new(0.0, 0.0, 5.0), 1.0, 3),
        common::cuboid(-high, high),
        common::cuboid(DVec3::ZERO, DVec3::new(3.0, 1.0, 0.2)),
    ] {
        for (turn, lens) in [
            (0.1, Lens::DEFAULT),
            (0.9, Lens::DEFAULT),
            (2.2, Lens::Orthographic { height: 1.0 }),
            (4.0, Lens::Orthographic { height: 1.0 }),
        ] {
            let direction = DVec3::new(f64::cos(turn), f64::sin(turn), -0.7);
            let camera = framing(direction, lens, true).camera(&mesh).unwrap();
            let view = camera.view(SIZE, SIZE).unwrap();
            let mut options = RenderOptions::default();
            let mut draw = |shadow: bool| {
                options.ground_shadow = shadow;
                drawn(&mesh, &view, &options)
            };
            let (with, without) = (draw(true), draw(false));
            let shadow = |image: &Image| image.pixels.iter().filter(|p| p[3] > 8).count();
            assert!(shadow(&with) > shadow(&without) + 50);
            for k in 0..SIZE {
                for (x, y) in [(k, 0), (k, SIZE - 1), (0, k), (SIZE - 1, k)] {
                    let alpha = with.get(x, y).unwrap()[3];
                    assert!(alpha < 4, "{direction} {lens:?}: {alpha} at {x}, {y}");
                }
            }
        }
    }
}

/// On an opaque background there is a shadow as well.
#[test]
fn shadows_darken_backgrounds() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let direction = DVec3::new(-1.0, 1.0, -1.0);
    let camera = framing(direction, Lens::DEFAULT, true)
        .camera(&mesh)
        .unwrap();
    let view = camera.view(SIZE, SIZE).unwrap();
    let mut options = RenderOptions::default();
    options.ground_shadow = true;
    options.background = csg::Color::from_srgb([1.0; 3]);
    let image = drawn(&mesh, &view, &options);
    let grey = |p: &[u8; 4]| p[0] == p[1] && p[1] == p[2] && (150..250).contains(&p[0]);
    assert!(image.pixels.iter().all(|p| p[3] == 255));
    assert!(image.pixels.iter().filter(|p| grey(p)).count() > 300);
    assert_eq!(image.get(0, 0), Some([255; 4]));
}

/// A shadow on nothing, put over white as browsers do, is that on white.
#[test]
fn shadows_look_alike_on_a_page() {
    let mesh = common::icosphere(DVec3::new(0.0, 0.0, 1.5), 1.0, 3);
    let direction = DVec3::new(-1.0, 1.0, -0.8);
    let camera = framing(direction, Lens::DEFAULT, true)
        .camera(&mesh)
        .unwrap();
    let view = camera.view(SIZE, SIZE).unwrap();
    let mut options = RenderOptions::default();
    options.ground_shadow = true;
    let on_nothing = drawn(&mesh, &view, &options);
    options.background = csg::Color::from_srgb([1.0; 3]);
    let on_white = drawn(&mesh, &view, &options);
    let mut shaded = 0;
    for (above, wanted) in on_nothing.pixels.iter().zip(&on_white.pixels) {
        if above[..3] == [0; 3] && above[3] < 255 {
            assert!(
                (255 - above[3]).abs_diff(wanted[0]) <= 1,
                "{above:?} {wanted:?}"
            );
            shaded += usize::from(above[3] > 20);
        }
    }
    assert!(shaded > 300, "{shaded}");
}

/// The share of a box's largest visible face in all that is seen of it, along
/// a direction: its areas times the cosines.
fn largest_share(axes: DMat3, sides: DVec3, direction: DVec3) -> f64 {
    let seen = [0, 1, 2].map(|k| {
        let area = sides[(k + 1) % 3] * sides[(k + 2) % 3];
        area * axes.col(k).dot(direction).abs()
    });
    seen.iter().fold(0.0f64, |m, &v| m.max(v)) / seen.iter().sum::<f64>()
}

fn turned_box(axes: DMat3, sides: DVec3) -> Mesh {
    let mut mesh = common::cuboid(-sides / 2.0, sides / 2.0);
    for p in &mut mesh.positions {
        *p = axes * *p;
    }
    mesh
}

#[test]
fn no_face_hides_the_rest() {
    let iso = StandardView::Iso.direction_and_up().0;
    let cube = common::cuboid(DVec3::ZERO, DVec3::ONE);
    assert!(clear_view(&cube, &[]).angle_between(iso) < 1e-7);
    // One face, or one edge, exactly towards the isometric viewer.
    let x = -iso;
    for roll in [0.0, 0.4, 1.1] {
        let axes = DMat3::from_axis_angle(x, roll)
            * DMat3::from_cols(
                x,
                x.any_orthonormal_vector(),
                x.cross(x.any_orthonormal_vector()),
            );
        let sides = DVec3::new(1.0, 1.3, 0.8);
        assert!(largest_share(axes, sides, iso) > 0.99);
        let direction = clear_view(&turned_box(axes, sides), &[]);
        let share = largest_share(axes, sides, direction);
        assert!(share < 0.9, "{roll}: {share}");
    }
}

#[test]
fn cuts_face_the_viewer() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 2);
    for normal in [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::NEG_X,
        DVec3::NEG_Y,
        DVec3::NEG_Z,
        DVec3::new(-1.0, 2.0, 0.5),
    ] {
        let plane = SectionPlane {
            normal,
            point: DVec3::ZERO,
        };
        let direction = clear_view(&mesh, &[plane]);
        assert!(direction.dot(normal) < 0.0, "{normal}: {direction}");
    }
    let planes = [DVec3::Y, DVec3::NEG_X].map(|normal| SectionPlane {
        normal,
        point: DVec3::ZERO,
    });
    let direction = clear_view(&mesh, &planes);
    assert!(planes.iter().all(|p| direction.dot(p.normal) < 0.0));
}

/// Pictures of depth, normals, surfaces and openness are smooth where one is
/// asked for: pixels at an outline are covered in part.
#[test]
fn other_outputs_are_smoothed() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
    let direction = DVec3::new(-1.0, 1.3, -0.8);
    let camera = framing(direction, Lens::DEFAULT, false)
        .camera(&mesh)
        .unwrap();
    let view = camera.view(SIZE, SIZE).unwrap();
    let scene = Prepared::new(&mesh);
    for show in [Show::Depth, Show::Normals, Show::Surfaces, Show::Occlusion] {
        let partial = [AntiAliasing::None, AntiAliasing::Msaa4, AntiAliasing::Msaa8].map(|mode| {
            let mut options = RenderOptions::default();
            options.anti_aliasing = mode;
            let mut image = Image::default();
            Renderer::default()
                .draw_shown(&scene, &view, SIZE, SIZE, &options, show, &mut image)
                .unwrap();
            assert_eq!((image.width, image.height), (SIZE, SIZE));
            image
                .pixels
                .iter()
                .filter(|p| p[3] > 0 && p[3] < 255)
                .count()
        });
        assert_eq!(partial[0], 0, "{show:?}");
        assert!(
            partial[1] > 200 && partial[2] > partial[1],
            "{show:?}: {partial:?}"
        );
    }
}

/// Hidden lines that cross each other all over are fainter than a few.
#[test]
fn many_hidden_lines_are_faint() {
    let darkness = |count: u32| {
        let mut mesh = common::cuboid(DVec3::ZERO, DVec3::ONE);
        for k in 0..count {
            let at = f64::from(k + 1) / f64::from(count + 1);
            let low = DVec3::new(at - 0.004, 0.3, 0.1);
            let rod = common::cuboid(low, low + DVec3::new(0.008, 0.2, 0.8));
            mesh = common::merge(mesh, &rod);
        }
        let lens = Lens::Orthographic { height: 1.0 };
        let camera = framing(DVec3::Y, lens, false).camera(&mesh).unwrap();
        let view = camera.view(SIZE, SIZE).unwrap();
        let mut options = RenderOptions::default();
        let mut image_of = |hidden: HiddenEdges| {
            let mut edges = EdgeOptions::default();
            edges.hidden = hidden;
            options.edges = Some(edges);
            drawn(&mesh, &view, &options)
        };
        let (dashed, omitted) = (image_of(HiddenEdges::Dash), image_of(HiddenEdges::Omit));
        let pairs = dashed.pixels.iter().zip(&omitted.pixels);
        let darker = pairs.map(|(a, b)| f64::from(b[0].saturating_sub(a[0])));
        let lines: Vec<f64> = darker.filter(|&d| d > 0.0).collect();
        lines.iter().sum::<f64>() / lines.len() as f64
    };
    let (few, many) = (darkness(2), darkness(40));
    assert!(few > 15.0, "{few}");
    assert!(many < few / 2.0, "{many} of {few}");
}
