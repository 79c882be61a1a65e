//! Units that a log names of its columns, in a line of their own or in the titles, against those of the card.

use crate::card::{LogColumn, Unit, dimension_of};

/// Spellings of units.
const SPELLINGS: [(&str, Unit); 26] = [
    ("s", Unit::Second),
    ("sec", Unit::Second),
    ("seconds", Unit::Second),
    ("ms", Unit::Millisecond),
    ("msec", Unit::Millisecond),
    ("milliseconds", Unit::Millisecond),
    ("us", Unit::Microsecond),
    ("µs", Unit::Microsecond),
    ("μs", Unit::Microsecond),
    ("microseconds", Unit::Microsecond),
    ("day", Unit::Day),
    ("days", Unit::Day),
    ("Pa", Unit::Pascal),
    ("pa", Unit::Pascal),
    ("mbar", Unit::Millibar),
    ("hPa", Unit::Millibar),
    ("kPa", Unit::Kilopascal),
    ("kpa", Unit::Kilopascal),
    ("bar", Unit::Bar),
    ("psi", Unit::PoundPerSquareInch),
    ("PSI", Unit::PoundPerSquareInch),
    ("N", Unit::Newton),
    ("newton", Unit::Newton),
    ("mN", Unit::Millinewton),
    ("gf", Unit::GramForce),
    ("g", Unit::GramForce),
];
/// Share by which a scale with a unit may differ from the unit that the file names: standard gravity and that of the place.
const SHARE: f64 = 0.05;

/// The unit of a column: of its line of units, else at the end of its title behind one of the signs `before`. None where the file names none, or
/// one of something else than the quantity.
pub(super) fn file_unit([title, unit]: [Option<&str>; 2], before: &[char], quantity: &str) -> Option<Unit> {
    let of_title = || title.and_then(|title| title.rsplit_once(before)).map(|(_, unit)| unit);
    let word = unit.filter(|unit| !unit.is_empty()).or_else(of_title)?.trim_matches(['[', ']', '(', ')', ' ']);
    let (_, unit) = SPELLINGS.iter().find(|(spelling, _)| *spelling == word)?;
    (unit.dimension() == dimension_of(quantity)).then_some(*unit)
}

impl Unit {
    /// The unit of the card in words, where it is another than this one of the file; an own scale of the same unit corrects an instrument.
    pub(super) fn contradicting_unit(self, quantity: &str, entry: Option<&LogColumn>) -> Option<String> {
        let unit = entry.and_then(|entry| entry.unit);
        let scale = entry.map_or(1.0, |entry| entry.scale);
        let is_same = unit == Some(self) || unit == Some(Self::Iso8601);
        let ratio = scale * unit.map_or(1.0, Self::in_log_units) / self.in_log_units();
        if is_same || (ratio - 1.0).abs() <= SHARE {
            return None;
        }
        let word =
            unit.map_or_else(|| quantity.rsplit('_').next().unwrap_or_default().to_owned(), |u| u.word().to_owned());
        Some(if scale == 1.0 { word } else { format!("{scale} {word}") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_in_their_line_or_at_the_end_of_a_title() {
        for (title, unit, quantity, expected) in [
            (Some("time_s"), Some("ms"), "time_s", Some(Unit::Millisecond)),
            (Some("time_s"), None, "time_s", Some(Unit::Second)),
            (Some("Kraft [mN]"), None, "force_n", Some(Unit::Millinewton)),
            (Some("Kraft (N)"), Some(""), "force_n", Some(Unit::Newton)),
            (Some("left_mbar"), Some("[kPa]"), "left_mbar", Some(Unit::Kilopascal)),
            (Some("p_s"), None, "left_mbar", None),
            (Some("counts"), Some("1"), "force_n", None),
            (Some("U [V]"), Some("V"), "force_n", None),
            (None, None, "time_s", None),
        ] {
            assert_eq!(file_unit([title, unit], &['[', '(', '_'], quantity), expected, "{title:?} {unit:?}");
        }
    }

    #[test]
    fn a_unit_of_the_file_contradicts_another_of_the_card_unless_its_scale_converts() {
        let entry = |unit: Option<Unit>, scale: f64| {
            let unit = unit.map_or(String::new(), |unit| format!("unit = \"{}\"\n", unit.word()));
            toml::from_str::<LogColumn>(&format!("quantity = \"force_n\"\ncolumn = 2\nscale = {scale}\n{unit}"))
                .unwrap()
        };
        for (named, unit, scale, expected) in [
            (Unit::Millinewton, Some(Unit::Newton), 1.0, Some("N")),
            (Unit::Millinewton, None, 1.0, Some("n")),
            (Unit::Millinewton, Some(Unit::Newton), 5e-6, Some("0.000005 N")),
            (Unit::Millinewton, Some(Unit::Newton), 1e-3, None),
            (Unit::Millinewton, Some(Unit::Millinewton), 1.7, None),
            (Unit::GramForce, Some(Unit::Newton), 0.00981, None),
            (Unit::Newton, None, 1.0, None),
        ] {
            let contradiction = named.contradicting_unit("force_n", Some(&entry(unit, scale)));
            assert_eq!(contradiction.as_deref(), expected, "{named:?} {unit:?} {scale}");
        }
        assert_eq!(
            file_unit([Some("time_s"), None], &['[', '('], "time_s"),
            None,
            "a unit of the card stands before a name"
        );
        assert_eq!(Unit::Millisecond.contradicting_unit("time_s", None).as_deref(), Some("s"));
    }
}
