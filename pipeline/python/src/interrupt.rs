//! Ctrl-C in a long solve: the solver asks the interpreter now and then whether a signal is waiting.

use fem::Interrupt;
use pyo3::prelude::*;
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
