//! The solid lowered: distinct surfaces and one Boolean formula over
//! half-space literals. No transforms and no shapes are left in it.

mod cell;
mod changes;
mod extent;
mod formula;
mod given;
mod local;
mod lower;
mod narrow;
mod reach;
mod region;
mod settle;
mod unify;

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::color::Color;

pub(crate) use cell::Reach;
pub use cell::{Cell, Pruner};
pub(crate) use changes::Changes;
pub(crate) use given::{Ends, Given};
pub(crate) use narrow::{Crown, Narrowed, Narrower};
pub(crate) use settle::Settled;

pub use crate::surface::{Bounds, Placement, Side, Surface, SurfaceShape};
pub(crate) use crate::surface::{Kind, StandardForm, roots_between};
pub use formula::{Formula, Gate, Literal, Operand, Operation};

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

/// A lowered solid; made only by [`Program::lower`], so that every later stage
/// may rely on finite, normalised, canonical surfaces.
///
/// `Display` prints it in a form for people: the surfaces with their
/// equations, then the formula.
#[derive(Clone, Debug)]
pub struct Program {
    surfaces: Vec<Surface>,
    formula: Formula,
    origins: Vec<Origin>,
    /// A box around the solid from those of its primitives, if these have an end.
    reach: Bounds,
    /// The edges and vertices of polyhedra, if there are any of many faces.
    given: Option<Arc<Given>>,
}

impl Program {
    /// The canonical surfaces; literals name them by index.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The edges and vertices of polyhedra.
    pub(crate) fn given(&self) -> Option<&Given> {
        self.given.as_deref()
    }

    /// The Boolean formula over literals.
    #[must_use]
    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    /// The primitives that literals come from; literals name them by index.
    #[must_use]
    pub fn origins(&self) -> &[Origin] {
        &self.origins
    }

    /// Whether `point` lies in the solid: the scalar reference that every
    /// faster path is held against. On the boundary itself either answer may
    /// come. Costs one evaluation of every surface and gate, but of large polyhedra only of
    /// those that are near.
    #[must_use]
    pub fn contains(&self, point: impl Into<DVec3>) -> bool {
        let point = point.into();
        if self.given.is_some() {
            let is_inside = |surface: u32| self.surfaces[surface as usize].value(point) <= 0.0;
            return Narrower::default().evaluate(&self.formula, is_inside);
        }
        let inside: Vec<bool> = self
            .surfaces
            .iter()
            .map(|surface| surface.value(point) <= 0.0)
            .collect();
        self.formula.evaluate(&inside)
    }

    /// The whole program as a cell: every surface, nothing pruned.
    #[must_use]
    pub fn root_cell(&self) -> Cell {
        Cell {
            surfaces: (0..self.surfaces.len() as u32).collect(),
            formula: self.formula.clone(),
        }
    }

    /// The program's surfaces as seen from `origin`: every anchor moved, so
    /// that coordinates relative to `origin` keep their digits.
    pub(crate) fn surfaces_about(&self, origin: DVec3) -> Vec<Surface> {
        self.surfaces
            .iter()
            .map(|surface| surface.relative_to(origin))
            .collect()
    }
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, surface) in self.surfaces.iter().enumerate() {
            writeln!(f, "s{i}: {surface} <= 0")?;
        }
        write!(f, "{}", self.formula)
    }
}
