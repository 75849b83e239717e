//! One way in and one way out for every mesh format, by file extension.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use csg::{Mesh, MeshSurface};
use rayon::prelude::*;

use crate::atomic::AtomicFile;
use crate::{Error, gltf, obj, ply, stl, threemf};

/// The mesh formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshFormat {
    /// glTF 2.0 in one binary file.
    Glb,
    /// glTF 2.0 as JSON, with its data in a `.bin` file beside it.
    Gltf,
    /// Wavefront OBJ, with its materials in a `.mtl` file beside it.
    Obj,
    /// Stereolithography: triangles without names or colours.
    Stl,
    /// The Stanford polygon format, binary, with a colour for each triangle.
    Ply,
    /// 3D Manufacturing Format, with colours. Written only.
    ThreeMf,
}

impl MeshFormat {
    /// Every format, in the order of documentation.
    pub const ALL: [Self; 6] = [
        Self::Glb,
        Self::Gltf,
        Self::Obj,
        Self::Stl,
        Self::Ply,
        Self::ThreeMf,
    ];

    /// The format's file extension, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::ThreeMf => "3mf",
        }
    }

    /// The format of a file extension (without the dot, in any case).
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|format| format.extension().eq_ignore_ascii_case(extension))
    }

    /// The format of a file by its name's extension.
    ///
    /// # Errors
    /// [`Error::UnknownFormat`], which lists the known ones.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        path.extension()
            .and_then(OsStr::to_str)
            .and_then(Self::from_extension)
            .ok_or_else(|| Error::UnknownFormat {
                path: path.to_owned(),
            })
    }

    /// All extensions, for messages.
    pub(crate) fn extensions() -> String {
        Self::ALL
            .map(|format| format!(".{}", format.extension()))
            .join(", ")
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::ThreeMf => "3MF",
        })
    }
}

/// Choices that a file name does not make.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct WriteOptions {
    /// STL: text, with every digit, rather than binary single precision.
    pub text: bool,
}

/// Writes a mesh to a file whose extension names the format; see
/// [`MeshFormat`] and, for what each keeps, the functions named `write_...`.
///
/// The file is replaced whole or not at all ([`AtomicFile`]), and so are the
/// two files that `.gltf` (with `.bin`) and `.obj` (with `.mtl`, if there
/// are colours) consist of.
///
/// # Errors
/// An unknown extension, an empty or invalid mesh, one that the format cannot
/// hold, or what the operating system refuses.
pub fn write_mesh(
    path: impl AsRef<Path>,
    mesh: &Mesh,
    options: &WriteOptions,
) -> Result<(), Error> {
    let path = path.as_ref();
    write_by_format(path, mesh, options).map_err(|error| error.in_file(path))
}

fn write_by_format(path: &Path, mesh: &Mesh, options: &WriteOptions) -> Result<(), Error> {
    let format = MeshFormat::from_path(path)?;
    let mut file = AtomicFile::create(path)?;
    match format {
        MeshFormat::Glb => gltf::write_glb(mesh, &mut file)?,
        MeshFormat::Gltf => {
            let (beside, name) = sibling(path, "bin");
            let mut bin = AtomicFile::create(&beside)?;
            gltf::write_gltf(mesh, &percent_encoded(&name), &mut file, &mut bin)?;
            return AtomicFile::commit_all([bin, file]);
        }
        MeshFormat::Obj => {
            let colored = |surface: &MeshSurface| surface.color.is_some();
            if mesh.surfaces.iter().any(colored) {
                let (beside, name) = sibling(path, "mtl");
                let mut materials = AtomicFile::create(&beside)?;
                obj::write_obj(mesh, Some(&name), &mut file)?;
                obj::write_mtl(mesh, &mut materials)?;
                return AtomicFile::commit_all([materials, file]);
            }
            obj::write_obj(mesh, None, &mut file)?;
        }
        MeshFormat::Stl if options.text => stl::write_stl_text(mesh, &mut file)?,
        MeshFormat::Stl => stl::write_stl(mesh, &mut file)?,
        MeshFormat::Ply => ply::write_ply(mesh, &mut file)?,
        MeshFormat::ThreeMf => threemf::write_3mf(mesh, &mut file)?,
    }
    file.commit()
}

/// Reads a mesh from a file whose extension names the format; what each
/// format gives is said at the functions named `read_...`.
///
/// # Errors
/// An unknown extension, a file that cannot be read or is damaged: the error
/// names the file and the place in it.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Mesh, Error> {
    let path = path.as_ref();
    read_by_format(path).map_err(|error| error.in_file(path))
}

fn read_by_format(path: &Path) -> Result<Mesh, Error> {
    let format = MeshFormat::from_path(path)?;
    let load = |path: &Path| load(path).map_err(Error::file("read", path));
    let beside = |name: &str| path.with_file_name("").join(name);
    match format {
        MeshFormat::Glb => gltf::read_glb(&load(path)?),
        MeshFormat::Gltf => gltf::read_gltf(&load(path)?, |name| load(&beside(name))),
        MeshFormat::Obj => obj::read_obj(&load(path)?, |name| fs::read(beside(name)).ok()),
        MeshFormat::Stl => stl::read_stl(&load(path)?),
        MeshFormat::Ply => ply::read_ply(&load(path)?),
        MeshFormat::ThreeMf => Err(Error::WriteOnly { format }),
    }
}

/// The contents of a file. Large ones are read by all threads, each of which
/// also pays for the memory it fills.
fn load(path: &Path) -> std::io::Result<Vec<u8>> {
    const PIECE: usize = 1 << 21;
    let about = fs::metadata(path)?;
    let length = usize::try_from(about.len()).unwrap_or(usize::MAX);
    if !about.is_file() || length < 2 * PIECE {
        return fs::read(path);
    }
    let mut data = vec![0; length];
    data.par_chunks_mut(PIECE)
        .enumerate()
        .try_for_each(|(index, piece)| {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start((index * PIECE) as u64))?;
            file.read_exact(piece)
        })?;
    Ok(data)
}

/// The file of the same stem with another extension, and its name.
fn sibling(path: &Path, extension: &str) -> (std::path::PathBuf, String) {
    let path = path.with_extension(extension);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.into_owned();
    (path, name)
}

/// A file name as a relative URI.
fn percent_encoded(name: &str) -> Cow<'_, str> {
    let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'.' | b'_' | b'~');
    if name.bytes().all(plain) {
        return name.into();
    }
    name.bytes()
        .map(|b| {
            if plain(b) {
                char::from(b).to_string()
            } else {
                format!("%{b:02X}")
            }
        })
        .collect::<String>()
        .into()
}
