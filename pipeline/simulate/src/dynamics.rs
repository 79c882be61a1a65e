//! Time integration of a motion.

use fem::{DynamicSettings, Equilibrium, InitialValueProblem, SolveError, Solver, State, StaticSettings, StepControl};
use si::Second;

use crate::budget::{Budget, Watch};
use crate::case::{Dynamic, Start, Steps};
use crate::frames::Frame;
use crate::loads::Loads;
use crate::probes::Solved;
use crate::{Simulation, Summary};
use diagnostics::{Diagnostic, Result};

/// Default number of steps between frames.
const FRAME_EVERY: usize = 10;
/// Number of progress lines with a fixed step.
const LINES: usize = 20;

/// Integrates the whole duration.
///
/// # Errors
/// A [`Diagnostic`] that names the time at which no motion was found; everything up to it, and the last state, is then written.
pub(super) fn solve_motion(set: &Dynamic, simulation: Simulation) -> Result<Summary> {
    let Simulation { case, body, budget, .. } = simulation;
    let mut solver = body.solver(case)?;
    let loads = body.loads(case);
    let mut initial = State::rest(body.solid.nodes().len());
    if set.start == Start::Equilibrium {
        let equilibrium = start_equilibrium(&mut solver, &loads, &budget);
        initial.displacement = equilibrium.map_err(|e| Diagnostic::from(e).while_doing("the start"))?.displacement;
    }
    // the output needs the solver's gas law while the integration borrows the solver
    let reader = body.solver(case)?;
    let last = (0.0, initial.clone());
    let clock = simulation.watch.clone();
    let mut watch = Watcher { simulation, reader: &reader, loads: loads.clone(), steps: 0, last, diagnostic: None };
    watch.see_state(0.0, &initial);
    let lost = {
        let mut observe = |time: Second, state: &State| {
            clock.restart();
            watch.next(time, state);
        };
        let pressures = |time: Second| loads.pressures_at(time);
        let problem = InitialValueProblem { settings: &set.settings(), initial: &initial, pressures: &pressures };
        integrate_motion(set, &mut solver, &problem, &mut observe).err()
    };
    watch.end_motion(lost, &clock)
}

/// The equilibrium in which a motion begins that starts in one: under the loads of time 0. The solver has the dead forces.
///
/// # Errors
/// [`SolveError`]
pub fn start_equilibrium(
    solver: &mut Solver,
    loads: &Loads,
    budget: &Budget,
) -> std::result::Result<Equilibrium, SolveError> {
    solver.equilibrium(&loads.pressures_at(0.0), None, &budget.limiting(StaticSettings::default()))
}

impl Dynamic {
    /// How it is integrated.
    pub fn settings(&self) -> DynamicSettings {
        let scheme = self.scheme.into();
        let (mass_damping, stiffness_damping) = (self.mass_damping, self.stiffness_damping);
        let settings = DynamicSettings { scheme, mass_damping, stiffness_damping, ..DynamicSettings::default() };
        DynamicSettings { step: self.step.unwrap_or(settings.step), ..settings }
    }
}

impl Steps {
    /// As the solver takes them.
    pub fn control(&self) -> StepControl {
        StepControl { tolerance: self.tolerance, shortest: self.shortest, longest: self.longest }
    }
}

fn integrate_motion(
    set: &Dynamic,
    solver: &mut Solver,
    problem: &InitialValueProblem,
    observe: &mut dyn FnMut(Second, &State),
) -> Result<(), SolveError> {
    match (set.step, set.adaptive) {
        (Some(step), _) => {
            let steps = (set.duration / step).round() as usize;
            solver.integrate(problem, steps, observe).map(|_| ())
        }
        (None, Some(bounds)) => {
            solver.integrate_adaptive(problem, &bounds.control(), set.duration, observe).map(|_| ())
        }
        (None, None) => Ok(()),
    }
}

/// Receives every state of the integration.
struct Watcher<'a> {
    simulation: Simulation<'a>,
    reader: &'a Solver,
    loads: Loads,
    steps: usize,
    last: (Second, State),
    /// The first error of writing.
    diagnostic: Option<Diagnostic>,
}

impl Watcher<'_> {
    fn next(&mut self, time: Second, state: &State) {
        self.steps += 1;
        self.see_state(time, state);
        let planned =
            self.simulation.case.dynamic.as_ref().and_then(|set| Some((set.duration / set.step?).round() as usize));
        if self.steps.is_multiple_of(planned.map_or(LINES, |steps| steps.div_ceil(LINES).max(1))) {
            let fastest = state.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            self.simulation
                .console
                .print_line(&format!("step {} at {time:.6} s: fastest {fastest:.3e} m/s", self.steps));
        }
        self.last = (time, state.clone());
    }

    fn see_state(&mut self, time: Second, state: &State) {
        if self.diagnostic.is_none() {
            self.diagnostic = self.write_step(time, state).err();
        }
    }

    fn write_step(&mut self, time: Second, state: &State) -> Result<()> {
        let Simulation { case, body, written, .. } = &mut self.simulation;
        if self.steps.is_multiple_of(case.output.every) {
            let pressures = self.loads.pressures_at(time);
            let solved = Solved { at: time, displacement: &state.displacement, pressures: &pressures, stability: None };
            written.table.write_row(body, self.reader, &solved)?;
        }
        let every = case.output.vtu_every.unwrap_or(FRAME_EVERY);
        if every > 0 && self.steps.is_multiple_of(every) {
            let name = written.frames.next_name();
            written.frames.write_frame(&name, time, body, &state_frame(state, self.reader))?;
        }
        Ok(())
    }

    /// The summary, or the diagnostic with the last state kept.
    fn end_motion(mut self, lost: Option<SolveError>, clock: &Watch) -> Result<Summary> {
        if let Some(diagnostic) = self.diagnostic.take() {
            return Err(diagnostic);
        }
        let Some(lost) = lost else {
            return Ok(Summary { dofs: 0, solved: self.steps, iterations: None, folder: Default::default() });
        };
        let (time, state) = &self.last;
        let Simulation { body, written, .. } = &mut self.simulation;
        let path = written.frames.write_frame("last_converged.vtu", *time, body, &state_frame(state, self.reader))?;
        Err(lost_step(lost, *time, clock).noting(format!("last converged state: {}", path.display())))
    }
}

fn state_frame<'a>(state: &'a State, reader: &'a Solver) -> Frame<'a> {
    let (displacement, velocity) = (&state.displacement, Some(state.velocity.as_slice()));
    Frame { displacement, velocity, mode: None, properties: reader.properties() }
}

/// A motion that ended at the state of `time`, as it is reported.
pub fn lost_step(cause: SolveError, time: Second, clock: &Watch) -> Diagnostic {
    match clock.exceeded() {
        None => Diagnostic::from(cause),
        Some(limit) => Diagnostic::new(
            format!("no motion is found beyond {time:.6} s"),
            limit.to_string(),
            "take a smaller time step or smoother pressures, or raise the limit",
        )
        .caused_by(limit),
    }
}
