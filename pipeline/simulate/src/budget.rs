//! Budget of a solve: Newton iterations of a level or a time step, halvings of a load step, and seconds of the whole.
//!
//! A body under a load that it cannot carry has no equilibrium, and the search for one no natural end: each load step is halved and solved in
//! other ways many times. Iterations are counted where the solver asks whether to end, before each of them, so that a solve that ends at its
//! limit does so at the same iteration on every machine; only `timeout` looks at the clock.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use fem::{Interrupt, StaticSettings};
use serde::Deserialize;
use si::Second;

/// Newton iterations of a level where nothing else is said. A level of the examples takes 6 to 20, one that snaps through some hundred; a body of
/// 6000 dofs makes 250 in seven to fourteen seconds of one core.
pub const MAX_ITERATIONS: usize = 250;

/// Limits of a solve; what is left out has its default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Budget {
    /// Newton iterations of each level or time step; [`MAX_ITERATIONS`] where none is given.
    pub max_iterations: Option<usize>,
    /// Halvings of a load step of a level.
    pub max_cutbacks: Option<usize>,
    /// Seconds of all levels or steps; no limit where none is given.
    pub timeout: Option<Second>,
}

/// The limit at which a solve was ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exceeded {
    /// Newton iterations of one level or time step.
    Iterations(usize),
    /// Seconds since the beginning.
    Timeout(Second),
}

impl std::fmt::Display for Exceeded {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Iterations(most) => write!(out, "it took {most} Newton iterations, the limit max_iterations"),
            Self::Timeout(seconds) => write!(out, "it took {seconds} s, the limit timeout"),
        }
    }
}

impl std::error::Error for Exceeded {}

impl Budget {
    /// These limits, and those of `other` where there is none here.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            max_iterations: self.max_iterations.or(other.max_iterations),
            max_cutbacks: self.max_cutbacks.or(other.max_cutbacks),
            timeout: self.timeout.or(other.timeout),
        }
    }

    /// The settings of a level within this budget.
    #[must_use]
    pub fn limiting(&self, settings: StaticSettings) -> StaticSettings {
        StaticSettings { max_halvings: self.max_cutbacks.unwrap_or(settings.max_halvings), ..settings }
    }

    /// Begins to count; the solver is to ask [`Watch::interrupt`], which also asks `other`.
    pub fn watch(&self, other: Option<Interrupt>) -> Arc<Watch> {
        Arc::new(Watch {
            most: self.max_iterations.unwrap_or(MAX_ITERATIONS),
            timeout: self.timeout.map(|seconds| (seconds, Duration::try_from_secs_f64(seconds).unwrap_or_default())),
            began: Instant::now(),
            iterations: AtomicUsize::new(0),
            exceeded: OnceLock::new(),
            other,
        })
    }
}

/// What a solve has used of its budget.
pub struct Watch {
    most: usize,
    timeout: Option<(Second, Duration)>,
    began: Instant,
    iterations: AtomicUsize,
    exceeded: OnceLock<Exceeded>,
    other: Option<Interrupt>,
}

impl Watch {
    /// The question for a solver: it counts an iteration each time that it is asked.
    pub fn interrupt(self: &Arc<Self>) -> Interrupt {
        let watch = self.clone();
        Arc::new(move || watch.count_iteration())
    }

    /// A level or time step begins.
    pub fn restart(&self) {
        self.iterations.store(0, Ordering::Relaxed);
    }

    /// The limit that was reached.
    pub fn exceeded(&self) -> Option<Exceeded> {
        self.exceeded.get().copied()
    }

    fn count_iteration(&self) -> bool {
        if self.other.as_ref().is_some_and(|asked| asked()) || self.exceeded.get().is_some() {
            return true;
        }
        let iterations_before = self.iterations.fetch_add(1, Ordering::Relaxed);
        let late = self.timeout.filter(|(_, limit)| self.began.elapsed() >= *limit);
        let spent = (iterations_before >= self.most).then_some(Exceeded::Iterations(self.most));
        match late.map(|(seconds, _)| Exceeded::Timeout(seconds)).or(spent) {
            Some(limit) => self.exceeded.set(limit).is_ok() || self.exceeded.get().is_some(),
            None => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_are_counted_in_each_level_and_an_end_is_final() {
        let watch = Budget { max_iterations: Some(2), ..Budget::default() }.watch(None);
        let asked = watch.interrupt();
        assert!(!asked() && !asked());
        watch.restart();
        assert!(!asked() && !asked() && asked());
        watch.restart();
        assert!(asked(), "a solve that was ended stays so until it has returned");
        assert_eq!(watch.exceeded(), Some(Exceeded::Iterations(2)));
    }

    #[test]
    fn seconds_are_those_of_the_whole_and_the_other_question_is_asked_first() {
        let none = Budget { timeout: Some(0.0), ..Budget::default() };
        let watch = none.watch(None);
        watch.restart();
        assert!(watch.interrupt()());
        assert_eq!(watch.exceeded(), Some(Exceeded::Timeout(0.0)));
        let other = none.watch(Some(Arc::new(|| true)));
        assert!(other.interrupt()() && other.exceeded().is_none());
    }
}
