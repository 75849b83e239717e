//! From cells to vertices: one for every loop, two for every ambiguous face.

use glam::DVec3;
use pulp::Simd;

use super::constraints::Constraints;
use super::{Crossings, EDGES, Placer};
use crate::program::{Cell, Surface};
use crate::surface::solve;
use crate::surface_nets::brick::{self, Beam, Mask, WORDS};
use crate::surface_nets::lattice::{CELLS, SAMPLES};
use crate::surface_nets::loops::{self, PATTERNS};
use crate::surface_nets::part::{BrickRecord, ComplexCell, FaceArcs, Part};
use crate::surface_nets::scene::Scene;

impl Placer {
    /// Places the vertices of cells that one surface crosses in one loop.
    #[inline(always)]
    pub(super) fn place_simple<S: Simd>(
        &mut self,
        simd: S,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        part: &mut Part,
    ) {
        let step = scene.lattice.step;
        self.slow.clear();
        let mut several = if self.one_surface {
            [0; WORDS]
        } else {
            crossings.several[3]
        };
        self.mark_apexes(scene, cell, &crossings.solid[3], &mut several);
        let mut crossed_by_several = several;
        for (several, solid) in crossed_by_several.iter_mut().zip(&crossings.solid[3]) {
            *several &= solid;
        }
        brick::for_each_set(&crossed_by_several, |sample| self.slow.push(sample as u16));
        let beams = Beam::all(&self.classified.solid);
        for s in 0..cell.surfaces.len() {
            let surface = &scene.surfaces[cell.surfaces[s] as usize];
            let mut own = self.sole_changes(crossings, s, 3);
            let mut any = 0;
            for (own, several) in own.iter_mut().zip(&several) {
                *own &= !several;
                any |= *own;
            }
            if any == 0 {
                continue;
            }
            let count = brick::expand(&own, &mut self.list, |_, _, sample| sample);
            // Compacted in place: what is read lies ahead of what is written.
            let mut simple = 0;
            let list = &mut *self.list;
            let (x, y, z) = (&mut *self.x, &mut *self.y, &mut *self.z);
            for i in 0..count.min(EDGES) {
                let sample = list[i];
                let at = usize::from(sample) % EDGES;
                let corners = beams[at / SAMPLES].corners(at % SAMPLES);
                let pattern = &PATTERNS[usize::from(corners)];
                let low = self.samples.point(at);
                // Written over if the cell is not one.
                list[simple] = sample;
                x[simple] = low.x + pattern.middle[0] * step;
                y[simple] = low.y + pattern.middle[1] * step;
                z[simple] = low.z + pattern.middle[2] * step;
                simple += usize::from(pattern.simple);
                if !pattern.simple {
                    self.slow.push(sample);
                }
            }
            self.move_to_surface(simd, scene, surface, simple, part);
        }
    }

    /// Moves the starting points of so many simple cells to their surface, and
    /// adds them to the part; those that do not get there become slow cells.
    #[inline(always)]
    fn move_to_surface<S: Simd>(
        &mut self,
        simd: S,
        scene: &Scene<'_>,
        surface: &Surface,
        simple: usize,
        part: &mut Part,
    ) {
        let step = scene.lattice.step;
        let Some(last) = simple.checked_sub(1) else {
            return;
        };
        // Whole vectors: the last point fills up.
        let padded = simple.next_multiple_of(solve::LANES).min(EDGES);
        let (x, y, z) = (&mut *self.x, &mut *self.y, &mut *self.z);
        for i in simple..padded {
            (x[i], y[i], z[i]) = (x[last], y[last], z[last]);
        }
        // The square of the last step, relative to the radius of curvature
        // (hardly below a cell), is what remains.
        let points = [&mut x[..padded], &mut y[..padded], &mut z[..padded]];
        let way = solve::project_all(simd, surface, 1e-7 * step, points);
        let (x, y, z) = (&x[..simple], &y[..simple], &z[..simple]);
        let cells = &self.list[..simple];
        let samples = &self.samples;
        let points = || {
            x.iter()
                .zip(y)
                .zip(z)
                .map(|((&x, &y), &z)| DVec3::new(x, y, z))
        };
        let is_near = |(&sample, point): (&u16, DVec3)| {
            let low = samples.point(usize::from(sample) % EDGES);
            let off = (point - low - 0.5 * step).abs();
            (off.x <= step) & (off.y <= step) & (off.z <= step)
        };
        // Nearly always all of them are: starting within their cells, they
        // have not gone far.
        let converged = way.is_some();
        let all_near = || {
            let mut each = cells.iter().zip(points());
            each.all(is_near)
        };
        if converged && (way <= Some(0.5 * step) || all_near()) {
            part.cells.extend_from_slice(cells);
            part.vertices.extend(points());
            return;
        }
        for (sample, point) in cells.iter().zip(points()) {
            let residual = || solve::residual(std::iter::once(surface), point);
            if is_near((sample, point)) && (converged || residual() <= scene.tolerance) {
                part.cells.push(*sample);
                part.vertices.push(point);
            } else {
                self.slow.push(*sample);
            }
        }
    }

