//! The combinatorial half of adaptive meshing: from lattice edges with the
//! solid's transitions along them to a surface that is manifold whatever the
//! octree looks like and however the crossings of a face are paired.
//!
//! A cell of an octree is a polyhedron. Its faces are the smallest faces
//! between it and its neighbours, its edges the smallest edges. Around every
//! face the transitions enter and leave the solid in turn; they are paired by
//! *arcs* that do not cross, once for both cells. Around every cell the arcs
//! close to *loops*. Dually, a loop is a vertex and a transition is a polygon
//! through the loops of the cells around its edge.
//!
//! That surface is the one of all triangles (transition, arc, loop), with the
//! points on transitions and arcs taken out where that is safe. With all of
//! them it is manifold: an edge between a loop and an arc has the two ends of
//! the arc beside it, an edge between a transition and a loop or an arc has
//! the two neighbours in a cycle. Taking an arc's point out is safe if no
//! other arc lies on its face, since two cells share one face at most; taking
//! a transition's out is safe if it is alone on its edge, its loops have more
//! than two arcs, and the diagonal of its polygon ends at a cell as small as
//! the edge, which the cell across it shares no other edge with.

use glam::UVec3;
use smallvec::SmallVec;

/// An edge of the octree that no cell splits, and the transitions on it.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    pub axis: usize,
    /// The cells around it, counter-clockwise seen from its upper end, each as
    /// often as it takes up a quadrant: with u and v the next axes in cyclic
    /// order those towards (-u, -v), (u, -v), (u, v), (-u, v).
    pub cells: [u32; 4],
    /// The quadrants, a bit each, whose cells are as small as the edge.
    pub small: u8,
    /// Its lower end in units of the lattice.
    pub start: UVec3,
    /// Its transitions in ascending order; at least one.
    pub first: u32,
    pub count: u32,
}

/// What the builder must know of a transition.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transition {
    pub edge: u32,
    /// Whether the solid begins here, going up the edge.
    pub enters: bool,
}

/// One transition on the boundary of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceCrossing {
    /// Cell below and cell above the face.
    face: (u32, u32),
    /// Its place going around counter-clockwise seen from above.
    order: u64,
    pub transition: u32,
    /// Which of the four faces around the transition's edge it is.
    slot: u8,
    /// Whether the solid begins here, going around.
    pub enters: bool,
}

impl FaceCrossing {
    /// One of the two cells at the face.
    pub fn any_cell(&self) -> u32 {
        self.face.0
    }

    /// The axis across the face, given that of the transition's edge.
    pub fn normal(&self, edge_axis: usize) -> usize {
        (edge_axis + 1 + usize::from(self.slot) % 2) % 3
    }
}

/// A curve across a face from the transition where the solid ends, going
/// around the face counter-clockwise, to one where it begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub from: u32,
    pub to: u32,
    from_slot: u8,
    to_slot: u8,
    /// The cell below the face, and the axis across it.
    below: u32,
    pub normal: usize,
    /// Whether it is not the only one on its face.
    pub crowded: bool,
}

/// A closed chain of arcs around a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loop {
    pub cell: u32,
    /// Its transitions, a range of [`Complex::visited`].
    pub first: u32,
    pub count: u32,
}

const NONE: u32 = u32::MAX;

/// Arcs and loops; scratch memory that is reused.
#[derive(Debug, Default)]
pub(super) struct Complex {
    pub arcs: Vec<Arc>,
    pub loops: Vec<Loop>,
    /// The transitions of all loops, one loop after another, and the axis
    /// across the face on which the loop goes on to the next.
    pub visited: Vec<(u32, u8)>,
    /// Per transition, the loop that passes it in each quadrant.
    loop_at: Vec<[u32; 4]>,
    /// Per transition, the arc on the face before each quadrant's end.
    arc_at: Vec<[u32; 4]>,
    /// Transitions whose point is a vertex.
    kept: Vec<bool>,
    crossings: Vec<FaceCrossing>,
    pairs: Vec<(usize, usize)>,
}

/// How a quadrilateral is cut into triangles: along the diagonal between its
/// first and third corner, along the other, or all around its transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    First,
    Second,
    Middle,
}

/// Where a vertex of the surface comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Corner {
    Loop(u32),
    Arc(u32),
    Transition(u32),
}

/// The corners of one transition's polygon.
pub(super) type Polygon = SmallVec<[Corner; 8]>;

/// How the crossings on one face are paired: fills the list with positions
/// (one where the solid ends, one where it begins), each once, no two pairs
/// crossing.
pub(super) trait Pairing {
    fn pair(&mut self, crossings: &[FaceCrossing], pairs: &mut Vec<(usize, usize)>);
}

