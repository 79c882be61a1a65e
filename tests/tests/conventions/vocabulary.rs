//! Names: no retired word comes back as an identifier, a key, a metric or a sentence that a user reads.
//!
//! A word is retired where the field has a standard term for what it named; the second entry says which. Identifiers are split at `_` and at
//! capitals, so `predicted_n` and `LevelLadder` are found as well as `told`.

use crate::assert_none;
use crate::source::Source;
use crate::tree::{sources, text, top};

/// Words that no identifier contains, and the term instead.
const RETIRED: &[(&str, &str)] = &[
    ("foretell", "predict"),
    ("foretold", "predicted"),
    ("foreseen", "predicted"),
    ("rung", "pressure level, thrust model"),
    ("rungs", "levels, models"),
    ("knob", "parameter"),
    ("desk", "stage context"),
    ("parcel", "record files"),
    ("shelf", "record reader"),
    ("tally", "summary"),
    ("lesson", "training settings"),
    ("parting", "split rule"),
    ("swimmer", "flapping model"),
    ("honesty", "sensitivity"),
    ("marches", "simulations"),
    ("uphill", "projected gradient"),
    ("softest", "feasible lower bound"),
    ("hill", "objective"),
    ("climb", "incremental loading, gradient ascent"),
    ("gait", "globalisation, actuation"),
    ("glide", "PCG on the lagged factor"),
    ("pace", "pseudo step"),
    ("stall", "no convergence"),
    ("wear", "refactorisation policy"),
    ("worn", "refactorisation policy"),
    ("sloped", "value with gradient"),
    ("freedoms", "dofs"),
    ("insideout", "inverted element"),
    ("demand", "options"),
    ("nudges", "perturbation snapshots"),
    ("march", "integrate in time"),
    ("drive", "actuation"),
    ("fate", "action"),
    ("waded", "underwater staircases"),
    ("learning", "identification trials"),
    ("malformed", "diagnostic"),
    ("conclude", "assemble record"),
    ("sighting", "observation"),
    ("sightings", "observations"),
    ("wishes", "load cases, settings that are asked for"),
    ("weighing", "whitening"),
    ("company", "neighbour distance"),
    ("undone", "deconvolved"),
    ("felt", "measured"),
    ("spare", "free memory"),
    ("unrest", "valve disturbance"),
    ("blows", "hammer taps"),
    ("receipts", "checkpoints"),
    ("unlettered", "without panel label"),
    ("laid", "layout"),
];

// Not retired, because the word has a standard meaning that the tree uses: creep, memory, moment, slope, spread (Covariance2 is a type), share, rule,
// patience, stride, walk (random), middle, part, dead load, degree of freedom, outcome, refusal, lane of a vector register, line of sight, turn,
// shed vortices. `ladder` is the list of laws that a fit tries in turn. The verbs `tell`, `keep` and `stand` stay in the sentences that name tests.

/// Phrases that no sentence for a user contains, and the one instead.
const PHRASES: &[(&str, &str)] = &[
    ("foretell", "predict"),
    ("foretold", "predicted"),
    ("keep company", "neighbour distances are bounded"),
    ("glides", "PCG on the lagged factor"),
    ("let go", "released"),
    ("swing dies", "decay of the free vibration"),
    ("may not leap", "changes from frame to frame are bounded"),
    ("how sure they are", "with their uncertainty"),
    ("simulates nothing", "baseline without a simulation"),
    ("tells more thrust", "over-predicts thrust"),
    ("tell other meshes", "moduli depend on the mesh"),
    ("learn to tell", "models are trained on"),
    ("it is undone", "its inverse is applied"),
    ("the flap of the most thrust", "the actuation of greatest mean thrust"),
];

