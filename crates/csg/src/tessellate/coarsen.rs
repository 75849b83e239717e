//! Takes out every vertex that topology and the surfaces' bends can spare.
//!
//! A vertex on a face or along a curve is removed with its triangles, and the
//! hole (along a curve, the two holes on both sides of the new chord) is filled
//! by cutting off ears (after Schroeder, Zarge and Lorensen, *Decimation of Triangle
//! Meshes*, 1992). Every new triangle must face the way its surface does at
//! each of its corners, and no new edge may join vertices that an edge joins
//! already, so that the mesh stays manifold and unfolded. On a plane this ends
//! with no vertex inside a face. No tolerance is asked inside faces: what is too
//! coarse for it is cut up again, evenly, while the vertices of cells lie as
//! chance would have it. Along curves on which they lie evenly no more are left
//! than the tolerance needs; they will be moved.

use glam::DVec3;

use super::goal::Goal;
use super::half_edges::{HalfEdges, Kind, NONE, first_of, halves_of, next, triangle_of};
use super::region::{Bend, metric};
use super::shape::faces_out;
use crate::numeric::tolerance::TOUCHING_AT_ENDS;

/// Of the angle between a triangle and its surface at a corner: 37°. Tunes counts only.
const LEAST_COSINE: f64 = 0.8;

/// Of the angle between a chord and its curve at an end, squared: 30°. Tunes counts only.
const LEAST_CHORD_COSINE_SQUARED: f64 = 0.75;

/// More neighbours than this are too many: ears are sought in quadratic time. Tunes counts only.
const MOST_NEIGHBOURS: usize = 48;

/// Holes of more corners are only filled ear by ear: all triangulations of one
/// are compared in cubic time. Tunes counts only.
const MOST_CORNERS: usize = 16;

/// See [`Hole::try_all`].
type Parts = [[(f64, usize); MOST_CORNERS]; MOST_CORNERS];

/// A hole to be filled.
#[derive(Default)]
struct Hole {
    /// Its corners counter-clockwise, and what lies beyond the edge from each
    /// to the next: a half-edge of the mesh, or, along the new chord, [`NONE`].
    corners: Vec<(u32, u32)>,
    region: u32,
    /// What of it is not filled yet.
    rim: Vec<(u32, u32)>,
    /// The triangles that fill it: their corners and what lies beyond each of
    /// their sides.
    ears: Vec<([u32; 3], [u32; 3])>,
}

/// Scratch memory.
#[derive(Default)]
struct Removal {
    spokes: Vec<u32>,
    slots: Vec<u32>,
    holes: [Hole; 2],
}

/// Takes out vertices until none can be spared, but for those on surfaces with a
/// tolerance of their own: faces are close to each other there.
pub(super) fn coarsen(mesh: &mut HalfEdges<'_>, goal: &Goal) {
    /// Tunes counts only.
    const MOST_PASSES: usize = 12;
    let mut removal = Removal::default();
    let mut waiting = vec![true; mesh.positions.len()];
    let is_movable = |kind: &Kind| matches!(kind, Kind::Face | Kind::Curve);
    let mut is_movable: Vec<bool> = mesh.kinds.iter().map(is_movable).collect();
    if !goal.tight.is_empty() {
        let is_tight = |&half: &u32| goal.tight.contains_key(&mesh.surface_id(half));
        for half in mesh.halves().filter(is_tight) {
            is_movable[mesh.origin(half) as usize] = false;
        }
    }
    for _ in 0..MOST_PASSES {
        let mut removed = false;
        for vertex in 0..mesh.positions.len() as u32 {
            if !is_movable[vertex as usize] || !std::mem::take(&mut waiting[vertex as usize]) {
                continue;
            }
            if goal.even_curves && is_needed(mesh, vertex, goal) {
                continue;
            }
            if removal.remove(mesh, vertex) {
                removed = true;
                for hole in &removal.holes {
                    for &(corner, _) in &hole.corners {
                        waiting[corner as usize] = true;
                    }
                }
            }
        }
        if !removed {
            break;
        }
    }
}

