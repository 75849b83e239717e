//! What faces, loops, edges and vertices there are.

use csg::brep::{CurveShape, Face};
use csg::glam::{DVec2, DVec3};
use csg::{
    BoundaryOptions, CancelToken, Error, Limits, Mesher, Profile, Program, Solid, SurfaceShape,
};
use stereotomy::csg;

use super::boundary;
use super::sound::assert_sound;
use crate::random::Random;

/// Shells, faces, loops, edges, vertices.
fn counts(solid: &Solid) -> [usize; 5] {
    let brep = boundary(solid).expect("a boundary");
    let program = Program::lower(solid).expect("valid");
    assert_eq!(assert_sound(&brep, &program, "counted"), 0.0);
    [
        brep.shells().len(),
        brep.faces().len(),
        brep.loops().len(),
        brep.edges().len(),
        brep.vertices().len(),
    ]
}

#[test]
fn faces_are_as_a_drawing_has_them() {
    let cube = Solid::cube(2.0);
    let rod = Solid::cylinder(0.5, -2.0..2.0);
    assert_eq!(counts(&cube), [1, 6, 6, 12, 8]);
    assert_eq!(counts(&Solid::sphere(1.0)), [1, 1, 0, 0, 0]);
    assert_eq!(counts(&rod), [1, 3, 4, 2, 0]);
    assert_eq!(counts(&Solid::cone(1.0, 0.0..1.0)), [1, 2, 2, 1, 0]);
    assert_eq!(counts(&(&cube - &rod)), [1, 7, 10, 14, 8]);
    assert_eq!(counts(&(&cube | &rod)), [1, 10, 14, 16, 8]);
    assert_eq!(counts(&(&cube - Solid::sphere(0.5))), [2, 7, 6, 12, 8]);
    // Two cylinders of one radius meet in two ellipses that cross twice.
    let cross = &rod & rod.rotate_x(std::f64::consts::FRAC_PI_2);
    assert_eq!(counts(&cross), [1, 4, 4, 4, 2]);
}

#[test]
fn faces_of_one_plane_that_look_alike_are_one() {
    let cube = Solid::cube(1.0);
    let beside = cube.translate([1.0, 0.0, 0.0]);
    assert_eq!(counts(&(&cube | &beside)), [1, 6, 6, 12, 8]);
    let named = cube.clone().named("left") | beside.named("right");
    assert_eq!(counts(&named), [1, 10, 10, 20, 12]);
    // Two faces of one plane, each in its place.
    let posts = Solid::cuboid([4.0, 4.0, 1.0])
        | Solid::cube(1.0).translate([1.0, 1.0, 1.0])
        | Solid::cube(1.0).translate([-1.0, -1.0, 1.0]);
    assert_eq!(counts(&posts), [1, 16, 18, 36, 24]);
    // A hole with an island in it, whose hole has an island, and so on.
    let ring = |r: f64| Solid::cylinder(r, 0.0..1.0) - Solid::cylinder(r - 0.5, -1.0..2.0);
    let rings = Solid::union([ring(1.0), ring(2.0), ring(3.0)]);
    assert_eq!(counts(&rings), [3, 12, 24, 12, 0]);
}

#[test]
fn where_a_solid_touches_itself_parts_keep_their_own_edges() {
    let cube = Solid::cube(1.0);
    let edge = &cube | cube.translate([1.0, 1.0, 0.0]);
    assert_eq!(counts(&edge), [2, 12, 12, 24, 16]);
    let corner = &cube | cube.translate([1.0, 1.0, 1.0]);
    assert_eq!(counts(&corner), [2, 12, 12, 24, 16]);
    let rod = Solid::cylinder(0.5, -2.0..2.0);
    let side_by_side = &rod | rod.translate([1.0, 0.0, 0.0]);
    assert_eq!(counts(&side_by_side), [2, 6, 8, 4, 0]);
    // A ball on a plate.
    let plate = Solid::cuboid([4.0, 4.0, 1.0]);
    let ball = Solid::sphere(1.0).translate([0.0, 0.0, 1.5]);
    assert_eq!(counts(&(plate | ball)), [2, 7, 6, 12, 8]);
    // A disc on the ridge of a ring, which slits its face.
    let ring = Solid::frustum(2.0, 1.0, 0.0..1.0) - Solid::cylinder(1.0, 0.0..1.0);
    let disc = Solid::cylinder(2.0, 1.0..2.0);
    assert_eq!(counts(&(ring | disc)), [2, 6, 10, 5, 0]);
}

