//! Writing: from a solid to scene text.
//!
//! One walk with a stack of its own. In a solid the innermost colour wins, in
//! a scene the outermost: a colour is therefore written around the largest
//! subtrees that hold no other.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;

use csg::color::srgb_to_linear;
use csg::{Color, Node, NodePath, PathStep, Primitive, Solid};
use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::polyhedra::{self, Within, cut_off, is_infinite, is_one_polyhedron, polyhedron};
use super::shapes::{Shape, shape};

/// Why a solid could not be written as a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// No node of the format says this.
    #[error("{problem} (at {path})")]
    NotExpressible {
        /// Where in the solid's tree.
        path: NodePath,
        /// What there is no node for, and what to use instead.
        problem: String,
    },
    /// The format cannot share subtrees, and written out there are too many.
    #[error(
        "written out without sharing, the tree has more than {limit} nodes: write its parts to several files"
    )]
    TooLarge {
        /// The most nodes that are written.
        limit: usize,
    },
}

/// More would be gigabytes of text.
const MOST_NODES: usize = 20_000_000;
/// Deeper levels are indented like this one, or the white space of a deep
/// tree would grow with the square of its depth.
const DEEPEST_INDENT: usize = 24;

/// The scene text of a solid: every Boolean operation, affine map, name (as a
/// comment) and colour. Boxes, spheres, ellipsoids, cylinders, frusta and cones are
/// nodes; other prisms are extruded polygons; what is made of half-spaces alone (an
/// extrusion, a hull, a polyhedron) is one polyhedron. Primitives without end are cut
/// off beyond the whole solid, which is then intersected with a box; curved ones that
/// OpenSCAD does not have (quadrics, paraboloids, hyperboloids) become polyhedra
/// within a thousandth of their size. Numbers are the shortest that read back the
/// same.
///
/// Subtrees that are shared are written at every place; the size of the text
/// is linear in the number of nodes so counted.
///
/// # Errors
/// [`WriteError::NotExpressible`] names the first node that is wrong, or has no end
/// where the whole solid has none; [`WriteError::TooLarge`].
pub fn write(solid: &Solid) -> Result<String, WriteError> {
    let mut writer = Writer {
        text: String::new(),
        depth: 0,
        path: NodePath::default(),
        with_color: with_color(solid),
        within: None,
        root: solid,
        nodes: 0,
        polyhedra: HashMap::new(),
        cut: Vec::new(),
    };
    writer.walk(solid)?;
    Ok(match writer.within {
        None => writer.text,
        Some(within) => within_box(&writer.text, within),
    })
}

/// The scene within a box, beyond which what was infinite is not to be trusted.
fn within_box(text: &str, within: Within) -> String {
    let mut whole = "intersection() {\n".to_owned();
    let [min, size] = [within.min, within.max - within.min];
    let head = multmatrix(&DAffine3::from_translation(min));
    let size = list(&size.to_array());
    let _ = writeln!(
        whole,
        "\t{head} {{\n\t\tcube(size = {size}, center = false);\n\t}}"
    );
    whole.push_str("\tgroup() {\n");
    for line in text.lines() {
        let _ = writeln!(whole, "\t\t{line}");
    }
    whole.push_str("\t}\n}\n");
    whole
}

enum Step<'a> {
    /// Writes a node in the colour set further out and not yet written.
    Enter {
        solid: &'a Solid,
        color: Option<Color>,
        operand: usize,
        /// The maps above it.
        map: DAffine3,
    },
    /// Closes a brace.
    Close,
    /// Steps back up in the path.
    Leave,
}

struct Writer<'a> {
    text: String,
    depth: usize,
    path: NodePath,
    /// Identities of the nodes with a colour in their subtree.
    with_color: HashSet<usize>,
    root: &'a Solid,
    nodes: usize,
    /// The box around all, once something infinite has been cut off.
    within: Option<Within>,
    /// What was written for subtrees that were made into one polyhedron, by identity.
    polyhedra: HashMap<usize, Option<String>>,
    /// What was written in place of infinite primitives, kept: the identity of what is gone
    /// may be given to another solid.
    cut: Vec<Solid>,
}

