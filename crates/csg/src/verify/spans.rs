//! The parts of rays in a program's solid: the roots of its surfaces, and the formula
//! between them, for 64 pieces at once.

use super::rays::{Lattice, Ray};
use crate::program::{Bounds, Program, Surface};

/// A part of a ray in the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    /// The ray's number.
    pub ray: u32,
    /// From where to where along it.
    pub ends: [f64; 2],
}

/// The parts of rays in a solid within bounds: disjoint, ray by ray, ascending.
pub(super) fn along(program: &Program, lattice: &Lattice, bounds: &Bounds) -> Vec<Span> {
    let mut tape = Tape::new(program);
    let mut events: Vec<(f64, u32)> = Vec::new();
    for (ray, line) in (0..).zip((0..lattice.len()).map(|number| lattice.ray(number))) {
        let (low, high) = (bounds.min[line.axis], bounds.max[line.axis]);
        events.clear();
        for (number, surface) in (0..).zip(program.surfaces()) {
            let (is_inside, roots) = changes(surface, &line);
            let before = roots.iter().filter(|&&t| t <= low).count();
            tape.set(number, is_inside != (before == 1));
            let within = roots.into_iter().filter(|&t| t > low && t < high);
            events.extend(within.map(|t| (t, number)));
        }
        events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = low;
        for &(at, surface) in &events {
            tape.add(ray, [from, at]);
            tape.change(surface);
            from = at;
        }
        tape.add(ray, [from, high]);
    }
    tape.finish()
}

/// Whether the far end of a ray, towards negative coordinates, is in a surface's
/// half-space, and where along it that changes.
fn changes(surface: &Surface, ray: &Ray) -> (bool, [f64; 2]) {
    const NOWHERE: [f64; 2] = [f64::INFINITY; 2];
    let about = surface.anchor()[ray.axis];
    let at = ray.at(about);
    let a = surface.quadratic[ray.axis];
    let (b, c) = (surface.gradient(at)[ray.axis], surface.value(at));
    match roots(a, b, c) {
        Some(roots) => {
            let far = if a == 0.0 { -b } else { a };
            (far < 0.0, roots.map(|root| about + root))
        }
        None if a == 0.0 => (c <= 0.0, NOWHERE),
        None => (a < 0.0, NOWHERE),
    }
}

/// The roots of a t² + b t + c, without cancellation: an infinite one where there is only
/// one, none where there are none or they are one.
pub(super) fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - 4.0 * a * c;
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    (discriminant > 0.0 && q != 0.0).then(|| {
        let far = if a == 0.0 { f64::INFINITY } else { q / a };
        [far.min(c / q), far.max(c / q)]
    })
}

/// Pieces of rays, a bit each of a word for every surface.
pub(super) struct Tape<'a> {
    program: &'a Program,
    words: Vec<u64>,
    /// At most 64.
    pieces: Vec<Span>,
    gates: Vec<u64>,
    found: Vec<Span>,
}

impl<'a> Tape<'a> {
    pub fn new(program: &'a Program) -> Self {
        Self {
            program,
            words: vec![0; program.surfaces().len()],
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
        let formula = self.program.formula();
        let words = &self.words;
        let inside = formula.evaluate_words(&mut self.gates, |_, surface| words[surface as usize]);
        for (bit, piece) in self.pieces.drain(..).enumerate() {
            if inside >> bit & 1 == 0 {
                continue;
            }
            match self.found.last_mut() {
                Some(last) if last.ray == piece.ray && last.ends[1] == piece.ends[0] => {
                    last.ends[1] = piece.ends[1];
                }
                _ => self.found.push(piece),
            }
        }
        for word in &mut self.words {
            *word = ((*word as i64) >> 63) as u64;
        }
    }
}
