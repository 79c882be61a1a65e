//! Ranges of `study.toml`: every numeric key of every profile has one, and what lies outside is refused with file, key and line.
#![allow(clippy::unwrap_used)]

use diagnostics::table::{self, Number};
use workflow::ranges::Ranges;
use workflow::settings::Profile;

const STUDY: &str = include_str!("../../../study.toml");
/// Numbers that no quantity has, and the least that a hand writes.
const NUMBERS: [&str; 8] = ["nan", "inf", "-inf", "-1", "0", "1e308", "1e18", "18446744073709551615"];

fn refusal(text: &str) -> Option<String> {
    study::settings(text, Profile::Paper).err().map(|refused| refused.to_string())
}

#[test]
fn every_numeric_key_of_every_profile_has_a_range_and_every_range_a_key() {
    assert_eq!(refusal(STUDY), None);
    let ranges = Ranges::parse(study::RANGES);
    let keys: Vec<String> = table::numbers(STUDY).into_iter().map(|number| number.key).collect();
    let without: Vec<&String> = keys.iter().filter(|key| ranges.ends(key).is_none()).collect();
    assert!(without.is_empty(), "{without:?}");
    let listed = toml::from_str::<toml::Table>(study::RANGES).unwrap();
    for (section, own) in &listed {
        for key in own.as_table().unwrap().keys() {
            let path = format!("{section}.{key}");
            assert!(keys.iter().any(|k| *k == path || k.starts_with(&format!("{path}."))), "{path}");
        }
    }
}

#[test]
fn numbers_that_no_quantity_has_are_refused_with_file_and_key_in_every_profile() {
    let ranges = Ranges::parse(study::RANGES);
    for Number { key, span, .. } in table::numbers(STUDY) {
        let list =
            key.rsplit_once('.').map_or("", |(list, last)| if last.parse::<usize>().is_ok() { list } else { &key });
        for number in NUMBERS {
            let text = format!("{}{number}{}", &STUDY[..span.start], &STUDY[span.end..]);
            let Some(message) = refusal(&text) else {
                let [low, high] = ranges.ends(&key).unwrap();
                assert!((low..=high).contains(&number.parse().unwrap()), "{key} = {number} is accepted");
                continue;
            };
            let named = message.starts_with("study.toml, line ") && message.contains("do:");
            assert!(named && message.contains(list), "{key} = {number}: {message}");
        }
    }
}

#[test]
fn a_list_that_is_empty_long_or_does_not_rise_is_refused_at_its_line() {
    let refused = |from: &str, to: &str| {
        assert!(STUDY.contains(from), "{from}");
        refusal(&STUDY.replacen(from, to, 1)).unwrap_or_default()
    };
    let falling = refused("band = [3.0, 30.0]", "band = [30.0, 3.0]");
    assert!(falling.starts_with("study.toml, line ") && falling.contains("load_cell.band does not rise"), "{falling}");
    let empty = refused("times = [0.002, 0.02, 0.2, 2.0, 20.0]", "times = []");
    assert!(empty.contains("relaxation.times has no number"), "{empty}");
    let long = format!("seeds = [{}]", "1, ".repeat(101));
    assert!(refused("seeds = [1]", &long).contains("thrust.seeds has more than 100 numbers"));
}