/// The words of an identifier, in lower case.
fn words(identifier: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut previous_lower = false;
    for c in identifier.chars() {
        if c == '_' || (c.is_uppercase() && previous_lower) {
            words.push(String::new());
        }
        if c != '_' {
            words.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        previous_lower = c.is_lowercase();
    }
    words
}

fn identifiers(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = code.lines().enumerate();
    lines.flat_map(|(i, line)| line.split(|c: char| !c.is_alphanumeric() && c != '_').map(move |word| (i + 1, word)))
}

/// Retired words in the identifiers of a text, as `path:line identifier`.
fn retired(path: &str, code: &str) -> Vec<String> {
    let instead = |word: &String| RETIRED.iter().find(|(old, _)| old == word).map(|(_, new)| *new);
    let found = identifiers(code).filter_map(|(line, identifier)| {
        let new = words(identifier).iter().find_map(instead)?;
        Some(format!("{path}:{line} `{identifier}`: use {new}"))
    });
    found.collect()
}

fn in_code(source: &Source) -> Vec<String> {
    let module = source.path.trim_end_matches(".rs").rsplit('/').next().unwrap_or_default();
    let own = retired(&source.path, module);
    own.into_iter().chain(retired(&source.path, &source.code())).collect()
}

/// Whether a phrase stands in a line as whole words, so that `let goal` is not "let go".
fn contains_words(line: &str, phrase: &str) -> bool {
    let letter = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let whole = |(at, _): (usize, &str)| {
        let (before, after) = (line[..at].chars().next_back(), line[at + phrase.len()..].chars().next());
        !letter(before) && !letter(after)
    };
    line.match_indices(phrase).any(whole)
}

/// Phrases that a reader meets, as `path:line phrase`.
fn phrases(path: &str, text: &str) -> Vec<String> {
    let of_line = |(i, line): (usize, &str)| {
        let lower = line.to_lowercase();
        let found = PHRASES.iter().filter(|(old, _)| contains_words(&lower, old));
        found.map(|(old, new)| format!("{path}:{} \"{old}\": write \"{new}\"", i + 1)).collect::<Vec<_>>()
    };
    text.lines().enumerate().flat_map(of_line).collect()
}

/// Settings, cards, cases, metrics, claims and the pages that people read.
fn pages() -> Vec<(String, String)> {
    let files = [
        "study.toml",
        "paper/claims.toml",
        "paper/expected.toml",
        "pipeline/rig/bench.toml",
        "pipeline/cli/src/init/card.toml",
        "pipeline/simulate/src/case/keys.txt",
    ];
    let sections = std::fs::read_dir(top().join("paper/sections")).into_iter().flatten().flatten();
    let sections = sections.map(|entry| format!("paper/sections/{}", entry.file_name().to_string_lossy()));
    files
        .map(str::to_owned)
        .into_iter()
        .chain(crate::pages::pages())
        .chain(sections)
        .map(|path| (path.clone(), text(&path)))
        .collect()
}

#[test]
fn no_retired_word_is_an_identifier() {
    // the lists of this file name the words
    let others = sources(&["pipeline", "tests"]).into_iter().filter(|s| !s.path.ends_with("vocabulary.rs"));
    assert_none(others.flat_map(|source| in_code(&source)).collect());
}

#[test]
fn no_retired_word_is_a_key_or_stands_on_a_page() {
    assert_none(pages().iter().flat_map(|(path, text)| [retired(path, text), phrases(path, text)].concat()).collect());
}

#[test]
fn no_retired_phrase_stands_in_help_captions_or_messages() {
    let others = sources(&["pipeline"]).into_iter().filter(|s| !s.test);
    let strings = |source: Source| phrases(&source.path, &source.outside_tests(&source.text));
    assert_none(others.flat_map(strings).collect());
}

#[test]
fn a_retired_word_is_found_inside_an_identifier_and_a_longer_word_is_not() {
    assert_eq!(retired("a.rs", "struct LevelRung { told_rung: f64 }").len(), 2);
    assert!(retired("a.rs", "let wrung = strung;").is_empty());
    assert_eq!(phrases("a.md", "The motion is foretold.").len(), 1);
    assert!(phrases("a.rs", "let goal = 1;").is_empty());
}
