//! A tensile test in a joint fit: the stress of a strip at several strains.

use std::path::Path;

use fem::material::Material;

use super::laws::LAWS;
use super::parameters::Parameter;
use super::tension::{Page, Pull, Strain, strip_stress};
use super::test::{Condition, Memory, Place, Predicted, Quantity, Test};
use diagnostics::{Diagnostic, Result};

/// Strains that are fitted, evenly from the least to the largest.
const POINTS: usize = 10;
/// By so much of itself a good model misses a stress; neighbouring strains are missed alike, so that three of ten count.
const SIGMA: f64 = 0.03;
const INDEPENDENT: f64 = 3.0;
/// Strain of the machine per MPa in the strip, at first and at most; and the modulus of the batch over that of the other tests at most.
const COMPLIANCE: [f64; 2] = [1.0, 20.0];
const BATCH: [f64; 2] = [0.2, 5.0];
const STEP: f64 = 1e-5;

/// A recorded pull with its page.
pub(super) struct Strip {
    page: Page,
    conditions: Vec<Condition>,
    /// Strain, time and stress of each quantity, by condition.
    points: Vec<Vec<[f64; 3]>>,
}

impl Strip {
    /// # Errors
    /// A [`Diagnostic`] when page or recording are refused, or a strain lies outside of the recording.
    pub fn new(path: &Path, root: &Path) -> Result<Self> {
        let page = Page::read(path)?;
        let pull = page.recording(root)?;
        let [least, largest] = page.fitted;
        let strain_at = |k: usize| least + k as f64 / (POINTS - 1) as f64 * (largest - least);
        let fitted: Vec<f64> = (0..POINTS).map(strain_at).collect();
        let groups = std::iter::once((true, fitted)).chain(page.predicted.iter().map(|strain| (false, vec![*strain])));
        let (mut conditions, mut points) = (Vec::new(), Vec::new());
        for (is_fitted, strains) in groups {
            let rows = strains.iter().map(|strain| point(&pull, *strain)).collect::<Result<Vec<_>>>()?;
            let level = strains.iter().copied().fold(0.0, f64::max);
            let weight = if is_fitted { (POINTS as f64 / INDEPENDENT).sqrt() } else { 1.0 };
            let quantities = rows.iter().map(|row| stress_quantity(row, weight)).collect();
            let name = if is_fitted { page.name.clone() } else { format!("{} at {:.0} %", page.name, 100.0 * level) };
            conditions.push(Condition { name, level, fitted: is_fitted, quantities });
            points.push(rows);
        }
        Ok(Self { page, conditions, points })
    }

    fn stress(&self, at: &Place, [strain, time, recorded]: [f64; 3]) -> Result<f64> {
        let constants = at.law.constants(at.shared)?;
        // By the recorded stress: with the predicted one the stretch would stand on both sides of its equation.
        let yielded = if self.page.measured_by == Strain::Crosshead { 1e-6 * at.own[1] * recorded } else { 0.0 };
        // A compliance on the way of a search may take more than the whole strain, and λ^−½ needs a positive stretch.
        let stretch = (1.0 + strain - yielded).max(0.05);
        Ok(at.own[0].exp() * strip_stress(material(at.law.material)?, &constants, (stretch, time)))
    }
}

/// The law `name` of `materials`.
pub(super) fn material(name: &str) -> Result<&'static dyn Material> {
    fem::materials::by_name(name).ok_or_else(|| {
        let law_names: Vec<&str> = LAWS.iter().map(|law| law.name).collect();
        Diagnostic::new(
            format!("there is no law `{name}`"),
            format!("laws: {}", law_names.join(", ")),
            "correct `laws`",
        )
    })
}

fn point(pull: &Pull, strain: f64) -> Result<[f64; 3]> {
    let (time, stress) = pull.at(strain).ok_or_else(|| {
        let message = format!("the strip was not recorded at a strain of {strain}");
        Diagnostic::new(message, "it lies outside of the rows before its break", "correct `fitted` and `predicted`")
    })?;
    Ok([strain, time, stress])
}

fn stress_quantity([strain, _, stress]: &[f64; 3], weight: f64) -> Quantity {
    let name = format!("stress at {:.0} %", 100.0 * strain);
    Quantity { name, unit: "kPa", measured: Some(1e-3 * stress), sigma: SIGMA * weight }
}

impl Test for Strip {
    fn name(&self) -> &str {
        &self.page.name
    }

    fn parameters(&self) -> Vec<Parameter> {
        let batch = Parameter::logarithmic("batch", "", 1.0, BATCH).known_to(self.page.batch_sigma);
        let compliance = Parameter::linear("compliance", "1/MPa", COMPLIANCE[0], [0.0, COMPLIANCE[1]]);
        match self.page.measured_by {
            Strain::Crosshead => vec![batch, compliance],
            Strain::Extensometer => vec![batch],
        }
    }

    fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    fn predict_condition(&self, at: &Place, condition: usize, _: &mut Memory) -> Result<Vec<Predicted>> {
        let predicted = |row: &[f64; 3]| -> Result<Predicted> {
            let value = self.stress(at, *row)?;
            let mut gradient = Vec::new();
            for p in 0..at.shared.len() + at.own.len() {
                let (mut shared, mut own) = (at.shared.to_vec(), at.own.to_vec());
                let parameter = if p < shared.len() { &mut shared[p] } else { &mut own[p - at.shared.len()] };
                *parameter += STEP;
                let perturbed = Place { law: at.law, shared: &shared, own: &own };
                gradient.push(1e-3 * (self.stress(&perturbed, *row)? - value) / STEP);
            }
            Ok(Predicted { value: 1e-3 * value, gradient })
        };
        self.points[condition].iter().map(predicted).collect()
    }
}
