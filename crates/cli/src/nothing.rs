//! Why nothing is left of a model, and where what it was made of lies.

use std::fmt;
use std::path::Path;

use csg::{BoundaryOptions, Bounds, Node, Program, Solid};

use crate::commands::figure::{place, short};
use crate::failure::{Failure, exit_codes};

/// Refuses to draw a solid of which nothing is left, and says why nothing is.
pub(crate) fn refuse_empty(solid: &Solid, boundary: &BoundaryOptions) -> Result<(), Failure> {
    match Program::lower(solid)?.boundary(boundary) {
        Ok(brep) if brep.is_empty() => {
            say!("{}", Nothing::of(solid));
            let cause = "the model is empty";
            Err(Failure::new(
                exit_codes::MODEL,
                "there is nothing to draw",
                cause,
            ))
        }
        // (There is something, or that cannot be told.)
        _ => Ok(()),
    }
}

/// A warning of an empty solid.
pub(crate) struct Nothing {
    /// Which one, where there are several.
    file: Option<String>,
    /// How many primitives it was made of.
    primitives: usize,
    /// What left nothing of them, if that is one operation.
    why: Option<String>,
    /// Operands and boxes around them.
    operands: Vec<String>,
}

/// Operands that are told.
const MOST: usize = 6;

impl Nothing {
    /// The same of a file that is one of several.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self {
            file: Some(path.display().to_string()),
            ..self
        }
    }

    pub(crate) fn of(solid: &Solid) -> Self {
        let primitives = Program::lower(solid).map_or(0, |program| program.origins().len());
        // Down to the operation that leaves nothing of something.
        let mut at = solid;
        let (why, operands) = loop {
            let operands = at.node().operands();
            let boxes: Vec<Where> = operands.iter().map(Where::of).collect();
            match at.node() {
                Node::Intersection(_) | Node::Difference(_) if boxes.len() > 1 => {
                    // Whose first operand is empty itself: there is the cause.
                    let cuts = matches!(at.node(), Node::Difference(_));
                    let is_empty = |k: usize| matches!(boxes[k], Where::Nowhere);
                    let empty = (0..boxes.len()).find(|&k| is_empty(k) && (k == 0 || !cuts));
                    if let Some(empty) = empty {
                        at = &operands[empty];
                        continue;
                    }
                    let why = if cuts {
                        "what is subtracted takes all of the first operand".to_owned()
                    } else {
                        apart(&boxes)
                    };
                    break (Some(why), told(operands, &boxes));
                }
                _ => match operands {
                    [only] => at = only,
                    [] => break (None, Vec::new()),
                    several => break (None, told(several, &boxes)),
                },
            }
        };
        Self {
            file: None,
            primitives,
            why,
            operands,
        }
    }
}

/// Where a solid lies.
enum Where {
    Nowhere,
    Within(Bounds),
    Endless,
}

impl Where {
    fn of(solid: &Solid) -> Self {
        let bounds = Program::lower(solid).and_then(|program| program.bounds());
        match bounds {
            Ok(None) => Self::Nowhere,
            Ok(Some(bounds)) => Self::Within(bounds),
            Err(_) => Self::Endless,
        }
    }
}

/// Why an intersection is empty.
fn apart(boxes: &[Where]) -> String {
    for (k, one) in boxes.iter().enumerate() {
        for (m, other) in boxes.iter().enumerate().skip(k + 1) {
            let (Where::Within(one), Where::Within(other)) = (one, other) else {
                continue;
            };
            let gap = (one.min - other.max).max(other.min - one.max);
            if gap.max_element() > 0.0 {
                let axis = ["x", "y", "z"][gap.max_position()];
                let gap = short(gap.max_element(), 6);
                let (k, m) = (k + 1, m + 1);
                return format!("operands {k} and {m} are {gap} apart along {axis}");
            }
        }
    }
    "the operands have no point in common".to_owned()
}

fn told(operands: &[Solid], boxes: &[Where]) -> Vec<String> {
    let mut told: Vec<String> = (1..)
        .zip(operands.iter().zip(boxes))
        .take(MOST)
        .map(|(number, (operand, lies))| {
            let name = match name(operand) {
                Some(name) => format!("{number} ({name})"),
                None => number.to_string(),
            };
            match lies {
                Where::Nowhere => format!("operand {name} is empty"),
                Where::Endless => format!("operand {name} has no end"),
                Where::Within(bounds) => {
                    let size = bounds.size().max_element();
                    let [low, high] =
                        [bounds.min, bounds.max].map(|corner| place(corner.to_array(), size, 6));
                    format!("operand {name} lies between {low} and {high}")
                }
            }
        })
        .collect();
    if operands.len() > MOST {
        told.push(format!("and {} more", operands.len() - MOST));
    }
    told
}

/// The name of a solid, or of the only thing that it is made of.
fn name(solid: &Solid) -> Option<&str> {
    match solid.node() {
        Node::Named(name, _) => Some(name),
        Node::Transform(_, only) | Node::Colored(_, only) => name(only),
        _ => None,
    }
}

impl fmt::Display for Nothing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("warning: ")?;
        if let Some(file) = &self.file {
            write!(f, "{file}: ")?;
        }
        match (&self.why, self.primitives) {
            (_, 0) => write!(f, "the model has nothing in it")?,
            (Some(why), count) => {
                write!(
                    f,
                    "nothing is left of the model's {count} primitives: {why}"
                )?;
            }
            (None, count) => write!(
                f,
                "nothing is left of the model's {count} primitives: they have no \
                 volume, or are smaller than the cells"
            )?,
        }
        for operand in &self.operands {
            write!(f, "\n  {operand}")?;
        }
        Ok(())
    }
}
