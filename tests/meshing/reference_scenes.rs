//! The reference scenes at many grids and in many poses.

use csg::{Meshed, Mesher, Program, Solid};
use stereotomy::{csg, scenes};

use super::defects::{largest_miss, measure, size};

/// A scene and what is known of it.
struct Scene {
    name: &'static str,
    solid: Solid,
    volume: f64,
    /// Summed over the components of the boundary.
    genus: Option<i64>,
    components: Option<usize>,
    /// The fewest cells along the longest side, home or turned, that put more
    /// than two across its smallest feature.
    resolved: u32,
    /// Whether all faces are planes: the volume is exact then.
    flat: bool,
}

fn reference_scenes() -> Vec<Scene> {
    let scene = |name, solid, volume, genus, components, resolved, flat| Scene {
        name,
        solid,
        volume,
        genus,
        components,
        resolved,
        flat,
    };
    let cheese = scenes::cheese_volume(100).expect("known");
    vec![
        scene(
            "sphere",
            scenes::sphere(),
            scenes::SPHERE_VOLUME,
            Some(0),
            Some(1),
            8,
            false,
        ),
        scene(
            "drilled",
            scenes::drilled(),
            scenes::DRILLED_VOLUME,
            Some(5),
            Some(1),
            32,
            false,
        ),
        scene(
            "tricylinder",
            scenes::tricylinder(),
            scenes::TRICYLINDER_VOLUME,
            Some(0),
            Some(1),
            8,
            false,
        ),
        scene(
            "sponge 2",
            scenes::menger(2),
            scenes::menger_volume(2),
            Some(81),
            Some(1),
            32,
            true,
        ),
        scene(
            "sponge 3",
            scenes::menger(3),
            scenes::menger_volume(3),
            Some(1409),
            Some(1),
            90,
            true,
        ),
        // Some of its walls are thinner than any cell.
        scene(
            "cheese",
            scenes::cheese(100),
            cheese,
            None,
            None,
            u32::MAX,
            false,
        ),
        scene(
            "rotated box",
            scenes::rotated_box(),
            scenes::ROTATED_BOX_VOLUME,
            Some(0),
            Some(1),
            16,
            true,
        ),
        scene(
            "shell",
            scenes::shell(0.1),
            scenes::shell_volume(0.1),
            Some(0),
            Some(2),
            48,
            false,
        ),
        scene(
            "thin shell",
            scenes::shell(0.02),
            scenes::shell_volume(0.02),
            Some(0),
            Some(2),
            210,
            false,
        ),
        scene(
            "flange",
            scenes::flange(),
            scenes::FLANGE_VOLUME,
            Some(9),
            Some(1),
            50,
            false,
        ),
    ]
}

fn turned(solid: &Solid) -> Solid {
    solid.rotate_xyz(0.3, 0.5, 0.7)
}

fn mesh(solid: &Solid, cells: u32) -> (Program, Meshed) {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().cells(cells).mesh(&program).expect("a mesh");
    (program, meshed)
}

const GRIDS: [u32; 4] = [32, 50, 101, 211];

impl Scene {
    /// The grids to try: what has many faces is not tried at the finest.
    fn grids(&self) -> impl Iterator<Item = u32> {
        let most = if self.genus > Some(9) { 101 } else { 211 };
        GRIDS.into_iter().filter(move |&cells| cells <= most)
    }
}

