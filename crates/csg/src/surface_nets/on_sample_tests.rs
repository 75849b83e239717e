//! Solids whose faces, edges and corners lie exactly on samples: what the
//! lattice's shift avoids in ordinary models must do no harm where it happens.

use glam::DVec3;

use super::lattice::Lattice;
use crate::mesher::{Meshed, Mesher};
use crate::program::{Bounds, Program};
use crate::solid::Solid;

/// Cells this wide in bounds this far: the samples are then where
/// [`Lattice::around`] says, the origin of the bounds being 0.
const STEP: f64 = 0.125;
const BOUNDS: Bounds = Bounds {
    min: DVec3::splat(-2.0),
    max: DVec3::splat(2.0),
};

/// The sample at the given place in the lattice.
fn sample(at: [u32; 3]) -> DVec3 {
    let lattice = Lattice::around(&BOUNDS, STEP).expect("few cells");
    DVec3::from_array([0, 1, 2].map(|axis| lattice.coordinate(axis, at[axis])))
}

fn mesh(solid: &Solid) -> (Program, Meshed) {
    let program = Program::lower(solid).expect("valid");
    let mesher = Mesher::new().bounds(BOUNDS).cell_size(STEP);
    let meshed = mesher.mesh(&program).expect("bounded");
    (program, meshed)
}

/// Samples that lie on some surface, among those of a cube of the lattice.
fn samples_on_surfaces(program: &Program) -> usize {
    let inner = 3..30;
    let samples = inner
        .clone()
        .flat_map(|z| inner.clone().map(move |y| [y, z]))
        .flat_map(|[y, z]| (3..30).map(move |x| sample([x, y, z])));
    samples
        .filter(|&point| program.surfaces().iter().any(|s| s.value(point) == 0.0))
        .count()
}

fn largest_miss(program: &Program, meshed: &Meshed) -> f64 {
    let mesh = &meshed.mesh;
    (0..mesh.triangles.len())
        .flat_map(|t| mesh.corners(t).map(|corner| (t, corner)))
        .map(|(t, corner)| {
            let id = mesh.surface_of(t).expect("an exact mesh").surface;
            let surface = &program.surfaces()[id as usize];
            surface.value(corner).abs() / surface.gradient(corner).length()
        })
        .fold(0.0, f64::max)
}

#[test]
fn boxes_between_samples_are_exact() {
    let (low, high) = (sample([5, 7, 9]), sample([25, 20, 17]));
    let block = Solid::cuboid_between(low, high);
    // Beside it, face to face; and one that shares an edge's line only.
    let beside = Solid::cuboid_between(sample([25, 10, 9]), sample([28, 20, 30]));
    let pocket = Solid::cuboid_between(sample([10, 10, 12]), sample([20, 15, 17]));
    let volume = |low: DVec3, high: DVec3| (high - low).element_product();
    let own = volume(low, high);
    for (solid, expected) in [
        (block.clone(), own),
        (
            &block | &beside,
            own + volume(sample([25, 10, 9]), sample([28, 20, 30])),
        ),
        (
            &block - &pocket,
            own - volume(sample([10, 10, 12]), sample([20, 15, 17])),
        ),
    ] {
        let (program, meshed) = mesh(&solid);
        assert!(samples_on_surfaces(&program) > 1000);
        let Meshed { mesh, report, .. } = &meshed;
        assert!(report.check.is_manifold(), "{}", report.check);
        assert_eq!(report.check.genus(), Some(0));
        assert_eq!(report.check.components, 1);
        assert!(report.fallbacks.is_empty(), "{:?}", report.fallbacks);
        let error = mesh.volume() - expected;
        assert!(error.abs() < 1e-13 * expected, "{error:e}");
    }
}

#[test]
fn curved_surfaces_through_samples_keep_their_vertices() {
    let center = sample([16, 16, 16]);
    // 3-4-5 and 5-12-13 triples of steps put many samples on the sphere, up
    // to rounding; the cone's apex is one, too, and so is every point of the
    // rod's axis.
    let ball = Solid::sphere(5.0 * STEP).translate(center);
    let rod = Solid::cylinder(5.0 * STEP, -10.0 * STEP..7.0 * STEP).translate(center);
    let cone = Solid::cone(6.0 * STEP, 0.0..6.0 * STEP).translate(center);
    let notch = Solid::cube(8.0 * STEP).translate(center + 4.0 * STEP);
    for solid in [&ball - &notch, &rod | &ball, cone - &rod, rod - ball, notch] {
        let (program, meshed) = mesh(&solid);
        let report = &meshed.report;
        assert!(report.check.is_manifold(), "{}", report.check);
        let miss = largest_miss(&program, &meshed);
        let excused = report.fallbacks.iter().any(|f| f.kind.contains("common"));
        assert!(excused || miss < 1e-13, "{miss:e}: {:?}", report.fallbacks);
    }
}
