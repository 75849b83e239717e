//! The parts of rays in a program's solid: the roots of its surfaces, and the formula
//! between them, for 64 pieces at once.

use super::rays::{Lattice, Ray};
use crate::program::{
    Bounds, Cell, Formula, Named, Narrower, Program, Pruner, Surface, line_roots,
};

/// A part of a ray in the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    /// The ray's number.
    pub ray: u32,
    /// From where to where along it.
    pub ends: [f64; 2],
}

/// Of programs with more surfaces only those near each piece of a ray are looked at. Tunes
/// speed only.
const MANY_SURFACES: usize = 1000;
/// So few are near enough.
const FEW_SURFACES: usize = 48;
/// A ray is halved no more often.
const MOST_HALVINGS: u32 = 30;

/// The parts of rays in a solid within bounds: disjoint, ray by ray, ascending.
pub(super) fn along(program: &Program, lattice: &Lattice, bounds: &Bounds) -> Vec<Span> {
    let rays = (0..).zip((0..lattice.len()).map(|number| lattice.ray(number)));
    let ends = |line: &Ray| [bounds.min[line.axis], bounds.max[line.axis]];
    if let Some(outline) = program.outline() {
        let cell = outline.cell();
        let mut tape = Tape::new(&cell.formula, cell.surfaces.len());
        for (ray, line) in rays {
            let crossings = outline.shells().along_line(line.axis, line.through);
            let changes = |name: u32, tell: &mut dyn FnMut(f64)| match outline.named(name) {
                Named::Surface(surface) => surface_changes(&surface, &line, tell),
                Named::Region(region) => {
                    let first = crossings.partition_point(|crossing| crossing.shell < region);
                    let own = crossings[first..].iter();
                    let own = own.take_while(|crossing| crossing.shell == region);
                    own.for_each(|crossing| tell(crossing.at));
                    false
                }
            };
            tape.add_all(&cell.surfaces, ray, ends(&line), changes);
        }
        return tape.finish();
    }
    if program.given().is_none() {
        let root = program.root_cell();
        if root.surfaces.len() <= MANY_SURFACES {
            let mut tape = Tape::new(&root.formula, root.surfaces.len());
            for (ray, line) in rays {
                tape.add_surfaces(&root, program.surfaces(), (ray, &line), ends(&line));
            }
            return tape.finish();
        }
        let mut walk = Walk::new(program.surfaces());
        for (ray, line) in rays {
            walk.descend(&root, (ray, &line), ends(&line), 0);
        }
        return walk.found;
    }
    let mut walk = Walk::new(program.surfaces());
    let mut narrower = Narrower::default();
    let mut cell = Cell::default();
    for (ray, line) in rays {
        let (center, half) = line.part(ends(&line));
        let side = |id: u32| program.surfaces()[id as usize].side_of_box(center, half);
        narrower.prune(program.formula(), side, &mut cell);
        walk.descend(&cell, (ray, &line), ends(&line), 0);
    }
    walk.found
}

/// A walk along rays.
struct Walk<'a> {
    surfaces: &'a [Surface],
    pruner: Pruner,
    found: Vec<Span>,
}

impl<'a> Walk<'a> {
    fn new(surfaces: &'a [Surface]) -> Self {
        Self {
            surfaces,
            pruner: Pruner::default(),
            found: Vec::new(),
        }
    }

    fn descend(&mut self, cell: &Cell, line: (u32, &Ray), ends: [f64; 2], halvings: u32) {
        let [low, high] = ends;
        let middle = low.midpoint(high);
        let (center, half) = line.1.part(ends);
        let mut pruned = Cell::default();
        cell.prune_into(self.surfaces, center, half, &mut self.pruner, &mut pruned);
        match pruned.constant() {
            Some(false) => {}
            Some(true) => join(&mut self.found, Span { ray: line.0, ends }),
            None if pruned.surfaces.len() <= FEW_SURFACES || halvings == MOST_HALVINGS => {
                let mut tape = Tape::new(&pruned.formula, pruned.surfaces.len());
                tape.add_surfaces(&pruned, self.surfaces, line, ends);
                for span in tape.finish() {
                    join(&mut self.found, span);
                }
            }
            None => {
                self.descend(&pruned, line, [low, middle], halvings + 1);
                self.descend(&pruned, line, [middle, high], halvings + 1);
            }
        }
    }
}

