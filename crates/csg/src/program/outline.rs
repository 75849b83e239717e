//! A solid with its polyhedra of many faces as literals: what is known of it before these
//! are put on half-spaces.

use std::sync::OnceLock;

use glam::DVec3;

use super::cell::Cell;
use super::lower::{Finished, Renumbered, lowered_with};
use super::lowered::{Lowered, Origin};
use super::placed::{Convex, IsNeeded, Placed, Polyhedra, Region};
use crate::error::Error;
use crate::mesh::Shells;
use crate::numeric::tolerance::NEAR;
use crate::solid::Solid;
use crate::surface::{Bounds, Side, Surface};

/// A solid with its large polyhedra as literals.
#[derive(Debug)]
pub(crate) struct Outline {
    solid: Solid,
    pub(super) regions: Vec<Region>,
    pub(super) others: Vec<Convex>,
    /// The formula, and what it names: surfaces, and behind these regions.
    cell: Cell,
    origins: Vec<Origin>,
    reach: Bounds,
    /// All but those that only part space.
    surfaces: Vec<Surface>,
    shells: OnceLock<Shells>,
}

/// Beyond so many triangles formulas may have more gates than there are numbers for.
const MANY_TRIANGLES: usize = 4_000_000;

impl Outline {
    /// Of a solid whose primitives are in place.
    pub(super) fn new(
        solid: &Solid,
        regions: Vec<Region>,
        others: Vec<Convex>,
        surfaces: Vec<Surface>,
    ) -> Result<Self, Error> {
        let mut outline = Self {
            solid: solid.clone(),
            regions,
            others,
            cell: Cell::default(),
            origins: Vec::new(),
            reach: Bounds::NOTHING,
            surfaces,
            shells: OnceLock::new(),
        };
        let lowered = lowered_with(solid, Polyhedra::Outlined(outline.placed()))?.lowered;
        let mut formula = lowered.formula;
        let names = outline.surfaces.len() + outline.regions.len();
        outline.cell = Cell {
            surfaces: Renumbered::of(&mut formula, names).ids,
            formula,
        };
        (outline.origins, outline.reach) = (lowered.origins, lowered.reach);
        Ok(outline)
    }

    pub(super) fn placed(&self) -> Placed<'_> {
        Placed {
            surfaces: &self.surfaces,
            regions: &self.regions,
            others: &self.others,
        }
    }

    /// Whether its formula may be too long.
    pub fn is_huge(&self) -> bool {
        let triangles = self.regions.iter().map(|region| region.triangles.len());
        triangles.sum::<usize>() > MANY_TRIANGLES
    }

    pub fn carriers(&self) -> &[Surface] {
        &self.surfaces
    }

    pub fn origins(&self) -> &[Origin] {
        &self.origins
    }

    pub fn reach(&self) -> Bounds {
        self.reach
    }

    /// The solid on half-spaces.
    pub(super) fn lowered(&self) -> Result<Lowered, Error> {
        Ok(self.written(None)?.lowered)
    }

    /// The same of one that is not huge, which has room.
    pub(super) fn whole(&self) -> Lowered {
        self.lowered().unwrap_or(Lowered::NOTHING)
    }

    /// The solid with its polyhedra written as formulas, where they are needed.
    pub(super) fn written(&self, is_needed: Option<IsNeeded<'_>>) -> Result<Finished, Error> {
        lowered_with(&self.solid, Polyhedra::Written(self.placed(), is_needed))
    }

    /// Things nearer to a polyhedron touch it, as far as any stage can tell.
    pub fn margin(&self) -> f64 {
        let vertices = self.regions.iter().flat_map(|region| &region.vertices);
        NEAR * vertices.map(|v| v.abs().max_element()).fold(0.0, f64::max)
    }

    /// The polyhedra as shells, their boxes grown by the margin.
    pub fn shells(&self) -> &Shells {
        let shells = self.regions.iter().map(|region| {
            let triangles = region.triangles.iter();
            triangles.map(|&triangle| region.corners(triangle))
        });
        self.shells
            .get_or_init(|| Shells::new(shells, self.margin()))
    }

    /// The formula, and what it names.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// What the formula names.
    pub fn named(&self, name: u32) -> Named {
        match self.surfaces.get(name as usize) {
            Some(surface) => Named::Surface(*surface),
            None => Named::Region(name - self.surfaces.len() as u32),
        }
    }

    /// On which side of a surface or region a box is.
    pub fn side_of_box(&self, name: u32, center: DVec3, half: DVec3) -> Side {
        match self.named(name) {
            Named::Surface(surface) => surface.side_of_box(center, half),
            Named::Region(region)
                if self.shells().meets(region, [center - half, center + half]) =>
            {
                Side::Crossing
            }
            Named::Region(region) if self.shells().contains(region, center) => Side::Inside,
            Named::Region(_) => Side::Outside,
        }
    }

    /// Tells of each place of the list of names that says something a point is in, but for
    /// one region.
    pub fn insides(&self, point: DVec3, but: Option<u32>, tell: &mut impl FnMut(usize)) {
        let names = &self.cell.surfaces;
        let first = names.partition_point(|&name| (name as usize) < self.surfaces.len());
        for (place, &name) in names[..first].iter().enumerate() {
            if self.surfaces[name as usize].value(point) <= 0.0 {
                tell(place);
            }
        }
        self.shells().around(point, &mut |region| {
            if but != Some(region)
                && let Some(place) = self.place_of(region)
            {
                tell(place);
            }
        });
    }

    /// Where a region is in the list of names.
    pub fn place_of(&self, region: u32) -> Option<usize> {
        let place = self.cell.position_of(self.surfaces.len() as u32 + region);
        place.map(|place| place as usize)
    }

    /// Whether a point lies in the solid.
    pub fn contains(&self, point: DVec3) -> bool {
        let mut inside = vec![false; self.cell.surfaces.len()];
        self.insides(point, None, &mut |place| inside[place] = true);
        self.cell.formula.evaluate(&inside)
    }
}

/// What a literal of an outline is about.
pub(crate) enum Named {
    Surface(Surface),
    /// By its number.
    Region(u32),
}
