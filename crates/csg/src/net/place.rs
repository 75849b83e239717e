//! From a classified brick to vertices: which surface causes each crossing,
//! which crossings form a vertex, and where it lies.

use glam::{DVec3, UVec3};

use super::brick::{self, Classified, Mask, Samples, WORDS};
use super::lattice::{CELLS, Lattice, SAMPLES};
use super::loops::{self, PATTERNS};
use super::part::{
    BrickRecord, ComplexCell, FaceArcs, Fallback, FallbackKind, Part, PolygonCode, PolygonGroup,
};
use super::{solve, validity};
use crate::program::{Cell, Origin, Side, Surface};

const EDGES: usize = SAMPLES * SAMPLES * SAMPLES;

/// The surfaces of one vertex, as positions in the brick's list. More than
/// this never have a common point but by construction of the model.
const MOST_CONSTRAINTS: usize = 8;

#[derive(Clone, Copy, Debug, Default)]
struct Constraints {
    len: usize,
    list: [u16; MOST_CONSTRAINTS],
}

impl Constraints {
    fn insert(&mut self, surface: u16) {
        if !self.as_slice().contains(&surface) && self.len < MOST_CONSTRAINTS {
            self.list[self.len] = surface;
            self.len += 1;
        }
    }

    fn as_slice(&self) -> &[u16] {
        &self.list[..self.len]
    }

    fn without(&self, index: usize) -> Self {
        let mut rest = Self::default();
        for (i, &surface) in self.as_slice().iter().enumerate() {
            if i != index {
                rest.insert(surface);
            }
        }
        rest
    }
}

/// A vertex in place, and what is to be known should it not be valid.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Index into the part's vertices.
    vertex: usize,
    constraints: Constraints,
    /// The mean of its crossed edges' middles.
    start: DVec3,
    /// The middle of the cell or face.
    middle: DVec3,
}

/// What the whole mesh has in common.
pub(super) struct Scene<'a> {
    /// The program's surfaces, in the local frame.
    pub surfaces: &'a [Surface],
    pub lattice: Lattice,
    /// The primitives that literals come from.
    pub origins: &'a [Origin],
    /// Distance to a surface below which a point lies on it.
    pub tolerance: f64,
}

impl Scene<'_> {
    /// Whether two primitives have the same kind, name and colour.
    fn look_alike(&self, a: u32, b: u32) -> bool {
        a == b || self.origins[a as usize] == self.origins[b as usize]
    }
}

/// Scratch memory of one worker, reused from brick to brick.
pub(super) struct Placer {
    classified: Classified,
    samples: Samples,
    /// Per surface: where it changes sign along x, y, z, and which cells it
    /// crosses as far as their corners tell.
    changes: Vec<[Mask; 4]>,
    /// Per axis and lower sample: the surface that causes the crossing.
    cause: [Box<[u16; EDGES]>; 3],
    polygons: Vec<Vec<PolygonCode>>,
    /// Starting points, then vertices, of the simple cells of one surface.
    x: Box<[f64; EDGES]>,
    y: Box<[f64; EDGES]>,
    z: Box<[f64; EDGES]>,
    /// The samples of a mask, one by one.
    list: Box<[u16; EDGES]>,
    /// Whether one surface alone crosses the brick: it causes everything.
    one_surface: bool,
    gates: Vec<u64>,
    signs: Vec<u64>,
    slow: Vec<u16>,
    complex: Vec<(u16, u8)>,
    /// The cells that are to have an apex as a vertex.
    apexes: Vec<(u16, DVec3)>,
    candidates: Vec<Candidate>,
    table: validity::Table,
}

