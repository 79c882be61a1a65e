//! Table `validation`: how far each motion never seen is told, by every scheme and by the baselines that simulate nothing.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::Column;

use crate::fault::{Fault, Outcome};
use crate::figures::order::in_order;
use crate::needs::Every;
use crate::records;
use crate::subject::{Study, Trial};
use crate::table::Table;

/// The table.
pub struct Validation;

/// Schemes and baselines beside the first, as records name them, and what the table calls them.
const OTHERS: [(&str, &str); 5] = [
    ("bdf2_undamped", "undamped"),
    ("implicit_euler", "implicit Euler"),
    ("last_cycle", "last cycle"),
    ("quasi_static", "quasi-static"),
    ("rest", "at rest"),
];

impl Table for Validation {
    type Needs = Every<records::Validation>;
    const NAME: &'static str = "validation";
    const SHOWS: &'static str = "how far motions never seen are told, and by what else";
    const EDITION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::Validation>::any(study)
    }

    fn fill(Every(all): Self::Needs) -> Outcome<plot::Table> {
        let head = [
            Column::words("specimen"),
            Column::words("medium"),
            Column::words("condition"),
            Column::numbers("repeats", ""),
        ];
        let ours = [Column::numbers("RMSE", "mm"), Column::numbers("of length", "%"), Column::numbers("lag", "ms")];
        let others = OTHERS.map(|(_, title)| Column::numbers(title, "%"));
        let columns = head.into_iter().chain(ours).chain(others).collect();
        let rows = in_order(all).iter().map(|(trial, found)| row(trial, found)).collect();
        let table = plot::Table::new(columns, rows).map_err(Fault::from_tool)?;
        Ok(table.noted("Of the marker farthest out, from the mean of the repeats. RMSE: second order, damping from a release, in water drag from a release too."))
    }
}

fn row(trial: &Trial, found: &records::Validation) -> Vec<String> {
    let percent = |rmse: f64| format!("{:.2}", 100.0 * rmse / found.length);
    let ways = || found.scored.iter().chain(&found.baselines);
    let by = |name: &str| ways().find(|way| way.name == name).map_or(String::new(), |way| percent(way.rmse));
    let condition = trial.condition();
    let condition = condition.trim_end_matches("_water").replace("mbar_", " mbar ").replace("hz", " Hz");
    let mut cells = vec![
        trial.card.name.clone(),
        trial.trial.medium.word().to_owned(),
        condition,
        found.repeats.to_string(),
        format!("{:.2}", 1e3 * found.rmse),
        percent(found.rmse),
        found.lag.map_or(String::new(), |lag| format!("{:+.1}", 1e3 * lag)),
    ];
    cells.extend(OTHERS.map(|(name, _)| by(name)));
    cells
}
