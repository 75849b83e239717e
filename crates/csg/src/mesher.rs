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
}