impl Default for Placer {
    fn default() -> Self {
        Self {
            classified: Classified::default(),
            samples: Samples {
                x: [0.0; SAMPLES],
                y: [0.0; SAMPLES],
                z: [0.0; SAMPLES],
            },
            changes: Vec::new(),
            cause: [(); 3].map(|()| Box::new([0; EDGES])),
            polygons: Vec::new(),
            x: Box::new([0.0; EDGES]),
            y: Box::new([0.0; EDGES]),
            z: Box::new([0.0; EDGES]),
            list: Box::new([0; EDGES]),
            one_surface: false,
            gates: Vec::new(),
            signs: Vec::new(),
            slow: Vec::new(),
            complex: Vec::new(),
            apexes: Vec::new(),
            candidates: Vec::new(),
            table: validity::Table::default(),
        }
    }
}

/// Where the solid, and more than one surface at once, changes sign.
struct Crossings {
    /// Along x, y, z, and per cell.
    solid: [Mask; 4],
    several: [Mask; 4],
}

impl Placer {
    /// Processes one brick: appends its vertices and polygons to `part`.
    #[inline(always)]
    pub fn brick(&mut self, scene: &Scene<'_>, cell: &Cell, position: UVec3, part: &mut Part) {
        let lattice = &scene.lattice;
        let first = position * CELLS as u32;
        for i in 0..SAMPLES {
            self.samples.x[i] = lattice.coordinate(0, first.x + i as u32);
            self.samples.y[i] = lattice.coordinate(1, first.y + i as u32);
            self.samples.z[i] = lattice.coordinate(2, first.z + i as u32);
        }
        part.bricks_sampled += 1;
        self.classified
            .classify(cell, scene.surfaces, &self.samples);
        let inside = self.classified.solid[0] & 1 == 1;
        let constant = if inside { u64::MAX } else { 0 };
        if self.classified.solid.iter().all(|&word| word == constant) {
            self.report_unseen(scene, cell, part);
            return;
        }
        let crossings = self.find_crossings(cell.surfaces.len());
        let record = part.open_brick(position);
        self.find_causes(scene, cell, &crossings, part);
        self.place_simple(scene, cell, &crossings, part);
        self.place_slow(scene, cell, &record, part);
        self.place_arcs(scene, cell, &crossings, &record, part);
        self.settle(scene, cell, part);
        self.collect_polygons(scene, cell, part);
        part.close_brick(record);
    }

    /// Reports what of the boundary lies in a brick all of whose samples are
    /// alike: the point of each surface nearest to the brick's middle, if the
    /// solid changes across the surface there.
    #[inline(never)]
    fn report_unseen(&mut self, scene: &Scene<'_>, cell: &Cell, part: &mut Part) {
        let half = 0.5 * scene.lattice.step * CELLS as f64;
        let middle = self.samples.point(0) + half;
        for s in 0..cell.surfaces.len() as u16 {
            let surface = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
            let place = solve::common_point(&[surface], middle, half).point;
            let mut constraints = Constraints::default();
            constraints.insert(s);
            if (place - middle).abs().max_element() <= half
                && self.is_valid(scene, cell, &constraints, place)
            {
                part.fallbacks.push(Fallback {
                    kind: FallbackKind::Unseen,
                    place,
                });
            }
        }
    }

    #[inline(always)]
    fn find_crossings(&mut self, surfaces: usize) -> Crossings {
        let mut crossings = Crossings {
            solid: [[0; WORDS]; 4],
            several: [[0; WORDS]; 4],
        };
        let fill = |mask: &Mask, out: &mut [Mask; 4]| {
            let [x, y, z, cells] = out;
            brick::changes_along(0, mask, x);
            brick::changes_along(1, mask, y);
            brick::changes_along(2, mask, z);
            brick::mixed_cells(mask, cells);
        };
        fill(&self.classified.solid, &mut crossings.solid);
        self.changes.clear();
        self.changes.resize(surfaces, [[0; WORDS]; 4]);
        if surfaces == 1 {
            self.changes[0] = crossings.solid;
            return crossings;
        }
        let mut any = [[0u64; WORDS]; 4];
        for (signs, changes) in self.classified.signs.iter().zip(&mut self.changes) {
            fill(signs, changes);
            for ((any, several), changes) in
                any.iter_mut().zip(&mut crossings.several).zip(&*changes)
            {
                for ((any, several), &changes) in any.iter_mut().zip(several).zip(changes) {
                    *several |= *any & changes;
                    *any |= changes;
                }
            }
        }
        crossings
    }

