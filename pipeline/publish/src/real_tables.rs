//! Numbers of the real recordings: `study fit` writes them as tables, which are tracked, and the paper's text takes them from there.
//!
//! A cell is `real_beam.LAW.FITTED[.RECORDING].QUANTITY.COLUMN`, `real_arm.MATERIAL[.FITTED].RECORDING.QUANTITY.COLUMN` or
//! `real_scoreboard.LAW.CONDITION.QUANTITY.COLUMN`, where letters and digits are kept and anything between them is `_`.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use workflow::metric::Metric;

/// A table of `study fit`: its file, the columns that name a row, the one with the unit, and those with numbers.
struct Layout {
    name: &'static str,
    keys: &'static [&'static str],
    /// Columns of numbers, each with its unit where that is not the row's.
    numbers: &'static [(&'static str, Option<&'static str>)],
}

const LAYOUTS: [Layout; 3] = [
    Layout {
        name: "real_beam",
        keys: &["law", "fitted", "recording", "quantity"],
        numbers: &[("measured", None), ("value", None), ("half_width_95", None), ("error_percent", Some("%"))],
    },
    Layout {
        name: "real_arm",
        keys: &["material", "fitted", "recording", "quantity"],
        numbers: &[("measured", None), ("predicted", None), ("error", Some("%")), ("missing_mbar", Some("mbar"))],
    },
    Layout {
        name: "real_scoreboard",
        keys: &["law", "condition", "quantity"],
        numbers: &[("recorded", None), ("predicted", None), ("half_width_95", None), ("error_percent", Some("%"))],
    },
];

/// The numbers of the tables in a folder; none of a table that is not there.
///
/// # Errors
/// A [`Diagnostic`] when a table is not understood.
pub(crate) fn read(folder: &Path) -> Result<Vec<Metric>> {
    let numbers_of = |layout: &Layout| {
        let path = folder.join(format!("{}.csv", layout.name));
        if !path.exists() {
            return Ok(Vec::new());
        }
        let diagnostic = |e: &dyn std::fmt::Display| {
            Diagnostic::new(format!("{} is not understood", path.display()), e, "just real, which writes it")
        };
        let text = input::read_text(&path, input::LOG).map_err(|e| diagnostic(&e))?;
        layout.table_numbers(&text).map_err(|e| diagnostic(&e))
    };
    LAYOUTS.iter().map(numbers_of).collect::<Result<Vec<_>>>().map(|all| all.concat())
}

impl Layout {
    fn table_numbers(&self, text: &str) -> csv::Result<Vec<Metric>> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let head = reader.headers()?.clone();
        let column = |name: &str| head.iter().position(|title| title == name);
        let mut numbers = Vec::new();
        for row in reader.records() {
            let row = row?;
            let cell = |name: &str| column(name).and_then(|k| row.get(k)).unwrap_or_default();
            let keys: Vec<String> = self.keys.iter().map(|key| slug(cell(key))).filter(|key| !key.is_empty()).collect();
            let unit = cell("unit");
            let named = self.numbers.iter().filter_map(|(name, own)| {
                let id = format!("{}.{}.{name}", self.name, keys.join("."));
                Some(Metric::new(id, cell(name).parse().ok()?, own.unwrap_or(unit)))
            });
            numbers.extend(named);
        }
        Ok(numbers)
    }
}

/// Letters and digits in lower case, with `_` for what lies between them.
fn slug(words: &str) -> String {
    let parts = words.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
    parts.map(str::to_lowercase).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_named_by_its_row_and_column() {
        let text = "law,fitted,recording,quantity,unit,measured,value,half_width_95,error_percent\n\
                    elastic,a + b,,youngs_modulus,Pa,,2.5,0.5,\nelastic,a + b,c,tip at the end,mm,1.0,2.0,,100.0\n";
        let numbers = LAYOUTS[0].table_numbers(text).unwrap();
        let expected = [
            ("real_beam.elastic.a_b.youngs_modulus.value", 2.5, "Pa"),
            ("real_beam.elastic.a_b.youngs_modulus.half_width_95", 0.5, "Pa"),
            ("real_beam.elastic.a_b.c.tip_at_the_end.measured", 1.0, "mm"),
            ("real_beam.elastic.a_b.c.tip_at_the_end.value", 2.0, "mm"),
            ("real_beam.elastic.a_b.c.tip_at_the_end.error_percent", 100.0, "%"),
        ];
        assert_eq!(numbers, expected.map(|(id, value, unit)| Metric::new(id, value, unit)));
    }
}
