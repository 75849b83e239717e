//! Growing the octree: cells are split, the program pruned on the way, until
//! what is left in them is simple or they are as small as allowed.

use glam::DVec3;

use super::probe::Scene;
use super::settle::{Settler, Verdict};
use super::tree::{Node, Place, Tree};
use crate::control::Control;
use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::program::{Cell, Pruner};

/// About what is held at a time for each leaf and what becomes of it, its
/// program not included.
const BYTES_PER_LEAF: usize = size_of::<Leaf>() + 600;

/// A cell of the finished tree.
#[derive(Clone, Debug)]
pub(super) struct Leaf {
    pub node: u32,
    pub place: Place,
    pub cell: Cell,
    /// The point about which the solid is a cone in the cell.
    pub star: Option<DVec3>,
}

/// A growing tree and its leaves.
pub(super) struct Grower<'a, 's> {
    pub scene: &'a Scene<'s>,
    control: &'a Control,
    /// No cell is finer.
    pub most_levels: u32,
    pub tree: Tree,
    pub leaves: Vec<Leaf>,
    /// Points of the boundary that cells of the smallest size do not show.
    pub hidden: Vec<DVec3>,
    pub visited: u64,
    pub pruned: u64,
    settler: Settler,
    pruner: Pruner,
    /// Programs of the cells on the way down.
    levels: Vec<Cell>,
}

impl<'a, 's> Grower<'a, 's> {
    pub fn new(scene: &'a Scene<'s>, most_levels: u32, control: &'a Control) -> Self {
        Self {
            scene,
            control,
            most_levels,
            tree: Tree {
                nodes: vec![Node::Constant],
            },
            leaves: Vec::new(),
            hidden: Vec::new(),
            visited: 0,
            pruned: 0,
            settler: Settler::default(),
            pruner: Pruner::default(),
            levels: Vec::new(),
        }
    }

    /// Grows everything from the root.
    pub fn grow(&mut self, root: &Cell) -> Result<(), Error> {
        self.split(0, Place::ROOT, root)
    }

    /// Splits a leaf whose loops turned out not to tell all.
    pub fn split_leaf(&mut self, leaf: usize) -> Result<(), Error> {
        let Leaf {
            node,
            place,
            ref mut cell,
            ..
        } = self.leaves[leaf];
        let cell = std::mem::take(cell);
        self.split(node, place, &cell)
    }

    /// Makes a node's eight children, and theirs.
    fn split(&mut self, node: u32, place: Place, cell: &Cell) -> Result<(), Error> {
        self.control.spend(8, 8 * size_of::<Node>() as u64)?;
        let first = self.tree.nodes.len() as u32;
        self.tree.nodes[node as usize] = Node::Children(first);
        self.tree.nodes.extend([Node::Constant; 8]);
        let mut part = self.levels.pop().unwrap_or_default();
        for octant in 0..8 {
            let child = place.child(octant);
            let half = 0.5 * self.scene.unit * f64::from(child.size());
            let center = self.scene.point(child.corner) + half;
            let slack = COORDINATE * (center.abs() + half);
            cell.prune_into(
                self.scene.surfaces,
                center,
                half + slack,
                &mut self.pruner,
                &mut part,
            );
            self.visited += 1;
            if part.constant().is_some() {
                self.pruned += 1;
                continue;
            }
            let node = first + octant as u32;
            let verdict = self.settler.judge(self.scene, &part, child);
            if verdict == Verdict::Split && child.level < self.most_levels {
                self.split(node, child, &part)?;
                continue;
            }
            if verdict == Verdict::Split {
                let hidden = self.settler.hidden_face(self.scene, &part, child);
                self.hidden.extend(hidden);
            }
            let bytes = BYTES_PER_LEAF + part.bytes();
            self.control.spend(0, bytes as u64)?;
            self.tree.nodes[node as usize] = Node::Leaf(self.leaves.len() as u32);
            self.leaves.push(Leaf {
                node,
                place: child,
                cell: part.clone(),
                star: match verdict {
                    Verdict::Star(point) => Some(point),
                    _ => None,
                },
            });
        }
        self.levels.push(part);
        Ok(())
    }
}
