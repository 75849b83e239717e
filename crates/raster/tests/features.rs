//! Edges, sections and shadows: what must be true of them.

use crate::common;
use csg::{Mesh, Mesher, Profile, Program, Solid};
use glam::{DVec3, Vec3};
use raster::{
    AntiAliasing, Camera, EdgeOptions, HiddenEdges, Image, Lens, Light, Prepared, RasterError,
    RenderOptions, Renderer, SectionPlane, StandardView, View, Viewport,
};

const SIZE: u32 = 160;

fn view_of(mesh: &Mesh, view: StandardView, lens: Lens) -> View {
    let camera = Camera::standard(mesh, view, lens, 1.0).unwrap();
    camera.view(SIZE, SIZE).unwrap()
}

fn draw(scene: &Prepared, view: &View, options: &RenderOptions) -> (Renderer, Image) {
    let mut renderer = Renderer::default();
    let mut image = Image::default();
    renderer
        .draw(scene, view, SIZE, SIZE, options, &mut image)
        .unwrap();
    (renderer, image)
}

fn dark(pixel: [u8; 4]) -> bool {
    pixel[3] > 128 && pixel[0] < 90 && pixel[1] < 90 && pixel[2] < 90
}

fn features() -> EdgeOptions {
    let mut edges = EdgeOptions::default();
    edges.width = 2.0;
    edges
}

const UNIT: DVec3 = DVec3::ONE;

#[test]
fn a_cube_has_twelve_feature_edges_and_a_ball_none() {
    let cube = Prepared::new(&common::cuboid(DVec3::ZERO, UNIT));
    assert_eq!(cube.feature_edges().len(), 12);
    let ball = Prepared::new(&common::icosphere(DVec3::ZERO, 1.0, 3));
    assert_eq!(ball.feature_edges().len(), 0);
    // Vertices that are not shared do not hide the neighbours.
    let mut soup = common::cuboid(DVec3::ZERO, UNIT);
    let corners: Vec<DVec3> = (0..soup.triangles.len())
        .flat_map(|t| soup.corners(t))
        .collect();
    soup.triangles = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    soup.positions = corners;
    assert_eq!(Prepared::new(&soup).feature_edges().len(), 12);
    // The mesh's own come first.
    let mut own = common::cuboid(DVec3::ZERO, UNIT);
    own.feature_edges = vec![vec![0, 1, 3]];
    assert_eq!(Prepared::new(&own).feature_edges(), [vec![0, 1, 3]]);
}

/// Rings of a bent tube are facets of one body; its ends are edges, and so is where another body
/// meets it at an angle as small as theirs.
#[test]
fn facets_of_one_body_have_no_edges_between_them() {
    let mesh = |solid: &Solid| {
        let program = Program::lower(solid).unwrap();
        let mesher = Mesher::new().tolerance(1e-3).normals();
        mesher.mesh(&program).unwrap().mesh
    };
    let circle = Profile::circle(0.3).translate([1.0, 0.0]);
    let bend = Solid::revolve_by(&circle, std::f64::consts::FRAC_PI_2);
    let bend = mesh(&bend);
    assert!(bend.surfaces.len() > 20, "{}", bend.surfaces.len());
    let edges = Prepared::new(&bend).feature_edges().to_vec();
    let is_at_an_end = |v: u32| {
        let p = bend.positions[v as usize];
        p.x.abs() < 1e-9 || p.y.abs() < 1e-9
    };
    assert!(edges.len() > 40, "{}", edges.len());
    assert!(edges.iter().flatten().all(|&v| is_at_an_end(v)));
    let ring = mesh(&Solid::revolve(&circle));
    assert_eq!(Prepared::new(&ring).feature_edges(), [[0; 0]; 0]);

    let square = Profile::rectangle([1.0, 1.0]);
    let bar = Solid::extrude(&square, 0.0..2.0);
    let kinked = bar.clone() | bar.rotate_y_degrees(175.0);
    let scene = mesh(&kinked);
    let positions = &scene.positions;
    let scene = Prepared::new(&scene);
    let near = |v: &u32| positions[*v as usize].z.abs() < 0.05;
    let kinks = scene
        .feature_edges()
        .iter()
        .filter(|line| line.iter().all(near));
    // Across two sides where they turn, and around the corners of each bar's end.
    assert!(kinks.count() >= 4);
}

