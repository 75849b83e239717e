//! Boolean formulas over half-space literals, in negation normal form.

use std::fmt;

/// One polarity of one surface, with its provenance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Literal {
    /// Index of the surface, in the list the formula goes with.
    pub surface: u32,
    /// Index of the primitive it comes from ([`crate::Program::origins`]).
    pub origin: u32,
    /// The half-space meant: f > 0 if true, f <= 0 if false.
    pub outside: bool,
}

/// How a gate combines its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// True where all operands are.
    And,
    /// True where any operand is.
    Or,
}

impl Operation {
    /// The operand value that decides the result: false for [`Self::And`].
    #[must_use]
    pub const fn absorbing(self) -> bool {
        matches!(self, Self::Or)
    }

    /// The other operation.
    #[must_use]
    pub const fn dual(self) -> Self {
        match self {
            Self::And => Self::Or,
            Self::Or => Self::And,
        }
    }
}

/// What a gate combines: a constant, a literal or an earlier gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operand {
    /// A truth value.
    Constant(bool),
    /// Index into [`Formula::literals`].
    Literal(u32),
    /// Index into [`Formula::gates`].
    Gate(u32),
}

/// An n-ary and- or or-gate: a range of the formula's operands ([`Formula::operands_of`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gate {
    /// How the operands combine.
    pub operation: Operation,
    /// First operand.
    pub start: u32,
    /// One past the last operand.
    pub end: u32,
}

/// A Boolean formula: literals and gates in an order in which every gate
/// comes after its operands, so that evaluation is one forward loop and no
/// depth can overflow the stack.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    pub(crate) literals: Vec<Literal>,
    pub(crate) gates: Vec<Gate>,
    pub(crate) operands: Vec<Operand>,
    pub(crate) root: Operand,
}

impl Default for Formula {
    fn default() -> Self {
        Self::NOTHING
    }
}

impl Formula {
    /// False everywhere.
    pub(crate) const NOTHING: Self = Self {
        literals: Vec::new(),
        gates: Vec::new(),
        operands: Vec::new(),
        root: Operand::Constant(false),
    };

    /// What its lists hold, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.literals) + size_of_val(&*self.gates) + size_of_val(&*self.operands)
    }

    /// The literals in use.
    #[must_use]
    pub fn literals(&self) -> &[Literal] {
        &self.literals
    }

    /// The gates, operands before users.
    #[must_use]
    pub fn gates(&self) -> &[Gate] {
        &self.gates
    }

    /// The operands of a gate.
    #[must_use]
    pub fn operands_of(&self, gate: &Gate) -> &[Operand] {
        &self.operands[gate.start as usize..gate.end as usize]
    }

    /// What the formula's value is.
    #[must_use]
    pub fn root(&self) -> Operand {
        self.root
    }

    /// The value where `inside[s]` tells whether f <= 0 for surface s.
    ///
    /// # Panics
    /// If `inside` is shorter than the list of surfaces.
    #[must_use]
    pub fn evaluate(&self, inside: &[bool]) -> bool {
        self.evaluate_into(inside, &mut Vec::with_capacity(self.gates.len()))
    }

    /// [`Self::evaluate`] with the caller's scratch memory.
    pub(crate) fn evaluate_into(&self, inside: &[bool], gates: &mut Vec<bool>) -> bool {
        gates.clear();
        for gate in &self.gates {
            let absorbing = gate.operation.absorbing();
            let decided = self
                .operands_of(gate)
                .iter()
                .any(|&operand| self.operand_value(operand, inside, gates) == absorbing);
            gates.push(decided == absorbing);
        }
        self.operand_value(self.root, inside, gates)
    }

    /// The values under 64 assignments at once, a bit each: `inside` gives the
    /// bits of f <= 0 for a literal, named by its index and its surface.
    pub(crate) fn evaluate_words(
        &self,
        gates: &mut Vec<u64>,
        inside: impl Fn(u32, u32) -> u64,
    ) -> u64 {
        let value = |operand: Operand, gates: &[u64]| match operand {
            Operand::Constant(false) => 0,
            Operand::Constant(true) => u64::MAX,
            Operand::Literal(i) => {
                let literal = self.literals[i as usize];
                let inside = inside(i, literal.surface);
                if literal.outside { !inside } else { inside }
            }
            Operand::Gate(i) => gates[i as usize],
        };
        gates.clear();
        for gate in &self.gates {
            let operands = self.operands_of(gate).iter();
            let result = match gate.operation {
                Operation::And => operands.fold(u64::MAX, |all, &o| all & value(o, gates)),
                Operation::Or => operands.fold(0, |all, &o| all | value(o, gates)),
            };
            gates.push(result);
        }
        value(self.root, gates)
    }

    fn operand_value(&self, operand: Operand, inside: &[bool], gates: &[bool]) -> bool {
        match operand {
            Operand::Constant(value) => value,
            Operand::Literal(i) => {
                let literal = self.literals[i as usize];
                inside[literal.surface as usize] != literal.outside
            }
            Operand::Gate(i) => gates[i as usize],
        }
    }
}

/// Prints small formulas as one nested expression, large ones gate by gate.
impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NESTED_LIMIT: usize = 64;
        if self.gates.len() <= NESTED_LIMIT {
            return match self.root {
                Operand::Gate(i) => {
                    writeln!(f, "solid = {}", Gated(self, &self.gates[i as usize], true))
                }
                root => writeln!(f, "solid = {}", Nested(self, root)),
            };
        }
        for (i, gate) in self.gates.iter().enumerate() {
            writeln!(f, "g{i} = {}", Gated(self, gate, false))?;
        }
        match self.root {
            Operand::Gate(i) => writeln!(f, "solid = g{i}"),
            root => writeln!(f, "solid = {}", Nested(self, root)),
        }
    }
}

/// One operand, gates spelled out in parentheses.
struct Nested<'a>(&'a Formula, Operand);

/// One gate, its operand gates spelled out or by number.
struct Gated<'a>(&'a Formula, &'a Gate, bool);

impl fmt::Display for Nested<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(formula, operand) = *self;
        match operand {
            Operand::Constant(value) => f.write_str(if value { "everything" } else { "nothing" }),
            Operand::Literal(i) => {
                let literal = formula.literals[i as usize];
                let not = if literal.outside { "!" } else { "" };
                write!(f, "{not}s{}", literal.surface)
            }
            Operand::Gate(i) => {
                write!(f, "({})", Gated(formula, &formula.gates[i as usize], true))
            }
        }
    }
}

impl fmt::Display for Gated<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(formula, gate, nested) = *self;
        let sign = match gate.operation {
            Operation::And => " & ",
            Operation::Or => " | ",
        };
        for (i, &operand) in formula.operands_of(gate).iter().enumerate() {
            if i > 0 {
                f.write_str(sign)?;
            }
            match operand {
                Operand::Gate(g) if !nested => write!(f, "g{g}")?,
                _ => write!(f, "{}", Nested(formula, operand))?,
            }
        }
        Ok(())
    }
}
