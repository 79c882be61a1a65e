//! Trials: films with their logs, and what the commands in these say.

use super::columns::Role;
use super::experiment::{Experiment, experiment, pulses};
use super::film::Footage;
use super::guess::{Confidence, Guess};
use super::lag::lag_guess;
use super::lamp::{Lamp, Lit};
use super::logs::{Kind, Log};
use super::motion::{MotionLag, lag_by_motion};
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
    /// The lags of its logs, in their order on the card.
    pub(super) lags: Vec<Guess>,
    /// The channels that are driven, and what is done with them; its numbers in the log's unit.
    pub(super) done: Option<(Vec<String>, Experiment)>,
}

/// The trials, the seconds of the logs in a second of the films where a lamp tells them, and what is left of films and logs.
pub(super) struct Trials<'a> {
    pub(super) trials: Vec<Trial<'a>>,
    pub(super) true_seconds: Option<f64>,
    pub(super) unpaired: Vec<Guess>,
}

/// A film with the time for which its lamp is on.
struct LitFilm<'a> {
    film: &'a Footage,
    lit: Lit,
}

/// Pairs films with pressure logs and these with force logs by the lamp, and what is left of the films by their motion.
pub(super) fn trials<'a>(films: &[&'a Footage], lamp: Option<&Lamp>, logs: &'a [Log]) -> Trials<'a> {
    let (mut trials, true_seconds) = trials_by_lamp(films, lamp, logs);
    trials.extend(trials_by_motion(&trials, films, logs));
    name_trials(&mut trials);
    trials.iter_mut().for_each(name_lags);
    let unpaired = unpaired(&trials, films, logs);
    Trials { trials, true_seconds, unpaired }
}

fn trials_by_lamp<'a>(films: &[&'a Footage], lamp: Option<&Lamp>, logs: &'a [Log]) -> (Vec<Trial<'a>>, Option<f64>) {
    let lit_film = |film: &&'a Footage| Some(LitFilm { film, lit: film.blocks.lit(lamp?)? });
    let lit_films: Vec<LitFilm> = films.iter().filter_map(lit_film).collect();
    let pressure_logs = timed_logs(logs, Kind::Pressure);
    let force_logs = timed_logs(logs, Kind::Force);
    let film_times: Vec<Timed> = lit_films.iter().map(LitFilm::timed).collect();
    let (pressure_times, force_times) = (times(&pressure_logs), times(&force_logs));
    let (film_pairs, seconds) = pairs(&film_times, &pressure_times);
    let (force_pairs, _) = pairs(&pressure_times, &force_times);
    let trial = |pair: &Pair| {
        let (film, (pressure, timed)) = (&lit_films[pair.film], &pressure_logs[pair.log]);
        let force_pair = force_pairs.iter().find(|other| other.film == pair.log);
        let force = force_pair.map(|other| force_logs[other.log].0);
        let pairing = pairing_guess(pair, force_pair, (film.film, timed, &film_times[pair.film]));
        let lag = |log: &Log| lag_guess(kind_word(log), (&film.lit, log), seconds, pairing.confidence);
        let lags = std::iter::once(*pressure).chain(force).filter_map(lag).collect();
        Trial { id: String::new(), film: film.film, pressure, force, lags, done: done(pressure), pairing }
    };
    let trials: Vec<Trial> = film_pairs.iter().map(trial).collect();
    let true_seconds = (!trials.is_empty()).then_some(seconds);
    (trials, true_seconds)
}

/// The films and pressure logs that no lamp pairs, by the motion in the films: the best correlated first.
fn trials_by_motion<'a>(paired: &[Trial<'a>], films: &[&'a Footage], logs: &'a [Log]) -> Vec<Trial<'a>> {
    let films: Vec<&Footage> =
        films.iter().copied().filter(|film| !paired.iter().any(|trial| std::ptr::eq(trial.film, *film))).collect();
    let is_left =
        |log: &&Log| log.kind == Kind::Pressure && !paired.iter().any(|trial| std::ptr::eq(trial.pressure, *log));
    let logs: Vec<&Log> = logs.iter().filter(is_left).collect();
    let mut lags: Vec<(usize, usize, MotionLag)> = Vec::new();
    for (f, film) in films.iter().enumerate() {
        let motion = logs.iter().enumerate().filter_map(|(l, log)| Some((f, l, lag_by_motion(&film.blocks, log)?)));
        lags.extend(motion.filter(|(.., lag)| lag.is_guess()));
    }
    lags.sort_by(|a, b| b.2.correlation.total_cmp(&a.2.correlation));
    let mut trials: Vec<(usize, Trial)> = Vec::new();
    while let Some(&(f, l, lag)) = lags.first() {
        let is_rival = |(film, log, _): &&(usize, usize, MotionLag)| (*film == f) != (*log == l);
        let rival = lags.iter().filter(is_rival).map(|(.., lag)| lag.correlation).fold(0.0, f64::max);
        trials.push((f, motion_trial(films[f], logs[l], (&lag, rival))));
        lags.retain(|(film, log, _)| *film != f && *log != l);
    }
    trials.sort_by_key(|(f, _)| *f);
    trials.into_iter().map(|(_, trial)| trial).collect()
}

/// A trial by motion; `rival` is the best correlation of either with another.
fn motion_trial<'a>(film: &'a Footage, pressure: &'a Log, (lag, rival): (&MotionLag, f64)) -> Trial<'a> {
    let is_clear = lag.correlation > 1.15 * rival;
    let confidence = if is_clear { lag.confidence() } else { Confidence::Unsure };
    let evidence = format!(
        "no lamp pairs it; its picture moves with these pressures, correlated by {:.2}, and by {rival:.2} with the next best",
        lag.correlation
    );
    let pairing = Guess::new(confidence, &film.name, &pressure.name, evidence);
    let lags = vec![lag.guess(kind_word(pressure), confidence)];
    Trial { id: String::new(), film, pressure, force: None, lags, done: done(pressure), pairing }
}

fn kind_word(log: &Log) -> &'static str {
    if log.kind == Kind::Pressure { "pressure" } else { "force" }
}

/// Says of the lags of a named trial what they are about.
fn name_lags(trial: &mut Trial) {
    let id = &trial.id;
    trial.lags.iter_mut().for_each(|lag| lag.about = format!("trial.{id}.lag.{}", lag.about));
}

fn times<T>(timed: &[(T, Timed)]) -> Vec<Timed> {
    timed.iter().map(|(_, timed)| timed.clone()).collect()
}

fn timed_logs(logs: &[Log], kind: Kind) -> Vec<(&Log, Timed)> {
    logs.iter().filter(|log| log.kind == kind).filter_map(|log| Some((log, log.timed()?))).collect()
}

impl LitFilm<'_> {
    fn timed(&self) -> Timed {
        let Lit { from, until, step } = self.lit;
        Timed { name: self.film.name.clone(), lit: until - from, resolution: step }
    }
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
        Guess::question(
            &film.name,
            "a film to which no log belongs by its lamp or its motion: which does, or leave it out",
        )
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
