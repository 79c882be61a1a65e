//! Table `thrust_models`: the thrust models on the held-out trials of the card, and three of them on the other splits of the runs.

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
    const VERSION: u32 = 4;

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
            Column::text("over seeds"),
            Column::numbers("R²", ""),
            Column::numbers("mean error", "%"),
            Column::text("95 %"),
            Column::numbers("phase", "°"),
            Column { published: true, ..Column::text("published") },
        ];
        let transfer_scores = transfer.iter().flat_map(|t| &t.scores);
        let rows = thrusts.iter().flat_map(|(specimen, thrust)| {
            let name = specimen.name();
            let of_tail = transfer_scores.clone().filter(|held| held.tail == name).map(|held| &held.scored);
            let scores: Vec<&Scored> = thrust.scores.iter().chain(of_tail).collect();
            let shown = scores.iter().filter(|scored| scored.seed == 0 && is_shown(scored));
            shown.map(|scored| score_row(&name, scored, nrmse_over_seeds(scored, &scores))).collect::<Vec<_>>()
        });
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted(
            "NRMSE: over the standard deviation of the measured force; intervals by bootstrap over cycles; over seeds: least and greatest NRMSE of three trainings, of which the first is shown. Card: the held-out trials; tail: trained on the runs of all other tails.",
        ))
    }
}

/// The split of the card.
const CARD: &str = "card";
/// Models and their names in the table.
const MODEL_NAMES: [(&str, &str); 2] = [("ebt", "elongated-body theory"), ("theory", "tuned theory")];
/// Models that are shown on other splits as well: the simplest, and the two that the text compares. All of all splits were a hundred rows.
const ON_OTHER_SPLITS: [&str; 3] = ["mean", "theory", "network"];

fn is_shown(scored: &Scored) -> bool {
    scored.split_rule == CARD || ON_OTHER_SPLITS.contains(&scored.model.as_str())
}

/// The least and the greatest NRMSE of the trainings of a model on the same split; nothing of a model that was trained once.
fn nrmse_over_seeds(scored: &Scored, scores: &[&Scored]) -> String {
    let same = scores.iter().filter(|other| other.model == scored.model && other.split_rule == scored.split_rule);
    let errors: Vec<f64> = same.map(|other| other.score.nrmse).collect();
    if errors.len() < 2 {
        return String::new();
    }
    let [low, high] = [f64::min, f64::max].map(|extreme| errors.iter().copied().fold(errors[0], extreme));
    format!("{low:.3} to {high:.3}")
}

fn score_row(specimen: &str, scored: &Scored, over_seeds: String) -> Vec<String> {
    let s = &scored.score;
    let name = MODEL_NAMES.iter().find(|(model, _)| *model == scored.model).map_or(&*scored.model, |(_, name)| name);
    let interval_text = |[low, high]: [f64; 2], digits: usize| format!("{low:.digits$} to {high:.digits$}");
    vec![
        specimen.to_owned(),
        scored.split_rule.clone(),
        name.to_owned(),
        format!("{:.3}", s.nrmse),
        interval_text(s.nrmse_interval, 3),
        over_seeds,
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
        ("nemo", CARD, "network") => "follows the force",
        ("bruce", CARD, "network") => "nearly twice the force",
        (_, CARD, "ebt") => "over-predicts",
        _ => "",
    }
}
