//! A mesh by cells made in slabs, each by itself, wherever, and put together.
//!
//! All bricks of a lattice have a place in one order ([`super::walk`]), and a
//! slab is a run of them: its vertices and triangles are a run of those of the
//! whole mesh. Beside its own bricks it walks those before them whose vertices
//! its triangles name, just to know where these are; they get the same places,
//! to the bit, in whatever slab. What a slab names of another one it calls by a
//! key, the vertex's place in the lattice ([`key`]), so that no two vertices
//! are ever taken for one because they are near to each other.
//!
//! What a slab cannot do is to clean up: a collapse may reach into another
//! slab, and what is worth the while depends on counts of the whole mesh. It
//! tells its bad triangles, and the merger cleans them up, all together, from
//! the triangles around them alone.

mod cut;
mod key;

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub(crate) use self::cut::{cut, empty};
pub(crate) use super::part::FallbackKind;
use crate::color::Color;
use crate::error::Error;
use crate::mesh::{LengthUnit, MeshSurface};
use crate::program::{Bounds, Surface};

/// A run of the bricks of a uniform lattice, meshed by itself: from
/// [`Mesher::slab`](crate::Mesher::slab), for a [`Merger`](crate::Merger).
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    /// What a merger keeps of it.
    pub head: SlabHead,
    /// What it reads when it comes to the slab.
    pub body: SlabBody,
    /// Its vertices, in model units about the middle of the solid's bounds.
    pub positions: Vec<DVec3>,
    /// Its triangles, by the places of their corners among its vertices and,
    /// counted on, those of other slabs that it names.
    pub triangles: Vec<[u32; 3]>,
}

/// What a merger keeps of a slab: how much there is of it, and what other slabs
/// may ask for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlabHead {
    /// Of program and lattice: the slabs of one mesh have the same.
    pub(crate) fingerprint: u64,
    pub(crate) part: u32,
    pub(crate) of: u32,
    pub(crate) unit: LengthUnit,
    pub(crate) bounds: Option<Bounds>,
    pub(crate) cell_size: f64,
    /// The middle of the bounds.
    pub(crate) origin: DVec3,
    pub(crate) least_area: f64,
    pub(crate) tolerance: f64,
    pub(crate) vertices: u32,
    pub(crate) triangles: u32,
    /// Triangles of the slab that come after those of all.
    pub(crate) further: u32,
    /// Triangles that have a colour, further ones, too.
    pub(crate) colored: u64,
    /// The vertices that other slabs may name: their keys, and which they are.
    pub(crate) exports: Vec<(u64, u32)>,
    /// The blocks that it has bricks of, by their first brick's number, and
    /// whether there is anything smaller than a cell.
    pub(crate) blocks: Vec<(u64, bool)>,
    /// Triangles that have no area or are folded over, and the block that each
    /// is in, by its place in the list; further ones, counted on, are in none.
    pub(crate) bad: Vec<(u32, Option<u32>)>,
    pub(crate) fallbacks: Vec<(FallbackKind, u64, Vec<DVec3>)>,
    pub(crate) cells_visited: u64,
    pub(crate) cells_pruned: u64,
    pub(crate) surface_cells: u64,
}

impl SlabHead {
    /// Which of how many slabs it is, from 0.
    #[must_use]
    pub fn part(&self) -> (u32, u32) {
        (self.part, self.of)
    }

    /// How many vertices it has.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices as usize
    }

    /// How many triangles it has, but for some further ones.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.triangles as usize
    }
}

/// What its triangles lie on, and what it names of other slabs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlabBody {
    /// In the order in which triangles first lie on them.
    pub(crate) entries: Vec<SlabEntry>,
    /// Runs of triangles.
    pub(crate) groups: Vec<SlabGroup>,
    /// The vertices of other slabs that triangles name: their keys and places.
    pub(crate) imports: Vec<(u64, DVec3)>,
    pub(crate) further: Vec<FurtherTriangle>,
}

/// A surface of a primitive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SlabEntry {
    /// Their indices in the program.
    pub surface: u32,
    pub primitive: u32,
    pub body: u32,
    pub name: Option<Arc<str>>,
    pub parts: Arc<[Arc<str>]>,
    pub color: Option<Color>,
    /// In model units about the true origin.
    pub shape: Surface,
}

impl SlabEntry {
    pub fn mesh_surface(&self) -> MeshSurface {
        MeshSurface {
            surface: self.surface,
            primitive: self.primitive,
            body: self.body,
            name: self.name.clone(),
            parts: self.parts.clone(),
            color: self.color,
        }
    }
}

/// Triangles one after another on one surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SlabGroup {
    pub entry: u32,
    /// Whether the surface's gradient points into the solid there.
    pub reversed: bool,
    pub triangles: u32,
}

/// A triangle that comes after those of all slabs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FurtherTriangle {
    pub corners: [u32; 3],
    pub entry: u32,
    pub reversed: bool,
}

/// Where a [`Merger`](crate::Merger) has slabs from: memory, or files that are read piece by piece.
pub trait SlabSource: Sync {
    /// What to call it in errors, such as the file's name.
    fn name(&self) -> String;

    /// What a merger keeps of it.
    fn head(&self) -> &SlabHead;

    /// [`Slab::body`].
    ///
    /// # Errors
    /// What cannot be read.
    fn body(&self) -> Result<Cow<'_, SlabBody>, Error>;

    /// [`Slab::positions`].
    ///
    /// # Errors
    /// What cannot be read.
    fn positions(&self) -> Result<Cow<'_, [DVec3]>, Error>;

    /// [`Slab::triangles`].
    ///
    /// # Errors
    /// What cannot be read.
    fn triangles(&self) -> Result<Cow<'_, [[u32; 3]]>, Error>;
}

impl SlabSource for Slab {
    fn name(&self) -> String {
        format!("slab {} of {}", self.head.part + 1, self.head.of)
    }

    fn head(&self) -> &SlabHead {
        &self.head
    }

    fn body(&self) -> Result<Cow<'_, SlabBody>, Error> {
        Ok(Cow::Borrowed(&self.body))
    }

    fn positions(&self) -> Result<Cow<'_, [DVec3]>, Error> {
        Ok(Cow::Borrowed(&self.positions))
    }

    fn triangles(&self) -> Result<Cow<'_, [[u32; 3]]>, Error> {
        Ok(Cow::Borrowed(&self.triangles))
    }
}
