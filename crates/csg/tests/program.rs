//! Lowering, canonical surfaces, pruning and bounds against closed forms and
//! direct evaluation of the authored tree.

use csg::program::{Cell, Operand, Pruner};
use csg::{Axis, Color, Error, NodeFault, Plane, Program, Solid};
use glam::DVec3;
use proptest::prelude::*;

fn lower(solid: &Solid) -> Program {
    Program::lower(solid).expect("a valid solid")
}

fn is_nothing(solid: &Solid) -> bool {
    lower(solid).formula().root() == Operand::Constant(false)
}

#[test]
fn primitives_contain_what_their_equations_say() {
    // Each primitive beside its textbook inequality.
    type Inside = fn(DVec3) -> bool;
    let cases: Vec<(Solid, Inside)> = vec![
        (Solid::half_space([0.0, 0.0, 2.0], 0.5), |p| p.z <= 0.5),
        (
            Solid::half_space_through([0.2, 0.0, 0.0], [-1.0, 0.0, 0.0]),
            |p| p.x >= 0.2,
        ),
        (Solid::cube(1.0), |p| p.abs().max_element() <= 0.5),
        (Solid::cuboid([1.0, 2.0, 0.6]), |p| {
            p.x.abs() <= 0.5 && p.y.abs() <= 1.0 && p.z.abs() <= 0.3
        }),
        (Solid::cuboid_between([0.0; 3], [1.0, 0.5, 0.25]), |p| {
            (0.0..=1.0).contains(&p.x) && (0.0..=0.5).contains(&p.y) && (0.0..=0.25).contains(&p.z)
        }),
        (Solid::sphere(0.8), |p| p.length() <= 0.8),
        (Solid::ellipsoid([1.0, 0.5, 0.25]), |p| {
            (p / DVec3::new(1.0, 0.5, 0.25)).length() <= 1.0
        }),
        (Solid::cylinder(0.4, -0.5..0.7), |p| {
            p.x.hypot(p.y) <= 0.4 && (-0.5..=0.7).contains(&p.z)
        }),
        (Solid::infinite_cylinder(0.4), |p| p.x.hypot(p.y) <= 0.4),
        (Solid::elliptic_cylinder([0.4, 0.8], 0.0..1.0), |p| {
            (p.x / 0.4).hypot(p.y / 0.8) <= 1.0 && (0.0..=1.0).contains(&p.z)
        }),
        (Solid::frustum(0.8, 0.3, -0.5..0.5), |p| {
            p.z.abs() <= 0.5 && p.x.hypot(p.y) <= 0.55 - 0.5 * p.z
        }),
        (Solid::frustum(0.5, 0.499, -0.5..0.5), |p| {
            p.z.abs() <= 0.5 && p.x.hypot(p.y) <= 0.4995 - 0.001 * p.z
        }),
        (Solid::cone(0.8, -0.5..0.5), |p| {
            p.z.abs() <= 0.5 && p.x.hypot(p.y) <= 0.8 * (0.5 - p.z)
        }),
        (Solid::frustum(0.0, 0.8, -0.5..0.5), |p| {
            p.z.abs() <= 0.5 && p.x.hypot(p.y) <= 0.8 * (p.z + 0.5)
        }),
        (Solid::infinite_cone(0.5f64.atan()), |p| {
            p.z >= 0.0 && p.x.hypot(p.y) <= 0.5 * p.z
        }),
        (Solid::paraboloid([0.5, 1.0]), |p| {
            p.z >= (p.x / 0.5).powi(2) + p.y.powi(2)
        }),
        (Solid::hyperboloid_one_sheet([0.5, 0.4, 0.8]), |p| {
            (p.x / 0.5).powi(2) + (p.y / 0.4).powi(2) - (p.z / 0.8).powi(2) <= 1.0
        }),
        (Solid::hyperboloid_two_sheets([0.5, 0.4, 0.3]), |p| {
            (p.z / 0.3).powi(2) - (p.x / 0.5).powi(2) - (p.y / 0.4).powi(2) >= 1.0
        }),
        (
            Solid::convex_polyhedron(
                [
                    [1.0, 1.0, 1.0],
                    [-1.0, -1.0, 1.0],
                    [1.0, -1.0, -1.0],
                    [-1.0, 1.0, -1.0],
                ]
                .map(|n| Plane {
                    normal: n.into(),
                    offset: 0.5,
                }),
            ),
            |p| {
                [
                    [1.0, 1.0, 1.0],
                    [-1.0, -1.0, 1.0],
                    [1.0, -1.0, -1.0],
                    [-1.0, 1.0, -1.0],
                ]
                .iter()
                .all(|&n| DVec3::from(n).dot(p) <= 0.5)
            },
        ),
        (
            Solid::prism([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]], -0.2..0.2),
            |p| p.x >= 0.0 && p.y >= 0.0 && p.x + p.y <= 1.0 && p.z.abs() <= 0.2,
        ),
        // xy + z <= 0.1
        (
            Solid::quadric([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, -0.1]),
            |p| p.x * p.y + p.z <= 0.1,
        ),
    ];
    let n = 23;
    for (solid, inside) in &cases {
        let program = lower(solid);
        let mut inside_count = 0;
        for i in 0..n * n * n {
            let index = DVec3::new((i % n).into(), (i / n % n).into(), (i / n / n).into());
            // An irrational step keeps the points off every surface above.
            let p = (index / f64::from(n) - 0.5) * 2.0 * 1.2345678912 + 1e-3;
            assert_eq!(program.contains(p), inside(p), "{solid:?} at {p}");
            inside_count += u32::from(inside(p));
        }
        assert!(inside_count > 10, "{solid:?} is hardly tested");
    }
}

