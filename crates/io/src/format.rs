//! One way in and one way out for every mesh format, by file extension.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::path::Path;

use csg::{Mesh, MeshSurface};

use crate::assemble::Assembled;
use crate::atomic::AtomicFile;
use crate::contents::Contents;
use crate::mesh_file::MeshFile;
use crate::{Error, gltf, obj, off, ply, step, stl, threemf};

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
    /// The Object File Format: vertices and polygons as text, without names or
    /// colours.
    Off,
    /// 3D Manufacturing Format, with colours.
    ThreeMf,
}

impl MeshFormat {
    /// Every format, in the order of documentation.
    pub const ALL: [Self; 7] = [
        Self::Glb,
        Self::Gltf,
        Self::Obj,
        Self::Stl,
        Self::Ply,
        Self::Off,
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
            Self::Off => "off",
            Self::ThreeMf => "3mf",
        }
    }

    /// Whether files of it say in which unit their lengths are: 3MF, and glTF, which is in metres
    /// (with a note of the unit that was written).
    #[must_use]
    pub const fn has_unit(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf | Self::ThreeMf)
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
    /// [`Error::UnknownFormat`], which lists the known ones; [`Error::StepOfMesh`].
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        path.extension()
            .and_then(OsStr::to_str)
            .and_then(Self::from_extension)
            .ok_or_else(|| {
                let path = path.to_owned();
                if step::is_step(&path) {
                    Error::StepOfMesh { path }
                } else {
                    Error::UnknownFormat { path }
                }
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
            Self::Off => "OFF",
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
    /// GLB: compressed ([`gltf::write_glb_compressed`]).
    #[cfg(feature = "compress")]
    pub compress: bool,
    /// PLY: colours of vertices, too, each vertex once for every colour around it
    /// ([`ply::write_ply_with`]), for programs that pass over colours of faces, as Blender does.
    pub vertex_colors: bool,
    /// glTF: bodies that are the same but for where they are, and how they are turned, are written
    /// once, as `EXT_mesh_gpu_instancing` says, which readers must know.
    ///
    /// Those are connected parts of the same triangles, names, colours and normals (within 2^-20),
    /// whose places are the same after a rotation and a translation: within a 2^-36th of the
    /// coordinate that is farthest from 0, and within a 2^-22th of their own size. Each vertex comes
    /// to where it is within a 2^-22th of the model's longest side, as computed from what is written
    /// (`compress` rounds the body that is written, besides). Bodies for which that is not so are
    /// written as they are, as are those that would save next to nothing. Their order is not kept.
    ///
    /// The mesher mostly gives bodies that were only moved the same triangles, and those that were
    /// turned too only where they have no curved faces, or are whole balls:
    /// [`crate::share_triangles`] gives them to all that are the same in the solid.
    pub instances: bool,
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
        MeshFormat::Glb => gltf::write_glb_with(mesh, options, &mut file)?,
        MeshFormat::Gltf => {
            let (beside, name) = sibling(path, "bin");
            let mut bin = AtomicFile::create(&beside)?;
            let uri = percent_encoded(&name);
            gltf::write_gltf_with(mesh, options, &uri, (&mut file, &mut bin))?;
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
        MeshFormat::Ply => ply::write_ply_with(mesh, options, &mut file)?,
        MeshFormat::Off => off::write_off(mesh, &mut file)?,
        MeshFormat::ThreeMf => threemf::write_3mf(mesh, &mut file)?,
    }
    file.commit()
}

/// Choices in reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Whether a file may name others in any folder (the data of `.gltf`, the
    /// materials of `.obj`), and not only in its own and below.
    pub any_folder: bool,
    /// Faster, for drawing faces only: vertices that a glTF file gives normals
    /// stay apart, even at the same place. Such a mesh looks the same, but its
    /// triangles need not be connected, as checks, measures and the search for
    /// edges want them.
    pub to_draw: bool,
}

impl ReadOptions {
    /// The same options with files of any folder allowed, or not.
    #[must_use]
    pub fn any_folder(mut self, any_folder: bool) -> Self {
        self.any_folder = any_folder;
        self
    }

    /// The same options for drawing only, or not.
    #[must_use]
    pub fn to_draw(mut self, to_draw: bool) -> Self {
        self.to_draw = to_draw;
        self
    }
}

/// Reads a mesh from a file whose extension names the format; what each
/// format gives is said at the functions named `read_...`. The file must not
/// be written to meanwhile. It may name others beside it or below only
/// ([`ReadOptions::any_folder`] lifts that).
///
/// # Errors
/// An unknown extension, a file that cannot be read, is damaged or has no
/// triangles: the error names the file and the place in it.
/// [`Error::OtherFolder`]; materials of an OBJ file that cannot be read are
/// left out.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Mesh, Error> {
    read_mesh_with(path, &ReadOptions::default())
}

/// [`read_mesh`] with other options.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Mesh, Error> {
    read_mesh_file(path, options).map(|file| file.mesh)
}

/// [`read_mesh_with`], and what else the file says: its objects, whether it has a unit, and what
/// was left out.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_file(path: impl AsRef<Path>, options: &ReadOptions) -> Result<MeshFile, Error> {
    let path = path.as_ref();
    let mut warnings = Vec::new();
    let read = read_by_format(path, options, &mut warnings).map_err(|error| error.in_file(path))?;
    let has_unit = MeshFormat::from_path(path)?.has_unit();
    Ok(MeshFile::new(read, has_unit, warnings))
}

fn read_by_format(
    path: &Path,
    options: &ReadOptions,
    warnings: &mut Vec<String>,
) -> Result<Assembled, Error> {
    let format = MeshFormat::from_path(path)?;
    let data = Contents::of(path).map_err(Error::file("read", path))?;
    let named = |name: &str| Contents::named_by(path, name, options.any_folder);
    match format {
        MeshFormat::Glb => gltf::read_glb_with(&data, options.to_draw),
        MeshFormat::Gltf => gltf::read_gltf_with(&data, options.to_draw, named),
        MeshFormat::Obj => obj::read_obj_objects(&data, |name| match named(name) {
            Ok(data) => Some(data.to_vec()),
            Err(error @ Error::OtherFolder { .. }) => {
                warnings.push(format!("its materials are left out: {error}"));
                None
            }
            Err(_) => None,
        }),
        MeshFormat::Stl => stl::read_stl(&data).map(Assembled::from),
        MeshFormat::Ply => ply::read_ply(&data).map(Assembled::from),
        MeshFormat::Off => off::read_off(&data).map(Assembled::from),
        MeshFormat::ThreeMf => threemf::read_3mf_objects(&data),
    }
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