/// Adds a part of a ray, or makes it one with the last.
fn join(found: &mut Vec<Span>, span: Span) {
    match found.last_mut() {
        Some(last) if last.ray == span.ray && last.ends[1] == span.ends[0] => {
            last.ends[1] = span.ends[1];
        }
        _ => found.push(span),
    }
}

/// Whether the far end of a ray, towards negative coordinates, is in a surface's
/// half-space, and where along it that changes.
fn changes(surface: &Surface, ray: &Ray) -> (bool, [f64; 2]) {
    const NOWHERE: [f64; 2] = [f64::INFINITY; 2];
    let about = surface.anchor()[ray.axis];
    let at = ray.at(about);
    let a = surface.quadratic[ray.axis];
    let (b, c) = (surface.gradient(at)[ray.axis], surface.value(at));
    match line_roots(a, b, c) {
        Some(roots) => {
            let far = if a == 0.0 { -b } else { a };
            (far < 0.0, roots.map(|root| about + root))
        }
        None if a == 0.0 => (c <= 0.0, NOWHERE),
        None => (a < 0.0, NOWHERE),
    }
}

/// Tells where a ray crosses a surface; whether its far end is inside.
fn surface_changes(surface: &Surface, ray: &Ray, tell: &mut dyn FnMut(f64)) -> bool {
    let (is_inside, roots) = changes(surface, ray);
    roots.into_iter().for_each(tell);
    is_inside
}

/// Pieces of rays, a bit each of a word for every surface.
pub(super) struct Tape<'a> {
    formula: &'a Formula,
    words: Vec<u64>,
    /// At most 64.
    pieces: Vec<Span>,
    gates: Vec<u64>,
    found: Vec<Span>,
}

impl<'a> Tape<'a> {
    /// Of a formula over so many surfaces.
    pub fn new(formula: &'a Formula, surfaces: usize) -> Self {
        Self {
            formula,
            words: vec![0; surfaces],
            pieces: Vec::with_capacity(64),
            gates: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Begins the next piece inside or outside a surface, and those after it.
    pub fn set(&mut self, surface: u32, is_inside: bool) {
        let from = u64::MAX << self.pieces.len();
        let word = &mut self.words[surface as usize];
        *word = if is_inside {
            *word | from
        } else {
            *word & !from
        };
    }

    /// Begins the next piece on the other side of a surface.
    fn change(&mut self, surface: u32) {
        self.words[surface as usize] ^= u64::MAX << self.pieces.len();
    }

    /// Adds the pieces between all surfaces of a cell along a ray.
    fn add_surfaces(
        &mut self,
        cell: &Cell,
        surfaces: &[Surface],
        (ray, line): (u32, &Ray),
        ends: [f64; 2],
    ) {
        self.add_all(&cell.surfaces, ray, ends, |id, tell| {
            surface_changes(&surfaces[id as usize], line, tell)
        });
    }

    /// Adds the pieces between all that is named along a ray: of each it is told where it
    /// changes, and whether the far end is inside.
    fn add_all(
        &mut self,
        names: &[u32],
        ray: u32,
        [low, high]: [f64; 2],
        changes: impl Fn(u32, &mut dyn FnMut(f64)) -> bool,
    ) {
        let mut events: Vec<(f64, u32)> = Vec::new();
        for (position, &name) in (0..).zip(names) {
            let mut changed = false;
            let is_inside = changes(name, &mut |at| {
                changed ^= at <= low;
                if at > low && at < high {
                    events.push((at, position));
                }
            });
            self.set(position, is_inside != changed);
        }
        events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = low;
        for &(at, position) in &events {
            self.add(ray, [from, at]);
            self.change(position);
            from = at;
        }
        self.add(ray, [from, high]);
    }

    pub fn add(&mut self, ray: u32, ends: [f64; 2]) {
        if ends[0] < ends[1] {
            self.pieces.push(Span { ray, ends });
            if self.pieces.len() == 64 {
                self.evaluate();
            }
        }
    }

    /// The pieces in the solid, those that follow on each other made one.
    pub fn finish(mut self) -> Vec<Span> {
        self.evaluate();
        self.found
    }

    /// Tells which pieces are in the solid, and goes on where the last one ends.
    fn evaluate(&mut self) {
        let words = &self.words;
        let inside = self
            .formula
            .evaluate_words(&mut self.gates, |_, surface| words[surface as usize]);
        for (bit, piece) in self.pieces.drain(..).enumerate() {
            if inside >> bit & 1 == 0 {
                continue;
            }
            join(&mut self.found, piece);
        }
        for word in &mut self.words {
            *word = ((*word as i64) >> 63) as u64;
        }
    }
}
