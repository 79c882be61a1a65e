//! Newton's method with a lagged factor, quasi-Newton updates and a choice of globalisation.
//!
//! Direction −H g, where H is the inverse of the last factor, rotated with the body since ([`NodalRotations`]) and corrected by L-BFGS pairs of
//! the steps since. A new factorisation is made only when the old factor converges too slowly.
//!
//! [`Globalisation::LineSearch`] lowers the energy in each step. [`Globalisation::FullStep`] takes whole steps with the mixed-integration-point
//! tangent [magisano2017]: a large rotation of a stiff thin sheet stretches it in second order, and a line search on the energy would cut every
//! step short. A watchdog [chamberlain1982] ends them: near the buckle of a wall they leap along its soft mode, and the energy does not fall
//! below its lowest value again.

use crate::assembly::rotation::NodalRotations;
use crate::newton::line_search::{LineSearch, MAX_TRIALS};
use crate::newton::options::{Globalisation, IterationState, NewtonCounts, NewtonOptions, NonConvergence};
use crate::newton::potential::{Energy, HessianKind, Potential};
use crate::system_data::SystemData;
use si::Metre;
use sparse::{Factor, FactorError, LbfgsHistory, RankOneUpdates, dot, max_abs};

/// Fraction of the body's size by which one step may move a node: beyond it the tangent predicts little.
const MAX_STEP: f64 = 0.3;
/// Fraction of the body's size below which every step lowers the energy: so short a rotation hardly stretches a sheet.
// With this and the watchdog 24 levels of a thin tail to 300 mbar took 23 s; with full steps alone one took 22 s, another had no equilibrium.
const SHORT: f64 = 2e-3;
/// Halvings of a full step that inverts an element.
const MAX_HALVINGS: usize = 6;

/// Numbers of the iteration, kept from solve to solve.
pub(crate) struct Newton {
    /// Lower triangle of the last assembled tangent.
    pub tangent: Vec<f64>,
    /// Its rank-one terms (sealed chambers).
    pub rank_one: RankOneUpdates,
    factor: Factor,
    /// Rank-one terms of the factorised tangent.
    factor_rank_one: RankOneUpdates,
    history: LbfgsHistory,
    /// Displacement at the last factorisation, 3 entries per node.
    factorised_at: Vec<f64>,
    /// Rotation of the body since.
    rotation: Option<NodalRotations>,
    gradient: Vec<f64>,
    trial_gradient: Vec<f64>,
    /// Counts of all solves so far, failed ones included.
    pub spent: NewtonCounts,
    /// Asked before each iteration whether to stop.
    pub interrupt: Option<Interrupt>,
}

/// A question that is asked before each Newton iteration: whether the solve shall end with [`NonConvergence::Interrupted`].
pub type Interrupt = std::sync::Arc<dyn Fn() -> bool + Send + Sync>;

/// A Newton direction.
struct Direction {
    /// −H g in elimination order.
    step: Vec<f64>,
    /// Largest change of a dof, m.
    size: Metre,
}

/// Why no step along the direction of a fresh factor was accepted.
fn step_failure(globalisation: Globalisation, iterations: usize) -> NonConvergence {
    match globalisation {
        Globalisation::FullStep => NonConvergence::InvertedElement,
        Globalisation::LineSearch => NonConvergence::LineSearchFailed { iterations },
    }
}

impl Newton {
    pub fn new(data: &SystemData) -> Self {
        let full = data.full_length();
        Self {
            tangent: vec![0.0; data.pattern.entries()],
            rank_one: RankOneUpdates::default(),
            factor: Factor::new(&data.symbolic),
            factor_rank_one: RankOneUpdates::default(),
            history: LbfgsHistory::default(),
            factorised_at: vec![0.0; full],
            rotation: None,
            gradient: vec![0.0; full],
            trial_gradient: vec![0.0; full],
            spent: NewtonCounts::default(),
            interrupt: None,
        }
    }

    /// Whether a factor exists.
    pub(crate) fn is_ready(&self) -> bool {
        self.factor.is_ready()
    }

    /// Moves `u` (3 entries per node, m) to a minimum of `potential`; `previous` is where a straight line to `u` began, if one did.
    ///
    /// # Errors
    /// [`NonConvergence`]; `u` is then somewhere on the way.
    pub fn minimise(
        &mut self,
        potential: &Potential,
        u: &mut [f64],
        previous: Option<&[f64]>,
        options: &NewtonOptions,
    ) -> Result<NewtonCounts, NonConvergence> {
        let energy = potential.energy(u, &mut self.gradient);
        if !energy.value.is_finite() {
            return Err(NonConvergence::InvertedElement);
        }
        let options = NewtonOptions { refactorise: options.refactorise || !self.is_ready(), ..*options };
        let mut state = IterationState::new(options, previous, energy);
        self.history.clear();
        self.rotate_factor_to(potential, u);
        let outcome = self.iterate_until_converged(potential, u, &mut state, &options);
        self.spent.add_counts(state.counts);
        outcome.map(|()| state.counts)
    }

