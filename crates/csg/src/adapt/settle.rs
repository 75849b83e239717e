//! When is a cell small enough? When the solid is simple in it: every surface
//! so flat that it is a single sheet, any two either cross at an angle or do
//! not meet, and the loops around the cell, each with one vertex on all its
//! surfaces, tell all that there is.

use glam::{DVec3, UVec3};
use smallvec::SmallVec;

use super::complex::{Complex, Edge, Transition};
use super::pairing::Geometric;
use super::probe::{Change, Flatness, Probe, Scene, have_no_common_point};
use super::touch::{Touch, touch};
use super::tree::Place;
use crate::numeric::tolerance::{DEPENDENT_IN_CELL, NEAR, TOUCHING};
use crate::program::{Cell, Surface};
use crate::surface::solve;

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// There is more in it than its loops can tell.
    Split,
    /// One vertex on each loop tells all.
    Settled,
    /// All surfaces are planes through this point or cones about it: inside
    /// the cell the solid is a cone over what its faces show.
    Star(DVec3),
}

/// A surface whose gradient turns by more than about this many radians in a
/// cell may be more than one sheet there.
const FLAT: f64 = 0.6;

/// More surfaces in a cell than this have a common point or are split.
const MOST_SURFACES: usize = 8;

/// A vertex on an edge of the solid may lie outside its cell by this share of
/// the cell's size: the edge passes through the cell, the point nearest to
/// where it was expected need not.
const CURVE_SLACK: f64 = 0.5;

/// The same for corners, which are nobody else's: rounding alone.
pub(super) const CORNER_SLACK: f64 = NEAR;

/// The surfaces of a loop, ascending.
pub(super) type Constraints = SmallVec<[u32; 4]>;

/// The surfaces that cause a loop's transitions, and where its vertex is to be
/// expected: amid the points where the loop passes from one surface to the
/// next, or amid its transitions if it stays on one.
pub(super) fn constraints_of(
    scene: &Scene<'_>,
    transitions: &[(u32, u8)],
    changes: &[Change],
) -> (Constraints, DVec3) {
    let mut surfaces = Constraints::new();
    let mut sum = DVec3::ZERO;
    let mut passages = DVec3::ZERO;
    let mut count = 0;
    for (index, &(transition, normal)) in transitions.iter().enumerate() {
        let change = &changes[transition as usize];
        sum += change.point;
        if !surfaces.contains(&change.surface) {
            surfaces.push(change.surface);
        }
        let (next, _) = transitions[(index + 1) % transitions.len()];
        let next = &changes[next as usize];
        if next.surface != change.surface {
            passages += passage(scene, change, next, usize::from(normal));
            count += 1;
        }
    }
    surfaces.sort_unstable();
    let start = if count > 0 {
        passages / f64::from(count)
    } else {
        sum / transitions.len() as f64
    };
    (surfaces, start)
}

/// Where in the face across `normal` the boundary passes from the surface of
/// one change to that of another, if near them.
pub(super) fn passage(scene: &Scene<'_>, a: &Change, b: &Change, normal: usize) -> DVec3 {
    let middle = 0.5 * (a.point + b.point);
    // Where the surfaces meet at a small angle the point is far from both.
    let reach = 8.0 * (a.point - b.point).length();
    let face = Surface::plane(a.point, DVec3::AXES[normal]);
    let surface = |id: u32| &scene.surfaces[id as usize];
    let both = [surface(a.surface), surface(b.surface), &face];
    let solution = solve::common_point(&both, middle, reach);
    let near = (solution.point - middle).length() <= reach;
    if near && solution.residual <= 1e-6 * reach {
        solution.point
    } else {
        middle
    }
}

/// How the surfaces of a cell meet.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meeting {
    /// At angles, at most three in a point, or not at all.
    Plain,
    /// Some touch, or three share a curve.
    Special,
    /// Two touch in a point where the branches of their curve cross.
    Node(DVec3),
}

