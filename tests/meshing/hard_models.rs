//! The models in `models/hard/`, each of which once broke a mesher: walls
//! thinner than a cell, surfaces that touch, apexes, points where many
//! surfaces meet, solids that are not manifold.

use std::f64::consts::PI;
use std::path::Path;

use csg::{BoundaryOptions, Meshed, Mesher, Program, Solid};
use glam::{DAffine3, DMat3, DVec3, dvec3};
use stereotomy::io::scene::ReadOptions;
use stereotomy::{csg, io};

use crate::ROOT;
use crate::random::Random;
use crate::sweeps::one_in;

use super::defects::{largest_miss, measure, size};

pub fn model(name: &str) -> Solid {
    read(name, &ReadOptions::default())
}

fn read(name: &str, options: &ReadOptions) -> Solid {
    let folder = Path::new(ROOT).join("models/hard");
    let file = folder.join(name).with_extension("csg");
    let scene = io::scene::read_file(&file, options);
    scene
        .unwrap_or_else(|e| panic!("{}: {e}", file.display()))
        .solid
}

fn mesh(solid: &Solid, cells: u32) -> Meshed {
    let program = Program::lower(solid).expect("a valid solid");
    Mesher::new().cells(cells).mesh(&program).expect("a mesh")
}

fn turn() -> DMat3 {
    DMat3::from_rotation_z(0.7) * DMat3::from_rotation_y(0.5) * DMat3::from_rotation_x(0.3)
}

/// Where a model is put: scaled, then turned, then moved.
#[derive(Clone, Copy, Debug)]
struct Pose {
    scale: f64,
    turned: bool,
    offset: DVec3,
}

const HOME: Pose = Pose {
    scale: 1.0,
    turned: false,
    offset: DVec3::ZERO,
};

const TURNED: Pose = Pose {
    turned: true,
    ..HOME
};

/// At home, turned, and turned besides far away, small and large.
const POSES: [Pose; 7] = [
    HOME,
    TURNED,
    Pose {
        offset: dvec3(1e6, -2e6, 1e6),
        ..TURNED
    },
    Pose {
        offset: dvec3(-1e9, 1e9, 0.5e9),
        ..TURNED
    },
    Pose {
        offset: dvec3(1e12, 0.0, 1e12),
        ..TURNED
    },
    Pose {
        scale: 1e-6,
        ..TURNED
    },
    Pose {
        scale: 1e6,
        ..TURNED
    },
];

impl Pose {
    fn of(self, solid: &Solid) -> Solid {
        let scaled = if self.scale == 1.0 {
            solid.clone()
        } else {
            solid.scale(self.scale)
        };
        let turned = if self.turned {
            scaled.rotate_xyz(0.3, 0.5, 0.7)
        } else {
            scaled
        };
        if self.offset == DVec3::ZERO {
            turned
        } else {
            turned.translate(self.offset)
        }
    }

    fn at(self, point: DVec3) -> DVec3 {
        let scaled = point * self.scale;
        self.offset + if self.turned { turn() * scaled } else { scaled }
    }

    /// How far coordinates may be off: four machine epsilons of the distance.
    fn rounding(self) -> f64 {
        4.0 * f64::EPSILON * self.offset.length()
    }
}

/// All of them.
const MODELS: [&str; 70] = [
    "apex-on-a-curve",
    "apex-on-a-cylinder",
    "ball-in-a-round-hole",
    "ball-in-a-turned-spheroid",
    "ball-inscribed-in-a-cylinder",
    "ball-on-plate",
    "ball-through-edges",
    "blind-hole-touches-a-bore",
    "block-of-cubes",
    "bubble-below-face",
    "capsule",
    "cone",
    "cone-cut-beside-its-apex",
    "cones-along-a-ruling",
    "cones-along-a-ruling-cut",
    "cones-nested-along-a-ruling",
    "cones-of-one-apex",
    "conical-pit",
    "conics-touching",
    "contact-of-fourth-order",
    "contact-on-a-ruling",
    "contact-parted-by-rounding",
    "corners-on-a-cone",
    "counterbore-cuts-a-bore",
    "crossing-pipes",
    "cubes-sharing-a-corner",
    "cubes-sharing-an-edge",
    "curves-cut-beside-a-contact",
    "dimples",
    "doubled-chords",
    "doubled-diagonals",
    "drilled-cube-rounded-by-a-cube",
    "flat-triangle",
    "half-cone",
    "half-hourglass",
    "half-twin-balls",
    "hourglass",
    "island-touching-its-hole",
    "near-cylinders",
    "near-parabola",
    "octahedron",
    "pipes-of-nearly-one-radius",
    "plate",
    "polygons-a-millionth-apart",
    "polyhedron-bored-flush",
    "prism-in-a-round-hole",
    "prism-out-of-a-cylinder",
    "pyramid-12",
    "pyramid-4",
    "pyramid-5",
    "pyramid-8",
    "random-tree",
    "rim-along-a-cylinder",
    "rim-along-a-ruling",
    "rods-side-by-side",
    "roots-about-a-contact",
    "rounded-edge",
    "slit-along-a-curve",
    "slit-between-cones",
    "slit-kinked-by-rounding",
    "slit-within-a-face",
    "spire",
    "thin-ellipse",
    "thin-lens",
    "thin-wall",
    "turned-battlements",
    "turned-over-face",
    "twin-balls",
    "twin-hollows",
    "wedge",
];

