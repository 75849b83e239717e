//! Lowering: from a tree of transformed primitives to surfaces and a formula.
//!
//! One iterative walk carries the accumulated map, name, colour and polarity
//! downwards (negation is pushed to the literals, so a difference is an
//! intersection whose later operands are walked negated) and values upwards.
//! Nested operations of one kind are flattened on the way: their values are
//! left on the value stack for the operation above. Subtrees that occur more
//! than once are remembered per map, name, colour and polarity.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::formula::{Formula, Gate, Literal, Operand, Operation};
use super::local::{LocalShape, half_spaces};
use super::unify::{SurfaceTable, WorldMap};
use super::{Origin, Program};
use crate::color::Color;
use crate::error::{Error, NodeFault, NodePath, PathStep};
use crate::solid::{Node, Primitive, Solid};

/// Indices keep the two highest bits free.
const MOST: usize = 1 << 30;

impl Program {
    /// Lowers a solid. Time and memory are linear in the number of nodes, a
    /// subtree that several others share counting once per distinct transform,
    /// name and colour (times the logarithm of the number of surfaces).
    ///
    /// # Errors
    /// [`Error::InvalidNode`] names the first node with bad arguments.
    pub fn lower(solid: &Solid) -> Result<Self, Error> {
        let mut lowering = Lowering::new(solid);
        lowering.walk(solid)?;
        let root = lowering.values.pop().unwrap_or(Operand::Constant(false));
        let Builder {
            mut formula,
            origins,
            table,
            ..
        } = lowering.builder;
        formula.root = root;
        Ok(Self {
            surfaces: table.into_surfaces(),
            formula: compact(&formula),
            origins,
        })
    }
}

/// What a subtree inherits from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Context {
    /// Index of the accumulated map, name and colour.
    map: u32,
    name: u32,
    color: u32,
    negated: bool,
}

/// One node on the way from the root to the current one.
struct Frame<'a> {
    solid: &'a Solid,
    context: Context,
    /// Which operand to visit next.
    next: usize,
    /// Which operand of the frame below this one is.
    operand: usize,
    /// The operation that the values above `base` are to be combined by, and
    /// whether the frame below does that because it is the same one.
    operation: Option<Operation>,
    merged: bool,
    base: usize,
}

struct Lowering<'a> {
    frames: Vec<Frame<'a>>,
    values: Vec<Operand>,
    maps: Vec<WorldMap>,
    map_index: FxHashMap<[u64; 12], u32>,
    /// Names and colours met so far; the first of each is "none".
    names: Vec<Option<Arc<str>>>,
    name_index: FxHashMap<Arc<str>, u32>,
    colors: Vec<Option<Color>>,
    color_index: FxHashMap<[u32; 4], u32>,
    /// Nodes that occur more than once in the tree.
    repeated: FxHashSet<usize>,
    known: FxHashMap<(usize, Context), Operand>,
    builder: Builder,
}

impl<'a> Lowering<'a> {
    fn new(root: &'a Solid) -> Self {
        let mut lowering = Self {
            frames: Vec::new(),
            values: Vec::new(),
            maps: Vec::new(),
            map_index: FxHashMap::default(),
            names: vec![None],
            name_index: FxHashMap::default(),
            colors: vec![None],
            color_index: FxHashMap::default(),
            repeated: find_repeated(root),
            known: FxHashMap::default(),
            builder: Builder::default(),
        };
        lowering.intern_map(WorldMap::IDENTITY);
        lowering
    }

    fn intern_map(&mut self, map: WorldMap) -> u32 {
        let key = map.map.to_cols_array().map(f64::to_bits);
        *self.map_index.entry(key).or_insert_with(|| {
            self.maps.push(map);
            (self.maps.len() - 1) as u32
        })
    }