#[test]
fn chains_of_many_maps_round_no_more_than_as_many_of_one() {
    let nested = |solid: &Solid, count: u32, map: &dyn Fn(&Solid) -> Solid| {
        (0..count).fold(solid.clone(), |solid, _| map(&solid))
    };
    let cube = Solid::cube(1.0);
    for count in [10, 60, 400] {
        // Cubes a little apart, and one that comes back.
        let step = 0.125;
        let far = 1.0001 - step * f64::from(count);
        let moved = |gap: f64| {
            let other = cube.translate([far + gap, 0.0, 0.0]);
            nested(&other, count, &|solid| solid.translate([step, 0.0, 0.0]))
        };
        assert_eq!(lower(&(&cube | moved(0.0))).surfaces().len(), 8, "{count}");
        assert_eq!(
            lower(&(&cube | moved(-1e-4))).surfaces().len(),
            7,
            "{count}"
        );
        let turned = nested(&cube, count, &|solid| solid.rotate_z(0.3).rotate_x(0.7));
        let back = nested(&turned, count, &|solid| solid.rotate_x(-0.7).rotate_z(-0.3));
        assert_eq!(lower(&(&cube | back)).surfaces().len(), 6, "{count}");
    }
}

#[test]
fn coincident_surfaces_are_one_through_any_transforms() {
    let quarter = std::f64::consts::FRAC_PI_2;
    // A cube has six planes; turned, moved there and back, mirrored or seen
    // from its other side it has the same six.
    let cube = Solid::cube(2.0);
    let same = [
        cube.rotate_x(quarter),
        cube.rotate_about_axis([1.0, 1.0, 1.0], 4.0 * quarter / 3.0),
        cube.translate([1e6, 3.0, 0.1])
            .translate([-1e6, -3.0, -0.1]),
        cube.rotate_z(0.3)
            .rotate_x(0.7)
            .rotate_x(-0.7)
            .rotate_z(-0.3),
        cube.mirror([0.0; 3], [0.0, 1.0, 0.0]),
        cube.scale(3.0).scale(1.0 / 3.0),
        Solid::cuboid_between([-1.0; 3], [1.0; 3]),
        !&cube,
    ];
    for other in &same {
        let both = &cube & other | other.named("again");
        assert_eq!(lower(&both).surfaces().len(), 6, "{other:?}");
    }
    let bar = Solid::infinite_cylinder(0.5).rotate_xyz(0.3, 0.5, 0.7);
    let along = bar.translate(
        glam::DMat3::from_rotation_z(0.7)
            * glam::DMat3::from_rotation_y(0.5)
            * glam::DMat3::from_rotation_x(0.3)
            * DVec3::Z
            * 17.0,
    );
    assert_eq!(lower(&(&bar | along)).surfaces().len(), 1);
    // What differs by more than rounding stays apart.
    for shift in [1e-12, 1e-9, 1e-3] {
        let pair = &cube | cube.translate([shift, 0.0, 0.0]);
        assert_eq!(lower(&pair).surfaces().len(), 8, "{shift}");
        let far = cube.translate([1e6, 0.0, 0.0]);
        let pair = &far | far.translate([1e-6 + shift, 0.0, 0.0]);
        assert_eq!(lower(&pair).surfaces().len(), 8, "{shift} at 1e6");
        let pair = Solid::sphere(1.0) | Solid::sphere(1.0 + shift);
        assert_eq!(lower(&pair).surfaces().len(), 2, "{shift}");
    }
}

