//! The waveforms of greatest mean thrust and of greatest thrust per air, beside square waves through the same valve and a recorded flap.
//!
//! Adam climbs from the best square wave. All flaps settle for as many cycles as the model says, the ascent's too: over too few of them an optimum
//! lives on the transient from rest.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Newton, Pascal};

use crate::Run;
use crate::square_wave_search::solved_points;
use crate::waveform::{Valve, Waveform};
use crate::waveform_thrust::{Cycle, Goal, Optimum, Performance, WaveformModel};
use diagnostics::{Diagnostic, Result};

/// Amplitudes and frequencies of the sweep.
const SWEEP: [usize; 2] = [4, 9];

/// The optima of a tail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OptimalWaveforms {
    /// The valve, as measured.
    pub valve: Valve,
    /// The recorded flap of greatest mean force, simulated under its measured pressures.
    pub recorded: Flap,
    /// Square waves.
    pub sweep: Vec<Performed>,
    /// How many further ones the reduced tail could not follow.
    pub unsolved: usize,
    /// One a goal.
    pub optima: Vec<OptimalWaveform>,
}

/// A flap and its pressures over one cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flap {
    /// The recorded run's id, or the goal.
    pub name: String,
    /// What comes of it.
    pub performed: Performed,
    /// Commands of both sides, Pa: steps of one cycle.
    pub command_pa: [Vec<Pascal>; 2],
    /// Pressures of both sides, Pa: steps of one cycle.
    pub pressure_pa: [Vec<Pascal>; 2],
}

/// The performance of a flap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Performed {
    /// Highest pressure, Pa.
    pub highest_pa: Pascal,
    /// Hz.
    pub frequency_hz: Hertz,
    /// Mean thrust by the model's theory, N.
    pub thrust_n: Newton,
    /// Air drawn by all chambers, m³/s at ambient pressure.
    pub air_m3_s: f64,
    /// Lateral amplitude of the last marker, m.
    pub amplitude_m: Metre,
}

/// The optimum for one goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OptimalWaveform {
    /// The best square wave of the sweep.
    pub square: Flap,
    /// The optimum.
    pub flap: Flap,
    /// Value of the goal at each evaluation of the ascent, N or N s/m³; none where the reduced tail could not follow.
    pub values: Vec<Option<f64>>,
}

impl Performed {
    /// Mean thrust over the flow of air, N s/m³.
    pub fn thrust_per_air(&self) -> f64 {
        Goal::ThrustPerAir.value(&Performance { thrust: self.thrust_n, air: self.air_m3_s, amplitude: 0.0 })
    }
}

impl OptimalWaveform {
    /// Value of the goal at the optimum over that of the best square wave, no unit.
    pub fn gain(&self) -> f64 {
        let value = |performed: &Performed| {
            if self.flap.name == Goal::Thrust.goal_name() { performed.thrust_n } else { performed.thrust_per_air() }
        };
        value(&self.flap.performed) / value(&self.square.performed)
    }
}

