//! Options, outcome and stopping rules of Newton's method.

use crate::newton::potential::Energy;
use si::Metre;

/// How a step along Newton's direction is limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Globalisation {
    /// Line search: each step lowers the energy. Slow along a stiff valley, but it converges through the snap-through
    /// of a wall.
    LineSearch,
    /// Full steps with the mixed-integration-point tangent ([`materials::tangent::TangentKind`]): fast where it
    /// converges.
    FullStep,
}

/// When Newton's method stops, and when it refactorises.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewtonOptions {
    /// The last step moves no node further than this.
    // The size of the step is the criterion, not the residual: a stiff sheet puts a floor of rounding under the
    // residual.
    pub tolerance: Metre,
    /// Iterations at most.
    pub max_iterations: usize,
    /// A lagged factor is replaced when the observed rate predicts more further iterations than this.
    pub max_predicted: f64,
    /// Iterations on a lagged factor before its rate is judged: quasi-Newton updates need a few to take effect.
    pub min_steps: usize,
    /// Whether to begin with a new factorisation.
    pub refactorise: bool,
    /// How steps are limited.
    pub globalisation: Globalisation,
}

/// Counts of a converged solve.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct NewtonCounts {
    /// Newton iterations.
    pub iterations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Tangents on the way that were not positive definite: a sign of snap-through.
    pub indefinite: usize,
}

/// Why Newton's method did not converge.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NonConvergence {
    /// An element is inverted at the initial guess, or on the way.
    #[error("an element is inverted")]
    InvertedElement,
    /// The steps did not become small enough.
    #[error("the last step is still {step:.2e} m after {iterations} iterations; the limit is {tolerance:.2e} m")]
    IterationLimit {
        /// Size of the last step, m.
        step: Metre,
        /// Iterations made.
        iterations: usize,
        /// Size to reach, m.
        tolerance: Metre,
    },
    /// The line search found no step that lowers the energy.
    #[error("no step lowers the energy after {iterations} iterations")]
    LineSearchFailed {
        /// Iterations made.
        iterations: usize,
    },
    /// The factor does not solve its own matrix.
    #[error("the factor leaves a relative residual of {residual:.1e}; the limit is {:.0e}", sparse::RESIDUAL_LIMIT)]
    InaccurateFactor {
        /// Relative residual of the check solve.
        residual: f64,
    },
    /// Loss of stability (limit point): no shape nearby is in equilibrium.
    #[error(
        "the body loses stability: its tangent was indefinite {times} times in a row, and it moved by {moved:.2e} m"
    )]
    LossOfStability {
        /// Indefinite tangents in a row.
        times: usize,
        /// Largest displacement on the way, m.
        moved: Metre,
    },
    /// The solve was asked to end.
    #[error("it was interrupted")]
    Interrupted,
    /// A force is NaN or infinite.
    #[error("a force is not a finite number")]
    NotFinite,
}

/// State of the iteration besides the displacement.
#[derive(Debug)]
pub(crate) struct IterationState {
    /// Counts so far.
    pub counts: NewtonCounts,
    /// Whether the next iteration begins with a new factorisation.
    pub refactorise: bool,
    /// Displacement before the step that led here, when it is known: the first point of the mixed-integration-point
    /// tangent.
    pub previous: Option<Vec<f64>>,
    /// Size of the last step.
    pub last_step: Metre,
    /// Energy at the current displacement.
    pub energy: Energy,
    options: NewtonOptions,
    /// Steps since the last factorisation.
    steps: usize,
    indefinite: usize,
}

/// Indefinite tangents in a row at which stability counts as lost: the snap-through of a wall takes up to ten.
const MAX_INDEFINITE: usize = 16;
/// Displacement, in sizes of the body, at which stability counts as lost.
const MAX_DISPLACEMENT: f64 = 3.0;

impl IterationState {
    /// At the initial guess; `previous` is where a straight line to it began.
    pub fn new(options: NewtonOptions, previous: Option<&[f64]>, energy: Energy) -> Self {
        Self {
            counts: NewtonCounts::default(),
            refactorise: options.refactorise,
            previous: previous.map(<[f64]>::to_vec),
            last_step: f64::INFINITY,
            energy,
            options,
            steps: 0,
            indefinite: 0,
        }
    }

    /// Counts a factorisation, of the tangent itself or of its convex part.
    pub(crate) fn count_factorisation(&mut self, exact: bool) {
        self.counts.factorisations += 1;
        self.indefinite = if exact { 0 } else { self.indefinite + 1 };
        self.counts.indefinite += usize::from(!exact);
        self.steps = 0;
    }

    /// Counts a step of `size`.
    pub(crate) fn count_step(&mut self, size: Metre) {
        self.steps += 1;
        self.last_step = size;
    }

    /// Refactorisation policy within a solve: whether the lagged factor's linear rate, observed from the last step and
    /// the next one of `size`, predicts more iterations than a factorisation is worth.
    pub(crate) fn needs_refactorisation(&self, size: Metre) -> bool {
        let ratio = size / self.last_step;
        let predicted = if ratio < 1.0 { (size / self.options.tolerance).ln() / -ratio.ln() } else { f64::INFINITY };
        self.steps >= self.options.min_steps && predicted > self.options.max_predicted
    }

    /// # Errors
    /// [`NonConvergence::LossOfStability`] when the iteration is far from every shape that could be in equilibrium.
    pub(crate) fn check_stability(&self, u: &[f64], size: Metre) -> Result<(), NonConvergence> {
        let moved = sparse::max_abs(u);
        if self.indefinite >= MAX_INDEFINITE || moved > MAX_DISPLACEMENT * size {
            return Err(NonConvergence::LossOfStability { times: self.indefinite, moved });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lagged_factor_is_replaced_when_its_rate_predicts_too_many_iterations() {
        let globalisation = Globalisation::LineSearch;
        let options = NewtonOptions {
            tolerance: 1e-8,
            max_iterations: 9,
            max_predicted: 6.0,
            min_steps: 1,
            refactorise: false,
            globalisation,
        };
        let mut state = IterationState::new(options, None, Energy { value: 0.0, size: 0.0 });
        assert!(!state.needs_refactorisation(1.0), "no rate is known yet");
        state.count_step(1e-2);
        assert!(!state.needs_refactorisation(1e-3), "five more of a tenth each");
        assert!(state.needs_refactorisation(5e-3), "nineteen more of a half each");
        assert!(state.needs_refactorisation(2e-2), "the steps grow");
    }
}
