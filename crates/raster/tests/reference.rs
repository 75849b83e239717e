//! The fast pipeline against the one that is taught.

use crate::common;
use csg::Mesh;
use glam::{DVec2, DVec3, DVec4, Vec3};
use raster::clip::{ClipVertex, PLANES, clip_polygon};
use raster::hidden_surface::{DepthBuffer, Painter};
use raster::{
    Camera, Image, Interpolation, Lens, Light, Prepared, RenderOptions, Renderer, View, Viewport,
    render_reference,
};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

/// A sphere and a box that cut each other, in two colours.
fn scene() -> Mesh {
    common::merge(
        common::colored(common::icosphere(DVec3::ZERO, 1.0, 3), [0.9, 0.4, 0.2]),
        &common::colored(
            flat_normals(common::cuboid(
                DVec3::new(0.2, -0.5, -0.9),
                DVec3::new(1.4, 0.6, 0.3),
            )),
            [0.3, 0.6, 0.9],
        ),
    )
}

fn flat_normals(mut mesh: Mesh) -> Mesh {
    mesh.corner_normals = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            [(b - a).cross(c - a).normalize().as_vec3(); 3]
        })
        .collect();
    mesh
}

fn camera(eye: DVec3, target: DVec3, lens: Lens, near: f64, far: f64) -> View {
    let camera = Camera {
        eye,
        target,
        up: DVec3::Z,
        lens,
        near,
        far,
    };
    camera.view(WIDTH, HEIGHT).unwrap()
}

/// Views from outside and inside, with faces behind the eye, across the near
/// and the far plane, and far beyond the sides.
fn views() -> Vec<(&'static str, View)> {
    let lens = Lens::Perspective { fov_y: 1.0 };
    let wide = Lens::Perspective { fov_y: 2.6 };
    let parallel = Lens::Orthographic { height: 3.0 };
    let cabinet = Lens::Oblique {
        height: 3.0,
        ratio: 0.5,
        angle: 0.8,
    };
    vec![
        (
            "outside",
            camera(DVec3::new(3.0, -2.0, 1.5), DVec3::ZERO, lens, 0.5, 9.0),
        ),
        (
            "no far plane",
            camera(
                DVec3::new(3.0, -2.0, 1.5),
                DVec3::ZERO,
                lens,
                0.5,
                f64::INFINITY,
            ),
        ),
        (
            "inside",
            camera(
                DVec3::new(0.1, 0.2, 0.1),
                DVec3::new(1.0, 0.3, 0.2),
                lens,
                0.01,
                9.0,
            ),
        ),
        (
            "inside, wide",
            camera(
                DVec3::new(0.3, 0.2, -0.1),
                DVec3::new(-1.0, 0.3, 0.2),
                wide,
                0.001,
                9.0,
            ),
        ),
        (
            "across near and far",
            camera(DVec3::new(3.0, -2.0, 1.5), DVec3::ZERO, lens, 3.2, 4.6),
        ),
        (
            "close by",
            camera(
                DVec3::new(1.45, 0.0, 0.1),
                DVec3::new(1.4, 0.4, 0.1),
                wide,
                0.002,
                5.0,
            ),
        ),
        (
            "parallel",
            camera(DVec3::new(3.0, -2.0, 1.5), DVec3::ZERO, parallel, 1.0, 9.0),
        ),
        (
            "cabinet",
            camera(DVec3::new(3.0, -2.0, 0.5), DVec3::ZERO, cabinet, 1.0, 9.0),
        ),
    ]
}

fn options(interpolation: Interpolation, cull: bool) -> RenderOptions {
    let mut options = RenderOptions::default();
    options.interpolation = interpolation;
    options.cull_back_faces = cull;
    options.two_sided = !cull;
    options.lights.push(Light::Point {
        position: DVec3::new(0.5, -2.0, 0.8),
        intensity: Vec3::new(0.5, 0.4, 0.3),
    });
    options
}