    /// Finds and marks the cells that are to have an apex as a vertex: the one
    /// that holds it or, where the tip pokes into a cell without reaching a
    /// sample, the next along the cone's axis that the boundary crosses.
    pub(super) fn mark_apexes(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossed: &Mask,
        marks: &mut Mask,
    ) {
        self.apexes.clear();
        self.has_apexes = false;
        for &id in &cell.surfaces {
            let surface = &scene.surfaces[id as usize];
            let Some(apex) = surface.apex() else {
                continue;
            };
            self.has_apexes = true;
            let mut found = Vec::new();
            match self.cell_at(scene, apex) {
                Some(own) if brick::is_set(crossed, own) => found.push(own),
                _ => {
                    let step = 0.5 * scene.lattice.step * surface.cone_axis();
                    for direction in [step, -step] {
                        let along = (1..=3).map(|k| apex + f64::from(k) * direction);
                        let mut cells = along.filter_map(|point| self.cell_at(scene, point));
                        found.extend(cells.find(|&at| brick::is_set(crossed, at)));
                    }
                }
            }
            for sample in found {
                marks[sample >> 6] |= 1 << (sample & 63);
                self.apexes.push((sample as u16, apex));
            }
        }
    }

    /// The brick's cell that a point lies in.
    pub(super) fn cell_at(&self, scene: &Scene<'_>, point: DVec3) -> Option<usize> {
        let first = self.samples.point(0);
        let index = ((point - first) / scene.lattice.step).floor();
        let fits = index.min_element() >= 0.0 && index.max_element() < CELLS as f64;
        fits.then(|| index.x as usize + 16 * index.y as usize + 256 * index.z as usize)
    }

    /// Places the vertices of all other cells: several surfaces, several loops
    /// or ambiguous faces.
    #[inline(always)]
    pub(super) fn place_slow(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        record: &BrickRecord,
        part: &mut Part,
    ) {
        let mut slow = std::mem::take(&mut self.slow);
        slow.sort_unstable();
        // Simple cells first: the i-th of them has the brick's i-th vertex.
        self.complex.clear();
        for &sample in &slow {
            let corners = brick::corners(&self.classified.solid, usize::from(sample));
            let pattern = &PATTERNS[usize::from(corners)];
            if pattern.simple {
                let edges = pattern.loops.edges;
                part.cells.push(sample);
                self.place_loop(scene, cell, usize::from(sample), edges, part);
            } else {
                self.complex.push((sample, corners));
            }
        }
        self.slow = slow;
        for (sample, corners) in std::mem::take(&mut self.complex) {
            let at = usize::from(sample);
            let mut joined = 0;
            for face in 0..6 {
                if PATTERNS[usize::from(corners)].ambiguous >> face & 1 == 1 {
                    let (axis, side) = (face / 2, face & 1);
                    let lowest = at + (side << (4 * axis));
                    let is_joined = self.face_is_joined(scene, cell, axis, lowest);
                    joined |= u8::from(is_joined) << face;
                }
            }
            let loops = loops::trace(corners, joined);
            part.complex.push(ComplexCell {
                sample,
                loops,
                vertex: part.vertices.len() as u32 - record.vertices.start,
            });
            for index in 0..usize::from(loops.count) {
                self.place_loop(scene, cell, at, loops.edges_of(index), part);
            }
        }
    }

    /// The vertex of one loop: on all surfaces that cause its crossings.
    #[inline(always)]
    pub(super) fn place_loop(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        sample: usize,
        edges: u16,
        part: &mut Part,
    ) {
        let mut constraints = Constraints::default();
        let mut start = DVec3::ZERO;
        let mut remaining = edges;
        while remaining != 0 {
            let edge = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            let (axis, offset) = EDGE_OFFSETS[edge];
            constraints.insert(self.cause(axis, sample + offset));
            start += self.edge_middle(scene, axis, sample + offset);
        }
        start /= f64::from(edges.count_ones());
        let middle = self.samples.point(sample) + 0.5 * scene.lattice.step;
        let crossed = EDGE_OFFSETS.iter().enumerate();
        let crossed = crossed.filter(|&(edge, _)| edges >> edge & 1 == 1);
        let crossed = crossed.map(|(_, &(axis, offset))| (axis, sample + offset));
        if let Some(more) = self.crowd(&constraints, crossed)
            && let Some(point) = self.meet_at(scene, cell, &more, start, middle)
        {
            part.vertices.push(point);
            return;
        }
        self.place_vertex(scene, cell, constraints, start, middle, part);
    }

