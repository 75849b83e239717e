//! Properties of random solids.

use csg::{Meshed, Mesher, Program};
use glam::DVec3;
use stereotomy::csg;

use super::measures::assert_agrees;
use crate::random::Random;
use crate::sweeps::one_in;

/// How many solids are tried: a slice of what there is.
const SOLIDS: u64 = 160;

pub fn mesh(program: &Program, cells: u32) -> Meshed {
    Mesher::new().cells(cells).mesh(program).expect("a mesh")
}

/// A coarse and a fine grid for a solid.
pub fn grids(random: &mut Random) -> [u32; 2] {
    [4 + random.below(12) as u32, 24 + random.below(24) as u32]
}

#[test]
fn manifold_and_in_agreement_with_the_program() {
    let step = one_in(5);
    let mut meshed = 0;
    for seed in (0..SOLIDS).step_by(step) {
        let mut random = Random::new(seed);
        let program = Program::lower(&random.solid()).expect("a valid solid");
        for cells in grids(&mut random) {
            let name = format!("seed {seed} at {cells}");
            let Meshed { mesh, report, .. } = mesh(&program, cells);
            assert!(report.check.is_manifold(), "{name}: {}", report.check);
            assert_agrees(&program, &mesh, report.cell_size, &mut random, &name);
            meshed += usize::from(!mesh.triangles.is_empty());
        }
    }
    // Otherwise little was tried.
    assert!((meshed * step) as u64 > SOLIDS, "{meshed}");
}

#[test]
fn one_two_and_eight_threads_give_the_same_mesh() {
    let pools = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    });
    for seed in (1000..1040).step_by(one_in(5)) {
        let mut random = Random::new(seed);
        let program = Program::lower(&random.solid()).expect("a valid solid");
        let cells = grids(&mut random)[1];
        let [one, two, eight] = [0, 1, 2].map(|i| pools[i].install(|| mesh(&program, cells)));
        assert!(
            one.mesh == two.mesh && one.mesh == eight.mesh,
            "seed {seed} at {cells}"
        );
        assert_eq!(one.report.fallbacks, eight.report.fallbacks, "seed {seed}");
    }
}

#[test]
fn scaled_by_a_power_of_two_every_bit_of_the_mesh_is() {
    for seed in (2000..2040).step_by(one_in(5)) {
        let mut random = Random::new(seed);
        let solid = random.solid();
        let cells = grids(&mut random)[1];
        let home = mesh(&Program::lower(&solid).expect("valid"), cells).mesh;
        for scale in [0.5f64.powi(20), 2f64.powi(20)] {
            let scaled = solid.scale(scale);
            let scaled = mesh(&Program::lower(&scaled).expect("valid"), cells).mesh;
            assert_eq!(scaled.triangles, home.triangles, "seed {seed} by {scale}");
            let positions: Vec<DVec3> = home.positions.iter().map(|&p| p * scale).collect();
            assert!(scaled.positions == positions, "seed {seed} by {scale}");
        }
    }
}
