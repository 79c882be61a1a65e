//! Incremental loading (load stepping) with Newton's method.
//!
//! From a nearby initial guess Newton's method solves for the whole load at once. Where that fails, the force that is
//! unbalanced at the guess fades out in steps, and from rest the load factor is raised in steps: a [`Homotopy`] either
//! way, followed with linear extrapolation. A failed step is halved, an easy one lengthens the next. A short step that
//! still fails is solved with a line search, and at last by pseudo-transient continuation, which passes the snap-through
//! of a thin wall.

use crate::inputs::AppliedLoad;
use crate::newton::options::{Globalisation, NewtonOptions, NonConvergence};
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::{Equilibrium, StaticSettings};
use crate::statics::homotopy::Homotopy;
use si::Pascal;
use sparse::dot;

/// Tolerance of intermediate load steps, as a fraction of the body's size: they only lead to the next.
const INTERMEDIATE_TOLERANCE: f64 = 1e-5;
/// Smallest load step, as a fraction of the load.
const MIN_STEP: f64 = 1.0 / 256.0;
/// A load step that full steps do not solve is halved while it is longer than this; then the line search is tried.
// Three halvings of the usual first step of a third.
const LINE_SEARCH_BELOW: f64 = 1.0 / 24.0;
/// A load step with this many factorisations or fewer makes the next one half as long again.
const EASY: usize = 8;
/// Full-step iterations at most before the line search is tried: those that converge need 4 to 12.
const MAX_FULL_STEPS: usize = 25;
/// A lagged factor is replaced when it is predicted to need more iterations than this: a factorisation costs about as
/// much.
const MAX_PREDICTED: f64 = 8.0;

/// First and smallest step in which an unbalanced force fades out.
const FIRST_FADE: f64 = 1.0 / 4.0;
const MIN_FADE: f64 = 1.0 / 32.0;
/// Halvings of such a step: a step that fails is rather too long than without an equilibrium.
const FADE_HALVINGS: usize = 4;

/// States of a path, each with its s.
type Path = Vec<(f64, Equilibrium)>;

/// Lengths of the steps along a path, as fractions of the whole.
struct Steps<'a> {
    first: f64,
    shortest: f64,
    /// Halvings at most.
    halvings: usize,
    /// Whether a short step that fails is solved by descent of the energy.
    descent: bool,
    settings: &'a StaticSettings,
}

impl SolverState {
    /// See [`crate::Solver::equilibrium`].
    pub(crate) fn equilibrium(
        &mut self,
        pressures: &[Pascal],
        initial_guess: Option<&[f64]>,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        self.check_pressures(pressures)?;
        check_settings(settings)?;
        self.linearised = None;
        if let Some(guess) = initial_guess {
            self.check_field("the initial guess", guess)?;
            let mut direct = self.at_rest(pressures);
            direct.displacement = self.follow_clamps(guess, pressures, 1.0);
            let options = self.full_steps(settings.tolerance, settings);
            if settings.reuse_factor && self.warm_start(&mut direct, pressures, &options) {
                return Ok(self.finished_equilibrium(direct, false));
            }
            let previous = self.moves_clamps().then_some(guess);
            if self.newton_solve(&mut direct, previous, AppliedLoad::whole(pressures), &options).is_ok() {
                return Ok(self.finished_equilibrium(direct, false));
            }
            if let Some(found) = self.fade_out(&self.with_clamps_at(guess, 1.0), pressures, settings) {
                return Ok(found);
            }
        }
        self.load_stepping(pressures, settings)
    }