/// Where surfaces are tangent there is no edge, however coarse the triangles;
/// where they meet at a small angle there is a whole one.
#[test]
fn tangent_surfaces_have_no_edge_between_them() {
    let mesh = |solid: &Solid, tolerance: f64| {
        let program = Program::lower(solid).unwrap();
        let mesher = Mesher::new().tolerance(tolerance).normals();
        mesher.mesh(&program).unwrap().mesh
    };
    let rod = Solid::cylinder(0.5, 0.0..2.0);
    let ends = |radius: f64| {
        let ball = Solid::sphere(radius);
        rod.clone() | ball.clone() | ball.translate([0.0, 0.0, 2.0])
    };
    for tolerance in [3e-2, 1e-2, 1e-3] {
        let capsule = mesh(&ends(0.5), tolerance);
        assert_eq!(Prepared::new(&capsule).feature_edges(), [[0; 0]; 0]);
        let swollen = mesh(&ends(0.51), tolerance);
        let scene = Prepared::new(&swollen);
        let mut ends_at = std::collections::HashMap::new();
        for v in scene.feature_edges().iter().flatten() {
            *ends_at.entry(v).or_insert(0) += 1;
        }
        // Two closed circles: as many edges as corners.
        assert!(ends_at.len() > 12, "{}", ends_at.len());
        assert!(ends_at.values().all(|&ends| ends == 2), "{tolerance}");
    }
}

/// The nine visible edges of a cube are dark all along, the three hidden ones
/// not at all, or in dashes.
#[test]
fn visible_edges_are_drawn_and_hidden_ones_are_not() {
    let mesh = common::cuboid(DVec3::ZERO, UNIT);
    let view = view_of(&mesh, StandardView::Iso, Lens::DEFAULT);
    let viewport = Viewport::of_image(SIZE, SIZE);
    let scene = Prepared::new(&mesh);
    let mut options = RenderOptions::default();
    options.edges = Some(features());
    let (_, omitted) = draw(&scene, &view, &options);
    if let Some(edges) = &mut options.edges {
        edges.hidden = HiddenEdges::Dash;
    }
    let (_, dashed) = draw(&scene, &view, &options);
    options.edges = None;
    let (_, without) = draw(&scene, &view, &options);
    // The corner that the viewer, at (1, -1, 1), does not see.
    let hidden_corner = DVec3::new(0.0, 1.0, 0.0);
    for line in scene.feature_edges() {
        let ends = [line[0], line[1]].map(|v| mesh.positions[v as usize]);
        let hidden = ends.contains(&hidden_corner);
        let (mut changed, mut dashes) = (0, 0);
        for step in 2..=18 {
            let at = viewport
                .project(&view, ends[0].lerp(ends[1], f64::from(step) / 20.0))
                .unwrap();
            let (x, y) = (at.x as u32, at.y as u32);
            assert!(
                hidden || dark(omitted.get(x, y).unwrap()),
                "{ends:?} at {x} {y}"
            );
            changed += u32::from(omitted.get(x, y) != without.get(x, y));
            dashes += u32::from(dashed.get(x, y) != without.get(x, y));
        }
        if hidden {
            assert_eq!(changed, 0, "{ends:?}");
            assert!((4..=15).contains(&dashes), "{ends:?}: {dashes}");
        }
    }
}

/// What hides an edge hides it up to the picture's border.
#[test]
fn edges_behind_what_fills_the_picture_are_not_drawn() {
    let ball = common::icosphere(DVec3::ZERO, 1.0, 2);
    let view = view_of(
        &ball,
        StandardView::Front,
        Lens::Orthographic { height: 1.0 },
    );
    // Wider than the picture, in front of a ball that is as large as it.
    let wall = [DVec3::new(-3.0, -0.97, -3.0), DVec3::new(3.0, -0.93, 3.0)];
    let mut mesh = common::cuboid(wall[0], wall[1]);
    let first = mesh.positions.len() as u32;
    mesh.positions
        .extend(&common::icosphere(DVec3::ZERO, 0.92, 2).positions);
    mesh.triangles
        .extend(ball.triangles.iter().map(|t| t.map(|v| first + v)));
    let scene = Prepared::new(&mesh);
    let mut options = RenderOptions::default();
    let (_, without) = draw(&scene, &view, &options);
    let mut edges = features();
    edges.features = false;
    edges.silhouettes = false;
    edges.wireframe = true;
    options.edges = Some(edges);
    // Of the face in front there is only its diagonal.
    let (_, wireframe) = draw(&scene, &view, &options);
    let diagonal = |x: u32, y: u32| x.abs_diff(y) < 4 || (x + y).abs_diff(SIZE - 1) < 4;
    for y in 0..SIZE {
        for x in 0..SIZE {
            let changed = wireframe.get(x, y) != without.get(x, y);
            assert!(!changed || diagonal(x, y), "{x} {y}");
        }
    }
}