/// The least distance in pixels from a sample to the outline of a clipped
/// triangle.
fn distance_to_an_edge(mesh: &Mesh, view: &View, at: DVec2) -> f64 {
    let viewport = Viewport::of_image(WIDTH, HEIGHT);
    let mut least = f64::INFINITY;
    for triangle in &mesh.triangles {
        let mut polygon: Vec<ClipVertex> = triangle
            .iter()
            .map(|&v| ClipVertex {
                position: view.world_to_clip() * mesh.positions[v as usize].extend(1.0),
                weights: [0.0; 3],
            })
            .collect();
        let mut next = Vec::new();
        for plane in PLANES {
            clip_polygon(&polygon, plane, &mut next);
            std::mem::swap(&mut polygon, &mut next);
        }
        let window: Vec<DVec2> = polygon
            .iter()
            .map(|v: &ClipVertex| {
                let p: DVec4 = v.position;
                viewport.from_ndc(p.truncate() / p.w).truncate()
            })
            .collect();
        for (k, a) in window.iter().enumerate() {
            let b = window[(k + 1) % window.len()];
            let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
            least = least.min(at.distance(a.lerp(b, t)));
        }
    }
    least
}

#[test]
fn coverage_depth_and_colour_agree() {
    let mesh = scene();
    let prepared = Prepared::new(&mesh);
    let pixels = (WIDTH * HEIGHT) as usize;
    for (name, view) in views() {
        let planes = common::reversed_depth_planes(&mesh, &view, [WIDTH, HEIGHT]);
        for (interpolation, cull) in [
            (Interpolation::Phong, true),
            (Interpolation::Phong, false),
            (Interpolation::Gouraud, false),
            (Interpolation::Flat, true),
        ] {
            let options = options(interpolation, cull);
            let mut depths = DepthBuffer::new(pixels);
            let expected =
                render_reference(&mesh, &view, WIDTH, HEIGHT, &options, &mut depths).unwrap();
            let mut renderer = Renderer::default();
            let mut image = Image::default();
            renderer
                .draw(&prepared, &view, WIDTH, HEIGHT, &options, &mut image)
                .unwrap();
            let depth = renderer.depth_buffer();
            let ids = renderer.triangle_buffer();
            let (mut covered, mut near_edges) = (0, 0);
            for k in 0..pixels {
                let (a, b) = (image.pixels[k], expected.pixels[k]);
                let same_coverage = a[3] == b[3];
                covered += usize::from(b[3] == 255);
                let depth_units = if b[3] == 255 {
                    (f64::from(depth.values[k]) - depths.depths()[k]).abs() * f64::from(1 << 24)
                } else {
                    0.0
                };
                // Single precision may snap a corner one sub-pixel off, which
                // moves depth by its slope over 1/256 pixel.
                let slope = ids.values[k].map_or(0.0, |id| planes[id as usize].truncate().length());
                let depth_limit = 2.0 + slope * f64::from(1 << 24) / 128.0;
                let colour = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
                if same_coverage && depth_units <= depth_limit && colour <= 1 {
                    continue;
                }
                let at = DVec2::new((k as u32 % WIDTH) as f64, (k as u32 / WIDTH) as f64) + 0.5;
                let distance = distance_to_an_edge(&mesh, &view, at);
                near_edges += 1;
                assert!(
                    distance < 2.0 / 256.0,
                    "{name} {interpolation:?} {cull}: {at}: {a:?} {b:?}, depth off by {depth_units}, {distance} from an edge"
                );
            }
            assert!(
                covered > 500 || name == "inside" && cull || name == "inside, wide" && cull,
                "{name}: {covered}"
            );
            assert!(near_edges * 200 <= pixels, "{name}: {near_edges}");
        }
    }
}