impl Complex {
    /// Joins the transitions to arcs and loops; those of `only` if a cell is
    /// named. Sorts four records a transition, the rest is linear.
    pub fn build(
        &mut self,
        edges: &[Edge],
        transitions: &[Transition],
        only: Option<u32>,
        pairing: &mut impl Pairing,
    ) {
        self.find_arcs(edges, transitions, only, pairing);
        self.find_loops(edges, transitions, only);
    }

    fn find_arcs(
        &mut self,
        edges: &[Edge],
        transitions: &[Transition],
        only: Option<u32>,
        pairing: &mut impl Pairing,
    ) {
        self.crossings.clear();
        for edge in edges {
            for slot in 0..4u8 {
                let here = edge.cells[usize::from(slot)];
                let next = edge.cells[usize::from(slot + 1) % 4];
                if here == next || only.is_some_and(|cell| here != cell && next != cell) {
                    continue;
                }
                // The first two faces are crossed going up, the others going
                // down. Seen from above, the edge is the right, lower, left,
                // upper side of the face.
                let face = if slot < 2 { (here, next) } else { (next, here) };
                let (side, ascending) =
                    [(1, true), (0, true), (3, false), (2, false)][usize::from(slot)];
                for rank in 0..edge.count {
                    let place = u64::from(edge.start[edge.axis]) << 16 | u64::from(rank);
                    let place = if ascending {
                        place
                    } else {
                        (1 << 60) - 1 - place
                    };
                    let transition = edge.first + rank;
                    self.crossings.push(FaceCrossing {
                        face,
                        order: side << 60 | place,
                        transition,
                        slot,
                        enters: transitions[transition as usize].enters == ascending,
                    });
                }
            }
        }
        self.crossings.sort_unstable_by_key(|c| (c.face, c.order));
        self.arcs.clear();
        self.arc_at.clear();
        self.arc_at.resize(transitions.len(), [NONE; 4]);
        for face in self.crossings.chunk_by(|a, b| a.face == b.face) {
            self.pairs.clear();
            if let [a, b] = face {
                debug_assert_ne!(a.enters, b.enters);
                self.pairs.push(if a.enters { (1, 0) } else { (0, 1) });
            } else {
                pairing.pair(face, &mut self.pairs);
            }
            for &(from, to) in &self.pairs {
                let (from, to) = (face[from], face[to]);
                let arc = self.arcs.len() as u32;
                self.arc_at[from.transition as usize][usize::from(from.slot)] = arc;
                self.arc_at[to.transition as usize][usize::from(to.slot)] = arc;
                self.arcs.push(Arc {
                    from: from.transition,
                    to: to.transition,
                    from_slot: from.slot,
                    to_slot: to.slot,
                    below: from.face.0,
                    normal: from
                        .normal(edges[transitions[from.transition as usize].edge as usize].axis),
                    crowded: face.len() > 2,
                });
            }
        }
    }

    fn find_loops(&mut self, edges: &[Edge], transitions: &[Transition], only: Option<u32>) {
        self.loops.clear();
        self.visited.clear();
        self.loop_at.clear();
        self.loop_at.resize(transitions.len(), [NONE; 4]);
        self.kept.clear();
        self.kept.resize(transitions.len(), false);
        for start in 0..transitions.len() {
            let edge = &edges[transitions[start].edge as usize];
            self.kept[start] = edge.count > 1;
            for quadrant in 0..4 {
                let cell = edge.cells[quadrant];
                if self.loop_at[start][quadrant] == NONE && only.is_none_or(|only| only == cell) {
                    self.trace(edges, transitions, start as u32, cell);
                }
            }
        }
        for arc in self.arcs.iter().filter(|arc| arc.crowded) {
            self.kept[arc.from as usize] = true;
            self.kept[arc.to as usize] = true;
        }
    }

    /// Follows the arcs around `cell` from `start` until they close.
    fn trace(&mut self, edges: &[Edge], transitions: &[Transition], start: u32, cell: u32) {
        let index = self.loops.len() as u32;
        let first = self.visited.len() as u32;
        let mut at = start;
        loop {
            let edge = &edges[transitions[at as usize].edge as usize];
            let mut next = None;
            let mut normal = 0;
            for quadrant in 0..4 {
                if edge.cells[quadrant] != cell {
                    continue;
                }
                self.loop_at[at as usize][quadrant] = index;
                // The cell's faces here: after this quadrant and before it.
                for slot in [quadrant, (quadrant + 3) % 4] {
                    let arc = self.arc_at[at as usize][slot];
                    if arc == NONE {
                        continue;
                    }
                    let Arc {
                        from,
                        to,
                        from_slot,
                        to_slot,
                        below,
                        ..
                    } = self.arcs[arc as usize];
                    // Seen from inside the cell above, arcs run backwards.
                    let (tail, tail_slot, head) = if below == cell {
                        (from, from_slot, to)
                    } else {
                        (to, to_slot, from)
                    };
                    if tail == at && usize::from(tail_slot) == slot {
                        next = Some(head);
                        normal = (edge.axis + 1 + slot % 2) % 3;
                    }
                }
            }
            self.visited.push((at, normal as u8));
            // Where transitions contradict each other the arcs may close elsewhere.
            let is_lost = self.visited.len() - first as usize > self.arcs.len();
            match next {
                Some(next) if next != start && !is_lost => at = next,
                _ => break,
            }
        }
        let count = self.visited.len() as u32 - first;
        if count < 3 {
            for &(transition, _) in &self.visited[first as usize..] {
                self.kept[transition as usize] = true;
            }
        }
        self.loops.push(Loop { cell, first, count });
    }

