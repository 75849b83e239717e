//! Meaning: from the text's nodes to a solid.

use csg::{Color, Node, Primitive, Solid};
use glam::{DAffine3, DMat4, DVec3, DVec4};

use super::error::{Place, SceneError, Warning};
use super::facets::{self, Fineness};
use super::parse::{Kind, NodeText, Tree, Value};
use super::{ReadOptions, Scene};

/// The most facets that one scene may have: half a gigabyte of planes.
const MOST_FACETS: f64 = (1 << 24) as f64;

pub(super) fn build(tree: &Tree<'_>, options: ReadOptions) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        tree,
        options,
        facets: 0.0,
        warnings: Vec::new(),
        cursor: Cursor::default(),
    };
    let mut open = vec![Open {
        operation: Operation::Union,
        end: tree.nodes.len(),
        colored: false,
        operands: Vec::new(),
    }];
    let mut index = 0;
    loop {
        // Each node that ends here becomes an operand of the one around it.
        while open.len() > 1 && open.last().is_some_and(|node| node.end <= index) {
            let closed = open.pop().map(Open::into_solid);
            if let (Some(solid), Some(around)) = (closed, open.last_mut()) {
                around.operands.push(solid);
            }
        }
        let (Some(around), Some(node)) = (open.last_mut(), tree.nodes.get(index)) else {
            break;
        };
        index += 1;
        if node.background {
            index = node.end;
        } else if node.kind.is_leaf() {
            if node.end > index {
                let problem = "it takes no children: end it with `;`";
                return Err(builder.fault(node, problem));
            }
            around.operands.push(builder.primitive(node)?);
        } else {
            let operation = builder.operation(node, around.colored)?;
            let colored = around.colored || matches!(operation, Operation::Color(_));
            open.push(Open {
                operation,
                end: node.end,
                colored,
                operands: Vec::new(),
            });
        }
    }
    let solid = open.pop().map_or_else(Solid::empty, Open::into_solid);
    Ok(Scene {
        solid,
        warnings: builder.warnings,
    })
}

/// A node whose children are being built.
struct Open {
    operation: Operation,
    end: usize,
    /// Whether a colour is set here or further out: then it wins.
    colored: bool,
    operands: Vec<Solid>,
}

/// What a node does with its children.
enum Operation {
    Union,
    Difference,
    Intersection,
    /// Maps their union.
    Map(DAffine3),
    /// Colours their union.
    Color(Color),
    /// Leaves nothing of them.
    Nothing,
}

impl Open {
    fn into_solid(self) -> Solid {
        let mut operands = self.operands;
        match self.operation {
            Operation::Nothing => Solid::empty(),
            Operation::Union => union(operands),
            Operation::Intersection => {
                if operands.is_empty() || operands.iter().any(is_empty) {
                    Solid::empty()
                } else {
                    one_or(operands, Solid::intersection)
                }
            }
            Operation::Difference => {
                if operands.first().is_none_or(is_empty) {
                    Solid::empty()
                } else {
                    operands.retain(|operand| !is_empty(operand));
                    one_or(operands, Solid::difference)
                }
            }
            Operation::Map(map) => unless_empty(union(operands), |solid| solid.affine(map)),
            Operation::Color(color) => unless_empty(union(operands), |solid| solid.colored(color)),
        }
    }
}

fn is_empty(solid: &Solid) -> bool {
    matches!(solid.node(), Node::Primitive(Primitive::Empty))
}

fn unless_empty(solid: Solid, map: impl FnOnce(&Solid) -> Solid) -> Solid {
    if is_empty(&solid) { solid } else { map(&solid) }
}

fn union(mut operands: Vec<Solid>) -> Solid {
    operands.retain(|operand| !is_empty(operand));
    if operands.is_empty() {
        Solid::empty()
    } else {
        one_or(operands, Solid::union)
    }
}

/// The only operand, or the operation on several.
fn one_or(mut operands: Vec<Solid>, operation: impl FnOnce(Vec<Solid>) -> Solid) -> Solid {
    match operands.pop() {
        Some(only) if operands.is_empty() => only,
        Some(last) => {
            operands.push(last);
            operation(operands)
        }
        None => Solid::empty(),
    }
}

struct Builder<'a> {
    tree: &'a Tree<'a>,
    options: ReadOptions,
    /// Facets made so far.
    facets: f64,
    warnings: Vec<Warning>,
    cursor: Cursor,
}