    /// Finds the surface of every crossing, and collects the polygons of those
    /// that the brick owns.
    #[inline(always)]
    fn find_causes(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        part: &mut Part,
    ) {
        self.polygons.iter_mut().for_each(Vec::clear);
        if self.polygons.len() < cell.surfaces.len() {
            self.polygons.resize_with(cell.surfaces.len(), Vec::new);
        }
        let several_surfaces = cell.surfaces.len() > 1;
        self.one_surface = !several_surfaces;
        let list = &mut *self.list;
        for (s, changes) in self.changes.iter().enumerate() {
            for (axis, changes) in changes[..3].iter().enumerate() {
                let mut changed = [0; WORDS];
                let mut any = 0;
                for (word, changed) in changed.iter_mut().enumerate() {
                    *changed = crossings.solid[axis][word]
                        & changes[word]
                        & !crossings.several[axis][word];
                    any |= *changed;
                }
                if any == 0 {
                    continue;
                }
                if several_surfaces {
                    let count = brick::expand(&changed, list);
                    for &sample in &list[..count] {
                        self.cause[axis][usize::from(sample) % EDGES] = s as u16;
                    }
                }
                // All that a code says but the sample is constant for each
                // combination of the two ends' sides.
                for (inside, within) in [(false, false), (false, true), (true, false), (true, true)]
                {
                    let mut chosen = [0; WORDS];
                    let mut any = 0;
                    for (word, chosen) in chosen.iter_mut().enumerate() {
                        let solid = self.classified.solid[word];
                        let surface = self.classified.signs[s][word];
                        let solid = if inside { solid } else { !solid };
                        let surface = if within { surface } else { !surface };
                        *chosen = changed[word] & solid & surface & brick::OWNED[word];
                        any |= *chosen;
                    }
                    if any != 0 {
                        let count = brick::expand(&chosen, list);
                        let code = |&sample| PolygonCode::new(axis, inside, within, sample);
                        self.polygons[s].extend(list[..count].iter().map(code));
                    }
                }
            }
        }
        for axis in 0..3 {
            for word in 0..WORDS {
                let mut bits = crossings.solid[axis][word] & crossings.several[axis][word];
                while bits != 0 {
                    let bit = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    let sample = word * 64 + bit;
                    let (s, several) = self.edge_cause(scene, cell, axis, sample);
                    self.cause[axis][sample] = s;
                    let is_owned = brick::is_set(&brick::OWNED, sample);
                    if several && is_owned {
                        part.fallbacks.push(Fallback {
                            kind: FallbackKind::SeveralCrossings,
                            place: self.samples.point(sample),
                        });
                    }
                    if is_owned {
                        let s = usize::from(s);
                        let inside = brick::is_set(&self.classified.solid, sample);
                        let within = brick::is_set(&self.classified.signs[s], sample);
                        self.polygons[s].push(PolygonCode::new(
                            axis,
                            inside,
                            within,
                            sample as u16,
                        ));
                    }
                }
            }
        }
    }