impl WaveformModel<'_> {
    /// The optima, beside square waves and a recorded run.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion or has no adjoint.
    pub fn optimal_waveforms(&self, recorded: &Run) -> Result<OptimalWaveforms> {
        let squares = Self::steepest_squares().into_par_iter();
        let attempts = squares.map(|waveform| {
            let cycle = self.last_cycle(&waveform)?;
            Ok((waveform, cycle))
        });
        let (sweep, unsolved) = solved_points(attempts.collect())?;
        Ok(OptimalWaveforms {
            valve: self.valve,
            unsolved,
            recorded: self.recorded_flap(recorded)?,
            sweep: sweep
                .iter()
                .map(|(waveform, cycle)| self.flap_performance(waveform.frequency(&self.limits), cycle))
                .collect(),
            optima: self.goal_optima(&sweep)?,
        })
    }

    /// The steepest square waves over the limits: amplitudes from an even part of the highest, all frequencies.
    fn steepest_squares() -> Vec<Waveform> {
        let [amplitudes, frequencies] = SWEEP;
        let grid_points = (1..=amplitudes).flat_map(|a| (0..frequencies).map(move |f| (a, f)));
        grid_points
            .map(|(a, f)| [a as f64 / amplitudes as f64, f as f64 / (frequencies - 1) as f64])
            .map(|coordinates| Waveform::steepest_square(&coordinates))
            .collect()
    }

    /// The optimum of each goal: the end of an ascent from its best square wave; where the end of the other goal's ascent has a greater value,
    /// that of an ascent from there. No ascent is global.
    fn goal_optima(&self, sweep: &[(Waveform, Cycle)]) -> Result<Vec<OptimalWaveform>> {
        let goals = [Goal::Thrust, Goal::ThrustPerAir];
        let squares: Vec<&(Waveform, Cycle)> =
            goals.iter().map(|goal| best_square(*goal, sweep)).collect::<Result<_>>()?;
        let ascents: Vec<Optimum> =
            (0..2).into_par_iter().map(|k| self.maximise(goals[k], &squares[k].0)).collect::<Result<_>>()?;
        let optimum = |k: usize| {
            let (goal, own_optimum, other_optimum) = (goals[k], &ascents[k], &ascents[1 - k]);
            if goal.value(&other_optimum.performance) > goal.value(&own_optimum.performance) {
                self.maximise(goal, &other_optimum.waveform)
            } else {
                Ok(own_optimum.clone())
            }
        };
        (0..2).into_par_iter().map(|k| self.compare_optimum(goals[k], squares[k], optimum(k)?)).collect()
    }

    /// An optimum beside the best square wave.
    fn compare_optimum(
        &self,
        goal: Goal,
        (square, cycle): &(Waveform, Cycle),
        optimum: Optimum,
    ) -> Result<OptimalWaveform> {
        let flap_under = |waveform: &Waveform, cycle: &Cycle| {
            self.named_flap(goal.goal_name(), waveform.frequency(&self.limits), cycle)
        };
        Ok(OptimalWaveform {
            square: flap_under(square, cycle),
            flap: flap_under(&optimum.waveform, &self.last_cycle(&optimum.waveform)?),
            values: optimum.values,
        })
    }

    fn recorded_flap(&self, run: &Run) -> Result<Flap> {
        let pressures = run.periodic_pressures()?;
        let first_chambers = [0, 1].map(|side| self.halves.iter().position(|half| *half == Some(side)));
        let side_pressure = |side: usize, t: f64| first_chambers[side].map_or(0.0, |chamber| pressures[chamber](t));
        Ok(self.named_flap(&run.id, run.frequency, &self.cycle_under(run.frequency, &side_pressure)?))
    }

    fn named_flap(&self, name: &str, frequency: Hertz, cycle: &Cycle) -> Flap {
        Flap {
            name: name.into(),
            performed: self.flap_performance(frequency, cycle),
            command_pa: cycle.commands.clone(),
            pressure_pa: cycle.pressures.clone(),
        }
    }

    fn flap_performance(&self, frequency_hz: Hertz, cycle: &Cycle) -> Performed {
        let Performance { thrust, air, amplitude } = cycle.performance;
        let highest_pa = cycle.pressures.iter().flatten().copied().fold(0.0, f64::max);
        Performed { highest_pa, frequency_hz, thrust_n: thrust, air_m3_s: air, amplitude_m: amplitude }
    }
}

fn best_square(goal: Goal, sweep: &[(Waveform, Cycle)]) -> Result<&(Waveform, Cycle)> {
    let value = |cycle: &Cycle| goal.value(&cycle.performance);
    sweep.iter().max_by(|(_, a), (_, b)| value(a).total_cmp(&value(b))).ok_or_else(|| {
        Diagnostic::new("no square wave was swept", "the sweep has no points", "report this as an error of the program")
    })
}
