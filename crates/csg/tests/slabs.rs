//! Slabs put together are the whole mesh, to the bit.

use crate::random::Random;
use csg::glam::DVec3;
use csg::{Merger, Meshed, Mesher, Program, Slab, Solid};

fn slabs(mesher: &Mesher, program: &Program, of: u32) -> Vec<Slab> {
    let slabs = (0..of).rev().map(|part| mesher.slab(program, part, of));
    slabs.collect::<Result<_, _>>().expect("slabs")
}

/// A cube less small spheres: with few cells, many of them thinner than one.
fn swiss_cheese(spheres: usize, radius: f64) -> Solid {
    let mut random = Random(7);
    let holes = (0..spheres).map(|i| {
        let size = radius * (1 + random.below(5)) as f64;
        let place = DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
        Solid::sphere(size)
            .translate(place)
            .named(format!("hole {}", i % 3))
    });
    (Solid::cube(2.0) - Solid::union(holes)).named("cheese")
}

/// What is the same for all these numbers of slabs, and how many vertices were merged.
fn check(solid: &Solid, cells: u32, counts: &[u32]) -> (Meshed, usize) {
    let program = Program::lower(solid).expect("a valid solid");
    let mesher = Mesher::new().cells(cells).normals().check(false);
    let mut whole = mesher.mesh(&program).expect("a mesh");
    whole.report.stages.clear();
    let mut merged_vertices = 0;
    for &of in counts {
        let slabs = slabs(&mesher, &program, of);
        let vertices: usize = slabs.iter().map(|slab| slab.positions.len()).sum();
        let merger = Merger::new(slabs).expect("slabs of one mesh");
        let mesh = merger.mesh_with_normals().expect("a mesh");
        assert!(mesh.positions == whole.mesh.positions, "positions of {of}");
        assert!(mesh.triangles == whole.mesh.triangles, "triangles of {of}");
        assert!(mesh == whole.mesh, "mesh of {of}");
        assert_eq!(merger.report(), &whole.report, "report of {of}");
        merged_vertices = vertices - merger.vertex_count();
        let corners = (0..merger.pieces()).flat_map(|piece| {
            let made = merger.triangles(piece, true).expect("a piece");
            assert_eq!(made.corners.len(), made.triangles.len());
            made.corners
        });
        let whole_corners = (0..whole.mesh.triangles.len()).map(|t| whole.mesh.corners(t));
        assert!(corners.eq(whole_corners), "corners of {of}");
        assert_eq!(merger.vertex_count(), whole.mesh.positions.len());
        assert_eq!(merger.triangle_count(), whole.mesh.triangles.len());
    }
    (whole, merged_vertices)
}

#[test]
fn slabs_of_a_drilled_cube_are_the_whole() {
    let rod = Solid::infinite_cylinder(0.4).rotate_x(0.7).rotate_z(0.3);
    let solid = ((Solid::cube(1.5) & Solid::sphere(1.0)) - rod).translate([10.0, 0.0, -3.0]);
    for cells in [1, 14, 33, 100] {
        check(&solid, cells, &[1, 2, 3, 7, 64, 1000]);
    }
}

#[test]
fn what_is_cleaned_up_across_slabs_is_the_same() {
    let solid = swiss_cheese(400, 0.02);
    let (_, merged) = check(&solid, 60, &[1, 2, 5, 16, 125, 300]);
    assert!(merged > 200, "{merged}");
}

#[test]
fn where_most_is_thinner_than_a_cell_the_same_is_left() {
    let (whole, _) = check(&swiss_cheese(8000, 0.01), 50, &[1, 4, 23]);
    let left = whole.report.fallbacks.iter();
    let left = left.filter(|fallback| fallback.kind.starts_with("triangle without area"));
    assert!(left.map(|fallback| fallback.count).sum::<usize>() > 4000);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let program = Program::lower(&swiss_cheese(50, 0.05)).expect("a valid solid");
    let mesher = Mesher::new().cells(50);
    let slab = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| mesher.slab(&program, 2, 5))
    };
    let alone = slab(1);
    assert!(alone.as_ref().is_ok_and(|slab| !slab.triangles.is_empty()));
    assert!(alone == slab(3));
}

#[test]
fn an_empty_solid_has_empty_slabs() {
    let (whole, _) = check(&(Solid::sphere(1.0) - Solid::cube(3.0)), 20, &[1, 3]);
    assert!(whole.mesh.triangles.is_empty());
}

#[test]
fn what_is_no_whole_is_told() {
    let program = Program::lower(&Solid::sphere(1.0)).expect("a sphere");
    let mesher = Mesher::new().cells(20);
    let slabs: Vec<Slab> = (0..3)
        .map(|part| mesher.slab(&program, part, 3).expect("a slab"))
        .collect();
    let problem = |slabs: Vec<Slab>| match Merger::new(slabs) {
        Err(error) => error.to_string(),
        Ok(_) => "none".to_owned(),
    };
    let [a, b, c] = [0, 1, 2].map(|i: usize| slabs[i].clone());
    assert_eq!(problem(vec![c.clone(), a.clone(), b.clone()]), "none");
    assert_eq!(
        problem(vec![c.clone(), a.clone()]),
        "slab 1 of 3: it is one of 3 slabs, and slab 2 is missing"
    );
    assert_eq!(
        problem(vec![a.clone(), b.clone()]),
        "slab 1 of 3: it is one of 3 slabs, and slab 3 is missing"
    );
    assert_eq!(
        problem(vec![a.clone(), b.clone(), b.clone(), c.clone()]),
        "slab 2 of 3: it is slab 2 of 3, as is slab 2 of 3"
    );
    let finer = Mesher::new()
        .cells(21)
        .slab(&program, 1, 3)
        .expect("a slab");
    assert!(
        problem(vec![a.clone(), finer, c.clone()]).contains("of another mesh than slab 1 of 3")
    );
    let other = Program::lower(&Solid::sphere(1.0).named("ball")).expect("a sphere");
    let other = mesher.slab(&other, 1, 3).expect("a slab");
    assert!(problem(vec![a.clone(), other, c.clone()]).contains("of another mesh"));
    let mut damaged = b.clone();
    damaged.triangles[0][0] = u32::MAX;
    let made = Merger::new(vec![a.clone(), damaged, c.clone()]).and_then(|merger| merger.mesh());
    let problem = made.err().map(|error| error.to_string());
    let told = "slab 2 of 3: its triangles name vertices that are not there";
    assert_eq!(problem.as_deref(), Some(told));
    let mut damaged = b;
    damaged.positions.pop();
    let made = Merger::new(vec![a, damaged, c]).and_then(|merger| merger.mesh());
    let problem = made.err().map(|error| error.to_string());
    let told = "slab 2 of 3: it has another number of vertices than it says";
    assert_eq!(problem.as_deref(), Some(told));
    assert!(problem_of(&mesher, &program, 3, 3).contains("counted from 0"));
    assert!(problem_of(&Mesher::new(), &program, 0, 3).contains("without cells"));
    assert!(problem_of(&mesher.clone().draft(), &program, 0, 3).contains("draft"));
    assert!(problem_of(&mesher.tolerance(0.1), &program, 0, 3).contains("tolerance"));
}

fn problem_of(mesher: &Mesher, program: &Program, part: u32, of: u32) -> String {
    let error = mesher.slab(program, part, of).err();
    error.expect("no such slab").to_string()
}
