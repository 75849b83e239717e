//! Tells when a model's file changes.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use crate::server::{Desk, Wish};

/// One save is several events within milliseconds: the file is emptied, written, renamed.
const QUIET: Duration = Duration::from_millis(15);

/// Watches a file and those beside it that it names, until the watcher is dropped. Editors
/// put a new file in the place of the old one, so it is the folder that is watched.
pub(crate) fn watch(file: &Path, desk: &Arc<Desk>) -> notify::Result<RecommendedWatcher> {
    let file = std::path::absolute(file)?;
    let folder = file.parent().unwrap_or(&file).to_owned();
    let (sender, events) = mpsc::channel();
    let mut watcher = notify::recommended_watcher(move |event: notify::Result<Event>| {
        let Ok(event) = event else { return };
        if !matches!(event.kind, EventKind::Access(_))
            && event.paths.iter().any(|path| matters(path, &file))
        {
            let _ = sender.send(());
        }
    })?;
    watcher.watch(&folder, RecursiveMode::NonRecursive)?;
    let desk = Arc::clone(desk);
    thread::spawn(move || {
        while events.recv().is_ok() {
            loop {
                match events.recv_timeout(QUIET) {
                    Ok(()) => {}
                    Err(RecvTimeoutError::Timeout) => break,
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
            desk.wish(Wish::Changed);
        }
    });
    Ok(watcher)
}

/// Whether it is the file, or one that the file names.
fn matters(path: &Path, file: &PathBuf) -> bool {
    let name = path.file_name().and_then(OsStr::to_str);
    if path.file_name() == file.file_name() {
        return true;
    }
    // (A large file is a mesh, which names materials at most.)
    let text = std::fs::metadata(file)
        .is_ok_and(|found| found.len() < 1 << 20)
        .then(|| std::fs::read_to_string(file).ok())
        .flatten();
    text.zip(name)
        .is_some_and(|(text, name)| text.contains(name))
}
