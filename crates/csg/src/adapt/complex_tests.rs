//! The complex on random unbalanced octrees with random transitions and
//! random pairings: whatever they are, the surface is manifold. No solid and
//! no geometry is behind them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DVec3, UVec3};

use super::complex::{Complex, Corner, Cut, Edge, FaceCrossing, Pairing, Transition};
use super::tree::{Node, Place, ROOT_BITS, Tree};
use crate::mesh::Mesh;
use crate::random::Random;

impl Pairing for Random {
    /// Any pairing without crossings: the first with any partner that leaves
    /// evenly many on both sides, then each side by itself.
    fn pair(&mut self, crossings: &[FaceCrossing], pairs: &mut Vec<(usize, usize)>) {
        let mut pending = vec![(0, crossings.len())];
        while let Some((start, end)) = pending.pop() {
            if start == end {
                continue;
            }
            let partner = start + 1 + 2 * self.below((end - start) / 2);
            let pair = (start, partner);
            assert_ne!(crossings[pair.0].enters, crossings[pair.1].enters);
            let ends_first = !crossings[pair.0].enters;
            pairs.push(if ends_first { pair } else { (pair.1, pair.0) });
            pending.push((start + 1, partner));
            pending.push((partner + 1, end));
        }
    }
}

/// A tree whose nodes are split at random, and its number of leaves.
fn random_tree(random: &mut Random, levels: u32, one_in: usize) -> (Tree, u32) {
    let mut tree = Tree {
        nodes: vec![Node::Constant],
    };
    let mut leaves = 0;
    let mut pending = vec![(0usize, 0u32)];
    while let Some((node, level)) = pending.pop() {
        if level == 0 || (level < levels && random.below(one_in) != 0) {
            let first = tree.nodes.len();
            tree.nodes[node] = Node::Children(first as u32);
            tree.nodes.extend([Node::Constant; 8]);
            pending.extend((0..8).map(|octant| (first + octant, level + 1)));
        } else {
            tree.nodes[node] = Node::Leaf(leaves);
            leaves += 1;
        }
    }
    (tree, leaves)
}

/// Random signs at the corners, nothing inside on the outermost layer, and up
/// to `more` pairs of transitions beyond what they ask for.
fn random_edges(
    random: &mut Random,
    tree: &Tree,
    more: usize,
    inside_of_four: usize,
) -> (Vec<Edge>, Vec<Transition>) {
    let mut signs: HashMap<UVec3, bool> = HashMap::new();
    let mut edges = Vec::new();
    let mut transitions = Vec::new();
    tree.for_each_edge(|leaf| {
        let mut sign = |point: UVec3| {
            let border = (0..3).any(|a| point[a] == 0 || point[a] == 1 << ROOT_BITS);
            match signs.entry(point) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(vacant) => {
                    *vacant.insert(!border && random.below(4) < inside_of_four)
                }
            }
        };
        let mut end = leaf.start;
        end[leaf.axis] += leaf.length;
        let (low, high) = (sign(leaf.start), sign(end));
        let count = usize::from(low != high) + 2 * random.below(more + 1);
        if count > 0 {
            let first = transitions.len() as u32;
            for rank in 0..count {
                transitions.push(Transition {
                    edge: edges.len() as u32,
                    enters: (rank % 2 == 0) != low,
                });
            }
            edges.push(Edge {
                axis: leaf.axis,
                cells: leaf.cells,
                small: leaf.small,
                start: leaf.start,
                first,
                count: count as u32,
            });
        }
    });
    (edges, transitions)
}

/// The surface as a mesh; places are of no account.
fn mesh(
    complex: &Complex,
    edges: &[Edge],
    transitions: &[Transition],
    random: &mut Random,
) -> Mesh {
    let mut index: HashMap<Corner, u32> = HashMap::new();
    let mut triangles = Vec::new();
    complex.triangles(
        edges,
        transitions,
        |_, _, safe| match random.below(3) {
            0 if safe[0] => Cut::First,
            1 if safe[1] => Cut::Second,
            _ => Cut::Middle,
        },
        |_, corners| {
            triangles.push(corners.map(|corner| {
                let next = index.len() as u32;
                *index.entry(corner).or_insert(next)
            }));
        },
    );
    let positions = (0..index.len()).map(|i| DVec3::splat(i as f64)).collect();
    Mesh::new(positions, triangles)
}