/// However thin it is, and however it slopes.
#[test]
fn edges_behind_a_thin_wall_are_not_drawn() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners =
        |size: f64, depth: f64| square.map(|(x, z)| DVec3::new(size * x, depth, size * z));
    let wall = Mesh::new(corners(1.0, 0.0).to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let mut options = RenderOptions::default();
    let mut edges = features();
    edges.wireframe = true;
    options.edges = Some(edges);
    for thickness in [1e-2, 1e-3, 1e-4, 1e-5] {
        let mut both = wall.clone();
        both.positions.extend(corners(0.9, thickness));
        both.positions.push(thickness * DVec3::Y);
        let behind = [[4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]];
        both.triangles.extend(behind);
        for view in [StandardView::Front, StandardView::Iso] {
            for lens in [Lens::Orthographic { height: 2.0 }, Lens::DEFAULT] {
                let view_of_wall = view_of(&wall, view, lens);
                let [alone, before] = [&wall, &both].map(|mesh| {
                    let (_, image) = draw(&Prepared::new(mesh), &view_of_wall, &options);
                    image
                });
                for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
                    let [alone, before] = [&alone, &before].map(|i| dark(i.get(x, y).unwrap()));
                    assert!(alone == before, "{thickness} {view:?} {lens:?} {x} {y}");
                }
            }
        }
    }
}

/// The bottom of a valley is farther away than all around it, and seen.
#[test]
fn edges_between_faces_that_turn_towards_the_viewer_are_drawn() {
    let corner = |x: f64, y: f64| DVec3::new(x, y, y.abs() / 2.0);
    let points = [(0., 0.), (1., 0.), (1., 1.), (0., 1.), (0., -1.), (1., -1.)];
    let positions = points.map(|(x, y)| corner(x, y)).to_vec();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 1]];
    let mut mesh = Mesh::new(positions, triangles);
    mesh.feature_edges = vec![vec![0, 1]];
    for (view, lens) in [
        (StandardView::Top, Lens::Orthographic { height: 1.0 }),
        (StandardView::Iso, Lens::DEFAULT),
    ] {
        let view = view_of(&mesh, view, lens);
        let mut options = RenderOptions::default();
        options.edges = Some(features());
        let (_, image) = draw(&Prepared::new(&mesh), &view, &options);
        let viewport = Viewport::of_image(SIZE, SIZE);
        for step in 1..=19 {
            let along = DVec3::X * (f64::from(step) / 20.0);
            let at = viewport.project(&view, along).unwrap();
            let seen = image.get(at.x as u32, at.y as u32).unwrap();
            assert!(dark(seen), "{at}: {seen:?}");
        }
    }
}

/// A ball's silhouette is the circle that its tangent cone touches.
#[test]
fn silhouettes_are_where_the_surface_turns_away() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 4);
    let view = view_of(&mesh, StandardView::Iso, Lens::Orthographic { height: 1.0 });
    let mut options = RenderOptions::default();
    options.edges = Some(features());
    options.lights = vec![Light::Ambient {
        intensity: Vec3::splat(0.3),
    }];
    let (_, image) = draw(&Prepared::new(&mesh), &view, &options);
    let middle = f64::from(SIZE) / 2.0;
    let radius = middle * 0.9;
    for step in 0..360 {
        let (sin, cos) = f64::from(step).to_radians().sin_cos();
        let at = |r: f64| {
            image
                .get((middle + cos * r) as u32, (middle + sin * r) as u32)
                .unwrap()
        };
        let line = (-2..=2).any(|d| dark(at(radius + 0.5 * f64::from(d))));
        assert!(line, "{step} degrees");
        assert!(
            !dark(at(radius - 6.0)) && at(radius + 4.0)[3] == 0,
            "{step} degrees"
        );
    }
}

