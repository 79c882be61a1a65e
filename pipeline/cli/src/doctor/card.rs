//! Checks of the card: it is readable and filled in, and every file that it names exists.

use std::path::Path;

use diagnostics::input;
use lab::Specimen;
use lab::card::{Card, Role};
use lab::table::line_of_path;
use toml::Value;

use super::finding::Finding;
use super::{Look, called, log};
use crate::pictures::{LEFT_OUT, unfilmed};

/// The specimen in a folder where its card can be read, and the findings on the card.
pub fn look(look: &Look, folder: &Path) -> (Option<Specimen>, Vec<Finding>) {
    let place = look.place(&called(folder), lab::folder::CARD);
    let text = input::read_text(&folder.join(lab::folder::CARD), input::PAGE).unwrap_or_default();
    let mut found = log::oddities(&place, &text);
    let open = unfilled(&text);
    if !open.is_empty() {
        found.extend(open.into_iter().map(|(key, line)| to_fill_in(&place, &key, line)));
        return (None, found);
    }
    match lab::card::parse(&text, &folder.join(lab::folder::CARD)) {
        Err(diagnostic) => {
            let line = diagnostic.line();
            found.push(diagnostic.in_file(Path::new(&place)).at_line(line).into());
            (None, found)
        }
        Ok(card) => {
            found.extend(no_role(&place, &card));
            found.extend(wide(&place, &card));
            found.extend(unfilmed(&card).map(|what| Finding::log(format!("{place}: {what}"), LEFT_OUT)));
            let specimen = Specimen { folder: folder.to_owned(), card };
            found.extend(specimen.missing().into_iter().map(|diagnostic| {
                let file = diagnostic.location.as_ref().map(|location| look.folders.display(&location.file));
                Finding::from(diagnostic.in_file(Path::new(&file.unwrap_or_default())))
            }));
            (Some(specimen), found)
        }
    }
}

fn to_fill_in(place: &str, key: &str, line: Option<usize>) -> Finding {
    let line = line.map_or(String::new(), |line| format!(", line {line}"));
    let key = key.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let what = format!("{place}{line}: {key} is not filled in");
    Finding::fix(what, "its value is nan", "enter the number; unit and range are in the comment behind it")
}

/// Keys with the value nan, with their lines: `study init` leaves them to be filled in.
fn unfilled(text: &str) -> Vec<(String, Option<usize>)> {
    let text = text.trim_start_matches('\u{feff}');
    let mut found = Vec::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        visit("", &Value::Table(table), &mut found);
    }
    let mut lines: Vec<_> = found.into_iter().map(|key| (line_of_path(text, &key), key)).collect();
    lines.sort();
    lines.dedup_by_key(|(line, _)| *line);
    lines.into_iter().map(|(line, key)| (key, line)).collect()
}

fn visit(path: &str, value: &Value, found: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Float(number) if number.is_nan() => found.push(path.to_owned()),
        Value::Table(table) => table.iter().for_each(|(key, value)| visit(&below(key), value, found)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| visit(&below(&i.to_string()), value, found))
        }
        _ => {}
    }
}

/// A card without a trial for identification.
fn no_role(place: &str, card: &Card) -> Option<Finding> {
    let fitted = card.trial.iter().any(|trial| trial.role == Role::Identify);
    let act = "give role = \"identify\" to a staircase, if moduli are to be identified";
    (!fitted).then(|| Finding::note(format!("{place}: no trial has the role identify"), "nothing would be fitted", act))
}

/// Highest over lowest plausible modulus, above which a search takes long: a data sheet leaves a factor of three.
const WIDE: f64 = 30.0;

/// Solids with a wide range of moduli.
fn wide<'a>(place: &'a str, card: &'a Card) -> impl Iterator<Item = Finding> + 'a {
    card.solid.parts.iter().filter_map(move |part| {
        let [low, high] = part.solid.plausible;
        let factor = high / low;
        (factor > WIDE).then(|| {
            Finding::note(
                format!("{place}: plausible of solid.{} spans a factor of {factor:.0}", part.name),
                "a search looks first for the softest silicone in it that stands the highest pressure, which may take minutes",
                "narrow it to what a data sheet or a first test allows",
            )
        })
    })
}