/// Lathe parts out of blocks and rods: steps and tapers on a grid touch each other, and the rod, along
/// circles.
#[test]
fn lathe_parts_have_the_topology_of_their_meshes() {
    let mut touching = 0;
    for seed in 0..150 {
        let mut random = Random::new(seed);
        let mut grid = |most: u64| random.below(most) as f64;
        let bore = 0.5 * (1.0 + grid(2));
        let mut corners = vec![DVec2::new(bore, 0.0)];
        let mut height = 0.0;
        for _ in 0..4 {
            let radius = bore + 1.0 + grid(3);
            corners.push(DVec2::new(radius, height));
            height += grid(2) + 0.5 * grid(2);
            corners.push(DVec2::new(radius, height));
        }
        corners.push(DVec2::new(bore, height + grid(2)));
        let tool = Solid::revolve(&Profile::polygon(corners));
        let (block, rod) = (
            Solid::cuboid([7.0, 7.0, 3.0]),
            Solid::cylinder(4.0, 0.0..3.5),
        );
        let solid = match seed % 3 {
            0 => block - tool,
            1 => rod - tool,
            _ => tool | (Solid::cylinder(2.0, 1.0..2.0) - Solid::cylinder(1.0, 1.0..2.0)),
        };
        let Ok(program) = Program::lower(&solid) else {
            continue;
        };
        let brep = boundary(&solid).expect("a boundary");
        let meshed = Mesher::new()
            .tolerance(0.05)
            .mesh(&program)
            .expect("a mesh");
        assert!(meshed.report.is_proven(), "seed {seed}");
        let check = meshed.mesh.check();
        let genera: usize = brep.shells().map(|shell| shell.genus()).sum();
        let found = (brep.shells().len(), genera);
        let genus = check.genus().expect("manifold") as usize;
        assert_eq!(found, (check.components, genus), "seed {seed}");
        touching += usize::from(check.components > 1);
    }
    assert!(touching >= 20, "{touching}");
}

#[test]
fn faces_cut_at_seams_have_charts() {
    let ball = |x| Solid::sphere(1.0).translate([x, 0.0, 0.0]);
    let cut_ball = ball(6.0) & Solid::half_space([0.1, 0.2, 1.0], 0.8);
    let solid = Solid::cylinder(1.0, -1.0..1.0) | ball(3.0) | cut_ball;
    let program = Program::lower(&solid).expect("valid");
    let options = BoundaryOptions::new().cut_at_seams();
    let brep = program.boundary(&options).expect("a boundary");
    assert_sound(&brep, &program, "cut");
    let is_ball = |face: &Face<'_>| matches!(face.surface().shape(), SurfaceShape::Sphere { .. });
    let (balls, others): (Vec<_>, Vec<_>) = brep.faces().partition(is_ball);
    let (whole, octants): (Vec<_>, Vec<_>) = balls
        .into_iter()
        .partition(|face| face.meridian().is_some());
    // A wall and two ends, and the plane; a whole ball; eight octants.
    assert_eq!(brep.shells().len(), 3);
    assert_eq!([others.len(), whole.len(), octants.len()], [4, 1, 8]);
    let [pole, middle] = whole[0].meridian().expect("a meridian");
    for edge in whole[0].edges() {
        let [from, to] = edge.range();
        let off = edge.at(0.5 * (from + to)) - DVec3::new(3.0, 0.0, 0.0);
        assert!(off.dot(middle) > 0.0 && off.dot(pole.cross(middle)).abs() < 1e-12);
    }
    for face in octants {
        let view = face.view();
        for at in face.points() {
            assert!(face.normal(at).dot(view).abs() > 0.5, "{at}");
        }
    }
    // The wall is on both sides of one line, the whole ball of half a circle.
    let seams = brep.edges().filter(|edge| {
        let [one, other] = edge.faces();
        one == other
    });
    let seams: Vec<_> = seams.map(|edge| is_ball(&edge.faces()[0])).collect();
    assert_eq!(seams.iter().filter(|&&is_ball| !is_ball).count(), 1);
    assert!(seams.contains(&true));
    // A quarter of it is not cut.
    let quarter = Solid::cylinder(1.0, -1.0..1.0) & Solid::cuboid_between([0.0; 3], [2.0; 3]);
    for turn in 0..8 {
        let turned = quarter.rotate_z(0.7 * f64::from(turn));
        let program = Program::lower(&turned).expect("valid");
        let cut = program.boundary(&options).expect("a boundary");
        assert_eq!((cut.faces().len(), cut.edges().len()), (5, 9));
    }
    let whole = boundary(&solid).expect("a boundary").measure();
    let cut = brep.measure();
    assert!((whole.volume.value - cut.volume.value).abs() < 1e-13);
}