/// A box cut in the middle: the cap is flat, hatched, where the plane is.
#[test]
fn a_section_is_capped_at_its_plane() {
    let mesh = common::merge(
        common::cuboid(DVec3::ZERO, UNIT),
        &common::inside_out(common::cuboid(DVec3::splat(0.3), DVec3::splat(0.7))),
    );
    let plane = SectionPlane {
        normal: DVec3::NEG_Y,
        point: DVec3::new(0.0, 0.5, 0.0),
    };
    let scene = Prepared::with_sections(&mesh, &[plane]).unwrap();
    let view = view_of(
        &mesh,
        StandardView::Front,
        Lens::Orthographic { height: 1.0 },
    );
    for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4] {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let (renderer, image) = draw(&scene, &view, &options);
        let normals = renderer.normal_buffer(&scene, &view);
        let (mut on_plane, mut in_hole) = (0, 0);
        let mut shades = std::collections::BTreeSet::new();
        for y in 0..SIZE {
            for x in 0..SIZE {
                let Some(pick) = renderer.pick(&scene, &view, x, y) else {
                    continue;
                };
                let p = pick.point;
                let hole = (0.31..0.69).contains(&p.x) && (0.31..0.69).contains(&p.z);
                let solid = !(0.29..0.71).contains(&p.x) || !(0.29..0.71).contains(&p.z);
                if solid {
                    assert!((p.y - 0.5).abs() < 1e-5, "{p}");
                    assert_eq!(normals.get(x, y), Some(Vec3::NEG_Y));
                    shades.insert(image.get(x, y).unwrap()[0] / 16);
                    on_plane += 1;
                } else if hole {
                    assert!((p.y - 0.7).abs() < 1e-5, "{p}");
                    in_hole += 1;
                }
            }
        }
        let side = f64::from(SIZE) * 0.9;
        assert!(
            (f64::from(on_plane) / (side * side * 0.84) - 1.0).abs() < 0.03,
            "{on_plane}"
        );
        assert!(
            (f64::from(in_hole) / (side * side * 0.38 * 0.38) - 1.0).abs() < 0.05,
            "{in_hole}"
        );
        assert!(shades.len() >= 2, "no hatching");
    }
    // From behind nothing is cut open.
    let behind = view_of(
        &mesh,
        StandardView::Back,
        Lens::Orthographic { height: 1.0 },
    );
    let (renderer, _) = draw(&scene, &behind, &RenderOptions::default());
    let pick = renderer.pick(&scene, &behind, SIZE / 2, SIZE / 2).unwrap();
    assert!((pick.point.y - 1.0).abs() < 1e-5);
}

/// Two planes cut a wedge out of nothing but what both keep.
#[test]
fn several_sections_keep_what_lies_behind_all() {
    let mesh = common::cuboid(DVec3::ZERO, UNIT);
    let planes = [
        SectionPlane {
            normal: DVec3::NEG_Y,
            point: DVec3::splat(0.25),
        },
        SectionPlane {
            normal: DVec3::Z,
            point: DVec3::splat(0.75),
        },
    ];
    let scene = Prepared::with_sections(&mesh, &planes).unwrap();
    let view = view_of(&mesh, StandardView::Iso, Lens::DEFAULT);
    let (renderer, _) = draw(&scene, &view, &RenderOptions::default());
    let (mut front, mut top) = (0, 0);
    for k in 0..SIZE * SIZE {
        let Some(pick) = renderer.pick(&scene, &view, k % SIZE, k / SIZE) else {
            continue;
        };
        let p = pick.point;
        assert!(p.y > 0.25 - 1e-4 && p.z < 0.75 + 1e-4, "{p}");
        front += u32::from((p.y - 0.25).abs() < 1e-4);
        top += u32::from((p.z - 0.75).abs() < 1e-4);
    }
    assert!(front > 1_000 && top > 1_000, "{front} {top}");
    let bad = SectionPlane {
        normal: DVec3::ZERO,
        point: DVec3::ZERO,
    };
    assert!(matches!(
        Prepared::with_sections(&mesh, &[bad]),
        Err(RasterError::BadSection)
    ));
    assert!(Prepared::with_sections(&mesh, &[planes[0]; 5]).is_err());
}

