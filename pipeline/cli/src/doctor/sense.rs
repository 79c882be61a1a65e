//! Consistency of a readable pressure log with the card: units, channels, range.

use std::ops::Range;

use lab::PressureLog;
use lab::card::Experiment;
use lab::pressure::{Channel, command_title, measured_title};
use si::{MILLIBAR, Pascal};

use super::finding::Finding;

/// A log's highest command may be off the card's by this factor either way: units differ by 6.9 (psi, kPa) at least.
const ASKED: f64 = 2.0;
/// Least and greatest measured over commanded pressure of a channel: valves are slow, and regulators overshoot.
const ANSWERED: [f64; 2] = [0.15, 2.0];
/// Sensors may be off by this much at rest, Pa.
const OFFSET: Pascal = 20.0 * MILLIBAR;

/// The channels that a trial fills first, and the others.
struct Channels<'a> {
    first: Vec<&'a Channel>,
    others: Vec<&'a Channel>,
}

/// Findings on a log that contradict the card.
pub fn look(place: &str, log: &PressureLog, experiment: &Experiment) -> Vec<Finding> {
    let mut found: Vec<Finding> = log.channels.iter().filter_map(|channel| negative(place, log, channel)).collect();
    let (first, others) = log.channels.iter().partition(|channel| experiment.first_channels().contains(&channel.name));
    let channels = Channels { first, others };
    let (begin, other) = (earliest(&channels.first), earliest(&channels.others));
    let Some((from, _)) = begin.filter(|(from, _)| other.is_none_or(|(other, _)| *from < other)) else {
        found.push(another_channel(place, &channels, other.map(|(_, channel)| channel)));
        return found;
    };
    found.extend(asked(place, &channels, experiment));
    found.extend(answered(place, &channels, from..other.map_or(log.time.len(), |(other, _)| other)));
    found
}

/// The first sample with a command above zero, and its channel.
fn earliest<'a>(channels: &[&'a Channel]) -> Option<(usize, &'a Channel)> {
    let begin = |channel: &&'a Channel| {
        channel.command.iter().position(|command| *command > 0.0).map(|sample| (sample, *channel))
    };
    channels.iter().filter_map(begin).min_by_key(|(sample, _)| *sample)
}

fn highest(values: &[Pascal]) -> Pascal {
    values.iter().copied().fold(0.0, f64::max)
}

fn mbar(pressure: Pascal) -> String {
    format!("{:.1} mbar", pressure / MILLIBAR)
}

fn names(channels: &[&Channel]) -> String {
    channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>().join(" and ")
}

fn negative(place: &str, log: &PressureLog, channel: &Channel) -> Option<Finding> {
    let below = |values: &[Pascal], limit: Pascal| values.iter().position(|p| *p < -limit).map(|i| (i, values[i]));
    let asked = below(&channel.command, 0.0).map(|at| (at, command_title(&channel.name)));
    let slack = OFFSET.max(0.1 * highest(&channel.command));
    let ((i, value), column) =
        asked.or_else(|| below(&channel.measured, slack).map(|at| (at, measured_title(&channel.name))))?;
    let what = format!("{place}: {column} is {} at time_s = {:.3}", mbar(value), log.time[i]);
    let why = format!("pressures are gauge pressures above ambient; {} is allowed for a sensor's zero", mbar(slack));
    Some(Finding::fix(
        what,
        why,
        "check sign and zero of the sensor; subtract ambient pressure from a log of absolute pressure",
    ))
}

/// The first command is another channel's, or there is none.
fn another_channel(place: &str, channels: &Channels<'_>, other: Option<&Channel>) -> Finding {
    let word = names(&channels.first);
    let Some(other) = other else {
        let columns: Vec<String> = channels.first.iter().map(|channel| command_title(&channel.name)).collect();
        let what = format!("{place}: {} never rises above 0", columns.join(" or "));
        return Finding::fix(
            what,
            format!("on the card {word} is filled"),
            "log the valves' commands, mbar above ambient",
        );
    };
    let what = format!("{place}: the first command is {}'s", command_title(&other.name));
    let act = "swap the names of the log's columns back, or correct channels of the trial on the card";
    Finding::fix(what, format!("on the card {word} is filled first"), act)
}

/// The highest command against the card's.
fn asked(place: &str, channels: &Channels<'_>, experiment: &Experiment) -> Option<Finding> {
    let card = match experiment {
        Experiment::Staircase { levels, .. } => highest(levels),
        Experiment::Flapping { amplitude, .. } => *amplitude,
    };
    let command = channels.first.iter().map(|channel| highest(&channel.command)).fold(0.0, f64::max);
    let factor = (command / card).max(card / command);
    (factor > ASKED).then(|| {
        let what = format!("{place} commands up to {}, the card {}", mbar(command), mbar(card));
        let why =
            format!("they differ by a factor of {factor:.1}; columns are in mbar, the card is in Pa (1 mbar = 100 Pa)");
        Finding::fix(what, why, "convert the log's columns to mbar, or the card's numbers to Pa")
    })
}

/// While the first channels alone are commanded, their pressures must rise, and by more than the others'.
fn answered(place: &str, channels: &Channels<'_>, alone: Range<usize>) -> Option<Finding> {
    let peak = |channel: &&Channel| highest(&channel.measured[alone.clone()]);
    let higher = channels.others.iter().copied().max_by(|a, b| peak(a).total_cmp(&peak(b)));
    channels.first.iter().find_map(|channel| {
        let (own, word) = (peak(channel), channel.name.as_str());
        if let Some(other) = higher.filter(|other| peak(other) > own) {
            let what = format!(
                "{place}: {word} is filled, and {} rises to {}",
                measured_title(&other.name),
                mbar(peak(&other))
            );
            let why = format!("{} reaches {} meanwhile: the columns are swapped", measured_title(word), mbar(own));
            return Some(Finding::fix(what, why, "swap the names of the measured columns, or the hoses"));
        }
        let command = highest(&channel.command[alone.clone()]);
        let part = own / command;
        (!(ANSWERED[0]..=ANSWERED[1]).contains(&part)).then(|| {
            let what =
                format!("{place}: at a command of {} {} reaches {}", mbar(command), measured_title(word), mbar(own));
            let why = format!("that is a fraction of {part:.2}; {} to {} is accepted", ANSWERED[0], ANSWERED[1]);
            Finding::fix(what, why, "convert the measured column to mbar, or look for a leak")
        })
    })
}