/// Whether three surfaces have the curve in common in which two of them meet
/// near the middle of a cell, which runs about along `axis`.
fn share_a_curve(
    [a, b, c]: [&Surface; 3],
    axis: DVec3,
    middle: DVec3,
    half: f64,
    tolerance: f64,
) -> bool {
    // Two quadrics' curve that is not on a third meets it in eight points at
    // most; near each other they do not all lie by chance.
    [-0.83, -0.31, 0.13, 0.57, 0.91].into_iter().all(|along| {
        let start = middle + along * half * axis;
        let solution = solve::common_point(&[a, b], start, half);
        solution.residual <= tolerance
            && solve::residual(std::iter::once(c), solution.point) <= 8.0 * tolerance
    })
}

/// Judges cells; scratch memory.
#[derive(Default)]
pub(super) struct Settler {
    pub probe: Probe,
    complex: Complex,
    edges: Vec<Edge>,
    transitions: Vec<Transition>,
    changes: Vec<Change>,
    axes: Vec<u8>,
    flatness: Vec<Flatness>,
    /// Bit j of the i-th: the cell's surfaces i and j do not meet in it.
    disjoint: [u16; MOST_SURFACES],
    loops: Vec<Constraints>,
}

/// The number of the cell itself among the 27 about it.
const SELF: u32 = 13;

impl Settler {
    /// What is known of the program in the cell at `place`.
    pub fn judge(&mut self, scene: &Scene<'_>, cell: &Cell, place: Place) -> Verdict {
        let half = 0.5 * scene.unit * f64::from(place.size());
        let middle = scene.point(place.corner) + half;
        let surface = |id: u32| &scene.surfaces[id as usize];
        if let Some(star) = self.star(scene, cell, middle, half) {
            return Verdict::Star(star);
        }
        self.flatness.clear();
        for &id in &cell.surfaces {
            let flatness = Flatness::over(surface(id), middle, half);
            if flatness.spread.is_nan() || flatness.spread > FLAT {
                return Verdict::Split;
            }
            self.flatness.push(flatness);
        }
        if cell.surfaces.len() > MOST_SURFACES {
            return Verdict::Split;
        }
        let Some(meeting) = self.meeting(scene, cell, middle, half) else {
            return Verdict::Split;
        };
        match meeting {
            Meeting::Plain if cell.surfaces.len() <= 2 => Verdict::Settled,
            Meeting::Node(point) => Verdict::Star(point),
            _ if self.loops_tell_all(scene, cell, place, middle, half) => Verdict::Settled,
            _ => Verdict::Split,
        }
    }

    /// A point in the cell through which all surfaces pass as planes or as
    /// cones about it.
    fn star(&self, scene: &Scene<'_>, cell: &Cell, middle: DVec3, half: f64) -> Option<DVec3> {
        let surface = |id: u32| &scene.surfaces[id as usize];
        let inside = |point: DVec3| (point - middle).abs().max_element() <= half;
        let through = |point: DVec3| {
            cell.surfaces.iter().all(|&id| {
                let surface = surface(id);
                match surface.apex() {
                    Some(apex) => (apex - point).length() <= scene.tolerance,
                    None => surface.is_plane() && surface.value(point).abs() <= scene.tolerance,
                }
            })
        };
        let apex = cell
            .surfaces
            .iter()
            .find_map(|&id| surface(id).apex().filter(|&p| inside(p)));
        if apex.is_some() {
            return apex.filter(|&point| through(point));
        }
        let (first, rest) = cell.surfaces.split_at_checked(3)?;
        if rest.is_empty() || !cell.surfaces.iter().all(|&id| surface(id).is_plane()) {
            return None;
        }
        let three = [surface(first[0]), surface(first[1]), surface(first[2])];
        let point = solve::common_point(&three, middle, half).point;
        (inside(point) && through(point)).then_some(point)
    }

