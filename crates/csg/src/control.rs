//! How a caller follows and stops a long computation.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::Error;

/// A handle that stops a computation from another thread. Clones stop the
/// same one.
///
/// ```
/// use csg::{Error, Mesher, Program, CancelToken, Solid};
///
/// let token = CancelToken::new();
/// token.cancel();
/// let program = Program::lower(&Solid::sphere(1.0))?;
/// let result = Mesher::new().cancel_token(token).mesh(&program);
/// assert!(matches!(result, Err(Error::Cancelled)));
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A handle that nobody has used yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the computation to end with [`Error::Cancelled`] as soon as it can.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`Self::cancel`] was called.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The caller's wishes during one computation: told of progress, asked
/// whether to go on.
#[derive(Clone, Default)]
pub(crate) struct Control {
    pub(crate) progress: Option<Arc<dyn Fn(f64) + Send + Sync>>,
    pub(crate) cancel: CancelToken,
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control")
            .field("progress", &self.progress.is_some())
            .field("cancel", &self.cancel)
            .finish()
    }
}

impl Control {
    /// An error once the caller has cancelled.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.cancel.is_cancelled() {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }

    /// A counter of `total` pieces of work that make up the share from `start`
    /// to `end` of the whole.
    pub(crate) fn stage(&self, total: u64, start: f64, end: f64) -> Stage<'_> {
        Stage {
            control: self,
            total: total.max(1),
            done: AtomicU64::new(0),
            start,
            end,
        }
    }
}

/// A stage whose pieces of work are counted from many threads.
pub(crate) struct Stage<'a> {
    control: &'a Control,
    total: u64,
    done: AtomicU64,
    start: f64,
    end: f64,
}

impl Stage<'_> {
    /// Counts finished pieces; tells the caller at every percent.
    pub(crate) fn add(&self, pieces: u64) {
        let Some(progress) = &self.control.progress else {
            return;
        };
        let before = self.done.fetch_add(pieces, Ordering::Relaxed);
        let percent = |done: u64| u128::from(done) * 100 / u128::from(self.total);
        if percent(before + pieces) > percent(before) {
            let share = (before + pieces) as f64 / self.total as f64;
            progress(self.start + (self.end - self.start) * share.min(1.0));
        }
    }
}
