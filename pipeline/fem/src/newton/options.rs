//! Options, outcome and stopping rules of Newton's method.

use crate::newton::line_search::ROUNDING;
use crate::newton::potential::Energy;
use si::Metre;
use sparse::FactorError;

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
    /// Whether the initial guess is a predicted shape, near an equilibrium whose stress the first tangent has.
    pub predicted: bool,
    /// How steps are limited.
    pub globalisation: Globalisation,
}

/// Counts of a solve.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct NewtonCounts {
    /// Newton iterations.
    pub iterations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Tangents on the way that were not positive definite: a sign of snap-through.
    pub indefinite: usize,
}

impl NewtonCounts {
    /// What was counted after `earlier`.
    pub(crate) fn counted_since(self, earlier: Self) -> Self {
        Self {
            iterations: self.iterations - earlier.iterations,
            factorisations: self.factorisations - earlier.factorisations,
            indefinite: self.indefinite - earlier.indefinite,
        }
    }

    /// Adds the counts of a further solve.
    pub(crate) fn add_counts(&mut self, further: Self) {
        self.iterations += further.iterations;
        self.factorisations += further.factorisations;
        self.indefinite += further.indefinite;
    }
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
    /// The tangent with the couplings of walls in contact is too large.
    #[error("the tangent with the couplings of walls in contact cannot be factorised: {0}")]
    TooLarge(#[from] FactorError),
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
    /// How steps are limited from here on.
    pub globalisation: Globalisation,
    options: NewtonOptions,
    /// Lowest energy so far and the displacement there; none before the first full step.
    lowest: Option<(Energy, Vec<f64>)>,
    /// Full steps in a row since then that did not lower it.
    rises: usize,
    /// Steps since the last factorisation.
    steps: usize,
    indefinite: usize,
}

/// Indefinite tangents in a row at which stability counts as lost: the snap-through of a wall takes up to ten.
const MAX_INDEFINITE: usize = 16;
/// Full steps in a row without a lower energy after which the watchdog ends them.
const MAX_RISES: usize = 3;
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
            globalisation: options.globalisation,
            options,
            lowest: None,
            rises: 0,
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
        // Linear convergence assumed: n more iterations with size · ratioⁿ = tolerance. A ratio above one predicts
        // nothing but a new factor.
        let predicted = if ratio < 1.0 { (size / self.options.tolerance).ln() / -ratio.ln() } else { f64::INFINITY };
        self.steps >= self.options.min_steps && predicted > self.options.max_predicted
    }

    /// Watches the energy of full steps; `u` is where the last one led. Where three in a row have not lowered it, returns the displacement of
    /// the lowest energy, from which a line search goes on.
    pub(crate) fn watch_energy(&mut self, u: &[f64]) -> Option<Vec<f64>> {
        if self.globalisation == Globalisation::LineSearch {
            return None;
        }
        match &self.lowest {
            Some((lowest, _)) if self.energy.value > lowest.value + ROUNDING * lowest.size => self.rises += 1,
            _ => (self.lowest, self.rises) = (Some((self.energy, u.to_vec())), 0),
        }
        if self.rises < MAX_RISES {
            return None;
        }
        (self.globalisation, self.refactorise) = (Globalisation::LineSearch, true);
        self.lowest.take().map(|(_, at)| at)
    }

    /// Whether a step of `size` goes on down a direction of negative curvature: the convex part of the tangent is too stiff along it, and the
    /// updates of its factor lengthen the steps.
    pub(crate) fn descends_negative_curvature(&self, size: Metre) -> bool {
        self.indefinite > 0 && size > self.last_step
    }

    /// # Errors
    /// [`NonConvergence::LossOfStability`] when the iteration is far from every shape that could be in equilibrium.
    pub(crate) fn check_stability(&self, u: &[f64], size: Metre) -> Result<(), NonConvergence> {
        let largest_displacement = sparse::max_abs(u);
        if self.indefinite >= MAX_INDEFINITE || largest_displacement > MAX_DISPLACEMENT * size {
            return Err(NonConvergence::LossOfStability { times: self.indefinite, moved: largest_displacement });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limited_by(globalisation: Globalisation) -> IterationState {
        let options = NewtonOptions {
            tolerance: 1e-8,
            max_iterations: 9,
            max_predicted: 6.0,
            min_steps: 1,
            refactorise: false,
            predicted: false,
            globalisation,
        };
        IterationState::new(options, None, Energy { value: 0.0, size: 1.0 })
    }

    #[test]
    fn the_watchdog_returns_to_the_lowest_energy_after_three_full_steps_above_it() {
        let mut state = limited_by(Globalisation::FullStep);
        let mut step = |value: f64, at: f64| {
            state.energy.value = value;
            state.watch_energy(&[at])
        };
        // the first step may rise: a sheet that rotates stretches
        assert_eq!([step(5.0, 1.0), step(2.0, 2.0), step(3.0, 3.0), step(2.5, 4.0)], [None, None, None, None]);
        assert_eq!([step(1.0, 5.0), step(1.2, 6.0), step(1.1, 7.0)], [None, None, None], "1.0 is lower than 2.0");
        assert_eq!(step(1.05, 8.0), Some(vec![5.0]));
        assert_eq!(step(9.0, 9.0), None, "a line search needs no watchdog");
        assert!(state.globalisation == Globalisation::LineSearch && state.refactorise);
    }

    #[test]
    fn longer_steps_on_a_convex_part_of_the_tangent_slide_down_negative_curvature() {
        let mut state = limited_by(Globalisation::FullStep);
        state.count_factorisation(true);
        state.count_step(1e-5);
        assert!(!state.descends_negative_curvature(2e-5), "the tangent was exact");
        state.count_factorisation(false);
        state.count_step(1e-5);
        assert!(state.descends_negative_curvature(2e-5) && !state.descends_negative_curvature(0.5e-5));
    }

    #[test]
    fn a_lagged_factor_is_replaced_when_its_rate_predicts_too_many_iterations() {
        let mut state = limited_by(Globalisation::LineSearch);
        assert!(!state.needs_refactorisation(1.0), "no rate is known yet");
        state.count_step(1e-2);
        assert!(!state.needs_refactorisation(1e-3), "five more of a tenth each");
        assert!(state.needs_refactorisation(5e-3), "nineteen more of a half each");
        assert!(state.needs_refactorisation(2e-2), "the steps grow");
    }
}
