//! A free vibration test in a joint fit: frequency, static deflection, first extremum and decay under each weight.

use std::path::Path;

use rayon::prelude::*;
use si::Series;

use super::parameters::Parameter;
use super::test::{Condition, Memory, Place, Predicted, Quantity, Test};
use crate::free_vibration::condition::{self, Basis, times};
use crate::free_vibration::features::{Features, NAMES};
use crate::free_vibration::fitting::interpolate_series;
use crate::free_vibration::page::Page;
use crate::free_vibration::recorded::{self, Recorded};
use diagnostics::{Diagnostic, Result};

/// By so much of itself a good model misses frequency, static deflection, first extremum and decay.
// The two repeats of each weight differ by 0.0 and 0.7 % in frequency, 1.1 and 0.7 in static deflection, 4.1 and 6.3 in the first extremum,
// and 3.4 and 11 in decay.
const SIGMAS: [f64; 4] = [0.01, 0.015, 0.05, 0.1];
/// The time in which a hand lets go, s, and how much it differs.
const RAMP: f64 = 0.06;
const RAMP_SIGMA: f64 = 0.03;
const RAMPS: [f64; 2] = [1e-3, 0.25];
/// Forward differences in the unit of the search: features of a motion are read to five digits.
const STEP: f64 = 2e-3;

/// The recordings of a page, with the reduced models of each weight.
pub(super) struct Bars {
    page: Page,
    recorded: Vec<Recorded>,
    conditions: Vec<Condition>,
    /// Recordings of each condition.
    members: Vec<Vec<usize>>,
    /// By condition, and by law.
    models: Vec<Vec<(&'static str, condition::Condition)>>,
}

impl Bars {
    /// Of the page in the file `path`, for these laws of `materials`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the page, a recording or a case is refused, or a shape is not found.
    pub fn new(path: &Path, root: &Path, materials: &[&'static str]) -> Result<Self> {
        let page = Page::read(path)?;
        let recorded = recorded::read(&page, root)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let (cases, members) = recordings_by_case(&page);
        let models = |case: &String| -> Result<Vec<(&'static str, condition::Condition)>> {
            let file = folder.join(case);
            let trained = condition::Condition::new(&page, &file, None)?;
            let material_model = |material: &&'static str| {
                Ok((*material, condition::Condition::of_material(&page, &file, material, Basis::Of(&trained))?))
            };
            materials.iter().map(material_model).collect()
        };
        let models = cases.par_iter().map(models).collect::<Result<_>>()?;
        let conditions =
            members.iter().map(|members| measured_condition(&page, &recorded, members)).collect::<Result<_>>()?;
        Ok(Self { page, recorded, conditions, members, models })
    }

    /// Features of recording `k` under `condition`, in the units of their names.
    fn beam_features(&self, at: &Place, (condition, k): (usize, usize)) -> Result<[f64; 4]> {
        let model = self.models[condition].iter().find(|(name, _)| *name == at.law.material).map(|(_, model)| model);
        let model =
            model.ok_or_else(|| Diagnostic::new("a law has no reduced model", at.law.name, "report this as a bug"))?;
        let properties = at.law.constants(at.shared)?.properties();
        let recorded = &self.recorded[k].fall;
        let times = times(&self.page, recorded.end() + self.page.step);
        let fall = model.fall(&properties, at.own[k], &times)?;
        let values =
            (0..recorded.values().len()).map(|i| interpolate_series(&times, &fall, recorded.time(i))).collect();
        Ok(Features::of(&self.page, &Series::new(0.0, recorded.rate(), values)?)?.to_array())
    }
}

/// The different cases of a page, with the numbers of their recordings.
fn recordings_by_case(page: &Page) -> (Vec<String>, Vec<Vec<usize>>) {
    let (mut cases, mut members): (Vec<String>, Vec<Vec<usize>>) = (Vec::new(), Vec::new());
    for (k, recording) in page.recording.iter().enumerate() {
        let case = recording.case.as_ref().unwrap_or(&page.case);
        match cases.iter().position(|known| known == case) {
            Some(condition) => members[condition].push(k),
            None => {
                cases.push(case.clone());
                members.push(vec![k]);
            }
        }
    }
    (cases, members)
}

fn measured_condition(page: &Page, recorded: &[Recorded], members: &[usize]) -> Result<Condition> {
    let mut quantities = Vec::new();
    for &k in members {
        let features = Features::of(page, &recorded[k].fall)?.to_array();
        for (n, (name, unit)) in NAMES.into_iter().enumerate() {
            let name = format!("{name} of {}", page.recording[k].name());
            quantities.push(Quantity { name, unit, measured: Some(features[n]), sigma: SIGMAS[n] });
        }
    }
    let first_member = members.first().copied().unwrap_or_default();
    let name = page.recording[first_member].name().trim_end_matches(['_', 'a', 'b', 'c']).to_owned();
    let level = quantities[1].measured.unwrap_or_default().abs();
    // repeats that a page holds out of its own fits are data of the same condition; one of which nothing is fitted is predicted
    let fitted = members.iter().any(|k| page.recording[*k].fitted);
    Ok(Condition { name, level, fitted, quantities })
}

impl Test for Bars {
    fn name(&self) -> &str {
        &self.page.name
    }

    fn parameters(&self) -> Vec<Parameter> {
        let ramp = |recording: &crate::free_vibration::page::Recording| {
            Parameter::linear(&format!("ramp of {}", recording.name()), "s", RAMP, RAMPS).known_to(RAMP_SIGMA)
        };
        self.page.recording.iter().map(ramp).collect()
    }

    fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// Repeats share the relative derivatives by the material of the first of them: they differ in the release alone.
    fn predict_condition(&self, at: &Place, condition: usize, _: &mut Memory) -> Result<Vec<Predicted>> {
        let (count, members) = (at.shared.len(), &self.members[condition]);
        let material_jobs = (0..count).map(|p| (members[0], Some(p)));
        let release_jobs = members.iter().flat_map(|&k| [(k, None), (k, Some(count + k))]);
        let jobs: Vec<(usize, Option<usize>)> = release_jobs.chain(material_jobs).collect();
        let simulate = |&(k, moved): &(usize, Option<usize>)| {
            let (mut shared, mut own) = (at.shared.to_vec(), at.own.to_vec());
            match moved {
                Some(p) if p < count => shared[p] += STEP,
                Some(p) => own[p - count] += STEP,
                None => {}
            }
            self.beam_features(&Place { law: at.law, shared: &shared, own: &own }, (condition, k))
        };
        let features: Vec<[f64; 4]> = jobs.par_iter().map(simulate).collect::<Result<_>>()?;
        let material = &features[2 * members.len()..];
        let mut predicted = Vec::new();
        for (m, &k) in members.iter().enumerate() {
            for n in 0..4 {
                let value = features[2 * m][n];
                let mut gradient = vec![0.0; count + at.own.len()];
                for (p, moved) in material.iter().enumerate() {
                    gradient[p] = value * (moved[n] / features[0][n] - 1.0) / STEP;
                }
                gradient[count + k] = (features[2 * m + 1][n] - value) / STEP;
                predicted.push(Predicted { value, gradient });
            }
        }
        Ok(predicted)
    }
}
