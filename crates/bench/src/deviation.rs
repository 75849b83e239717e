//! The measured two-sided distance between a mesh and the true boundary: the
//! same samples and the same code for every mesher.

use csg::{Mesh, Program};
use glam::DVec3;
use rayon::prelude::*;

use crate::measure::Largest;
use crate::truth::Truth;

/// Steps along an edge of a triangle's lattice of samples.
const LATTICE: usize = 5;
/// About so many samples of a mesh: of finer ones, coarser lattices and at
/// last only some triangles are taken.
const SAMPLES: usize = 300_000;
/// Rays along each axis, a side, and steps along each.
const RAYS: usize = 40;
const STEPS: usize = 200;

/// The largest distance of samples of the mesh to the boundary of the solid,
/// which lies well within the cube from -half to half.
pub fn mesh_to_boundary(program: &Program, half: f64, mesh: &Mesh) -> f64 {
    let count = mesh.triangles.len().max(1);
    let points_of = |steps: usize| (steps + 1) * (steps + 2) / 2;
    let steps = (1..=LATTICE)
        .rev()
        .find(|&steps| points_of(steps) * count <= SAMPLES);
    // Corners and edges tell less than centroids of fine triangles.
    let stride = count.div_ceil(SAMPLES / 4);
    let mut samples = Vec::new();
    for index in (0..mesh.triangles.len()).step_by(stride) {
        let [a, b, c] = mesh.corners(index);
        samples.push((a + b + c) / 3.0);
        let Some(steps) = steps.filter(|&steps| steps > 1) else {
            samples.extend([(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0]);
            continue;
        };
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
                samples.push(a + (b - a) * u + (c - a) * v);
            }
        }
    }
    let largest = Largest::default();
    Truth::new(program, half).visit(&samples, 0.02 * half, &|_, nearest| {
        largest.add(nearest.map_or(f64::INFINITY, |n| n.distance));
    });
    largest.value()
}

/// Points of the solid's boundary: where rays along the axes, which form a
/// lattice slightly askew to any symmetry, go in or out, to 1e-13 of `half`.
/// Features thinner than `half` / 100 may be missed.
pub fn boundary_samples(program: &Program, half: f64) -> Vec<DVec3> {
    let rays: Vec<(usize, usize, usize)> = (0..3)
        .flat_map(|axis| (0..RAYS * RAYS).map(move |k| (axis, k % RAYS, k / RAYS)))
        .collect();
    let along = |ray: &(usize, usize, usize)| {
        let &(axis, i, j) = ray;
        let mut origin = [0.0; 3];
        origin[(axis + 1) % 3] = half * (2.0 * (i as f64 + 0.437) / RAYS as f64 - 1.0);
        origin[(axis + 2) % 3] = half * (2.0 * (j as f64 + 0.561) / RAYS as f64 - 1.0);
        let at = move |t: f64| {
            let mut p = origin;
            p[axis] = half * (2.0 * t - 1.0);
            DVec3::from_array(p)
        };
        let mut found = Vec::new();
        let mut before = program.contains(at(0.0));
        for step in 1..=STEPS {
            let (mut low, mut high) = ((step - 1) as f64, step as f64);
            (low, high) = (low / STEPS as f64, high / STEPS as f64);
            let after = program.contains(at(high));
            if before != after {
                while high - low > 1e-14 {
                    let middle = 0.5 * (low + high);
                    if program.contains(at(middle)) == before {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                found.push(at(0.5 * (low + high)));
            }
            before = after;
        }
        found
    };
    rays.par_iter().flat_map_iter(along).collect()
}

/// The largest distance of points to a mesh.
pub fn points_to_mesh(points: &[DVec3], mesh: &Mesh) -> f64 {
    let tree = Tree::new(mesh);
    let largest = Largest::default();
    points
        .par_iter()
        .for_each(|&p| largest.add(tree.distance(p)));
    largest.value()
}

/// A tree of boxes, split at the median of the longest side.
struct Tree<'a> {
    mesh: &'a Mesh,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    first: usize,
    count: usize,
    /// The second child; the first follows its parent. Zero for leaves.
    second: usize,
}

impl<'a> Tree<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let mut tree = Self {
            mesh,
            nodes: Vec::new(),
            order: Vec::new(),
        };
        let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        if !order.is_empty() {
            tree.split(&mut order, 0);
        }
        tree.order = order;
        tree
    }

    fn split(&mut self, order: &mut [u32], first: usize) -> usize {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &triangle in &*order {
            for corner in self.mesh.corners(triangle as usize) {
                low = low.min(corner);
                high = high.max(corner);
            }
        }
        let node = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            first,
            count: order.len(),
            second: 0,
        });
        if order.len() > 4 {
            let axis = (high - low).max_position();
            let mesh = self.mesh;
            let key = |&i: &u32| -> f64 {
                let corners = mesh.corners(i as usize);
                corners.iter().map(|corner| corner[axis]).sum()
            };
            let middle = order.len() / 2;
            order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
            let (left, right) = order.split_at_mut(middle);
            self.split(left, first);
            self.nodes[node].second = self.split(right, first + middle);
        }
        node
    }

    fn distance(&self, p: DVec3) -> f64 {
        let mut best = f64::INFINITY;
        let mut pending = if self.nodes.is_empty() {
            vec![]
        } else {
            vec![0]
        };
        let away = |node: usize| {
            let node = &self.nodes[node];
            p.distance_squared(p.clamp(node.low, node.high))
        };
        while let Some(index) = pending.pop() {
            if away(index) >= best {
                continue;
            }
            let node = &self.nodes[index];
            if node.second == 0 {
                for &i in &self.order[node.first..node.first + node.count] {
                    let q = nearest_on_triangle(p, self.mesh.corners(i as usize));
                    best = best.min(p.distance_squared(q));
                }
            } else {
                let mut children = [index + 1, node.second];
                if away(children[0]) < away(children[1]) {
                    children.swap(0, 1);
                }
                pending.extend(children);
            }
        }
        best.sqrt()
    }
}

/// The point of a triangle nearest to `p`: below it, or on its outline.
fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let over = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if area > 0.0 && over(a, b) && over(b, c) && over(c, a) {
        return p - normal * ((p - a).dot(normal) / area);
    }
    let on_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let t = (p - from).dot(along) / along.length_squared();
        from + along
            * if t.is_finite() {
                t.clamp(0.0, 1.0)
            } else {
                0.0
            }
    };
    let mut best = on_edge(a, b);
    for q in [on_edge(b, c), on_edge(c, a)] {
        if p.distance_squared(q) < p.distance_squared(best) {
            best = q;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use csg::{Mesher, Solid};

    use super::*;

    /// A ball's mesh measured against a ball a little larger is off by the
    /// difference of radii and its own chord error, both ways.
    #[test]
    fn offset_ball_is_off_by_the_offset() {
        let program = |radius: f64| Program::lower(&Solid::sphere(radius)).expect("valid");
        let meshed = Mesher::new().cells(64).mesh(&program(1.0)).expect("a mesh");
        let larger = program(1.1);
        let there = mesh_to_boundary(&larger, 1.6, &meshed.mesh);
        let back = points_to_mesh(&boundary_samples(&larger, 1.6), &meshed.mesh);
        for found in [there, back] {
            assert!((0.1..0.102).contains(&found), "{found}");
        }
    }
}
