//! `[[log.columns]]` where the logs differ from the guide.

use crate::proposal::columns::{Column, Role};
use crate::proposal::guess::{Confidence, Guess};
use crate::proposal::logs::{Kind, Log};
use crate::proposal::trials::Trial;

use super::Writer;

impl Writer {
    /// `[log]` and its columns where a log differs from the guide.
    pub(super) fn logs(&mut self, trials: &[Trial]) {
        let pressure = trials.first().map(|trial| trial.pressure);
        let force = trials.iter().find_map(|trial| trial.force);
        for log in pressure.into_iter().chain(force) {
            let entries: Vec<Entry> =
                log.columns.iter().enumerate().filter_map(|(k, column)| entry(log, k, column)).collect();
            entries.into_iter().for_each(|entry| self.column(log, entry));
        }
    }

    fn column(&mut self, log: &Log, entry: Entry) {
        let log_kind = if log.kind == Kind::Pressure { "pressure" } else { "force" };
        self.put(format_args!("\n[[log.columns]]\nquantity = {:?}\nof = {log_kind:?}\n", entry.quantity));
        let about = |key: &str| format!("log.columns.{log_kind}.{}.{key}", entry.quantity);
        self.line("column", Guess::new(entry.sure, about("column"), entry.place, "by its title and its numbers"));
        if let Some((unit, confidence, evidence)) = entry.unit {
            self.line("unit", Guess::new(confidence, about("unit"), format!("{unit:?}"), evidence));
        }
        if let Some(scale) = entry.scale {
            self.line("scale", Guess::new(Confidence::Likely, about("scale"), scale, "1 is then the lamp that is on"));
        }
    }
}

/// A column that the card has to name.
struct Entry {
    quantity: String,
    place: String,
    sure: Confidence,
    unit: Option<(&'static str, Confidence, String)>,
    scale: Option<f64>,
}

/// The entry of a column; none of one that has the title and the unit of the guide, or that is not used.
fn entry(log: &Log, index: usize, column: &Column) -> Option<Entry> {
    let channel = column.channel.as_deref();
    let force_unit = || {
        (
            column.unit.unwrap_or("N"),
            if column.unit.is_some() { Confidence::Certain } else { Confidence::Unsure },
            "its title, or newtons where it names none".to_owned(),
        )
    };
    let (quantity, unit, own) = match column.role {
        Role::Time => ("time_s".to_owned(), Some(log.clock.clone()), "s"),
        Role::Lamp => ("led".to_owned(), None, ""),
        Role::Command => (format!("{}_command_mbar", channel?), Some(log.pressure_unit()), "mbar"),
        Role::Pressure => (format!("{}_mbar", channel?), Some(log.pressure_unit()), "mbar"),
        Role::Force => ("force_n".to_owned(), Some(force_unit()), "N"),
        Role::Other => return None,
    };
    let largest = column.values.iter().fold(0.0, |l: f64, v| l.max(*v));
    let scale = (column.role == Role::Lamp && (largest - 1.0).abs() > 0.2).then(|| 1.0 / largest);
    let unit = unit.filter(|(unit, ..)| *unit != own);
    if column.title.as_ref() == Some(&quantity) && unit.is_none() && scale.is_none() {
        return None;
    }
    let place = column.title.as_ref().map_or_else(|| (index + 1).to_string(), |title| format!("{title:?}"));
    let sure = if column.title.is_some() { Confidence::Likely } else { Confidence::Unsure };
    Some(Entry { quantity, place, sure, unit, scale })
}
