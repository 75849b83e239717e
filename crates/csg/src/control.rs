//! How a caller follows and stops a long computation.

use crate::clock::Instant;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::Error;
use crate::limits::{Demand, Limit, LimitReached, Limits};
use crate::machine;

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

/// What the caller of a mesher handed over: whom to tell of progress, and who
/// may stop it.
#[derive(Clone, Default)]
pub(crate) struct Caller {
    pub(crate) progress: Option<Arc<dyn Fn(f64) + Send + Sync>>,
    pub(crate) cancel: CancelToken,
}

impl fmt::Debug for Caller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Caller")
            .field("progress", &self.progress.is_some())
            .field("cancel", &self.cancel)
            .finish()
    }
}

/// What one computation is asked now and then: may it go on? And told: how far
/// it is. Counts what it spends.
#[derive(Debug)]
pub(crate) struct Control {
    caller: Caller,
    limits: Limits,
    deadline: Option<Instant>,
    /// What the work is done for.
    demand: Demand,
    /// From which share of the whole to which this part of it leads.
    part: [f64; 2],
    cells: AtomicU64,
    bytes: AtomicU64,
    /// The last percent that the caller was told of. Shared, for what is done
    /// once more.
    told: Arc<AtomicU64>,
}

impl Control {
    /// Of a computation that begins now.
    pub(crate) fn start(caller: &Caller, limits: Limits, demand: Demand) -> Self {
        // What is counted is within a factor of two of what an allocator holds.
        let memory = limits.memory.or_else(|| Some(machine::memory()? / 2));
        Self {
            caller: caller.clone(),
            limits: Limits { memory, ..limits },
            deadline: limits
                .time
                .and_then(|time| Instant::now().checked_add(time)),
            demand,
            part: [0.0, 1.0],
            cells: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            told: Arc::default(),
        }
    }

    /// Of a part of it with something else to do, or of another try: nothing is
    /// spent yet but time.
    pub(crate) fn again(&self, demand: Demand) -> Self {
        Self {
            caller: self.caller.clone(),
            demand,
            cells: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            told: Arc::clone(&self.told),
            ..*self
        }
    }

    /// The same, for work that leads from one share of the whole to another one: what it
    /// tells of itself, from 0 to 1, is put in between.
    pub(crate) fn part(self, from: f64, to: f64) -> Self {
        Self {
            part: [from, to],
            ..self
        }
    }

    /// An error once the caller has cancelled, or a limit is reached. By counts
    /// it depends on what was counted alone: who goes on to the end of a loop
    /// whose rest is skipped learns the same on any number of threads.
    #[inline]
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.caller.cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let exceeded = |spent: &AtomicU64, most: Option<u64>| {
            most.filter(|&most| spent.load(Ordering::Relaxed) > most)
        };
        if let Some(most) = exceeded(&self.cells, self.limits.cells) {
            return Err(self.reached(Limit::Cells(most)));
        }
        if let Some(most) = exceeded(&self.bytes, self.limits.memory) {
            return Err(self.reached(Limit::Memory(most)));
        }
        match (self.deadline, self.limits.time) {
            (Some(end), Some(most)) if Instant::now() >= end => {
                Err(self.reached(Limit::Time(most)))
            }
            _ => Ok(()),
        }
    }

    /// Counts cells that were looked at and bytes that are kept.
    #[inline]
    pub(crate) fn spend(&self, cells: u64, bytes: u64) -> Result<(), Error> {
        self.cells.fetch_add(cells, Ordering::Relaxed);
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
        self.check()
    }

    /// An error for a mesh of more triangles than allowed.
    pub(crate) fn check_triangles(&self, count: usize) -> Result<(), Error> {
        match self.limits.triangles {
            Some(most) if count as u64 > most => Err(self.reached(Limit::Triangles(most))),
            _ => self.check(),
        }
    }

    /// An error for more bytes, on top of those spent, than allowed.
    pub(crate) fn check_memory(&self, bytes: usize) -> Result<(), Error> {
        let bytes = (bytes as u64).saturating_add(self.bytes.load(Ordering::Relaxed));
        match self.limits.memory {
            Some(most) if bytes > most => Err(self.reached(Limit::Memory(most))),
            _ => self.check(),
        }
    }

    fn reached(&self, limit: Limit) -> Error {
        Error::LimitReached(LimitReached {
            limit,
            demand: self.demand,
            kept: None,
        })
    }

    /// Tells the caller what share of this part is done, if it is a percent of the whole
    /// more than was told before.
    pub(crate) fn tell(&self, share: f64) {
        let Some(progress) = &self.caller.progress else {
            return;
        };
        let [from, to] = self.part;
        let share = from + (to - from) * share;
        let percent = (100.0 * share) as u64;
        if self.told.fetch_max(percent, Ordering::Relaxed) < percent {
            progress(share);
        }
    }

    /// A counter of `total` pieces of work that make up the share from `start`
    /// to `end` of this part.
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

#[cfg(test)]
impl Default for Control {
    fn default() -> Self {
        Self::start(&Caller::default(), Limits::new(), Demand::ExactBoundary)
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
        let done = pieces + self.done.fetch_add(pieces, Ordering::Relaxed);
        let share = (done as f64 / self.total as f64).min(1.0);
        self.control
            .tell(self.start + (self.end - self.start) * share);
    }
}