impl Writer<'_> {
    fn walk(&mut self, solid: &Solid) -> Result<(), WriteError> {
        let mut steps = vec![Step::Enter {
            solid,
            color: None,
            operand: 0,
            map: DAffine3::IDENTITY,
        }];
        while let Some(step) = steps.pop() {
            match step {
                Step::Close => {
                    self.depth -= 1;
                    self.line("}");
                }
                Step::Leave => {
                    self.path.steps.pop();
                }
                Step::Enter {
                    solid,
                    color,
                    operand,
                    map,
                } => {
                    self.nodes += 1;
                    if self.nodes > MOST_NODES {
                        return Err(WriteError::TooLarge { limit: MOST_NODES });
                    }
                    self.enter(solid, color, (operand, map), &mut steps)?;
                }
            }
        }
        Ok(())
    }

    fn enter<'a>(
        &mut self,
        solid: &'a Solid,
        color: Option<Color>,
        (operand, map): (usize, DAffine3),
        steps: &mut Vec<Step<'a>>,
    ) -> Result<(), WriteError> {
        let node = solid.node();
        self.path.steps.push(PathStep {
            operand,
            kind: node.kind(),
            name: match node {
                Node::Named(name, _) => Some(name.clone()),
                _ => None,
            },
        });
        steps.push(Step::Leave);
        let mut color = color;
        if !self.with_color.contains(&solid.id())
            && let Some(color) = color.take()
        {
            self.open(&color_head(color));
            steps.push(Step::Close);
        }
        let head = match node {
            Node::Primitive(primitive) if is_infinite(primitive) => {
                return self.infinite(primitive, map);
            }
            Node::Primitive(primitive) => {
                let shape = shape(primitive).map_err(|problem| self.fault(problem))?;
                self.shape(&shape);
                return Ok(());
            }
            Node::Colored(own, inner) => {
                // Written here or, if there are colours further in, there.
                steps.push(Step::Enter {
                    solid: inner,
                    color: Some(*own),
                    operand: 0,
                    map,
                });
                return Ok(());
            }
            Node::Union(_) => "union()".to_owned(),
            Node::Intersection(_) => "intersection()".to_owned(),
            Node::Difference(_) => "difference()".to_owned(),
            Node::Transform(Ok(map), _) if map.is_finite() => multmatrix(map),
            Node::Transform(Ok(_), _) => return Err(self.fault("the map is not finite".into())),
            Node::Transform(Err(fault), _) => return Err(self.fault(fault.to_string())),
            Node::Made(csg::Made {
                solid: Err(fault), ..
            }) => {
                return Err(self.fault(fault.to_string()));
            }
            // (OpenSCAD has no parabolas.)
            Node::Made(csg::Made {
                with_chords: Some(solid),
                ..
            }) => {
                steps.push(Step::Enter {
                    solid,
                    color,
                    operand: 0,
                    map,
                });
                return Ok(());
            }
            Node::Made(made) => {
                if is_one_polyhedron(made)
                    && let Some(node) = self.one_polyhedron(solid)
                {
                    self.line(&node);
                    return Ok(());
                }
                "group()".to_owned()
            }
            Node::Named(name, _) => {
                let comment: String = name
                    .chars()
                    .map(|c| if c.is_control() { ' ' } else { c })
                    .collect();
                self.line(&format!("// {comment}"));
                "group()".to_owned()
            }
            other => return Err(self.fault(format!("there is no node for {}", other.kind()))),
        };
        let operands = node.operands();
        if operands.is_empty() {
            let problem = format!("{} of nothing: use Solid::empty()", node.kind());
            return Err(self.fault(problem));
        }
        self.open(&head);
        steps.push(Step::Close);
        let map = match node {
            Node::Transform(Ok(own), _) => map * *own,
            _ => map,
        };
        for (operand, solid) in operands.iter().enumerate().rev() {
            steps.push(Step::Enter {
                solid,
                color,
                operand,
                map,
            });
        }
        Ok(())
    }

    /// A primitive without end, cut off beyond the whole solid.
    fn infinite(&mut self, primitive: &Primitive, map: DAffine3) -> Result<(), WriteError> {
        let within = match self.within {
            Some(within) => within,
            None => match Within::of(self.root).map_err(|problem| self.fault(problem))? {
                Some(within) => within,
                // Nothing is left of it anyway.
                None => Within {
                    min: -DVec3::ONE,
                    max: DVec3::ONE,
                },
            },
        };
        self.within = Some(within);
        let cut =
            cut_off(primitive, within.padded(), map).map_err(|problem| self.fault(problem))?;
        self.cut.push(cut.clone());
        self.walk(&cut)
    }

    /// The node of a subtree as one polyhedron, if it can be meshed.
    fn one_polyhedron(&mut self, solid: &Solid) -> Option<String> {
        let written = self.polyhedra.entry(solid.id()).or_insert_with(|| {
            let mesh = polyhedron(solid).ok()?;
            Some(mesh.map_or_else(|| "group();".to_owned(), |mesh| polyhedra::node(&mesh)))
        });
        written.clone()
    }

    fn shape(&mut self, shape: &Shape) {
        if let Some(map) = &shape.map {
            self.open(&multmatrix(map));
            self.line(&shape.node);
            self.depth -= 1;
            self.line("}");
        } else {
            self.line(&shape.node);
        }
    }

    fn open(&mut self, head: &str) {
        self.line(&format!("{head} {{"));
        self.depth += 1;
    }

    fn line(&mut self, line: &str) {
        let tabs = self.depth.min(DEEPEST_INDENT);
        self.text.extend(std::iter::repeat_n('\t', tabs));
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn fault(&self, problem: String) -> WriteError {
        WriteError::NotExpressible {
            path: self.path.clone(),
            problem,
        }
    }
}