impl Removal {
    /// Removes a vertex, if that may be.
    fn remove(&mut self, mesh: &mut HalfEdges<'_>, vertex: u32) -> bool {
        self.spokes.clear();
        self.spokes
            .extend(mesh.around(vertex).take(MOST_NEIGHBOURS + 1));
        let count = self.spokes.len();
        if count > MOST_NEIGHBOURS {
            return false;
        }
        self.slots.clear();
        self.slots
            .extend(self.spokes.iter().map(|&spoke| triangle_of(spoke)));
        let mut chord_twin = NONE;
        match mesh.kinds[vertex as usize] {
            Kind::Face => {
                self.dig(mesh, 0, 0, count);
                self.holes[1].corners.clear();
                self.holes[1].ears.clear();
                // The last two triangles of a tetrahedron stay apart.
                if let [(_, beyond), _, (last, _)] = self.holes[0].corners[..]
                    && mesh.apex(beyond) == last
                {
                    return false;
                }
            }
            Kind::Curve => {
                let mut features = (0..count).filter(|&i| mesh.is_feature(self.spokes[i]));
                let (Some(i), Some(j)) = (features.next(), features.next()) else {
                    return false;
                };
                let [back, on] = [i, j].map(|k| self.spokes[k]);
                if !chord_may_be(mesh, vertex, back, on) {
                    return false;
                }
                self.dig(mesh, 0, i, j - i);
                self.dig(mesh, 1, j, count - (j - i));
                let [first, second] = &self.holes;
                // One triangle between both edges just goes; its far side is
                // where the chord runs.
                let beyond = |hole: &Hole| match hole.corners[..] {
                    [(_, beyond), _] if !mesh.is_feature(beyond) => Some(beyond),
                    [_, _] => Some(NONE),
                    _ => None,
                };
                match (beyond(first), beyond(second)) {
                    (None, None) => {
                        let (from, to) = (first.corners[0].0, second.corners[0].0);
                        if mesh.are_joined(from, to) {
                            return false;
                        }
                    }
                    (Some(twin), None) | (None, Some(twin)) if twin != NONE => chord_twin = twin,
                    _ => return false,
                }
            }
            Kind::Corner | Kind::Gone => return false,
        }
        let mut used = 0;
        for hole in &mut self.holes {
            if !hole.fill(mesh, &self.slots[used..]) {
                return false;
            }
            used += hole.ears.len();
        }
        // Two triangles back to back would enclose nothing.
        let beyond = (chord_twin != NONE).then(|| mesh.apex(chord_twin));
        let over_chord = self.holes.iter().filter_map(Hole::apex_over_chord);
        let mut over_chord = over_chord.chain(beyond);
        if let (Some(a), Some(b)) = (over_chord.next(), over_chord.next())
            && a == b
        {
            return false;
        }
        if let [first, second] = &self.holes
            && let (Some(&(from, _)), Some(&(to, _))) =
                (first.corners.first(), second.corners.first())
        {
            mesh.carry_border([from, vertex], [from, to]);
        }
        // Nothing was touched so far.
        let mut slots = self.slots.iter();
        for hole in &self.holes {
            for ((corners, beyond), &triangle) in hole.ears.iter().zip(&mut slots) {
                mesh.set_region(triangle, hole.region);
                let halves = halves_of(triangle);
                for (half, (&corner, &beyond)) in halves.zip(corners.iter().zip(beyond)) {
                    mesh.set_origin(half, corner);
                    mesh.leaving[corner as usize] = half;
                    match beyond {
                        LATER => {}
                        NONE if chord_twin == NONE => chord_twin = half,
                        NONE => mesh.join(half, chord_twin),
                        twin => mesh.join(half, twin),
                    }
                }
            }
        }
        for &triangle in &self.slots[used..] {
            mesh.discard(triangle);
        }
        mesh.kinds[vertex as usize] = Kind::Gone;
        mesh.leaving[vertex as usize] = NONE;
        true
    }

    /// The hole that `count` triangles from spoke `from` on leave behind.
    fn dig(&mut self, mesh: &HalfEdges<'_>, which: usize, from: usize, count: usize) {
        let hole = &mut self.holes[which];
        let spokes = &self.spokes;
        hole.region = mesh.region_index(triangle_of(spokes[from]));
        hole.ears.clear();
        hole.corners.clear();
        for i in 0..count {
            let spoke = spokes[(from + i) % spokes.len()];
            let rim = next(spoke);
            hole.corners.push((mesh.origin(rim), mesh.twin(rim)));
        }
        if count < spokes.len() {
            // Closed by the chord.
            let last = spokes[(from + count) % spokes.len()];
            hole.corners.push((mesh.target(last), NONE));
        }
    }
}

