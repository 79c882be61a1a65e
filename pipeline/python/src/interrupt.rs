//! Work of the compiled part: on a thread of its own while the calling one waits and asks for Ctrl-C, with panics as exceptions.
//!
//! A factorisation of a large body takes seconds, and nothing asks within it whether to end. Where Ctrl-C is pressed, the caller therefore has
//! its exception at once, and the thread ends at its next question, without anyone waiting for it.

use fem::Interrupt;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::errors::{Kind, typed_exception};
use crate::threads::in_this_process;

/// Time between two questions: short for a person, long against the 10 µs that one takes.
const BETWEEN: Duration = Duration::from_millis(100);
/// Time that work has to end by itself after Ctrl-C, so that its thread does not run into the next call.
const GRACE: Duration = Duration::from_millis(400);
/// Stack of a thread: that of a program's main thread.
const STACK: usize = 8 << 20;

/// Whether work shall end, and the exception that a callback of the user raised in it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Signals {
    ended: Arc<AtomicBool>,
    /// Whether the caller has gone on before the work was at its end.
    left: Arc<AtomicBool>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Signals {
    /// The question for a solver.
    pub(crate) fn interrupt(&self) -> Interrupt {
        let ended = self.ended.clone();
        Arc::new(move || ended.load(Ordering::Relaxed))
    }

    /// Whether the work shall end.
    pub(crate) fn is_raised(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Whether the caller has gone on.
    pub(crate) fn is_left(&self) -> bool {
        self.left.load(Ordering::Relaxed)
    }

    /// Ends the work with an exception of the caller's own, as one that a progress callback raised.
    pub(crate) fn end_with(&self, error: PyErr) {
        self.ended.store(true, Ordering::Relaxed);
        if let Ok(mut raised) = self.raised.lock() {
            raised.get_or_insert(error);
        }
    }

    /// The callback's exception, or else the outcome.
    fn raised_or_solved<T>(&self, solved: PyResult<T>) -> PyResult<T> {
        let raised = self.raised.lock().ok().and_then(|mut raised| raised.take());
        raised.map_or(solved, Err)
    }
}

/// Runs `compute` with the interpreter's lock released, on a thread of its own; the signals that it is given ask it to end once a handler has
/// raised an exception.
///
/// # Errors
/// The exception of the handler or of a callback, what `compute` returns, or `InternalError` where it panics.
pub(crate) fn run_watched<T: Send + 'static>(
    py: Python<'_>,
    compute: impl FnOnce(&Signals) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    run_watched_by(py, &Signals::default(), compute)
}

/// As [`run_watched`], with signals of the caller's own.
///
/// # Errors
/// As [`run_watched`].
pub(crate) fn run_watched_by<T: Send + 'static>(
    py: Python<'_>,
    signals: &Signals,
    compute: impl FnOnce(&Signals) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let asked = signals.clone();
    let (done, waiting) = channel();
    let computed = move || {
        let outcome = run_guarded(|| in_this_process(|| compute(&asked)));
        // Nobody waits any more where the caller had its exception.
        let _ = done.send(asked.raised_or_solved(outcome));
    };
    py.detach(move || {
        std::thread::Builder::new().stack_size(STACK).spawn(computed)?;
        wait_for(&waiting, signals)
    })
}

fn wait_for<T>(waiting: &Receiver<PyResult<T>>, signals: &Signals) -> PyResult<T> {
    loop {
        match waiting.recv_timeout(BETWEEN) {
            Ok(outcome) => return outcome,
            Err(RecvTimeoutError::Disconnected) => return Err(internal_error("a thread ended without a result")),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    signals.ended.store(true, Ordering::Relaxed);
                    signals.left.store(waiting.recv_timeout(GRACE).is_err(), Ordering::Relaxed);
                    return Err(error);
                }
            }
        }
    }
}

/// Runs `compute`, with a panic as an exception.
///
/// # Errors
/// What `compute` returns, or `InternalError`.
pub(crate) fn run_guarded<T>(compute: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    // What a panic leaves half done is a solver's, and that is marked so by its lock.
    catch_unwind(AssertUnwindSafe(compute)).unwrap_or_else(|panic| Err(internal_error(&panic_message(&*panic))))
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
}

fn internal_error(message: &str) -> PyErr {
    let reason = format!("the program met a state that it holds impossible: {message}");
    let act = "this is a defect of softfish: report it with this call; make a new solver before the next one";
    typed_exception(Kind::Internal, ["the call failed", &reason, act])
}
