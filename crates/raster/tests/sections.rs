//! Several section planes together, held against the solid itself: at every
//! pixel the first point of the ray in what is left, or none.

use crate::common;
use csg::{Color, Mesh};
use glam::{DVec2, DVec3, Vec3};
use proptest::prelude::*;
use raster::{
    AntiAliasing, Camera, Image, Lens, Level, Light, Prepared, RenderOptions, Renderer,
    SectionPlane, View, Viewport,
};

const SIZE: u32 = 48;

/// A cube of side 2 around the origin with a hollow of this half-side, if any,
/// cut by planes.
#[derive(Debug)]
struct Solid {
    hollow: Option<f64>,
    planes: Vec<SectionPlane>,
}

impl Solid {
    fn mesh(&self) -> Mesh {
        let cube = common::cuboid(DVec3::NEG_ONE, DVec3::ONE);
        let Some(half) = self.hollow else { return cube };
        let hollow = common::cuboid(DVec3::splat(-half), DVec3::splat(half));
        common::merge(cube, &common::inside_out(hollow))
    }

    /// The first parameter in 0..1 at which `from` + t (`to` - `from`) is in
    /// the solid.
    fn first(&self, from: DVec3, to: DVec3) -> Option<f64> {
        let mut range = [0.0, 1.0];
        for plane in &self.planes {
            clip(&mut range, plane.normal, plane.point, from, to);
        }
        clip_to_cube(&mut range, 1.0, from, to);
        if let Some(half) = self.hollow {
            let mut hollow = [0.0, 1.0];
            clip_to_cube(&mut hollow, half, from, to);
            if hollow[0] <= range[0] && range[0] < hollow[1] {
                range[0] = hollow[1];
            }
        }
        (range[0] < range[1]).then_some(range[0])
    }
}

/// Whether a ray meets the outside and the hollow of the cube before it is cut.
fn meets(solid: &Solid, from: DVec3, to: DVec3) -> [bool; 2] {
    [1.0, solid.hollow.unwrap_or_default()].map(|half| {
        let mut range = [0.0, 1.0];
        clip_to_cube(&mut range, half, from, to);
        range[0] < range[1]
    })
}

/// Cuts a range of a ray's parameter to the half-space behind a plane.
fn clip(range: &mut [f64; 2], normal: DVec3, point: DVec3, from: DVec3, to: DVec3) {
    let (start, change) = (normal.dot(from - point), normal.dot(to - from));
    let crossing = -start / change;
    if change < 0.0 {
        range[0] = range[0].max(crossing);
    } else if change > 0.0 {
        range[1] = range[1].min(crossing);
    } else if start > 0.0 {
        range[1] = range[0];
    }
}

fn clip_to_cube(range: &mut [f64; 2], half: f64, from: DVec3, to: DVec3) {
    for normal in [DVec3::X, DVec3::Y, DVec3::Z] {
        for normal in [normal, -normal] {
            clip(range, normal, normal * half, from, to);
        }
    }
}

fn draw(level: Level, scene: &Prepared, view: &View, options: &RenderOptions) -> (Renderer, Image) {
    let mut renderer = Renderer::with_level(level);
    let mut image = Image::default();
    renderer
        .draw(scene, view, SIZE, SIZE, options, &mut image)
        .unwrap();
    (renderer, image)
}

/// A depth that changes by more within a hundredth of a pixel is that of
/// different faces.
const EDGE: f64 = 0.02;