/// Open where nothing is near, darker in a corner.
#[test]
fn occlusion_darkens_corners() {
    let floor = common::cuboid(DVec3::new(-2.0, -2.0, -0.1), DVec3::new(2.0, 2.0, 0.0));
    let mesh = common::merge(floor, &common::cuboid(DVec3::ZERO, UNIT));
    let view = view_of(&mesh, StandardView::Iso, Lens::DEFAULT);
    let scene = Prepared::new(&mesh);
    let (renderer, _) = draw(&scene, &view, &RenderOptions::default());
    let open = renderer.ambient_occlusion(&scene, &view);
    let at = |p: DVec3| {
        let window = Viewport::of_image(SIZE, SIZE).project(&view, p).unwrap();
        open.get(window.x as u32, window.y as u32).unwrap()
    };
    let far = at(DVec3::new(1.0, -1.5, 0.0));
    let corner = at(DVec3::new(0.5, -0.05, 0.0));
    assert!(far > 0.97, "{far}");
    assert!(corner < far - 0.2, "{corner}");
}

/// The shadow lies under the model, fades outwards, and is not seen from
/// below.
#[test]
fn the_ground_shadow_is_under_the_model() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 3);
    let scene = Prepared::new(&mesh);
    let mut options = RenderOptions::default();
    options.ground_shadow = true;
    let camera = Camera {
        eye: DVec3::new(0.0, -8.0, 3.0),
        target: DVec3::new(0.0, 0.0, -0.5),
        up: DVec3::Z,
        lens: Lens::DEFAULT,
        near: 1.0,
        far: 20.0,
    };
    let view = camera.view(SIZE, SIZE).unwrap();
    let (_, image) = draw(&scene, &view, &options);
    let alpha = |p: DVec3| {
        let window = Viewport::of_image(SIZE, SIZE).project(&view, p).unwrap();
        image.get(window.x as u32, window.y as u32).unwrap()[3]
    };
    let near = alpha(DVec3::new(0.0, -0.9, -1.0));
    let rim = alpha(DVec3::new(0.0, -1.05, -1.0));
    assert!(near > rim && rim > 0 && near < 255, "{near} {rim}");
    assert_eq!(alpha(DVec3::new(0.0, -1.8, -1.0)), 0);
    let below = Camera {
        eye: DVec3::new(0.0, -8.0, -3.0),
        ..camera
    };
    let (_, image) = draw(&scene, &below.view(SIZE, SIZE).unwrap(), &options);
    assert!(image.pixels.iter().all(|p| p[3] == 0 || p[3] == 255));
}

/// The triad's axes are drawn in their colours, in their directions.
#[test]
fn the_triad_shows_the_axes() {
    let mesh = common::cuboid(DVec3::ZERO, UNIT);
    let view = view_of(&mesh, StandardView::Front, Lens::DEFAULT);
    let mut options = RenderOptions::default();
    options.triad = true;
    let (_, image) = draw(
        &Prepared::new(&Mesh::new(mesh.positions, vec![])),
        &view,
        &options,
    );
    // From the front X points right and Z up; Y points away.
    let length = f64::from(SIZE) * 0.07;
    let centre = (length * 1.7, f64::from(SIZE) - length * 1.7);
    let right = image
        .get((centre.0 + length * 0.7) as u32, centre.1 as u32)
        .unwrap();
    let up = image
        .get(centre.0 as u32, (centre.1 - length * 0.7) as u32)
        .unwrap();
    assert!(
        right[3] > 100 && right[0] > right[1] && right[0] > right[2],
        "{right:?}"
    );
    assert!(up[3] > 100 && up[2] > up[0] && up[2] > up[1], "{up:?}");
}

/// Anti-aliased edges have the opacity of the area covered.
#[test]
fn multisampling_approaches_the_area_covered() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 4);
    let view = view_of(&mesh, StandardView::Iso, Lens::Orthographic { height: 1.0 });
    let scene = Prepared::new(&mesh);
    let area = |anti_aliasing: AntiAliasing| {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let (_, image) = draw(&scene, &view, &options);
        image
            .pixels
            .iter()
            .map(|p| f64::from(p[3]) / 255.0)
            .collect::<Vec<f64>>()
    };
    let exact = area(AntiAliasing::Supersample(8));
    let error = |mode: AntiAliasing| {
        let squares = area(mode)
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>();
        squares.sqrt()
    };
    let (one, four, eight) = (
        error(AntiAliasing::None),
        error(AntiAliasing::Msaa4),
        error(AntiAliasing::Msaa8),
    );
    assert!(
        four < one * 0.45 && eight < four * 0.8,
        "{one} {four} {eight}"
    );
}
