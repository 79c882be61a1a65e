//! Trajectories: recorded motions for replay and adjoint, with checkpointing [griewank1992].
//!
//! While all states fit into the memory allowed, they are stored. Otherwise each checkpoint stores the two states at
//! the start of a segment, and the states of a segment are recomputed on demand. Each segment begins with a new
//! factorisation, in the recording as in the recomputation, so that both give the same bytes.

use crate::dynamics::settings::{DynamicSettings, InitialValueProblem, State};
use crate::dynamics::stencil::Stencil;
use crate::dynamics::stepper::StepperState;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::system_data::SystemData;
use crate::viscoelastic::history::{History, HistoryStep};
use materials::step::RegionStep;
use materials::symmetric::Symmetric;
use si::{Pascal, Second};

/// A recorded motion.
#[derive(Debug, Clone, Default)]
pub struct Trajectory {
    pub(crate) settings: DynamicSettings,
    /// Time of each state, the initial one first, s.
    times: Vec<Second>,
    /// Pressures of each step, one per chamber; those of step n at n − 1.
    pressures: Vec<Vec<Pascal>>,
    /// States at the start of each segment, newest first, and the history of the newest.
    checkpoints: Vec<(Vec<State>, Option<History>)>,
    /// Checkpoint interval: steps of a segment.
    interval: usize,
    /// All states, the initial one first, when there is a single segment.
    stored: Vec<State>,
    /// Their histories, where a region relaxes.
    stored_histories: Vec<History>,
}

/// States of one checkpoint segment, oldest first, and the number of the first.
pub(crate) struct Segment {
    first: usize,
    states: Vec<State>,
    /// Of the last states, where a region relaxes; the last one's is that of the last state.
    histories: Vec<History>,
}

impl Segment {
    /// The state after step `n`; the initial one for 0.
    pub fn state(&self, n: usize) -> &State {
        &self.states[n - self.first]
    }

    /// The history after step `n`, where a region relaxes.
    pub fn history(&self, n: usize) -> Option<&History> {
        // The second state of a checkpoint has no history, and none is asked for.
        self.histories.get((n - self.first).checked_sub(self.states.len() - self.histories.len())?)
    }
}

/// One step of a recorded motion, as adjoint and sensitivity need it.
pub(crate) struct TrajectoryStep<'a> {
    pub trajectory: &'a Trajectory,
    pub segment: &'a Segment,
    /// Number of the step, from 1.
    pub n: usize,
    pub stencil: Stencil,
}

impl<'a> TrajectoryStep<'a> {
    pub fn new(trajectory: &'a Trajectory, segment: &'a Segment, n: usize) -> Self {
        Self { trajectory, segment, n, stencil: trajectory.stencil_of_step(n) }
    }

    /// The state at the end of the step.
    pub fn state(&self) -> &State {
        self.segment.state(self.n)
    }

    /// Past states that the stencil weighs, newest first.
    pub fn past(&self) -> impl Iterator<Item = &State> {
        (1..=self.stencil.weights.len()).map(|j| self.segment.state(self.n - j))
    }

    pub fn pressures(&self) -> &[Pascal] {
        &self.trajectory.pressures[self.n - 1]
    }

    /// The histories before and after the step over `regions`, where a region relaxes.
    pub(crate) fn history_step<'b>(
        &'b self,
        data: &'b SystemData,
        regions: Option<&'b [RegionStep]>,
    ) -> Option<HistoryStep<'b>> {
        let (before, now) = self.segment.history(self.n - 1).zip(self.segment.history(self.n))?;
        Some(HistoryStep { data, regions: regions?, before, now, displacement: &self.state().displacement })
    }

    /// Length of the step, s.
    pub fn length(&self) -> Second {
        self.trajectory.times[self.n] - self.trajectory.times[self.n - 1]
    }

    /// aₙ, 3 entries per node.
    pub fn acceleration(&self) -> Vec<f64> {
        self.stencil.rate(&self.state().velocity, self.past().map(|state| state.velocity.as_slice()))
    }
}

impl Trajectory {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.pressures.len()
    }

    /// Time of each state, the initial one first, s.
    pub fn times(&self) -> &[Second] {
        &self.times
    }

    /// Number of checkpoint segments: 1 when every state is stored.
    pub fn segments(&self) -> usize {
        self.checkpoints.len()
    }

    /// The stencil of step `n` (from 1).
    fn stencil_of_step(&self, n: usize) -> Stencil {
        Stencil::ending(self.settings.scheme, &self.times[n.saturating_sub(2)..=n])
    }

    /// Stores the newest state.
    fn store_state(&mut self, stepper: &StepperState) {
        self.stored.push(stepper.states[0].clone());
        self.stored_histories.extend(stepper.history.clone());
    }

    /// First and last step of a segment.
    pub(crate) fn segment_bounds(&self, segment: usize) -> (usize, usize) {
        (segment * self.interval + 1, ((segment + 1) * self.interval).min(self.steps()))
    }
}