/// Holds every pixel against the solid, but for those that an edge, be it cut
/// away or not, passes within a hundredth of a pixel or, with several samples,
/// within a pixel. Returns how many pixels showed a cap.
fn check(solid: &Solid, view: &View) -> usize {
    let scene = Prepared::with_sections(&solid.mesh(), &solid.planes).unwrap();
    let viewport = Viewport::of_image(SIZE, SIZE);
    let rays = |x: u32, y: u32, reach: f64| {
        let offsets = [
            (0.0, 0.0),
            (-1.0, -1.0),
            (-1.0, 1.0),
            (1.0, -1.0),
            (1.0, 1.0),
        ];
        offsets.map(|(dx, dy)| {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let offset = DVec2::new(dx, dy) * reach;
            viewport.ray(view, centre + offset).unwrap()
        })
    };
    let truth_of = |rays: [(DVec3, DVec3); 5]| {
        rays.map(|(near, far)| Some(near.lerp(far, solid.first(near, far)?)))
    };
    let options = RenderOptions::default();
    let (renderer, image) = draw(Level::default(), &scene, view, &options);
    let mut multisampled = RenderOptions::default();
    multisampled.anti_aliasing = AntiAliasing::Msaa4;
    let (_, smooth) = draw(Level::default(), &scene, view, &multisampled);
    let mut caps = 0;
    for (x, y) in (0..SIZE * SIZE).map(|k| (k % SIZE, k / SIZE)) {
        let close = rays(x, y, 0.01);
        let met = close.map(|(near, far)| meets(solid, near, far));
        if met.iter().any(|m| *m != met[0]) {
            continue;
        }
        let truth = truth_of(close);
        let shown = renderer.pick(&scene, view, x, y);
        if truth.iter().all(Option::is_none) {
            assert_eq!(shown, None, "({x}, {y}) shows what is not there");
            assert_eq!(image.get(x, y).unwrap()[3], 0);
        } else if let Some(truth) = truth.iter().copied().collect::<Option<Vec<DVec3>>>() {
            let point = shown
                .unwrap_or_else(|| panic!("a hole at ({x}, {y})"))
                .point;
            let spread = truth.iter().map(|p| p.distance(truth[0]));
            let spread = spread.fold(0.0, f64::max);
            let error = point.distance(truth[0]);
            assert!(
                spread > EDGE || error <= 1e-4 + spread,
                "({x}, {y}): {point} for {}",
                truth[0]
            );
            let on = |p: &SectionPlane| (p.normal.dot(truth[0] - p.point)).abs() < 1e-9;
            caps += usize::from(solid.planes.iter().any(on));
        }
        let truth = truth_of(rays(x, y, 1.0));
        let alpha = smooth.get(x, y).unwrap()[3];
        // No edge passes between: what is left of the cube is convex.
        if solid.hollow.is_none() && truth.iter().all(Option::is_some) {
            assert_eq!(alpha, 255, "a hole in a sample of ({x}, {y})");
        }
    }
    for options in [options, multisampled] {
        let (_, portable) = draw(Level::PORTABLE, &scene, view, &options);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        let (_, alone) = pool.install(|| draw(Level::default(), &scene, view, &options));
        assert!(portable == alone);
    }
    caps
}

fn view(mesh: &Mesh, direction: DVec3, lens: Lens) -> View {
    let camera = Camera::framing(mesh, direction, DVec3::Z, lens, 1.0).unwrap();
    camera.view(SIZE, SIZE).unwrap()
}

const LENSES: [Lens; 2] = [Lens::DEFAULT, Lens::Orthographic { height: 1.0 }];