impl Builder<'_> {
    /// What a node with children does.
    fn operation(&mut self, node: &NodeText<'_>, colored: bool) -> Result<Operation, SceneError> {
        match node.kind {
            Kind::Difference | Kind::Intersection | Kind::Group | Kind::Union => {
                self.arguments(node, &[])?;
                Ok(match node.kind {
                    Kind::Difference => Operation::Difference,
                    Kind::Intersection => Operation::Intersection,
                    _ => Operation::Union,
                })
            }
            Kind::Multmatrix => self.map(node),
            Kind::Color => Ok(match self.color(node)? {
                Some(color) if !colored => Operation::Color(color),
                _ => Operation::Union,
            }),
            _ => {
                self.arguments(node, &["convexity"])?;
                Ok(Operation::Union)
            }
        }
    }

    fn map(&mut self, node: &NodeText<'_>) -> Result<Operation, SceneError> {
        let [matrix] = self.arguments(node, &[""])?;
        let rows = matrix.and_then(|value| {
            let rows: [[f64; 4]; 4] = array(value, |row| array(row, number))?;
            Some(DMat4::from_cols_array_2d(&rows).transpose())
        });
        let Some(matrix) = rows else {
            return Err(self.fault(node, "it needs a matrix: four rows of four numbers"));
        };
        let matrix = matrix * (1.0 / matrix.w_axis.w);
        if !matrix.is_finite() {
            return Ok(self.nothing(node, "the matrix is not finite"));
        }
        if matrix.row(3) != DVec4::W {
            let problem =
                "a projective matrix: the last row must be 0, 0, 0 and a number that is not 0";
            return Err(self.fault(node, problem));
        }
        let map = DAffine3::from_mat4(matrix);
        let linear = map.matrix3;
        let lengths = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        let relative = (linear.determinant() / lengths).abs();
        // Below this not one correct digit is left of the inverse.
        if relative.is_nan() || relative <= 64.0 * f64::EPSILON {
            return Ok(self.nothing(node, "the matrix has no inverse"));
        }
        Ok(Operation::Map(map))
    }

    fn nothing(&mut self, node: &NodeText<'_>, problem: &str) -> Operation {
        self.warn(node, format!("{problem}: what it maps has no points"));
        Operation::Nothing
    }

    fn color(&mut self, node: &NodeText<'_>) -> Result<Option<Color>, SceneError> {
        let [color] = self.arguments(node, &[""])?;
        let rgba = color.and_then(|value| {
            array(value, number).or_else(|| {
                let [r, g, b] = array(value, number)?;
                Some([r, g, b, 1.0])
            })
        });
        let Some(rgba) = rgba.filter(|rgba: &[f64; 4]| rgba.iter().all(|c| c.is_finite())) else {
            let problem = "it needs a colour: [red, green, blue, alpha], each from 0 to 1";
            return Err(self.fault(node, problem));
        };
        if rgba.iter().any(|&component| component < 0.0) {
            return Ok(None);
        }
        let [r, g, b, alpha] = rgba.map(|component| component.min(1.0) as f32);
        Ok(Some(Color::from_srgb([r, g, b]).with_alpha(alpha)))
    }

    fn primitive(&mut self, node: &NodeText<'_>) -> Result<Solid, SceneError> {
        match node.kind {
            Kind::Cube => self.cube(node),
            Kind::Sphere => self.sphere(node),
            _ => self.cylinder(node),
        }
    }

    fn cube(&mut self, node: &NodeText<'_>) -> Result<Solid, SceneError> {
        let [size, center] = self.arguments(node, &["size", "center"])?;
        let Some(size) = size.and_then(|value| array(value, number)) else {
            return Err(self.fault(node, "it needs `size = [x, y, z]`"));
        };
        let center = self.flag(node, "center", center)?;
        if !size.iter().all(|&side| is_size(side)) {
            return Ok(self.empty(node, "a side"));
        }
        let size = DVec3::from_array(size);
        Ok(if center {
            Solid::cuboid(size)
        } else {
            Solid::cuboid_between(DVec3::ZERO, size)
        })
    }

    fn sphere(&mut self, node: &NodeText<'_>) -> Result<Solid, SceneError> {
        let [fn_, fa, fs, radius] = self.arguments(node, &["$fn", "$fa", "$fs", "r"])?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let radius = self.number(node, "r", radius)?;
        if !is_size(radius) {
            return Ok(self.empty(node, "the radius"));
        }
        if !(self.options.faceted || fineness.is_polygon()) {
            return Ok(Solid::sphere(radius));
        }
        let fragments = fineness.fragments(radius);
        let facets = fragments * (0.5 * fragments).ceil();
        let fragments = self.facets(node, fragments, facets)?;
        let planes = facets::sphere(radius, fragments);
        Ok(Solid::convex_polyhedron(planes))
    }

    fn cylinder(&mut self, node: &NodeText<'_>) -> Result<Solid, SceneError> {
        let keys = ["$fn", "$fa", "$fs", "h", "r1", "r2", "center"];
        let [fn_, fa, fs, height, bottom, top, center] = self.arguments(node, &keys)?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let height = self.number(node, "h", height)?;
        let bottom = self.number(node, "r1", bottom)?;
        let top = self.number(node, "r2", top)?;
        let center = self.flag(node, "center", center)?;
        if !is_size(height) {
            return Ok(self.empty(node, "the height"));
        }
        let widest = bottom.max(top);
        if !(is_size(widest) && bottom >= 0.0 && top >= 0.0) {
            return Ok(self.empty(node, "a radius"));
        }
        let z = if center {
            -0.5 * height..0.5 * height
        } else {
            0.0..height
        };
        if self.options.faceted || fineness.is_polygon() {
            let fragments = fineness.fragments(widest);
            let fragments = self.facets(node, fragments, fragments)?;
            return Ok(facets::cylinder(bottom, top, z, fragments));
        }
        Ok(if bottom == top {
            Solid::cylinder(bottom, z)
        } else {
            Solid::frustum(bottom, top, z)
        })
    }

    /// The values of the arguments with the given keys (an empty key: without
    /// one), in their order; an error for any other argument.
    fn arguments<const N: usize>(
        &self,
        node: &NodeText<'_>,
        keys: &[&str; N],
    ) -> Result<[Option<&Value>; N], SceneError> {
        let mut found = [None; N];
        for argument in &self.tree.arguments[node.arguments.clone()] {
            let key = argument.key.unwrap_or("");
            let name = match argument.key {
                Some(key) => format!("the argument `{key}`"),
                None => "an argument without a name".to_owned(),
            };
            let Some(slot) = keys.iter().position(|&known| known == key) else {
                return Err(self.fault(node, &format!("{name} is not known here")));
            };
            if found[slot].replace(&argument.value).is_some() {
                return Err(self.fault(node, &format!("{name} is given twice")));
            }
        }
        Ok(found)
    }

    fn fineness(
        &self,
        node: &NodeText<'_>,
        [number, angle, size]: [Option<&Value>; 3],
    ) -> Result<Fineness, SceneError> {
        let or_default = |key, value: Option<&Value>, default| match value {
            Some(_) => self.number(node, key, value),
            None => Ok(default),
        };
        Ok(Fineness {
            number: or_default("$fn", number, 0.0)?,
            angle: or_default("$fa", angle, 12.0)?,
            size: or_default("$fs", size, 2.0)?,
        })
    }

    fn number(
        &self,
        node: &NodeText<'_>,
        key: &str,
        value: Option<&Value>,
    ) -> Result<f64, SceneError> {
        value
            .and_then(number)
            .ok_or_else(|| self.fault(node, &format!("it needs a number `{key}`")))
    }

    fn flag(
        &self,
        node: &NodeText<'_>,
        key: &str,
        value: Option<&Value>,
    ) -> Result<bool, SceneError> {
        match value {
            None => Ok(false),
            Some(&Value::Bool(flag)) => Ok(flag),
            Some(_) => Err(self.fault(node, &format!("`{key}` must be true or false"))),
        }
    }

    /// Counts the facets of a primitive, and gives its fragments as a count.
    fn facets(
        &mut self,
        node: &NodeText<'_>,
        fragments: f64,
        facets: f64,
    ) -> Result<usize, SceneError> {
        self.facets += facets;
        if self.facets <= MOST_FACETS {
            return Ok(fragments as usize);
        }
        let problem = format!(
            "with {fragments} fragments the scene has more than {MOST_FACETS} facets: raise $fa and $fs, lower $fn, or read circles as circles"
        );
        Err(self.fault(node, &problem))
    }

    fn empty(&mut self, node: &NodeText<'_>, what: &str) -> Solid {
        let problem = format!("{what} is not positive and finite: it has no points");
        self.warn(node, problem);
        Solid::empty()
    }

    fn fault(&self, node: &NodeText<'_>, problem: &str) -> SceneError {
        SceneError::Argument {
            place: Place::of(self.tree.text, node.offset),
            node: node.name.to_owned(),
            problem: problem.to_owned(),
        }
    }

    fn warn(&mut self, node: &NodeText<'_>, problem: String) {
        self.warnings.push(Warning {
            place: self.cursor.advance(self.tree.text, node.offset),
            node: node.name.to_owned(),
            problem,
        });
    }
}

/// Whether OpenSCAD makes anything of this size.
fn is_size(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        _ => None,
    }
}

/// A list of exactly N values, each read by `item`.
fn array<T, const N: usize>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Option<[T; N]> {
    let Value::List(values) = value else {
        return None;
    };
    let items: Option<Vec<T>> = values.iter().map(item).collect();
    items?.try_into().ok()
}

/// Finds the places of ever greater offsets in one pass over the text, so
/// that any number of warnings costs no more than that.
#[derive(Default)]
struct Cursor {
    offset: usize,
    /// Lines and columns before it.
    line: usize,
    column: usize,
}

impl Cursor {
    fn advance(&mut self, text: &str, offset: usize) -> Place {
        let passed = text.get(self.offset..offset).unwrap_or_default();
        for character in passed.chars() {
            if character == '\n' {
                self.line += 1;
                self.column = 0;
            } else {
                self.column += 1;
            }
        }
        self.offset = offset;
        Place {
            file: None,
            line: self.line + 1,
            column: self.column + 1,
        }
    }
}