impl SolverState {
    /// See [`crate::Solver::record_at`].
    pub(crate) fn record_at(
        &mut self,
        problem: &InitialValueProblem,
        times: Vec<Second>,
        memory: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<Trajectory, SolveError> {
        if let Some(pair) = times.windows(2).find(|pair| pair[0].is_nan() || pair[1].is_nan() || pair[1] <= pair[0]) {
            return Err(SolveError::Setting { what: "a time", value: pair[1], range: "above the time before it" });
        }
        let steps = times.len().saturating_sub(1);
        let settings = *problem.settings;
        let mut stepper = self.start(&settings, problem.initial)?;
        let history = stepper.history.as_ref().map_or(0, |history| history.tensors.len() * size_of::<Symmetric>());
        let interval = checkpoint_interval(steps, 16 * problem.initial.displacement.len() + history, memory)?;
        let pressures = times.iter().skip(1).map(|&time| (problem.pressures)(time)).collect();
        let mut trajectory = Trajectory { settings, times, pressures, interval, ..Trajectory::default() };
        let stores_all = interval >= steps;
        if stores_all {
            trajectory.store_state(&stepper);
        }
        for n in 1..=steps {
            if (n - 1).is_multiple_of(interval) {
                stepper.restart();
                trajectory.checkpoints.push((stepper.states.iter().cloned().collect(), stepper.history.clone()));
            }
            self.step_to(&settings, &mut stepper, trajectory.times[n], &trajectory.pressures[n - 1])?;
            observe(trajectory.times[n], &stepper.states[0]);
            if stores_all {
                trajectory.store_state(&stepper);
            }
        }
        Ok(trajectory)
    }

    /// The states of `segment` and the two before it, recomputed from its checkpoint where they are not stored.
    pub(crate) fn segment(&mut self, trajectory: &Trajectory, segment: usize) -> Result<Segment, SolveError> {
        if !trajectory.stored.is_empty() {
            let (states, histories) = (trajectory.stored.clone(), trajectory.stored_histories.clone());
            return Ok(Segment { first: 0, states, histories });
        }
        let (first, last) = trajectory.segment_bounds(segment);
        let (checkpoint, history) = &trajectory.checkpoints[segment];
        let checkpoint_states = checkpoint.len();
        let times = trajectory.times[first - checkpoint_states..first].iter().rev().copied().collect();
        let mut stepper = StepperState::new(checkpoint.clone(), times, history.clone());
        let mut states: Vec<State> = checkpoint.iter().rev().cloned().collect();
        let mut histories: Vec<History> = history.iter().cloned().collect();
        for n in first..=last {
            self.step_to(&trajectory.settings, &mut stepper, trajectory.times[n], &trajectory.pressures[n - 1])?;
            states.push(stepper.states[0].clone());
            histories.extend(stepper.history.clone());
        }
        Ok(Segment { first: first - checkpoint_states, states, histories })
    }

    /// See [`crate::Solver::replay`].
    pub(crate) fn replay(
        &mut self,
        trajectory: &Trajectory,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(), SolveError> {
        for number in 0..trajectory.segments() {
            let segment = self.segment(trajectory, number)?;
            let (first, last) = trajectory.segment_bounds(number);
            for n in (if number == 0 { 0 } else { first })..=last {
                observe(trajectory.times[n], segment.state(n));
            }
        }
        Ok(())
    }
}

/// Steps of a segment: all of them when every state (of `bytes`) fits into `memory`, else √(2 steps), which needs the
/// least memory.
// With one level of checkpoints each step is recomputed once, so the adjoint costs one more forward solve. Nested
// checkpoints (revolve) would need less memory and more recomputation; two states per segment have sufficed for 2000
// steps in 400 MB.
fn checkpoint_interval(steps: usize, bytes: usize, memory: usize) -> Result<usize, SolveError> {
    let steps = steps.max(1);
    if (steps + 1).saturating_mul(bytes) <= memory {
        return Ok(steps);
    }
    let interval = ((2 * steps) as f64).sqrt().ceil() as usize;
    let needed = (2 * steps.div_ceil(interval) + interval + 2).saturating_mul(bytes);
    if needed <= memory {
        return Ok(interval);
    }
    let (what, range) = ("the memory for states, in bytes", "enough for all checkpoints and one segment");
    Err(SolveError::Setting { what, value: memory as f64, range })
}