    /// See [`crate::Solver::equilibrium_near`].
    pub(crate) fn equilibrium_near(
        &mut self,
        pressures: &[Pascal],
        nearby: &[f64],
        predicted: &[f64],
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        self.check_pressures(pressures)?;
        check_settings(settings)?;
        self.check_field("the nearby shape", nearby)?;
        self.check_field("the predicted shape", predicted)?;
        self.linearised = None;
        let mut solution = self.at_rest(pressures);
        let previous = self.with_clamps_at(nearby, 1.0);
        solution.displacement = self.admissible_shape(&previous, self.with_clamps_at(predicted, 1.0));
        let options = NewtonOptions {
            max_iterations: settings.max_iterations,
            predicted: true,
            ..self.full_steps(settings.tolerance, settings)
        };
        let load = AppliedLoad::whole(pressures);
        // An interpolated shape stretches a stiff sheet where it rotates, and the stress of that stretch makes the tangent indefinite: the
        // first one has the stress of the nearby shape.
        match self.newton_solve(&mut solution, Some(&previous), load, &options) {
            Ok(_) => Ok(self.finished_equilibrium(solution, false)),
            Err(cause) => Err(self.no_equilibrium(vec![(0.0, self.at_rest(pressures))], 1.0, pressures, cause)),
        }
    }

    /// Moves `state` to its equilibrium on the lagged factor; whether it converged.
    fn warm_start(&mut self, state: &mut Equilibrium, pressures: &[Pascal], options: &NewtonOptions) -> bool {
        let potential = self.inputs.at_rest(&self.data, pressures);
        let ready = self.newton.is_ready();
        let counts = ready.then(|| self.newton.warm_start(&potential, &mut state.displacement, options)).flatten();
        state.iterations += counts.map_or(0, |counts| counts.iterations);
        counts.is_some()
    }

    /// Raises the load factor from 0 to 1.
    fn load_stepping(&mut self, pressures: &[Pascal], settings: &StaticSettings) -> Result<Equilibrium, SolveError> {
        let (first, halvings) = (1.0 / settings.load_steps.max(1) as f64, settings.max_halvings);
        let steps = Steps { first, shortest: MIN_STEP, halvings, descent: true, settings };
        let result = self.follow_homotopy(self.at_rest(pressures), &Homotopy::Rest(pressures), &steps);
        match result {
            Ok(end) => Ok(self.finished_equilibrium(end, true)),
            Err((path, step, cause)) => Err(self.no_equilibrium(path, step, pressures, cause)),
        }
    }

    /// Fades out the force that `pressures` leave unbalanced at `shape`; none where that fails.
    // Through the buckle of a wall this takes some ten short steps; load stepping from rest repeats the whole path.
    fn fade_out(&mut self, shape: &[f64], pressures: &[Pascal], settings: &StaticSettings) -> Option<Equilibrium> {
        let mut start = self.at_rest(pressures);
        start.displacement.copy_from_slice(shape);
        let mut unbalanced = vec![0.0; shape.len()];
        let energy = self.inputs.at_rest(&self.data, pressures).energy(shape, &mut unbalanced);
        let steps = Steps { first: FIRST_FADE, shortest: MIN_FADE, halvings: FADE_HALVINGS, descent: false, settings };
        let follow = || self.follow_homotopy(start, &Homotopy::Shape(pressures, unbalanced), &steps).ok();
        // A guess with an inverted element has no force that could fade.
        energy.value.is_finite().then(follow).flatten().map(|at| self.finished_equilibrium(at, false))
    }

    /// The end of the path that begins with `start`, which is in equilibrium at s = 0.
    ///
    /// # Errors
    /// The path as far as it was found, the length of the step that failed, and why.
    fn follow_homotopy(
        &mut self,
        start: Equilibrium,
        homotopy: &Homotopy,
        steps: &Steps,
    ) -> Result<Equilibrium, (Path, f64, NonConvergence)> {
        let mut path = vec![(0.0, start)];
        let mut step = steps.first;
        let mut halved = 0;
        loop {
            let reached = path[path.len() - 1].0;
            let target = if reached + step > 1.0 - MIN_STEP { 1.0 } else { reached + step };
            match self.advance_to(target, &path, homotopy, steps) {
                Ok((at, _)) if target == 1.0 => return Ok(at),
                Ok((at, factorisations)) => {
                    path.push((target, at));
                    path.drain(..path.len() - 2);
                    step *= if factorisations <= EASY { 1.5 } else { 1.0 };
                }
                Err(cause)
                    if cause != NonConvergence::Interrupted && step > steps.shortest && halved < steps.halvings =>
                {
                    step *= 0.5;
                    halved += 1;
                }
                Err(cause) => return Err((path, step, cause)),
            }
        }
    }

