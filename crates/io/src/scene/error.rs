//! What can be wrong with a scene, and where.

use std::fmt;
use std::path::{Path, PathBuf};

/// A place in a scene text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, if the text came from one.
    pub file: Option<PathBuf>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Place {
    /// The place of byte `offset` in `text`. Costs one pass over the text
    /// before it, so it is asked for only when there is something to say.
    pub(super) fn of(text: &str, offset: usize) -> Self {
        let before = text.get(..offset).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            file: None,
            line: before.bytes().filter(|&byte| byte == b'\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(f, "{}:{}:{}", file.display(), self.line, self.column),
            None => write!(f, "line {}, column {}", self.line, self.column),
        }
    }
}

/// Why a scene could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The text does not follow the grammar.
    #[error("{place}: {problem}")]
    Syntax {
        /// Where.
        place: Place,
        /// What was found, and what should be there.
        problem: String,
    },
    /// A node that is not known.
    #[error(
        "{place}: `{node}` cannot be read{}: supported are {} (a `%` before the node leaves it out)",
        meant(.node), super::parse::NODES.join(", ")
    )]
    Unsupported {
        /// Where.
        place: Place,
        /// The node's name.
        node: String,
    },
    /// An argument is missing, unknown or of the wrong kind.
    #[error("{place}: {node}: {problem}")]
    Argument {
        /// Where.
        place: Place,
        /// The node's name.
        node: String,
        /// What is wrong, and what is asked for.
        problem: String,
    },
    /// A node names a file that is neither beside the scene nor below:
    /// [`any_folder`](super::ReadOptions::any_folder) allows that.
    #[error(
        "{place}: {node}: `{file}` is not in the scene's folder or below: copy it there, or allow files of any folder"
    )]
    OtherFolder {
        /// Where.
        place: Place,
        /// The node's name.
        node: String,
        /// The file as the node names it.
        file: String,
    },
    /// An imported mesh bounds no solid: [`repair`](super::ReadOptions::repair) mends what can be
    /// mended.
    #[error("{place}: {node}: {}: {faults}", .file.display())]
    NotASolid {
        /// Where.
        place: Place,
        /// The node's name.
        node: String,
        /// The mesh's file.
        file: PathBuf,
        /// All that is wrong with it.
        faults: Box<csg::MeshFaults>,
    },
    /// The bytes are not text.
    #[error("{place}: the text is not UTF-8 from here on: save it as UTF-8")]
    NotUtf8 {
        /// Where the first byte that is not UTF-8 stands.
        place: Place,
    },
    /// The file could not be read.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl SceneError {
    /// The same error with the place's file named.
    #[must_use]
    pub fn in_file(mut self, path: impl AsRef<Path>) -> Self {
        match &mut self {
            Self::Syntax { place, .. }
            | Self::Unsupported { place, .. }
            | Self::Argument { place, .. }
            | Self::OtherFolder { place, .. }
            | Self::NotASolid { place, .. }
            | Self::NotUtf8 { place } => place.file = Some(path.as_ref().to_owned()),
            Self::Io { .. } => {}
        }
        self
    }

    /// Where in the text, unless the file could not be read at all.
    #[must_use]
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Syntax { place, .. }
            | Self::Unsupported { place, .. }
            | Self::Argument { place, .. }
            | Self::OtherFolder { place, .. }
            | Self::NotASolid { place, .. }
            | Self::NotUtf8 { place } => Some(place),
            Self::Io { .. } => None,
        }
    }
}

/// What a name was most likely meant to be: one of OpenSCAD's modules that an
/// evaluated tree has under another name, or a node that is spelt alike.
fn meant(name: &str) -> String {
    let evaluated = match name {
        "move" | "transform" => Some("translate"),
        "turn" => Some("rotate"),
        "sphere3d" | "ball" => Some("sphere"),
        "box" | "cuboid" => Some("cube"),
        "cone" => Some("cylinder"),
        "rectangle" => Some("square"),
        "extrude" => Some("linear_extrude"),
        "revolve" => Some("rotate_extrude"),
        _ => None,
    };
    let lowercase = name.to_lowercase();
    let alike = || {
        let distances = super::parse::NODES
            .iter()
            .map(|known| (strsim::damerau_levenshtein(known, &lowercase), *known));
        let (distance, known) = distances.min()?;
        (3 * distance <= known.len()).then_some(known)
    };
    match evaluated.or_else(alike) {
        Some(known) => format!(" (`{known}` is meant?)"),
        None => String::new(),
    }
}

/// A node that has no points because of its arguments.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Warning {
    /// Where.
    pub place: Place,
    /// The node's name.
    pub node: String,
    /// Why it is empty.
    pub problem: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.place, self.node, self.problem)
    }
}