    /// How the surfaces meet in the cell, if it is known of any two that they
    /// cross at an angle, touch, or do not meet, and of any three that they
    /// meet in one point, in a curve, or not at all.
    fn meeting(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        middle: DVec3,
        half: f64,
    ) -> Option<Meeting> {
        let all = &self.flatness;
        let surface = |i: usize| &scene.surfaces[cell.surfaces[i] as usize];
        let mut meeting = Meeting::Plain;
        // Bit j of the i-th: surfaces i and j touch, or do not meet.
        let mut touching = [0u16; MOST_SURFACES];
        let disjoint = &mut self.disjoint;
        *disjoint = [0; MOST_SURFACES];
        for i in 0..all.len() {
            for j in 0..i {
                let (a, b) = (&all[i], &all[j]);
                if a.crosses(b) {
                    continue;
                }
                if have_no_common_point(&[(1.0, a), (-a.normal.dot(b.normal), b)], half) {
                    disjoint[i] |= 1 << j;
                    disjoint[j] |= 1 << i;
                    continue;
                }
                let tolerance = scene.tolerance;
                match touch(surface(i), surface(j), middle, 2.0 * half, tolerance)? {
                    Touch::Nested => {
                        touching[i] |= 1 << j;
                        touching[j] |= 1 << i;
                        meeting = Meeting::Special;
                    }
                    Touch::Node(point) => {
                        let inside = (point - middle).abs().max_element() <= half;
                        let flat = a.spread.max(b.spread) <= 0.5 * FLAT;
                        if !(inside && flat && all.len() == 2) {
                            return None;
                        }
                        return Some(Meeting::Node(point));
                    }
                }
            }
        }
        for i in 0..all.len() {
            for j in 0..i {
                for k in 0..j {
                    let pairs = |of: &[u16]| (of[i] >> j | of[i] >> k | of[j] >> k) & 1 == 1;
                    if pairs(&*disjoint) || pairs(&touching) {
                        continue;
                    }
                    let (a, b, c) = (&all[i], &all[j], &all[k]);
                    let (ab, bc, ca) = (
                        a.normal.cross(b.normal),
                        b.normal.cross(c.normal),
                        c.normal.cross(a.normal),
                    );
                    let determinant = ab.dot(c.normal).abs();
                    if determinant > a.spread + b.spread + c.spread + DEPENDENT_IN_CELL {
                        continue;
                    }
                    // Nearly a pencil of planes: the combination that cancels
                    // the gradients.
                    let longest = |p: DVec3, q: DVec3| {
                        if p.length_squared() >= q.length_squared() {
                            p
                        } else {
                            q
                        }
                    };
                    let axis = longest(ab, longest(bc, ca));
                    let weighted = [(bc.dot(axis), a), (ca.dot(axis), b), (ab.dot(axis), c)];
                    if have_no_common_point(&weighted, half) {
                        continue;
                    }
                    let three = [surface(i), surface(j), surface(k)];
                    if !share_a_curve(
                        three,
                        axis.normalize_or_zero(),
                        middle,
                        half,
                        scene.tolerance,
                    ) {
                        return None;
                    }
                    meeting = Meeting::Special;
                }
            }
        }
        Some(meeting)
    }

