//! Force logs: the readings of the load cell in a trial, and in the recordings of its fixture alone.
//!
//! In air the force on the fixture is the inertia of the moving tail; in water the hydrodynamic force is added. Pressure-dependent buoyancy
//! and the standing waves that the run excites act on the cell beside the fixture. The fixture alone is recorded twice: under hammer
//! taps, and over still water after a run.

use std::f64::consts::TAU;
use std::path::Path;

use diagnostics::Result;
use lab::card::{Experiment, Fixture, FixtureOf, Medium};
use lab::truth::{TrueCell, TrueForce, TrueForces};
use si::{Hertz, Newton, Second};

use crate::bench::{Bench, TrialRun};
use crate::folder;
use crate::instruments::buoyancy::{self, DelayedPressure};
use crate::instruments::cell::{self, Run};
use crate::instruments::fixture;
use crate::instruments::hammer::HammerTaps;
use crate::instruments::oscillator::Oscillator;
use crate::instruments::tank::{self, DrivenWaves, FreeWaves};
use crate::pressure_log::Clock;
use crate::random::RandomStream;
use crate::settings::Settings;

/// Time for which the amplifier runs on after the film, s.
const AFTERWARDS: Second = 0.3;
/// Sampling rate of the true forces.
const TRUE_RATE: Hertz = 120.0;

/// The fixture of a specimen's seed.
fn fixture_of(set: &Settings, seed: u64) -> Oscillator {
    fixture::draw_fixture(&set.cell, &mut RandomStream::new(seed, "fixture"))
}

/// The true load cell and tank of a specimen's seed.
pub(crate) fn true_cell(set: &Settings, seed: u64) -> TrueCell {
    let fixture = fixture_of(set, seed);
    TrueCell {
        mass: fixture.mass,
        damping: fixture.damping,
        stiffness: fixture.stiffness,
        tank_length: set.tank.length,
        tank_depth: set.tank.depth,
        tank_frequencies: tank::MODES.map(|mode| tank::mode_frequency(&set.tank, mode)),
    }
}

/// Writes the force log of a trial, if the trial has one, and returns its ground truth.
///
/// # Errors
/// When a file cannot be written.
pub(crate) fn record_trial(bench: &Bench, run: &TrialRun, folder: &Path) -> Result<Option<TrueForce>> {
    let (set, trial, script) = (bench.set, run.trial, &run.pneumatics.script);
    let Some(file) = &trial.force else { return Ok(None) };
    let delayed = run
        .pneumatics
        .sides
        .each_ref()
        .map(|side| DelayedPressure::of_pressure(&set.buoyancy, [0.0, script.length], &|t| side.at(t)));
    let static_force = |t: Second| {
        let side =
            |p: &DelayedPressure| buoyancy::static_force(&set.buoyancy, bench.name, trial.medium, p.pressure_at(t));
        delayed.iter().map(side).sum::<f64>()
    };
    let pull = |t| run.motion.pull(t);
    let mut random = RandomStream::new(bench.seed, &format!("force {}", trial.id));
    let clock = cell::draw_clock(&set.cell, &mut random);
    let waves = match (trial.medium, &trial.experiment) {
        (Medium::Water, Experiment::Flapping { .. }) => {
            let amplitudes = &mut RandomStream::new(bench.seed, &format!("waves {}", trial.id));
            DrivenWaves::of_run(&set.tank, [script.led_on, script.led_off], &pull, amplitudes)
        }
        _ => DrivenWaves::no_waves(),
    };
    let other_force = |t| static_force(t) + waves.force_at(t);
    let end = script.length + AFTERWARDS;
    let fixture = fixture_of(set, bench.seed);
    let cell_run = Run { id: &trial.id, fixture, clock, pull: &pull, beside: &other_force, medium: trial.medium, end };
    let (mut log, truth) = cell::record_run(&set.cell, &cell_run, &mut random);
    log.led = cell::lamp_channel(&set.cell, clock, &log.time, script);
    folder::write_file(folder, file, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    let forces = sample_forces(run, &static_force, &waves);
    let parts = format!("truth/{}_forces.csv", trial.id);
    folder::write_file(folder, &parts, lab::truth::write_forces(&forces, lab::VIRTUAL_BENCH).as_bytes())?;
    Ok(Some(TrueForce { forces: Some(parts), ..truth }))
}

/// The true forces of a trial, evenly sampled.
fn sample_forces(run: &TrialRun, static_force: &dyn Fn(Second) -> Newton, waves: &DrivenWaves) -> TrueForces {
    let mut forces = TrueForces::default();
    for i in 0..(run.pneumatics.script.length * TRUE_RATE) as usize {
        let t = i as f64 / TRUE_RATE;
        forces.time.push(t);
        forces.pull.push(run.motion.pull(t));
        forces.thrust.push(run.motion.thrust(t));
        forces.lift.push(static_force(t));
        forces.wave.push(waves.force_at(t));
    }
    forces
}

/// Writes the logs of a recording of the fixture alone, and returns its ground truth.
///
/// # Errors
/// When a file cannot be written.
pub(crate) fn record_fixture(set: &Settings, seed: u64, fixture: &Fixture, folder: &Path) -> Result<TrueForce> {
    let mut random = RandomStream::new(seed, &format!("force {}", fixture.id));
    let recording = FixtureRecording { set, seed, fixture, folder };
    match &fixture.of {
        FixtureOf::Taps { hammer, .. } => recording.record_taps(hammer, &mut random),
        FixtureOf::StillWater => recording.record_still_water(&mut random),
    }
}

/// A recording of the fixture alone.
struct FixtureRecording<'a> {
    set: &'a Settings,
    seed: u64,
    fixture: &'a Fixture,
    folder: &'a Path,
}