/// A ray that enters by one cut and leaves by the other meets no face at all.
#[test]
fn a_quarter_taken_out_leaves_no_hole_in_the_caps() {
    let plane = |normal: DVec3| SectionPlane {
        normal,
        point: DVec3::ZERO,
    };
    for normals in [
        &[DVec3::NEG_Y, DVec3::NEG_X][..],
        &[DVec3::NEG_Y, DVec3::X],
        &[DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
        &[
            DVec3::NEG_Y,
            DVec3::X,
            DVec3::NEG_Z,
            DVec3::new(1.0, 0.3, 1.0),
        ],
    ] {
        for hollow in [None, Some(0.5)] {
            let planes = normals.iter().map(|n| plane(*n)).collect();
            let solid = Solid { hollow, planes };
            for lens in LENSES {
                let view = view(&solid.mesh(), DVec3::new(-1.0, 1.0, -1.0), lens);
                assert!(check(&solid, &view) > 50);
            }
        }
    }
}

/// Draws a box with something in its middle, cut by a plane across z, from above,
/// and compares the colours beside it, in its wall and in its middle.
fn check_seen_through(
    mesh: &Mesh,
    normal: DVec3,
    height: f64,
    at_wall: &[([f32; 3], f32)],
    at_middle: &[([f32; 3], f32)],
) {
    let view = Camera::looking_at(DVec3::Z * 10.0, DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.0 })
        .view(SIZE, SIZE)
        .unwrap();
    let point = DVec3::Z * height;
    let scene = Prepared::with_sections(mesh, &[SectionPlane { normal, point }]).unwrap();
    for (anti_aliasing, culls) in [
        (AntiAliasing::None, true),
        (AntiAliasing::Msaa4, false),
        (AntiAliasing::Msaa8, true),
    ] {
        let mut options = RenderOptions::default().anti_aliasing(anti_aliasing);
        options.cull_back_faces = culls;
        options.lights = vec![Light::Ambient {
            intensity: Vec3::ONE,
        }];
        options.cap_color = Some(Color::from_linear([0.0; 3]));
        let (_, image) = draw(Level::default(), &scene, &view, &options);
        let found = [2, 9, 19].map(|x| image.get(x, 25).unwrap());
        let wanted = [&[][..], at_wall, at_middle].map(common::blended);
        let off = found.as_flattened().iter().zip(wanted.as_flattened());
        let off = off.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(
            off <= Some(1),
            "{normal} {height} {anti_aliasing:?}: {found:?} {wanted:?}"
        );
    }
}

fn with_alpha(mesh: Mesh, srgb: [f32; 3], alpha: f32) -> Mesh {
    let mut mesh = common::colored(mesh, srgb);
    let surface = &mut mesh.surfaces[0];
    surface.color = surface.color.map(|color| color.with_alpha(alpha));
    mesh
}

/// A box with a hollow cut at half its height, seen from above: the cut is as
/// opaque as the box, and through the hollow one sees the hollow's floor and the box's. A
/// cut that meets nothing changes nothing; one from below leaves what is above
/// it.
#[test]
fn cut_solids_are_seen_through() {
    // (Hatching leaves black as it is.)
    let [red, black, blue] = [[1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]];
    let outside = common::cuboid(DVec3::splat(-0.75), DVec3::splat(0.75));
    let hollow = common::inside_out(common::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5)));
    let (glass, lining, cut) = ((red, 0.5), (blue, 0.5), (black, 0.5));
    for (normal, height, opacity, at_wall, at_hollow) in [
        (DVec3::Z, 0.0, 0.5, &[cut, glass][..], &[lining, glass][..]),
        (DVec3::Z, 0.0, 1.0, &[cut, glass], &[(blue, 1.0)]),
        // Below the hollow.
        (DVec3::Z, -0.6, 0.5, &[cut, glass], &[cut, glass]),
        (
            DVec3::Z,
            2.0,
            0.5,
            &[glass, glass],
            &[glass, lining, lining, glass],
        ),
        (DVec3::NEG_Z, 0.0, 0.5, &[glass], &[glass, lining]),
    ] {
        let hollow = with_alpha(hollow.clone(), blue, opacity);
        let mesh = common::merge(with_alpha(outside.clone(), red, 0.5), &hollow);
        check_seen_through(&mesh, normal, height, at_wall, at_hollow);
    }
}

/// An opaque block within glass: where it is cut the cap is opaque, and it is
/// seen through the cap of the glass above it. Glass within glass of another
/// opacity, and within an opaque block.
#[test]
fn caps_have_the_opacity_of_what_is_cut() {
    let [red, black, blue] = [[1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]];
    let (glass, cut) = ((red, 0.5), (black, 0.5));
    let outside = common::cuboid(DVec3::splat(-0.75), DVec3::splat(0.75));
    let inside = common::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let block = with_alpha(inside.clone(), blue, 1.0);
    let mesh = common::merge(with_alpha(outside.clone(), red, 0.5), &block);
    check_seen_through(&mesh, DVec3::Z, 0.0, &[cut, glass], &[(black, 1.0)]);
    check_seen_through(&mesh, DVec3::Z, 0.6, &[cut, glass], &[cut, (blue, 1.0)]);
    let clear = with_alpha(inside, blue, 0.25);
    let mesh = common::merge(with_alpha(outside.clone(), red, 0.5), &clear);
    let beyond = [(black, 0.25), (blue, 0.25), glass];
    check_seen_through(&mesh, DVec3::Z, 0.0, &[cut, glass], &beyond);
    let mesh = common::merge(with_alpha(outside, red, 1.0), &clear);
    check_seen_through(&mesh, DVec3::Z, 0.0, &[(black, 1.0)], &[(black, 1.0)]);
}

