//! What is said meanwhile: a progress bar for whatever takes long, and accounts.

use std::fmt::Display;
use std::io::IsTerminal;
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// What is done sooner than this needs no bar.
const PATIENCE: Duration = Duration::from_millis(500);
/// Length of the bar: the mesher reports hundredths.
const STEPS: u64 = 100;

/// A bar on standard error that appears if the work takes longer than half a
/// second, and only on a terminal; and what is said there besides errors and warnings.
pub(crate) struct Progress {
    bar: ProgressBar,
    is_quiet: bool,
}

impl Progress {
    /// That says nothing, if it is quiet.
    pub(crate) fn new(is_quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        if let Ok(style) =
            ProgressStyle::with_template("{msg:>9} {wide_bar} {percent:>3}%  {elapsed}")
        {
            bar.set_style(style);
        }
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
        Self { bar, is_quiet }
    }

    /// Whether nothing is said.
    pub(crate) fn is_quiet(&self) -> bool {
        self.is_quiet
    }

    /// Names what is being done now.
    pub(crate) fn stage(&self, name: &'static str) {
        self.bar.set_position(0);
        self.bar.set_message(name);
    }

    /// Says something on standard error, which is not carrying data.
    pub(crate) fn say(&self, what: impl Display) {
        if !self.is_quiet {
            self.bar.suspend(|| eprintln!("{what}"));
        }
    }

    /// Takes the bar away.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// A callback for the share that is done, 0 to 1.
    pub(crate) fn callback(&self) -> impl Fn(f64) + Send + Sync + 'static {
        let bar = self.bar.clone();
        move |share: f64| bar.set_position((share * STEPS as f64) as u64)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end();
    }
}
