//! Table `thrust_models`: every thrust model on every split of the runs.

use plot::Column;

use diagnostics::Result;
use records::subject::{Specimen, Study};
use records::{Scored, Thrust, Transfer};
use workflow::needs::{Every, Maybe};
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct ThrustModels;

impl Table for ThrustModels {
    type Of = Study;
    type Needs = (Every<Thrust, Specimen>, Maybe<Transfer>);
    const NAME: &'static str = "thrust_models";
    const CAPTION: &'static str = "error of each thrust model on held-out trials";
    const VERSION: u32 = 3;

    fn is_made_for(study: &Study) -> bool {
        Every::<Thrust>::any(study)
    }

    fn fill((Every(thrusts), Maybe(transfer)): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("specimen"),
            Column::text("held out by"),
            Column::text("model"),
            Column::numbers("NRMSE", ""),
            Column::text("95 %"),
            Column::numbers("R²", ""),
            Column::numbers("mean error", "%"),
            Column::text("95 %"),
            Column::numbers("phase", "°"),
            Column { published: true, ..Column::text("published") },
        ];
        let transfer_scores = transfer.iter().flat_map(|t| &t.scores);
        let rows = thrusts.iter().flat_map(|(specimen, thrust)| {
            let name = specimen.name();
            let held_out_scores: Vec<&Scored> =
                transfer_scores.clone().filter(|held| held.tail == name).map(|held| &held.scored).collect();
            thrust.scores.iter().chain(held_out_scores).map(|scored| score_row(&name, scored)).collect::<Vec<_>>()
        });
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted(
            "NRMSE: over the standard deviation of the measured force; intervals by bootstrap over cycles. Tail: trained on the runs of all other tails.",
        ))
    }
}

fn score_row(specimen: &str, scored: &Scored) -> Vec<String> {
    let s = &scored.score;
    let model =
        if scored.seed == 0 { scored.model.clone() } else { format!("{}, seed {}", scored.model, scored.seed + 1) };
    let interval_text = |[low, high]: [f64; 2], digits: usize| format!("{low:.digits$} to {high:.digits$}");
    vec![
        specimen.to_owned(),
        scored.split_rule.clone(),
        model,
        format!("{:.3}", s.nrmse),
        interval_text(s.nrmse_interval, 3),
        format!("{:.3}", s.r2),
        format!("{:.1}", s.mean_error_percent),
        interval_text(s.mean_interval_percent, 1),
        format!("{:.0}", s.phase_deg),
        published_statement(specimen, scored).to_owned(),
    ]
}

/// The paper's statement on a model's mean force on the held-out runs; it gives no NRMSE.
fn published_statement(specimen: &str, scored: &Scored) -> &'static str {
    match (specimen, scored.split_rule.as_str(), scored.model.as_str()) {
        ("nemo", "card", "network") => "follows the force",
        ("bruce", "card", "network") => "nearly twice the force",
        (_, "card", "ebt") => "over-predicts",
        _ => "",
    }
}
