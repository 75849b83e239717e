//! Files as slices of bytes.
//!
//! A large mesh file is most of what reading it takes memory for. Mapped, it
//! stays where the system keeps it anyway: nothing is copied, and no fresh
//! memory is cleared for it, which is a quarter of the time that a binary STL
//! file of a million triangles takes to read.
#![allow(unsafe_code)]

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::ops::Deref;
use std::path::Path;

use memmap2::Mmap;

use crate::Error;

/// Files of fewer bytes are read: a mapping costs about as much.
const SMALL: u64 = 1 << 16;

/// The contents of a file, or of a part of one.
pub(crate) enum Contents<'data> {
    Mapped(Mmap),
    Read(Vec<u8>),
    Borrowed(&'data [u8]),
}

impl Contents<'_> {
    /// Opens a regular file. Anything else is refused before it is opened: a
    /// device may have no end, and opening a pipe waits for its writer.
    ///
    /// The file must not be written to meanwhile. Programs that write whole
    /// files beside the old ones, as this one does, never do that.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let regular = |about: &Metadata| match about.file_type() {
            kind if kind.is_file() => Ok(()),
            kind if kind.is_dir() => Err(io::Error::other("it is a folder")),
            _ => Err(io::Error::other("it is a device or a pipe, not a file")),
        };
        regular(&fs::metadata(path)?)?;
        let file = File::open(path)?;
        // (Another one may have taken its place meanwhile.)
        let about = file.metadata()?;
        regular(&about)?;
        if about.len() >= SMALL {
            // SAFETY: the mapping is private and only read, and readers check
            // every length and index that they find in it. What another
            // process writes to the file while it is mapped could still
            // change under them; the documentation of reading rules it out.
            return unsafe { Mmap::map(&file) }.map(Self::Mapped);
        }
        let mut bytes = Vec::new();
        // (No more than was there: it may grow.)
        file.take(SMALL).read_to_end(&mut bytes)?;
        Ok(Self::Read(bytes))
    }

    /// A file that the file at `document` names. It must lie in the same folder
    /// or below, links and `..` followed, unless `any_folder`.
    pub(crate) fn named_by(document: &Path, name: &str, any_folder: bool) -> Result<Self, Error> {
        // (A document in the current folder has an empty one.)
        let folder = document.parent().unwrap_or(Path::new(""));
        let folder = Path::new(".").join(folder);
        let named = folder.join(name);
        let place = |path: &Path| path.canonicalize().map_err(Error::file("read", &named));
        if !any_folder && is_outside(&named, &place(&folder)?) {
            let path = named.canonicalize().unwrap_or(named);
            return Err(Error::OtherFolder { path });
        }
        Self::of(&place(&named)?).map_err(Error::file("read", &named))
    }
}

/// Whether a file is neither in a folder nor below, links and `..` followed; the folder is as
/// [`Path::canonicalize`] has it. Of a file that is not there its nearest folder is asked, so that
/// nobody learns which files other folders have.
pub(crate) fn is_outside(file: &Path, folder: &Path) -> bool {
    let nearest = file.ancestors().find_map(|path| path.canonicalize().ok());
    !nearest.is_some_and(|path| path.starts_with(folder))
}

impl Deref for Contents<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Read(bytes) => bytes,
            Self::Borrowed(bytes) => bytes,
        }
    }
}
