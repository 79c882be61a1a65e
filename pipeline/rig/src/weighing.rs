//! Weighing: what the load cell says of a trial, and of its fixture alone.
//!
//! A trial in air pulls with the inertia of the moving tail alone, one in water with the water's push as well; buoyancy that
//! follows pressure and the waves that the run drives stand beside it. The fixture alone is tapped with a hammer, and left over a tank in which a run has ended.
//!
//! Stands on: the instruments, the physics' reaction, `lab` (the logs). Never knows: a film.

use std::f64::consts::TAU;
use std::path::Path;

use lab::card::{Experiment, Fixture, FixtureOf, Medium};
use lab::truth::{TrueCell, TrueForce, TrueForces};
use si::{Hertz, Second};

use crate::draw::Draw;
use crate::fault::Fault;
use crate::folder;
use crate::instruments::buoyancy::{self, Late};
use crate::instruments::cell::{self, Run};
use crate::instruments::fixture;
use crate::instruments::hammer::Blows;
use crate::instruments::oscillator::Oscillator;
use crate::instruments::tank::{self, Swell, Waves};
use crate::logger::Clock;
use crate::physics::Motion;
use crate::script::Script;
use crate::settings::Settings;
use crate::trial::Bench;
use crate::valve::Trace;

/// How long the amplifier runs on after the camera, s.
const AFTERWARDS: Second = 0.3;
/// Times a second at which the truth is told.
const TRUE_RATE: Hertz = 120.0;

/// The fixture of a specimen's seed.
fn fixture_of(set: &Settings, seed: u64) -> Oscillator {
    fixture::drawn(&set.cell, &mut Draw::new(seed, "fixture"))
}

/// What is hidden in the cell of a specimen's seed.
pub fn truth(set: &Settings, seed: u64) -> TrueCell {
    let it = fixture_of(set, seed);
    TrueCell {
        mass: it.mass,
        damping: it.damping,
        stiffness: it.stiffness,
        tank_length: set.tank.length,
        tank_depth: set.tank.depth,
        tank_frequencies: tank::MODES.map(|mode| tank::frequency(&set.tank, mode)),
    }
}

/// Writes the force log of a trial that has one, and returns what is hidden in it.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn of_trial(
    bench: &Bench,
    trial: &lab::card::Trial,
    motion: &dyn Motion,
    script: &Script,
    sides: &[Trace; 2],
    folder: &Path,
) -> Result<Option<TrueForce>, Fault> {
    let Some(file) = &trial.force else { return Ok(None) };
    let set = bench.set;
    let late = sides.each_ref().map(|side| Late::of(&set.buoyancy, [0.0, script.length], &|t| side.at(t)));
    let lift = |t| late.iter().map(|p| buoyancy::still(&set.buoyancy, bench.name, trial.medium, p.at(t))).sum();
    let pull = |t| motion.pull(t);
    let mut draw = Draw::new(bench.seed, &format!("force {}", trial.id));
    let clock = cell::clock(&set.cell, &mut draw);
    let swell = match (trial.medium, &trial.experiment) {
        (Medium::Water, Experiment::Flapping { .. }) => {
            let waves = &mut Draw::new(bench.seed, &format!("waves {}", trial.id));
            Swell::of(&set.tank, [script.led_on, script.led_off], &pull, waves)
        }
        _ => Swell::none(),
    };
    let beside = |t| lift(t) + swell.at(t);
    let end = script.length + AFTERWARDS;
    let run = Run { id: &trial.id, pull: &pull, beside: &beside, medium: trial.medium, end };
    let (mut log, truth) = cell::record(&set.cell, fixture_of(set, bench.seed), &run, clock, &mut draw);
    log.led = cell::lamp(&set.cell, clock, &log.time, script);
    folder::write(folder, file, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    let mut forces = TrueForces::default();
    for i in 0..(script.length * TRUE_RATE) as usize {
        let t = i as f64 / TRUE_RATE;
        forces.time.push(t);
        forces.pull.push(pull(t));
        forces.thrust.push(motion.thrust(t));
        forces.lift.push(lift(t));
        forces.wave.push(swell.at(t));
    }
    let parts = format!("truth/{}_forces.csv", trial.id);
    folder::write(folder, &parts, lab::truth::write_forces(&forces, lab::VIRTUAL_BENCH).as_bytes())?;
    Ok(Some(TrueForce { forces: Some(parts), ..truth }))
}

/// Writes the logs of a recording of the fixture alone, and returns what is hidden in them.
///
/// # Errors
/// [`Fault`] when the disk refuses.
pub fn of_fixture(set: &Settings, seed: u64, fixture: &Fixture, folder: &Path) -> Result<TrueForce, Fault> {
    let mut draw = Draw::new(seed, &format!("force {}", fixture.id));
    match &fixture.of {
        FixtureOf::Taps { hammer } => taps(set, seed, fixture, hammer, folder, &mut draw),
        FixtureOf::StillWater => still_water(set, seed, fixture, folder, &mut draw),
    }
}

fn taps(
    set: &Settings,
    seed: u64,
    fixture: &Fixture,
    hammer: &str,
    folder: &Path,
    draw: &mut Draw,
) -> Result<TrueForce, Fault> {
    let blows = Blows::drawn(&set.hammer, draw);
    let clock = cell::clock(&set.cell, draw);
    let end = set.hammer.every * (set.hammer.taps + 1) as f64;
    let run = Run { id: &fixture.id, pull: &|t| blows.at(t), beside: &|_| 0.0, medium: fixture.medium, end };
    let (log, truth) = cell::record(&set.cell, fixture_of(set, seed), &run, clock, draw);
    let struck = blows.log(&set.hammer, clock, end, draw);
    folder::write(folder, &fixture.force, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    folder::write(folder, hammer, lab::force::write(&struck, lab::VIRTUAL_BENCH).as_bytes())?;
    Ok(TrueForce { taps: blows.truth(), ..truth })
}

/// True time 0 is where the log begins; the run before it ended so much earlier.
fn still_water(
    set: &Settings,
    seed: u64,
    fixture: &Fixture,
    folder: &Path,
    draw: &mut Draw,
) -> Result<TrueForce, Fault> {
    let before = &set.still_water;
    let (start, length) = (draw.unit(), before.run + draw.unit() / before.frequency);
    let force = |t: Second| before.force * (TAU * (before.frequency * t + start)).sin();
    let waves = Waves::left_by(&set.tank, length, &force, draw);
    let clock = Clock { offset: 0.0, ..cell::clock(&set.cell, draw) };
    let left = |t: Second| waves.at(t + before.wait);
    let run = Run { id: &fixture.id, pull: &|_| 0.0, beside: &left, medium: fixture.medium, end: before.length };
    let (log, truth) = cell::record(&set.cell, fixture_of(set, seed), &run, clock, draw);
    folder::write(folder, &fixture.force, lab::force::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    Ok(TrueForce { waves: waves.true_at(before.wait), ..truth })
}
