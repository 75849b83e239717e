//! The one entry from a program to a mesh: options in, mesh and report out.

mod fit;
mod options;
mod run;

use crate::clock::Instant;

pub use self::options::{MAX_CELLS, Mesher};
pub use self::run::Meshed;
use self::run::Run;
use crate::error::Error;
use crate::program::Program;
use crate::surface_nets::slab::Slab;

impl Mesher {
    /// Meshes a program. The empty solid gives an empty mesh.
    ///
    /// The result is the same for any number of threads.
    ///
    /// # Errors
    /// [`Error::Unbounded`] for a solid that reaches infinitely far,
    /// [`Error::InvalidOption`] for a resolution, a tolerance, an angle or a box
    /// out of range,
    /// [`Error::LimitReached`] if it would cost more than [`Self::limits`]
    /// allow,
    /// [`Error::TooLarge`] if the vertices outnumber an index,
    /// [`Error::Cancelled`] when asked to stop.
    pub fn mesh(&self, program: &Program) -> Result<Meshed, Error> {
        let start = Instant::now();
        match self.default_tolerance(program)? {
            Some(tolerance) => {
                let mesher = self.clone().tolerance(tolerance);
                Run::new(&mesher, program, start)?.mesh()
            }
            None => Run::new(self, program, start)?.mesh(),
        }
    }

    /// Meshes one part, counted from 0, of `of` parts of a mesh by [`Self::cells`] or cells of a
    /// given size: a slab of its lattice, with the program pruned to it, for a
    /// [`Merger`](crate::Merger) to put together with the others.
    ///
    /// Slabs need nothing of each other, so they may be made in any order, on any machines; the
    /// mesh is the same, to the bit, for any number of them. Each has the same share of the
    /// lattice, which need not be the same share of the boundary: some more slabs than there are
    /// workers keep these busy. Beside its own cells it samples those just before them.
    ///
    /// Limits hold for the slab. Normals can be had from the merger; the mesh is not checked.
    ///
    /// # Errors
    /// As [`Self::mesh`]; [`Error::InvalidOption`] also for a part that there is not, and for what
    /// slabs do not have: a draft, a tolerance, adaptive cells, feature edges, partial results.
    pub fn slab(&self, program: &Program, part: u32, of: u32) -> Result<Slab, Error> {
        Run::new(self, program, Instant::now())?.slab(part, of)
    }
}
