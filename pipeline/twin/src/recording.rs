//! A motion that keeps what its adjoint needs: the coordinates of every step, and the histories of relaxation at checkpoints.
//!
//! Between two checkpoints the histories are replayed from the coordinates, without a search for equilibrium.

use crate::elastic::Solid;
use crate::error::TwinError;
use crate::history::{Factors, History};
use crate::lanes::gather;
use crate::law::{Deformed, Symmetric};
use crate::state::{Stencil, TwinState};
use crate::twin::Twin;

/// Parts of steps between two checkpoints.
// Measured on a flapping tail in air, motion with adjoint over motion: 1.59 with a checkpoint at every part, 1.58 with this, 1.56 with 256. Memory decides:
// a checkpoint of 376 points with five branches takes 108 kB, the stresses of a replayed part 18 kB.
const INTERVAL: usize = 32;

/// A motion from rest.
#[derive(Debug, Clone)]
pub struct Recording {
    state: TwinState,
    pub(crate) parts: Vec<RecordedPart>,
    /// Histories, by region, before every [`INTERVAL`]th part.
    checkpoints: Vec<Vec<History>>,
    /// Number of parts until the end of each step.
    pub(crate) ends: Vec<usize>,
}

/// A step that was found: a whole one, or a part of a halved one.
#[derive(Debug, Clone)]
pub(crate) struct RecordedPart {
    pub stencil: Stencil,
    /// s.
    pub duration: f64,
    pub coordinates: Vec<f64>,
    pub velocity: Vec<f64>,
    /// Pa.
    pub pressures: Vec<f64>,
    /// s.
    pub time: f64,
    /// Fraction of its step that has passed at its end.
    pub passed: f64,
}

impl Recording {
    /// The state after the last step.
    pub fn state(&self) -> &TwinState {
        &self.state
    }

    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.ends.len()
    }

    /// q after step `number`, from 0.
    ///
    /// # Panics
    /// When there is no such step.
    pub fn coordinates(&self, number: usize) -> &[f64] {
        &self.parts[self.ends[number] - 1].coordinates
    }

    /// q̇ after step `number`, from 0, 1/s.
    ///
    /// # Panics
    /// When there is no such step.
    pub fn velocity(&self, number: usize) -> &[f64] {
        &self.parts[self.ends[number] - 1].velocity
    }
}

impl Twin {
    /// A motion from rest without a step.
    pub fn recording(&self) -> Recording {
        let state = self.start();
        Recording { checkpoints: vec![state.histories.clone()], state, parts: Vec::new(), ends: Vec::new() }
    }

    /// [`Twin::step`] of a recorded motion. An error leaves it at the last whole step.
    ///
    /// # Errors
    /// As [`Twin::step`].
    pub fn record(&self, recording: &mut Recording, pressures: &[f64], duration: f64) -> Result<(), TwinError> {
        let Recording { state, parts, checkpoints, ends } = recording;
        let (before, first, checkpointed) = (state.time(), parts.len(), checkpoints.len());
        let mut see = |state: &TwinState, stencil: Stencil| {
            parts.push(RecordedPart {
                stencil,
                duration: state.factors.0,
                coordinates: state.coordinates().to_vec(),
                velocity: state.velocity().to_vec(),
                pressures: state.pressures.clone(),
                time: state.time(),
                passed: 1.0,
            });
            if parts.len() % INTERVAL == 0 {
                checkpoints.push(state.histories.clone());
            }
        };
        if let Err(error) = self.step_seen((state, &mut see), pressures, duration) {
            parts.truncate(first);
            checkpoints.truncate(checkpointed);
            return Err(error);
        }
        parts[first..].iter_mut().for_each(|part| part.passed = (part.time - before) / duration);
        ends.push(parts.len());
        Ok(())
    }

    /// The stresses H that relaxation holds (Pa) in every part between checkpoint `number` and the next: parts × solids × blocks.
    pub(crate) fn held_stresses(&self, recording: &Recording, number: usize) -> Vec<Vec<Vec<Symmetric>>> {
        let mut histories = recording.checkpoints[number].clone();
        let parts = recording.parts.iter().skip(number * INTERVAL).take(INTERVAL);
        let stresses_of_part = |part: &RecordedPart| {
            self.solids.iter().zip(&mut histories).map(|(s, h)| replay_part(s, h, part)).collect()
        };
        parts.map(stresses_of_part).collect()
    }
}

/// Number of the checkpoint before a part, and the part's place after it.
pub(crate) fn checkpoint_place(part: usize) -> (usize, usize) {
    (part / INTERVAL, part % INTERVAL)
}

/// H of one part; its history is advanced.
fn replay_part(solid: &Solid, history: &mut History, part: &RecordedPart) -> Vec<Symmetric> {
    let mut held_stress = Vec::new();
    if !solid.branches.is_empty() {
        let factors: Vec<Factors> = solid.branches.iter().map(|branch| Factors::new(*branch, part.duration)).collect();
        history.hold_stress(solid.mu, &factors, &mut held_stress);
        history.advance(&factors, &relaxing_stresses(solid, &part.coordinates));
    }
    held_stress
}

/// I − C⁻¹ of each block at q.
fn relaxing_stresses(solid: &Solid, q: &[f64]) -> Vec<Symmetric> {
    let constants = solid.constants_with_gain(0.0);
    let stress_of_block =
        |block: usize| Deformed::new(&gather(solid.gradients.block(block), q), &constants).relaxing_stress();
    (0..solid.block_count()).map(stress_of_block).collect()
}
