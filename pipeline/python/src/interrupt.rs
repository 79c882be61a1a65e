//! Ctrl-C in a long computation. A solver asks the interpreter now and then whether a signal is waiting. What computes on many threads, of
//! which the interpreter tells none of signals, runs beside the calling one, which waits and asks.

use fem::Interrupt;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time between two questions: short for a person, long against the 10 µs that one takes.
const BETWEEN: Duration = Duration::from_millis(100);

/// What a signal handler raised, and when it was last asked for.
#[derive(Debug)]
struct State {
    raised: Option<PyErr>,
    asked: Instant,
}

/// Asks for signals during one solve.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    state: Arc<Mutex<State>>,
}

impl Signals {
    pub(crate) fn new() -> Self {
        Self { state: Arc::new(Mutex::new(State { raised: None, asked: Instant::now() })) }
    }

    /// The question for a solver.
    pub(crate) fn interrupt(&self) -> Interrupt {
        let own = self.clone();
        Arc::new(move || own.is_raised())
    }

    /// Whether a handler has raised an exception, as that of Ctrl-C does.
    pub(crate) fn is_raised(&self) -> bool {
        let Ok(mut state) = self.state.lock() else { return true };
        if state.raised.is_none() && state.asked.elapsed() >= BETWEEN {
            state.asked = Instant::now();
            state.raised = Python::attach(|py| py.check_signals()).err();
        }
        state.raised.is_some()
    }

    /// Ends the solve with an exception of the caller's own, as one that a progress callback raised.
    pub(crate) fn raise(&self, error: PyErr) {
        if let Ok(mut state) = self.state.lock() {
            state.raised.get_or_insert(error);
        }
    }

    /// The exception, or else the outcome of the solve.
    pub(crate) fn outcome<T>(&self, solved: PyResult<T>) -> PyResult<T> {
        let raised = self.state.lock().ok().and_then(|mut state| state.raised.take());
        raised.map_or(solved, Err)
    }
}

/// Stack of the thread of a computation: that of a program's main thread.
const STACK: usize = 8 << 20;

/// Runs `compute`, with the interpreter's lock released, on a thread of its own; the interrupt that it is given is set once a signal
/// handler has raised an exception.
///
/// # Errors
/// The exception of the handler, or what `compute` returns.
pub(crate) fn watched<T: Send>(py: Python<'_>, compute: impl FnOnce(Interrupt) -> PyResult<T> + Send) -> PyResult<T> {
    let ended = Arc::new(AtomicBool::new(false));
    let asked = ended.clone();
    let interrupt: Interrupt = Arc::new(move || asked.load(Ordering::Relaxed));
    let (done, waiting) = channel();
    let computed = move || {
        let outcome = compute(interrupt);
        // Nobody waits any more only where the interpreter is at its end.
        let _ = done.send(());
        outcome
    };
    py.detach(move || {
        std::thread::scope(|scope| {
            let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, computed)?;
            let mut raised = None;
            while waiting.recv_timeout(BETWEEN) == Err(RecvTimeoutError::Timeout) {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    raised.get_or_insert(error);
                    ended.store(true, Ordering::Relaxed);
                }
            }
            let outcome = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            raised.map_or(outcome, Err)
        })
    })
}
