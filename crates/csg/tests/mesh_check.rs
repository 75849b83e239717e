//! Every check must pass on meshes that are whole and fail on meshes that
//! have just the one defect it is for.

use crate::shapes::{cuboid, joined, mapped, torus, unit_cube, unit_tetrahedron};
use csg::{Mesh, MeshCheck, MeshDefect};
use glam::{DVec3, dvec3};
use proptest::prelude::*;

/// The defects of a mesh with their counts, and the places checked to match.
fn defects(mesh: &Mesh) -> (MeshCheck, Vec<(MeshDefect, usize)>) {
    let check = mesh.check();
    let found: Vec<_> = MeshDefect::ALL
        .into_iter()
        .map(|defect| (defect, check.count(defect)))
        .filter(|&(_, count)| count > 0)
        .collect();
    for defect in MeshDefect::ALL {
        let places = check.places.iter().filter(|p| p.defect == defect).count();
        assert_eq!(
            places,
            check.count(defect).min(csg::mesh::PLACES_PER_DEFECT)
        );
    }
    (check, found)
}

fn assert_whole(mesh: &Mesh, components: usize, genus: i64) {
    let (check, found) = defects(mesh);
    assert_eq!(found, [], "{check}");
    assert!(check.is_closed() && check.is_oriented() && check.is_manifold());
    assert_eq!(check.components, components);
    assert_eq!(check.genus(), Some(genus));
    assert_eq!(check.edges * 2, mesh.triangles.len() * 3);
    assert_eq!(
        check.euler_characteristic(),
        2 * components as i64 - 2 * genus
    );
}

#[test]
fn whole_meshes_pass_with_the_right_genus() {
    assert_whole(&unit_cube(), 1, 0);
    assert_whole(&unit_tetrahedron(), 1, 0);
    let ring = torus(2.0, 0.5, 24, 12);
    assert_whole(&ring, 1, 1);
    let far = mapped(&ring, |p| p + dvec3(10.0, 0.0, 0.0));
    assert_whole(&joined(&ring, &far), 2, 2);
    assert_whole(&joined(&unit_cube(), &far), 2, 1);
    assert_whole(&Mesh::default(), 0, 0);
}

#[test]
fn a_vertex_of_many_triangles_is_still_manifold() {
    // A double cone over a 1000-gon: apexes beyond the short scan.
    let n = 1000u32;
    let mut positions: Vec<DVec3> = (0..n)
        .map(|i| DVec3::from((glam::DVec2::from_angle(f64::from(i) * 0.00628), 0.0)))
        .collect();
    positions.extend([DVec3::Z, DVec3::NEG_Z]);
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| [[i, (i + 1) % n, n], [(i + 1) % n, i, n + 1]])
        .collect();
    let mesh = Mesh::new(positions, triangles);
    assert_whole(&mesh, 1, 0);
    let mut turned = mesh.clone();
    turned.triangles[777].swap(0, 1);
    assert_eq!(defects(&turned).1, [(MeshDefect::MisorientedEdge, 3)]);
    let mut open = mesh;
    open.triangles.remove(500);
    assert_eq!(defects(&open).1, [(MeshDefect::OpenEdge, 3)]);
}

#[test]
fn a_missing_triangle_opens_three_edges() {
    let mut mesh = unit_cube();
    mesh.triangles.remove(5);
    let (check, found) = defects(&mesh);
    assert_eq!(found, [(MeshDefect::OpenEdge, 3)]);
    assert!(!check.is_closed() && check.is_oriented() && !check.is_manifold());
    assert_eq!(check.genus(), None);
    // The places are the midpoints of the hole's edges.
    let hole = unit_cube().corners(5);
    for (i, corner) in hole.iter().enumerate() {
        let middle = corner.midpoint(hole[(i + 1) % 3]);
        assert!(check.places.iter().any(|place| place.at == middle));
    }
}

#[test]
fn a_turned_triangle_is_misoriented() {
    let mut mesh = unit_cube();
    mesh.triangles[3].swap(1, 2);
    let (check, found) = defects(&mesh);
    assert_eq!(found, [(MeshDefect::MisorientedEdge, 3)]);
    assert!(check.is_closed() && !check.is_oriented() && !check.is_manifold());
}