/// All models by name.
pub fn all() -> impl Iterator<Item = (&'static str, Solid)> {
    MODELS.into_iter().map(|name| (name, model(name)))
}

#[test]
fn manifold_in_every_pose_at_every_grid() {
    let places = POSES.map(|pose| [1, 4, 11, 37].map(|cells| (pose, cells)));
    let cases = MODELS.iter().flat_map(|name| {
        let places = places.as_flattened().iter();
        places.map(move |place| (name, place))
    });
    for (name, (pose, cells)) in cases.step_by(one_in(5)) {
        let check = mesh(&pose.of(&model(name)), *cells).report.check;
        assert!(check.is_manifold(), "{name} {pose:?} at {cells}: {check}");
    }
}

/// By their own curves, and no surface moved.
#[test]
fn cones_that_touch_along_a_ruling_are_meshed_as_they_are() {
    for name in MODELS.iter().filter(|name| name.starts_with("cones-")) {
        for pose in [HOME, TURNED] {
            let program = Program::lower(&pose.of(&model(name))).expect("a valid solid");
            let meshed = Mesher::new().tolerance(0.01).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert_eq!(report.fallbacks, [], "{name} {pose:?}");
            assert!(
                report.is_proven(),
                "{name} {pose:?}: {:?}",
                report.undecided
            );
            assert!(mesh.self_intersections().is_empty(), "{name} {pose:?}");
        }
    }
}

#[test]
fn flat_models_are_exact_at_every_grid_in_every_pose() {
    let pyramid = |sides: f64| sides / 6.0 * (std::f64::consts::TAU / sides).sin();
    for (name, volume, parts) in [
        ("block-of-cubes", 27.0, 1),
        ("cubes-sharing-a-corner", 2.0, 2),
        ("cubes-sharing-an-edge", 2.0, 2),
        ("octahedron", 4.0 / 3.0, 1),
        ("pyramid-4", pyramid(4.0), 1),
        ("pyramid-5", pyramid(5.0), 1),
    ] {
        for pose in POSES {
            let program = Program::lower(&pose.of(&model(name))).expect("a valid solid");
            for cells in [16, 33, 64] {
                let Meshed { mesh, report, .. } = mesh(&pose.of(&model(name)), cells);
                let error = mesh.volume() - volume * pose.scale.powi(3);
                let allowed = 1e-12 * volume * pose.scale.powi(3) + pose.rounding() * mesh.area();
                let name = format!("{name} {pose:?} at {cells}");
                assert!(error.abs() <= allowed, "{name}: {error:e} of {allowed:e}");
                // A lattice edge may go from one part to the other right
                // through the edge they share, both its ends inside.
                if name.contains("an-edge") && pose.turned {
                    continue;
                }
                assert_eq!(report.check.genus(), Some(0), "{name}");
                assert_eq!(report.check.components, parts, "{name}");
                assert!(
                    report.fallbacks.is_empty(),
                    "{name}: {:?}",
                    report.fallbacks
                );
                // Far away the measure's own steps are lost in rounding.
                if pose.offset.length() < 1e7 {
                    let found = measure(&program, &mesh);
                    let defects = found.folded + found.without_area + found.duplicates;
                    assert!(defects == 0, "{name}: {found:?}");
                }
            }
        }
    }
}

