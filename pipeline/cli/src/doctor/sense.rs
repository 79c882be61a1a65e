//! Consistency of a readable pressure log with the card: units, sides, range.

use std::ops::Range;

use lab::PressureLog;
use lab::card::{Experiment, Side};
use si::{MILLIBAR, Pascal};

use super::finding::Finding;

/// A log's highest command may be off the card's by this factor either way: units differ by 6.9 (psi, kPa) at least.
const ASKED: f64 = 2.0;
/// Least and greatest measured over commanded pressure of a side: valves are slow, and regulators overshoot.
const ANSWERED: [f64; 2] = [0.15, 2.0];
/// Sensors may be off by this much at rest, Pa.
const OFFSET: Pascal = 20.0 * MILLIBAR;

/// Findings on a log that contradict the card.
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

/// The first sample with a command above zero for a side.
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
    let why = format!("pressures are gauge pressures above ambient; {} is allowed for a sensor's zero", mbar(slack));
    Some(Finding::fix(
        what,
        why,
        "check sign and zero of the sensor; subtract ambient pressure from a log of absolute pressure",
    ))
}

fn another_side(place: &str, side: Side, other: bool) -> Finding {
    let (word, opposite) = (side.word(), side.other().word());
    if other {
        let what = format!("{place}: the first command is {opposite}_command_mbar's");
        let why = format!("on the card {word} is filled first");
        return Finding::fix(
            what,
            why,
            "swap the names of the log's columns back, or correct side of the trial on the card",
        );
    }
    let what = format!("{place}: {word}_command_mbar never rises above 0");
    Finding::fix(what, format!("on the card {word} is filled"), "log the valves' commands, mbar above ambient")
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
        let what = format!("{place} commands up to {}, the card {}", mbar(command), mbar(card));
        let why =
            format!("they differ by a factor of {factor:.1}; columns are in mbar, the card is in Pa (1 mbar = 100 Pa)");
        Finding::fix(what, why, "convert the log's columns to mbar, or the card's numbers to Pa")
    })
}

/// While one side alone is commanded, its pressure must rise, and by more than the other's.
fn answered(place: &str, log: &PressureLog, side: Side, alone: Range<usize>) -> Option<Finding> {
    let peak = |s: Side| highest(&log.side(s).measured[alone.clone()]);
    let (own, other, word) = (peak(side), peak(side.other()), side.word());
    let command = highest(&log.side(side).command[alone.clone()]);
    if other > own {
        let what = format!("{place}: {word} is filled, and {}_mbar rises to {}", side.other().word(), mbar(other));
        let why = format!("{word}_mbar reaches {} meanwhile: the columns are swapped", mbar(own));
        return Some(Finding::fix(what, why, "swap the names of the measured columns, or the hoses"));
    }
    let part = own / command;
    (!(ANSWERED[0]..=ANSWERED[1]).contains(&part)).then(|| {
        let what = format!("{place}: at a command of {} {word}_mbar reaches {}", mbar(command), mbar(own));
        let why = format!("that is a fraction of {part:.2}; {} to {} is accepted", ANSWERED[0], ANSWERED[1]);
        Finding::fix(what, why, "convert the measured column to mbar, or look for a leak")
    })
}
