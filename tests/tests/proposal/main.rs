//! Twenty folders of one recording of the bench, with names, formats and units changed: the card that `study doctor FOLDER` proposes is right,
//! and no guess that it calls certain is wrong.
#![allow(clippy::unwrap_used)] // a panic fails the test

mod recorded;
mod scrambled;

use cli::proposal::{Confidence, Guess, Proposal, propose};
use recorded::Recorded;
use scrambled::{Scheme, Scrambled, TrialFiles};

const FOLDERS: u64 = 20;
/// Folders that must come out right.
const RIGHT: usize = 18;

#[test]
fn of_twenty_changed_folders_eighteen_come_out_right_and_nothing_certain_is_wrong() {
    let recorded = Recorded::new();
    let outcomes: Vec<(u64, Vec<String>)> = (0..FOLDERS)
        .map(|seed| {
            let scrambled = Scrambled::new(&recorded, seed);
            let proposal = propose(&scrambled.folder, "specimen").unwrap();
            let wrong: Vec<String> = proposal
                .guesses
                .iter()
                .filter(|guess| is_wrong_certainty(guess, &scrambled, &proposal))
                .map(Guess::to_string)
                .collect();
            assert!(wrong.is_empty(), "folder {seed} ({:?}): certain, and wrong: {wrong:#?}", scrambled.scheme);
            (seed, deviations(&proposal, &scrambled))
        })
        .collect();
    let right = outcomes.iter().filter(|(_, deviations)| deviations.is_empty()).count();
    let wrong: Vec<_> = outcomes.iter().filter(|(_, deviations)| !deviations.is_empty()).collect();
    assert!(right >= RIGHT, "{right} of {FOLDERS} are right: {wrong:#?}");
}

fn card(proposal: &Proposal) -> toml::Table {
    toml::from_str(&proposal.card).unwrap_or_else(|e| panic!("{e}\n{}", proposal.card))
}

/// The trials of a card.
fn trials(card: &toml::Table) -> Vec<toml::Table> {
    let trials = card.get("trial").and_then(toml::Value::as_array).cloned().unwrap_or_default();
    trials.into_iter().map(|trial| trial.as_table().unwrap().clone()).collect()
}

/// Largest error of a certain lag, s: a frame and a sample of a log.
const LAG: f64 = 0.03;

/// What the card says otherwise than the recording.
fn deviations(proposal: &Proposal, scrambled: &Scrambled) -> Vec<String> {
    let card = card(proposal);
    let mut deviations = Vec::new();
    let mut compare = |about: &str, proposed: String, truth: String| {
        if proposed != truth {
            deviations.push(format!("{about}: {proposed} for {truth}"));
        }
    };
    let board = &card["camera"]["board"];
    compare("calibration", card["camera"]["calibration"].as_str().unwrap().into(), scrambled.calibration.clone());
    compare("board", format!("{} × {}", board["columns"], board["rows"]), "9 × 6".into());
    let lamp: Vec<f64> = card["led"]["centre"].as_array().unwrap().iter().map(|c| c.as_float().unwrap()).collect();
    let off = (lamp[0] - scrambled.lamp[0]).hypot(lamp[1] - scrambled.lamp[1]);
    compare("lamp within 8 px", (off < 8.0).to_string(), "true".into());
    let trials = trials(&card);
    compare("trials", trials.len().to_string(), scrambled.trials.len().to_string());
    for truth in &scrambled.trials {
        let of_film = trials.iter().find(|trial| trial["video"].as_str() == Some(&truth.film));
        compare(&truth.film, of_film.map_or_else(|| "no trial".into(), said), truth.said());
        let about =
            of_film.map_or_else(String::new, |trial| format!("trial.{}.lag.pressure", trial["id"].as_str().unwrap()));
        let lag = proposal.guesses.iter().find(|guess| guess.about == about).and_then(|guess| guess.value.clone());
        let is_near = |lag: String| (lag.parse::<f64>().unwrap() - truth.lags[0]).abs() < LAG;
        compare(&format!("lag of {}", truth.film), lag.is_some_and(is_near).to_string(), "true".into());
    }
    for (quantity, of, unit) in scrambled.units() {
        compare(&format!("unit of {quantity}"), unit_on_card(&card, &quantity, of), unit);
    }
    deviations
}