    /// The crossing of an edge on which several surfaces change sign: their
    /// roots in order, the formula between them, and of the odd number of
    /// transitions the one nearest to the middle that goes the way the whole
    /// edge does.
    #[inline(never)]
    fn edge_cause(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        axis: usize,
        sample: usize,
    ) -> (u16, bool) {
        let start = self.samples.point(sample);
        let mut roots: Vec<(f64, u16)> = Vec::with_capacity(4);
        for (s, changes) in self.changes.iter().enumerate() {
            if brick::is_set(&changes[axis], sample) {
                let surface = &scene.surfaces[cell.surfaces[s] as usize];
                let t = root_along(surface, start, axis, scene.lattice.step);
                roots.push((t, s as u16));
            }
        }
        roots.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Bit i of an assignment: after the first i roots.
        roots.truncate(63);
        let signs = &self.classified.signs;
        let result = brick::evaluate_assignments(&cell.formula, &mut self.gates, |_, surface| {
            let inside = brick::is_set(&signs[surface as usize], sample);
            let before = if inside { u64::MAX } else { 0 };
            match roots.iter().position(|&(_, s)| u32::from(s) == surface) {
                Some(rank) => before ^ (u64::MAX << (rank + 1)),
                None => before,
            }
        });
        let transitions: Vec<usize> = (0..roots.len())
            .filter(|&i| (result >> i ^ result >> (i + 1)) & 1 == 1)
            .collect();
        let chosen = transitions
            .get((transitions.len() / 2) & !1)
            .copied()
            .unwrap_or(roots.len() / 2);
        (roots[chosen].1, transitions.len() > 1)
    }

    /// Places the vertices of cells that one surface crosses in one loop.
    #[inline(always)]
    fn place_simple(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        part: &mut Part,
    ) {
        let step = scene.lattice.step;
        self.slow.clear();
        let mut several = crossings.several[3];
        self.mark_apexes(scene, cell, &crossings.solid[3], &mut several);
        brick::for_each_set(&crossings.solid[3], |sample| {
            if brick::is_set(&several, sample) {
                self.slow.push(sample as u16);
            }
        });
        for s in 0..cell.surfaces.len() {
            let surface = &scene.surfaces[cell.surfaces[s] as usize];
            let mut own = [0; WORDS];
            let mut any = 0;
            for (word, own) in own.iter_mut().enumerate() {
                *own = crossings.solid[3][word] & self.changes[s][3][word] & !several[word];
                any |= *own;
            }
            if any == 0 {
                continue;
            }
            let count = brick::expand(&own, &mut self.list);
            // Compacted in place: what is read lies ahead of what is written.
            let mut simple = 0;
            for i in 0..count {
                let sample = self.list[i];
                let at = usize::from(sample) % EDGES;
                let pattern = &PATTERNS[usize::from(brick::corners(&self.classified.solid, at))];
                if !pattern.simple {
                    self.slow.push(sample);
                    continue;
                }
                let low = self.samples.point(at);
                self.list[simple] = sample;
                self.x[simple] = low.x + pattern.middle[0] * step;
                self.y[simple] = low.y + pattern.middle[1] * step;
                self.z[simple] = low.z + pattern.middle[2] * step;
                simple += 1;
            }
            let cells = &self.list[..simple];
            let (x, y, z) = (
                &mut self.x[..simple],
                &mut self.y[..simple],
                &mut self.z[..simple],
            );
            // The square of the last step, relative to the radius of curvature
            // (hardly below a cell), is what remains.
            let converged = solve::project_all(surface, 1e-8 * step, x, y, z);
            let is_good = |(&sample, ((&x, &y), &z)): (&u16, ((&f64, &f64), &f64))| {
                let point = DVec3::new(x, y, z);
                let low = self.samples.point(usize::from(sample) % EDGES);
                let near = (point - low - 0.5 * step).abs().max_element() <= step;
                near && (converged
                    || solve::residual(std::iter::once(surface), point) <= scene.tolerance)
            };
            let points = || x.iter().zip(&*y).zip(&*z);
            // Nearly always all of them are.
            let good = cells
                .iter()
                .zip(points())
                .fold(true, |all, one| all & is_good(one));
            if good {
                part.cells.extend_from_slice(cells);
                let points = points().map(|((&x, &y), &z)| DVec3::new(x, y, z));
                part.vertices.extend(points);
                continue;
            }
            for (&sample, ((&x, &y), &z)) in cells.iter().zip(points()) {
                if is_good((&sample, ((&x, &y), &z))) {
                    part.cells.push(sample);
                    part.vertices.push(DVec3::new(x, y, z));
                } else {
                    self.slow.push(sample);
                }
            }
        }
    }