/// The painter's algorithm is right for parts that do not overlap in depth,
/// and wrong where surfaces cut each other.
#[test]
fn the_painter_fails_where_surfaces_cut_each_other() {
    let options = options(Interpolation::Phong, true);
    let different = |mesh: &Mesh| {
        let view = camera(
            DVec3::new(3.0, -2.0, 1.5),
            DVec3::ZERO,
            Lens::DEFAULT,
            0.5,
            9.0,
        );
        let painted = render_reference(mesh, &view, WIDTH, HEIGHT, &options, &mut Painter).unwrap();
        let mut depths = DepthBuffer::new((WIDTH * HEIGHT) as usize);
        let right = render_reference(mesh, &view, WIDTH, HEIGHT, &options, &mut depths).unwrap();
        painted
            .pixels
            .iter()
            .zip(&right.pixels)
            .filter(|(a, b)| a != b)
            .count()
    };
    assert_eq!(different(&common::icosphere(DVec3::ZERO, 1.0, 3)), 0);
    assert!(different(&scene()) > 500);
}

/// A reading of the depth buffer leads back to the point drawn.
#[test]
fn picking_finds_the_point_and_its_triangle() {
    let mesh = scene();
    let prepared = Prepared::new(&mesh);
    for (name, view) in views() {
        if name == "inside, wide" || name == "close by" {
            // Window depth resolves too little this near the eye.
            continue;
        }
        let mut renderer = Renderer::default();
        let options = options(Interpolation::Phong, false);
        renderer
            .draw(
                &prepared,
                &view,
                WIDTH,
                HEIGHT,
                &options,
                &mut Image::default(),
            )
            .unwrap();
        let normals = renderer.normal_buffer(&prepared, &view);
        for y in (0..HEIGHT).step_by(7) {
            for x in (0..WIDTH).step_by(7) {
                let Some(pick) = renderer.pick(&prepared, &view, x, y) else {
                    continue;
                };
                let [a, b, c] = mesh.corners(pick.triangle as usize);
                let plane = (b - a).cross(c - a).normalize();
                assert!((pick.point - a).dot(plane).abs() < 1e-3, "{name} {x} {y}");
                assert_eq!(
                    pick.surface,
                    Some(mesh.triangle_surfaces[pick.triangle as usize])
                );
                let normal = normals.get(x, y).unwrap().as_dvec3();
                assert!(normal.dot(plane) > 0.97 && (normal.length() - 1.0).abs() < 1e-5);
            }
        }
    }
}

/// Reversed depth tells surfaces 1e-4 apart at a distance of 1e3 with the
/// near plane at 0.1 and no far plane.
#[test]
fn reversed_depth_separates_distant_surfaces() {
    let square = |x: f64, colour: [f32; 3]| {
        let mesh = Mesh::new(
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[y, z]| DVec3::new(x, y * 80.0, z * 80.0))
                .to_vec(),
            vec![[0, 1, 2], [0, 2, 3]],
        );
        common::colored(mesh, colour)
    };
    let lens = Lens::Perspective { fov_y: 0.1 };
    let view = camera(
        DVec3::new(1e3, 0.0, 0.0),
        DVec3::ZERO,
        lens,
        0.1,
        f64::INFINITY,
    );
    let front = square(1e-4, [1.0, 0.0, 0.0]);
    let back = square(0.0, [0.0, 0.0, 1.0]);
    for mesh in [
        common::merge(front.clone(), &back),
        common::merge(back, &front),
    ] {
        let mut image = Image::default();
        Renderer::default()
            .draw(
                &Prepared::new(&mesh),
                &view,
                WIDTH,
                HEIGHT,
                &options(Interpolation::Phong, true),
                &mut image,
            )
            .unwrap();
        let red = image
            .pixels
            .iter()
            .filter(|p| p[0] > 0 && p[2] < p[0])
            .count();
        let any = image.pixels.iter().filter(|p| p[3] > 0).count();
        assert_eq!(
            (red, any),
            ((WIDTH * HEIGHT) as usize, (WIDTH * HEIGHT) as usize)
        );
    }
}