#[test]
fn cubes_welded_along_an_edge_are_not_manifold() {
    // Two cubes with the edge from (1, 1, 0) to (1, 1, 1) in common.
    let mut mesh = joined(
        &unit_cube(),
        &cuboid(dvec3(1.0, 1.0, 0.0), dvec3(2.0, 2.0, 1.0)),
    );
    assert!(
        mesh.check().is_manifold(),
        "coincident but separate is fine"
    );
    for vertex in mesh.triangles.as_flattened_mut() {
        match *vertex {
            8 => *vertex = 3,
            12 => *vertex = 7,
            _ => {}
        }
    }
    let (check, found) = defects(&mesh);
    assert_eq!(
        found,
        [
            (MeshDefect::NonManifoldEdge, 1),
            (MeshDefect::NonManifoldVertex, 2),
            (MeshDefect::UnreferencedVertex, 2),
        ]
    );
    assert!(check.is_closed() && check.is_oriented() && !check.is_manifold());
    assert_eq!(check.places[0].at, dvec3(1.0, 1.0, 0.5));
    assert_eq!(check.components, 1);
}

#[test]
fn cubes_welded_at_a_corner_are_not_vertex_manifold() {
    let mut mesh = joined(&unit_cube(), &cuboid(DVec3::ONE, DVec3::splat(2.0)));
    for vertex in mesh.triangles.as_flattened_mut() {
        if *vertex == 8 {
            *vertex = 7;
        }
    }
    let (check, found) = defects(&mesh);
    assert_eq!(
        found,
        [
            (MeshDefect::NonManifoldVertex, 1),
            (MeshDefect::UnreferencedVertex, 1)
        ]
    );
    assert!(check.is_closed() && check.is_oriented() && !check.is_manifold());
    assert_eq!((check.places[0].at, check.places[0].index), (DVec3::ONE, 7));
}

#[test]
fn three_triangles_on_one_edge_are_open_and_not_manifold() {
    let fin = Mesh::new(
        vec![DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::Y, DVec3::NEG_X],
        vec![[0, 1, 2], [0, 1, 3], [1, 0, 4]],
    );
    let (_, found) = defects(&fin);
    assert_eq!(
        found,
        [
            (MeshDefect::OpenEdge, 7),
            (MeshDefect::NonManifoldEdge, 1),
            (MeshDefect::NonManifoldVertex, 2),
        ]
    );
}

#[test]
fn degenerate_triangles_are_counted_and_left_out() {
    let mut mesh = unit_cube();
    mesh.triangles.push([2, 2, 5]);
    mesh.triangles.push([4, 4, 4]);
    let (check, found) = defects(&mesh);
    assert_eq!(found, [(MeshDefect::DegenerateTriangle, 2)]);
    assert!(check.is_closed() && check.is_oriented() && !check.is_manifold());
    assert_eq!(check.euler_characteristic(), 2);
    assert_eq!(check.places[1].index, 13);
}

#[test]
fn duplicates_are_found_in_any_order_and_direction() {
    let mut pillow = Mesh::new(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        vec![[0, 1, 2], [1, 0, 2]],
    );
    let (check, found) = defects(&pillow);
    assert_eq!(found, [(MeshDefect::DuplicateTriangle, 1)]);
    assert!(check.is_closed() && check.is_oriented() && !check.is_manifold());
    pillow.triangles[1] = [2, 0, 1];
    assert_eq!(
        defects(&pillow).1,
        [
            (MeshDefect::DuplicateTriangle, 1),
            (MeshDefect::MisorientedEdge, 3)
        ]
    );
    let mut cube = unit_cube();
    let [a, b, c] = cube.triangles[7];
    cube.triangles.push([b, c, a]);
    let (check, _) = defects(&cube);
    assert_eq!(check.duplicate_triangles, 1);
    assert_eq!((check.open_edges, check.non_manifold_edges), (3, 3));
}

#[test]
fn indices_out_of_range_are_reported() {
    let mut mesh = unit_cube();
    mesh.triangles[0][1] = 8;
    mesh.triangles.push([u32::MAX, 0, 1]);
    let (check, found) = defects(&mesh);
    assert_eq!(
        found,
        [
            (MeshDefect::OutOfRangeTriangle, 2),
            (MeshDefect::OpenEdge, 3)
        ]
    );
    assert!(!check.is_closed() && !check.is_manifold());
    assert_eq!(mesh.components().of_triangles[0], None);
    assert!(mesh.volume().is_finite());
    let only_bad = Mesh::new(Vec::new(), vec![[0, 1, 2]]);
    assert!(!only_bad.check().is_closed());
    assert_eq!(only_bad.components().count, 0);
}

