//! A test under one stress in a joint fit: the stress of a strip or a cylinder at several strains, or at several times.

use std::path::Path;

use fem::material::Material;

use super::laws::LAWS;
use super::parameters::Parameter;
use super::test::{Condition, Memory, Place, Predicted, Quantity, Test};
use super::uniaxial::{Kind, Loaded, Page, Recording, Strain, uniaxial_stress};
use diagnostics::{Diagnostic, Result};

/// Strains that are fitted, evenly from the least to the largest; of a relaxation times, evenly in their logarithm.
const POINTS: usize = 10;
/// By so much of itself a good model misses a stress; neighbouring states are missed alike, so that three of ten count.
const SIGMA: f64 = 0.03;
const INDEPENDENT: f64 = 3.0;
/// Strain of the machine per MPa in the strip, at first and at most; and the modulus of the batch over that of the other tests at most.
const COMPLIANCE: [f64; 2] = [1.0, 20.0];
const BATCH: [f64; 2] = [0.2, 5.0];
const STEP: f64 = 1e-5;

/// A recorded test with its page.
pub(super) struct StressedSpecimen {
    page: Page,
    conditions: Vec<Condition>,
    /// The state of each quantity, by condition.
    states: Vec<Vec<Loaded>>,
}

impl StressedSpecimen {
    /// # Errors
    /// A [`Diagnostic`] when page or recording are refused, or a strain lies outside of the recording.
    pub fn new(path: &Path, root: &Path) -> Result<Self> {
        let page = Page::read(path)?;
        let recording = page.recording(root)?;
        let fitted = fitted_places(&page);
        let groups = std::iter::once((true, fitted)).chain(page.predicted.iter().map(|place| (false, vec![*place])));
        let (mut conditions, mut states) = (Vec::new(), Vec::new());
        for (is_fitted, places) in groups {
            let loaded =
                places.iter().map(|place| recorded_state(&recording, &page, *place)).collect::<Result<Vec<_>>>()?;
            let level = places.iter().copied().fold(0.0, f64::max);
            let weight = if is_fitted { (POINTS as f64 / INDEPENDENT).sqrt() } else { 1.0 };
            let quantities = loaded.iter().map(|state| stress_quantity(page.test, state, weight)).collect();
            let suffix = place_text(page.test, level);
            let name = if is_fitted { page.name.clone() } else { format!("{} at {suffix}", page.name) };
            conditions.push(Condition { name, level, fitted: is_fitted, quantities });
            states.push(loaded);
        }
        Ok(Self { page, conditions, states })
    }

    /// With the sign of the recorded one, Pa.
    fn stress(&self, at: &Place, state: &Loaded) -> Result<f64> {
        let constants = at.law.constants(at.shared)?;
        // By the recorded stress: with the predicted one the stretch would stand on both sides of its equation.
        let yielded = if self.page.measured_by == Strain::Crosshead { 1e-6 * at.own[1] * state.stress } else { 0.0 };
        // A compliance on the way of a search may take more than the whole strain, and λ^−½ needs a positive stretch.
        let sign = self.page.test.sign();
        let stretch = (1.0 + sign * (state.strain - yielded)).max(0.05);
        let stress = uniaxial_stress(material(at.law.material)?, &constants, (stretch, [state.ramp, state.held]));
        Ok(sign * at.own[0].exp() * stress)
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

/// The strains, or times (s), that are fitted.
fn fitted_places(page: &Page) -> Vec<f64> {
    let [least, largest] = page.fitted;
    let place_at = |k: usize| {
        let part = k as f64 / (POINTS - 1) as f64;
        if page.test == Kind::Relaxation {
            least * (largest / least).powf(part)
        } else {
            least + part * (largest - least)
        }
    };
    (0..POINTS).map(place_at).collect()
}

fn recorded_state(recording: &Recording, page: &Page, place: f64) -> Result<Loaded> {
    recording.at(place).ok_or_else(|| {
        let message = format!("the specimen was not recorded at {}", place_text(page.test, place));
        let reason = match page.test {
            Kind::Relaxation => "it was not held so long",
            Kind::Tension | Kind::Compression => "it lies outside of the rows before its break",
        };
        Diagnostic::new(message, reason, "correct `fitted` and `predicted`")
    })
}

fn place_text(kind: Kind, place: f64) -> String {
    if kind == Kind::Relaxation { format!("{place:.3} s") } else { format!("{:.0} %", 100.0 * place) }
}

fn stress_quantity(kind: Kind, state: &Loaded, weight: f64) -> Quantity {
    let coordinate = if kind == Kind::Relaxation { state.held } else { state.strain };
    let name = format!("stress at {}", place_text(kind, coordinate));
    Quantity { name, unit: "kPa", measured: Some(1e-3 * state.stress), sigma: SIGMA * weight }
}

impl Test for StressedSpecimen {
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
        let predicted = |state: &Loaded| -> Result<Predicted> {
            let value = self.stress(at, state)?;
            let mut gradient = Vec::new();
            for p in 0..at.shared.len() + at.own.len() {
                let (mut shared, mut own) = (at.shared.to_vec(), at.own.to_vec());
                let parameter = if p < shared.len() { &mut shared[p] } else { &mut own[p - at.shared.len()] };
                *parameter += STEP;
                let perturbed = Place { law: at.law, shared: &shared, own: &own };
                gradient.push(1e-3 * (self.stress(&perturbed, state)? - value) / STEP);
            }
            Ok(Predicted { value: 1e-3 * value, gradient })
        };
        self.states[condition].iter().map(predicted).collect()
    }
}
