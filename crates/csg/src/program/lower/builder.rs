//! The formula under construction: every gate simplified as it is made, so that
//! coincident faces cancel and what is said twice is said once.

use rustc_hash::FxHashSet;

use crate::error::Error;
use crate::program::Origin;
use crate::program::formula::{Formula, Gate, Literal, Operand, Operation};
use crate::program::unify::SurfaceTable;

/// Indices keep the two highest bits free.
const MOST: usize = 1 << 30;

/// The program under construction.
#[derive(Default)]
pub(super) struct Builder {
    pub formula: Formula,
    pub origins: Vec<Origin>,
    pub table: SurfaceTable,
    /// A hash of what each gate says, and of what its complement would.
    meanings: Vec<Meaning>,
    /// When each half-space (2 surface + outside) was last an operand.
    stamps: Vec<u32>,
    epoch: u32,
    gate_meanings: FxHashSet<u128>,
}

/// What an operand says about surfaces, hashed: equal for equal operands in
/// any order, whatever primitives they come from. 128 bits keep accidental
/// equality out of reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Meaning {
    own: u128,
    complement: u128,
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): every bit of a number
/// changes half of those of the result.
pub(crate) fn avalanche(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A mixing function with full avalanche: two rounds on independent streams.
fn mix(value: u128, salt: u64) -> u128 {
    let (high, low) = ((value >> 64) as u64, value as u64);
    let a = avalanche(
        low.wrapping_add(salt)
            .wrapping_add(avalanche(high ^ 0x9e37_79b9_7f4a_7c15)),
    );
    let b = avalanche(a ^ high.rotate_left(17) ^ low.wrapping_mul(0xd6e8_feb8_6659_fd93));
    u128::from(a) << 64 | u128::from(b)
}

impl Builder {
    pub fn literal(&mut self, literal: Literal) -> Result<Operand, Error> {
        let index = self.formula.literals.len();
        if index >= MOST {
            return Err(Error::TooLarge {
                what: "literals in the model",
                limit: MOST as u64,
            });
        }
        self.formula.literals.push(literal);
        let needed = 2 * (literal.surface as usize + 1);
        if self.stamps.len() < needed {
            self.stamps.resize(needed.max(2 * self.table.len()), 0);
        }
        Ok(Operand::Literal(index as u32))
    }

    fn meaning(&self, operand: Operand) -> Meaning {
        match operand {
            Operand::Constant(value) => Meaning {
                own: u128::from(value),
                complement: u128::from(!value),
            },
            Operand::Literal(i) => {
                let literal = self.formula.literals[i as usize];
                let key = u128::from(literal.surface) << 1 | u128::from(literal.outside);
                Meaning {
                    own: mix(key, 1),
                    complement: mix(key ^ 1, 1),
                }
            }
            Operand::Gate(i) => self.meanings[i as usize],
        }
    }

    /// Marks a half-space or gate as an operand of the current list; false if
    /// an equal one already is.
    fn mark(&mut self, operand: Operand) -> bool {
        match operand {
            Operand::Literal(i) => {
                let slot = self.slot(i);
                std::mem::replace(&mut self.stamps[slot], self.epoch) != self.epoch
            }
            _ => self.gate_meanings.insert(self.meaning(operand).own),
        }
    }

    fn slot(&self, literal: u32) -> usize {
        let literal = self.formula.literals[literal as usize];
        2 * literal.surface as usize + usize::from(literal.outside)
    }

    fn is_marked(&self, operand: Operand) -> bool {
        match operand {
            Operand::Literal(i) => self.stamps[self.slot(i)] == self.epoch,
            _ => self.gate_meanings.contains(&self.meaning(operand).own),
        }
    }

    fn complement_is_marked(&self, operand: Operand) -> bool {
        match operand {
            Operand::Literal(i) => self.stamps[self.slot(i) ^ 1] == self.epoch,
            _ => self
                .gate_meanings
                .contains(&self.meaning(operand).complement),
        }
    }

    /// The value of an operation, simplified: constants, repeated operands
    /// and complementary ones (S and not-S), and within operands of the other
    /// kind whatever the operands beside them already decide.
    pub fn combine(
        &mut self,
        operation: Operation,
        mut values: Vec<Operand>,
    ) -> Result<Operand, Error> {
        // Each round may decide something for the next. Stopping early costs
        // a few gates, never correctness, and bounds the time.
        const ROUNDS: usize = 8;
        for _ in 0..ROUNDS {
            let Some(shortened) = self.simplify(operation, &mut values)? else {
                return Ok(Operand::Constant(operation.absorbing()));
            };
            if !shortened {
                break;
            }
        }
        self.gate(operation, &values)
    }

    /// One round of [`Self::combine`]: `None` if the result is decided, else
    /// whether an operand was shortened and another round may find more.
    fn simplify(
        &mut self,
        operation: Operation,
        values: &mut Vec<Operand>,
    ) -> Result<Option<bool>, Error> {
        let absorbing = operation.absorbing();
        self.epoch += 1;
        self.gate_meanings.clear();
        let mut kept = Vec::with_capacity(values.len());
        for &value in &*values {
            match value {
                Operand::Constant(value) if value == absorbing => return Ok(None),
                Operand::Constant(_) => {}
                value if self.mark(value) => {
                    if self.complement_is_marked(value) {
                        return Ok(None);
                    }
                    kept.push(value);
                }
                _ => {}
            }
        }
        values.clear();
        let mut shortened = Vec::new();
        for value in kept {
            let Operand::Gate(gate) = value else {
                values.push(value);
                continue;
            };
            let gate = self.formula.gates[gate as usize];
            if gate.operation == operation {
                values.push(value);
                continue;
            }
            let operands = self.formula.operands_of(&gate);
            if operands.iter().any(|&operand| self.is_marked(operand)) {
                // x & (x | y) is x.
                continue;
            }
            let undecided = |&&operand: &&Operand| !self.complement_is_marked(operand);
            let rest: Vec<Operand> = operands.iter().filter(undecided).copied().collect();
            if rest.is_empty() {
                return Ok(None);
            }
            if rest.len() == operands.len() {
                values.push(value);
            } else {
                shortened.push(rest);
            }
        }
        let any = !shortened.is_empty();
        for rest in shortened {
            let value = self.gate(operation.dual(), &rest)?;
            values.push(value);
        }
        Ok(Some(any))
    }

    /// A gate over operands that need no more simplifying.
    pub fn gate(&mut self, operation: Operation, operands: &[Operand]) -> Result<Operand, Error> {
        match operands {
            [] => return Ok(Operand::Constant(!operation.absorbing())),
            &[only] => return Ok(only),
            _ => {}
        }
        let start = self.formula.operands.len();
        if start + operands.len() >= MOST {
            return Err(Error::TooLarge {
                what: "operands in the model",
                limit: MOST as u64,
            });
        }
        let mut sum = Meaning {
            own: 0,
            complement: 0,
        };
        for &operand in operands {
            let meaning = self.meaning(operand);
            sum.own = sum.own.wrapping_add(mix(meaning.own, 2));
            sum.complement = sum.complement.wrapping_add(mix(meaning.complement, 2));
        }
        let salts = match operation {
            Operation::And => (3, 4),
            Operation::Or => (4, 3),
        };
        self.meanings.push(Meaning {
            own: mix(sum.own, salts.0),
            complement: mix(sum.complement, salts.1),
        });
        self.formula.operands.extend_from_slice(operands);
        self.formula.gates.push(Gate {
            operation,
            start: start as u32,
            end: self.formula.operands.len() as u32,
        });
        Ok(Operand::Gate((self.formula.gates.len() - 1) as u32))
    }
}

/// A formula some of whose literals have come to name other surfaces, with what they are in
/// simplified anew.
pub(crate) fn simplified(formula: &Formula, is_changed: &[bool]) -> Result<Formula, Error> {
    let mut builder = Builder::default();
    builder.formula.literals.reserve(formula.literals.len());
    builder.formula.operands.reserve(formula.operands.len());
    builder.formula.gates.reserve(formula.gates.len());
    builder.meanings.reserve(formula.gates.len());
    for &literal in &formula.literals {
        builder.literal(literal)?;
    }
    // Of each gate, and whether it may have changed.
    let mut values: Vec<(Operand, bool)> = Vec::with_capacity(formula.gates.len());
    let value = |operand: Operand, values: &[(Operand, bool)]| match operand {
        Operand::Gate(gate) => values[gate as usize],
        Operand::Literal(literal) => (operand, is_changed[literal as usize]),
        constant @ Operand::Constant(_) => (constant, false),
    };
    let mut operands = Vec::new();
    for gate in &formula.gates {
        operands.clear();
        let mut changes = false;
        for &operand in formula.operands_of(gate) {
            let (operand, is_changed) = value(operand, &values);
            operands.push(operand);
            changes |= is_changed;
        }
        let operand = if changes {
            builder.combine(gate.operation, operands.clone())?
        } else {
            builder.gate(gate.operation, &operands)?
        };
        values.push((operand, changes));
    }
    builder.formula.root = value(formula.root, &values).0;
    Ok(compact(&builder.formula))
}

/// The formula without literals and gates that nothing uses.
pub(super) fn compact(formula: &Formula) -> Formula {
    const UNUSED: u32 = u32::MAX;
    let mut gate_index = vec![UNUSED; formula.gates.len()];
    let mut literal_index = vec![UNUSED; formula.literals.len()];
    let mut mark = |operand, gate_index: &mut [u32]| match operand {
        Operand::Constant(_) => {}
        Operand::Literal(i) => literal_index[i as usize] = 0,
        Operand::Gate(i) => gate_index[i as usize] = 0,
    };
    mark(formula.root, &mut gate_index);
    for (i, gate) in formula.gates.iter().enumerate().rev() {
        if gate_index[i] != UNUSED {
            for &operand in formula.operands_of(gate) {
                mark(operand, &mut gate_index);
            }
        }
    }
    let mut compacted = Formula::default();
    for (index, &literal) in literal_index.iter_mut().zip(&formula.literals) {
        if *index != UNUSED {
            *index = push_index(&mut compacted.literals, literal);
        }
    }
    let renumber = |operand, gate_index: &[u32]| match operand {
        Operand::Constant(_) => operand,
        Operand::Literal(i) => Operand::Literal(literal_index[i as usize]),
        Operand::Gate(i) => Operand::Gate(gate_index[i as usize]),
    };
    for (i, gate) in formula.gates.iter().enumerate() {
        if gate_index[i] == UNUSED {
            continue;
        }
        let start = compacted.operands.len() as u32;
        for &operand in formula.operands_of(gate) {
            let operand = renumber(operand, &gate_index);
            compacted.operands.push(operand);
        }
        gate_index[i] = push_index(
            &mut compacted.gates,
            Gate {
                operation: gate.operation,
                start,
                end: compacted.operands.len() as u32,
            },
        );
    }
    compacted.root = renumber(formula.root, &gate_index);
    compacted
}

/// Appends an item, and tells where it stands.
pub(super) fn push_index<T>(list: &mut Vec<T>, item: T) -> u32 {
    list.push(item);
    (list.len() - 1) as u32
}
