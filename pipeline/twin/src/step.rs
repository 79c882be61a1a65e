//! Steps of a reduced tail: BDF2; a step that is not found is halved.

use crate::equations::Equations;
use crate::error::TwinError;
use crate::state::{Stencil, TwinState};
use crate::twin::Twin;
use crate::workspace::Workspace;

/// Times that a step is halved at most.
const HALVINGS: usize = 6;

/// What sees the state after a part of a step, and the stencil of that part.
pub(crate) type See<'a> = dyn FnMut(&TwinState, Stencil) + 'a;

impl Twin {
    /// Steps by `duration` seconds, at whose end the chambers have these `pressures`, Pa. Where no step of that length is found, it is
    /// halved, with pressures that rise evenly. An error leaves the state as it was. A step that is not halved takes no memory.
    ///
    /// # Errors
    /// [`TwinError`] when an input is wrong, a pressure is beyond the range of its chamber, the state is of another twin, or no step is found.
    pub fn step(&self, state: &mut TwinState, pressures: &[f64], duration: f64) -> Result<(), TwinError> {
        self.step_seen((state, &mut |_, _| {}), pressures, duration)
    }

    /// [`Twin::step`]; `see` is shown the state after every part of it, and the stencil of that part.
    pub(crate) fn step_seen(
        &self,
        seen: (&mut TwinState, &mut See),
        pressures: &[f64],
        duration: f64,
    ) -> Result<(), TwinError> {
        self.check_state(seen.0)?;
        self.check_pressures(pressures)?;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(TwinError::Input { what: format!("a step of {duration} s") });
        }
        match self.attempt_step(seen.0, pressures, duration) {
            Ok(stencil) => (seen.1)(seen.0, stencil),
            Err(error) => self.step_in_halves(seen, (pressures, duration), error)?,
        }
        Ok(())
    }

    /// A step in parts after the whole one failed with `error`; where that fails too, the state is as it was.
    fn step_in_halves(
        &self,
        (state, see): (&mut TwinState, &mut See),
        (pressures, duration): (&[f64], f64),
        error: TwinError,
    ) -> Result<(), TwinError> {
        state.lagged.gamma = f64::NAN;
        // The copy is made only where the whole step has failed: a step that is found takes no memory.
        let before = state.clone();
        let stepped = self.step_two_halves((state, see), (pressures, duration), (HALVINGS, error));
        if stepped.is_err() {
            *state = TwinState { work: state.work, ..before };
        }
        stepped
    }

    fn step_in_parts(
        &self,
        (state, see): (&mut TwinState, &mut See),
        pressures: &[f64],
        duration: f64,
        halvings: usize,
    ) -> Result<(), TwinError> {
        match self.attempt_step(state, pressures, duration) {
            Ok(stencil) => {
                see(state, stencil);
                Ok(())
            }
            Err(error) => {
                state.lagged.gamma = f64::NAN;
                self.step_two_halves((state, see), (pressures, duration), (halvings, error))
            }
        }
    }

    /// The halves of a step that failed with `error`, which is returned where it may not be halved again.
    fn step_two_halves(
        &self,
        (state, see): (&mut TwinState, &mut See),
        (pressures, duration): (&[f64], f64),
        (halvings, error): (usize, TwinError),
    ) -> Result<(), TwinError> {
        if halvings == 0 {
            return Err(error);
        }
        let middle: Vec<f64> = state.pressures.iter().zip(pressures).map(|(a, b)| 0.5 * (a + b)).collect();
        self.step_in_parts((state, see), &middle, 0.5 * duration, halvings - 1)?;
        self.step_in_parts((state, see), pressures, 0.5 * duration, halvings - 1)
    }

    /// One step of the scheme; the state changes only where it is found.
    fn attempt_step(&self, state: &mut TwinState, pressures: &[f64], duration: f64) -> Result<Stencil, TwinError> {
        state.prepare_factors(&self.solids, duration);
        let time = state.time + duration;
        let stencil = Equations::of_step(self, state, pressures, duration).solve(time)?;
        let Workspace { coordinates, velocity, momentum, stresses, row, .. } = &mut state.workspace;
        for ((history, factors), now) in state.histories.iter_mut().zip(&state.factors.1).zip(&*stresses) {
            history.advance(factors, &now.relaxing);
        }
        std::mem::swap(&mut state.stresses, stresses);
        state.past.push_state(time, [coordinates, velocity, momentum], row);
        state.time = time;
        state.pressures.copy_from_slice(pressures);
        state.work.steps += 1;
        Ok(stencil)
    }
}