    /// One step to s = `target`, from the extrapolated path or, when that inverts an element, from its end.
    fn advance_to(
        &mut self,
        target: f64,
        path: &[(f64, Equilibrium)],
        homotopy: &Homotopy,
        steps: &Steps,
    ) -> Result<(Equilibrium, usize), NonConvergence> {
        let settings = steps.settings;
        let tolerance = if target == 1.0 { settings.tolerance } else { settings.tolerance.max(INTERMEDIATE_TOLERANCE) };
        let full_steps = self.full_steps(tolerance, settings);
        let globalisation = Globalisation::LineSearch;
        let line_search = NewtonOptions { globalisation, max_iterations: settings.max_iterations, ..full_steps };
        let loads = homotopy.loads_at(target);
        let (_, end) = &path[path.len() - 1];
        let [last, guess] = self.shapes_before((path, target), loads.applied_load().load_factor);
        let previous = (path.len() > 1 || self.moves_clamps()).then_some(end.displacement.as_slice());
        let state_from = |shape: &[f64]| {
            let (displacement, pressures) = (shape.to_vec(), loads.pressures.clone());
            Equilibrium { displacement, pressures, ..end.clone() }
        };
        let mut attempt = |shape: &[f64], previous, options| {
            let mut next = state_from(shape);
            self.newton_solve(&mut next, previous, loads.applied_load(), options).map(|count| (next, count))
        };
        // Full steps first: for stiff sheets in large rotation they need 4 to 12 iterations where a line search on the
        // energy needs many times as many. The line search is the fallback, because it converges through snap-through.
        let full = attempt(&guess, previous, &full_steps);
        if full.is_ok() || !steps.descent || target - path[path.len() - 1].0 > LINE_SEARCH_BELOW {
            return full;
        }
        let mut solution = attempt(&guess, None, &line_search);
        if solution == Err(NonConvergence::InvertedElement) {
            solution = attempt(&last, None, &line_search);
        }
        solution.or_else(|_| {
            let mut next = state_from(&last);
            self.pseudo_transient(&mut next, loads.applied_load(), &line_search).map(|count| (next, count))
        })
    }

    /// The end of a path with its clamps at a `part` of what is prescribed, and the shape predicted at s = `target`.
    fn shapes_before(&mut self, (path, target): (&[(f64, Equilibrium)], f64), part: f64) -> [Vec<f64>; 2] {
        let (_, end) = &path[path.len() - 1];
        let last = self.with_clamps_at(&end.displacement, part);
        let predicted = match path.len() {
            1 => self.follow_clamps(&end.displacement, &end.pressures, part),
            _ => extrapolated_shape(path, target),
        };
        let guess = self.admissible_shape(&last, predicted);
        [last, guess]
    }

    /// Moves `at` to its equilibrium under `load` by Newton's method; returns the number of factorisations.
    pub(crate) fn newton_solve(
        &mut self,
        at: &mut Equilibrium,
        previous: Option<&[f64]>,
        load: AppliedLoad,
        options: &NewtonOptions,
    ) -> Result<usize, NonConvergence> {
        self.couple_contact(&at.displacement)?;
        let mut factorisations = 0;
        // A solve that brought further walls into contact is repeated with their couplings, from its end.
        loop {
            let potential = self.inputs.static_potential(&self.data, load);
            let counts = self.newton.minimise(&potential, &mut at.displacement, previous, options)?;
            at.iterations += counts.iterations;
            at.factorisations += counts.factorisations;
            factorisations += counts.factorisations;
            if counts.indefinite > 0 {
                at.snap_through.push(load.load_factor);
            }
            if !self.couple_contact(&at.displacement)? {
                return Ok(factorisations);
            }
        }
    }

