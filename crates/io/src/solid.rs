//! Solids from mesh files.

use std::path::Path;

use csg::{LengthUnit, Repairs, Solid};

use crate::{Error, ReadOptions, read_mesh_file};

/// How a solid is read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolidOptions {
    /// The unit of the solid's lengths, the millimetre where nothing else is said. Those of 3MF
    /// and glTF files are converted; others have none and are taken as they are.
    pub unit: LengthUnit,
    /// Whether a mesh that bounds no solid is mended ([`Solid::repaired`]).
    pub repair: bool,
    /// Whether the file may name others in any folder ([`ReadOptions::any_folder`]).
    pub any_folder: bool,
}

impl SolidOptions {
    /// The same options with another unit.
    #[must_use]
    pub fn unit(mut self, unit: LengthUnit) -> Self {
        self.unit = unit;
        self
    }

    /// The same options with meshes mended, or not.
    #[must_use]
    pub fn repair(mut self, repair: bool) -> Self {
        self.repair = repair;
        self
    }

    /// The same options with files of any folder allowed, or not.
    #[must_use]
    pub fn any_folder(mut self, any_folder: bool) -> Self {
        self.any_folder = any_folder;
        self
    }
}

/// Reads the solid that a mesh file bounds (STL, OBJ, PLY, OFF, 3MF, GLB or glTF, by
/// its extension), to be combined with others: see [`MeshFile::solid`](crate::MeshFile::solid).
/// Its lengths are millimetres ([`SolidOptions::unit`]).
///
/// # Errors
/// As [`read_mesh`](crate::read_mesh); [`Error::NotASolid`] names open, doubled, crossing and
/// wrongly facing triangles with their places.
pub fn read_solid(path: impl AsRef<Path>) -> Result<Solid, Error> {
    read_solid_with(path, &SolidOptions::default()).map(|(solid, _)| solid)
}

/// [`read_solid`] with other options, and what was mended.
///
/// # Errors
/// As [`read_solid`].
pub fn read_solid_with(
    path: impl AsRef<Path>,
    options: &SolidOptions,
) -> Result<(Solid, Repairs), Error> {
    let path = path.as_ref();
    let files = ReadOptions::default().any_folder(options.any_folder);
    let file = read_mesh_file(path, &files)?.in_unit(options.unit);
    let read = if options.repair {
        file.repaired()
    } else {
        file.solid().map(|solid| (solid, Repairs::default()))
    };
    read.map_err(|faults| Error::NotASolid(faults).in_file(path))
}
