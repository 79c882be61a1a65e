//! Table `thrust_models`: every rung of the ladder on every parting of the runs.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::Column;

use crate::fault::{Fault, Outcome};
use crate::needs::{Every, Maybe};
use crate::records::{Scored, Thrust, Transfer};
use crate::subject::{Scope, Study};
use crate::table::Table;

/// The table.
pub struct ThrustModels;

impl Table for ThrustModels {
    type Needs = (Every<Thrust>, Maybe<Transfer>);
    const NAME: &'static str = "thrust_models";
    const SHOWS: &'static str = "how well each model tells thrust it never saw";
    const EDITION: u32 = 3;

    fn is_made_for(study: &Study) -> bool {
        Every::<Thrust>::any(study)
    }

    fn fill((Every(all), Maybe(transfer)): Self::Needs) -> Outcome<plot::Table> {
        let columns = vec![
            Column::words("specimen"),
            Column::words("held out by"),
            Column::words("model"),
            Column::numbers("NRMSE", ""),
            Column::words("95 %"),
            Column::numbers("R²", ""),
            Column::numbers("mean error", "%"),
            Column::words("95 %"),
            Column::numbers("phase", "°"),
            Column { published: true, ..Column::words("published") },
        ];
        let across = transfer.iter().flat_map(|t| &t.scores);
        let rows = all.iter().flat_map(|(specimen, thrust)| {
            let name = specimen.name();
            let across: Vec<&Scored> =
                across.clone().filter(|held| held.tail == name).map(|held| &held.scored).collect();
            thrust.scores.iter().chain(across).map(|scored| row(&name, scored)).collect::<Vec<_>>()
        });
        let table = plot::Table::new(columns, rows.collect()).map_err(Fault::from_tool)?;
        Ok(table.noted(
            "NRMSE over the standard deviation of the measured force; intervals by bootstrap over beats. Tail: learnt from all others' runs.",
        ))
    }
}

fn row(specimen: &str, scored: &Scored) -> Vec<String> {
    let s = &scored.score;
    let model =
        if scored.seed == 0 { scored.rung.clone() } else { format!("{}, seed {}", scored.rung, scored.seed + 1) };
    let between = |[low, high]: [f64; 2], digits: usize| format!("{low:.digits$} to {high:.digits$}");
    vec![
        specimen.to_owned(),
        scored.parting.clone(),
        model,
        format!("{:.3}", s.nrmse),
        between(s.nrmse_interval, 3),
        format!("{:.3}", s.r2),
        format!("{:.1}", s.mean_error_percent),
        between(s.mean_interval_percent, 1),
        format!("{:.0}", s.phase_deg),
        published(specimen, scored).to_owned(),
    ]
}

/// What the paper says of a model's mean force on the runs that its card holds out; it gives no NRMSE.
fn published(specimen: &str, scored: &Scored) -> &'static str {
    match (specimen, scored.parting.as_str(), scored.rung.as_str()) {
        ("nemo", "card", "network") => "follows the force",
        ("bruce", "card", "network") => "nearly twice the force",
        (_, "card", "ebt") => "over-predicts",
        _ => "",
    }
}
