//! The octree: cells of many sizes on one lattice, and the walk that visits
//! every edge that no cell splits with the four cells around it.
//!
//! The walk is that of dual contouring (Ju, Losasso, Schaefer and Warren,
//! *Dual Contouring of Hermite Data*, 2002): down through cells, the faces
//! between cells, and the edges between faces. It needs neither parents nor
//! neighbours nor any balance between the sizes of neighbours.

use glam::UVec3;

/// The root cell is so many lattice units long: every cell down to a unit has
/// integer corners.
pub(super) const ROOT_BITS: u32 = 30;

/// The finest level that a cell may have.
pub(super) const MOST_LEVELS: u32 = ROOT_BITS - 2;

/// A place in the tree: its level tells its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// The least corner, in lattice units.
    pub corner: UVec3,
    pub level: u32,
}

impl Place {
    pub const ROOT: Self = Self {
        corner: UVec3::ZERO,
        level: 0,
    };

    /// The length of the sides in lattice units.
    pub fn size(self) -> u32 {
        1 << (ROOT_BITS - self.level)
    }

    /// The child in an octant: bit 0 for the upper half along x.
    pub fn child(self, octant: usize) -> Self {
        let half = self.size() / 2;
        let upper = UVec3::new(
            octant as u32 & 1,
            octant as u32 >> 1 & 1,
            octant as u32 >> 2,
        );
        Self {
            corner: self.corner + half * upper,
            level: self.level + 1,
        }
    }
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// The first of eight consecutive nodes.
    Children(u32),
    /// A cell in which the boundary has no part.
    Constant,
    /// A cell, by number.
    Leaf(u32),
}

/// An octree; the root is node 0.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
}

/// A node and where it is.
#[derive(Clone, Copy)]
struct At {
    node: u32,
    place: Place,
}

/// An edge of the tree: the cells around it in the order of
/// [`super::complex::Edge::cells`], with their places.
pub(super) struct LeafEdge {
    pub axis: usize,
    pub cells: [u32; 4],
    pub small: u8,
    pub start: UVec3,
    pub length: u32,
}

/// The octant with the given bits along three axes in cyclic order from
/// `axis`.
fn octant(axis: usize, along: usize, u: usize, v: usize) -> usize {
    along << axis | u << ((axis + 1) % 3) | v << ((axis + 2) % 3)
}

/// Towards which side of the edge each quadrant lies, along u and v.
const QUADRANTS: [(usize, usize); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];

impl Tree {
    /// Calls `visit` for every edge that no cell splits and around which all
    /// four cells are leaves that are not constant, in a fixed order.
    pub fn for_each_edge(&self, mut visit: impl FnMut(LeafEdge)) {
        let root = At {
            node: 0,
            place: Place::ROOT,
        };
        self.cell(root, &mut visit);
    }

    fn child(&self, at: At, octant: usize) -> At {
        match self.nodes[at.node as usize] {
            Node::Children(first) => At {
                node: first + octant as u32,
                place: at.place.child(octant),
            },
            _ => at,
        }
    }

    fn is_split(&self, at: At) -> bool {
        matches!(self.nodes[at.node as usize], Node::Children(_))
    }

    fn is_constant(&self, at: At) -> bool {
        self.nodes[at.node as usize] == Node::Constant
    }

    fn cell(&self, at: At, visit: &mut impl FnMut(LeafEdge)) {
        if !self.is_split(at) {
            return;
        }
        for octant in 0..8 {
            self.cell(self.child(at, octant), visit);
        }
        for axis in 0..3 {
            for (u, v) in QUADRANTS {
                let side = |upper| self.child(at, octant(axis, upper, u, v));
                self.face(side(0), side(1), axis, visit);
            }
            for along in 0..2 {
                let around = QUADRANTS.map(|(u, v)| self.child(at, octant(axis, along, u, v)));
                self.edge(around, axis, visit);
            }
        }
    }

    /// The face between a cell and the next along `axis`.
    fn face(&self, below: At, above: At, axis: usize, visit: &mut impl FnMut(LeafEdge)) {
        if !(self.is_split(below) || self.is_split(above))
            || self.is_constant(below)
            || self.is_constant(above)
        {
            return;
        }
        for (u, v) in QUADRANTS {
            self.face(
                self.child(below, octant(axis, 1, u, v)),
                self.child(above, octant(axis, 0, u, v)),
                axis,
                visit,
            );
        }
        for along in 0..2 {
            // Edges along the first axis of the face: across them lie its
            // second axis and its normal.
            let first = QUADRANTS.map(|(second, normal)| {
                let side = if normal == 0 { below } else { above };
                self.child(side, octant(axis, 1 - normal, along, second))
            });
            self.edge(first, (axis + 1) % 3, visit);
            let second = QUADRANTS.map(|(normal, first)| {
                let side = if normal == 0 { below } else { above };
                self.child(side, octant(axis, 1 - normal, first, along))
            });
            self.edge(second, (axis + 2) % 3, visit);
        }
    }

    /// The edge along `axis` between four cells.
    fn edge(&self, around: [At; 4], axis: usize, visit: &mut impl FnMut(LeafEdge)) {
        if around.iter().any(|&at| self.is_constant(at)) {
            return;
        }
        if around.iter().any(|&at| self.is_split(at)) {
            for along in 0..2 {
                let mut quadrant = 0;
                let halves = around.map(|at| {
                    let (u, v) = QUADRANTS[quadrant];
                    quadrant += 1;
                    self.child(at, octant(axis, along, 1 - u, 1 - v))
                });
                self.edge(halves, axis, visit);
            }
            return;
        }
        let length = around
            .map(|at| at.place.size())
            .into_iter()
            .min()
            .unwrap_or(0);
        let mut edge = LeafEdge {
            axis,
            cells: [0; 4],
            small: 0,
            start: UVec3::ZERO,
            length,
        };
        for (quadrant, at) in around.into_iter().enumerate() {
            if let Node::Leaf(leaf) = self.nodes[at.node as usize] {
                edge.cells[quadrant] = leaf;
            }
            if at.place.size() == length {
                edge.small |= 1 << quadrant;
                let (u, v) = QUADRANTS[quadrant];
                edge.start = at.place.corner;
                edge.start[(axis + 1) % 3] += length * (1 - u as u32);
                edge.start[(axis + 2) % 3] += length * (1 - v as u32);
            }
        }
        visit(edge);
    }
}
