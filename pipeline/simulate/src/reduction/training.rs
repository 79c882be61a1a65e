//! Training of a reduced model over a box of constants and pressures.
//!
//! The whole body is solved along the pressures of each chamber at the middle of the box. Then points are drawn evenly from the box (Halton's
//! sequence [halton1960]); each is solved by the reduced model and, from there, by the whole body. Where they differ by more than the tolerance
//! the equilibrium is taught with its derivatives; the model is done when several points in a row agree.

use std::sync::Arc;

use fem::{
    Equilibrium, Parameter, ReducedModel, ReducedSolver, ReductionSettings, RegionProperties, Snapshot, Solver,
    StaticSettings, System,
};
use nalgebra::DVector;
use si::Pascal;

use super::ranges::NamedRange;
use diagnostics::{Diagnostic, Result};

/// Points in a row that must agree.
const CHECKS: usize = 8;
/// Equilibria on the way to the highest pressure of a chamber.
const STEPS: usize = 4;
/// The cubature's error is so much less than that of the model.
const CUBATURE: f64 = 0.1;
/// Bases of Halton's sequence: a reduced model is trained over at most so many constants and chambers.
const BASES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// The box of constants and pressures over which a model is trained, and how well it must serve in it.
#[derive(Debug, Clone)]
pub struct TrainingBox {
    /// E (Pa) or ν of a region each; others are those of the body.
    pub constants: Vec<(Parameter, NamedRange)>,
    /// One per chamber of the mesh, Pa.
    pub pressures: Vec<NamedRange>,
    /// Largest difference of a node from the whole body, over the largest displacement in the box.
    pub tolerance: f64,
    /// Equilibria of the whole body at most.
    pub most: usize,
}

/// A trained model.
#[derive(Debug)]
pub struct Trained {
    /// The model.
    pub model: Arc<ReducedModel>,
    /// Equilibria that taught it.
    pub taught: usize,
    /// Points that were checked and not taught, and their largest difference.
    pub checked: (usize, f64),
}

/// Trains a reduced model of a body in the box; `progress` is called at each point.
///
/// # Errors
/// A [`Diagnostic`] when there are too many ranges, none of a pressure, the whole body has no equilibrium in the box, or the model does not serve
/// after so many equilibria.
pub fn train_reduced(
    system: &System,
    space: &TrainingBox,
    settings: StaticSettings,
    progress: &dyn Fn(&str),
) -> Result<Trained> {
    if space.pressures.iter().all(|range| range.low == range.high) {
        let reason = "its shapes are those that the body takes under them";
        return Err(Diagnostic::new("no pressure varies", reason, "give a range of a chamber's pressure, in Pa"));
    }
    let varied = space.pressures.iter().filter(|range| range.low < range.high).count();
    if space.constants.len() + varied > BASES.len() {
        let reason = format!("points are drawn from at most {} of them", BASES.len());
        return Err(Diagnostic::new("too many ranges are given", reason, "leave out those that matter least"));
    }
    Training { system, space, settings, equilibria: Vec::new() }.run_training(progress)
}

/// A point of the box.
#[derive(Debug, Clone)]
struct BoxPoint {
    regions: Vec<RegionProperties>,
    pressures: Vec<Pascal>,
}

/// An equilibrium that teaches.
struct TrainingEquilibrium {
    point: BoxPoint,
    displacement: Vec<f64>,
    changes: Vec<Vec<f64>>,
}

/// The whole body with what it has taught.
struct Training<'a> {
    system: &'a System,
    space: &'a TrainingBox,
    settings: StaticSettings,
    equilibria: Vec<TrainingEquilibrium>,
}

