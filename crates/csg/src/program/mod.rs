//! The solid lowered: distinct surfaces and one Boolean formula over
//! half-space literals. No transforms and no shapes are left in it.

mod cell;
mod changes;
mod crossed;
mod extent;
mod formula;
mod given;
mod halved;
mod local;
mod lower;
mod lowered;
mod narrow;
mod outline;
mod parted;
mod placed;
mod reach;
mod settle;
mod uncut;
mod unify;

use std::fmt;
use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::error::Error;
use crate::solid::Solid;

pub(crate) use cell::Reach;
pub use cell::{Cell, Pruner};
pub(crate) use changes::Changes;
pub(crate) use given::{Ends, Given};
pub(crate) use narrow::{Crown, Narrowed, Narrower};
pub(crate) use outline::{Named, Outline};
pub(crate) use settle::Settled;
pub(crate) use uncut::Uncut;

pub use crate::surface::{Bounds, Placement, Side, Surface, SurfaceShape};
pub(crate) use crate::surface::{Kind, StandardForm, SurfaceId, line_roots, roots_between};
pub use formula::{Formula, Gate, Literal, Operand, Operation};
use lower::First;
use lowered::Lowered;
pub use lowered::Origin;

/// A lowered solid; made only by [`Program::lower`], so that every later stage
/// may rely on finite, normalised, canonical surfaces.
///
/// `Display` prints it in a form for people: the surfaces with their
/// equations, then the formula.
///
/// Polyhedra of many faces are put on half-spaces when these are first asked for: a mesh
/// needs only those of faces that something else is near.
#[derive(Clone, Debug)]
pub struct Program {
    lowered: OnceLock<Lowered>,
    /// The solid with its large polyhedra as literals, if it has any.
    outline: Option<Arc<Outline>>,
    apart: OnceLock<Option<Arc<Apart>>>,
}

/// A solid taken apart: the faces of its polyhedra that nothing comes near, and the rest.
#[derive(Debug)]
pub(crate) struct Apart {
    pub uncut: Uncut,
    /// A solid of which only the faces on some surfaces are meant.
    pub rest: Program,
}

impl Program {
    fn of(lowered: Lowered) -> Self {
        Self {
            lowered: OnceLock::from(lowered),
            outline: None,
            apart: OnceLock::new(),
        }
    }

    /// The same with all polyhedra on half-spaces from the beginning.
    #[cfg(test)]
    pub(crate) fn expanded(&self) -> Self {
        Self::of(self.lowered().clone())
    }

    /// Lowers a solid. Time and memory are linear in the number of nodes, a
    /// subtree that several others share counting once per distinct transform,
    /// name and colour (times the logarithm of the number of surfaces).
    ///
    /// # Errors
    /// [`Error::InvalidNode`] names the first node with bad arguments.
    pub fn lower(solid: &Solid) -> Result<Self, Error> {
        let outline = match First::of(solid)? {
            First::Lowered(lowered) => return Ok(Self::of(lowered)),
            First::Placed(regions, others, surfaces) => {
                Outline::new(solid, regions, others, surfaces)?
            }
        };
        // A huge one before anything is asked of it: its formula may be too long.
        let whole = outline.is_huge().then(|| outline.lowered()).transpose()?;
        Ok(Self {
            lowered: whole.map_or_else(OnceLock::new, OnceLock::from),
            outline: Some(Arc::new(outline)),
            apart: OnceLock::new(),
        })
    }

    fn lowered(&self) -> &Lowered {
        self.lowered.get_or_init(|| match &self.outline {
            Some(outline) => outline.whole(),
            None => Lowered::NOTHING,
        })
    }

    /// The canonical surfaces; literals name them by index.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.lowered().surfaces
    }

    /// The first of the surfaces: those that may carry faces, which are all but those that
    /// only part space between faces of large polyhedra. A mesh names only these; they are known
    /// at once, where the others are made when [`Self::surfaces`] asks for them.
    #[must_use]
    pub fn carriers(&self) -> &[Surface] {
        match &self.outline {
            Some(outline) => outline.carriers(),
            None => self.surfaces(),
        }
    }

    /// Whether all surfaces that may carry faces are planes.
    #[must_use]
    pub fn is_polyhedral(&self) -> bool {
        self.carriers().iter().all(Surface::is_plane)
    }

    /// The solid taken apart; none if too few faces are uncut for that.
    pub(crate) fn apart(&self) -> Option<&Apart> {
        let apart = self.apart.get_or_init(|| {
            let (uncut, rest) = Uncut::of(self.outline.as_deref()?)?;
            let rest = Self::of(rest);
            Some(Arc::new(Apart { uncut, rest }))
        });
        apart.as_deref()
    }

    /// The solid with its large polyhedra as literals, if it has any.
    pub(crate) fn outline(&self) -> Option<&Outline> {
        self.outline.as_deref()
    }

    /// Whether its formula is pruned from its root on: it has large polyhedra.
    pub(crate) fn is_deep(&self) -> bool {
        self.outline.is_some() || self.given().is_some()
    }

    /// The edges and vertices of polyhedra.
    pub(crate) fn given(&self) -> Option<&Given> {
        self.lowered().given.as_deref()
    }

    /// The Boolean formula over literals.
    #[must_use]
    pub fn formula(&self) -> &Formula {
        &self.lowered().formula
    }

    /// The primitives that literals come from; literals name them by index.
    #[must_use]
    pub fn origins(&self) -> &[Origin] {
        match &self.outline {
            Some(outline) => outline.origins(),
            None => &self.lowered().origins,
        }
    }

    /// A box around the solid from those of its primitives, if these have an end.
    fn reach(&self) -> Bounds {
        match &self.outline {
            Some(outline) => outline.reach(),
            None => self.lowered().reach,
        }
    }

    /// Whether `point` lies in the solid: the scalar reference that every
    /// faster path is held against. On the boundary itself either answer may
    /// come. Costs one evaluation of every surface and gate; of a large polyhedron of n faces,
    /// whose faces on one side of the point are counted, about log n steps.
    #[must_use]
    pub fn contains(&self, point: impl Into<DVec3>) -> bool {
        let point = point.into();
        if let Some(outline) = &self.outline {
            return outline.contains(point);
        }
        if self.given().is_some() {
            let is_inside = |surface: u32| self.surfaces()[surface as usize].value(point) <= 0.0;
            return Narrower::default().evaluate(self.formula(), is_inside);
        }
        let inside: Vec<bool> = self
            .surfaces()
            .iter()
            .map(|surface| surface.value(point) <= 0.0)
            .collect();
        self.formula().evaluate(&inside)
    }

    /// The whole program as a cell: every surface, nothing pruned.
    #[must_use]
    pub fn root_cell(&self) -> Cell {
        Cell {
            surfaces: (0..self.surfaces().len() as u32).collect(),
            formula: self.formula().clone(),
        }
    }

    /// The program's surfaces as seen from `origin`: every anchor moved, so
    /// that coordinates relative to `origin` keep their digits.
    pub(crate) fn surfaces_about(&self, origin: DVec3) -> Vec<Surface> {
        self.surfaces()
            .iter()
            .map(|surface| surface.relative_to(origin))
            .collect()
    }
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, surface) in self.surfaces().iter().enumerate() {
            writeln!(f, "s{i}: {surface} <= 0")?;
        }
        write!(f, "{}", self.formula())
    }
}
