//! What can go wrong with a mesh file.

use std::path::{Path, PathBuf};

use crate::MeshFormat;
use crate::drawing::DrawingFormat;

/// Why a mesh file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused something about a file.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// What was tried, as a verb: "open", "read", "replace" ...
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Writing to the given stream failed.
    #[error("cannot write: {0}")]
    Write(#[from] std::io::Error),
    /// The file name does not say which format is meant.
    #[error(
        "{}: no mesh format has this extension; use one of {}",
        path.display(), MeshFormat::extensions()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A file names another one in a folder that is not its own:
    /// [`any_folder`](crate::ReadOptions::any_folder) allows that.
    #[error(
        "{} is not in the folder of the file that names it, or below: \
         copy it there, or allow files of any folder",
        path.display()
    )]
    OtherFolder {
        /// The other file, links followed.
        path: PathBuf,
    },
    /// There is nothing to write.
    #[error("the mesh is empty: it has no triangles, so there is nothing to write")]
    EmptyMesh,
    /// The mesh breaks the rules of its own type.
    #[error("the mesh is not valid: {problem}")]
    InvalidMesh {
        /// What is wrong, where, and how to mend it.
        problem: String,
    },
    /// The mesh is valid but does not fit into the format.
    #[error("{format} cannot hold this mesh: {problem}")]
    DoesNotFit {
        /// The format.
        format: MeshFormat,
        /// What does not fit, and what would.
        problem: String,
    },
    /// The solid has no boundary.
    #[error("the solid is empty, so there is nothing to write")]
    EmptySolid,
    /// A boundary cannot be written as STEP.
    #[error("STEP cannot hold this solid: {problem}")]
    NotInStep {
        /// What does not fit, and how to mend it.
        problem: String,
    },
    /// A STEP file was asked for, but only a mesh was given, or one was to be read.
    #[error(
        "{}: STEP files are written from the exact boundary of a solid, not from a mesh, \
         and are not read; name a scene, or a mesh format: one of {}",
        path.display(), MeshFormat::extensions()
    )]
    StepOfMesh {
        /// The file.
        path: PathBuf,
    },
    /// The file name does not say which format of drawings is meant.
    #[error(
        "{}: no format of drawings has this extension; use one of .svg, .dxf, .pdf",
        path.display()
    )]
    UnknownDrawing {
        /// The file.
        path: PathBuf,
    },
    /// There is nothing to draw.
    #[error("the drawing is empty: the plane does not meet the solid, or the shape has no points")]
    EmptyDrawing,
    /// A drawing's curves cannot keep a tolerance that is not above 0.
    #[error("the drawing's tolerance is {tolerance}: give one above 0")]
    DrawingTolerance {
        /// What was given.
        tolerance: f64,
    },
    /// A file is damaged, or uses what this reader does not know.
    #[error("{place}: {problem}")]
    Malformed {
        /// The format.
        format: MeshFormat,
        /// A line, a byte offset or a named part of the file.
        place: String,
        /// What is wrong there, and how to mend it.
        problem: String,
    },
    /// The file name does not say which format of flat shapes is meant.
    #[error(
        "{}: no format that flat shapes are read from has this extension; use one of .svg, .dxf",
        path.display()
    )]
    UnknownProfile {
        /// The file.
        path: PathBuf,
    },
    /// A drawing is damaged, or uses what this reader does not know.
    #[error("{place}: {problem}")]
    MalformedDrawing {
        /// The format.
        format: DrawingFormat,
        /// A line, an element or entity, or the drawing as a whole.
        place: String,
        /// What is wrong there, and how to mend it.
        problem: String,
    },
    /// The mesh bounds no solid.
    #[error("{0}")]
    NotASolid(Box<csg::MeshFaults>),
    /// A slab of a mesh cannot be read, or put together with the others.
    #[error(transparent)]
    Slab(#[from] csg::Error),
    /// What is to be drawn is faulty.
    #[error("what is to be drawn is faulty: {0}")]
    Undrawable(csg::Error),
    /// Any of the others, with the file it happened in.
    #[error("{}: {source}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What happened.
        source: Box<Error>,
    },
}

impl Error {
    pub(crate) fn file(
        action: &'static str,
        path: &Path,
    ) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::File {
            action,
            path,
            source,
        }
    }

    /// Says in which file it happened, unless the error does already.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::File { .. }
            | Self::InFile { .. }
            | Self::UnknownFormat { .. }
            | Self::UnknownDrawing { .. }
            | Self::UnknownProfile { .. }
            | Self::StepOfMesh { .. } => self,
            other => Self::InFile {
                path: path.to_owned(),
                source: Box::new(other),
            },
        }
    }
}
