//! What is left of a large formula in a small box, found from its root: in the time of what is
//! left and of the way to it, where [`Cell::prune_into`] takes that of the whole formula.

use rustc_hash::FxHashMap;

use super::cell::Cell;
use super::formula::{Formula, Gate, Literal, Operand, Operation};
use crate::surface::Side;

/// What a formula comes to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Narrowed {
    Constant(bool),
    /// There are surfaces left at which it is to be cut: that which is nearest to its root,
    /// and what is above the gates with these.
    Cut(u32, Crown),
    /// It was written to the cell.
    Varying,
}

/// The gates next to the root of what is left of a formula, whose operands below them are
/// those of the whole one. They are numbered after these.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crown {
    gates: Vec<Gate>,
    operands: Vec<Operand>,
    root: Operand,
}

impl Crown {
    /// Of a formula of which nothing is known yet.
    pub const fn of(formula: &Formula) -> Self {
        Self {
            gates: Vec::new(),
            operands: Vec::new(),
            root: formula.root,
        }
    }
}

/// A formula with a crown.
#[derive(Clone, Copy)]
struct View<'a> {
    formula: &'a Formula,
    crown: &'a Crown,
}

impl<'a> View<'a> {
    #[inline]
    fn gate(&self, gate: u32) -> (Operation, &'a [Operand]) {
        let own = self.formula.gates.len();
        let (gate, operands) = match (gate as usize).checked_sub(own) {
            None => (&self.formula.gates[gate as usize], &self.formula.operands),
            Some(gate) => (&self.crown.gates[gate], &self.crown.operands),
        };
        let operands = &operands[gate.start as usize..gate.end as usize];
        (gate.operation, operands)
    }
}

/// What a gate comes to.
#[derive(Clone, Copy, Debug)]
struct Value {
    operand: Operand,
    /// A surface at which it is to be cut before it is looked into.
    cut: Option<u32>,
    /// Whether it was found to be left.
    is_live: bool,
}

impl Value {
    const fn of(operand: Operand) -> Self {
        Self {
            operand,
            cut: None,
            is_live: false,
        }
    }
}

/// A gate whose operands are looked at.
struct Visit {
    gate: u32,
    /// The next one of its operands.
    next: u32,
    /// How many vary, and the last of them.
    kept: u32,
    only: Operand,
}

/// Scratch memory of [`Self::narrow`].
pub(crate) struct Narrower {
    values: FxHashMap<u32, Value>,
    visits: Vec<Visit>,
    /// Gates and literals that are left, ascending.
    gates: Vec<u32>,
    literals: Vec<u32>,
    pending: Vec<u32>,
    /// So many gates are looked at.
    most: usize,
}

impl Default for Narrower {
    fn default() -> Self {
        Self {
            values: FxHashMap::default(),
            visits: Vec::new(),
            gates: Vec::new(),
            literals: Vec::new(),
            pending: Vec::new(),
            most: usize::MAX,
        }
    }
}

/// What literals come to, by the sides of their surfaces.
fn literal(formula: &Formula, side: impl Fn(u32) -> Side) -> impl Fn(u32) -> Operand {
    move |i| {
        let literal = formula.literals[i as usize];
        match side(literal.surface) {
            Side::Inside => Operand::Constant(!literal.outside),
            Side::Outside => Operand::Constant(literal.outside),
            Side::Crossing => Operand::Literal(i),
        }
    }
}

impl Narrower {
    /// Shortens a formula over a program's surfaces, of which the crown is left in a box around
    /// this one, by the sides of the box that these are on, literal by literal. Gates with a
    /// literal of a surface at which the box is to be cut are not looked into.
    pub fn narrow(
        &mut self,
        formula: &Formula,
        crown: &Crown,
        side: impl Fn(u32) -> Side,
        is_cut: impl Fn(u32) -> bool,
        out: &mut Cell,
    ) -> Narrowed {
        let literal = literal(formula, side);
        let view = View { formula, crown };
        let root = match self.root(view, &literal, is_cut) {
            Some(Operand::Constant(value)) => return Narrowed::Constant(value),
            Some(root) => root,
            None => crown.root,
        };
        if let Some(cut) = self.find_live(view, root, &literal) {
            return Narrowed::Cut(cut, self.crown(view, root, &literal));
        }
        self.write(view, root, &literal, out);
        Narrowed::Varying
    }