    fn iterate_until_converged(
        &mut self,
        potential: &Potential,
        u: &mut [f64],
        state: &mut IterationState,
        options: &NewtonOptions,
    ) -> Result<(), NonConvergence> {
        while state.counts.iterations < options.max_iterations {
            if self.iterate(potential, u, state, options)? {
                return Ok(());
            }
        }
        let NewtonCounts { iterations, .. } = state.counts;
        Err(NonConvergence::IterationLimit { step: state.last_step, iterations, tolerance: options.tolerance })
    }

    /// One direction and the step along it; whether it was the last.
    fn iterate(
        &mut self,
        potential: &Potential,
        u: &mut [f64],
        state: &mut IterationState,
        options: &NewtonOptions,
    ) -> Result<bool, NonConvergence> {
        self.check_interrupt()?;
        let fresh = std::mem::take(&mut state.refactorise);
        if fresh {
            self.refactorise_state(potential, u, state, options)?;
        }
        let direction = self.newton_direction(potential, fresh)?;
        let size = direction.size;
        state.counts.iterations += 1;
        if size <= options.tolerance {
            potential.data.pattern.scatter(&direction.step, 1.0, u);
            return Ok(true);
        }
        let short = size < SHORT * potential.data.size;
        let globalisation = if short { Globalisation::LineSearch } else { state.globalisation };
        let slides = globalisation == Globalisation::LineSearch && state.descends_negative_curvature(size);
        if !fresh && !slides && state.needs_refactorisation(size) {
            state.refactorise = true;
            return Ok(false);
        }
        state.previous = Some(u.to_vec());
        match self.take_step(potential, u, &direction, (state.energy, globalisation)) {
            Some((next, whole)) => {
                state.energy = next;
                // A shortened step means that the factor describes the energy badly here.
                state.refactorise = !whole;
                state.count_step(size);
                self.return_to_lowest(potential, u, state);
            }
            None if !fresh => state.refactorise = true,
            None => return Err(step_failure(globalisation, state.counts.iterations)),
        }
        Ok(false)
    }

    fn check_interrupt(&self) -> Result<(), NonConvergence> {
        match &self.interrupt {
            Some(interrupted) if interrupted() => Err(NonConvergence::Interrupted),
            _ => Ok(()),
        }
    }

    /// Returns to the point of lowest energy where the watchdog ends the full steps.
    fn return_to_lowest(&mut self, potential: &Potential, u: &mut [f64], state: &mut IterationState) {
        if let Some(lowest) = state.watch_energy(u) {
            u.copy_from_slice(&lowest);
            state.energy = potential.energy(u, &mut self.gradient);
        }
    }

    /// A new factorisation at `u`, counted in the state.
    ///
    /// # Errors
    /// [`NonConvergence`] where none succeeds, or stability is lost.
    fn refactorise_state(
        &mut self,
        potential: &Potential,
        u: &[f64],
        state: &mut IterationState,
        options: &NewtonOptions,
    ) -> Result<(), NonConvergence> {
        let full_steps = state.globalisation == Globalisation::FullStep;
        let previous = state.previous.as_deref().filter(|_| full_steps);
        let first = options.predicted && state.counts.factorisations == 0;
        let is_exact = self.refactorise(potential, u, previous, first)?;
        state.count_factorisation(is_exact);
        state.check_stability(u, potential.data.size)
    }

    /// Factorises the tangent at `u`, or the largest convex part of it; whether it was the tangent itself. `predicted`: `u` is a predicted shape.
    fn refactorise(
        &mut self,
        potential: &Potential,
        u: &[f64],
        previous: Option<&[f64]>,
        predicted: bool,
    ) -> Result<bool, NonConvergence> {
        let probe = potential.data.pattern.gather(&self.gradient);
        // Each alternative keeps less of the second derivative. The last one is always positive definite, so that a body in
        // snap-through, whose exact tangent is indefinite, still has a direction of descent.
        use HessianKind::{Convex, ConvexElastic, Exact, FormerStress, MixedPoint};
        let kinds = [FormerStress, MixedPoint, Exact, ConvexElastic, Convex];
        let first = if previous.is_none() { 2 } else { usize::from(!predicted) };
        for &kind in &kinds[first..] {
            potential.hessian(u, previous.unwrap_or(&[]), kind, &mut self.tangent);
            self.rank_one = RankOneUpdates::new(potential.rank_one_terms(u));
            match self.factorise(potential, u, &probe) {
                Ok(()) => return Ok(!matches!(kind, ConvexElastic | Convex)),
                Err(FactorError::Inaccurate { residual }) => return Err(NonConvergence::InaccurateFactor { residual }),
                Err(_) => {}
            }
        }
        Err(NonConvergence::NotFinite)
    }