/// The identities of the nodes that are coloured or have a coloured node
/// below them.
fn with_color(root: &Solid) -> HashSet<usize> {
    let mut found = HashSet::new();
    let mut seen = HashSet::new();
    // Nodes on the way down, and again (true) after their operands.
    let mut pending = vec![(root, false)];
    while let Some((solid, after)) = pending.pop() {
        let operands = solid.node().operands();
        if after {
            if matches!(solid.node(), Node::Colored(..))
                || operands.iter().any(|operand| found.contains(&operand.id()))
            {
                found.insert(solid.id());
            }
        } else if !operands.is_empty() && seen.insert(solid.id()) {
            pending.push((solid, true));
            pending.extend(operands.iter().map(|operand| (operand, false)));
        }
    }
    found
}

fn color_head(color: Color) -> String {
    let encoded = color.to_srgb();
    let [r, g, b] = [0, 1, 2].map(|i| shortest_srgb(encoded[i], color.rgb[i]));
    format!("color([{r}, {g}, {b}, {}])", color.alpha)
}

/// The fewest decimals of an sRGB component that decode to `linear`: powers
/// in f32 leave 1 at 0.99999994.
fn shortest_srgb(encoded: f32, linear: f32) -> f32 {
    let mut rounded = (0..9).map(|decimals| {
        let unit = 10_f64.powi(decimals);
        ((f64::from(encoded) * unit).round() / unit) as f32
    });
    rounded
        .find(|&candidate| srgb_to_linear(candidate) == linear)
        .unwrap_or(encoded)
}

fn multmatrix(map: &DAffine3) -> String {
    let mut head = "multmatrix([".to_owned();
    for row in 0..3 {
        let linear = map.matrix3.row(row);
        head.push('[');
        for entry in linear.to_array() {
            let _ = write!(head, "{}, ", number(entry));
        }
        let _ = write!(head, "{}], ", number(map.translation[row]));
    }
    head.push_str("[0, 0, 0, 1]])");
    head
}

/// The shortest digits that read back as the same number.
pub(super) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e16).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// The number list `[x, y, ..]`.
pub(super) fn list(values: &[f64]) -> String {
    let numbers: Vec<String> = values.iter().map(|&value| number(value)).collect();
    format!("[{}]", numbers.join(", "))
}

/// The map with the given columns across and the identity along z.
pub(super) fn across(x: DVec2, y: DVec2, center: DVec2) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(x.extend(0.0), y.extend(0.0), DVec3::Z),
        translation: center.extend(0.0),
    }
}