#[test]
fn cubes_that_share_an_edge_or_a_corner_have_every_corner() {
    for (name, second) in [
        ("cubes-sharing-an-edge", dvec3(1.0, 1.0, 0.0)),
        ("cubes-sharing-a-corner", DVec3::ONE),
    ] {
        for pose in [HOME, TURNED] {
            let mesh = mesh(&pose.of(&model(name)), 30).mesh;
            for i in 0..16u32 {
                let corner = DVec3::from_array([0, 1, 2].map(|a| f64::from(i >> a & 1)));
                let corner = pose.at(corner + second * f64::from(i >> 3));
                let nearest = nearest(&mesh, corner);
                assert!(nearest < 1e-14, "{name} {pose:?}: {corner} by {nearest:e}");
            }
        }
    }
}

/// How far the nearest vertex is from a point.
fn nearest(mesh: &csg::Mesh, point: DVec3) -> f64 {
    let distances = mesh.positions.iter().map(|p| p.distance(point));
    distances.fold(f64::INFINITY, f64::min)
}

#[test]
fn points_where_many_planes_meet_are_vertices() {
    for (name, apex) in [
        ("pyramid-4", dvec3(0.0, 0.0, 1.0)),
        ("pyramid-5", dvec3(0.0, 0.0, 1.0)),
        ("pyramid-8", dvec3(0.0, 0.0, 1.0)),
        ("octahedron", dvec3(0.0, 0.0, -1.0)),
        ("octahedron", dvec3(0.0, 1.0, 0.0)),
    ] {
        for pose in [HOME, TURNED] {
            for cells in [16, 33, 64] {
                let mesh = mesh(&pose.of(&model(name)), cells).mesh;
                let nearest = nearest(&mesh, pose.at(apex));
                assert!(nearest < 1e-12, "{name} {pose:?} at {cells}: {nearest:e}");
            }
        }
    }
}

#[test]
fn touching_surfaces_throw_no_vertex_off_and_curved_volumes_converge() {
    use std::f64::consts::PI;
    for (name, volume) in [
        ("capsule", PI * (0.5 + 1.0 / 6.0)),
        ("rounded-edge", 4.0 * (2.0 - 0.25 + PI / 16.0)),
        ("crossing-pipes", 2.0 * PI - 2.0 / 3.0),
        ("cone", 2.0 / 3.0 * PI),
        ("conical-pit", 8.0 - PI / 3.0 * 1.25 * 0.625 * 0.625),
    ] {
        for pose in [HOME, TURNED] {
            let solid = pose.of(&model(name));
            let program = Program::lower(&solid).expect("a valid solid");
            let error = |cells: u32| {
                let Meshed { mesh, report, .. } = mesh(&solid, cells);
                let which = format!("{name} {pose:?} at {cells}");
                let miss = largest_miss(&program, &mesh) / size(&mesh);
                assert!(miss < 1e-12, "{which}: {miss:e}");
                assert_eq!(report.check.genus(), Some(0), "{which}");
                assert_eq!(report.check.components, 1, "{which}");
                (mesh.volume() / volume - 1.0).abs()
            };
            // Second order: by eight at four times the cells, at the least.
            let (coarse, fine) = (error(25), error(100));
            assert!(fine < coarse / 8.0, "{name} {pose:?}: {coarse:e}, {fine:e}");
        }
    }
}

#[test]
fn what_is_thinner_than_a_cell_is_reported_beside_what_is_not() {
    let block = Solid::cuboid([1.0, 1.0, 1.0]);
    let wall = Solid::cuboid([0.5, 0.01, 0.5]).translate([0.75, 0.06, 0.0]);
    let gap = Solid::cuboid([0.5, 0.01, 0.5]).translate([0.45, 0.06, 0.0]);
    let ball = Solid::sphere(0.01).translate([0.63, 0.03, 0.02]);
    let wedge = Solid::prism([[0.0, 0.0], [1.0, 0.0], [0.0, 0.1]], 0.0..0.3);
    for (name, solid, place) in [
        ("wall", &block | wall, dvec3(0.75, 0.06, 0.0)),
        ("gap", &block - gap, dvec3(0.45, 0.06, 0.0)),
        ("ball", &block | ball, dvec3(0.63, 0.03, 0.02)),
        ("wedge", wedge, dvec3(0.6, 0.02, 0.15)),
    ] {
        for pose in [HOME, TURNED] {
            let Meshed { report, .. } = mesh(&pose.of(&solid), 16);
            let thin = report.fallbacks.iter();
            let thin = thin.filter(|f| f.kind.contains("thinner than a cell"));
            let mut places = thin.flat_map(|f| &f.places);
            let found = places.any(|found| found.distance(pose.at(place)) < 0.4);
            assert!(found, "{name} {pose:?}: {:?}", report.fallbacks);
        }
    }
    let report = mesh(&block, 16).report;
    assert!(report.fallbacks.is_empty(), "{:?}", report.fallbacks);
}

