//! Nodes with children: what their arguments say, and what becomes of hulls,
//! sums and new sizes.

use std::ops::Range;

use csg::{Color, Profile, Solid, corners, stretch};
use glam::{BVec2, BVec3, DAffine2, DAffine3, DMat2, DMat3, DMat4, DVec2, DVec3, DVec4};

use super::build::{Builder, Open};
use super::error::SceneError;
use super::flat::{Extrusion, Growth, Revolution};
use super::parse::{Kind, NodeText, Value};
use super::pieces::{self, MIXED, Piece, Pieces};
use super::values::{array, number, text};

/// What a node does with its children, mostly with their union.
pub(super) enum Operation {
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
    /// The plane z = 0 of it.
    Section,
    Hull,
    Minkowski,
    /// To a size where it is not 0; as much as that along the axes that are so
    /// marked.
    Resize(DVec3, BVec3),
}

impl Operation {
    /// By how much it makes lengths longer at most, as far as its arguments tell.
    pub(super) fn stretch(&self) -> f64 {
        match self {
            Self::Map(Some(map), _) => stretch(map),
            Self::Extrude(extrusion) => extrusion.widest(),
            _ => 1.0,
        }
    }
}

/// Whether a node holds others as they are, or puts them elsewhere.
fn is_bracket(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Group | Kind::Union | Kind::Multmatrix | Kind::Color | Kind::Render
    )
}

/// A matrix of which the last number is 1.
fn matrix_of(value: &Value) -> Option<DMat4> {
    let rows: [[f64; 4]; 4] = array(value, |row| array(row, number))?;
    let matrix = DMat4::from_cols_array_2d(&rows).transpose();
    Some(matrix * (1.0 / matrix.w_axis.w))
}