    /// Finds and marks the cells that are to have an apex as a vertex: the one
    /// that holds it or, where the tip pokes into a cell without reaching a
    /// sample, the next along the cone's axis that the boundary crosses.
    fn mark_apexes(&mut self, scene: &Scene<'_>, cell: &Cell, crossed: &Mask, marks: &mut Mask) {
        self.apexes.clear();
        for &id in &cell.surfaces {
            let surface = &scene.surfaces[id as usize];
            let Some(apex) = surface.apex() else {
                continue;
            };
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
    fn cell_at(&self, scene: &Scene<'_>, point: DVec3) -> Option<usize> {
        let first = self.samples.point(0);
        let index = ((point - first) / scene.lattice.step).floor();
        let fits = index.min_element() >= 0.0 && index.max_element() < CELLS as f64;
        fits.then(|| index.x as usize + 16 * index.y as usize + 256 * index.z as usize)
    }

    /// Places the vertices of all other cells: several surfaces, several loops
    /// or ambiguous faces.
    #[inline(always)]
    fn place_slow(
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
            part.complex.push(ComplexCell {
                sample,
                corners,
                joined,
                vertex: part.vertices.len() as u32 - record.vertices,
            });
            let traced = loops::trace(corners, joined);
            for index in 0..usize::from(traced.count) {
                self.place_loop(scene, cell, at, traced.edges_of(index), part);
            }
        }
    }

    /// Whether the inside corners of an ambiguous face are joined across it:
    /// by surfaces where they pair up one way only, never where two parts touch
    /// along an edge, else by what the solid is in the middle of the face. Depends on the face alone, so both its cells
    /// agree.
    fn face_is_joined(
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
        self.contains(scene, cell, middle)
    }

    /// The (axis, lower sample) of the edges of a face, in cyclic order.
    fn face_edges(&self, axis: usize, lowest: usize) -> [(usize, usize); 4] {
        let (b, c) = loops::next_axes(axis);
        let (step_b, step_c) = (1 << (4 * b), 1 << (4 * c));
        [
            (b, lowest),
            (c, lowest + step_b),
            (b, lowest + step_c),
            (c, lowest),
        ]
    }

    fn contains(&mut self, scene: &Scene<'_>, cell: &Cell, point: DVec3) -> bool {
        self.signs.clear();
        let values = cell.surfaces.iter().map(|&id| {
            let inside = scene.surfaces[id as usize].value(point) <= 0.0;
            if inside { u64::MAX } else { 0 }
        });
        self.signs.extend(values);
        let signs = &self.signs;
        let result = brick::evaluate_assignments(&cell.formula, &mut self.gates, |_, surface| {
            signs[surface as usize]
        });
        result & 1 == 1
    }

    /// The vertex of one loop: on all surfaces that cause its crossings.
    #[inline(always)]
    fn place_loop(
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
        self.place_vertex(scene, cell, constraints, start, middle, part);
    }

    /// The surface that causes a crossing.
    fn cause(&self, axis: usize, sample: usize) -> u16 {
        if self.one_surface {
            0
        } else {
            self.cause[axis][sample % EDGES]
        }
    }

    /// The middle of a lattice edge.
    fn edge_middle(&self, scene: &Scene<'_>, axis: usize, sample: usize) -> DVec3 {
        let mut point = self.samples.point(sample);
        point[axis] += 0.5 * scene.lattice.step;
        point
    }

    /// Adds a vertex on all `constraints`, expected near `start`; `middle` is
    /// the middle of its cell or face, which it may leave by a cell at most.
    /// Whether the solid really changes there is left to [`Self::settle`].
    fn place_vertex(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: Constraints,
        start: DVec3,
        middle: DVec3,
        part: &mut Part,
    ) {
        let vertex = part.vertices.len();
        if let Some(apex) = self.apex_vertex(scene, cell, &constraints, middle) {
            part.vertices.push(apex);
            return;
        }
        let found = self.try_constraints(scene, cell, &constraints, start, middle);
        part.vertices.push(found.unwrap_or(start));
        let candidate = Candidate {
            vertex,
            constraints,
            start,
            middle,
        };
        if found.is_some() {
            self.candidates.push(candidate);
        } else {
            self.repair(scene, cell, &candidate, None, part);
        }
    }

    /// Tests all vertices placed since the last call, and repairs those across
    /// which the solid does not change as their crossings say.
    #[inline(always)]
    fn settle(&mut self, scene: &Scene<'_>, cell: &Cell, part: &mut Part) {
        let candidates = std::mem::take(&mut self.candidates);
        for batch in candidates.chunks(validity::LANES) {
            let points = batch.iter().map(|c| part.vertices[c.vertex]);
            let mut tests = validity::Tests::new(points, scene, cell);
            for (lane, candidate) in batch.iter().enumerate() {
                tests.free(lane, candidate.constraints.as_slice());
            }
            let valid = tests.evaluate(&cell.formula, &mut self.table);
            for (lane, candidate) in batch.iter().enumerate() {
                let point = part.vertices[candidate.vertex];
                let is_valid = match valid.get(lane, candidate.constraints.len) {
                    Some(valid) => valid,
                    None => self.is_valid(scene, cell, &candidate.constraints, point),
                };
                if !is_valid {
                    self.repair(scene, cell, candidate, Some(point), part);
                }
            }
        }
        self.candidates = candidates;
        self.candidates.clear();
    }

    /// Finds another place for a vertex: with one more surface, for a feature
    /// that no sample saw, or on fewer, and reports what it had to settle for.
    /// `plain` is the common point of its constraints, if there is one.
    #[inline(never)]
    fn repair(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        candidate: &Candidate,
        plain: Option<DVec3>,
        part: &mut Part,
    ) {
        let Candidate {
            vertex,
            constraints,
            start,
            middle,
        } = candidate;
        if constraints.len < 3 {
            for extra in 0..cell.surfaces.len() as u16 {
                if constraints.as_slice().contains(&extra) {
                    continue;
                }
                let surface = &scene.surfaces[cell.surfaces[usize::from(extra)] as usize];
                let half = DVec3::splat(scene.lattice.step);
                if surface.side_of_box(*middle, half) != Side::Crossing {
                    continue;
                }
                let mut more = *constraints;
                more.insert(extra);
                if let Some(point) = self.try_constraints(scene, cell, &more, *start, *middle)
                    && self.is_valid(scene, cell, &more, point)
                {
                    part.vertices[*vertex] = point;
                    return;
                }
            }
        }
        let kind = if plain.is_some() {
            FallbackKind::HiddenFeature
        } else {
            FallbackKind::NoCommonPoint
        };
        let place = plain.unwrap_or(*start);
        part.fallbacks.push(Fallback { kind, place });
        if plain.is_some() {
            return;
        }
        // As many of the surfaces as have a common point.
        let mut fewer = vec![*constraints];
        while let Some(candidates) = shrink(&fewer) {
            for candidate in &candidates {
                if let Some(point) = self.try_constraints(scene, cell, candidate, *start, *middle) {
                    part.vertices[*vertex] = point;
                    return;
                }
            }
            fewer = candidates;
        }
    }

    /// The apex of one of the surfaces, if it is on all of them, a part of the
    /// solid's boundary, and either marked for this cell or, where several
    /// surfaces meet in nothing but the apex, within the reach of a vertex.
    fn apex_vertex(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        middle: DVec3,
    ) -> Option<DVec3> {
        let step = scene.lattice.step;
        let surface = |s: u16| &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        let list = constraints.as_slice();
        let mut apexes = list.iter().filter_map(|&s| surface(s).apex());
        let reach = if list.len() > 1 {
            1.5 * step
        } else {
            0.5 * step
        };
        let apex = apexes.find(|&apex| {
            let holds = (apex - middle).abs().max_element() <= reach;
            let is_marked = self.apexes.iter().any(|&(sample, marked)| {
                marked == apex && self.samples.point(usize::from(sample)) + 0.5 * step == middle
            });
            holds || is_marked
        })?;
        let on_all = solve::residual(list.iter().map(|&s| surface(s)), apex) <= scene.tolerance;
        (on_all && self.is_valid(scene, cell, constraints, apex)).then_some(apex)
    }

    /// A point on all constraints within a cell of `middle`, if there is one.
    fn try_constraints(
        &self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        start: DVec3,
        middle: DVec3,
    ) -> Option<DVec3> {
        let mut list = [&scene.surfaces[0]; MOST_CONSTRAINTS];
        for (slot, &s) in list.iter_mut().zip(constraints.as_slice()) {
            *slot = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        }
        let step = scene.lattice.step;
        let solution = solve::common_point(&list[..constraints.len], start, step);
        let near = (solution.point - middle).abs().max_element() <= 1.5 * step;
        (near && solution.residual <= scene.tolerance).then_some(solution.point)
    }

    /// Whether the solid changes across each of the constraints at `point`:
    /// the formula over all their sign combinations, the other surfaces as
    /// they are there (both ways where they pass through the point, too).
    fn is_valid(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        point: DVec3,
    ) -> bool {
        /// Bit i of the k-th: bit k of i.
        const VARIABLES: [u64; 6] = [
            0xaaaa_aaaa_aaaa_aaaa,
            0xcccc_cccc_cccc_cccc,
            0xf0f0_f0f0_f0f0_f0f0,
            0xff00_ff00_ff00_ff00,
            0xffff_0000_ffff_0000,
            0xffff_ffff_0000_0000,
        ];
        if constraints.len > VARIABLES.len() {
            return true;
        }
        let mut free = constraints.len;
        self.signs.clear();
        for (s, &id) in cell.surfaces.iter().enumerate() {
            let own = constraints
                .as_slice()
                .iter()
                .position(|&c| usize::from(c) == s);
            let sign = match own {
                Some(k) => VARIABLES[k],
                None => {
                    let surface = &scene.surfaces[id as usize];
                    let value = surface.value(point);
                    let on_it = free < VARIABLES.len()
                        && value.abs() <= scene.tolerance * surface.gradient(point).length();
                    if on_it {
                        free += 1;
                        VARIABLES[free - 1]
                    } else if value <= 0.0 {
                        u64::MAX
                    } else {
                        0
                    }
                }
            };
            self.signs.push(sign);
        }
        let signs = &self.signs;
        let table = brick::evaluate_assignments(&cell.formula, &mut self.gates, |_, surface| {
            signs[surface as usize]
        });
        (0..constraints.len).all(|k| {
            let shifted = table >> (1 << k);
            (table ^ shifted) & !VARIABLES[k] & assignments(free) != 0
        })
    }

    /// Puts two vertices on every ambiguous face the brick owns, one on each
    /// arc, so that no two mesh edges join the same two loops.
    #[inline(always)]
    fn place_arcs(
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
    fn place_axis_arcs(
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
                vertex: part.vertices.len() as u32 - record.vertices,
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
                self.place_vertex(scene, cell, constraints, start, middle, part);
            }
        }
    }

