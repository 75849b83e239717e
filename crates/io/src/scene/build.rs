//! Meaning: from the text's nodes to a solid.

use std::f64::consts::PI;

use csg::corners::Faceting;
use csg::{Made, Node, Solid, elementary};
use text::Fonts;

use super::error::{Place, SceneError, Warning};
use super::facets::Fineness;
use super::operations::Operation;
use super::parse::{NodeText, Tree};
use super::pieces::{self, MIXED, Piece};
use super::{ReadOptions, Scene};

/// The most facets that one scene may have: half a gigabyte of planes.
const MOST_FACETS: f64 = (1 << 24) as f64;
/// Circles have at least so many fragments where a smooth reading has to facet
/// them for a hull or a Minkowski sum.
const FRAGMENTS: f64 = 30.0;

/// And at most so many, however near they are to be: more corners are more work.
const MOST_FRAGMENTS: f64 = 360.0;

/// More warnings than this help nobody.
const MOST_WARNINGS: usize = 1000;
/// What becomes of a node that something is wrong with.
const NO_POINTS: &str = ": it has no points";

pub(super) fn build(tree: &Tree<'_>, options: &ReadOptions) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        tree,
        options,
        faceted_until: 0,
        index: 0,
        has_chords: false,
        strays: None,
        stretch: 1.0,
        facets: 0.0,
        faceting: Faceting::new(),
        fonts: None,
        warnings: Vec::new(),
        cursor: Cursor::default(),
    };
    let mut open = vec![Open {
        operation: Operation::Union,
        stretch: 1.0,
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
            let stretch = builder.stretch;
            builder.stretch *= operation.stretch();
            open.push(Open {
                operation,
                stretch,
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
pub(super) struct Open<'a> {
    pub(super) operation: Operation,
    /// By how much the maps around it make lengths longer.
    stretch: f64,
    /// None for the root.
    node: Option<&'a NodeText<'a>>,
    end: usize,
    /// Whether a colour is set here or further out: then it wins.
    colored: bool,
    pub(super) operands: Vec<Piece>,
}

pub(super) struct Builder<'a> {
    pub(super) tree: &'a Tree<'a>,
    pub(super) options: &'a ReadOptions,
    /// Nodes before this one are read faceted, whatever the options say.
    pub(super) faceted_until: usize,
    /// The next node.
    pub(super) index: usize,
    /// Whether polygons were put in place of circles since it was last told.
    has_chords: bool,
    /// How far flat shapes, and what corners of polygons for circles make, stray from what they
    /// stand for, since it was last told.
    pub(super) strays: Option<f64>,
    /// By how much the maps around the next node make lengths longer.
    stretch: f64,
    /// Facets made so far.
    facets: f64,
    /// What may still be meshed.
    pub(super) faceting: Faceting,
    /// Loaded when the first text is read.
    pub(super) fonts: Option<Fonts>,
    warnings: Vec<Warning>,
    cursor: Cursor,
}

impl Builder<'_> {
    /// Whether circles are polygons here.
    pub(super) fn is_faceted(&self) -> bool {
        self.options.faceted || self.index <= self.faceted_until
    }

    /// The fragments of a circle that is read as a polygon.
    pub(super) fn fragments(&mut self, fineness: &Fineness, radius: f64) -> f64 {
        let fragments = fineness.fragments(radius);
        if self.options.faceted || fineness.is_polygon() {
            fragments
        } else {
            self.has_chords = true;
            let needed = self.within().map_or(0.0, |within| {
                let half = elementary::acos((1.0 - within / radius).clamp(0.0, 1.0));
                (PI / half).ceil().min(MOST_FRAGMENTS)
            });
            let fragments = fragments.max(FRAGMENTS).max(needed);
            self.strayed(radius * (1.0 - elementary::cos(PI / fragments)));
            fragments
        }
    }

    /// How far chords and flat faces may stray in the coordinates of the next node, if the options
    /// say.
    pub(super) fn within(&self) -> Option<f64> {
        self.options.within.map(|within| within / self.stretch)
    }

    /// Notes how far what was made strays from what it stands for, until it is a solid.
    pub(super) fn strayed(&mut self, by: f64) {
        self.strays = Some(self.strays.map_or(by, |before| before.max(by)));
    }

    /// A solid made of what strayed.
    pub(super) fn standing_in(&mut self, solid: Solid) -> Solid {
        match self.strays.take() {
            Some(strays) => solid.standing_in(strays),
            None => solid,
        }
    }

    /// What a node comes to when its children are there.
    fn close(&mut self, open: Open<'_>) -> Result<Piece, SceneError> {
        self.stretch = open.stretch;
        let operation = match open.operation {
            Operation::Intersection => pieces::intersection,
            Operation::Difference => pieces::difference,
            _ => pieces::union,
        };
        let of_union = !matches!(open.operation, Operation::Hull | Operation::Minkowski);
        let Some(node) = open.node else {
            return Ok(operation(open.operands).0);
        };
        if !of_union && std::mem::take(&mut self.has_chords) {
            let problem = format!(
                "circles in it are taken for polygons of {FRAGMENTS} corners, or $fn if that is more"
            );
            self.warn(node, problem);
        }
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
                let shadow = self.of_corners(node, |faceting| solid.projection(faceting))?;
                Ok(Piece::Flat(shadow))
            }
            (Operation::Section, Piece::Solid(solid)) => {
                let section = self.of_corners(node, |faceting| solid.faceted_section(faceting))?;
                self.flat(node, section)
            }
            (Operation::Projection | Operation::Section, _) => {
                Ok(self.nothing(node, "it takes solids"))
            }
            (Operation::Resize(size, auto), piece) => self.resized(node, piece, size, auto),
            (_, piece) => Ok(piece),
        }
    }

    /// What comes of the corners of solids; with a warning if any were of curved surfaces.
    pub(super) fn of_corners<T>(
        &mut self,
        node: &NodeText<'_>,
        of: impl Fn(&mut Faceting) -> Result<T, csg::Error>,
    ) -> Result<T, SceneError> {
        let before = self.faceting.clone();
        self.faceting = before.clone().to(self.within());
        let mut made = of(&mut self.faceting);
        if made.is_err() && self.options.within.is_some() {
            // What is as near as that may be too much work.
            self.faceting = before.to(None);
            made = of(&mut self.faceting);
        }
        let made = made.map_err(|e| self.fault(node, &e.to_string()))?;
        if let Some(within) = self.faceting.take_strayed() {
            let problem = format!(
                "what is curved in it is taken for faces and edges within {within:.0e} of it"
            );
            self.warn(node, problem);
            self.strayed(within);
        }
        Ok(made)
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

    /// Nothing, for a reason.
    pub(super) fn nothing(&mut self, node: &NodeText<'_>, problem: &str) -> Piece {
        self.warn(node, problem.to_owned() + NO_POINTS);
        Piece::Nothing
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

    pub(super) fn warn(&mut self, node: &NodeText<'_>, problem: String) {
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
