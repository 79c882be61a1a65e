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
pub(crate) fn consistency_findings(log_path: &str, log: &PressureLog, experiment: &Experiment) -> Vec<Finding> {
    let mut findings: Vec<Finding> =
        log.channels.iter().filter_map(|channel| negative_pressure(log_path, log, channel)).collect();
    let (first, others) = log.channels.iter().partition(|channel| experiment.first_channels().contains(&channel.name));
    let channels = Channels { first, others };
    let (first_rise, other_rise) = (first_command(&channels.first), first_command(&channels.others));
    let Some((start, _)) = first_rise.filter(|(start, _)| other_rise.is_none_or(|(other_rise, _)| *start < other_rise))
    else {
        findings.push(another_channel(log_path, &channels, other_rise.map(|(_, channel)| channel)));
        return findings;
    };
    findings.extend(command_mismatch(log_path, &channels, experiment));
    findings.extend(response_mismatch(
        log_path,
        &channels,
        start..other_rise.map_or(log.time.len(), |(other_rise, _)| other_rise),
    ));
    findings
}

/// The first sample with a command above zero, and its channel.
fn first_command<'a>(channels: &[&'a Channel]) -> Option<(usize, &'a Channel)> {
    let first_rise = |channel: &&'a Channel| {
        channel.command.iter().position(|command| *command > 0.0).map(|sample| (sample, *channel))
    };
    channels.iter().filter_map(first_rise).min_by_key(|(sample, _)| *sample)
}

fn highest_pressure(values: &[Pascal]) -> Pascal {
    values.iter().copied().fold(0.0, f64::max)
}

fn in_mbar(pressure: Pascal) -> String {
    format!("{:.1} mbar", pressure / MILLIBAR)
}

fn joined_names(channels: &[&Channel]) -> String {
    channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>().join(" and ")
}

fn negative_pressure(log_path: &str, log: &PressureLog, channel: &Channel) -> Option<Finding> {
    let first_below =
        |values: &[Pascal], limit: Pascal| values.iter().position(|p| *p < -limit).map(|i| (i, values[i]));
    let negative_command = first_below(&channel.command, 0.0).map(|sample| (sample, command_title(&channel.name)));
    let tolerance = OFFSET.max(0.1 * highest_pressure(&channel.command));
    let ((i, value), column) = negative_command
        .or_else(|| first_below(&channel.measured, tolerance).map(|sample| (sample, measured_title(&channel.name))))?;
    let defect = format!("{log_path}: {column} is {} at time_s = {:.3}", in_mbar(value), log.time[i]);
    let reason =
        format!("pressures are gauge pressures above ambient; {} is allowed for a sensor's zero", in_mbar(tolerance));
    Some(Finding::fix(
        defect,
        reason,
        "check sign and zero of the sensor; subtract ambient pressure from a log of absolute pressure",
    ))
}

/// The first command is another channel's, or there is none.
fn another_channel(log_path: &str, channels: &Channels<'_>, other: Option<&Channel>) -> Finding {
    let filled = joined_names(&channels.first);
    let Some(other) = other else {
        let columns: Vec<String> = channels.first.iter().map(|channel| command_title(&channel.name)).collect();
        let defect = format!("{log_path}: {} never rises above 0", columns.join(" or "));
        return Finding::fix(
            defect,
            format!("on the card {filled} is filled"),
            "log the valves' commands, mbar above ambient",
        );
    };
    let defect = format!("{log_path}: the first command is {}'s", command_title(&other.name));
    let action = "swap the names of the log's columns back, or correct channels of the trial on the card";
    Finding::fix(defect, format!("on the card {filled} is filled first"), action)
}

/// The highest command against the card's.
fn command_mismatch(log_path: &str, channels: &Channels<'_>, experiment: &Experiment) -> Option<Finding> {
    let card_level = match experiment {
        Experiment::Staircase { levels, .. } => highest_pressure(levels),
        Experiment::Flapping { amplitude, .. } => *amplitude,
    };
    let command = channels.first.iter().map(|channel| highest_pressure(&channel.command)).fold(0.0, f64::max);
    let factor = (command / card_level).max(card_level / command);
    (factor > ASKED).then(|| {
        let defect = format!("{log_path} commands up to {}, the card {}", in_mbar(command), in_mbar(card_level));
        let reason =
            format!("they differ by a factor of {factor:.1}; columns are in mbar, the card is in Pa (1 mbar = 100 Pa)");
        Finding::fix(defect, reason, "convert the log's columns to mbar, or the card's numbers to Pa")
    })
}

/// While the first channels alone are commanded, their pressures must rise, and by more than the others'.
fn response_mismatch(log_path: &str, channels: &Channels<'_>, alone: Range<usize>) -> Option<Finding> {
    let peak = |channel: &&Channel| highest_pressure(&channel.measured[alone.clone()]);
    let strongest = channels.others.iter().copied().max_by(|a, b| peak(a).total_cmp(&peak(b)));
    channels.first.iter().find_map(|channel| {
        let (response, name) = (peak(channel), channel.name.as_str());
        if let Some(other) = strongest.filter(|other| peak(other) > response) {
            let defect = format!(
                "{log_path}: {name} is filled, and {} rises to {}",
                measured_title(&other.name),
                in_mbar(peak(&other))
            );
            let reason =
                format!("{} reaches {} meanwhile: the columns are swapped", measured_title(name), in_mbar(response));
            return Some(Finding::fix(defect, reason, "swap the names of the measured columns, or the hoses"));
        }
        let command = highest_pressure(&channel.command[alone.clone()]);
        let ratio = response / command;
        (!(ANSWERED[0]..=ANSWERED[1]).contains(&ratio)).then(|| {
            let defect = format!(
                "{log_path}: at a command of {} {} reaches {}",
                in_mbar(command),
                measured_title(name),
                in_mbar(response)
            );
            let reason = format!("that is a fraction of {ratio:.2}; {} to {} is accepted", ANSWERED[0], ANSWERED[1]);
            Finding::fix(defect, reason, "convert the measured column to mbar, or look for a leak")
        })
    })
}
