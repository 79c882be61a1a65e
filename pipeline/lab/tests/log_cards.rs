//! The parts of a card about logs and the tank: round trip, and each error with its key.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::Path;

use lab::card::{self, Card};

const CARD: &str = include_str!("../../study/tests/card.toml");
const STILL: &str = "
[tank]
length = 0.45
depth = 0.15

[[fixture]]
id = \"still_water\"
kind = \"still_water\"
medium = \"water\"
force = \"trials/still_water/force.csv\"
";
const LOG: &str = "
[log]
longest_gap = 0.05
force_lag = 0.2
force_lag_sigma = 0.02

[[log.columns]]
quantity = \"force_n\"
column = 2
unit = \"gf\"
of = \"hammer\"

[[log.columns]]
quantity = \"led\"
column = \"Lampe\"
scale = 0.2
";

fn parsed(more: &str) -> Result<Card, String> {
    card::parse(&format!("{CARD}{more}"), Path::new("fish/specimen.toml")).map_err(|e| e.to_string())
}

/// The refusal of a text with `from` changed to `to`.
fn refusal(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "`{from}` is there");
    parsed(&text.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn still_water_needs_a_tank_and_water() {
    assert!(parsed(STILL).is_ok());
    let said = refusal(STILL, "[tank]\nlength = 0.45\ndepth = 0.15\n", "");
    assert!(said.contains("still water, but the card has no [tank]"), "{said}");
    assert!(refusal(STILL, "medium = \"water\"", "medium = \"air\"").contains("still water in air"));
    assert!(refusal(STILL, "length = 0.45", "length = 450").contains("tank.length = 450 m is out of range"));
}

#[test]
fn tank_and_layout_of_logs_are_written_and_read_back() {
    let card = parsed(&format!("{STILL}{LOG}")).unwrap();
    assert_eq!(card::parse(&card::write(&card), Path::new("fish/specimen.toml")).unwrap(), card);
}

#[test]
fn a_wrong_quantity_unit_place_or_lag_is_refused_with_its_key() {
    for (from, to, piece) in [
        ("quantity = \"led\"", "quantity = \"lamp\"", "quantity is `lamp`"),
        ("unit = \"gf\"", "unit = \"kPa\"", "unit is `kPa`, of `force_n`"),
        ("column = 2", "column = 0", "column = 0 is out of range"),
        ("force_lag = 0.2\n", "force_lag = 200\n", "log.force_lag = 200 s is out of range"),
    ] {
        let said = refusal(LOG, from, to);
        assert!(said.contains(piece), "{said}");
    }
}