fn vector() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0f64]
        .prop_map(DVec3::from_array)
        .prop_filter("too short", |v| v.length() > 0.1)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn several_planes_show_what_is_left(
        planes in prop::collection::vec((vector(), vector()), 1..=4),
        hollow in prop::option::of(0.2..0.8f64),
        direction in vector(),
        lens in prop::sample::select(&LENSES[..]),
    ) {
        let planes = planes.into_iter().map(|(normal, point)| SectionPlane {
            normal,
            point: point * 0.7,
        });
        let solid = Solid { hollow, planes: planes.collect() };
        check(&solid, &view(&solid.mesh(), direction, lens));
    }
}

/// A tetrahedron with the outside of its faces on the right side.
fn tetrahedron(corners: [DVec3; 4]) -> Mesh {
    let mut triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let [a, b, c, d] = corners;
    if (b - a).cross(c - a).dot(d - a) > 0.0 {
        for triangle in &mut triangles {
            triangle.swap(1, 2);
        }
    }
    Mesh::new(corners.to_vec(), triangles)
}

/// How far a point is outside of the plane of a convex mesh's face, at most.
fn outside(mesh: &Mesh, point: DVec3) -> f64 {
    let planes = (0..mesh.triangles.len()).map(|face| {
        let [a, b, c] = mesh.corners(face);
        (b - a).cross(c - a).normalize().dot(point - a)
    });
    planes.fold(f64::NEG_INFINITY, f64::max)
}

/// The middle of a pixel, at some depth.
fn on_sample() -> impl Strategy<Value = DVec3> {
    let last = f64::from(SIZE) / 2.0;
    (2..SIZE - 2, 2..SIZE - 2, -20.0..20.0f64).prop_map(move |(x, y, z)| {
        let [x, y] = [x, y].map(|pixel| f64::from(pixel) + 0.5 - last);
        DVec3::new(x, y, z)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Silhouettes whose ends lie exactly on samples pass exactly through
    /// others, where the front and the back of the solid are at one depth. What
    /// is seen there is a point of the solid, not of the plane beside it.
    #[test]
    fn no_cap_beside_silhouettes_that_pass_through_samples(
        corners in proptest::array::uniform4(on_sample()),
        normal in vector().prop_map(|v| DVec3::new(v.x, v.y, v.z.abs() + 0.5)),
        share in 0.1..0.9f64,
    ) {
        let [a, b, c, d] = corners;
        prop_assume!((b - a).cross(c - a).dot(d - a).abs() > 50.0);
        let mesh = tetrahedron(corners);
        let plane = SectionPlane { normal, point: a.lerp(b, share) };
        let scene = Prepared::with_sections(&mesh, &[plane]).unwrap();
        let camera = Camera {
            eye: DVec3::Z * 100.0,
            target: DVec3::ZERO,
            up: DVec3::Y,
            lens: Lens::Orthographic { height: f64::from(SIZE) },
            near: 1.0,
            far: 200.0,
        };
        let view = camera.view(SIZE, SIZE).unwrap();
        let (renderer, _) = draw(Level::default(), &scene, &view, &RenderOptions::default());
        for (x, y) in (0..SIZE * SIZE).map(|k| (k % SIZE, k / SIZE)) {
            if let Some(pick) = renderer.pick(&scene, &view, x, y) {
                let away = outside(&mesh, pick.point);
                prop_assert!(away < 0.05, "({x}, {y}) shows {} at {away}", pick.point);
            }
        }
    }
}