    /// Moves the collected polygons to the part, grouped by surface and by
    /// the primitive that the surface belongs to there; the first of several
    /// if they differ in nothing that can be seen.
    fn collect_polygons(&mut self, scene: &Scene<'_>, cell: &Cell, part: &mut Part) {
        for s in 0..cell.surfaces.len() {
            let polygons = std::mem::take(&mut self.polygons[s]);
            if polygons.is_empty() {
                self.polygons[s] = polygons;
                continue;
            }
            let mut own = cell
                .formula
                .literals()
                .iter()
                .filter(|l| l.surface as usize == s);
            let first = own.next().map_or(0, |literal| literal.origin);
            let several = own.any(|literal| !scene.look_alike(literal.origin, first));
            let facing = polygons[0].is_reversed();
            if several || polygons.iter().any(|code| code.is_reversed() != facing) {
                let mut sorted: Vec<(u32, bool, PolygonCode)> = polygons
                    .iter()
                    .map(|&code| {
                        let origin = if several {
                            self.origin_at(cell, s as u32, code)
                        } else {
                            first
                        };
                        (origin, code.is_reversed(), code)
                    })
                    .collect();
                sorted.sort_by_key(|&(origin, reversed, _)| (origin, reversed));
                for run in sorted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
                    part.polygons.extend(run.iter().map(|&(.., code)| code));
                    part.groups.push(PolygonGroup {
                        surface: cell.surfaces[s],
                        origin: run[0].0,
                        reversed: run[0].1,
                        count: run.len() as u32,
                    });
                }
            } else {
                part.polygons.extend_from_slice(&polygons);
                part.groups.push(PolygonGroup {
                    surface: cell.surfaces[s],
                    origin: first,
                    reversed: facing,
                    count: polygons.len() as u32,
                });
            }
            self.polygons[s] = polygons;
        }
    }

    /// Of the primitives that share a surface, the first whose literal alone
    /// makes the solid change at a crossing; the first of all if none does.
    fn origin_at(&mut self, cell: &Cell, surface: u32, code: PolygonCode) -> u32 {
        let literals = cell.formula.literals();
        let own: Vec<u32> = (0..literals.len() as u32)
            .filter(|&i| literals[i as usize].surface == surface)
            .take(63)
            .collect();
        let signs = &self.classified.signs;
        let sample = code.sample();
        let result = brick::evaluate_assignments(&cell.formula, &mut self.gates, |i, s| {
            let inside = brick::is_set(&signs[s as usize], sample);
            let sign = if inside { u64::MAX } else { 0 };
            // Assignment k + 1 toggles the k-th literal alone.
            match own.iter().position(|&o| o == i) {
                Some(k) => sign ^ 1 << (k + 1),
                None => sign,
            }
        });
        let decides = |k: &usize| (result >> (k + 1) ^ result) & 1 == 1;
        let chosen = (0..own.len()).find(decides).unwrap_or(0);
        literals[own[chosen] as usize].origin
    }
}