/// Whether a chord past a vertex on a curve would stray more than four times the
/// tolerance, as twice the longest one there would: on a curve between a plane
/// and a developable face. Faces that bend both ways want large triangles first,
/// and other curves to be measured in long stretches.
fn is_needed(mesh: &HalfEdges<'_>, vertex: u32, goal: &Goal) -> bool {
    let mut features = mesh.around(vertex).filter(|&half| mesh.is_feature(half));
    let (Some(back), Some(on)) = (features.next(), features.next()) else {
        return false;
    };
    let edges = [back, on];
    let sides = [on, mesh.twin(on)];
    let bends = sides.map(|side| mesh.region(side).bend);
    if !bends.contains(&Bend::Flat) || bends.iter().any(|bend| bend.is_twice()) {
        return false;
    }
    let tolerance = sides.map(|side| goal.tolerance_on(mesh.surface_id(side)));
    let [before, after] = edges.map(|edge| mesh.at(mesh.target(edge)) - mesh.at(vertex));
    let doubled_area = before.cross(after).length_squared();
    let chord = (after - before).length_squared();
    // Of a chord l, a and b from the vertex, which is h off it: h l² / 4 a b.
    let sag = doubled_area * chord / (16.0 * before.length_squared() * after.length_squared());
    sag > (4.0 * tolerance[0].min(tolerance[1])).powi(2)
}

/// Whether a curve may be taken straight past a vertex, from the end of one of
/// its two edges to the end of the other: a chord that still runs along the
/// curve at both its ends, also where elongated ellipsoids beside it are round: else it may
/// cut off more than half of a curve around one, whose edges there run around its tips.
fn chord_may_be(mesh: &HalfEdges<'_>, vertex: u32, back: u32, on: u32) -> bool {
    let surfaces = mesh.curve_surfaces(on);
    let sides = [on, mesh.twin(on)].map(|side| mesh.region(side));
    let rounds = sides.map(|side| side.round.as_ref().filter(|_| side.bend == Bend::Double));
    let (p, q, r) = (
        mesh.at(mesh.target(back)),
        mesh.at(vertex),
        mesh.at(mesh.target(on)),
    );
    let chord = r - p;
    // The direction of the curve at an end, the way the old edge runs there.
    let along = |at: DVec3, edge: DVec3| {
        let [g1, g2] = surfaces.map(|s| s.gradient(at));
        let tangent = g1.cross(g2);
        let square = tangent.length_squared();
        // Where the surfaces touch it has none, and the edge must do.
        if square <= TOUCHING_AT_ENDS * TOUCHING_AT_ENDS * g1.length_squared() * g2.length_squared()
        {
            return chord.dot(edge) > 0.0;
        }
        let tangent = tangent * tangent.dot(edge).signum();
        let rounds = rounds.into_iter().flatten();
        let placed = rounds.map(|round| [tangent, chord].map(|along| round.direction(along)));
        placed.chain([[tangent, chord]]).all(|[tangent, chord]| {
            let cosine = tangent.dot(chord);
            let squares = tangent.length_squared() * chord.length_squared();
            cosine > 0.0 && cosine * cosine >= LEAST_CHORD_COSINE_SQUARED * squares
        })
    };
    along(p, q - p) && along(r, r - q)
}

impl Hole {
    /// Finds triangles for the hole; `slots` are those that they are going to
    /// be.
    fn fill(&mut self, mesh: &HalfEdges<'_>, slots: &[u32]) -> bool {
        if self.corners.len() < 3 || self.cut_off_ears(mesh, slots) {
            return true;
        }
        // Ears may leave corners in a line behind.
        (4..=MOST_CORNERS).contains(&self.corners.len()) && self.try_all(mesh, slots)
    }

    /// The corner across from the new chord of the triangle that ends at it.
    fn apex_over_chord(&self) -> Option<u32> {
        let own = |(corners, beyond): &([u32; 3], [u32; 3])| {
            let side = beyond.iter().position(|&beyond| beyond == NONE)?;
            Some(corners[(side + 2) % 3])
        };
        self.ears.iter().find_map(own)
    }

    fn may_be(&self, mesh: &HalfEdges<'_>, corners: [u32; 3]) -> bool {
        let region = &mesh.regions[self.region as usize];
        let surface = &mesh.surfaces[region.surface];
        faces_out(surface, region, corners.map(|v| mesh.at(v)), LEAST_COSINE)
    }