/// Triangles that go around an apex are no farther from the cone than from it, and
/// chords along which a ball touches a hole are the same in both, and cut before what
/// is beside them.
#[test]
fn where_surfaces_are_narrow_or_touch_few_triangles_will_do() {
    for (name, most) in [
        ("cone-cut-beside-its-apex", 50),
        ("ball-in-a-round-hole", 1500),
    ] {
        for pose in [HOME, TURNED] {
            let program = Program::lower(&pose.of(&model(name))).expect("a valid solid");
            let meshed = Mesher::new().tolerance(0.01).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert_eq!(report.fallbacks, [], "{name}");
            assert!(report.deviation.is_some_and(|bound| bound <= 0.01));
            assert!(mesh.triangles.len() <= most, "{}", mesh.triangles.len());
        }
    }
}

/// On grids much of its tip is thinner than a cell.
#[test]
fn a_spire_is_whole_or_reported_and_no_face_of_it_turned_over() {
    let apex = dvec3(0.0, 0.0, 3.0);
    for pose in [HOME, TURNED] {
        let solid = pose.of(&model("spire"));
        let program = Program::lower(&solid).expect("a valid solid");
        for cells in 8..=40 {
            let Meshed { mesh, report, .. } = mesh(&solid, cells);
            let which = format!("{pose:?} at {cells}");
            let found = measure(&program, &mesh);
            assert_eq!(found.folded, 0, "{which}: {found:?}");
            let mut places = report.fallbacks.iter().flat_map(|f| &f.places);
            let is_told = places.any(|place| place.distance(pose.at(apex)) < 1e-9);
            let nearest = nearest(&mesh, pose.at(apex)) / report.cell_size;
            assert!(is_told || nearest < 2.0, "{which}: {nearest} cells");
        }
    }
}

/// With true circles and with polygons in their place.
#[test]
fn nothing_is_to_be_reported_to_a_tolerance_in_both_modes() {
    const TOLERANCE: f64 = 0.01;
    let cases = MODELS.map(|name| [false, true].map(|faceted| (name, faceted)));
    for &(name, faceted) in cases.as_flattened().iter().step_by(one_in(3)) {
        let solid = read(name, &ReadOptions::default().faceted(faceted));
        let program = Program::lower(&solid).expect("a valid solid");
        let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
        let Meshed { mesh, report, .. } = meshed.expect("a mesh");
        let name = format!("{name}, faceted: {faceted}");
        assert!(report.check.is_manifold(), "{name}: {}", report.check);
        assert_eq!(report.fallbacks, [], "{name}");
        assert!(report.deviation.is_some_and(|d| d <= TOLERANCE), "{name}");
        assert_eq!(mesh.self_intersections(), [[0; 2]; 0], "{name}");
        let found = measure(&program, &mesh);
        assert_eq!(found.folded, 0, "{name}: {found:?}");
    }
}

/// Three surfaces that cross at a small sine have one vertex there, along whichever of their
/// curves it is found.
#[test]
fn rods_a_little_out_of_line_are_meshed_as_they_are() {
    let model = model("flush-cylinders-a-millionth-off");
    let off = |off: f64| {
        let rod = |at: DVec3| Solid::cylinder(5.0, 0.0..10.0).translate(at);
        rod(DVec3::ZERO) | rod(dvec3(off, 0.0, 10.0))
    };
    let solids = [model, off(1e-4), off(1e-5), off(3e-7), off(1e-7)];
    for solid in &solids {
        for pose in [HOME, TURNED] {
            let program = Program::lower(&pose.of(solid)).expect("a valid solid");
            for tolerance in [1e-2, 1e-3, 1e-4] {
                let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
                let Meshed { mesh, report, .. } = meshed.expect("a mesh");
                let what = format!("{pose:?} at {tolerance}");
                assert!(report.is_proven(), "{what}: {:?}", report.undecided);
                assert_eq!((report.fallbacks, report.moved), (vec![], None), "{what}");
                let off = (mesh.volume() - 500.0 * PI).abs();
                assert!(off <= tolerance * mesh.area(), "{what}: {off}");
            }
        }
    }
}

