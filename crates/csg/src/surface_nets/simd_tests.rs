//! The same mesh, bit for bit, on vectors of every width.

use super::mesh_on;
use crate::control::Control;
use crate::program::Program;
use crate::report::Report;
use crate::solid::Solid;
use crate::task::Task;

fn levels() -> Vec<pulp::Arch> {
    let mut levels = vec![pulp::Arch::Scalar, pulp::Arch::new()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
    levels
}

/// Planes, spheres, oblique cylinders and a cone, cut and joined.
fn solids() -> [Solid; 3] {
    let rod = Solid::infinite_cylinder(0.4).rotate_x(0.7).rotate_z(0.3);
    let drilled = (Solid::cube(1.5) & Solid::sphere(1.0)) - &rod;
    let cone = Solid::cone(0.8, -0.8..0.8).rotate_y(0.4);
    let slab = Solid::half_space([0.3, -0.2, 1.0], 0.1);
    [
        drilled.clone(),
        (&cone | &rod) & Solid::cube(1.7),
        (drilled | cone) & slab,
    ]
}

#[test]
fn every_vector_width_gives_the_same_mesh() {
    for (i, solid) in solids().iter().enumerate() {
        let program = Program::lower(solid).expect("a valid solid");
        let bounds = program.bounds().expect("bounded").expect("not empty");
        let (origin, size) = (bounds.center(), bounds.size());
        let control = Control::default();
        let task = Task {
            program: &program,
            surfaces: program.surfaces_about(origin),
            origin,
            size,
            cell: size.max_element() / 40.0,
            control: &control,
        };
        let meshes = levels().into_iter().map(|level| {
            let mut report = Report::default();
            let mesh = mesh_on(level, &task, &mut report).expect("nobody cancels");
            (mesh, report.fallbacks)
        });
        let meshes: Vec<_> = meshes.collect();
        assert!(meshes[0].0.triangles.len() > 1000, "solid {i}");
        for (level, other) in meshes.iter().enumerate().skip(1) {
            assert!(meshes[0] == *other, "solid {i}, level {level}");
        }
    }
}