/// The low 2^free bits.
const fn assignments(free: usize) -> u64 {
    if free >= 6 {
        u64::MAX
    } else {
        (1 << (1 << free)) - 1
    }
}

/// All sets with one constraint less.
fn shrink(sets: &[Constraints]) -> Option<Vec<Constraints>> {
    let smaller: Vec<Constraints> = sets
        .iter()
        .take(8)
        .flat_map(|set| (0..set.len).rev().map(|i| set.without(i)))
        .filter(|set| set.len > 0)
        .collect();
    (!smaller.is_empty()).then_some(smaller)
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

/// The root of f along an edge on which it changes sign, in units of the
/// edge, in closed form.
fn root_along(surface: &Surface, start: DVec3, axis: usize, step: f64) -> f64 {
    let f = surface.value(start);
    let b = surface.gradient(start)[axis] * step;
    let a = surface.quadratic[axis] * step * step;
    // Of a t² + b t + f = 0 the root in 0..1, without cancellation (Press et
    // al., *Numerical Recipes*, 5.6).
    let discriminant = (b * b - 4.0 * a * f).max(0.0);
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let misfit = |t: f64| {
        if t.is_finite() {
            (t - 0.5).abs()
        } else {
            f64::INFINITY
        }
    };
    let (first, second) = (q / a, f / q);
    let t = if misfit(second) <= misfit(first) {
        second
    } else {
        first
    };
    if t >= 0.0 { t.min(1.0) } else { 0.0 }
}
