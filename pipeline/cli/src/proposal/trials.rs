//! Trials: films with their logs, and what the commands in these say.

use super::columns::Role;
use super::experiment::{Experiment, experiment, pulses};
use super::film::Footage;
use super::guess::{Confidence, Guess};
use super::lamp::Lamp;
use super::logs::{Kind, Log};
use super::pairing::{Pair, Timed, pairs};

/// A film with its logs.
#[derive(Debug, Clone)]
pub(super) struct Trial<'a> {
    pub(super) id: String,
    pub(super) film: &'a Footage,
    pub(super) pressure: &'a Log,
    pub(super) force: Option<&'a Log>,
    /// How sure the films and logs belong together, and why.
    pub(super) pairing: Guess,
    /// The channels that are driven, and what is done with them; its numbers in the log's unit.
    pub(super) done: Option<(Vec<String>, Experiment)>,
}

/// The trials, the seconds of the logs in a second of the films, and what is left of films and logs.
pub(super) struct Trials<'a> {
    pub(super) trials: Vec<Trial<'a>>,
    pub(super) true_seconds: f64,
    pub(super) unpaired: Vec<Guess>,
}

/// Pairs films with pressure logs and these with force logs by the lamp.
pub(super) fn trials<'a>(films: &[&'a Footage], lamp: Option<&Lamp>, logs: &'a [Log]) -> Trials<'a> {
    let timed_films: Vec<(&'a Footage, Timed)> =
        films.iter().filter_map(|film| Some((*film, lit_film(film, lamp?)?))).collect();
    let pressure_logs = timed_logs(logs, Kind::Pressure);
    let force_logs = timed_logs(logs, Kind::Force);
    let (film_times, pressure_times, force_times) = (times(&timed_films), times(&pressure_logs), times(&force_logs));
    let (film_pairs, true_seconds) = pairs(&film_times, &pressure_times);
    let (force_pairs, _) = pairs(&pressure_times, &force_times);
    let trial = |pair: &Pair| {
        let (film, (pressure, timed)) = (timed_films[pair.film].0, &pressure_logs[pair.log]);
        let force = force_pairs.iter().find(|other| other.film == pair.log);
        Trial {
            id: String::new(),
            film,
            pressure,
            force: force.map(|other| force_logs[other.log].0),
            pairing: pairing_guess(pair, force, (film, timed, &film_times[pair.film])),
            done: done(pressure),
        }
    };
    let mut trials: Vec<Trial> = film_pairs.iter().map(trial).collect();
    name_trials(&mut trials);
    let unpaired = unpaired(&trials, films, logs);
    Trials { trials, true_seconds, unpaired }
}

fn times<T>(timed: &[(T, Timed)]) -> Vec<Timed> {
    timed.iter().map(|(_, timed)| timed.clone()).collect()
}

fn timed_logs(logs: &[Log], kind: Kind) -> Vec<(&Log, Timed)> {
    logs.iter().filter(|log| log.kind == kind).filter_map(|log| Some((log, log.timed()?))).collect()
}

fn lit_film(film: &Footage, lamp: &Lamp) -> Option<Timed> {
    let lit = film.blocks.lit(lamp).filter(|lit| lit.is_whole)?;
    let frame = 1.0 / film.info.rate;
    Some(Timed {
        name: film.name.clone(),
        lit: (lit.until - lit.from) as f64 * frame,
        resolution: lit.every as f64 * frame,
    })
}

fn pairing_guess(pair: &Pair, force: Option<&Pair>, (film, log, timed): (&Footage, &Timed, &Timed)) -> Guess {
    let durations = format!("the lamp is on for {:.3} s of the film and {:.3} s of the log", timed.lit, log.lit);
    let mut weakest = strength(pair);
    let mut evidence = format!("{durations}{}", choice(pair));
    if let Some(force) = force {
        weakest = weakest.max(strength(force));
        evidence += &format!("; the force log's lamp is on as long{}", choice(force));
    }
    Guess::new(weakest, &film.name, &log.name, evidence)
}

fn strength(pair: &Pair) -> Confidence {
    match (pair.is_only, pair.is_named) {
        (true, _) => Confidence::Certain,
        (_, true) => Confidence::Likely,
        _ => Confidence::Unsure,
    }
}

fn choice(pair: &Pair) -> &'static str {
    match (pair.is_only, pair.is_named) {
        (true, _) => ", and no other is",
        (_, true) => "; of several such the names tell which",
        _ => "; several are, in the order of their names: check which",
    }
}

/// What the commands say.
fn done(log: &Log) -> Option<(Vec<String>, Experiment)> {
    let commands: Vec<_> = log.of_role(Role::Command).collect();
    let values: Vec<&[f64]> = commands.iter().map(|column| &column.values[..]).collect();
    let (channels, experiment) = experiment(&pulses(&log.stamps(), &values))?;
    Some((channels.iter().filter_map(|k| commands[*k].channel.clone()).collect(), experiment))
}

/// Words of a path that many recordings share.
const GENERIC: [&str; 8] = ["video", "film", "clip", "movie", "camera", "cam", "recording", "trial"];

/// Names trials by their films, or by the folders of those.
fn name_trials(trials: &mut [Trial]) {
    let mut taken: Vec<String> = Vec::new();
    for trial in trials {
        let stem = trial.film.name.rsplit_once('.').map_or(&trial.film.name[..], |(stem, _)| stem);
        let parts: Vec<&str> = stem.split('/').collect();
        let telling = parts.iter().rev().find(|part| !GENERIC.contains(&part.to_lowercase().as_str()));
        let sign = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
        let word: String = telling.unwrap_or(&"trial").chars().map(sign).collect();
        let word = word.trim_start_matches('-').to_owned();
        let mut id = if word.is_empty() { "trial".to_owned() } else { word.clone() };
        for number in 2.. {
            if !taken.contains(&id) {
                break;
            }
            id = format!("{word}_{number}");
        }
        taken.push(id.clone());
        trial.id = id;
    }
}

/// Films and logs that belong to no trial.
fn unpaired(trials: &[Trial], films: &[&Footage], logs: &[Log]) -> Vec<Guess> {
    let films = films.iter().filter(|film| !trials.iter().any(|trial| std::ptr::eq(trial.film, **film)));
    let no_log = |film: &&Footage| {
        Guess::question(&film.name, "a film to which no log belongs by its lamp: which does, or leave it out")
    };
    let is_used = |log: &Log| {
        let is = |other: &Log| std::ptr::eq(other, log);
        trials.iter().any(|trial| is(trial.pressure) || trial.force.is_some_and(is))
    };
    let no_film = |log: &Log| {
        let lamp = if log.lit.is_some() { "by its lamp" } else { "since it shows no lamp" };
        Guess::question(
            &log.name,
            format!("a log that belongs to no film {lamp}: a trial's, a fixture's, or leave it out"),
        )
    };
    films.map(no_log).chain(logs.iter().filter(|log| !is_used(log)).map(no_film)).collect()
}