#[test]
fn manifold_everywhere_and_of_the_right_kind_where_resolved() {
    for scene in reference_scenes() {
        for (pose, solid) in [
            ("home", scene.solid.clone()),
            ("turned", turned(&scene.solid)),
        ] {
            for cells in scene.grids() {
                let (_, Meshed { mesh, report, .. }) = mesh(&solid, cells);
                let name = format!("{} {pose} at {cells}", scene.name);
                let check = &report.check;
                assert!(check.is_manifold(), "{name}: {check}");
                if cells < scene.resolved {
                    continue;
                }
                assert_eq!(check.genus(), scene.genus, "{name}");
                assert_eq!(Some(check.components), scene.components, "{name}");
                let error = (mesh.volume() / scene.volume - 1.0).abs();
                // Chords of a cell under the smallest radius, which the
                // resolution is in proportion to.
                let size = if scene.flat {
                    1e-13
                } else {
                    4.0 / f64::from(cells).powi(2) * f64::from(scene.resolved) / 8.0
                };
                assert!(error < size, "{name}: volume off by {error:e} of {size:e}");
            }
        }
    }
}

#[test]
fn vertices_are_on_the_surfaces_that_their_triangles_claim() {
    for scene in reference_scenes() {
        for solid in [scene.solid.clone(), turned(&scene.solid)] {
            for cells in [50, 101] {
                let (program, Meshed { mesh, report, .. }) = mesh(&solid, cells);
                let name = format!("{} at {cells}", scene.name);
                // Where surfaces had no common point the mesher says so.
                let is_excused = report
                    .fallbacks
                    .iter()
                    .any(|f| f.kind.contains("common point"));
                assert!(
                    !is_excused || cells < scene.resolved,
                    "{name}: {:?}",
                    report.fallbacks
                );
                let miss = largest_miss(&program, &mesh) / size(&mesh);
                assert!(is_excused || miss < 1e-13, "{name}: {miss:e}");
            }
        }
    }
}

#[test]
fn no_folded_flat_or_doubled_triangles_and_no_fallbacks_where_resolved() {
    for scene in reference_scenes() {
        for (pose, solid) in [
            ("home", scene.solid.clone()),
            ("turned", turned(&scene.solid)),
        ] {
            for cells in [32, 75, 110] {
                if cells < scene.resolved {
                    continue;
                }
                let (program, Meshed { mesh, report, .. }) = mesh(&solid, cells);
                let name = format!("{} {pose} at {cells}", scene.name);
                let found = measure(&program, &mesh);
                let defects = found.folded + found.without_area + found.duplicates;
                assert!(defects == 0, "{name}: {found:?}");
                assert!(
                    report.fallbacks.is_empty(),
                    "{name}: {:?}",
                    report.fallbacks
                );
            }
        }
    }
}

#[test]
fn far_away_and_at_any_scale_as_at_home() {
    let solid = turned(&scenes::drilled());
    let (home_program, home) = mesh(&solid, 64);
    let home_volume = home.mesh.volume();
    for scale in [1e-6, 1e6] {
        let (program, Meshed { mesh, report, .. }) = mesh(&solid.scale(scale), 64);
        assert_eq!(report.check.genus(), Some(5), "{scale}");
        let miss = measure(&program, &mesh).miss;
        assert!(miss < 1e-13, "{scale}: {miss:e}");
        let error = mesh.volume() / scale.powi(3) / home_volume - 1.0;
        assert!(error.abs() < 1e-4, "{scale}: volume off by {error:e}");
    }
    for distance in [1e6, 1e9, 1e12] {
        let offset = glam::dvec3(0.6, -0.48, 0.64) * distance;
        let (
            _,
            Meshed {
                mut mesh, report, ..
            },
        ) = mesh(&solid.translate(offset), 64);
        assert_eq!(report.check.genus(), Some(5), "{distance:e}");
        for position in &mut mesh.positions {
            *position -= offset;
        }
        // The surfaces are numbered as at home.
        let miss = largest_miss(&home_program, &mesh);
        let allowed = 1e-13 + 4.0 * f64::EPSILON * distance;
        assert!(miss < allowed, "{distance:e}: {miss:e} of {allowed:e}");
        let error = mesh.volume() / home_volume - 1.0;
        let allowed = 1e-4 + 4.0 * f64::EPSILON * distance * home.mesh.area() / home_volume;
        assert!(
            error.abs() < allowed,
            "{distance:e}: volume off by {error:e}"
        );
    }
}
