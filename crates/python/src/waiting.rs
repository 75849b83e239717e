//! Long work: Python's other threads go on meanwhile, its callback is told of
//! progress, and Ctrl-C ends it.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use csg::CancelToken;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How often signals are looked at and progress is told.
const TICK: Duration = Duration::from_millis(50);

/// The share of the work that is done, as the bits of a double.
#[derive(Clone, Default)]
pub(crate) struct Share(Arc<AtomicU64>);

impl Share {
    pub(crate) fn set(&self, share: f64) {
        self.0.store(share.to_bits(), Ordering::Relaxed);
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// What the work of [`wait`] is followed and stopped by.
#[derive(Default)]
pub(crate) struct Follow<'py> {
    pub(crate) share: Share,
    pub(crate) cancel: CancelToken,
    /// Called with the share, by the thread that waits.
    pub(crate) callback: Option<Bound<'py, PyAny>>,
}

impl Follow<'_> {
    fn tell(&self, told: &mut f64, share: f64) -> PyResult<()> {
        if let Some(callback) = &self.callback
            && share > *told
        {
            *told = share;
            callback.call1((share,))?;
        }
        Ok(())
    }
}

/// The threads that work is done by, of this process: those of a process that forked are
/// not there in its child, and work for them would wait for ever.
fn threads() -> PyResult<Arc<ThreadPool>> {
    static THREADS: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut threads = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match &*threads {
        Some((of, pool)) if *of == process => Ok(Arc::clone(pool)),
        _ => {
            let pool = ThreadPoolBuilder::new().build().map_err(|error| {
                PyRuntimeError::new_err(format!("no threads to work with: {error}"))
            })?;
            let pool = Arc::new(pool);
            // The parent's cannot be ended from here.
            std::mem::forget(threads.replace((process, Arc::clone(&pool))));
            Ok(pool)
        }
    }
}

/// Does the work in another thread. An exception of the callback or of a signal's
/// handler (`KeyboardInterrupt`) cancels it, waits for its end and goes on from there.
pub(crate) fn wait<'py, T: Send>(
    py: Python<'py>,
    follow: &Follow<'py>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let done = Mutex::new(None);
    let is_done = Condvar::new();
    let result = threads()?.in_place_scope(|scope| {
        scope.spawn(|_| {
            let result = catch_unwind(AssertUnwindSafe(work));
            *done.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            is_done.notify_one();
        });
        let mut told = 0.0;
        let mut interrupted = None;
        loop {
            let finished = py.detach(|| {
                let slot = done.lock().unwrap_or_else(PoisonError::into_inner);
                let waited = is_done.wait_timeout_while(slot, TICK, |slot| slot.is_none());
                waited.unwrap_or_else(PoisonError::into_inner).0.take()
            });
            if let Some(result) = finished {
                if interrupted.is_none() && result.is_ok() {
                    interrupted = follow.tell(&mut told, 1.0).err();
                }
                return interrupted.map_or(Ok(result), Err);
            }
            if interrupted.is_none() {
                let so_far = py
                    .check_signals()
                    .and_then(|()| follow.tell(&mut told, follow.share.get()));
                if let Err(error) = so_far {
                    follow.cancel.cancel();
                    interrupted = Some(error);
                }
            }
        }
    });
    result.map(|result| result.unwrap_or_else(|panic| resume_unwind(panic)))
}

/// [`wait`] for what cannot be stopped on its way.
pub(crate) fn wait_out<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    wait(py, &Follow::default(), work)
}
