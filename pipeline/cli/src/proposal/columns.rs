//! The columns of a log: what each holds, and in which unit.

use lab::log::table::RawTable;

use super::guess::Confidence;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Lamp,
    Command,
    Pressure,
    Force,
    Other,
}

/// A column of a log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    /// Its title; none in a log without titles.
    pub(super) title: Option<String>,
    pub(super) role: Role,
    /// The unit by its word on a card, where the file names it.
    pub(super) unit: Option<&'static str>,
    /// The name of its channel, where it has one.
    pub(super) channel: Option<String>,
    pub(super) values: Vec<f64>,
}

/// Words of titles, in lower case, without units.
const LAMP: [&str; 9] = ["led", "lamp", "light", "lampe", "licht", "sync", "trigger", "ttl", "flash"];
const COMMAND: [&str; 9] = ["command", "cmd", "set", "setpoint", "soll", "target", "reference", "ref", "sollwert"];
const MEASURED: [&str; 7] = ["measured", "meas", "actual", "ist", "sensor", "istwert", "reading"];
const PRESSURE: [&str; 5] = ["pressure", "druck", "press", "p", "valve"];
const FORCE: [&str; 9] = ["force", "kraft", "load", "thrust", "fx", "fy", "fz", "loadcell", "cell"];
const TIME: [&str; 6] = ["time", "t", "zeit", "timestamp", "clock", "x"];

/// Units by their spelling, the word of the card, and what they measure.
const UNITS: [(&str, &str, Role); 20] = [
    ("mbar", "mbar", Role::Pressure),
    ("hPa", "mbar", Role::Pressure),
    ("kPa", "kPa", Role::Pressure),
    ("Pa", "Pa", Role::Pressure),
    ("bar", "bar", Role::Pressure),
    ("psi", "psi", Role::Pressure),
    ("N", "N", Role::Force),
    ("mN", "mN", Role::Force),
    ("gf", "gf", Role::Force),
    ("g", "gf", Role::Force),
    ("newton", "N", Role::Force),
    ("s", "s", Role::Time),
    ("sec", "s", Role::Time),
    ("seconds", "s", Role::Time),
    ("ms", "ms", Role::Time),
    ("msec", "ms", Role::Time),
    ("us", "us", Role::Time),
    ("µs", "us", Role::Time),
    ("μs", "us", Role::Time),
    ("micros", "us", Role::Time),
];

/// Letters and digits of a title in lower case, without separators.
fn title_words(title: &str) -> Vec<String> {
    let parts = title.split(|c: char| !c.is_alphanumeric());
    parts.filter(|part| !part.is_empty()).map(str::to_lowercase).collect()
}

/// The unit that a text names: in brackets, or as the last of its words; the text alone may be one.
fn unit_of(text: &str) -> Option<(&'static str, Role)> {
    let bracketed = text.rfind(['[', '(']).map(|open| text[open + 1..].trim_end_matches([']', ')', ' ']));
    let last = text.rsplit(|c: char| !c.is_alphanumeric() && c != '°').next().unwrap_or_default();
    let known_unit = |word: &str| {
        let exact = UNITS.iter().find(|(unit, ..)| *unit == word.trim());
        exact.or_else(|| UNITS.iter().find(|(unit, ..)| unit.eq_ignore_ascii_case(word.trim())))
    };
    // a title that is one word names a quantity
    let is_alone = title_words(text).len() == 1 && bracketed.is_none();
    let unit = bracketed.and_then(known_unit).or_else(|| (!is_alone).then(|| known_unit(last)).flatten());
    unit.map(|(_, word, role)| (*word, *role))
}

/// The columns of a table.
pub(super) fn columns(table: &RawTable) -> Vec<Column> {
    let column = |k: usize| {
        let title = table.titles.as_ref().and_then(|titles| titles.get(k)).cloned();
        let own_line = table.units.as_ref().and_then(|units| units.get(k));
        let from_line =
            own_line.and_then(|unit| unit_of(&format!("[{}]", unit.trim_matches(['[', ']', '(', ')', ' ']))));
        let named = from_line.or_else(|| title.as_deref().and_then(unit_of));
        let date = table.is_date[k].then_some(("iso8601", Role::Time));
        Column {
            role: Role::Other,
            unit: date.or(named).map(|(word, _)| word),
            channel: None,
            values: table.columns[k].clone(),
            title,
        }
    };
    let mut columns: Vec<Column> = (0..table.columns.len()).map(column).collect();
    assign_roles(&mut columns);
    name_channels(&mut columns);
    columns
}

