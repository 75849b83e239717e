//! Solids from mesh files.

use std::path::Path;

use csg::{Repairs, Solid};

use crate::{Error, read_mesh};

/// Reads the solid that a mesh file bounds (STL, OBJ, PLY, OFF, 3MF, GLB or glTF, by
/// its extension), to be combined with others: see [`Solid::from_mesh`].
///
/// # Errors
/// As [`read_mesh`]; [`Error::NotASolid`] names open, doubled, crossing and
/// wrongly facing triangles with their places.
pub fn read_solid(path: impl AsRef<Path>) -> Result<Solid, Error> {
    let path = path.as_ref();
    let mesh = read_mesh(path)?;
    Solid::from_mesh(&mesh).map_err(|faults| Error::NotASolid(faults).in_file(path))
}

/// The same of a mesh that may not quite bound a solid, and what was changed to make it
/// bound one: see [`Solid::repaired`].
///
/// # Errors
/// As [`read_solid`], for what cannot be mended.
pub fn read_repaired_solid(path: impl AsRef<Path>) -> Result<(Solid, Repairs), Error> {
    let path = path.as_ref();
    let mesh = read_mesh(path)?;
    Solid::repaired(&mesh).map_err(|faults| Error::NotASolid(faults).in_file(path))
}
