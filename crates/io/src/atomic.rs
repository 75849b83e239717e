//! Files that are either replaced whole or left alone.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::Error;

/// What [`bytes_written`] tells.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// At most so many bytes are given to the system at a time, or what is counted would stand still.
const AT_ONCE: usize = 1 << 18;

/// How many bytes this process has given to [`AtomicFile`]s so far, finished or not: something to
/// show people while a large file is written. All functions of this crate that are given a path
/// write it as one.
#[must_use]
pub fn bytes_written() -> u64 {
    WRITTEN.load(Ordering::Relaxed)
}

/// A file being written beside its place, which takes that place only when
/// [`AtomicFile::commit`] succeeds: after an error, a panic or on a full disk
/// the old file is still there, whole, and nothing else is.
///
/// The data goes to a temporary file in the same folder, is flushed to the
/// disk, and is then renamed, keeping the permissions of a file it replaces.
/// What is not a regular file (a pipe, `/dev/null`) is written to directly.
#[derive(Debug)]
pub struct AtomicFile {
    /// The place, links followed.
    path: PathBuf,
    target: Target,
    /// Whether the data is flushed to the disk first.
    flush: bool,
}

#[derive(Debug)]
enum Target {
    Beside(NamedTempFile),
    Direct(File),
}

impl AtomicFile {
    /// Starts a new file that shall be at `path`.
    ///
    /// # Errors
    /// If `path` is a folder or in a folder that cannot be written to.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let old = fs::metadata(path).ok();
        let target = match &old {
            Some(old) if !old.is_file() => {
                // (Opening a folder for writing gives the error to report.)
                let file = File::options().write(true).open(path);
                Target::Direct(file.map_err(Error::file("write to", path))?)
            }
            _ => Target::Beside(
                temporary_beside(path, old.map(|old| old.permissions()))
                    .map_err(Error::file("create a file beside", path))?,
            ),
        };
        // Replace what a symbolic link names, not the link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        Ok(Self {
            path,
            target,
            flush: true,
        })
    }

    /// Leaves it to the system when the data reaches the disk: other programs
    /// still find the old file or the new one, whole, but after a power
    /// failure the new one may be empty. For what is quickly made again, such
    /// as pictures; waiting for the disk can take longer than drawing them.
    #[must_use]
    pub fn without_flush(mut self) -> Self {
        self.flush = false;
        self
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If the data cannot be flushed to the disk or the place not be taken;
    /// then the old file is still there.
    pub fn commit(self) -> Result<(), Error> {
        Self::commit_all([self])
    }

    /// Puts several files that belong together in their places: all of them,
    /// or on error none. They are flushed before the first is renamed; only
    /// a crash of the machine between two renames can separate them.
    ///
    /// # Errors
    /// As [`AtomicFile::commit`].
    pub fn commit_all(files: impl IntoIterator<Item = Self>) -> Result<(), Error> {
        let (mut ready, mut flushed) = (Vec::new(), Vec::new());
        for file in files {
            match file.target {
                // Pipes and devices cannot always be flushed to a disk.
                Target::Direct(_) => {}
                Target::Beside(temporary) => {
                    if file.flush {
                        let synced = temporary.as_file().sync_all();
                        synced.map_err(Error::file("write", &file.path))?;
                        flushed.push(file.path.clone());
                    }
                    ready.push((file.path, temporary.into_temp_path()));
                }
            }
        }
        let mut done: Vec<Replaced> = Vec::new();
        let last = ready.len().saturating_sub(1);
        for (index, (path, temporary)) in ready.into_iter().enumerate() {
            // Only files that later failures may bring back need keeping.
            match replace(&path, temporary, index < last) {
                Ok(replaced) => done.push(replaced),
                Err(source) => {
                    done.into_iter().rev().for_each(Replaced::undo);
                    return Err(Error::file("replace", &path)(source));
                }
            }
        }
        for path in &flushed {
            sync_folder_of(path);
        }
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let data = &data[..data.len().min(AT_ONCE)];
        let written = match &mut self.target {
            // (Whose own errors would name it.)
            Target::Beside(file) => file.as_file_mut().write(data),
            Target::Direct(file) => file.write(data),
        }?;
        WRITTEN.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.target {
            Target::Beside(file) => file.as_file_mut().flush(),
            Target::Direct(file) => file.flush(),
        }
    }
}

/// A file that has taken its place, and the old one if it is kept.
struct Replaced {
    path: PathBuf,
    old: Option<TempPath>,
}

impl Replaced {
    /// Brings the old state back, as far as the system lets us.
    fn undo(self) {
        let _ = match self.old {
            Some(old) => old.persist(&self.path).map_err(|error| error.error),
            None => fs::remove_file(&self.path),
        };
    }
}

fn replace(path: &Path, temporary: TempPath, keep_old: bool) -> io::Result<Replaced> {
    let mut old = None;
    if keep_old && path.is_file() {
        let aside = temporary_beside(path, None)?.into_temp_path();
        fs::rename(path, &aside)?;
        old = Some(aside);
    }
    match temporary.persist(path) {
        Ok(()) => Ok(Replaced {
            path: path.to_owned(),
            old,
        }),
        Err(error) => {
            if let Some(old) = old {
                old.persist(path)?;
            }
            Err(error.error)
        }
    }
}

/// A new file in the folder of `path`, removed again unless it is renamed.
fn temporary_beside(
    path: &Path,
    permissions: Option<fs::Permissions>,
) -> io::Result<NamedTempFile> {
    let folder = match path.canonicalize() {
        Ok(path) => path.parent().map(Path::to_owned),
        Err(_) => path.parent().map(Path::to_owned),
    };
    let folder = folder
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or_else(|| PathBuf::from("."));
    let mut builder = Builder::new();
    builder.prefix(".unfinished-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: what the user's mask allows (the default of
        // temporary files is private).
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // (Nobody asked for the file that could not be made, so its name would only puzzle.)
    let made = builder.tempfile_in(&folder);
    let file = made.map_err(|error| match fs::metadata(&folder) {
        Err(own) => own,
        Ok(_) => error.kind().into(),
    })?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    Ok(file)
}

/// Makes a rename last through a power failure, where folders can be flushed.
fn sync_folder_of(path: &Path) {
    #[cfg(unix)]
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    #[cfg(not(unix))]
    let _ = path;
}