/// Surfaces that nearly agree, as matrices of six digits place them, or have a line in common, are
/// not moved.
#[test]
fn what_is_placed_on_purpose_is_meshed_as_it_is() {
    for name in [
        "pipes-in-a-fan",
        "apex-on-a-rim",
        "balls-overlapping-by-rounding",
        "balls-turned-in-six-digits",
        "bellows-a-hair-off",
        "bores-crossing-on-a-ruling",
        "cross-bore-out-of-a-slab",
        "frusta-around-an-axis",
        "frusta-on-one-plane",
        "gear-a-hair-off",
        "groove-along-a-ruling",
        "pipe-and-its-mirror",
        "rim-on-a-rod-beside-a-block",
        "round-end-in-a-cylinder",
        "shaft-beside-a-collar",
        "tee-of-equal-pipes",
    ] {
        for pose in [HOME, TURNED] {
            let program = Program::lower(&pose.of(&model(name))).expect("a valid solid");
            let boundary = program.boundary(&BoundaryOptions::new());
            let exact = boundary.expect("a boundary").measure().volume;
            for tolerance in [1e-2, 1e-3] {
                let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
                let Meshed { mesh, report, .. } = meshed.expect("a mesh");
                let what = format!("{name}, {pose:?} at {tolerance}");
                assert!(report.is_proven(), "{what}: {:?}", report.undecided);
                assert_eq!((report.fallbacks, report.moved), (vec![], None), "{what}");
                let off = (mesh.volume() - exact.value).abs();
                assert!(
                    off <= tolerance * mesh.area() + exact.error,
                    "{what}: {off}"
                );
            }
        }
    }
}

/// Where two pipes of one radius meet their curve has branches: each is cut up for itself, so that
/// no more triangles are needed than for as many ellipses.
#[test]
fn branches_of_curves_are_cut_up_one_by_one() {
    let solid = model("tee-of-equal-pipes");
    // Both pipes less half of what they have in common (Archimedes).
    let radius = 1.1f64;
    let volume = PI * radius.powi(2) * 12.0 - 8.0 / 3.0 * radius.powi(3);
    for (tolerance, most) in [(3e-3, 400), (1e-3, 650), (1e-5, 6200)] {
        for pose in [HOME, TURNED] {
            let program = Program::lower(&pose.of(&solid)).expect("a valid solid");
            let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert!(report.is_proven(), "{pose:?} {tolerance}: {report:?}");
            let count = mesh.triangles.len();
            assert!(count < most, "{pose:?} {tolerance}: {count} triangles");
            let off = (mesh.volume() - volume).abs();
            assert!(off < tolerance * mesh.area(), "{pose:?} {tolerance}: {off}");
        }
    }
}

/// Rods that just touch both sides of a plate from within leave slits, which are holes in these: the
/// exact boundary has as many handles as the mesh.
#[test]
fn slits_have_no_area_and_are_no_faces() {
    for pose in [HOME, TURNED] {
        let program = Program::lower(&pose.of(&model("plate-slit-from-within"))).expect("valid");
        let boundary = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        let meshed = Mesher::new()
            .tolerance(1e-2)
            .mesh(&program)
            .expect("a mesh");
        let genera: Vec<usize> = boundary.shells().map(|shell| shell.genus()).collect();
        assert_eq!(genera, [1], "{pose:?}");
        assert_eq!(meshed.report.check.genus(), Some(1), "{pose:?}");
    }
}

/// A rod, cones and a ball that were meant to touch, be in line and of one radius, and miss it by
/// as much as nobody sees: they are moved by about that, and no farther.
#[test]
fn what_misses_touching_by_little_is_moved_until_it_touches() {
    for name in [
        "rod-that-is-a-cone-by-a-billionth",
        "spool-missed-by-a-billionth",
    ] {
        let program = Program::lower(&model(name)).expect("a valid solid");
        for tolerance in [0.7, 0.1, 0.02] {
            let what = format!("{name} at {tolerance}");
            let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert_eq!(report.fallbacks, [], "{what}");
            assert!(report.check.is_manifold() && mesh.self_intersections().is_empty());
            assert!(report.deviation.is_some_and(|d| d <= tolerance), "{what}");
            let moved = report.moved.map_or(0.0, |moved| moved.distance);
            assert!(moved < 1e-5, "{what}: {moved}");
        }
    }
}

