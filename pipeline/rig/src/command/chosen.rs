//! What of the bench is asked for on the command line: specimens, trials of them, members of a population.

use std::collections::BTreeMap;

use diagnostics::{Diagnostic, Result};

use crate::settings::Settings;
use crate::specimen::Specimen;
use crate::specimens::ALL;

/// The numbers of the specimens of a population that are asked for.
pub(super) fn chosen_numbers(count: u16, only: Option<u16>) -> Result<Vec<usize>> {
    match only {
        None => Ok((1..=usize::from(count)).collect()),
        Some(number) if (1..=count).contains(&number) => Ok(vec![number.into()]),
        Some(number) => Err(Diagnostic::new(
            format!("there is no specimen {number} to be drawn"),
            format!("{count} are asked for, from 1 on"),
            "name one of these with --only, or draw more",
        )),
    }
}

/// A specimen, and the parts that are asked for; none where all of it is.
pub(super) type Chosen = (&'static Specimen, Option<Vec<String>>);

/// The specimens among `names`, each of which is a specimen's or a part's, SPECIMEN/PART; all of the profile if `names` is empty. With `cards` no part of
/// any.
pub(super) fn chosen_parts(names: &[String], cards: bool, profile: &str, set: &Settings) -> Result<Vec<Chosen>> {
    let mut parts: BTreeMap<&str, Option<Vec<String>>> = BTreeMap::new();
    for name in names {
        let (specimen, part) = name.split_once('/').map_or((&**name, None), |(specimen, part)| (specimen, Some(part)));
        let known = parts.entry(specimen).or_insert_with(|| Some(Vec::new()));
        match part {
            None => *known = None,
            Some(part) => known.iter_mut().for_each(|parts| parts.push(part.to_owned())),
        }
    }
    let specimens: Vec<String> = parts.keys().map(|name| name.to_string()).collect();
    let of_specimen = |specimen: &'static Specimen| match cards {
        true => (specimen, Some(Vec::new())),
        false => (specimen, parts.get(&*specimen.name).cloned().flatten()),
    };
    Ok(chosen_specimens(&specimens, profile, set)?.into_iter().map(of_specimen).collect())
}

/// The specimens of these names, or those of the profile if `names` is empty.
pub(super) fn chosen_specimens(names: &[String], profile: &str, set: &Settings) -> Result<Vec<&'static Specimen>> {
    known_profile(profile, set)?;
    let names = if names.is_empty() { &set.profile[profile].specimens } else { names };
    let known_names: Vec<&str> = ALL.iter().map(|s| &*s.name).collect();
    let find = |name: &String| {
        ALL.iter()
            .find(|s| s.name == **name)
            .ok_or_else(|| unknown_name(&format!("the specimen `{name}`"), &known_names))
    };
    names.iter().map(find).collect()
}

pub(super) fn known_profile(profile: &str, set: &Settings) -> Result<()> {
    let known_profiles: Vec<&str> = set.profile.keys().map(String::as_str).collect();
    let refused = || unknown_name(&format!("the profile `{profile}`"), &known_profiles);
    if known_profiles.contains(&profile) { Ok(()) } else { Err(refused()) }
}

fn unknown_name(subject: &str, known_names: &[&str]) -> Diagnostic {
    Diagnostic::new(
        format!("{subject} is unknown"),
        format!("the bench has {}", known_names.join(", ")),
        "name one of these",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_behind_their_specimen_and_a_whole_specimen_has_them_all() {
        let set = Settings::built_in();
        let chosen = |names: &[&str], cards: bool| {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            let chosen = chosen_parts(&names, cards, "paper", &set).unwrap();
            chosen.into_iter().map(|(specimen, trials)| (specimen.name.to_string(), trials)).collect::<Vec<_>>()
        };
        let trials = |names: &[&str]| Some(names.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(chosen(&["nemo/a", "nemo/b"], false), [("nemo".to_owned(), trials(&["a", "b"]))]);
        assert_eq!(chosen(&["nemo/a", "nemo"], false), [("nemo".to_owned(), None)]);
        assert_eq!(chosen(&["bruce"], true), [("bruce".to_owned(), trials(&[]))]);
        assert_eq!(chosen(&[], false).len(), set.profile["paper"].specimens.len());
    }

    #[test]
    fn an_unknown_specimen_or_profile_is_an_error_that_lists_the_known_ones() {
        let set = Settings::built_in();
        let message = |names: &[&str], profile: &str| {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            chosen_specimens(&names, profile, &set).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(message(&["goldfish"], "quick").contains("the bench has nemo"));
        assert!(message(&[], "slow").contains("paper, population, quick"));
        assert_eq!(message(&[], "quick"), "");
    }

    #[test]
    fn one_specimen_of_a_population_is_drawn_by_its_number() {
        assert_eq!(chosen_numbers(3, None).unwrap(), [1, 2, 3]);
        assert_eq!(chosen_numbers(3, Some(3)).unwrap(), [3]);
        assert!([0, 4].iter().all(|number| chosen_numbers(3, Some(*number)).is_err()));
    }
}
