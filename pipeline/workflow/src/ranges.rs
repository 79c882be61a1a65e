//! Ranges of the numbers of `study.toml`: each key has one, and every profile is held to it.
//!
//! A slip of a unit or a sign is refused before anything is computed, also in a profile that is not run today. A program lists its ranges as
//! a page of TOML with the sections and keys of the settings.

use std::collections::BTreeMap;
use std::path::Path;

use diagnostics::table::{self, Number};
use diagnostics::{Diagnostic, Result};
use serde::Deserialize;
use toml::{Table, Value};

use crate::settings::{FILE, Profile, SEE};

/// The ranges of all keys, by section and key.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranges(BTreeMap<String, BTreeMap<String, Range>>);

/// The least and the greatest value of a key, or of each number of its list, and what the list is held to.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Range {
    Ends(f64, f64),
    List(f64, f64, Rule),
}

/// What a list is held to, besides the range of its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Rule {
    /// It has a number at least.
    Filled,
    /// It has a number at least, and its numbers rise.
    Rising,
}

/// Numbers of a list at most: each costs a simulation, or a layer of a network.
const LONGEST_LIST: usize = 100;

impl Ranges {
    /// The ranges that a program lists.
    ///
    /// # Panics
    /// When the list is not as it is described: it is part of the program.
    pub fn parse(text: &str) -> Self {
        Self(toml::from_str(text).expect("the ranges are part of the program and are read by every test"))
    }

    /// The ends of the range of the key with this path; the path begins with the profile where that is not the paper's.
    pub fn ends(&self, path: &str) -> Option<[f64; 2]> {
        let mut parts = path.split('.').peekable();
        parts.next_if(|name| is_profile(name));
        let (section, key) = (parts.next()?, parts.next()?);
        let (Range::Ends(low, high) | Range::List(low, high, _)) = *self.0.get(section)?.get(key)?;
        Some([low, high])
    }

    /// Holds every number of the settings in `text` to the range of its key, in every profile.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the key, its value, its range and its line.
    pub fn check(&self, text: &str) -> Result<()> {
        for number in table::numbers(text) {
            let ends = self.ends(&number.key);
            ends.filter(|[low, high]| !(*low..=*high).contains(&number.value))
                .map_or(Ok(()), |ends| Err(out_of_range(text, &number, ends)))?;
        }
        // a page that is no TOML is refused by its reader, with the line
        let paper: Table = toml::from_str(text).unwrap_or_default();
        self.check_lists(text, &paper, "")?;
        let mut tables = paper.iter().filter_map(|(name, value)| Some((name, value.as_table()?)));
        tables.try_for_each(|(name, table)| match is_profile(name) {
            true => self.check_lists(text, table, &format!("{name}.")),
            false => Ok(()),
        })
    }

    fn check_lists(&self, text: &str, settings: &Table, profile: &str) -> Result<()> {
        let keys = self.0.iter().flat_map(|(section, keys)| keys.iter().map(move |(key, range)| (section, key, range)));
        for (section, key, range) in keys {
            let list = settings.get(section).and_then(|section| section.get(key)).and_then(Value::as_array);
            let Some(fault) = list.and_then(|values| range.list_fault(values)) else { continue };
            let path = format!("{profile}{section}.{key}");
            let line = table::line_of_path(text, &path);
            let reason = format!("a list has 1 to {LONGEST_LIST} numbers, and bounds, knots and levels rise");
            return Err(settings_error(format!("{path} {fault}"), reason).at_line(line));
        }
        Ok(())
    }
}

impl Range {
    /// What is wrong with a list of numbers, besides each of them.
    fn list_fault(&self, values: &[Value]) -> Option<&'static str> {
        let Range::List(_, _, rule) = self else {
            return (values.len() > LONGEST_LIST).then_some("has more than 100 numbers");
        };
        let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
        let numbers: Vec<f64> = values.iter().filter_map(number).collect();
        match rule {
            _ if values.len() > LONGEST_LIST => Some("has more than 100 numbers"),
            _ if values.is_empty() => Some("has no number"),
            Rule::Rising if !numbers.is_sorted_by(|a, b| a < b) => Some("does not rise"),
            _ => None,
        }
    }
}

fn is_profile(name: &str) -> bool {
    Profile::ALL.iter().any(|profile| profile.name() == name)
}

fn out_of_range(text: &str, number: &Number, [low, high]: [f64; 2]) -> Diagnostic {
    let Number { key, value, span } = number;
    // Beyond this, digits without an exponent are not legible.
    let value = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
    let reason = format!("the range is {low} to {high}; numbers are in SI units");
    settings_error(format!("{key} = {value} is out of range"), reason).at_line(table::line_of_offset(text, span.start))
}

fn settings_error(problem: String, reason: String) -> Diagnostic {
    Diagnostic::file(Path::new(FILE), problem, reason, format!("correct it; {SEE}"))
}