    /// Whether every loop around the cell has a valid vertex in it, and no
    /// face, edge or corner of the solid in the cell is missing from them.
    fn loops_tell_all(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        place: Place,
        middle: DVec3,
        half: f64,
    ) -> bool {
        if !self.find_loops(scene, cell, place) {
            return false;
        }
        self.loops.clear();
        for of in &self.complex.loops {
            let transitions = self.complex.transitions_of(of);
            let (surfaces, start) = constraints_of(scene, transitions, &self.changes);
            let about = Expected {
                start,
                middle,
                half,
                corner_slack: CORNER_SLACK,
            };
            let point = vertex(scene, &mut self.probe, cell, &surfaces, about);
            if point.is_none() {
                return false;
            }
            self.loops.push(surfaces);
        }
        let count = cell.surfaces.len();
        for i in 0..count {
            if self.is_hidden(scene, cell, &[i], middle, half) {
                return false;
            }
            for j in 0..i {
                if self.is_hidden(scene, cell, &[j, i], middle, half) {
                    return false;
                }
                for k in 0..j {
                    if self.is_hidden(scene, cell, &[k, j, i], middle, half) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether these surfaces (positions in the cell) meet in the cell where
    /// the solid changes across each of them, though no loop has them all.
    fn is_hidden(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        positions: &[usize],
        middle: DVec3,
        half: f64,
    ) -> bool {
        let apart = |&p: &usize| positions.iter().any(|&q| self.disjoint[p] >> q & 1 == 1);
        if positions.iter().any(apart) {
            return false;
        }
        let ids: SmallVec<[u32; 4]> = positions.iter().map(|&p| cell.surfaces[p]).collect();
        if self
            .loops
            .iter()
            .any(|l| ids.iter().all(|id| l.contains(id)))
        {
            return false;
        }
        let surface = |id: u32| &scene.surfaces[id as usize];
        let surfaces: SmallVec<[&Surface; 4]> = ids.iter().map(|&id| surface(id)).collect();
        let solution = solve::common_point(&surfaces, middle, half);
        let point = solution.point;
        // Where more surfaces share a curve or a corner, a loop with others of
        // them has it, too.
        let known = |l: &Constraints| {
            l.len() >= ids.len()
                && solve::residual(l.iter().map(|&id| surface(id)), point) <= 8.0 * scene.tolerance
        };
        solution.residual <= scene.tolerance
            && (point - middle).abs().max_element() <= half
            && are_independent(&surfaces, point)
            && self.probe.changes_across(scene, cell, &ids, point)
            && !(ids.len() > 1 && self.loops.iter().any(known))
    }

    /// A point of the boundary in the cell, on a surface that changes the solid
    /// on none of the cell's edges: what is lost if the cell is not split.
    pub fn hidden_face(&mut self, scene: &Scene<'_>, cell: &Cell, place: Place) -> Option<DVec3> {
        let half = 0.5 * scene.unit * f64::from(place.size());
        let middle = scene.point(place.corner) + half;
        self.find_loops(scene, cell, place);
        let is_shown = |id: u32| self.changes.iter().any(|change| change.surface == id);
        let hidden: Constraints = cell
            .surfaces
            .iter()
            .copied()
            .filter(|&id| !is_shown(id))
            .collect();
        hidden.into_iter().find_map(|id| {
            // In the face, or on an edge of it: most of the surface may be none.
            let alone = std::iter::once([id, id]);
            let others = cell.surfaces.iter().filter(|&&other| other != id);
            alone
                .chain(others.map(|&other| [id, other]))
                .find_map(|ids| {
                    let ids = if ids[0] == ids[1] {
                        &ids[..1]
                    } else {
                        &ids[..]
                    };
                    let surfaces: SmallVec<[&Surface; 2]> =
                        ids.iter().map(|&id| &scene.surfaces[id as usize]).collect();
                    let solution = solve::common_point(&surfaces, middle, half);
                    let point = solution.point;
                    (solution.residual <= scene.tolerance
                        && (point - middle).abs().max_element() <= half
                        && self.probe.changes_across(scene, cell, ids, point))
                    .then_some(point)
                })
        })
    }

    /// The loops around the cell as if all its neighbours were of its size.
    /// False if an edge has more changes than can be told apart.
    fn find_loops(&mut self, scene: &Scene<'_>, cell: &Cell, place: Place) -> bool {
        self.edges.clear();
        self.transitions.clear();
        self.changes.clear();
        self.axes.clear();
        let size = place.size();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (side_u, side_v) in [(0u32, 0u32), (1, 0), (1, 1), (0, 1)] {
                let mut start = place.corner;
                start[u] += size * side_u;
                start[v] += size * side_v;
                let mut end = start;
                end[axis] += size;
                let first = self.changes.len();
                let ends = [scene.point(start), scene.point(end)];
                if !self
                    .probe
                    .changes_along(scene, cell, axis, ends, &mut self.changes)
                {
                    return false;
                }
                if self.changes.len() == first {
                    continue;
                }
                let edge = self.edges.len() as u32;
                for change in &self.changes[first..] {
                    self.transitions.push(Transition {
                        edge,
                        enters: change.enters,
                    });
                    self.axes.push(axis as u8);
                }
                // The four cells around the edge among the 27.
                let cells = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(quadrant_u, quadrant_v)| {
                    let mut offset = UVec3::ONE;
                    offset[u] = side_u + quadrant_u;
                    offset[v] = side_v + quadrant_v;
                    offset.x + 3 * offset.y + 9 * offset.z
                });
                self.edges.push(Edge {
                    axis,
                    cells,
                    small: 0b1111,
                    start,
                    first: first as u32,
                    count: (self.changes.len() - first) as u32,
                });
            }
        }
        let mut pairing = Geometric {
            scene,
            probe: &mut self.probe,
            changes: &self.changes,
            axes: &self.axes,
            cell: |_| cell,
        };
        self.complex
            .build(&self.edges, &self.transitions, Some(SELF), &mut pairing);
        true
    }
}

/// Whether the gradients of up to three surfaces at a point are linearly
/// independent: the surfaces have no more in common near it than they must.
fn are_independent(surfaces: &[&Surface], point: DVec3) -> bool {
    let normal = |s: &Surface| s.gradient(point).normalize_or_zero();
    match surfaces {
        [a, b] => normal(a).cross(normal(b)).length_squared() > TOUCHING * TOUCHING,
        [a, b, c] => normal(a).cross(normal(b)).dot(normal(c)).abs() > TOUCHING,
        _ => true,
    }
}

/// Where a vertex is expected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// About here.
    pub start: DVec3,
    /// In the cell with this middle and half side.
    pub middle: DVec3,
    pub half: f64,
    /// By what share of the half side a corner may lie outside.
    pub corner_slack: f64,
}

/// The vertex of a loop: the point on all its surfaces near `start`, if there
/// is one in the cell and the solid changes across each of them there; else
/// the same with one more surface, for a feature that no edge saw.
pub(super) fn vertex(
    scene: &Scene<'_>,
    probe: &mut Probe,
    cell: &Cell,
    constraints: &[u32],
    about: Expected,
) -> Option<DVec3> {
    let plain = valid_point(scene, probe, cell, constraints, about);
    if plain.is_some() || constraints.len() > 2 {
        return plain;
    }
    let others = cell.surfaces.iter().filter(|id| !constraints.contains(id));
    others.copied().find_map(|extra| {
        let mut more: Constraints = constraints.into();
        more.push(extra);
        valid_point(scene, probe, cell, &more, about)
    })
}

fn valid_point(
    scene: &Scene<'_>,
    probe: &mut Probe,
    cell: &Cell,
    constraints: &[u32],
    about: Expected,
) -> Option<DVec3> {
    let surfaces: SmallVec<[&Surface; 4]> = constraints
        .iter()
        .map(|&id| &scene.surfaces[id as usize])
        .collect();
    let solution = solve::common_point(&surfaces, about.start, about.half);
    let is_corner = match surfaces.len() {
        0..3 => false,
        3 => are_independent(&surfaces, solution.point),
        _ => true,
    };
    let slack = if is_corner {
        about.corner_slack
    } else {
        CURVE_SLACK
    };
    let off = (solution.point - about.middle).abs().max_element();
    (off <= about.half * (1.0 + slack)
        && solution.residual <= scene.tolerance
        && probe.changes_across(scene, cell, constraints, solution.point))
    .then_some(solution.point)
}
