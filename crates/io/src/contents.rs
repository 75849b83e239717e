//! Files as slices of bytes.
//!
//! A large mesh file is most of what reading it takes memory for. Mapped, it
//! stays where the system keeps it anyway: nothing is copied, and no fresh
//! memory is cleared for it, which is a quarter of the time that a binary STL
//! file of a million triangles takes to read.
#![allow(unsafe_code)]

use std::fs::File;
use std::io::{self, Read};
use std::ops::Deref;
use std::path::Path;

use memmap2::Mmap;

/// Files of fewer bytes are read: a mapping costs about as much.
const SMALL: u64 = 1 << 16;

/// The contents of a file.
pub(crate) enum Contents {
    Mapped(Mmap),
    Read(Vec<u8>),
}

impl Contents {
    /// Opens a file; what is no regular file (a pipe) is read to its end.
    ///
    /// The file must not be written to meanwhile. Programs that write whole
    /// files beside the old ones, as this one does, never do that.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let about = file.metadata()?;
        if about.is_file() && about.len() >= SMALL {
            // SAFETY: the mapping is private and only read, and readers check
            // every length and index that they find in it. What another
            // process writes to the file while it is mapped could still
            // change under them; the documentation of reading rules it out.
            return unsafe { Mmap::map(&file) }.map(Self::Mapped);
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(Self::Read(bytes))
    }
}

impl Deref for Contents {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Read(bytes) => bytes,
        }
    }
}
