//! Meaning: from the text's nodes to a solid.

use csg::{Color, Made, Node, NodeFault, PolyhedronFault, Solid};
use glam::{BVec3, DAffine2, DAffine3, DMat2, DMat4, DVec3, DVec4};

use super::corners::{self, Allowance};
use super::error::{Place, SceneError, Warning};
use super::facets::{self, Fineness};
use super::flat::{Extrusion, Growth, Revolution};
use super::parse::{Kind, NodeText, Tree, Value};
use super::pieces::{self, MIXED, Piece, Pieces};
use super::values::{array, list, number};
use super::{ReadOptions, Scene};

/// The most facets that one scene may have: half a gigabyte of planes.
const MOST_FACETS: f64 = (1 << 24) as f64;
/// Circles have at least so many fragments where a smooth reading has to facet
/// them for a hull or a Minkowski sum.
const FRAGMENTS: f64 = 30.0;

/// More warnings than this help nobody.
const MOST_WARNINGS: usize = 1000;
/// What becomes of a node that something is wrong with.
const NO_POINTS: &str = ": it has no points";

pub(super) fn build(tree: &Tree<'_>, options: ReadOptions) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        tree,
        options,
        faceted_until: 0,
        index: 0,
        facets: 0.0,
        allowance: Allowance::default(),
        warnings: Vec::new(),
        cursor: Cursor::default(),
    };
    let mut open = vec![Open {
        operation: Operation::Union,
        node: None,
        end: tree.nodes.len(),
        colored: false,
        operands: Vec::new(),
    }];
    loop {
        // Each node that ends here becomes an operand of the one around it.
        while open.len() > 1 && open.last().is_some_and(|node| node.end <= builder.index) {
            let Some(closed) = open.pop() else { break };
            let piece = builder.close(closed)?;
            if let Some(around) = open.last_mut() {
                around.operands.push(piece);
            }
        }
        let (Some(around), Some(node)) = (open.last_mut(), tree.nodes.get(builder.index)) else {
            break;
        };
        builder.index += 1;
        if node.background {
            builder.index = node.end;
        } else if node.kind.is_leaf() {
            if node.end > builder.index {
                let problem = "it takes no children: end it with `;`";
                return Err(builder.fault(node, problem));
            }
            around.operands.push(builder.leaf(node)?);
        } else {
            let operation = builder.operation(node, around.colored)?;
            let colored = around.colored || matches!(operation, Operation::Color(_));
            open.push(Open {
                operation,
                node: Some(node),
                end: node.end,
                colored,
                operands: Vec::new(),
            });
        }
    }
    let root = open.pop().map(|root| builder.close(root)).transpose()?;
    let solid = match root {
        None | Some(Piece::Nothing) => Solid::empty(),
        Some(Piece::Solid(solid)) => solid,
        Some(Piece::Flat(_)) => {
            let at = tree.nodes.iter().find(|node| !node.background);
            if let Some(node) = at {
                let problem = "the scene is flat: a solid needs linear_extrude or rotate_extrude";
                builder.warn(node, problem.to_owned());
            }
            Solid::empty()
        }
    };
    Ok(Scene {
        solid,
        warnings: builder.warnings,
    })
}

/// A node whose children are being built.
struct Open<'a> {
    operation: Operation,
    /// None for the root.
    node: Option<&'a NodeText<'a>>,
    end: usize,
    /// Whether a colour is set here or further out: then it wins.
    colored: bool,
    operands: Vec<Piece>,
}

/// What a node does with its children, mostly with their union.
enum Operation {
    Union,
    Difference,
    Intersection,
    /// A map of space and of the plane; none where it has no inverse.
    Map(Option<DAffine3>, Option<DAffine2>),
    Color(Color),
    Extrude(Extrusion),
    Revolve(Revolution),
    Offset(Growth),
    Projection,
    Hull,
    Minkowski,
    /// To a size where it is not 0; as much as that along the axes that are so
    /// marked.
    Resize(DVec3, BVec3),
}

