//! Checks of the card: it is readable and filled in, and every file that it names exists.

use std::path::Path;

use diagnostics::input;
use lab::Specimen;
use lab::card::{Card, Role};
use lab::table::line_of_path;
use toml::Value;

use super::finding::Finding;
use super::{Project, folder_name, log};
use crate::pictures::{LEFT_OUT, unfilmed_trials};

/// The specimen in a folder where its card can be read, and the findings on the card.
pub(crate) fn card_findings(project: &Project, folder: &Path) -> (Option<Specimen>, Vec<Finding>) {
    let card_path = project.display_path(&folder_name(folder), lab::folder::CARD);
    let text = input::read_text(&folder.join(lab::folder::CARD), input::PAGE).unwrap_or_default();
    let mut findings = log::encoding_notes(&card_path, &text);
    let open_keys = unfilled_keys(&text);
    if !open_keys.is_empty() {
        findings.extend(open_keys.into_iter().map(|(key, line)| unfilled_key(&card_path, &key, line)));
        return (None, findings);
    }
    match lab::card::parse(&text, &folder.join(lab::folder::CARD)) {
        Err(diagnostic) => {
            let line = diagnostic.line();
            findings.push(diagnostic.in_file(Path::new(&card_path)).at_line(line).into());
            (None, findings)
        }
        Ok(card) => {
            findings.extend(no_role(&card_path, &card));
            findings.extend(wide_ranges(&card_path, &card));
            findings
                .extend(unfilmed_trials(&card).map(|trials| Finding::log(format!("{card_path}: {trials}"), LEFT_OUT)));
            let specimen = Specimen { folder: folder.to_owned(), card };
            findings.extend(specimen.missing().into_iter().map(|diagnostic| {
                let missing_path = diagnostic.location.as_ref().map(|location| project.folders.display(&location.file));
                Finding::from(diagnostic.in_file(Path::new(&missing_path.unwrap_or_default())))
            }));
            (Some(specimen), findings)
        }
    }
}

fn unfilled_key(card_path: &str, key: &str, line: Option<usize>) -> Finding {
    let line = line.map_or(String::new(), |line| format!(", line {line}"));
    let key = key.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let defect = format!("{card_path}{line}: {key} is not filled in");
    Finding::fix(defect, "its value is nan", "enter the number; unit and range are in the comment behind it")
}

/// Keys with the value nan, with their lines: `study init` leaves them to be filled in.
fn unfilled_keys(text: &str) -> Vec<(String, Option<usize>)> {
    let text = text.trim_start_matches('\u{feff}');
    let mut keys = Vec::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        collect_nan_keys("", &Value::Table(table), &mut keys);
    }
    let mut lines: Vec<_> = keys.into_iter().map(|key| (line_of_path(text, &key), key)).collect();
    lines.sort();
    lines.dedup_by_key(|(line, _)| *line);
    lines.into_iter().map(|(line, key)| (key, line)).collect()
}

fn collect_nan_keys(path: &str, value: &Value, keys: &mut Vec<String>) {
    let child_path = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Float(number) if number.is_nan() => keys.push(path.to_owned()),
        Value::Table(table) => table.iter().for_each(|(key, value)| collect_nan_keys(&child_path(key), value, keys)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| collect_nan_keys(&child_path(&i.to_string()), value, keys))
        }
        _ => {}
    }
}

/// A card without a trial for identification.
fn no_role(card_path: &str, card: &Card) -> Option<Finding> {
    let identifies = card.trial.iter().any(|trial| trial.role == Role::Identify);
    let action = "give role = \"identify\" to a staircase, if moduli are to be identified";
    (!identifies).then(|| {
        Finding::note(format!("{card_path}: no trial has the role identify"), "nothing would be fitted", action)
    })
}

/// Highest over lowest plausible modulus, above which a search takes long: a data sheet leaves a factor of three.
const WIDE: f64 = 30.0;

/// Solids with a wide range of moduli.
fn wide_ranges<'a>(card_path: &'a str, card: &'a Card) -> impl Iterator<Item = Finding> + 'a {
    card.solid.parts.iter().filter_map(move |part| {
        let [low, high] = part.solid.plausible;
        let factor = high / low;
        (factor > WIDE).then(|| {
            Finding::note(
                format!("{card_path}: plausible of solid.{} spans a factor of {factor:.0}", part.name),
                "a search looks first for the softest silicone in it that stands the highest pressure, which may take minutes",
                "narrow it to what a data sheet or a first test allows",
            )
        })
    })
}