    /// The same without cuts: as [`Cell::prune_by`], of whatever comes of it.
    pub fn prune(&mut self, formula: &Formula, side: impl Fn(u32) -> Side, out: &mut Cell) {
        let crown = Crown::of(formula);
        if let Narrowed::Constant(value) = self.narrow(formula, &crown, side, |_| false, out) {
            *out = Cell::default();
            out.formula.root = Operand::Constant(value);
        }
    }

    /// The constant that a formula comes to, if it does and so many gates tell.
    pub fn constant(
        &mut self,
        formula: &Formula,
        side: impl Fn(u32) -> Side,
        most: usize,
    ) -> Option<bool> {
        self.most = most;
        let crown = &Crown::of(formula);
        let root = self.root(View { formula, crown }, literal(formula, side), |_| false);
        self.most = usize::MAX;
        match root? {
            Operand::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// The value where every surface is on one side.
    pub fn evaluate(&mut self, formula: &Formula, is_inside: impl Fn(u32) -> bool) -> bool {
        let side = |surface| {
            if is_inside(surface) {
                Side::Inside
            } else {
                Side::Outside
            }
        };
        self.constant(formula, side, usize::MAX) == Some(true)
    }

    /// What the formula comes to; none if too many gates would have to be looked at.
    fn root(
        &mut self,
        view: View<'_>,
        literal: impl Fn(u32) -> Operand,
        is_cut: impl Fn(u32) -> bool,
    ) -> Option<Operand> {
        self.values.clear();
        match view.crown.root {
            Operand::Literal(i) => Some(literal(i)),
            Operand::Gate(gate) => {
                self.look_into(view, gate, literal, is_cut);
                self.values.get(&gate).map(|value| value.operand)
            }
            constant => Some(constant),
        }
    }

    /// Finds what a gate comes to, and those that this takes.
    fn look_into(
        &mut self,
        view: View<'_>,
        gate: u32,
        literal: impl Fn(u32) -> Operand,
        is_cut: impl Fn(u32) -> bool,
    ) {
        self.visits.clear();
        self.begin(view, gate, &literal, &is_cut);
        'visits: while let Some(mut visit) = self.visits.pop() {
            if self.values.len() > self.most {
                return;
            }
            let (operation, operands) = view.gate(visit.gate);
            let absorbing = operation.absorbing();
            for &operand in &operands[visit.next as usize..] {
                if let Operand::Gate(below) = operand {
                    let Some(value) = self.values.get(&below) else {
                        self.visits.push(visit);
                        self.begin(view, below, &literal, &is_cut);
                        continue 'visits;
                    };
                    match value.operand {
                        Operand::Constant(value) if value == absorbing => {
                            (visit.kept, visit.only) = (0, Operand::Constant(absorbing));
                            break;
                        }
                        Operand::Constant(_) => {}
                        varying => {
                            visit.kept += 1;
                            visit.only = varying;
                        }
                    }
                }
                visit.next += 1;
            }
            let operand = if visit.kept > 1 {
                Operand::Gate(visit.gate)
            } else {
                visit.only
            };
            self.values.insert(visit.gate, Value::of(operand));
        }
    }

    /// Looks at a gate's literals, and goes on with its gates only if these do not tell.
    fn begin(
        &mut self,
        view: View<'_>,
        gate: u32,
        literal: impl Fn(u32) -> Operand,
        is_cut: impl Fn(u32) -> bool,
    ) {
        let (operation, operands) = view.gate(gate);
        let absorbing = operation.absorbing();
        let (mut kept, mut only) = (0, Operand::Constant(!absorbing));
        let mut cut = None;
        for &operand in operands {
            let operand = match operand {
                Operand::Gate(_) => continue,
                Operand::Literal(i) => literal(i),
                constant => constant,
            };
            match operand {
                Operand::Constant(value) if value == absorbing => {
                    self.values.insert(gate, Value::of(operand));
                    return;
                }
                Operand::Literal(i) => {
                    let surface = view.formula.literals[i as usize].surface;
                    if cut.is_none() && is_cut(surface) {
                        cut = Some(surface);
                    }
                    kept += 1;
                    only = operand;
                }
                _ => {}
            }
        }
        if cut.is_some() {
            let value = Value::of(Operand::Gate(gate));
            self.values.insert(gate, Value { cut, ..value });
            return;
        }
        self.visits.push(Visit {
            gate,
            next: 0,
            kept,
            only,
        });
    }

    /// What an operand of a gate that was looked into comes to.
    #[inline]
    fn value(&self, operand: Operand, literal: impl Fn(u32) -> Operand) -> Operand {
        match operand {
            Operand::Literal(i) => literal(i),
            Operand::Gate(below) => self.values[&below].operand,
            constant @ Operand::Constant(_) => constant,
        }
    }

    /// Finds the gates and literals that are left, or the cut nearest to the root.
    fn find_live(
        &mut self,
        view: View<'_>,
        root: Operand,
        literal: impl Fn(u32) -> Operand,
    ) -> Option<u32> {
        self.gates.clear();
        self.literals.clear();
        self.pending.clear();
        let mut nearest: Option<(u32, u32)> = None;
        match root {
            Operand::Gate(gate) => self.pending.push(gate),
            Operand::Literal(i) => self.literals.push(i),
            Operand::Constant(_) => {}
        }
        while let Some(gate) = self.pending.pop() {
            let Some(value) = self.values.get_mut(&gate) else {
                continue;
            };
            if std::mem::replace(&mut value.is_live, true) {
                continue;
            }
            if let Some(cut) = value.cut {
                nearest = nearest.max(Some((gate, cut)));
                continue;
            }
            self.gates.push(gate);
            let (_, operands) = view.gate(gate);
            for &operand in operands {
                match self.value(operand, &literal) {
                    Operand::Literal(i) => self.literals.push(i),
                    Operand::Gate(below) => self.pending.push(below),
                    Operand::Constant(_) => {}
                }
            }
        }
        self.gates.sort_unstable();
        nearest.map(|(_, cut)| cut)
    }

    /// The gates that are left above those that were not looked into.
    fn crown(&self, view: View<'_>, root: Operand, literal: impl Fn(u32) -> Operand) -> Crown {
        let first = view.formula.gates.len() as u32;
        let renumbered = |operand| match operand {
            Operand::Gate(gate) => {
                let place = self.gates.binary_search(&gate);
                Operand::Gate(place.map_or(gate, |place| first + place as u32))
            }
            other => other,
        };
        let mut crown = Crown {
            gates: Vec::with_capacity(self.gates.len()),
            operands: Vec::new(),
            root: renumbered(root),
        };
        for &gate in &self.gates {
            let (operation, operands) = view.gate(gate);
            let start = crown.operands.len() as u32;
            let operands = operands
                .iter()
                .map(|&operand| self.value(operand, &literal));
            let varying = operands.filter(|operand| !matches!(operand, Operand::Constant(_)));
            crown.operands.extend(varying.map(renumbered));
            crown.gates.push(Gate {
                operation,
                start,
                end: crown.operands.len() as u32,
            });
        }
        crown
    }

    /// Writes what is left, in the order of the whole formula.
    fn write(
        &mut self,
        view: View<'_>,
        root: Operand,
        literal: impl Fn(u32) -> Operand,
        out: &mut Cell,
    ) {
        self.literals.sort_unstable();
        self.literals.dedup();
        let surface_of = |i: &u32| view.formula.literals[*i as usize].surface;
        let place = |list: &[u32], item: u32| {
            let place = list.partition_point(|&other| other < item);
            place as u32
        };
        let Cell {
            surfaces,
            formula: written,
        } = out;
        surfaces.clear();
        surfaces.extend(self.literals.iter().map(surface_of));
        surfaces.sort_unstable();
        surfaces.dedup();
        written.literals.clear();
        written
            .literals
            .extend(self.literals.iter().map(|i| Literal {
                surface: place(surfaces, surface_of(i)),
                ..view.formula.literals[*i as usize]
            }));
        let renumbered = |operand| match operand {
            Operand::Constant(_) => operand,
            Operand::Literal(i) => Operand::Literal(place(&self.literals, i)),
            Operand::Gate(i) => Operand::Gate(place(&self.gates, i)),
        };
        written.gates.clear();
        written.operands.clear();
        for &gate in &self.gates {
            let (operation, operands) = view.gate(gate);
            let start = written.operands.len() as u32;
            for &operand in operands {
                let operand = self.value(operand, &literal);
                if !matches!(operand, Operand::Constant(_)) {
                    written.operands.push(renumbered(operand));
                }
            }
            written.gates.push(Gate {
                operation,
                start,
                end: written.operands.len() as u32,
            });
        }
        written.root = renumbered(root);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Pruner;
    use crate::random::Random;

    /// A formula of gates of some earlier ones and literals of so many surfaces.
    fn random(random: &mut Random, surfaces: u32) -> Formula {
        let mut formula = Formula::default();
        let mut below = |most: u32| (random.unit() * f64::from(most)) as u32;
        for _ in 0..2 * surfaces {
            formula.literals.push(Literal {
                surface: below(surfaces),
                origin: 0,
                outside: below(2) == 1,
            });
        }
        for gate in 0..1 + below(24) {
            let start = formula.operands.len() as u32;
            for _ in 0..2 + below(3) {
                formula.operands.push(if gate > 0 && below(3) > 0 {
                    Operand::Gate(gate - 1 - below(gate.min(4)))
                } else {
                    Operand::Literal(below(2 * surfaces))
                });
            }
            formula.gates.push(Gate {
                operation: [Operation::And, Operation::Or][below(2) as usize],
                start,
                end: formula.operands.len() as u32,
            });
        }
        formula.root = Operand::Gate(formula.gates.len() as u32 - 1);
        formula
    }

    #[test]
    fn what_is_left_is_what_pruning_leaves() {
        let mut seeds = Random(5);
        let mut narrower = Narrower::default();
        let mut pruner = Pruner::literal_by_literal();
        let (mut constant, mut varying, mut cuts) = (0, 0, 0);
        for _ in 0..3000 {
            let surfaces = 12;
            let formula = random(&mut seeds, surfaces);
            let sides = [Side::Inside, Side::Outside, Side::Crossing, Side::Crossing];
            let sides: Vec<Side> = (0..surfaces)
                .map(|_| sides[(4.0 * seeds.unit()) as usize])
                .collect();
            let whole = Cell {
                surfaces: (0..surfaces).collect(),
                formula,
            };
            let (mut pruned, mut narrowed) = (Cell::default(), Cell::default());
            whole.restrict_into(&sides, &mut pruner, &mut pruned);
            let side = |surface: u32| sides[surface as usize];
            let crown = Crown::of(&whole.formula);
            let found = narrower.narrow(&whole.formula, &crown, side, |_| false, &mut narrowed);
            match pruned.constant() {
                Some(value) => {
                    assert_eq!(found, Narrowed::Constant(value));
                    constant += 1;
                }
                None => {
                    assert_eq!(found, Narrowed::Varying);
                    assert_eq!(narrowed.surfaces, pruned.surfaces);
                    assert_eq!(narrowed.formula, pruned.formula);
                    varying += 1;
                }
            }
            let inside = sides.iter().map(|&side| side == Side::Inside);
            let inside: Vec<bool> = inside.collect();
            let value = narrower.evaluate(&whole.formula, |surface| inside[surface as usize]);
            assert_eq!(value, whole.formula.evaluate(&inside));
            // A cut that is told is left, and none is told only where none is. Where all are
            // on one side, the crown tells as much as the whole formula.
            let is_cut = |surface: u32| surface < 3;
            let cut = narrower.narrow(&whole.formula, &crown, side, is_cut, &mut narrowed);
            let Narrowed::Cut(cut, crown) = cut else {
                assert_eq!(cut, found);
                continue;
            };
            assert!(is_cut(cut) && side(cut) == Side::Crossing);
            cuts += 1;
            let decided = |surface: u32| match side(surface) {
                Side::Crossing if is_cut(surface) => Side::Inside,
                side => side,
            };
            let known: Vec<Side> = (0..surfaces).map(decided).collect();
            whole.restrict_into(&known, &mut pruner, &mut pruned);
            let below = narrower.narrow(&whole.formula, &crown, decided, is_cut, &mut narrowed);
            match pruned.constant() {
                Some(value) => assert_eq!(below, Narrowed::Constant(value)),
                None => {
                    assert_eq!(below, Narrowed::Varying);
                    assert_eq!(narrowed.surfaces, pruned.surfaces);
                    assert_eq!(narrowed.formula.literals, pruned.formula.literals);
                    for assignment in 0..1 << narrowed.surfaces.len() {
                        let is_inside = |k: usize| assignment >> k & 1 == 1;
                        let inside: Vec<bool> =
                            (0..narrowed.surfaces.len()).map(is_inside).collect();
                        let values = [&narrowed, &pruned].map(|c| c.formula.evaluate(&inside));
                        assert_eq!(values[0], values[1]);
                    }
                }
            }
        }
        assert!(constant > 500 && varying > 500 && cuts > 500);
    }
}