#[test]
fn what_cancels_is_nothing() {
    let ball = Solid::sphere(1.0);
    let cube = Solid::cube(1.5);
    let both = &ball | &cube;
    let mixed =
        (&cube & (&ball | cube.translate([1.0, 0.0, 0.0]))) - Solid::cylinder(0.2, -2.0..2.0);
    for solid in [&ball, &cube, &both, &mixed] {
        assert!(is_nothing(&(solid - solid)), "{solid:?}");
        // Not by identity of nodes, but by what they say.
        let moved = solid.translate([3.0, 0.0, 0.0]).translate([-3.0, 0.0, 0.0]);
        assert!(is_nothing(&(solid - &moved)), "{solid:?}");
        assert!(is_nothing(&(solid & !&moved)), "{solid:?}");
        let all = lower(&(solid | !&moved));
        assert_eq!(all.formula().root(), Operand::Constant(true), "{solid:?}");
    }
    assert!(is_nothing(&(Solid::sphere(1.0) - Solid::space())));
    assert!(is_nothing(&Solid::empty()));
}

#[test]
fn abutting_boxes_have_no_membrane() {
    let left = Solid::cuboid_between([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0]);
    let right = Solid::cuboid_between([0.0, -1.0, -1.0], [1.0, 1.0, 1.0]);
    let program = lower(&(left | right));
    // A box across the shared face, away from the others, is proven full.
    let mut cell = Cell::default();
    program.root_cell().prune_into(
        program.surfaces(),
        DVec3::ZERO,
        DVec3::splat(0.5),
        &mut Pruner::default(),
        &mut cell,
    );
    assert_eq!(cell.constant(), Some(true));
}

#[test]
fn names_and_colours_stay_with_their_subtrees() {
    let red = Color::from_linear([1.0, 0.0, 0.0]);
    let blue = Color::from_linear([0.0, 0.0, 1.0]);
    let hub = Solid::sphere(1.0).colored(red).named("hub");
    let all = (hub.translate([1.0, 0.0, 0.0]) | Solid::cube(0.5))
        .colored(blue)
        .named("all");
    let program = lower(&all);
    let found: Vec<_> = program
        .origins()
        .iter()
        .map(|o| (o.kind, o.name.as_deref(), o.color))
        .collect();
    assert_eq!(
        found,
        [
            ("sphere", Some("hub"), Some(red)),
            ("cuboid", Some("all"), Some(blue))
        ]
    );
}

