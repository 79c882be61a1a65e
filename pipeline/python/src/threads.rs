//! Threads of parallel loops. Those of a process do not exist in a fork of it, where a loop that waits for them would never end: a fork gets
//! threads of its own at its first use.

use std::process;
use std::sync::{Arc, Mutex, OnceLock};

use pyo3::PyResult;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::input_error;

/// The process that loaded this module.
static LOADED: OnceLock<u32> = OnceLock::new();
/// The pool of a fork of it, and that fork.
static FORKED: Mutex<Option<Pool>> = Mutex::new(None);

/// Threads of one process.
#[derive(Debug, Clone)]
struct Pool {
    process: u32,
    threads: Arc<ThreadPool>,
}

impl Pool {
    fn new(count: usize) -> PyResult<Self> {
        let built = ThreadPoolBuilder::new().num_threads(count).build();
        let refusal = |e: rayon::ThreadPoolBuildError| {
            input_error(format!("{count} threads cannot be had"), e.to_string(), "ask for fewer")
        };
        Ok(Self { process: process::id(), threads: Arc::new(built.map_err(refusal)?) })
    }

    /// The pool in `held` if it is of this process, else one made anew in its place.
    fn current(held: &Mutex<Option<Self>>, count: usize) -> PyResult<Arc<ThreadPool>> {
        let mut pool = held.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if pool.as_ref().is_none_or(|kept| kept.process != process::id()) {
            // The threads of the former pool are not there to be ended.
            std::mem::forget(pool.take());
            *pool = Some(Self::new(count)?);
        }
        pool.as_ref().map(|kept| kept.threads.clone()).ok_or_else(|| input_error("no threads can be had", "", ""))
    }
}

/// Remembers the process that loads the module.
pub(crate) fn remember_process() {
    LOADED.get_or_init(process::id);
}

/// Runs `compute` so that its parallel loops find threads: those that all solvers share.
///
/// # Errors
/// What `compute` returns; `InputError` when no threads can be had.
pub(crate) fn in_this_process<T: Send>(compute: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    if LOADED.get() == Some(&process::id()) {
        return compute();
    }
    // 0: as many as there are processors
    Pool::current(&FORKED, 0)?.install(compute)
}

/// So many threads of a solver's own.
#[derive(Debug)]
pub(crate) struct OwnThreads {
    count: usize,
    pool: Mutex<Option<Pool>>,
}

impl OwnThreads {
    /// # Errors
    /// `InputError` when they cannot be had.
    pub(crate) fn new(count: usize) -> PyResult<Self> {
        Ok(Self { count, pool: Mutex::new(Some(Pool::new(count)?)) })
    }

    /// Runs `compute` on them.
    ///
    /// # Errors
    /// What `compute` returns; `InputError` when they cannot be had again in a fork.
    pub(crate) fn install<T: Send>(&self, compute: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
        Pool::current(&self.pool, self.count)?.install(compute)
    }
}