impl<'a> Training<'a> {
    /// # Errors
    /// A [`Diagnostic`] when the whole body has no equilibrium in the box, the model cannot be made, or it does not serve after so many equilibria.
    fn run_training(mut self, progress: &dyn Fn(&str)) -> Result<Trained> {
        self.follow_pressures()?;
        let (mut model, mut checked, mut number) = (self.reduced_model()?, (0, 0.0_f64), 0);
        while checked.0 < CHECKS {
            number += 1;
            let point = self.drawn_point(number);
            let (whole, difference) = self.check_point(&model, &point)?;
            progress(&format!(
                "{} equilibria taught, point {number} differs by {:.2} %",
                self.equilibria.len(),
                100.0 * difference
            ));
            if difference <= self.space.tolerance {
                checked = (checked.0 + 1, checked.1.max(difference));
                continue;
            }
            if self.equilibria.len() >= self.space.most {
                return Err(self.not_trained(difference));
            }
            self.teach_equilibrium(point, whole)?;
            (model, checked) = (self.reduced_model()?, (0, 0.0));
        }
        Ok(Trained { model, taught: self.equilibria.len(), checked })
    }

    /// Teaches the pressures of each chamber alone at the middle of the constants, then all of them together.
    fn follow_pressures(&mut self) -> Result<()> {
        let middle = vec![0.5; self.space.constants.len()];
        let neutral_pressures: Vec<Pascal> =
            self.space.pressures.iter().map(|range| 0.0_f64.clamp(range.low, range.high)).collect();
        let varied_chambers: Vec<usize> = (0..neutral_pressures.len())
            .filter(|&k| self.space.pressures[k].low < self.space.pressures[k].high)
            .collect();
        for &chamber in &varied_chambers {
            let mut last: Option<Vec<f64>> = None;
            for step in 1..=STEPS {
                let mut pressures = neutral_pressures.clone();
                pressures[chamber] +=
                    (self.farthest_pressure(chamber) - neutral_pressures[chamber]) * step as f64 / STEPS as f64;
                let point = BoxPoint { regions: self.regions_at(&middle), pressures };
                let equilibrium = self.whole_equilibrium(&point, last.as_deref())?;
                last = Some(equilibrium.displacement.clone());
                self.teach_equilibrium(point, equilibrium)?;
            }
        }
        if varied_chambers.len() > 1 {
            let pressures = (0..neutral_pressures.len()).map(|chamber| self.farthest_pressure(chamber)).collect();
            let point = BoxPoint { regions: self.regions_at(&middle), pressures };
            let equilibrium = self.whole_equilibrium(&point, None)?;
            self.teach_equilibrium(point, equilibrium)?;
        }
        Ok(())
    }

    /// The end of a chamber's range that is farther from ambient pressure, Pa.
    fn farthest_pressure(&self, chamber: usize) -> Pascal {
        let NamedRange { low, high, .. } = self.space.pressures[chamber];
        if low.abs() > high.abs() { low } else { high }
    }

    /// The regions with each constant at a part (0 to 1) of its range.
    fn regions_at(&self, parts: &[f64]) -> Vec<RegionProperties> {
        let mut regions = self.system.regions().to_vec();
        for ((parameter, range), part) in self.space.constants.iter().zip(parts) {
            match *parameter {
                Parameter::YoungsModulus(region) => regions[region].youngs_modulus = range.value_at(*part),
                Parameter::PoissonsRatio(region) => regions[region].poissons_ratio = range.value_at(*part),
                _ => {}
            }
        }
        regions
    }

    /// The point `number` (from 1) of an even sequence over the box.
    fn drawn_point(&self, number: usize) -> BoxPoint {
        let parts: Vec<f64> = BASES.iter().map(|base| radical_inverse(number, *base)).collect();
        let (constants, pressures) = parts.split_at(self.space.constants.len());
        let pressures = self.space.pressures.iter().zip(pressures).map(|(range, part)| range.value_at(*part));
        BoxPoint { regions: self.regions_at(constants), pressures: pressures.collect() }
    }

    fn solver_at(&self, point: &BoxPoint) -> Result<Solver> {
        let mut solver = self.system.solver();
        for (index, region) in point.regions.iter().enumerate() {
            solver.set_elastic(index, region.youngs_modulus, region.poissons_ratio)?;
        }
        Ok(solver)
    }

