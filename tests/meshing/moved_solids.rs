//! Random solids far away and at other scales.

use csg::{Mesh, Meshed, Program};
use stereotomy::csg;

use super::defects::{largest_miss, size};
use super::random_solids::{grids, mesh};
use crate::random::Random;

#[test]
fn moved_and_scaled_solids_are_as_accurate_as_at_home() {
    let mut clean = 0;
    for seed in 3000..3080 {
        let mut random = Random::new(seed);
        let solid = random.solid();
        let cells = grids(&mut random)[1];
        let home = Program::lower(&solid).expect("valid");
        let offset = 1e6 * glam::dvec3(0.6, -0.48, 0.64);
        for scale in [1.0, 1e-6, 1e6] {
            let moved = solid
                .scale(scale)
                .translate(offset * f64::from(u8::from(scale == 1.0)));
            let program = Program::lower(&moved).expect("valid");
            let name = format!("seed {seed} at {cells} by {scale}");
            let Meshed { mesh, report, .. } = mesh(&program, cells);
            assert!(report.check.is_manifold(), "{name}: {}", report.check);
            if !report.fallbacks.is_empty() || mesh.triangles.is_empty() {
                continue;
            }
            clean += 1;
            let back = Mesh {
                positions: mesh
                    .positions
                    .iter()
                    .map(|&p| if scale == 1.0 { p - offset } else { p / scale })
                    .collect(),
                ..mesh
            };
            if home.surfaces().len() != program.surfaces().len() {
                continue;
            }
            let miss = largest_miss(&home, &back);
            let distance = if scale == 1.0 { offset.length() } else { 0.0 };
            let allowed = 1e-12 * size(&back) + 4.0 * f64::EPSILON * distance;
            assert!(miss < allowed, "{name}: {miss:e} of {allowed:e}");
        }
    }
    assert!(clean >= 20, "{clean}");
}
