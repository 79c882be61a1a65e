//! Sense: a pressure log that can be read, held against the card, so that another unit or swapped sides are seen.
//!
//! Stands on: `lab`. Never knows: a file, a film.

use std::ops::Range;

use lab::PressureLog;
use lab::card::{Experiment, Side};
use si::{MILLIBAR, Pascal};

use super::finding::Finding;

/// A log's highest command may be off the card's by this factor either way: units differ by 6.9 (psi, kPa) at least.
const ASKED: f64 = 2.0;
/// A side answers with at least and at most this part of its highest command: valves are slow, and regulators overshoot.
const ANSWERED: [f64; 2] = [0.15, 2.0];
/// Sensors may be off by this much at rest, Pa.
const OFFSET: Pascal = 20.0 * MILLIBAR;

/// What a log says that cannot be meant.
pub fn look(place: &str, log: &PressureLog, experiment: &Experiment) -> Vec<Finding> {
    let side = experiment.side();
    let mut found: Vec<Finding> = [Side::Left, Side::Right].iter().filter_map(|&s| negative(place, log, s)).collect();
    let (first, other) = (begin(log, side), begin(log, side.other()));
    let Some(first) = first.filter(|first| other.is_none_or(|other| *first < other)) else {
        found.push(another_side(place, side, other.is_some()));
        return found;
    };
    found.extend(asked(place, log, experiment));
    found.extend(answered(place, log, side, first..other.unwrap_or(log.time.len())));
    found
}

/// The first sample at which a side is asked for pressure.
fn begin(log: &PressureLog, side: Side) -> Option<usize> {
    log.side(side).command.iter().position(|command| *command > 0.0)
}

fn highest(values: &[Pascal]) -> Pascal {
    values.iter().copied().fold(0.0, f64::max)
}

fn mbar(pressure: Pascal) -> String {
    format!("{:.1} mbar", pressure / MILLIBAR)
}

fn negative(place: &str, log: &PressureLog, side: Side) -> Option<Finding> {
    let (channel, word) = (log.side(side), side.word());
    let below = |values: &[Pascal], limit: Pascal| values.iter().position(|p| *p < -limit).map(|i| (i, values[i]));
    let asked = below(&channel.command, 0.0).map(|at| (at, format!("{word}_command_mbar")));
    let slack = OFFSET.max(0.1 * highest(&channel.command));
    let ((i, value), column) =
        asked.or_else(|| below(&channel.measured, slack).map(|at| (at, format!("{word}_mbar"))))?;
    let what = format!("{place}: {column} is {} at time_s = {:.3}", mbar(value), log.time[i]);
    let why = format!("pressures are over ambient and only filled; {} is left for a sensor's zero", mbar(slack));
    Some(Finding::mend(
        what,
        why,
        "check sign and zero of the sensor; a log of absolute pressure must have ambient taken off",
    ))
}

fn another_side(place: &str, side: Side, other: bool) -> Finding {
    let (word, opposite) = (side.word(), side.other().word());
    if other {
        let what = format!("{place}: the first command is {opposite}_command_mbar's");
        let why = format!("the card says that {word} is filled first");
        return Finding::mend(
            what,
            why,
            "swap the names of the log's columns back, or correct side of the trial on the card",
        );
    }
    let what = format!("{place}: {word}_command_mbar never rises above 0");
    Finding::mend(
        what,
        format!("the card says that {word} is filled"),
        "log what the valves were asked for, mbar over ambient",
    )
}

/// The highest command against the card's.
fn asked(place: &str, log: &PressureLog, experiment: &Experiment) -> Option<Finding> {
    let card = match experiment {
        Experiment::Staircase { levels, .. } => highest(levels),
        Experiment::Flapping { amplitude, .. } => *amplitude,
    };
    let command = highest(&log.side(experiment.side()).command);
    let factor = (command / card).max(card / command);
    (factor > ASKED).then(|| {
        let what = format!("{place} asks for up to {}, the card for {}", mbar(command), mbar(card));
        let why =
            format!("they differ by a factor of {factor:.1}; columns are in mbar, the card is in Pa (1 mbar = 100 Pa)");
        Finding::mend(what, why, "convert the log's columns to mbar, or the card's numbers to Pa")
    })
}

/// While one side alone is asked, it must answer, and by more than the other.
fn answered(place: &str, log: &PressureLog, side: Side, alone: Range<usize>) -> Option<Finding> {
    let peak = |s: Side| highest(&log.side(s).measured[alone.clone()]);
    let (own, other, word) = (peak(side), peak(side.other()), side.word());
    let command = highest(&log.side(side).command[alone.clone()]);
    if other > own {
        let what = format!("{place}: {word} is filled, and {}_mbar rises to {}", side.other().word(), mbar(other));
        let why = format!("{word}_mbar reaches {} meanwhile: the columns are swapped", mbar(own));
        return Some(Finding::mend(what, why, "swap the names of the measured columns, or the hoses"));
    }
    let part = own / command;
    (!(ANSWERED[0]..=ANSWERED[1]).contains(&part)).then(|| {
        let what = format!("{place}: {word}_mbar answers {} with {}", mbar(command), mbar(own));
        let why = format!("that is {part:.2} of it; {} to {} is believed", ANSWERED[0], ANSWERED[1]);
        Finding::mend(what, why, "convert the measured column to mbar, or look for a leak")
    })
}