    /// Whether the inside corners of an ambiguous face are joined across it:
    /// by surfaces where they pair up one way only, never where two parts touch
    /// along an edge, else by what the solid is in the middle of the face. Depends on the face alone, so both its cells
    /// agree.
    pub(super) fn face_is_joined(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        axis: usize,
        lowest: usize,
    ) -> bool {
        let causes = self.face_edges(axis, lowest).map(|(a, s)| self.cause(a, s));
        let [a, b, c, d] = causes;
        let first_inside = brick::is_set(&self.classified.solid, lowest);
        // Arcs (0,1) and (2,3) cut off the odd corners, (1,2) and (3,0) the even.
        let odd = a == b && c == d;
        let even = b == c && d == a;
        if odd != even {
            return even != first_inside;
        }
        if a == c && b == d && a != b {
            // The curve in which two surfaces meet pierces the face, the solid
            // alternates around it: parts that touch along an edge stay apart.
            return false;
        }
        let (b, c) = loops::next_axes(axis);
        let mut middle = self.samples.point(lowest);
        middle[b] += 0.5 * scene.lattice.step;
        middle[c] += 0.5 * scene.lattice.step;
        self.truth.contains(scene.surfaces, cell, middle)
    }

    /// The (axis, lower sample) of the edges of a face, in cyclic order.
    pub(super) fn face_edges(&self, axis: usize, lowest: usize) -> [(usize, usize); 4] {
        let (b, c) = loops::next_axes(axis);
        let (step_b, step_c) = (1 << (4 * b), 1 << (4 * c));
        [
            (b, lowest),
            (c, lowest + step_b),
            (b, lowest + step_c),
            (c, lowest),
        ]
    }

    /// Puts two vertices on every ambiguous face the brick owns, one on each
    /// arc, so that no two mesh edges join the same two loops.
    #[inline(always)]
    pub(super) fn place_arcs(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        record: &BrickRecord,
        part: &mut Part,
    ) {
        for axis in 0..3 {
            let mut faces = [0; WORDS];
            if brick::ambiguous_faces(axis, &crossings.solid, &mut faces) {
                self.place_axis_arcs(scene, cell, axis, &faces, record, part);
            }
        }
    }

    /// The vertices on ambiguous faces normal to one axis.
    #[inline(never)]
    pub(super) fn place_axis_arcs(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        axis: usize,
        faces: &Mask,
        record: &BrickRecord,
        part: &mut Part,
    ) {
        let (b, c) = loops::next_axes(axis);
        let mut lowest_samples = Vec::new();
        brick::for_each_set(faces, |sample| lowest_samples.push(sample));
        for lowest in lowest_samples {
            let joined = self.face_is_joined(scene, cell, axis, lowest);
            part.arcs.push(FaceArcs {
                face: (axis << 12 | lowest) as u16,
                vertex: part.vertices.len() as u32 - record.vertices.start,
                joined,
            });
            let edges = self.face_edges(axis, lowest);
            let first_inside = brick::is_set(&self.classified.solid, lowest);
            let mut middle = self.samples.point(lowest);
            middle[b] += 0.5 * scene.lattice.step;
            middle[c] += 0.5 * scene.lattice.step;
            let partner = loops::ambiguous_partner(first_inside, joined, 0);
            let other = if partner == 1 { 2 } else { 1 };
            let other_partner = loops::ambiguous_partner(first_inside, joined, other);
            for pair in [[0, partner], [other, other_partner]] {
                let mut constraints = Constraints::default();
                let mut start = DVec3::ZERO;
                for i in pair {
                    let (axis, sample) = edges[i];
                    constraints.insert(self.cause(axis, sample));
                    start += 0.5 * self.edge_middle(scene, axis, sample);
                }
                if let Some(more) = self.crowd(&constraints, pair.into_iter().map(|i| edges[i]))
                    && let Some(point) = self.meet_at(scene, cell, &more, start, middle)
                {
                    part.vertices.push(point);
                    continue;
                }
                self.place_vertex(scene, cell, constraints, start, middle, part);
            }
        }
    }
}

/// Per edge of a cell its axis and the offset of its lower sample from the
/// cell's.
const EDGE_OFFSETS: [(usize, usize); 12] = {
    let mut offsets = [(0, 0); 12];
    let mut edge = 0;
    while edge < 12 {
        let start = loops::edge_start(edge);
        let offset = (start & 1) + 16 * (start >> 1 & 1) + 256 * (start >> 2);
        offsets[edge] = (edge / 4, offset);
        edge += 1;
    }
    offsets
};
