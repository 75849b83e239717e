//! How thick a solid is inside: rays from its faces straight inwards, found
//! with a hierarchy of boxes.

use csg::Mesh;
use glam::DVec3;

use crate::refine::Piece;

/// How far towards the middle of a triangle a corner's ray begins.
pub(crate) const INSET: f64 = 1e-6;

/// Most triangles of a box that is not divided.
const LEAF: usize = 8;

/// A box of the hierarchy.
struct Node {
    low: DVec3,
    high: DVec3,
    /// Of `order`; or, of two boxes, that of the second one.
    first: usize,
    count: usize,
}

/// The triangles of a mesh, ready for rays.
pub(crate) struct Inside {
    corners: Vec<Option<[DVec3; 3]>>,
    order: Vec<usize>,
    nodes: Vec<Node>,
}

impl Inside {
    pub fn new(mesh: &Mesh) -> Self {
        let at = |v: u32| mesh.positions.get(v as usize).copied();
        let triangles = mesh.triangles.iter();
        let corners: Vec<_> = triangles
            .map(|&[a, b, c]| Some([at(a)?, at(b)?, at(c)?]))
            .collect();
        let order = (0..corners.len())
            .filter(|&t| corners[t].is_some())
            .collect();
        let mut inside = Self {
            corners,
            order,
            nodes: Vec::new(),
        };
        inside.build(0, inside.order.len());
        inside
    }

    fn middle(&self, triangle: usize) -> DVec3 {
        self.corners[triangle].map_or(DVec3::ZERO, |[a, b, c]| (a + b + c) / 3.0)
    }

    /// Adds the box of a range of the order, and those within it.
    fn build(&mut self, first: usize, count: usize) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in self.order[first..first + count]
            .iter()
            .filter_map(|&t| self.corners[t])
            .flatten()
        {
            (low, high) = (low.min(p), high.max(p));
        }
        let own = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            first,
            count,
        });
        if count <= LEAF {
            return;
        }
        let size = high - low;
        let axis = (0..3).fold(0, |most, k| if size[k] > size[most] { k } else { most });
        let mut part = self.order[first..first + count].to_vec();
        part.sort_by(|&a, &b| self.middle(a)[axis].total_cmp(&self.middle(b)[axis]));
        self.order[first..first + count].copy_from_slice(&part);
        let half = count / 2;
        self.build(first, half);
        (self.nodes[own].first, self.nodes[own].count) = (self.nodes.len(), 0);
        self.build(first + half, count - half);
    }

    /// The distance from a corner of a part of a triangle straight inwards to the
    /// next triangle; `None` for one without area, or where there is nothing.
    pub fn thickness(&self, piece: &Piece, corner: usize, at: [DVec3; 3]) -> Option<f64> {
        let triangle = piece.parent;
        let [a, b, c] = (*self.corners.get(triangle)?)?;
        let flat = (b - a).cross(c - a).try_normalize()?;
        let smooth = piece.normals.map(|normals| normals[corner].as_dvec3());
        let outwards = smooth.and_then(DVec3::try_normalize).unwrap_or(flat);
        let inwards = -outwards * outwards.dot(flat).signum();
        // A little inside, where what lies at the other side of an edge is not met.
        let middle = (at[0] + at[1] + at[2]) / 3.0;
        let origin = at[corner].lerp(middle, INSET);
        let mut nearest = f64::INFINITY;
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop() {
            let Some(node) = self.nodes.get(index) else {
                continue;
            };
            if !crosses(node, origin, inwards, nearest) {
                continue;
            }
            if node.count == 0 {
                waiting.extend([index + 1, node.first]);
                continue;
            }
            for &other in &self.order[node.first..node.first + node.count] {
                if other != triangle
                    && let Some(corners) = self.corners[other]
                    && let Some(distance) = hit(corners, origin, inwards)
                {
                    nearest = nearest.min(distance);
                }
            }
        }
        nearest.is_finite().then_some(nearest)
    }
}

/// Whether a ray meets a box nearer than a distance.
fn crosses(node: &Node, origin: DVec3, along: DVec3, nearest: f64) -> bool {
    let (mut enter, mut leave) = (0.0f64, nearest);
    for k in 0..3 {
        let (a, b) = (node.low[k] - origin[k], node.high[k] - origin[k]);
        if along[k] == 0.0 {
            if a > 0.0 || b < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (a / along[k], b / along[k]);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    enter <= leave
}

/// Where a ray meets a triangle, if it does (Möller, Trumbore, 1997).
fn hit([a, b, c]: [DVec3; 3], origin: DVec3, along: DVec3) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let p = along.cross(v);
    let determinant = u.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - a;
    let x = from.dot(p) / determinant;
    let q = from.cross(u);
    let y = along.dot(q) / determinant;
    let distance = v.dot(q) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && distance > 0.0).then_some(distance)
}