#[test]
fn random_octrees_with_random_transitions_and_pairings_are_manifold() {
    let mut triangles = 0;
    for seed in 0..600 {
        let mut random = Random(seed);
        let levels = 1 + random.below(4) as u32;
        let (tree, _) = random_tree(&mut random, levels, 2);
        let more = random.below(3);
        let inside_of_four = random.below(4);
        let (edges, transitions) = random_edges(&mut random, &tree, more, inside_of_four);
        let mut complex = Complex::default();
        complex.build(&edges, &transitions, None, &mut random);
        let mesh = mesh(&complex, &edges, &transitions, &mut random);
        let check = mesh.check();
        assert!(check.is_manifold(), "seed {seed}: {check}");
        assert_eq!(check.unreferenced_vertices, 0, "seed {seed}");
        triangles += mesh.triangles.len();
    }
    assert!(triangles > 30_000, "{triangles}");
}

#[test]
fn one_inside_corner_is_a_sphere_the_right_way_out() {
    let mut random = Random(1);
    for split in 0..8 {
        // Eight cells, one of them split again: its middle is inside, or that
        // of all.
        let mut tree = Tree {
            nodes: vec![Node::Children(1)],
        };
        tree.nodes.extend((0..8).map(Node::Leaf));
        if split > 0 {
            tree.nodes[1 + split] = Node::Children(9);
            tree.nodes.extend((8..16).map(Node::Leaf));
        }
        let half = 1 << (ROOT_BITS - 1);
        let mut edges = Vec::new();
        let mut transitions = Vec::new();
        tree.for_each_edge(|leaf| {
            let mut end = leaf.start;
            end[leaf.axis] += leaf.length;
            let inside = [leaf.start, end].map(|p| p == UVec3::splat(half));
            if inside[0] != inside[1] {
                transitions.push(Transition {
                    edge: edges.len() as u32,
                    enters: inside[1],
                });
                edges.push(Edge {
                    axis: leaf.axis,
                    cells: leaf.cells,
                    small: leaf.small,
                    start: leaf.start,
                    first: edges.len() as u32,
                    count: 1,
                });
            }
        });
        assert_eq!(edges.len(), 6);
        let mut complex = Complex::default();
        complex.build(&edges, &transitions, None, &mut random);
        assert_eq!(complex.loops.len(), 8);
        // Each loop's vertex: the mean of points on its transitions' edges.
        let middle = |t: u32| {
            let edge = &edges[t as usize];
            let mut p = edge.start.as_dvec3() / f64::from(half);
            p[edge.axis] += 0.1;
            p
        };
        let mut positions = Vec::new();
        for of in &complex.loops {
            let all = complex.transitions_of(of);
            assert_eq!(all.len(), 3);
            positions.push(all.iter().map(|&(t, _)| middle(t)).sum::<DVec3>() / 3.0);
        }
        let mut triangles = Vec::new();
        complex.triangles(
            &edges,
            &transitions,
            |_, _, _| Cut::First,
            |_, corners| {
                triangles.push(corners.map(|corner| match corner {
                    Corner::Loop(index) => index,
                    other => panic!("{other:?}"),
                }));
            },
        );
        let mesh = Mesh::new(positions, triangles);
        assert!(mesh.check().is_manifold());
        assert_eq!(mesh.triangles.len(), 12);
        assert!(mesh.volume() > 0.0, "{split}: {}", mesh.volume());
    }
}

#[test]
fn places_reach_the_finest_level() {
    let mut place = Place::ROOT;
    for _ in 0..super::tree::MOST_LEVELS {
        place = place.child(7);
    }
    assert_eq!(place.size(), 4);
    assert_eq!(place.corner, UVec3::splat((1 << ROOT_BITS) - 4));
}