    /// The transitions that a loop passes, each with the axis across the face
    /// that it goes on through.
    pub fn transitions_of(&self, of: &Loop) -> &[(u32, u8)] {
        &self.visited[of.first as usize..(of.first + of.count) as usize]
    }

    /// Keeps the points on a transition and on all arcs that end in it: its
    /// polygon becomes the star of its point, which folds nowhere if all
    /// vertices lie in their own cells and faces.
    pub fn keep(&mut self, transition: u32) {
        for arc in self.arc_at[transition as usize] {
            if arc != NONE {
                let arc = &mut self.arcs[arc as usize];
                arc.crowded = true;
                self.kept[arc.from as usize] = true;
                self.kept[arc.to as usize] = true;
            }
        }
    }

    /// The corners of a transition's polygon, counter-clockwise seen from
    /// outside the solid, and which of the two diagonals of a quadrilateral
    /// without arcs are safe.
    pub fn polygon(&self, edge: &Edge, transition: u32, enters: bool) -> (Polygon, [bool; 2]) {
        let loops = self.loop_at[transition as usize];
        let mut corners = Polygon::new();
        let mut small = 0u8;
        for (slot, &passing) in loops.iter().enumerate() {
            let next = (slot + 1) % 4;
            // A cell's last quadrant in turn stands for all of its.
            if edge.cells[slot] == edge.cells[next] {
                continue;
            }
            small |= (edge.small >> slot & 1) << corners.len();
            corners.push(Corner::Loop(passing));
            let arc = self.arc_at[transition as usize][slot];
            if self.arcs[arc as usize].crowded {
                corners.push(Corner::Arc(arc));
            }
        }
        let (even, odd) = (small & 0b0101 != 0, small & 0b1010 != 0);
        // Cells are listed counter-clockwise seen from the edge's upper end:
        // from outside where the solid ends there. Reversed, the k-th of four
        // corners is the (3 - k)-th.
        if enters {
            corners.reverse();
            (corners, [odd, even])
        } else {
            (corners, [even, odd])
        }
    }

    /// Whether the point on a transition is a vertex.
    pub fn is_kept(&self, transition: u32) -> bool {
        self.kept[transition as usize]
    }

    /// Cuts every transition's polygon into triangles, counter-clockwise seen
    /// from outside the solid. How a quadrilateral is cut `cut` says, which is
    /// told the loops at its corners and which of its two diagonals are safe.
    pub fn triangles(
        &self,
        edges: &[Edge],
        transitions: &[Transition],
        mut cut: impl FnMut(u32, [u32; 4], [bool; 2]) -> Cut,
        mut triangle: impl FnMut(u32, [Corner; 3]),
    ) {
        for (at, transition) in (0u32..).zip(transitions) {
            let edge = &edges[transition.edge as usize];
            let (corners, safe) = self.polygon(edge, at, transition.enters);
            let cut = match corners.as_slice() {
                _ if self.is_kept(at) => Cut::Middle,
                &[
                    Corner::Loop(a),
                    Corner::Loop(b),
                    Corner::Loop(c),
                    Corner::Loop(d),
                ] => cut(at, [a, b, c, d], safe),
                _ => Cut::First,
            };
            if cut == Cut::Middle {
                let middle = Corner::Transition(at);
                for (k, &corner) in corners.iter().enumerate() {
                    triangle(at, [middle, corner, corners[(k + 1) % corners.len()]]);
                }
            } else if let &[a, b, c, d] = corners.as_slice() {
                let [a, b, c, d] = if cut == Cut::First {
                    [a, b, c, d]
                } else {
                    [b, c, d, a]
                };
                triangle(at, [a, b, c]);
                triangle(at, [a, c, d]);
            } else {
                debug_assert_eq!(corners.len(), 3);
                triangle(at, [corners[0], corners[1], corners[2]]);
            }
        }
    }
}
