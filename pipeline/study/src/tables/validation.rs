//! Table `validation`: error of the prediction of each validation motion, by every scheme and by the baselines without a simulation.

use plot::Column;

use crate::figures::order::in_order;
use diagnostics::Result;
use records::subject::{Study, Trial};
use workflow::needs::Every;
use workflow::table::Table;

/// The table.
pub struct Validation;

/// Schemes and baselines beside the first: names in records and in the table.
const OTHERS: [(&str, &str); 5] = [
    ("elastic", "elastic"),
    (records::PAPER_MODEL, "paper's model"),
    ("last_cycle", "last cycle"),
    ("quasi_static", "quasi-static"),
    ("rest", "at rest"),
];

impl Table for Validation {
    type Of = Study;
    type Needs = Every<records::Validation, Trial>;
    const NAME: &'static str = "validation";
    const CAPTION: &'static str = "error of the prediction and of the baselines on validation trials";
    const VERSION: u32 = 3;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::Validation>::any(study)
    }

    fn fill(Every(validations): Self::Needs) -> Result<plot::Table> {
        let head = [
            Column::text("specimen"),
            Column::text("medium"),
            Column::text("condition"),
            Column::numbers("repeats", ""),
        ];
        let ours = [
            Column::numbers("RMSE", "mm"),
            Column::numbers("of length", "%"),
            Column::numbers("largest", "%"),
            Column::numbers("lag", "ms"),
        ];
        let other_columns = OTHERS.map(|(_, title)| Column::numbers(title, "%"));
        let columns = head.into_iter().chain(ours).chain(other_columns).collect();
        let rows = in_order(validations).iter().map(|(trial, validation)| trial_row(trial, validation)).collect();
        let table = plot::Table::new(columns, rows)?;
        Ok(table.noted("Of the tip marker, against the mean of the repeats. RMSE and largest distance: viscoelastic, second order; elastic: without relaxation; paper's model: elastic, no damping, no water, implicit Euler. In water the others have the identified added mass and drag."))
    }
}

fn trial_row(trial: &Trial, validation: &records::Validation) -> Vec<String> {
    let percent = |rmse: f64| format!("{:.2}", 100.0 * rmse / validation.length);
    let models = || validation.scored.iter().chain(&validation.baselines);
    let error_of_model =
        |name: &str| models().find(|model| model.name == name).map_or(String::new(), |model| percent(model.rmse));
    let condition = trial.condition();
    let condition = condition.trim_end_matches("_water").replace("mbar_", " mbar ").replace("hz", " Hz");
    let mut cells = vec![
        trial.card.name.clone(),
        trial.trial.medium.word().to_owned(),
        condition,
        validation.repeats.to_string(),
        format!("{:.2}", 1e3 * validation.rmse),
        percent(validation.rmse),
        format!("{:.2}", validation.max_percent()),
        validation.lag.map_or(String::new(), |lag| format!("{:+.1}", 1e3 * lag)),
    ];
    cells.extend(OTHERS.map(|(name, _)| error_of_model(name)));
    cells
}
