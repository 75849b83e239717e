//! From a classified brick to vertices: which surface causes each crossing,
//! which crossings form a vertex, and where it lies.

mod causes;
mod cells;
mod constraints;
mod polygons;
#[cfg(test)]
mod reference_tests;
mod unseen;
mod vertices;

use glam::{DVec3, UVec3};
use pulp::Simd;

use self::constraints::{Candidate, Constraints};
use super::brick::{self, Classified, List, Mask, Samples, WORDS};
use super::lattice::{CELLS, SAMPLES};
use super::part::{Part, PolygonCode};
use super::scene::Scene;
use super::validity;
use crate::program::{Cell, Changes};

const EDGES: usize = SAMPLES * SAMPLES * SAMPLES;

/// Scratch memory of one worker, reused from brick to brick.
pub(super) struct Placer {
    classified: Classified,
    samples: Samples,
    /// Per surface: where it changes sign along x, y, z, and which cells it
    /// crosses as far as their corners tell.
    changes: Vec<[Mask; 4]>,
    /// Per axis and lower sample: the surface that causes the crossing.
    cause: [Box<[u16; EDGES]>; 3],
    /// Edges with several transitions that are one point in truth (axis << 12
    /// | lower sample), and the surfaces that meet there.
    crowded: Vec<(u16, Constraints)>,
    /// Where the surfaces cross one edge.
    roots: Vec<(f64, u16)>,
    /// The polygons of one surface.
    polygons: Vec<PolygonCode>,
    /// The polygons on whose edges several surfaces change sign.
    contested: Vec<(u16, PolygonCode)>,
    /// Starting points, then vertices, of the simple cells of one surface.
    x: Box<[f64; EDGES]>,
    y: Box<[f64; EDGES]>,
    z: Box<[f64; EDGES]>,
    /// The samples of a mask, one by one.
    list: Box<List>,
    crossings: Option<Box<Crossings>>,
    /// Whether one surface alone crosses the brick: it causes everything.
    one_surface: bool,
    gates: Vec<u64>,
    truth: Changes,
    slow: Vec<u16>,
    complex: Vec<(u16, u8)>,
    /// Whether any surface of the brick has an apex.
    has_apexes: bool,
    /// The cells that are to have an apex as a vertex.
    apexes: Vec<(u16, DVec3)>,
    candidates: Vec<Candidate>,
    /// Candidates that the fast search found no place for.
    pending: Vec<usize>,
    tests: validity::Tests,
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
            crowded: Vec::new(),
            roots: Vec::new(),
            polygons: Vec::new(),
            contested: Vec::new(),
            x: Box::new([0.0; EDGES]),
            y: Box::new([0.0; EDGES]),
            z: Box::new([0.0; EDGES]),
            list: Box::new([0; EDGES + 4]),
            crossings: None,
            one_surface: false,
            gates: Vec::new(),
            truth: Changes::default(),
            slow: Vec::new(),
            complex: Vec::new(),
            has_apexes: false,
            apexes: Vec::new(),
            candidates: Vec::new(),
            pending: Vec::new(),
            tests: validity::Tests::default(),
        }
    }
}

/// Where the solid, and more than one surface at once, changes sign.
struct Crossings {
    /// Along x, y, z, and per cell.
    solid: [Mask; 4],
    several: [Mask; 4],
}

impl Default for Crossings {
    fn default() -> Self {
        Self {
            solid: [[0; WORDS]; 4],
            several: [[0; WORDS]; 4],
        }
    }
}

impl Placer {
    /// Processes one brick: appends its vertices and polygons to `part`.
    #[inline(always)]
    pub fn brick<S: Simd>(
        &mut self,
        simd: S,
        scene: &Scene<'_>,
        cell: &Cell,
        position: UVec3,
        part: &mut Part,
    ) {
        let lattice = &scene.lattice;
        let first = position * CELLS as u32;
        for i in 0..SAMPLES {
            self.samples.x[i] = lattice.coordinate(0, first.x + i as u32);
            self.samples.y[i] = lattice.coordinate(1, first.y + i as u32);
            self.samples.z[i] = lattice.coordinate(2, first.z + i as u32);
        }
        part.bricks_sampled += 1;
        self.classified.classify(cell, scene.table(), &self.samples);
        let inside = self.classified.solid[0] & 1 == 1;
        let constant = if inside { u64::MAX } else { 0 };
        if self.classified.solid.iter().all(|&word| word == constant) {
            self.report_unseen(scene, cell, false, part);
            return;
        }
        let mut crossings = self.crossings.take().unwrap_or_default();
        self.one_surface = cell.surfaces.len() == 1;
        self.find_crossings(cell.surfaces.len(), &mut crossings);
        let record = part.open_brick(position);
        self.place_simple(simd, scene, cell, &crossings, part);
        self.find_causes(scene, cell, &crossings, part);
        self.place_slow(scene, cell, &record, part);
        self.place_arcs(scene, cell, &crossings, &record, part);
        self.settle(scene, cell, part);
        self.report_unseen(scene, cell, true, part);
        part.close_brick(record);
        self.crossings = Some(crossings);
    }

    #[inline(always)]
    fn find_crossings(&mut self, surfaces: usize, crossings: &mut Crossings) {
        brick::changes(&self.classified.solid, &mut crossings.solid);
        if surfaces == 1 {
            return;
        }
        self.changes.resize(surfaces, [[0; WORDS]; 4]);
        let mut any = [[0u64; WORDS]; 4];
        crossings.several = [[0; WORDS]; 4];
        for (signs, changes) in self.classified.signs.iter().zip(&mut self.changes) {
            brick::changes(signs, changes);
            for ((any, several), changes) in
                any.iter_mut().zip(&mut crossings.several).zip(&*changes)
            {
                for ((any, several), &changes) in any.iter_mut().zip(several).zip(changes) {
                    *several |= *any & changes;
                    *any |= changes;
                }
            }
        }
    }

    /// Where the solid changes and one surface only, the given one. `which`
    /// is x, y, z or the cells.
    #[inline(always)]
    fn sole_changes(&self, crossings: &Crossings, s: usize, which: usize) -> Mask {
        let mut sole = crossings.solid[which];
        if !self.one_surface {
            let (changes, several) = (&self.changes[s][which], &crossings.several[which]);
            for ((sole, changes), several) in sole.iter_mut().zip(changes).zip(several) {
                *sole &= changes & !several;
            }
        }
        sole
    }
}