    /// Factorises `tangent`, assembled at `u`, and prepares its rank-one terms.
    ///
    /// # Errors
    /// [`FactorError`]
    pub fn factorise(&mut self, potential: &Potential, u: &[f64], probe: &[f64]) -> Result<(), FactorError> {
        let symbolic = &potential.data.symbolic;
        self.history.clear();
        self.rotation = None;
        self.factorised_at.copy_from_slice(u);
        self.factor.compute(symbolic, &potential.data.pattern, &self.tangent, probe)?;
        self.factor_rank_one = RankOneUpdates::new(potential.rank_one_terms(u));
        let factor = &mut self.factor;
        if self.factor_rank_one.prepare_solves(|x| factor.solve(symbolic, x)) {
            Ok(())
        } else {
            Err(FactorError::NotPositiveDefinite)
        }
    }

    /// Rotates the lagged factor to `u`.
    // The stiffness of a law that is not objective does not turn with the body.
    pub(crate) fn rotate_factor_to(&mut self, potential: &Potential, u: &[f64]) {
        let turns = potential.elastic.iter().any(|elastic| elastic.material.is_objective());
        let rotation_between = || NodalRotations::between(&potential.body(), &self.factorised_at, u);
        self.rotation = (self.is_ready() && turns).then(rotation_between);
    }

    /// x ← H x by the rotated factor alone, in elimination order: the preconditioner of all solves.
    pub fn solve(&mut self, data: &SystemData, x: &mut [f64]) {
        let dofs = &data.pattern.dof;
        self.rotation.iter().for_each(|rotation| rotation.apply(dofs, true, x));
        self.factor.solve(&data.symbolic, x);
        self.factor_rank_one.correct_solution(x);
        self.rotation.iter().for_each(|rotation| rotation.apply(dofs, false, x));
    }

    /// The direction at the gradient; right after a factorisation, which was checked with the gradient, its solution is at hand.
    fn newton_direction(&mut self, potential: &Potential, fresh: bool) -> Result<Direction, NonConvergence> {
        let mut step = match self.factor.take_probe_solution().filter(|_| fresh) {
            Some(mut solution) => {
                self.factor_rank_one.correct_solution(&mut solution);
                solution
            }
            None => {
                let (mut step, history) =
                    (potential.data.pattern.gather(&self.gradient), std::mem::take(&mut self.history));
                history.apply(&mut step, |x| self.solve(potential.data, x));
                self.history = history;
                step
            }
        };
        step.iter_mut().for_each(|entry| *entry = -*entry);
        if !step.iter().all(|entry| entry.is_finite()) {
            return Err(NonConvergence::NotFinite);
        }
        let size = max_abs(&step);
        Ok(Direction { step, size })
    }

    /// Goes along `direction` from the energy `start`: with a line search as far as the energy falls, with full steps as far as no element is
    /// inverted. Returns the energy there, and whether it was the whole step.
    fn take_step(
        &mut self,
        potential: &Potential,
        u: &mut [f64],
        direction: &Direction,
        (start, globalisation): (Energy, Globalisation),
    ) -> Option<(Energy, bool)> {
        let pattern = &potential.data.pattern;
        let old = pattern.gather(&self.gradient);
        let search = LineSearch { start, slope: dot(&old, &direction.step) };
        let mut part = (MAX_STEP * potential.data.size / direction.size).min(1.0);
        part *= potential.admissible_part(u, &pattern.scattered(&direction.step, part, u.len()));
        let mut trial = u.to_vec();
        for _ in 0..if globalisation == Globalisation::LineSearch { MAX_TRIALS } else { MAX_HALVINGS } {
            trial.copy_from_slice(u);
            pattern.scatter(&direction.step, part, &mut trial);
            let energy = potential.energy(&trial, &mut self.trial_gradient);
            let new = pattern.gather(&self.trial_gradient);
            let accepted = match globalisation {
                Globalisation::LineSearch => search.accepts(part, energy, dot(&new, &direction.step)),
                Globalisation::FullStep => energy.value.is_finite(),
            };
            if accepted {
                u.copy_from_slice(&trial);
                std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                let step = direction.step.iter().map(|entry| part * entry).collect();
                self.history.push(step, new.iter().zip(&old).map(|(new, old)| new - old).collect());
                return Some((energy, part == 1.0));
            }
            part *= search.shorten(part, energy);
        }
        None
    }
}