#[test]
fn bad_nodes_are_named_by_their_path() {
    let bad = Solid::sphere(-1.0).named("ball");
    let tree = Solid::cube(1.0) - (Solid::cube(2.0) | bad.translate([1.0, 0.0, 0.0]));
    let error = Program::lower(&tree.named("part")).expect_err("a negative radius");
    assert_eq!(
        error.to_string(),
        "a radius is -1: it must be positive and finite \
         (at \"part\" / difference / union (operand 2) / transform (operand 2) / \"ball\" / sphere)"
    );
}

#[test]
fn every_kind_of_bad_input_is_an_error() {
    let nan = f64::NAN;
    let s = Solid::sphere(1.0);
    let bad = [
        Solid::sphere(0.0),
        Solid::sphere(nan),
        Solid::sphere(f64::INFINITY),
        Solid::sphere(1e200),
        Solid::ellipsoid([1.0, 1.0, -1.0]),
        Solid::cube(0.0),
        Solid::cuboid([1.0, nan, 1.0]),
        Solid::cuboid_between([1.0; 3], [0.0, 2.0, 2.0]),
        Solid::half_space([0.0; 3], 1.0),
        Solid::half_space([nan, 0.0, 0.0], 1.0),
        Solid::half_space([1.0, 0.0, 0.0], nan),
        Solid::half_space_through([nan; 3], [0.0, 0.0, 1.0]),
        Solid::cylinder(1.0, 1.0..1.0),
        Solid::cylinder(1.0, 1.0..0.0),
        Solid::cylinder(1.0, nan..0.0),
        Solid::cylinder(-1.0, 0.0..1.0),
        Solid::infinite_cylinder(0.0),
        Solid::frustum(0.0, 0.0, 0.0..1.0),
        Solid::frustum(-1.0, 1.0, 0.0..1.0),
        Solid::infinite_cone(2.0),
        Solid::infinite_cone(-0.5),
        Solid::paraboloid([0.0, 1.0]),
        Solid::hyperboloid_one_sheet([1.0, 1.0, 0.0]),
        Solid::hyperboloid_two_sheets([1.0, nan, 1.0]),
        Solid::quadric([0.0; 10]),
        Solid::convex_polyhedron([]),
        Solid::convex_polyhedron([Plane {
            normal: DVec3::ZERO,
            offset: 1.0,
        }]),
        Solid::prism([[0.0, 0.0], [1.0, 0.0]], 0.0..1.0),
        Solid::prism([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 0.0..1.0),
        Solid::prism([[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]], 0.0..1.0),
        // A pentagram: every corner turns the same way, but twice around.
        Solid::prism(
            (0..5).map(|i| glam::DVec2::from_angle(f64::from(i) * 0.8 * std::f64::consts::PI)),
            0.0..1.0,
        ),
        Solid::union([]),
        Solid::intersection([]),
        Solid::difference([]),
        s.scale(0.0),
        s.scale_xyz([1.0, 0.0, 1.0]),
        s.scale(nan),
        s.translate([nan, 0.0, 0.0]),
        s.translate([f64::INFINITY, 0.0, 0.0]),
        s.rotate_about_axis([0.0; 3], 1.0),
        s.mirror([0.0; 3], [0.0; 3]),
        s.shear(Axis::Y, Axis::Y, 1.0),
        s.scale_along([1.0, 0.0, 0.0], 0.0),
        s.scale(1e200).scale(1e200),
    ];
    for solid in bad {
        // Also where it could be thought not to matter.
        let error = Program::lower(&(Solid::cube(1.0) & &solid));
        assert!(
            matches!(error, Err(Error::InvalidNode { .. })),
            "{solid:?}: {error:?}"
        );
    }
}

#[test]
fn a_million_deep_and_a_million_wide() {
    let worker = || {
        let ball = Solid::sphere(0.5);
        let mut deep = Solid::cube(1.0);
        for i in 0..1_000_000 {
            deep = match i % 3 {
                0 => deep | &ball,
                1 => deep - &ball.translate([f64::from(i), 0.0, 0.0]),
                _ => deep.named("level"),
            };
        }
        let program = lower(&deep);
        assert!(program.contains([0.0; 3]) && !program.contains([1.0, 0.0, 0.0]));
        let wide = Solid::union((0..1_000_000).map(|i| ball.translate([f64::from(i), 0.0, 0.0])));
        let program = lower(&wide);
        assert_eq!(program.surfaces().len(), 1_000_000);
        assert!(program.contains([77.2, 0.0, 0.0]) && !program.contains([77.5, 0.2, 0.0]));
    };
    std::thread::Builder::new()
        .stack_size(256 * 1024)
        .spawn(worker)
        .expect("a thread")
        .join()
        .expect("no overflow");
}

#[test]
fn shared_subtrees_are_lowered_once_per_transform() {
    // 2^60 leaves if every path were walked.
    let mut solid = Solid::sphere(1.0) | Solid::cube(1.0);
    for _ in 0..60 {
        solid = (&solid | &solid.named("twin")) & &solid;
    }
    let program = lower(&solid);
    assert!(program.formula().gates().len() < 500);
    assert_eq!(program.surfaces().len(), 7);
}

#[test]
fn bounds_are_tight_and_infinity_is_found() {
    let third = 1.0f64 / 3.0;
    let cases = [
        (Solid::sphere(1.0), [-1.0; 3], [1.0; 3]),
        (
            Solid::sphere(1e-6).translate([1e6, 0.0, 0.0]),
            [1e6 - 1e-6, -1e-6, -1e-6],
            [1e6 + 1e-6, 1e-6, 1e-6],
        ),
        (
            Solid::cuboid([2.0, 1.0, 1.0]).rotate_z(std::f64::consts::FRAC_PI_4),
            [-1.5 * 0.5f64.sqrt(), -1.5 * 0.5f64.sqrt(), -0.5],
            [1.5 * 0.5f64.sqrt(), 1.5 * 0.5f64.sqrt(), 0.5],
        ),
        (
            Solid::cube(2.0) & Solid::half_space([1.0, 1.0, 1.0], -2.0 / 3f64.sqrt()),
            [-1.0; 3],
            [0.0, 0.0, 0.0],
        ),
        // Infinite parts that something else ends.
        (
            Solid::paraboloid([1.0, 1.0]) & Solid::half_space([0.0, 0.0, 1.0], 1.0),
            [-1.0, -1.0, 0.0],
            [1.0, 1.0, 1.0],
        ),
        (
            Solid::infinite_cylinder(0.5)
                & Solid::infinite_cylinder(0.5).rotate_x(1.0f64.atan2(0.0)),
            [-0.5, -0.5, -0.5],
            [0.5; 3],
        ),
        (
            Solid::infinite_cone(third.atan()) & Solid::half_space([0.0, 0.0, 1.0], 3.0),
            [-1.0, -1.0, 0.0],
            [1.0, 1.0, 3.0],
        ),
    ];
    for (solid, min, max) in cases {
        let bounds = lower(&solid).bounds().expect("bounded").expect("not empty");
        let (min, max) = (DVec3::from(min), DVec3::from(max));
        let slack = (max - min) / 200.0;
        assert!(
            bounds.min.cmple(min).all() && bounds.max.cmpge(max).all(),
            "{solid:?} {bounds:?}"
        );
        assert!(
            (min - bounds.min).cmple(slack).all() && (bounds.max - max).cmple(slack).all(),
            "{solid:?} {bounds:?}"
        );
    }
    // The tilted bowl touches infinity in one point only.
    let tilted =
        (Solid::paraboloid([1.0, 1.0]) & Solid::half_space([0.0, 0.0, 1.0], 1.0)).rotate_x(0.7);
    assert!(lower(&tilted).bounds().is_ok());
    assert_eq!(
        lower(&(Solid::cube(1.0) - Solid::cube(2.0))).bounds(),
        Ok(None)
    );
    for (solid, direction) in [
        (Solid::infinite_cylinder(1.0), DVec3::Z),
        (Solid::half_space([1.0, 0.0, 0.0], 3.0), DVec3::ZERO),
        (!Solid::sphere(1.0), DVec3::ZERO),
        (Solid::space(), DVec3::ZERO),
        (Solid::paraboloid([1.0, 1.0]), DVec3::Z),
        (
            Solid::infinite_cylinder(0.1).rotate_y(0.3) - Solid::sphere(3.0),
            DVec3::new(0.3f64.sin(), 0.0, 0.3f64.cos()),
        ),
    ] {
        let Err(Error::Unbounded { direction: found }) = lower(&solid).bounds() else {
            panic!("{solid:?} has no bounds");
        };
        if direction != DVec3::ZERO {
            assert!(
                DVec3::from(found).dot(direction).abs() > 0.99,
                "{solid:?} {found:?}"
            );
        }
    }
}

#[test]
fn display_is_for_people() {
    let program = lower(&(Solid::cylinder(2.0, 0.0..3.0) - Solid::sphere(1.0)));
    assert_eq!(
        program.to_string(),
        "s0: x² + y² - 4 about (0, 0, 1.5) <= 0\n\
         s1: -z <= 0\n\
         s2: z about (0, 0, 3) <= 0\n\
         s3: x² + y² + z² - 1 <= 0\n\
         solid = s0 & s1 & s2 & !s3\n"
    );
}

#[test]
fn faults_are_typed() {
    let error = Program::lower(&Solid::union([]));
    assert!(matches!(
        error,
        Err(Error::InvalidNode {
            fault: NodeFault::NoOperands { operation: "union" },
            ..
        })
    ));
}

/// Random trees with shared maps and coincident faces, each beside a direct
/// evaluation of the tree.
fn any_tree() -> impl Strategy<Value = Solid> {
    let leaf = prop_oneof![
        Just(Solid::cube(1.0)),
        Just(Solid::sphere(0.6)),
        Just(Solid::cylinder(0.4, -0.5..0.5)),
        Just(Solid::cone(0.5, -0.5..0.5)),
        Just(Solid::paraboloid([0.7, 0.5])),
    ];
    leaf.prop_recursive(5, 40, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 1..4).prop_map(Solid::union),
            prop::collection::vec(inner.clone(), 1..4).prop_map(Solid::intersection),
            prop::collection::vec(inner.clone(), 1..4).prop_map(Solid::difference),
            (inner.clone(), -2i32..3, -2i32..3).prop_map(|(s, x, y)| {
                s.translate([0.25 * f64::from(x), 0.25 * f64::from(y), 0.0])
            }),
            (inner.clone(), 0i32..4)
                .prop_map(|(s, k)| s.rotate_x(f64::from(k) * std::f64::consts::FRAC_PI_4)),
            inner.clone().prop_map(|s| &s - s.scale(0.5)),
            inner.prop_map(|s| s.scale_xyz([1.5, 0.5, -1.0])),
        ]
    })
}