/// A rod touches a wider one from within at a point of its own rim, or nearly so, and nearly round:
/// all three pairs of surfaces are told to meet there alike, and nothing is moved by more than what
/// made it not quite round.
#[test]
fn rims_beside_contacts_are_told_alike_along_all_curves() {
    let decided = |what: &str, solid: &Solid, off: f64| {
        let program = Program::lower(solid).expect("a valid solid");
        let meshed = Mesher::new().tolerance(0.01).mesh(&program);
        let Meshed { report, .. } = meshed.expect("a mesh");
        assert_eq!(report.undecided, [], "{what}");
        assert_eq!(report.fallbacks, [], "{what}");
        let moved = report.moved.map_or(0.0, |moved| moved.distance);
        assert!(moved <= 10.0 * off, "{what}: moved by {moved}");
        assert!(report.check.is_manifold(), "{what}: {}", report.check);
        let boundary = program.boundary(&BoundaryOptions::new());
        boundary.expect("a boundary").measure().volume
    };
    let model = model("rod-touches-a-pipe-at-its-rim");
    decided("eleven digits", &model, 1e-11);
    let rod = Solid::cylinder(0.25, 0.0..1.25).rotate_x(7.0 * PI / 6.0);
    let pipe = Solid::cylinder(0.5, 0.0..1.0).rotate_x(11.0 * PI / 12.0);
    let down = 0.25 * dvec3(0.0, (PI / 12.0).sin(), (PI / 12.0).cos());
    let parts = [
        rod.translate([-0.5, -0.25, 0.5]),
        pipe.translate(dvec3(-0.25, 0.5, -0.25) + down)
            .rotate_x(2.0 * PI / 3.0),
    ];
    let exact = decided("exact", &Solid::union(parts.clone()), 0.0);
    let mut random = Random::new(1);
    for (round, off) in [1e-8, 1e-11, 1e-12, 1e-13]
        .repeat(10)
        .into_iter()
        .enumerate()
    {
        let parts = parts.clone().map(|part| {
            let mut number = || off * (2.0 * random.unit() - 1.0);
            let mut vector = || dvec3(number(), number(), number());
            let columns = DMat3::from_cols(vector(), vector(), vector());
            part.affine(DAffine3 {
                matrix3: DMat3::IDENTITY + columns,
                translation: vector(),
            })
        });
        let what = format!("{round}: {off}");
        let volume = decided(&what, &Solid::union(parts), off);
        // A contact is told to the square root of what its surfaces are.
        assert!(volume.error < 1e-6, "{what}: {volume:?}");
        let miss = (volume.value - exact.value).abs();
        assert!(
            miss <= volume.error + 10.0 * off,
            "{what}: {volume:?}, {exact:?}"
        );
    }
}

/// The bound of a volume counts that edges are right to rounding only.
#[test]
fn volumes_of_slivers_are_within_their_bounds() {
    let program = Program::lower(&model("sliver-of-six-digits")).expect("a valid solid");
    let boundary = program.boundary(&BoundaryOptions::new());
    let exact = boundary.expect("a boundary").measure().volume;
    let meshed = Mesher::new().tolerance(0.01).mesh(&program);
    let Meshed { mesh, report, .. } = meshed.expect("a mesh");
    assert!(report.is_proven(), "{:?}", report.undecided);
    // All of it is flat, and so the mesh exact but for rounding.
    let volume = mesh.volume();
    let off = (volume - exact.value).abs();
    assert!(
        off <= exact.error && exact.error < 0.1 * volume,
        "{exact:?}"
    );
}

/// A hull of balls in a plane is made of planes, cylinders and balls.
#[test]
fn hulls_of_balls_in_a_plane_are_round() {
    let program = Program::lower(&model("plate-of-balls-on-a-post")).expect("a valid solid");
    assert!(program.surfaces().len() < 40);
    let meshed = Mesher::new().tolerance(0.01).mesh(&program);
    let Meshed { mesh, report, .. } = meshed.expect("a mesh");
    assert!(report.is_proven(), "{:?}", report.undecided);
    assert!(mesh.self_intersections().is_empty());
}