pub(super) struct Builder<'a> {
    tree: &'a Tree<'a>,
    options: ReadOptions,
    /// Nodes before this one are read faceted, whatever the options say.
    faceted_until: usize,
    /// The next node.
    index: usize,
    /// Facets made so far.
    facets: f64,
    /// What may still be meshed.
    allowance: Allowance,
    warnings: Vec<Warning>,
    cursor: Cursor,
}

impl Builder<'_> {
    /// Whether circles are polygons here.
    pub(super) fn is_faceted(&self) -> bool {
        self.options.faceted || self.index <= self.faceted_until
    }

    /// The fragments of a circle that is read as a polygon.
    pub(super) fn fragments(&self, fineness: &Fineness, radius: f64) -> f64 {
        let fragments = fineness.fragments(radius);
        if self.options.faceted || fineness.is_polygon() {
            fragments
        } else {
            fragments.max(FRAGMENTS)
        }
    }

    /// What a node comes to when its children are there.
    fn close(&mut self, open: Open<'_>) -> Result<Piece, SceneError> {
        let operation = match open.operation {
            Operation::Intersection => pieces::intersection,
            Operation::Difference => pieces::difference,
            _ => pieces::union,
        };
        let of_union = !matches!(open.operation, Operation::Hull | Operation::Minkowski);
        let Some(node) = open.node else {
            return Ok(operation(open.operands).0);
        };
        if !of_union {
            return self.convex(node, open);
        }
        let (piece, mixed) = operation(open.operands);
        if mixed {
            self.warn(node, MIXED.to_owned());
        }
        match (open.operation, piece) {
            (_, Piece::Nothing) => Ok(Piece::Nothing),
            (Operation::Map(Some(map), _), Piece::Solid(solid)) => {
                Ok(Piece::Solid(solid.affine(map)))
            }
            (Operation::Map(_, Some(map)), Piece::Flat(flat)) => Ok(Piece::Flat(flat.affine(map))),
            (Operation::Map(..), _) => {
                Ok(self.nothing(node, "the matrix is not finite, or has no inverse"))
            }
            (Operation::Color(color), Piece::Solid(solid)) => {
                Ok(Piece::Solid(solid.colored(color)))
            }
            (Operation::Extrude(extrusion), Piece::Flat(flat)) => {
                self.extruded(node, &flat, &extrusion)
            }
            (Operation::Revolve(revolution), Piece::Flat(flat)) => {
                self.revolved(node, &flat, &revolution)
            }
            (Operation::Offset(growth), Piece::Flat(flat)) => self.grown(node, &flat, &growth),
            (Operation::Extrude(_) | Operation::Revolve(_) | Operation::Offset(_), _) => {
                Ok(self.nothing(node, "it takes flat children, not solids"))
            }
            (Operation::Projection, Piece::Solid(solid)) => {
                let shadow = corners::shadow(&solid, &mut self.allowance)
                    .map_err(|e| self.fault(node, &e))?;
                Ok(Piece::Flat(shadow))
            }
            (Operation::Projection, _) => Ok(self.nothing(node, "it takes solids")),
            (Operation::Resize(size, auto), piece) => self.resized(node, piece, size, auto),
            (_, piece) => Ok(piece),
        }
    }

    fn convex(&mut self, node: &NodeText<'_>, open: Open<'_>) -> Result<Piece, SceneError> {
        let (pieces, mixed) = pieces::alike(open.operands);
        if mixed {
            self.warn(node, MIXED.to_owned());
        }
        let is_hull = matches!(open.operation, Operation::Hull);
        match pieces {
            Pieces::Nothing => Ok(Piece::Nothing),
            Pieces::Flats(flats) if is_hull => Ok(Piece::Flat(csg::Profile::union(flats).hull())),
            Pieces::Flats(_) => {
                Err(self.fault(node, "Minkowski sums of flat shapes cannot be read"))
            }
            Pieces::Solids(solids) => {
                let solid = if is_hull {
                    corners::hull(&solids, &mut self.allowance)
                } else {
                    corners::minkowski(solids, &mut self.allowance)
                };
                let solid = solid.map_err(|e| self.fault(node, &e))?;
                self.made(node, solid)
            }
        }
    }

    fn resized(
        &mut self,
        node: &NodeText<'_>,
        piece: Piece,
        size: DVec3,
        auto: BVec3,
    ) -> Result<Piece, SceneError> {
        let bounds = match &piece {
            Piece::Nothing => return Ok(piece),
            Piece::Solid(solid) => {
                corners::bounds(solid, &mut self.allowance).map_err(|e| self.fault(node, &e))?
            }
            Piece::Flat(flat) => flat
                .bounds(1e-6)
                .map_err(|e| self.fault(node, &e.to_string()))?
                .map(|(min, max)| (min.extend(0.0), max.extend(1.0))),
        };
        let Some((min, max)) = bounds else {
            return Ok(Piece::Nothing);
        };
        let axes = if matches!(piece, Piece::Flat(_)) {
            2
        } else {
            3
        };
        let own = max - min;
        let mut scale = DVec3::ONE;
        let mut largest = 0;
        for axis in 0..axes {
            if size[axis] != 0.0 {
                scale[axis] = size[axis] / own[axis];
                if size[axis] > size[largest] {
                    largest = axis;
                }
            }
        }
        if size[largest] != 0.0 {
            let same = size[largest] / own[largest];
            for axis in 0..axes {
                if auto.test(axis) && size[axis] == 0.0 {
                    scale[axis] = same;
                }
            }
        }
        if !scale.is_finite() || scale.min_element() == 0.0 {
            return Ok(self.nothing(node, "the new size is not finite"));
        }
        let flat = DAffine2::from_scale(scale.truncate());
        Ok(piece.mapped(&DAffine3::from_scale(scale), &flat))
    }

    /// What a function of this node made, or what it says is wrong.
    pub(super) fn made(&mut self, node: &NodeText<'_>, solid: Solid) -> Result<Piece, SceneError> {
        if let Node::Made(Made {
            solid: Err(fault), ..
        }) = solid.node()
        {
            return Err(self.fault(node, &fault.to_string()));
        }
        Ok(Piece::of(solid))
    }

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
            Kind::LinearExtrude => Ok(Operation::Extrude(self.extrusion(node)?)),
            Kind::RotateExtrude => Ok(Operation::Revolve(self.revolution(node)?)),
            Kind::Offset => Ok(Operation::Offset(self.growth(node)?)),
            Kind::Projection => {
                let [cut, _] = self.arguments(node, &["cut", "convexity"])?;
                if self.flag(node, "cut", cut)? {
                    return Err(self.fault(node, "sections (`cut = true`) cannot be read"));
                }
                Ok(Operation::Projection)
            }
            Kind::Hull | Kind::Minkowski => {
                self.arguments(node, &["convexity"])?;
                if node.kind == Kind::Minkowski || !self.holds_balls_alone(node) {
                    self.faceted_until = self.faceted_until.max(node.end);
                }
                Ok(if node.kind == Kind::Hull {
                    Operation::Hull
                } else {
                    Operation::Minkowski
                })
            }
            Kind::Resize => self.resize(node),
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
            return Ok(Operation::Map(None, None));
        }
        if matrix.row(3) != DVec4::W {
            let problem =
                "a projective matrix: the last row must be 0, 0, 0 and a number that is not 0";
            return Err(self.fault(node, problem));
        }
        let map = DAffine3::from_mat4(matrix);
        let linear = map.matrix3;
        let lengths = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        let flat = DAffine2 {
            matrix2: DMat2::from_cols(linear.x_axis.truncate(), linear.y_axis.truncate()),
            translation: map.translation.truncate(),
        };
        let across = flat.matrix2.x_axis.length() * flat.matrix2.y_axis.length();
        // Below this not one correct digit is left of the inverse.
        let is_regular = |relative: f64| relative.abs() > 64.0 * f64::EPSILON;
        let solid = is_regular(linear.determinant() / lengths).then_some(map);
        let flat = is_regular(flat.matrix2.determinant() / across).then_some(flat);
        Ok(Operation::Map(solid, flat))
    }

    /// Whether all below a node are spheres: their hull is smooth.
    fn holds_balls_alone(&self, node: &NodeText<'_>) -> bool {
        let below = &self.tree.nodes[self.index..node.end];
        below
            .iter()
            .filter(|node| !node.background)
            .all(|node| match node.kind {
                Kind::Sphere => {
                    let arguments = &self.tree.arguments[node.arguments.clone()];
                    let fragments = arguments.iter().find(|a| a.key == Some("$fn"));
                    let fragments = fragments.and_then(|a| number(&a.value)).unwrap_or(0.0);
                    !(fragments > 0.0 && fragments <= 12.0)
                }
                Kind::Group | Kind::Union | Kind::Multmatrix | Kind::Color | Kind::Render => true,
                _ => false,
            })
    }

    fn resize(&mut self, node: &NodeText<'_>) -> Result<Operation, SceneError> {
        let [size, auto, _] = self.arguments(node, &["newsize", "auto", "convexity"])?;
        let size = size.and_then(|value| array(value, number));
        let auto = match auto {
            None => Some([0.0; 3]),
            Some(value) => array(value, |item| match item {
                Value::Bool(flag) => Some(f64::from(u8::from(*flag))),
                item => number(item),
            }),
        };
        let (Some(size), Some(auto)) = (size, auto) else {
            let problem = "it needs `newsize = [x, y, z]` and `auto = [x, y, z]`";
            return Err(self.fault(node, problem));
        };
        let auto = auto.map(|flag| flag != 0.0);
        Ok(Operation::Resize(
            DVec3::from_array(size),
            BVec3::from_array(auto),
        ))
    }

    /// Nothing, for a reason.
    pub(super) fn nothing(&mut self, node: &NodeText<'_>, problem: &str) -> Piece {
        self.warn(node, problem.to_owned() + NO_POINTS);
        Piece::Nothing
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

    fn leaf(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        match node.kind {
            Kind::Cube => self.cube(node),
            Kind::Sphere => self.sphere(node),
            Kind::Polyhedron => self.polyhedron(node),
            Kind::Circle => self.circle(node),
            Kind::Square => self.square(node),
            Kind::Polygon => self.polygon(node),
            _ => self.cylinder(node),
        }
    }

    fn polyhedron(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let keys = ["points", "faces", "triangles", "convexity"];
        let [points, faces, triangles, _] = self.arguments(node, &keys)?;
        let points = points.and_then(|value| list(value, |item| array(item, number)));
        let Some(points) = points else {
            return Err(self.fault(node, "it needs `points = [[x, y, z], ..]`"));
        };
        let index = |item: &Value| {
            let index = number(item)?;
            (0.0..u32::MAX.into())
                .contains(&index)
                .then_some(index as u32)
        };
        let faces = faces.or(triangles);
        let faces = faces.and_then(|value| list(value, |face| list(face, index)));
        let Some(mut faces) = faces else {
            return Err(self.fault(node, "it needs `faces = [[0, 1, 2], ..]`"));
        };
        self.facets(node, faces.len() as f64, faces.len() as f64)?;
        // Clockwise seen from outside.
        for face in &mut faces {
            face.reverse();
        }
        if points.is_empty() || faces.is_empty() {
            return Ok(self.nothing(node, "it has no faces"));
        }
        let points: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
        let mut solid = Solid::polyhedron(points.iter().copied(), &faces);
        if matches!(polyhedron_fault(&solid), Some(PolyhedronFault::Open { .. })) {
            solid = Solid::polyhedron(points.iter().copied().map(on_grid), &faces);
        }
        if matches!(polyhedron_fault(&solid), Some(PolyhedronFault::InsideOut)) {
            self.warn(node, "its faces are inside out: they are turned".to_owned());
            for face in &mut faces {
                face.reverse();
            }
            solid = Solid::polyhedron(points, faces);
        }
        self.made(node, solid)
    }

    fn cube(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [size, center] = self.arguments(node, &["size", "center"])?;
        let Some(size) = size.and_then(|value| array(value, number)) else {
            return Err(self.fault(node, "it needs `size = [x, y, z]`"));
        };
        let center = self.flag(node, "center", center)?;
        if !size.iter().all(|&side| is_size(side)) {
            return Ok(self.empty(node, "a side"));
        }
        let size = DVec3::from_array(size);
        Ok(Piece::Solid(if center {
            Solid::cuboid(size)
        } else {
            Solid::cuboid_between(DVec3::ZERO, size)
        }))
    }

    fn sphere(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [fn_, fa, fs, radius] = self.arguments(node, &["$fn", "$fa", "$fs", "r"])?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let radius = self.number(node, "r", radius)?;
        if !is_size(radius) {
            return Ok(self.empty(node, "the radius"));
        }
        if !(self.is_faceted() || fineness.is_polygon()) {
            return Ok(Piece::Solid(Solid::sphere(radius)));
        }
        let fragments = self.fragments(&fineness, radius);
        let facets = fragments * (0.5 * fragments).ceil();
        let fragments = self.facets(node, fragments, facets)?;
        let planes = facets::sphere(radius, fragments);
        Ok(Piece::Solid(Solid::convex_polyhedron(planes)))
    }

    fn cylinder(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
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
        if self.is_faceted() || fineness.is_polygon() {
            let fragments = self.fragments(&fineness, widest);
            let fragments = self.facets(node, fragments, fragments)?;
            let solid = facets::cylinder(bottom, top, z, fragments);
            return Ok(Piece::Solid(solid));
        }
        Ok(Piece::Solid(if bottom == top {
            Solid::cylinder(bottom, z)
        } else {
            Solid::frustum(bottom, top, z)
        }))
    }

    /// The values of the arguments with the given keys (an empty key: without
    /// one), in their order; an error for any other argument.
    pub(super) fn arguments<const N: usize>(
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

    pub(super) fn fineness(
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

    pub(super) fn number(
        &self,
        node: &NodeText<'_>,
        key: &str,
        value: Option<&Value>,
    ) -> Result<f64, SceneError> {
        value
            .and_then(number)
            .ok_or_else(|| self.fault(node, &format!("it needs a number `{key}`")))
    }

    pub(super) fn flag(
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
    pub(super) fn facets(
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

    pub(super) fn empty(&mut self, node: &NodeText<'_>, what: &str) -> Piece {
        let problem = format!("{what} is not positive and finite: it has no points");
        self.warn(node, problem);
        Piece::Nothing
    }

    pub(super) fn fault(&self, node: &NodeText<'_>, problem: &str) -> SceneError {
        SceneError::Argument {
            place: Place::of(self.tree.text, node.offset),
            node: node.name.to_owned(),
            problem: problem.to_owned(),
        }
    }

    fn warn(&mut self, node: &NodeText<'_>, problem: String) {
        if self.warnings.len() >= MOST_WARNINGS {
            return;
        }
        self.warnings.push(Warning {
            place: self.cursor.advance(self.tree.text, node.offset),
            node: node.name.to_owned(),
            problem,
        });
    }
}

/// What is wrong with a polyhedron's faces.
fn polyhedron_fault(solid: &Solid) -> Option<&PolyhedronFault> {
    match solid.node() {
        Node::Made(Made {
            solid: Err(NodeFault::Polyhedron(fault)),
            ..
        }) => Some(fault),
        _ => None,
    }
}

/// The nearest point of the grid on which OpenSCAD's vertices are one.
fn on_grid(point: DVec3) -> DVec3 {
    const PER_UNIT: f64 = (1 << 20) as f64;
    (point * PER_UNIT).round() / PER_UNIT
}

/// Whether OpenSCAD makes anything of this size.
pub(super) fn is_size(value: f64) -> bool {
    value > 0.0 && value.is_finite()
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
        if offset < self.offset {
            // What is said of a node when it ends.
            return Place::of(text, offset);
        }
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
