//! Table `ingredients`: what each ingredient of the model is worth on flapping that was never seen, from the paper's own model on.

use plot::Column;

use diagnostics::Result;
use records::subject::{Study, Trial};
use records::{PAPER_MODEL, Validation};
use workflow::needs::Every;
use workflow::table::Table;

/// The table.
pub struct Ingredients;

/// Names in the record and in the table, the paper's own model first.
const MODELS: [(&str, &str); 4] = [
    (PAPER_MODEL, "the paper's: elastic, no damping, no water, implicit Euler"),
    ("implicit_euler", "with added mass and drag, in water"),
    ("elastic", "with a scheme of second order"),
    ("viscoelastic", "with relaxation"),
];

impl Table for Ingredients {
    type Of = Study;
    type Needs = Every<Validation, Trial>;
    const NAME: &'static str = "ingredients";
    const CAPTION: &'static str = "what each ingredient of the model is worth on flapping that was never seen";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<Validation>::any(study)
    }

    fn fill(Every(validations): Self::Needs) -> Result<plot::Table> {
        let medium = |wet: bool| {
            let word = if wet { "in water" } else { "in air" };
            [Column::numbers(&format!("{word}, mean"), "%"), Column::numbers(&format!("{word}, worst"), "%")]
        };
        let columns = std::iter::once(Column::text("model")).chain(medium(false)).chain(medium(true)).collect();
        let rows = MODELS.map(|(name, title)| {
            let [air, water] = [false, true].map(|wet| model_errors(&validations, name, wet));
            std::iter::once(title.to_owned()).chain(mean_and_worst(&air)).chain(mean_and_worst(&water)).collect()
        });
        let table = plot::Table::new(columns, rows.to_vec())?;
        Ok(table.noted("Root mean square error of the tip marker over the length, over all validation trials."))
    }
}

/// Errors of a model over the trials in a medium, % of the length.
fn model_errors(validations: &[(Trial, Validation)], name: &str, wet: bool) -> Vec<f64> {
    let relative_error = |validation: &Validation| {
        let model = validation.scored.iter().find(|model| model.name == name)?;
        Some(100.0 * model.rmse / validation.length)
    };
    validations
        .iter()
        .filter(|(trial, _)| trial.is_in_water() == wet)
        .filter_map(|(_, validation)| relative_error(validation))
        .collect()
}

fn mean_and_worst(errors: &[f64]) -> [String; 2] {
    if errors.is_empty() {
        return [String::new(), String::new()];
    }
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    [mean, errors.iter().copied().fold(0.0, f64::max)].map(|error| format!("{error:.2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_trial_the_cells_are_empty() {
        assert_eq!(mean_and_worst(&[]), ["", ""]);
        assert_eq!(mean_and_worst(&[0.1, 0.3]), ["0.20", "0.30"]);
    }
}
