//! Identities of measures, on random solids.

use csg::brep::{Bounded, SolidMeasure};
use csg::{Mesher, Program, Solid};
use stereotomy::csg;

use super::boundary;
use super::sound::assert_sound;
use crate::random::Random;
use crate::sweeps::one_in;

/// The measures of a solid that was not moved; else none, and so many are.
fn measured(solid: &Solid, name: &str, undecided: &mut u32) -> Option<SolidMeasure> {
    match boundary(solid) {
        Ok(brep) if brep.moved().is_none() => Some(brep.measure()),
        Ok(_) => None,
        Err(error) => {
            println!("{name}: {error}");
            *undecided += 1;
            None
        }
    }
}

fn assert_sum(terms: &[(f64, Bounded)], name: &str) {
    let sum: f64 = terms.iter().map(|(sign, term)| sign * term.value).sum();
    let error: f64 = terms.iter().map(|(_, term)| term.error).sum();
    assert!(sum.abs() <= error, "{name}: {sum:e} {error:e} {terms:?}");
    assert!(error < 1e-9, "{name}: {error:e}");
}

/// V(A ∪ B) + V(A ∩ B) = V(A) + V(B), and V(A - B) + V(A ∩ B) = V(A): the boundaries of the
/// combinations have other faces, edges and vertices.
#[test]
fn volumes_of_combinations_add_up() {
    let (mut tried, mut undecided) = (0, 0);
    let step = one_in(5);
    for seed in (0..30).step_by(step) {
        let mut random = Random::new(seed);
        let [a, b] = [random.solid(), random.solid()];
        let name = format!("seed {seed}");
        let parts = [a.clone(), b.clone(), &a | &b, &a & &b, &a - &b];
        let parts = parts.map(|part| measured(&part, &name, &mut undecided));
        let [Some(a), Some(b), Some(or), Some(and), Some(less)] =
            parts.map(|m| m.map(|m| m.volume))
        else {
            continue;
        };
        tried += 1;
        assert_sum(&[(1.0, or), (1.0, and), (-1.0, a), (-1.0, b)], &name);
        assert_sum(&[(1.0, less), (1.0, and), (-1.0, a)], &name);
    }
    assert!(tried * step >= 21, "{tried}");
    assert!(undecided <= 2, "{undecided}");
}

/// Every part of the boundary of random solids is where the program's is, and measures are
/// those of a mesh to a tolerance.
#[test]
fn boundaries_are_sound_and_agree_with_meshes() {
    let (mut tried, mut wrong) = (0u32, 0.0);
    for seed in 500..560 {
        let mut random = Random::new(seed);
        let solid = random.solid();
        let name = format!("seed {seed}");
        let program = Program::lower(&solid).expect("valid");
        let Ok(brep) = boundary(&solid) else {
            continue;
        };
        tried += 1;
        wrong += assert_sound(&brep, &program, &name);
        let measure = brep.measure();
        let mesh = Mesher::new()
            .tolerance(1e-3)
            .mesh(&program)
            .expect("a mesh");
        let deviation = mesh.report.deviation.unwrap_or(1e-3);
        // A layer as thick as that all around, and as much again for its second order.
        let most = 2.0 * deviation * measure.area.upper() + measure.volume.error;
        let off = (mesh.mesh.volume() - measure.volume.value).abs();
        assert!(
            off <= most,
            "{name}: {off} {most} {:?}",
            mesh.report.fallbacks
        );
    }
    assert!(tried >= 55, "{tried}");
    // Walls thinner than the distance at which is looked.
    assert!(wrong / f64::from(tried) < 0.02, "{wrong} of {tried}");
}
