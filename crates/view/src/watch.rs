//! Tells when a model's file changes.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};
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
    thread::spawn(move || debounced(&events, || desk.wish(Wish::Changed)));
    Ok(watcher)
}

/// Tells once of events that follow each other soon, until there can be no more.
fn debounced(events: &Receiver<()>, mut tell: impl FnMut()) {
    while events.recv().is_ok() {
        while events.recv_timeout(QUIET).is_ok() {}
        tell();
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_save_is_told_once() {
        let (events, received) = mpsc::channel();
        let (teller, told) = mpsc::channel();
        // (All there before anybody listens.)
        (0..3).for_each(|_| events.send(()).expect("a listener"));
        thread::scope(|scope| {
            scope.spawn(move || debounced(&received, || teller.send(()).expect("a counter")));
            told.recv().expect("the first save");
            assert!(told.recv_timeout(2 * QUIET).is_err());
            events.send(()).expect("a listener");
            told.recv().expect("the second save");
            drop(events);
        });
        assert!(told.try_recv().is_err());
    }
}
