//! Dynamics: a motion, step after step.
//!
//! Stands on: `body`, fem. Never knows: a file's format.

use fem::{Adaptive, March, SolveError, Solver, State, StaticSettings};
use si::{Pascal, Second};

use super::body::Body;
use super::frames::Frame;
use super::{Summary, Telling, Written};
use crate::case::{Case, Dynamic, Scheme, Start};
use crate::fault::{Fault, Outcome};

/// A frame each so many steps, when the case does not say.
const FRAME_EVERY: usize = 10;
/// Lines of progress in a march of steps of one length.
const LINES: usize = 20;

/// Moves through the whole duration.
///
/// # Errors
/// A [`Fault`] that names the time at which no motion was found; everything up to it, and the last state, is then written.
pub(super) fn solve(
    case: &Case,
    set: &Dynamic,
    body: &Body,
    written: &mut Written,
    telling: &Telling,
) -> Outcome<Summary> {
    let mut solver = body.solver(case)?;
    let pressures = |time: Second| body.pressures(case, |chamber| chamber.pressure.at(time));
    let initial = initial(set, body, &mut solver, &pressures(0.0))?;
    // what is written needs the solver's gas law while the march borrows the solver
    let reader = body.solver(case)?;
    let mut watch =
        Watch { case, body, reader: &reader, written, telling, steps: 0, last: (0.0, initial.clone()), fault: None };
    watch.see(0.0, &initial);
    let lost = {
        let mut observe = |time: Second, state: &State| watch.next(time, state);
        march(set, &mut solver, &initial, &pressures, &mut observe).err()
    };
    watch.end(lost)
}

fn initial(set: &Dynamic, body: &Body, solver: &mut Solver, pressures: &[Pascal]) -> Outcome<State> {
    let mut state = State::rest(body.solid.nodes().len());
    if set.start == Start::Equilibrium {
        let found = solver.equilibrium(pressures, None, &StaticSettings::default());
        state.displacement = found.map_err(|e| Fault::from_tool(format!("the start: {e}")))?.displacement;
    }
    Ok(state)
}

fn march(
    set: &Dynamic,
    solver: &mut Solver,
    initial: &State,
    pressures: &dyn Fn(Second) -> Vec<Pascal>,
    observe: &mut dyn FnMut(Second, &State),
) -> Result<(), SolveError> {
    let scheme = match set.scheme {
        Scheme::ImplicitEuler => fem::Scheme::ImplicitEuler,
        Scheme::Bdf2 => fem::Scheme::Bdf2,
    };
    let (mass_damping, stiffness_damping) = (set.mass_damping, set.stiffness_damping);
    let march = March { scheme, mass_damping, stiffness_damping, ..March::default() };
    match (set.step, set.adaptive) {
        (Some(step), _) => {
            let steps = (set.duration / step).round() as usize;
            solver.march(&March { step, ..march }, initial, pressures, steps, observe).map(|_| ())
        }
        (None, Some(bounds)) => {
            let bounds = Adaptive { tolerance: bounds.tolerance, shortest: bounds.shortest, longest: bounds.longest };
            solver.march_adaptive(&march, &bounds, initial, pressures, set.duration, observe).map(|_| ())
        }
        (None, None) => Ok(()),
    }
}

/// Sees every state of a march.
struct Watch<'a> {
    case: &'a Case,
    body: &'a Body<'a>,
    reader: &'a Solver,
    written: &'a mut Written,
    telling: &'a Telling,
    steps: usize,
    last: (Second, State),
    /// The first thing that could not be written.
    fault: Option<Fault>,
}

impl Watch<'_> {
    fn next(&mut self, time: Second, state: &State) {
        self.steps += 1;
        self.see(time, state);
        let planned = self.case.dynamic.as_ref().and_then(|set| Some((set.duration / set.step?).round() as usize));
        if self.steps.is_multiple_of(planned.map_or(LINES, |steps| steps.div_ceil(LINES).max(1))) {
            let fastest = state.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            self.telling.line(&format!("step {} at {time:.6} s: fastest {fastest:.3e} m/s", self.steps));
        }
        self.last = (time, state.clone());
    }

    fn see(&mut self, time: Second, state: &State) {
        if self.fault.is_none() {
            self.fault = self.write(time, state).err();
        }
    }

    fn write(&mut self, time: Second, state: &State) -> Outcome<()> {
        if self.steps.is_multiple_of(self.case.output.every) {
            let pressures = self.body.pressures(self.case, |chamber| chamber.pressure.at(time));
            self.written.table.row(time, self.body, self.reader, &state.displacement, &pressures)?;
        }
        let every = self.case.output.vtu_every.unwrap_or(FRAME_EVERY);
        if every > 0 && self.steps.is_multiple_of(every) {
            let name = self.written.frames.next_name();
            self.written.frames.write(&name, time, self.body, &frame(state, self.reader))?;
        }
        Ok(())
    }

    /// The summary, or the fault with the last state kept.
    fn end(mut self, lost: Option<SolveError>) -> Outcome<Summary> {
        if let Some(fault) = self.fault.take() {
            return Err(fault);
        }
        let Some(lost) = lost else {
            return Ok(Summary { freedoms: 0, solved: self.steps, iterations: None, folder: Default::default() });
        };
        let (time, state) = &self.last;
        let path = self.written.frames.write("last_converged.vtu", *time, self.body, &frame(state, self.reader))?;
        Err(Fault::from_tool(format!("{lost}\n  last converged state: {}", path.display())))
    }
}

fn frame<'a>(state: &'a State, reader: &'a Solver) -> Frame<'a> {
    let (displacement, velocity) = (&state.displacement, Some(state.velocity.as_slice()));
    Frame { displacement, velocity, properties: reader.properties() }
}