fn assign_roles(columns: &mut [Column]) {
    let hinted = |column: &Column, hints: &[&str]| {
        let words = column.title.as_deref().map(title_words).unwrap_or_default();
        words.iter().any(|word| hints.contains(&word.trim_end_matches(char::is_numeric)))
    };
    let rising: Vec<usize> = (0..columns.len()).filter(|&k| is_rising(&columns[k].values)).collect();
    let named_time =
        rising.iter().copied().find(|&k| hinted(&columns[k], &TIME) || columns[k].unit_role() == Some(Role::Time));
    let Some(time) = named_time.or(rising.first().copied()) else { return };
    columns[time].role = Role::Time;
    let two_levels: Vec<usize> =
        (0..columns.len()).filter(|&k| k != time && is_switched_once(&columns[k].values)).collect();
    let named_lamp = two_levels.iter().copied().find(|&k| hinted(&columns[k], &LAMP));
    let longest =
        two_levels.into_iter().filter(|&k| columns[k].unit.is_none()).max_by_key(|&k| on_samples(&columns[k].values));
    let lamp = named_lamp.or(longest.filter(|_| columns.iter().all(|column| column.title.is_none())));
    lamp.into_iter().for_each(|k| columns[k].role = Role::Lamp);
    let is_lone = columns.iter().filter(|column| column.role == Role::Other && is_numeric(&column.values)).count() == 1;
    for column in columns.iter_mut().filter(|column| column.role == Role::Other && is_numeric(&column.values)) {
        let (is_step, measures) = (is_piecewise_constant(&column.values), column.unit_role());
        let is_force =
            measures == Some(Role::Force) || measures.is_none() && (hinted(column, &FORCE) || is_lone && !is_step);
        let is_pressure = measures == Some(Role::Pressure)
            || measures.is_none()
                && (column.title.is_none()
                    || [&COMMAND[..], &MEASURED, &PRESSURE].iter().any(|hints| hinted(column, hints)));
        column.role = match (is_force, is_pressure) {
            (true, _) => Role::Force,
            (_, true) if hinted(column, &COMMAND) || is_step && !hinted(column, &MEASURED) => Role::Command,
            (_, true) => Role::Pressure,
            _ => Role::Other,
        };
    }
}

impl Column {
    /// What its unit measures.
    fn unit_role(&self) -> Option<Role> {
        let unit = self.unit?;
        UNITS
            .iter()
            .find(|(_, word, _)| *word == unit)
            .map(|(.., role)| *role)
            .or((unit == "iso8601").then_some(Role::Time))
    }
}

fn is_numeric(values: &[f64]) -> bool {
    values.iter().filter(|v| v.is_finite()).count() * 10 > values.len() * 9
}

fn is_rising(values: &[f64]) -> bool {
    is_numeric(values) && values.windows(2).filter(|pair| pair[1] <= pair[0]).count() * 100 <= values.len()
}

/// Whether samples mostly repeat the one before.
fn is_piecewise_constant(values: &[f64]) -> bool {
    values.windows(2).filter(|pair| pair[0] != pair[1]).count() * 10 <= values.len()
}

fn middle_value(values: &[f64]) -> f64 {
    let range = values
        .iter()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    0.5 * (range.0 + range.1)
}

fn on_samples(values: &[f64]) -> usize {
    let middle = middle_value(values);
    values.iter().filter(|v| **v > middle).count()
}

/// Low, then high, then perhaps low again, with hardly anything between.
fn is_switched_once(values: &[f64]) -> bool {
    let middle = middle_value(values);
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let switches = values.windows(2).filter(|pair| (pair[0] > middle) != (pair[1] > middle)).count();
    let between_levels = values.iter().filter(|v| (*v - low).min(high - *v) > 0.2 * (high - low)).count();
    high > low && values[0] < middle && (1..=2).contains(&switches) && between_levels <= 4
}

/// When the lamp of a log lights and goes out, by its clock; none where it does not go out.
pub(super) fn lit_interval(time: &[f64], lamp: &[f64]) -> Option<[f64; 2]> {
    let middle = middle_value(lamp);
    let switches: Vec<usize> = (1..lamp.len()).filter(|&k| (lamp[k] > middle) != (lamp[k - 1] > middle)).collect();
    let [on, off] = switches[..] else { return None };
    // length: a time for each sample of the lamp; between the first that shows the change and the one before it
    Some([on, off].map(|k| 0.5 * (time[k - 1] + time[k])))
}

