//! Trajectories: a motion recorded so that it can be gone through again, backwards too.
//!
//! While all states fit into the memory allowed, they are kept. Otherwise only the two states at the start of each
//! stretch are, and a stretch is marched again when it is asked for [griewank1992]. Each stretch begins with a factor of
//! its own, when recorded as when repeated, so that both give the same bytes.
//!
//! Stands on: `dynamics`, `stencil`. Never knows: a loss, a parameter.

use crate::motion::dynamics::Walk;
use crate::motion::march::{March, State};
use crate::motion::stencil::Stencil;
use crate::solver::Solver;
use crate::stall::SolveError;
use si::{Pascal, Second};

/// A motion and what is needed to repeat it.
#[derive(Debug, Clone, Default)]
pub struct Trajectory {
    pub(crate) march: March,
    /// Time of each state, the initial one first, s.
    times: Vec<Second>,
    /// Pressures of each step, one a chamber; those of step n at n − 1.
    pressures: Vec<Vec<Pascal>>,
    /// States at the start of each stretch, newest first.
    starts: Vec<Vec<State>>,
    /// Steps of a stretch.
    stride: usize,
    /// The states of all steps, the initial one first, when there is one stretch alone.
    kept: Vec<State>,
}

/// States from one stretch, oldest first, and the number of the first.
pub(crate) struct Stretch {
    first: usize,
    states: Vec<State>,
}

impl Stretch {
    /// The state after step `n`; the initial one for 0.
    pub fn state(&self, n: usize) -> &State {
        &self.states[n - self.first]
    }
}

impl Trajectory {
    /// How many steps there are.
    pub fn steps(&self) -> usize {
        self.pressures.len()
    }

    /// Time of each state, the initial one first, s.
    pub fn times(&self) -> &[Second] {
        &self.times
    }

    /// Pressures of step `n` (from 1), one a chamber.
    pub(crate) fn pressures(&self, n: usize) -> &[Pascal] {
        &self.pressures[n - 1]
    }

    /// How many stretches it was cut into: 1 when every state was kept.
    pub fn stretches(&self) -> usize {
        self.starts.len()
    }

    /// The stencil of step `n` (from 1).
    pub(crate) fn stencil(&self, n: usize) -> Stencil {
        Stencil::ending(self.march.scheme, &self.times[n.saturating_sub(2)..=n])
    }

    /// First and last step of a stretch.
    pub(crate) fn bounds(&self, stretch: usize) -> (usize, usize) {
        (stretch * self.stride + 1, ((stretch + 1) * self.stride).min(self.steps()))
    }
}

impl Solver {
    /// Moves as [`Solver::march`] does, and records the motion; `memory` is how many bytes its states may take.
    ///
    /// # Errors
    /// As [`Solver::march`]; also when not even stretches of equal numbers of steps fit into `memory`.
    pub fn record(
        &mut self,
        march: &March,
        initial: &State,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        steps: usize,
        memory: usize,
    ) -> Result<Trajectory, SolveError> {
        let times = (0..=steps).map(|step| step as f64 * march.step).collect();
        self.record_over(march, initial, pressures, times, memory)
    }

    /// The same over given `times` (s, rising from 0), as [`Solver::march_adaptive`] returns them.
    ///
    /// # Errors
    /// As [`Solver::record`]; also when the times do not rise.
    pub fn record_over(
        &mut self,
        march: &March,
        initial: &State,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        times: Vec<Second>,
        memory: usize,
    ) -> Result<Trajectory, SolveError> {
        if let Some(pair) = times.windows(2).find(|pair| pair[0].is_nan() || pair[1].is_nan() || pair[1] <= pair[0]) {
            return Err(SolveError::Setting { what: "a time", value: pair[1], range: "above the time before it" });
        }
        let steps = times.len().saturating_sub(1);
        let stride = stride(steps, 16 * initial.displacement.len(), memory)?;
        let mut walk = self.set_out(march, initial)?;
        let pressures = times.iter().skip(1).map(|&time| pressures(time)).collect();
        let mut made = Trajectory { march: *march, times, pressures, starts: Vec::new(), stride, kept: Vec::new() };
        let whole = stride >= steps;
        if whole {
            made.kept.push(walk.states[0].clone());
        }
        for n in 1..=steps {
            if (n - 1).is_multiple_of(stride) {
                walk.begin_anew();
                made.starts.push(walk.states.iter().cloned().collect());
            }
            self.step_to(march, &mut walk, made.times[n], &made.pressures[n - 1])?;
            if whole {
                made.kept.push(walk.states[0].clone());
            }
        }
        Ok(made)
    }

    /// The states that a pass through `stretch` needs: those of its steps and the two before them.
    pub(crate) fn repeat(&mut self, trajectory: &Trajectory, stretch: usize) -> Result<Stretch, SolveError> {
        if !trajectory.kept.is_empty() {
            return Ok(Stretch { first: 0, states: trajectory.kept.clone() });
        }
        let (first, last) = trajectory.bounds(stretch);
        let start = &trajectory.starts[stretch];
        let before = start.len();
        let times = trajectory.times[first - before..first].iter().rev().copied().collect();
        let mut walk = Walk::new(start.clone(), times);
        let mut states: Vec<State> = start.iter().rev().cloned().collect();
        for n in first..=last {
            self.step_to(&trajectory.march, &mut walk, trajectory.times[n], trajectory.pressures(n))?;
            states.push(walk.states[0].clone());
        }
        Ok(Stretch { first: first - before, states })
    }

    /// Hands each state of a recorded motion to `observe`, the initial one first.
    ///
    /// # Errors
    /// [`SolveError`] when a stretch cannot be repeated: the solver's properties are then not those of the recording.
    pub fn replay(
        &mut self,
        trajectory: &Trajectory,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(), SolveError> {
        for stretch in 0..trajectory.stretches() {
            let states = self.repeat(trajectory, stretch)?;
            let (first, last) = trajectory.bounds(stretch);
            for n in (if stretch == 0 { 0 } else { first })..=last {
                observe(trajectory.times[n], states.state(n));
            }
        }
        Ok(())
    }
}

/// Steps of a stretch: all of them when every state (of `bytes`) fits into `memory`, else about √2 per root of their
/// number, which needs the least.
fn stride(steps: usize, bytes: usize, memory: usize) -> Result<usize, SolveError> {
    let steps = steps.max(1);
    if (steps + 1).saturating_mul(bytes) <= memory {
        return Ok(steps);
    }
    let stride = ((2 * steps) as f64).sqrt().ceil() as usize;
    let needed = (2 * steps.div_ceil(stride) + stride + 2).saturating_mul(bytes);
    if needed <= memory {
        return Ok(stride);
    }
    let (what, range) = ("the memory for states, in bytes", "enough for the starts and one stretch of the motion");
    Err(SolveError::Setting { what, value: memory as f64, range })
}