    fn at_rest(&self, pressures: &[Pascal]) -> Equilibrium {
        Equilibrium {
            displacement: vec![0.0; self.data.full_length()],
            pressures: pressures.to_vec(),
            iterations: 0,
            factorisations: 0,
            residual: 0.0,
            load_stepped: false,
            snap_through: Vec::new(),
        }
    }

    /// Full steps beginning with a new factorisation.
    fn full_steps(&self, tolerance: f64, settings: &StaticSettings) -> NewtonOptions {
        NewtonOptions {
            tolerance: tolerance * self.data.size,
            max_iterations: settings.max_iterations.min(MAX_FULL_STEPS),
            max_predicted: MAX_PREDICTED,
            min_steps: 1,
            refactorise: true,
            predicted: false,
            globalisation: Globalisation::FullStep,
        }
    }

    fn finished_equilibrium(&self, mut at: Equilibrium, load_stepped: bool) -> Equilibrium {
        at.load_stepped = load_stepped;
        at.residual = self.relative_residual(&at);
        at
    }

    /// ‖∂Π/∂u‖ at free dofs over ‖∂Ψ/∂u‖ there, or at all dofs where clamps are displaced: they may be all that loads the body. 0 where there is
    /// no elastic force.
    fn relative_residual(&self, at: &Equilibrium) -> f64 {
        let norm = |full: &[f64]| {
            let free = self.data.pattern.gather(full);
            dot(&free, &free).sqrt()
        };
        let mut gradient = vec![0.0; at.displacement.len()];
        self.inputs.at_rest(&self.data, &at.pressures).energy(&at.displacement, &mut gradient);
        let unbalanced = norm(&gradient);
        let forces = self.elastic_forces(&at.displacement);
        let elastic = if self.moves_clamps() { dot(&forces, &forces).sqrt() } else { norm(&forces) };
        if elastic > 0.0 { unbalanced / elastic } else { 0.0 }
    }

    fn no_equilibrium(
        &self,
        mut path: Path,
        load_step: f64,
        pressures: &[Pascal],
        cause: NonConvergence,
    ) -> SolveError {
        let (load_factor, at) = path.swap_remove(path.len() - 1);
        let larger = |most: f64, pressure: &f64| if pressure.abs() > most.abs() { *pressure } else { most };
        let pressure = pressures.iter().fold(0.0, larger);
        let last_converged = (load_factor > 0.0).then(|| Box::new(self.finished_equilibrium(at, true)));
        SolveError::NoEquilibrium { load_factor, load_step, pressure, cause, last_converged }
    }
}

/// The straight line through the last two states of the path, at the load factor `target`.
fn extrapolated_shape(path: &[(f64, Equilibrium)], target: f64) -> Vec<f64> {
    let (reached, end) = &path[path.len() - 1];
    let Some((earlier, start)) = path.len().checked_sub(2).map(|at| &path[at]) else {
        return end.displacement.clone();
    };
    let part = (target - reached) / (reached - earlier);
    end.displacement.iter().zip(&start.displacement).map(|(now, then)| now + part * (now - then)).collect()
}

fn check_settings(settings: &StaticSettings) -> Result<(), SolveError> {
    if !(settings.tolerance > 0.0 && settings.tolerance <= 1e-2) {
        let (what, range) = ("the tolerance", "above 0 and at most 0.01 of the body's size");
        return Err(SolveError::Setting { what, value: settings.tolerance, range });
    }
    if settings.max_iterations == 0 {
        return Err(SolveError::Setting { what: "max_iterations", value: 0.0, range: "at least 1" });
    }
    Ok(())
}