    fn whole_equilibrium(&self, point: &BoxPoint, guess: Option<&[f64]>) -> Result<Equilibrium> {
        Ok(self.solver_at(point)?.equilibrium(&point.pressures, guess, &self.settings)?)
    }

    fn teach_equilibrium(&mut self, point: BoxPoint, equilibrium: Equilibrium) -> Result<()> {
        let mut solver = self.solver_at(&point)?;
        let change = |(parameter, range): &(Parameter, NamedRange)| -> Result<Vec<f64>> {
            let half = 0.5 * (range.high - range.low);
            Ok(solver.sensitivity(&equilibrium, *parameter)?.into_iter().map(|slope| half * slope).collect())
        };
        let changes = self.space.constants.iter().map(change).collect::<Result<_>>()?;
        self.equilibria.push(TrainingEquilibrium { point, displacement: equilibrium.displacement, changes });
        Ok(())
    }

    fn reduced_model(&self) -> Result<Arc<ReducedModel>> {
        let snapshots: Vec<Snapshot> = self
            .equilibria
            .iter()
            .map(|known| Snapshot {
                displacement: &known.displacement,
                regions: &known.point.regions,
                changes: &known.changes,
            })
            .collect();
        let tolerance = CUBATURE * self.space.tolerance;
        let settings = ReductionSettings { coordinates: 60, tolerance, ..ReductionSettings::default() };
        Ok(Arc::new(self.system.reduce_trained(&snapshots, &settings)?))
    }

    /// The whole body at a point, and the largest difference of the reduced one.
    fn check_point(&self, model: &Arc<ReducedModel>, point: &BoxPoint) -> Result<(Equilibrium, f64)> {
        let predicted = self.predicted_displacement(model, point);
        let equilibrium = self.whole_equilibrium(point, predicted.as_deref())?;
        let largest = self
            .equilibria
            .iter()
            .flat_map(|known| &known.displacement)
            .fold(0.0, |greatest: f64, u| greatest.max(u.abs()));
        let largest_difference = |predicted: &Vec<f64>| {
            predicted
                .iter()
                .zip(&equilibrium.displacement)
                .fold(0.0, |greatest: f64, (a, b)| greatest.max((a - b).abs()))
        };
        let difference = predicted.as_ref().map_or(f64::INFINITY, |predicted| largest_difference(predicted) / largest);
        Ok((equilibrium, difference))
    }

    /// By the reduced model from the nearest equilibrium that taught it; none where it finds no equilibrium.
    fn predicted_displacement(&self, model: &Arc<ReducedModel>, point: &BoxPoint) -> Option<Vec<f64>> {
        let distance = |known: &TrainingEquilibrium| {
            let each = known.point.pressures.iter().zip(&point.pressures).zip(&self.space.pressures);
            each.map(|((a, b), range)| ((a - b) / (range.high - range.low).max(f64::MIN_POSITIVE)).powi(2)).sum::<f64>()
        };
        let nearest = self.equilibria.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let start: DVector<f64> = model.projected(&nearest.displacement);
        let solver = ReducedSolver::new(Arc::clone(model), point.regions.clone());
        let equilibrium = solver.equilibrium_near(&point.pressures, &start, &start).ok()?;
        Some(model.displacement(&equilibrium.coordinates))
    }

    fn not_trained(&self, difference: f64) -> Diagnostic {
        Diagnostic::new(
            format!(
                "after {} equilibria the reduced model still differs by {:.2} %",
                self.equilibria.len(),
                100.0 * difference
            ),
            format!("{:.2} % were asked for", 100.0 * self.space.tolerance),
            "narrow the ranges, raise --tolerance, or allow more with --equilibria",
        )
    }
}

/// Digits of `number` in `base` behind the point, in reverse order.
fn radical_inverse(mut number: usize, base: usize) -> f64 {
    let (mut sum, mut digit) = (0.0, 1.0 / base as f64);
    while number > 0 {
        sum += digit * (number % base) as f64;
        (number, digit) = (number / base, digit / base as f64);
    }
    sum
}