/// Names the channels by what is left of the titles of their columns, or by number; each command has its measured pressure.
fn name_channels(columns: &mut [Column]) {
    let noise: Vec<&str> = [&COMMAND[..], &MEASURED, &PRESSURE].concat();
    let channel_words = |column: &Column| {
        let unit = column.unit.map(str::to_lowercase);
        let words = column.title.as_deref().map(title_words).unwrap_or_default();
        let telling_words = words.into_iter().filter(|word| {
            !noise.contains(&word.as_str())
                && Some(word) != unit.as_ref()
                && !UNITS.iter().any(|(name, ..)| name.to_lowercase() == *word)
        });
        telling_words.filter(|word| word.is_ascii()).collect::<Vec<_>>().join("_")
    };
    let commands: Vec<usize> = (0..columns.len()).filter(|&k| columns[k].role == Role::Command).collect();
    let mut measured: Vec<usize> = (0..columns.len()).filter(|&k| columns[k].role == Role::Pressure).collect();
    for (number, &command) in commands.iter().enumerate() {
        let own_words = channel_words(&columns[command]);
        let same = measured.iter().position(|&k| !own_words.is_empty() && channel_words(&columns[k]) == own_words);
        let follows = |k: &usize| correlation(&columns[command].values, &columns[*k].values);
        let best = (0..measured.len()).max_by(|&a, &b| follows(&measured[a]).total_cmp(&follows(&measured[b])));
        let best = best.filter(|&place| follows(&measured[place]) > 0.8);
        // of channels at rest nothing but the order tells which is whose
        let partner = same.or(best).or((!measured.is_empty()).then_some(0)).map(|place| measured.remove(place));
        let name = if own_words.is_empty() { format!("channel_{}", number + 1) } else { own_words };
        partner.into_iter().chain([command]).for_each(|k| columns[k].channel = Some(name.clone()));
    }
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let [mean_a, mean_b] = [a, b].map(|values| values.iter().sum::<f64>() / count);
    // length: both are columns of one table
    let sums = a.iter().zip(b).fold([0.0; 3], |[ab, aa, bb], (x, y)| {
        let (x, y) = (x - mean_a, y - mean_b);
        [ab + x * y, aa + x * x, bb + y * y]
    });
    if sums[1] * sums[2] > 0.0 { sums[0] / (sums[1] * sums[2]).sqrt() } else { 0.0 }
}

/// The unit of pressures that name none: the first in which the largest is that of a soft actuator.
pub(super) fn plausible_pressure(largest: f64) -> (&'static str, Confidence) {
    let pascals = [("mbar", 100.0), ("kPa", 1e3), ("bar", 1e5), ("psi", 6_894.757), ("Pa", 1.0)];
    let fits = pascals.iter().find(|(_, factor)| (2e3..2e5).contains(&(largest * factor)));
    (fits.map_or("mbar", |(unit, _)| *unit), Confidence::Unsure)
}

/// One of a unit in the units of our logs: s, mbar or N.
pub(super) fn in_log_units(unit: &str) -> f64 {
    match unit {
        "ms" | "mN" => 1e-3,
        "us" => 1e-6,
        "day" => 86_400.0,
        "Pa" => 0.01,
        "kPa" => 10.0,
        "bar" => 1e3,
        "psi" => 68.947_57,
        "gf" => 9.806_65e-3,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn units_are_read_in_brackets_and_at_the_end_of_titles() {
        for (title, unit) in [
            ("time_s", Some("s")),
            ("Zeit [ms]", Some("ms")),
            ("Kraft (mN)", Some("mN")),
            ("left_command_mbar", Some("mbar")),
            ("Soll links [kPa]", Some("kPa")),
            ("force_n", Some("N")),
            ("t", None),
            ("s", None),
            ("led", None),
        ] {
            assert_eq!(unit_of(title).map(|(word, _)| word), unit, "{title}");
        }
    }

    #[test]
    fn the_columns_of_a_log_are_told_by_titles_and_by_numbers() {
        let titled = "Lampe,Druck ist rechts [kPa],Soll links [kPa],Zeit [ms],Soll rechts [kPa],Druck ist links [kPa]";
        for titles in [format!("{titled}\n"), String::new()] {
            let row = |k: usize| {
                let is_on = (10..90).contains(&k);
                let level = if (20..40).contains(&k) {
                    5.0
                } else if (50..70).contains(&k) {
                    10.0
                } else {
                    0.0
                };
                let noise = (k * 37 % 11) as f64 * 0.01;
                format!("{},{noise},{level},{},0,{}\n", i32::from(is_on), 5 * k, level + noise)
            };
            let table = RawTable::new(&(titles.clone() + &(0..100).map(row).collect::<String>())).unwrap();
            let columns = columns(&table);
            let roles = [Role::Lamp, Role::Pressure, Role::Command, Role::Time, Role::Command, Role::Pressure];
            assert_eq!(columns.iter().map(|column| column.role).collect::<Vec<_>>(), roles, "{titles}");
            assert_eq!(lit_interval(&columns[3].values, &columns[0].values), Some([47.5, 447.5]));
            let channels: Vec<&str> = [2, 5, 4, 1].map(|k| columns[k].channel.as_deref().unwrap()).to_vec();
            let expected = if titles.is_empty() {
                ["channel_1", "channel_1", "channel_2", "channel_2"]
            } else {
                ["links", "links", "rechts", "rechts"]
            };
            assert_eq!(channels, expected);
        }
    }
}