impl Builder<'_> {
    /// What a node with children does.
    pub(super) fn operation(
        &mut self,
        node: &NodeText<'_>,
        colored: bool,
    ) -> Result<Operation, SceneError> {
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
                Ok(if self.flag(node, "cut", cut)? {
                    Operation::Section
                } else {
                    Operation::Projection
                })
            }
            Kind::Hull | Kind::Minkowski => {
                self.arguments(node, &["convexity"])?;
                let is_smooth = match node.kind {
                    Kind::Hull => {
                        self.holds_balls_alone(node)
                            || self.is_flat(self.index..node.end)
                            || self.holds_parallel_circles(node)
                    }
                    _ => self.sums_smoothly(node),
                };
                if !is_smooth {
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
        let Some(matrix) = matrix.and_then(matrix_of) else {
            return Err(self.fault(node, "it needs a matrix: four rows of four numbers"));
        };
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
        self.below(self.index..node.end).all(|node| {
            node.kind == Kind::Sphere && !self.is_polygon(node) || is_bracket(node.kind)
        })
    }

    /// Whether all below a node are cylinders and extruded circles in parallel planes, one at least,
    /// and what has flat faces: their hull is smooth.
    fn holds_parallel_circles(&self, node: &NodeText<'_>) -> bool {
        let mut maps: Vec<(usize, DMat3)> = Vec::new();
        let mut normal = None;
        let mut index = self.index;
        while let Some(below) = self.tree.nodes[..node.end].get(index) {
            while maps.pop_if(|(end, _)| *end <= index).is_some() {}
            index += 1;
            if below.background {
                index = below.end;
                continue;
            }
            let map = maps.last().map_or(DMat3::IDENTITY, |(_, map)| *map);
            match below.kind {
                Kind::Multmatrix => {
                    let arguments = &self.tree.arguments[below.arguments.clone()];
                    let matrix = arguments.first().and_then(|a| matrix_of(&a.value));
                    let Some(matrix) = matrix else { return false };
                    maps.push((below.end, map * DMat3::from_mat4(matrix)));
                }
                Kind::Cylinder | Kind::Circle if !self.is_polygon(below) => {
                    let Some((own, _)) = corners::circles(map, DVec2::ONE) else {
                        return false;
                    };
                    if !corners::are_parallel(own, *normal.get_or_insert(own)) {
                        return false;
                    }
                }
                Kind::Cube
                | Kind::Polyhedron
                | Kind::Cylinder
                | Kind::Square
                | Kind::Polygon
                | Kind::Circle
                | Kind::LinearExtrude => {}
                Kind::Sphere if self.is_polygon(below) => {}
                kind if is_bracket(kind) => {}
                _ => return false,
            }
        }
        normal.is_some()
    }

    /// Whether a Minkowski sum is smooth.
    fn sums_smoothly(&self, node: &NodeText<'_>) -> bool {
        let mut children = Vec::new();
        let mut index = self.index;
        while let Some(child) = self.tree.nodes[..node.end].get(index) {
            if !child.background {
                children.push(index..child.end);
            }
            index = child.end;
        }
        self.sums_with_balls(&children)
            || self.sums_with_circles(&children)
            || self.sums_columns(node)
    }

    /// Whether all below a node are boxes and cylinders with parallel axes.
    fn sums_columns(&self, node: &NodeText<'_>) -> bool {
        let is_column = |node: &NodeText<'_>| {
            matches!(node.kind, Kind::Cube | Kind::Cylinder) || is_bracket(node.kind)
        };
        self.below(self.index..node.end).all(is_column) && self.holds_parallel_circles(node)
    }

    /// Whether children are each made of nothing but spheres, or of nothing but flat faces: what
    /// is rounded so is smooth.
    fn sums_with_balls(&self, children: &[Range<usize>]) -> bool {
        let is_ball = |node: &NodeText<'_>| {
            node.kind == Kind::Sphere && !self.is_polygon(node) || is_bracket(node.kind)
        };
        let is_flat = |node: &NodeText<'_>| match node.kind {
            Kind::Cube | Kind::Polyhedron => true,
            Kind::Sphere | Kind::Cylinder => self.is_polygon(node),
            kind => is_bracket(kind),
        };
        children.iter().all(|child| {
            let all = || self.below(child.clone());
            all().all(is_ball) || all().all(is_flat)
        })
    }

    /// Whether children are flat shapes, all but one of them one circle each, which move the
    /// outline of that one.
    fn sums_with_circles(&self, children: &[Range<usize>]) -> bool {
        let is_circle = |node: &NodeText<'_>| node.kind == Kind::Circle && !self.is_polygon(node);
        let is_one_circle = |child: &&Range<usize>| {
            let mut shapes = self
                .below((*child).clone())
                .filter(|node| !is_bracket(node.kind));
            shapes.next().is_some_and(is_circle) && shapes.next().is_none()
        };
        let circles = children.iter().filter(is_one_circle).count();
        circles + 1 >= children.len() && children.iter().all(|child| self.is_flat(child.clone()))
    }

    /// Whether nodes are flat shapes, their circles none that are polygons.
    fn is_flat(&self, nodes: Range<usize>) -> bool {
        self.below(nodes).all(|node| match node.kind {
            Kind::Square
            | Kind::Polygon
            | Kind::Text
            | Kind::Offset
            | Kind::Difference
            | Kind::Intersection => true,
            Kind::Circle => !self.is_polygon(node),
            kind => is_bracket(kind),
        })
    }

    fn below(&self, nodes: Range<usize>) -> impl Iterator<Item = &NodeText<'_>> {
        let below = self.tree.nodes[nodes].iter();
        below.filter(|node| !node.background)
    }

    /// Whether the text asks for a polygon in place of the circles of a primitive.
    fn is_polygon(&self, node: &NodeText<'_>) -> bool {
        let arguments = &self.tree.arguments[node.arguments.clone()];
        let fragments = arguments.iter().find(|a| a.key == Some("$fn"));
        let fragments = fragments.and_then(|a| number(&a.value)).unwrap_or(0.0);
        fragments > 0.0 && fragments <= 12.0
    }

    fn resize(&mut self, node: &NodeText<'_>) -> Result<Operation, SceneError> {
        let [size, auto, _] = self.arguments(node, &["newsize", "auto", "convexity"])?;
        // (Of flat shapes two do.)
        let size = size.and_then(|value| {
            let flat = || array(value, number).map(|[x, y]| [x, y, 0.0]);
            array(value, number).or_else(flat)
        });
        let flag = |item: &Value| match item {
            Value::Bool(flag) => Some(*flag),
            item => number(item).map(|number| number != 0.0),
        };
        let auto = match auto {
            None | Some(Value::Undefined) => Some([false; 3]),
            // One for all axes, or each its own.
            Some(value) => flag(value)
                .map(|flag| [flag; 3])
                .or_else(|| array(value, flag))
                .or_else(|| array(value, flag).map(|[x, y]| [x, y, false])),
        };
        let (Some(size), Some(auto)) = (size, auto) else {
            let problem = "it needs `newsize = [x, y, z]` or [x, y], and `auto`, if it is given, as \
                           one flag or so many";
            return Err(self.fault(node, problem));
        };
        Ok(Operation::Resize(
            DVec3::from_array(size),
            BVec3::from_array(auto),
        ))
    }

    /// By numbers, by name or in hexadecimal digits, as style sheets have them; `alpha` is more than
    /// either says.
    fn color(&mut self, node: &NodeText<'_>) -> Result<Option<Color>, SceneError> {
        let [color, alpha] = self.arguments(node, &["c", "alpha"])?;
        let rgba = color.and_then(|value| match text(value) {
            Some(name) => {
                let parsed = csscolorparser::parse(name).ok()?;
                Some([parsed.r, parsed.g, parsed.b, parsed.a].map(f64::from))
            }
            None => array(value, number).or_else(|| {
                let [r, g, b] = array(value, number)?;
                Some([r, g, b, 1.0])
            }),
        });
        let Some(mut rgba) = rgba.filter(|rgba: &[f64; 4]| rgba.iter().all(|c| c.is_finite()))
        else {
            let problem = "it needs a colour: [red, green, blue, alpha], each from 0 to 1; or a name, or #rrggbb";
            return Err(self.fault(node, problem));
        };
        if let Some(alpha) = alpha {
            rgba[3] = self.number(node, "alpha", Some(alpha))?;
        }
        if rgba.iter().any(|&component| component < 0.0) {
            return Ok(None);
        }
        let [r, g, b, alpha] = rgba.map(|component| component.min(1.0) as f32);
        Ok(Some(Color::from_srgb([r, g, b]).with_alpha(alpha)))
    }

    pub(super) fn convex(
        &mut self,
        node: &NodeText<'_>,
        open: Open<'_>,
    ) -> Result<Piece, SceneError> {
        let (pieces, mixed) = pieces::alike(open.operands);
        if mixed {
            self.warn(node, MIXED.to_owned());
        }
        let is_hull = matches!(open.operation, Operation::Hull);
        match pieces {
            Pieces::Nothing => Ok(Piece::Nothing),
            Pieces::Flats(flats) if is_hull => {
                let flat = Profile::union(flats);
                Ok(Piece::Flat(match flat.exact_hull() {
                    Some(hull) => hull,
                    None => self.in_chords(node, &flat)?.hull(),
                }))
            }
            Pieces::Flats(flats) => {
                let sum = self.of_corners(node, |faceting| {
                    Profile::minkowski_sum(flats.clone(), faceting)
                })?;
                self.flat(node, sum)
            }
            Pieces::Solids(solids) => {
                let solid = self.of_corners(node, |faceting| {
                    if is_hull {
                        Solid::hull_of(&solids, faceting)
                    } else {
                        Solid::minkowski_sum(solids.clone(), faceting)
                    }
                })?;
                let solid = self.standing_in(solid);
                self.made(node, solid)
            }
        }
    }

    pub(super) fn resized(
        &mut self,
        node: &NodeText<'_>,
        piece: Piece,
        size: DVec3,
        auto: BVec3,
    ) -> Result<Piece, SceneError> {
        if !size.is_finite() {
            return Ok(self.nothing(node, "the new size is not finite"));
        }
        match &piece {
            Piece::Nothing => Ok(piece),
            Piece::Solid(solid) => {
                let resized =
                    self.of_corners(node, |faceting| solid.resized(size, auto, faceting))?;
                Ok(Piece::of(self.standing_in(resized)))
            }
            Piece::Flat(flat) => {
                let resized = flat.resized(size.truncate(), BVec2::new(auto.x, auto.y));
                let resized = resized.map_err(|e| self.fault(node, &e.to_string()))?;
                self.flat(node, resized)
            }
        }
    }
}