/// A trial's files and what was done, in words.
fn said(trial: &toml::Table) -> String {
    let text = |key: &str| trial.get(key).and_then(toml::Value::as_str).unwrap_or("none").to_owned();
    let number =
        |key: &str| trial.get(key).map_or(f64::NAN, |v| v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap());
    let list = |key: &str| trial[key].as_array().unwrap().clone();
    let files = format!("{} {}", text("pressure"), text("force"));
    let channels: Vec<String> = list("channels").iter().map(|channel| channel.as_str().unwrap().to_owned()).collect();
    let channels = channels.join("+");
    if text("kind") == "flapping" {
        let (kilopascals, frequency) = (number("amplitude") / 1e3, number("frequency"));
        return format!(
            "{files} {channels} flaps {} kPa {} Hz {}",
            kilopascals.round(),
            frequency.round(),
            number("cycles")
        );
    }
    let levels: Vec<f64> = list("levels").iter().map(|level| (level.as_float().unwrap() / 100.0).round()).collect();
    let tenths = |key: &str| (number(key) * 20.0).round() / 20.0;
    format!("{files} {channels} staircase {levels:?} {} {}", tenths("hold"), tenths("pause"))
}

/// The unit of a quantity on the card; empty where it is that of the quantity's own title.
fn unit_on_card(card: &toml::Table, quantity: &str, of: &str) -> String {
    let columns = card.get("log").and_then(|log| log.get("columns")).and_then(toml::Value::as_array);
    let entry = columns
        .into_iter()
        .flatten()
        .find(|entry| entry["quantity"].as_str() == Some(quantity) && entry["of"].as_str() == Some(of));
    entry.and_then(|entry| entry.get("unit")).and_then(toml::Value::as_str).unwrap_or_default().to_owned()
}

/// Whether a guess says that it is certain, and is wrong. Of each kind of certain guess the truth is known here.
fn is_wrong_certainty(guess: &Guess, scrambled: &Scrambled, proposal: &Proposal) -> bool {
    let (Confidence::Certain, Some(value)) = (guess.confidence, &guess.value) else { return false };
    let unquoted = value.trim_matches('"');
    let parts: Vec<&str> = guess.about.split('.').collect();
    match parts[..] {
        ["camera", "calibration"] => unquoted != scrambled.calibration,
        ["camera", "board", key] => {
            unquoted
                != [("columns", "9"), ("rows", "6"), ("kind", "checkerboard")]
                    .iter()
                    .find(|(k, _)| *k == key)
                    .unwrap()
                    .1
        }
        ["trial", id, "lag", of] => {
            let lag: f64 = value.parse().unwrap();
            (lag - scrambled.lag_of(&film_of(proposal, id), of)).abs() > LAG
        }
        ["trial", id, key] => scrambled.file_of(&film_of(proposal, id), key) != unquoted,
        ["log", "columns", of, quantity, "unit"] => {
            !scrambled.units().iter().any(|(q, o, unit)| (&q[..], *o, &unit[..]) == (quantity, of, unquoted))
        }
        ["frame rate"] => !value.starts_with("60.00 "),
        _ if value.starts_with("text: ") => !scrambled.scheme.is_dialect(value),
        _ => panic!("nothing is known here of the certain guess {guess}"),
    }
}

fn film_of(proposal: &Proposal, id: &str) -> String {
    let trials = trials(&card(proposal));
    let trial = trials.iter().find(|trial| trial["id"].as_str() == Some(id)).unwrap();
    trial["video"].as_str().unwrap().to_owned()
}

#[test]
fn every_scheme_occurs() {
    let schemes: Vec<Scheme> = (0..FOLDERS).map(Scheme::of).collect();
    let kinds = |key: fn(&Scheme) -> String| {
        let mut all: Vec<String> = schemes.iter().map(key).collect();
        all.sort();
        all.dedup();
        all.len()
    };
    assert_eq!(kinds(|scheme| scheme.layout.to_string()), 4);
    assert_eq!(kinds(|scheme| scheme.separator.to_string()), 3);
    assert_eq!(kinds(|scheme| scheme.encoding.to_string()), 4);
    assert_eq!(kinds(|scheme| scheme.pressure.0.to_owned()), 4);
    let files = TrialFiles { film: "a".into(), pressure: "b".into(), force: None, done: String::new(), lags: [0.0; 2] };
    assert_eq!(files.said(), "b none ");
}