    fn walk(&mut self, root: &'a Solid) -> Result<(), Error> {
        let context = Context {
            map: 0,
            name: 0,
            color: 0,
            negated: false,
        };
        self.enter(root, context, 0, None)?;
        while let Some(frame) = self.frames.last_mut() {
            let node = frame.solid.node();
            let index = frame.next;
            let Some(operand) = node.operands().get(index) else {
                self.leave()?;
                continue;
            };
            frame.next += 1;
            let mut context = frame.context;
            let operation = frame.operation;
            match node {
                Node::Difference(_) if index > 0 => context.negated = !context.negated,
                Node::Transform(map, _) => {
                    let map = map.clone().map_err(|fault| self.error(fault))?;
                    context.map = self.accumulate(context.map, map)?;
                }
                Node::Named(name, _) => {
                    let next = self.names.len() as u32;
                    context.name = *self.name_index.entry(name.clone()).or_insert(next);
                    if context.name == next {
                        self.names.push(Some(name.clone()));
                    }
                }
                Node::Colored(color, _) => {
                    let [r, g, b] = color.rgb;
                    let key = [r, g, b, color.alpha].map(f32::to_bits);
                    let next = self.colors.len() as u32;
                    context.color = *self.color_index.entry(key).or_insert(next);
                    if context.color == next {
                        self.colors.push(Some(*color));
                    }
                }
                _ => {}
            }
            self.enter(operand, context, index, operation)?;
        }
        Ok(())
    }

    /// The accumulated map followed by (further in) `inner`, checked.
    fn accumulate(&mut self, outer: u32, inner: glam::DAffine3) -> Result<u32, Error> {
        if !inner.is_finite() {
            return Err(self.error(NodeFault::NotFinite {
                what: "every entry of the map",
            }));
        }
        let alone = WorldMap::IDENTITY.then_inner(&inner);
        // Not so much as one correct digit is left below this.
        let conditioning = alone.relative_determinant().abs();
        if conditioning.is_nan() || conditioning <= 64.0 * f64::EPSILON {
            return Err(self.error(NodeFault::SingularMap {
                determinant: inner.matrix3.determinant(),
            }));
        }
        let outer = self.maps[outer as usize];
        let map = if outer.is_identity() {
            alone
        } else {
            outer.then_inner(&inner)
        };
        if !map.map.is_finite() {
            return Err(self.error(NodeFault::OutOfRange {
                what: "the map together with those above it",
            }));
        }
        Ok(self.intern_map(map))
    }

    /// Starts on a node: finds its value at once (a leaf, a known subtree) or
    /// puts it on the stack. `above` is the operation its value feeds.
    fn enter(
        &mut self,
        solid: &'a Solid,
        context: Context,
        operand: usize,
        above: Option<Operation>,
    ) -> Result<(), Error> {
        let node = solid.node();
        let repeated = self.repeated.contains(&solid.id());
        if repeated && let Some(&value) = self.known.get(&(solid.id(), context)) {
            self.values.push(value);
            return Ok(());
        }
        let nary = match node {
            Node::Union(_) => Some(("union", Operation::Or)),
            Node::Intersection(_) => Some(("intersection", Operation::And)),
            Node::Difference(_) => Some(("difference", Operation::And)),
            _ => None,
        };
        let own = nary.map(|(_, operation)| {
            if context.negated {
                operation.dual()
            } else {
                operation
            }
        });
        self.frames.push(Frame {
            solid,
            context,
            next: 0,
            operand,
            // A repeated node must come to one value that can be remembered.
            operation: own.or(if repeated { None } else { above }),
            merged: own.is_some() && own == above && !repeated,
            base: self.values.len(),
        });
        match node {
            Node::Primitive(primitive) => self.lower_primitive(primitive, context),
            _ if nary.is_some() && node.operands().is_empty() => {
                let operation = nary.map_or("", |(name, _)| name);
                Err(self.error(NodeFault::NoOperands { operation }))
            }
            _ => Ok(()),
        }
    }

    /// Finishes the node on top of the stack: its value replaces those of its
    /// operands, unless the operation below takes them all.
    fn leave(&mut self) -> Result<(), Error> {
        let Some(frame) = self.frames.pop() else {
            return Ok(());
        };
        let combines = matches!(
            frame.solid.node(),
            Node::Union(_) | Node::Intersection(_) | Node::Difference(_)
        );
        if combines
            && !frame.merged
            && let Some(operation) = frame.operation
        {
            let value = self
                .builder
                .combine(operation, &self.values[frame.base..])?;
            self.values.truncate(frame.base);
            self.values.push(value);
        }
        if self.repeated.contains(&frame.solid.id())
            && let [value] = self.values[frame.base..]
        {
            self.known.insert((frame.solid.id(), frame.context), value);
        }
        Ok(())
    }

