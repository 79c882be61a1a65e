//! How a search for a minimum is held, how it may end, and what it remembers on the way.
//!
//! Stands on: `si`. Never knows: a potential, a factor.

use si::Metre;

/// What one step may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gait {
    /// Each step lowers the energy: slow in a stiff valley, but it comes down, through a wall that snaps too.
    Careful,
    /// Whole steps, with tangents at foreseen stress (see [`crate::body::assembly::Bend`]): quick where it arrives.
    Leaping,
}

/// When to stop, and how much patience to have with an old factor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule {
    /// The last step moves no node further than this.
    pub tolerance: Metre,
    /// Directions at most.
    pub limit: usize,
    /// A factor is renewed when it promises to need more further directions than this.
    pub patience: f64,
    /// Directions of an old factor before it is judged: what past steps teach needs a few to tell.
    pub trials: usize,
    /// Whether to begin with a new factor.
    pub fresh: bool,
    /// How steps are taken.
    pub gait: Gait,
}

/// How a search ended well.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Found {
    /// Directions computed.
    pub iterations: usize,
    /// Factors made.
    pub factorisations: usize,
    /// Tangents met on the way that were not positive definite: the body snapped.
    pub indefinite: usize,
}

/// Why a search gave up.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Stall {
    /// An element is turned inside out where the search began, or on the way.
    #[error("an element is turned inside out")]
    InsideOut,
    /// Steps did not become small.
    #[error("the last step is still {step:.2e} m after {iterations} iterations; the limit is {tolerance:.2e} m")]
    TooSlow {
        /// Size of the last step, m.
        step: Metre,
        /// Iterations made.
        iterations: usize,
        /// Size to reach, m.
        tolerance: Metre,
    },
    /// No step along a direction lowers the energy.
    #[error("no step lowers the energy after {iterations} iterations")]
    NoDescent {
        /// Iterations made.
        iterations: usize,
    },
    /// The tangent could not be factorised well.
    #[error("the factor leaves a residual of {residual:.1e}; the limit is {:.0e}", crate::algebra::factor::INEXACT)]
    Inexact {
        /// Part of its own terms that a solve leaves unbalanced.
        residual: f64,
    },
    /// The body gives way: no shape nearby can bear the load.
    #[error("the body gives way: its tangent was indefinite {times} times in a row, and it moved by {moved:.2e} m")]
    GivesWay {
        /// Indefinite tangents in a row.
        times: usize,
        /// Largest displacement on the way, m.
        moved: Metre,
    },
    /// A force is NaN or infinite.
    #[error("a force is not a finite number")]
    NotANumber,
}

/// Where a search stands.
#[derive(Debug)]
pub(crate) struct Search {
    /// Counts so far.
    pub found: Found,
    /// Whether the next direction needs a new factor.
    pub renew: bool,
    /// Where the step that led here began, when it is known.
    pub before: Option<Vec<f64>>,
    /// Size of the last step.
    pub last: Metre,
    /// Steps since the last factor.
    steps: usize,
    indefinite: usize,
}

/// Indefinite tangents in a row before the body is said to give way: a wall that snaps through takes up to ten.
const INDEFINITE: usize = 16;
/// Displacement, in sizes of the body, beyond which it has given way.
const FURTHEST: f64 = 3.0;

impl Search {
    /// At the start; `before` is where a straight line to the start began.
    pub fn new(renew: bool, before: Option<&[f64]>) -> Self {
        let before = before.map(<[f64]>::to_vec);
        Self { found: Found::default(), renew, before, last: f64::INFINITY, steps: 0, indefinite: 0 }
    }

    /// Counts a factor, of the tangent itself or of a convex part of it.
    pub fn count_factor(&mut self, exact: bool) {
        self.found.factorisations += 1;
        self.indefinite = if exact { 0 } else { self.indefinite + 1 };
        self.found.indefinite += usize::from(!exact);
        self.steps = 0;
    }

    /// Counts a step of `size`.
    pub fn count_step(&mut self, size: Metre) {
        self.steps += 1;
        self.last = size;
    }

    /// Whether the factor promises to need more further directions than the rule has patience for, now that the next
    /// step would be of `size`.
    pub fn is_worn(&self, size: Metre, rule: &Rule) -> bool {
        let ratio = size / self.last;
        let promised = if ratio < 1.0 { (size / rule.tolerance).ln() / -ratio.ln() } else { f64::INFINITY };
        self.steps >= rule.trials && promised > rule.patience
    }

    /// # Errors
    /// [`Stall::GivesWay`] when the search has left all shapes that could bear the load.
    pub fn check(&self, u: &[f64], size: Metre) -> Result<(), Stall> {
        let moved = u.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if self.indefinite >= INDEFINITE || moved > FURTHEST * size {
            return Err(Stall::GivesWay { times: self.indefinite, moved });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_worn_when_it_promises_more_directions_than_the_rule_has_patience_for() {
        let rule = Rule { tolerance: 1e-8, limit: 9, patience: 6.0, trials: 1, fresh: false, gait: Gait::Careful };
        let mut search = Search::new(false, None);
        assert!(!search.is_worn(1.0, &rule), "nothing is known yet");
        search.count_step(1e-2);
        assert!(!search.is_worn(1e-3, &rule), "five more of a tenth each");
        assert!(search.is_worn(5e-3, &rule), "nineteen more of a half each");
        assert!(search.is_worn(2e-2, &rule), "it grows");
    }
}