impl FixtureRecording<'_> {
    fn record_taps(&self, hammer: &str, random: &mut RandomStream) -> Result<TrueForce> {
        let set = &self.set.hammer;
        let taps = HammerTaps::draw_taps(set, random);
        let clock = cell::draw_clock(&self.set.cell, random);
        let end = set.every * (set.taps + 1) as f64;
        let truth = self.write_log(&Run { pull: &|t| taps.force_at(t), ..self.unloaded_run(clock, end) }, random)?;
        let log = taps.hammer_log(set, clock, end, random);
        folder::write_file(self.folder, hammer, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
        Ok(TrueForce { taps: taps.true_taps(), ..truth })
    }

    /// The log begins at true time 0, `wait` (s) after the end of the run that excited the waves.
    fn record_still_water(&self, random: &mut RandomStream) -> Result<TrueForce> {
        let run = &self.set.still_water;
        let (start, length) = (random.unit(), run.run + random.unit() / run.frequency);
        let force = |t: Second| run.force * (TAU * (run.frequency * t + start)).sin();
        let waves = FreeWaves::after_run(&self.set.tank, length, &force, random);
        let clock = Clock { offset: 0.0, ..cell::draw_clock(&self.set.cell, random) };
        let wave_force = |t: Second| waves.force_at(t + run.wait);
        let truth = self.write_log(&Run { beside: &wave_force, ..self.unloaded_run(clock, run.length) }, random)?;
        Ok(TrueForce { waves: waves.truth_at(run.wait), ..truth })
    }

    /// A run without any force.
    fn unloaded_run(&self, clock: Clock, end: Second) -> Run<'_> {
        let (id, medium, fixture) = (&self.fixture.id, self.fixture.medium, fixture_of(self.set, self.seed));
        Run { id, fixture, clock, pull: &|_| 0.0, beside: &|_| 0.0, medium, end }
    }

    fn write_log(&self, run: &Run, random: &mut RandomStream) -> Result<TrueForce> {
        let (log, truth) = cell::record_run(&self.set.cell, run, random);
        folder::write_file(self.folder, &self.fixture.force, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
        Ok(truth)
    }
}