    fn lower_primitive(&mut self, primitive: &Primitive, context: Context) -> Result<(), Error> {
        let surfaces = match half_spaces(primitive).map_err(|fault| self.error(fault))? {
            LocalShape::Constant(value) => {
                self.values
                    .push(Operand::Constant(value != context.negated));
                return Ok(());
            }
            LocalShape::HalfSpaces(surfaces) => surfaces,
        };
        let origin = push_index(
            &mut self.builder.origins,
            Origin {
                kind: primitive.kind(),
                name: self.names[context.name as usize].clone(),
                color: self.colors[context.color as usize],
            },
        );
        let base = self.values.len();
        let map = self.maps[context.map as usize];
        for surface in surfaces {
            let placed = map.apply(&surface).ok_or_else(|| {
                self.error(NodeFault::OutOfRange {
                    what: "the primitive under the maps above it",
                })
            })?;
            let (surface, flipped) = self.builder.table.insert(placed);
            let literal = self.builder.literal(Literal {
                surface,
                origin,
                outside: flipped != context.negated,
            })?;
            self.values.push(literal);
        }
        let operation = if context.negated {
            Operation::Or
        } else {
            Operation::And
        };
        let flattens = self
            .frames
            .last()
            .is_some_and(|frame| frame.operation == Some(operation));
        if !flattens {
            let value = self.builder.combine(operation, &self.values[base..])?;
            self.values.truncate(base);
            self.values.push(value);
        }
        Ok(())
    }

    /// The fault as an error at the node on top of the stack.
    fn error(&self, fault: NodeFault) -> Error {
        let steps = self
            .frames
            .iter()
            .map(|frame| PathStep {
                operand: frame.operand,
                kind: frame.solid.node().kind(),
                name: match frame.solid.node() {
                    Node::Named(name, _) => Some(name.clone()),
                    _ => None,
                },
            })
            .collect();
        Error::InvalidNode {
            path: NodePath { steps },
            fault,
        }
    }
}

fn push_index<T>(list: &mut Vec<T>, item: T) -> u32 {
    list.push(item);
    (list.len() - 1) as u32
}

/// The nodes that more than one operand list of the tree below `root` names
/// (or one list several times).
fn find_repeated(root: &Solid) -> FxHashSet<usize> {
    let mut seen = FxHashSet::default();
    let mut repeated = FxHashSet::default();
    let mut pending = vec![root];
    while let Some(solid) = pending.pop() {
        if !solid.is_shared() || seen.insert(solid.id()) {
            pending.extend(solid.node().operands());
        } else {
            repeated.insert(solid.id());
        }
    }
    repeated
}

/// The program under construction.
#[derive(Default)]
struct Builder {
    formula: Formula,
    origins: Vec<Origin>,
    table: SurfaceTable,
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

/// A mixing function with full avalanche (two rounds of the finaliser of
/// SplitMix64, Steele, Lea and Flood 2014, on independent streams).
fn mix(value: u128, salt: u64) -> u128 {
    let half = |mut x: u64| {
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    let (high, low) = ((value >> 64) as u64, value as u64);
    let a = half(
        low.wrapping_add(salt)
            .wrapping_add(half(high ^ 0x9e37_79b9_7f4a_7c15)),
    );
    let b = half(a ^ high.rotate_left(17) ^ low.wrapping_mul(0xd6e8_feb8_6659_fd93));
    u128::from(a) << 64 | u128::from(b)
}

impl Builder {
    fn literal(&mut self, literal: Literal) -> Result<Operand, Error> {
        let index = self.formula.literals.len();
        if index >= MOST {
            return Err(Error::TooLarge {
                what: "literals in the model",
                limit: MOST as u64,
            });
        }
        self.formula.literals.push(literal);
        self.stamps.resize(2 * self.table.len(), 0);
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
    fn combine(&mut self, operation: Operation, values: &[Operand]) -> Result<Operand, Error> {
        // Each round may decide something for the next. Stopping early costs
        // a few gates, never correctness, and bounds the time.
        const ROUNDS: usize = 8;
        let mut values = values.to_vec();
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
    fn gate(&mut self, operation: Operation, operands: &[Operand]) -> Result<Operand, Error> {
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

/// The formula without literals and gates that nothing uses.
fn compact(formula: &Formula) -> Formula {
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