#[test]
fn loose_and_non_finite_vertices_are_reported() {
    let mut mesh = unit_cube();
    mesh.positions.push(DVec3::ONE);
    let (check, found) = defects(&mesh);
    assert_eq!(found, [(MeshDefect::UnreferencedVertex, 1)]);
    assert!(check.is_manifold() && check.genus() == Some(0));
    mesh.positions[3].y = f64::NAN;
    let (check, found) = defects(&mesh);
    assert_eq!(
        found,
        [
            (MeshDefect::UnreferencedVertex, 1),
            (MeshDefect::NonFiniteVertex, 1)
        ]
    );
    assert!(check.is_closed() && !check.is_manifold());
}

#[test]
fn a_report_reads_as_one_line() {
    let mut mesh = unit_cube();
    assert_eq!(
        mesh.check().to_string(),
        "12 triangles, 18 edges, 8 vertices, 1 components"
    );
    mesh.triangles.push([2, 2, 5]);
    assert!(mesh.check().to_string().ends_with(
        "; 1 x triangle with a repeated vertex (first at [0.3333333333333333, 0.6666666666666666, 0.3333333333333333])"
    ));
}

/// The definitions, read off directly and slowly, to compare with.
fn counted_directly(mesh: &Mesh) -> [usize; 4] {
    use std::collections::{BTreeMap, BTreeSet};
    let mut edges: BTreeMap<[u32; 2], [i64; 2]> = BTreeMap::new();
    let mut links: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        if a == b || b == c || c == a {
            continue;
        }
        for [u, v, w] in [[a, b, c], [b, c, a], [c, a, b]] {
            let sides = edges.entry([u.min(v), u.max(v)]).or_default();
            sides[usize::from(u > v)] += 1;
            links.entry(u).or_default().push([v, w]);
        }
    }
    let open = edges.values().filter(|s| (s[0] + s[1]) % 2 == 1).count();
    let many = edges.values().filter(|s| s[0] + s[1] > 2).count();
    let turned = edges.values().filter(|s| (s[0] - s[1]).abs() > 1).count();
    let bad_links = links
        .values()
        .filter(|link| {
            let ends: BTreeSet<u32> = link.iter().flatten().copied().collect();
            let branches = ends
                .iter()
                .any(|end| link.iter().flatten().filter(|e| *e == end).count() > 2);
            let mut reached = BTreeSet::from([link[0][0]]);
            for _ in 0..link.len() {
                for &[a, b] in *link {
                    if reached.contains(&a) || reached.contains(&b) {
                        reached.extend([a, b]);
                    }
                }
            }
            branches || reached != ends
        })
        .count();
    [open, many, turned, bad_links]
}

proptest! {
    /// Random heaps of triangles on few vertices have every defect at once.
    #[test]
    fn counts_agree_with_the_definitions(
        triangles in prop::collection::vec(prop::array::uniform3(0u32..9), 0..40)
    ) {
        let positions = (0..9).map(|i| DVec3::splat(f64::from(i))).collect();
        let mesh = Mesh::new(positions, triangles);
        let (check, _) = defects(&mesh);
        let counted = [
            check.open_edges,
            check.non_manifold_edges,
            check.misoriented_edges,
            check.non_manifold_vertices,
        ];
        prop_assert_eq!(counted, counted_directly(&mesh));
    }

    /// Neither the numbering of vertices nor the order of triangles matters.
    #[test]
    fn a_shuffled_torus_is_still_a_torus(
        order in Just((0..96u32).collect::<Vec<_>>()).prop_shuffle(),
        rows in Just((0..192usize).collect::<Vec<_>>()).prop_shuffle(),
        turns in prop::collection::vec(0usize..3, 192),
    ) {
        let ring = torus(2.0, 0.5, 12, 8);
        let mut shuffled = ring.clone();
        for (old, &new) in order.iter().enumerate() {
            shuffled.positions[new as usize] = ring.positions[old];
        }
        for ((slot, &row), &turn) in shuffled.triangles.iter_mut().zip(&rows).zip(&turns) {
            *slot = ring.triangles[row].map(|v| order[v as usize]);
            slot.rotate_left(turn);
        }
        assert_whole(&shuffled, 1, 1);
    }
}

#[test]
fn places_do_not_depend_on_the_number_of_threads() {
    let mut mesh = torus(2.0, 0.5, 400, 150);
    mesh.triangles.retain(|t| t[0] % 1013 != 7);
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a thread pool")
            .install(|| (mesh.check(), mesh.measure()))
    };
    let one = run(1);
    assert!(one.0.open_edges > csg::mesh::PLACES_PER_DEFECT);
    assert_eq!(one, run(2));
    assert_eq!(one, run(8));
}