    /// Cuts off the ear with the shortest cut each time.
    fn cut_off_ears(&mut self, mesh: &HalfEdges<'_>, slots: &[u32]) -> bool {
        let region = &mesh.regions[self.region as usize];
        let surface = &mesh.surfaces[region.surface];
        self.ears.clear();
        self.rim.clear();
        self.rim.extend_from_slice(&self.corners);
        let triangle = |rim: &[(u32, u32)], i: usize| {
            let n = rim.len();
            [rim[(i + n - 1) % n].0, rim[i].0, rim[(i + 1) % n].0]
        };
        while self.rim.len() > 3 {
            let n = self.rim.len();
            let mut best = (f64::INFINITY, n);
            for i in 0..n {
                let [p, q, r] = triangle(&self.rim, i);
                let cut = metric(surface, region.bend, mesh.at(r) - mesh.at(p));
                if cut < best.0 && self.may_be(mesh, [p, q, r]) && !mesh.are_joined(p, r) {
                    best = (cut, i);
                }
            }
            let i = best.1;
            if i == n {
                return false;
            }
            let rim = &mut self.rim;
            let before = (i + n - 1) % n;
            let half = first_of(slots[self.ears.len()]);
            // Corners p, q, r: sides p → q, q → r, and r → p, beyond which the
            // rest of the hole is.
            self.ears
                .push((triangle(rim, i), [rim[before].1, rim[i].1, LATER]));
            rim[before].1 = half + 2;
            rim.remove(i);
        }
        let corners = [0, 1, 2].map(|i| self.rim[i].0);
        self.ears.push((corners, [0, 1, 2].map(|i| self.rim[i].1)));
        self.may_be(mesh, corners)
    }

    /// Finds the triangulation of the least squared cuts, if there is any, by
    /// dynamic programming over the parts that one cut leaves (Klincsek,
    /// *Minimal Triangulations of Polygonal Domains*, 1980).
    fn try_all(&mut self, mesh: &HalfEdges<'_>, slots: &[u32]) -> bool {
        let region = &mesh.regions[self.region as usize];
        let surface = &mesh.surfaces[region.surface];
        let n = self.corners.len();
        let corner = |i: usize| self.corners[i].0;
        // Of the part from corner i to corner j: the cost, and the apex over
        // the cut.
        let mut parts = [[(f64::INFINITY, 0); MOST_CORNERS]; MOST_CORNERS];
        for i in 0..n - 1 {
            parts[i][i + 1].0 = 0.0;
        }
        for length in 2..n {
            for i in 0..n - length {
                let j = i + length;
                let is_cut = length < n - 1;
                if is_cut && mesh.are_joined(corner(i), corner(j)) {
                    continue;
                }
                let edge = mesh.at(corner(j)) - mesh.at(corner(i));
                let cut = metric(surface, region.bend, edge);
                for k in i + 1..j {
                    let cost = parts[i][k].0 + parts[k][j].0 + cut;
                    if cost < parts[i][j].0 && self.may_be(mesh, [i, k, j].map(corner)) {
                        parts[i][j] = (cost, k);
                    }
                }
            }
        }
        if parts[0][n - 1].0 == f64::INFINITY {
            return false;
        }
        self.ears.clear();
        self.emit(&parts, 0, n - 1, slots);
        if let Some((_, beyond)) = self.ears.last_mut() {
            beyond[2] = self.corners[n - 1].1;
        }
        true
    }

    /// Adds the triangles of the part from corner i to corner j; returns the
    /// half-edge from j to i, or, where that is a side of the hole, what lies
    /// beyond it.
    fn emit(&mut self, parts: &Parts, i: usize, j: usize, slots: &[u32]) -> u32 {
        if j == i + 1 {
            return self.corners[i].1;
        }
        let k = parts[i][j].1;
        let before = self.emit(parts, i, k, slots);
        let after = self.emit(parts, k, j, slots);
        let half = first_of(slots[self.ears.len()]);
        let corners = [i, k, j].map(|i| self.corners[i].0);
        self.ears.push((corners, [before, after, LATER]));
        half + 2
    }
}

/// What lies beyond the side of an ear is another ear, which will know.
const LATER: u32 = NONE - 1;