#[test]
fn curves_are_called_by_their_names() {
    let edges = |solid: &Solid| {
        let brep = boundary(solid).expect("a boundary");
        let curved = brep.edges().filter(|edge| {
            let [one, other] = edge.faces();
            !(one.surface().is_plane() && other.surface().is_plane())
        });
        curved.map(|edge| edge.curve()).collect::<Vec<_>>()
    };
    let cone = Solid::cone(1.0, 0.0..2.0);
    for (name, plane, is_wanted) in [
        (
            "circle",
            Solid::half_space([0.0, 0.0, 1.0], 1.0),
            (|curve| {
                matches!(curve, CurveShape::Ellipse { a, b, .. }
                if (a.length() - b.length()).abs() < 1e-14)
            }) as fn(&CurveShape) -> bool,
        ),
        (
            "hyperbola",
            Solid::half_space([1.0, 0.0, 0.0], 0.3),
            |curve| matches!(curve, CurveShape::Hyperbola { .. }),
        ),
        (
            "rulings",
            Solid::half_space([1.0, 0.0, 0.0], 0.0),
            |curve| matches!(curve, CurveShape::Line { .. }),
        ),
    ] {
        let found = edges(&(&cone & plane));
        assert!(found.iter().any(is_wanted), "{name}: {found:?}");
    }
    let bore = Solid::cylinder(1.0, -2.0..2.0)
        - Solid::cylinder(0.5, -2.0..2.0).rotate_x(std::f64::consts::FRAC_PI_2);
    let quartics = edges(&bore)
        .into_iter()
        .filter(|curve| *curve == CurveShape::Quartic);
    assert_eq!(quartics.count(), 2);
}

#[test]
fn names_of_faces_are_those_of_their_primitives() {
    let solid = Solid::cube(2.0).named("block") - Solid::cylinder(0.5, -2.0..2.0).named("bore");
    let brep = boundary(&solid).expect("a boundary");
    for face in brep.faces() {
        let name = face.origin().name.as_deref();
        assert_eq!(
            name,
            Some(if face.surface().is_plane() {
                "block"
            } else {
                "bore"
            })
        );
    }
}

#[test]
fn what_cannot_be_had_is_an_error() {
    let ball = Program::lower(&Solid::sphere(1.0)).expect("valid");
    let endless = Program::lower(&Solid::half_space([0.0, 0.0, 1.0], 0.0)).expect("valid");
    let options = BoundaryOptions::new();
    assert!(matches!(
        endless.boundary(&options),
        Err(Error::Unbounded { .. })
    ));
    for distance in [-1.0, f64::NAN, f64::INFINITY] {
        let result = ball.boundary(&options.clone().most_moved(distance));
        assert!(matches!(result, Err(Error::InvalidOption(_))), "{distance}");
    }
    let token = CancelToken::new();
    token.cancel();
    let result = ball.boundary(&options.clone().cancel_token(token));
    assert!(matches!(result, Err(Error::Cancelled)));
    let many = Program::lower(&stereotomy::scenes::cheese(1000)).expect("valid");
    let result = many.boundary(&options.limits(Limits::new().cells(10)));
    assert!(matches!(result, Err(Error::LimitReached(_))));
}

#[test]
fn boundaries_are_the_same_on_any_number_of_threads() {
    let program = Program::lower(&stereotomy::scenes::cheese(300)).expect("valid");
    let describe = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads").install(|| {
            let brep = program
                .boundary(&BoundaryOptions::new())
                .expect("a boundary");
            let edges: Vec<_> = brep.edges().map(|e| (e.range(), e.curve())).collect();
            let points: Vec<_> = brep.vertices().map(|v| v.point()).collect();
            (edges, points, brep.measure())
        })
    };
    assert!(describe(1) == describe(4));
}