/// The authored tree evaluated as it stands.
fn contains_directly(solid: &Solid, p: DVec3) -> bool {
    use csg::{Node, Primitive};
    match solid.node() {
        Node::Primitive(Primitive::Cuboid { min, max }) => {
            p.cmpge(*min).all() && p.cmple(*max).all()
        }
        Node::Primitive(Primitive::Ellipsoid { radii }) => (p / *radii).length() <= 1.0,
        Node::Primitive(Primitive::Cylinder { radii, z: Some(z) }) => {
            p.x.hypot(p.y) <= radii.x && z.start <= p.z && p.z <= z.end
        }
        Node::Primitive(Primitive::Frustum { bottom, z, .. }) => {
            let height = z.end - z.start;
            z.start <= p.z && p.z <= z.end && p.x.hypot(p.y) <= bottom * (z.end - p.z) / height
        }
        Node::Primitive(Primitive::Paraboloid { scales }) => {
            p.z >= (p.x / scales.x).powi(2) + (p.y / scales.y).powi(2)
        }
        Node::Union(operands) => operands.iter().any(|s| contains_directly(s, p)),
        Node::Intersection(operands) => operands.iter().all(|s| contains_directly(s, p)),
        Node::Difference(operands) => {
            contains_directly(&operands[0], p)
                && !operands[1..].iter().any(|s| contains_directly(s, p))
        }
        Node::Transform(Ok(map), operand) => {
            contains_directly(operand, map.inverse().transform_point3(p))
        }
        other => panic!("not in these trees: {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn lowering_and_pruning_keep_the_point_set(
        tree in any_tree(),
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 20),
    ) {
        let program = lower(&tree);
        let root = program.root_cell();
        let mut cell = Cell::default();
        for point in points {
            let p = DVec3::from(point);
            // Random doubles lie on no surface.
            let expected = contains_directly(&tree, p);
            prop_assert_eq!(program.contains(p), expected);
            let half = DVec3::splat(0.07);
            let mut pruner = Pruner::default();
            root.prune_into(program.surfaces(), p + 0.03, half, &mut pruner, &mut cell);
            let inside: Vec<bool> = cell
                .surfaces
                .iter()
                .map(|&id| program.surfaces()[id as usize].value(p) <= 0.0)
                .collect();
            prop_assert_eq!(cell.formula.evaluate(&inside), expected);
            prop_assert!(cell.surfaces.windows(2).all(|w| w[0] < w[1]));
        }
    }
}

