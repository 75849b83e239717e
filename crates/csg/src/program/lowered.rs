//! What a solid is lowered to.

use std::sync::Arc;

use super::formula::Formula;
use super::given::Given;
use crate::color::Color;
use crate::surface::{Bounds, Surface};

/// Where a literal comes from: one primitive of the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The primitive's kind, in the words of the authoring functions.
    pub kind: &'static str,
    /// The number, from 1, of the outermost body around the primitive that a function made of
    /// primitives, such as an extrusion or a hull; 0 if there is none.
    pub body: u32,
    /// The innermost name around the primitive.
    pub name: Option<Arc<str>>,
    /// The names around that one, the outermost first: the parts that it is within. Of more
    /// than fifteen the innermost are left out; a name straight within the same one is that one.
    pub parts: Arc<[Arc<str>]>,
    /// The innermost colour around the primitive.
    pub color: Option<Color>,
}

impl Origin {
    /// Whether what comes from two primitives need not be told apart where it lies on one
    /// surface, whichever bodies they are part of.
    pub(crate) fn looks_like(&self, other: &Self) -> bool {
        self.kind == other.kind
            && self.name == other.name
            && self.parts == other.parts
            && self.color == other.color
    }
}

/// Surfaces, and a formula over their half-spaces.
#[derive(Clone, Debug)]
pub(super) struct Lowered {
    pub surfaces: Vec<Surface>,
    pub formula: Formula,
    pub origins: Vec<Origin>,
    /// A box around the solid from those of its primitives, if these have an end.
    pub reach: Bounds,
    /// The edges and vertices of polyhedra, if there are any of many faces.
    pub given: Option<Arc<Given>>,
}

impl Lowered {
    pub const NOTHING: Self = Self {
        surfaces: Vec::new(),
        formula: Formula::NOTHING,
        origins: Vec::new(),
        reach: Bounds::NOTHING,
        given: None,
    };
}
