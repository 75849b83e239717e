//! What is said meanwhile: a progress bar for whatever takes long, and accounts.

use std::fmt::{Display, Write};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use indicatif::{DecimalBytes, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// What is done sooner than this needs no bar.
const PATIENCE: Duration = Duration::from_millis(500);
/// Length of the bar: the mesher reports hundredths.
const STEPS: u64 = 100;

/// Of a stage that does not tell what share of it is done, and of one that does.
const UNKNOWN: &str = "{msg:>9}  {written}{elapsed}";
const KNOWN: &str = "{msg:>9} {wide_bar} {percent:>3}%  {written}{elapsed}";

/// A line on standard error that appears if the work takes longer than half a
/// second, and only on a terminal; and what is said there besides errors and warnings.
///
/// It has the name of what is being done, the bytes that this has written to files, how long all
/// of it has taken so far, and a bar as soon as a share is told.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// What all files had been given when the stage began.
    before: Arc<AtomicU64>,
    /// Whether the stage has told what share of it is done.
    is_known: Arc<AtomicBool>,
    is_quiet: bool,
}

impl Progress {
    /// That says nothing, if it is quiet.
    pub(crate) fn new(is_quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        if !is_quiet && std::io::stderr().is_terminal() {
            let waiting = bar.clone();
            thread::spawn(move || {
                thread::sleep(PATIENCE);
                if !waiting.is_finished() {
                    waiting.set_draw_target(ProgressDrawTarget::stderr());
                    waiting.enable_steady_tick(Duration::from_millis(100));
                }
            });
        }
        Self {
            bar,
            before: Arc::default(),
            is_known: Arc::default(),
            is_quiet,
        }
    }

    /// Whether nothing is said.
    pub(crate) fn is_quiet(&self) -> bool {
        self.is_quiet
    }

    /// Names what is being done now, of which nobody knows yet how much there is.
    pub(crate) fn stage(&self, name: &'static str) {
        self.before.store(io::bytes_written(), Ordering::Relaxed);
        self.is_known.store(false, Ordering::Relaxed);
        self.bar.set_style(style(UNKNOWN, &self.before));
        self.bar.set_position(0);
        self.bar.set_message(name);
    }

    /// Says something on standard error, which is not carrying data.
    pub(crate) fn say(&self, what: impl Display) {
        if !self.is_quiet {
            self.bar.suspend(|| say!("{what}"));
        }
    }

    /// Takes the bar away.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// A callback for the share that is done, 0 to 1, of the stage that is on then.
    pub(crate) fn callback(&self) -> impl Fn(f64) + Send + Sync + 'static {
        let (bar, known) = (self.bar.clone(), style(KNOWN, &self.before));
        let is_known = Arc::clone(&self.is_known);
        move |share: f64| {
            if !is_known.swap(true, Ordering::Relaxed) {
                bar.set_style(known.clone());
            }
            bar.set_position((share * STEPS as f64) as u64);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end();
    }
}

/// A line in which `written` is what files have been given since, if anything.
fn style(template: &str, before: &Arc<AtomicU64>) -> ProgressStyle {
    let before = Arc::clone(before);
    let written = move |_: &ProgressState, to: &mut dyn Write| {
        let bytes = io::bytes_written().saturating_sub(before.load(Ordering::Relaxed));
        if bytes > 0 {
            // (It goes to a string.)
            let _ = write!(to, "{}  ", DecimalBytes(bytes));
        }
    };
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .with_key("written", written)
}