#[test]
fn names_around_a_primitive_are_its_parts() {
    let ball = Solid::sphere(1.0).named("ball");
    let both = ball.clone().named("race") | ball.named("ball").translate([3.0, 0.0, 0.0]);
    let deep = (0..100).fold(Solid::cube(1.0), |solid, k| solid.named(format!("{k}")));
    let program = Program::lower(&(both.named("bearing") | deep)).expect("valid");
    let names = |k: usize| {
        let origin = &program.origins()[k];
        let all = origin.parts.iter().chain(&origin.name);
        all.map(AsRef::as_ref).collect::<Vec<&str>>()
    };
    assert_eq!(names(0), ["bearing", "race", "ball"]);
    assert_eq!(names(1), ["bearing", "ball"]);
    // The outermost, and the innermost.
    assert_eq!(names(2).len(), 16);
    assert_eq!((names(2)[0], names(2)[14], names(2)[15]), ("99", "85", "0"));
}

/// A block whose side is turned by so little that one coordinate of its normal is rounded to 1 is
/// not taken for one along the axes: about its middle, 9 away, it is elsewhere by more than the cap
/// of a ball that it cuts off is high.
#[test]
fn boxes_of_caps_under_sides_turned_by_a_hair_hold_them() {
    for power in 6..13 {
        let angle = 10f64.powi(-power);
        for (height, y) in [(1e-8, 9.0), (1e-8, -9.0), (1e-6, -9.0), (1e-4, -9.0)] {
            let (sin, cos) = angle.sin_cos();
            let x = (11.0 - height - y * sin) / cos;
            let block = Solid::cube(20.0).rotate_z(angle).translate([x, y, 0.0]);
            let program = Program::lower(&(Solid::sphere(1.0) & block)).expect("valid");
            let bounds = program.bounds().expect("finite").expect("a cap");
            let rim = (height * (2.0 - height)).sqrt();
            let along = DVec3::new(cos, sin, 0.0);
            for side in [
                DVec3::ZERO,
                DVec3::Z,
                DVec3::NEG_Z,
                DVec3::new(-sin, cos, 0.0),
                DVec3::new(sin, -cos, 0.0),
            ] {
                // (The side itself is rounded by 2e-15 of 10.)
                let inside = 1.0 - 1e-6;
                let point = (1.0 - inside * height) * along + inside * rim * side;
                let is_within = point.cmpge(bounds.min).all() && point.cmple(bounds.max).all();
                assert!(is_within, "{angle:e}, {height:e}: {point} of {bounds:?}");
            }
        }
    }
}
