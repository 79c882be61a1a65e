//! What the page's materials make of each recording: as another body identified them, and fitted to inflations.
//!
//! Logarithms of displacement ratios are fitted by Gauss and Newton's method with Broyden's updates of the Jacobian [broyden1965]: a
//! motion under a history costs ten seconds, and the displacement is close to a power of the modulus.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::body::Meshed;
use super::hold::Course;
use super::inflated::Shape;
use super::page::Page;
use super::recorded::{Features, Recorded};
use crate::IdentifiedMaterial;
use diagnostics::Result;
use si::Pascal;

/// A point of the search: logarithm of the modulus ratio, C₂₀/C₁₀, and what is missing of a step's pressure at first, kPa.
pub(super) type Point = [f64; 3];
/// Differences of the Jacobian, and largest steps.
const DIFFERENCE: Point = [0.05, 0.1, 0.3];
const LONGEST: Point = [0.3, 0.5, 1.5];
/// C₂₀/C₁₀ at which a fit begins.
const STIFFENING: f64 = 0.5;
/// Bounds of all but the modulus: below those of C₂₀/C₁₀ every wall of this arm balloons.
const RANGES: [[f64; 2]; 3] = [[f64::NEG_INFINITY, f64::INFINITY], [-0.2, 4.0], [0.0, 8.0]];
/// Steps at most, and the step that ends a fit.
const MAX_STEPS: usize = 4;
const ENOUGH: f64 = 3e-3;
/// Logarithm of the displacement ratio of a wall that balloons without bound.
// Finite, since an infinite residual would spoil the step of all recordings; larger than any other, so that they stay
// continuous where a wall begins to balloon.
const BURST: f64 = 1.5;

/// A material with what it makes of every recording.
pub(super) struct Row {
    pub name: String,
    /// E over that of the material's source.
    pub modulus_ratio: f64,
    pub material: IdentifiedMaterial,
    /// What is missing of a step's pressure at first, Pa.
    pub missing: Pascal,
    /// Recordings to which it was fitted.
    pub used: Vec<usize>,
    /// Where its fit ended; none where nothing was fitted.
    pub end: Option<End>,
    /// Thickness of the thinnest wall, m.
    pub wall: Option<f64>,
    /// One per recording.
    pub predictions: Vec<Prediction>,
}

/// Where a fit ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct End {
    pub at: Point,
    /// Number of free parameters.
    pub free: usize,
    /// Largest component of the step that would follow.
    pub next_step: f64,
}

impl End {
    /// Whether another step would change the result by more than its digits.
    pub(super) fn converged(&self) -> bool {
        self.next_step < 10.0 * ENOUGH
    }

    /// Free parameters on an end of their range, with the range.
    pub(super) fn on_bounds(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let Self { at, free, .. } = *self;
        let lies_on = move |p: usize, end: f64| (at[p] - end).abs() < 1e-6;
        (0..free).filter(move |p| RANGES[*p].iter().any(|end| lies_on(*p, *end))).map(|p| (p, RANGES[p]))
    }
}

/// What a material makes of one recording.
pub(super) struct Prediction {
    pub course: Course,
    /// None when the wall balloons without bound.
    pub features: Option<Features>,
}

/// The recordings of a page with the body.
pub(super) struct Bench<'a> {
    pub page: &'a Page,
    pub recorded: &'a [Recorded],
    pub body: &'a Meshed,
}

/// A point of the search with the residuals and Jacobian of every recording: as many rows of each as quantities are compared.
pub(super) struct Linearised {
    pub at: Point,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl Bench<'_> {
    /// The material `source` at a point of the search.
    fn scaled_material(&self, source: &IdentifiedMaterial, point: Point) -> IdentifiedMaterial {
        // C₃₀ = 0: with ½ C₂₀²/C₁₀, as in the free vibration test, the walls stiffen too steeply, and the tip of a recording that is left out is
        // predicted to 18.5 and 20.6 % in place of 13.7 and 16.3
        let stiffening = [point[1], 0.0];
        IdentifiedMaterial { youngs_modulus: source.youngs_modulus * point[0].exp(), stiffening, ..source.clone() }
    }

    /// What `material` makes of every recording on `body`.
    ///
    /// # Errors
    /// A diagnostic when it is refused.
    pub fn row(&self, name: &str, material: IdentifiedMaterial, body: &Meshed) -> Result<Row> {
        self.predict_row(name, (material, 0.0), body)
    }

    /// What the end of a fit to the recordings `used` makes of every recording.
    ///
    /// # Errors
    /// A diagnostic when its material is refused.
    pub fn fitted(&self, name: &str, (source, end): (&IdentifiedMaterial, &Linearised), used: &[usize]) -> Result<Row> {
        let point = end.at;
        let row = self.predict_row(name, (self.scaled_material(source, point), missing_pressure(point)), self.body)?;
        let (free, next_step) = (end.jacobian.ncols(), gauss_newton_step(end).amax());
        let end = End { at: point, free, next_step };
        Ok(Row { used: used.to_vec(), modulus_ratio: point[0].exp(), end: Some(end), ..row })
    }

    fn predict_row(&self, name: &str, (material, missing): (IdentifiedMaterial, Pascal), body: &Meshed) -> Result<Row> {
        let mut known = Vec::new();
        let predict = |k: usize| {
            let recording = &self.page.recording[k];
            let duration = recording.duration();
            let course = body.inflate(&material, (recording, &self.page.supply(missing)), duration, &mut known)?;
            let features = course.burst.is_none().then(|| Features::of(self.page, duration, &course.tip));
            Ok(Prediction { course, features })
        };
        let predictions = (0..self.recorded.len()).map(predict).collect::<Result<_>>()?;
        let (name, wall) = (name.to_owned(), body.wall);
        Ok(Row { name, modulus_ratio: 1.0, material, missing, used: Vec::new(), end: None, wall, predictions })
    }

    /// Logarithms of simulated over measured displacement soon after the step, and with `free` parameters that the creep shows, at the
    /// end of the hold.
    fn log_ratios(
        &self,
        source: &IdentifiedMaterial,
        (point, free): (Point, usize),
        (k, known): (usize, &mut Vec<Arc<Shape>>),
    ) -> Result<Vec<f64>> {
        let (recording, measured) = (&self.page.recording[k], self.recorded[k].features);
        let hold = recording.duration();
        let end = if quantity_count(free) > 1 { hold } else { self.page.early[1] };
        let supply = self.page.supply(missing_pressure(point));
        let course = self.body.inflate(&self.scaled_material(source, point), (recording, &supply), end, known)?;
        if course.burst.is_some() {
            return Ok(vec![BURST; quantity_count(free)]);
        }
        let predicted = Features::of(self.page, hold, &course.tip);
        let logarithm = |ratio: f64| if ratio > 0.0 { ratio.ln().min(BURST) } else { BURST };
        let ratios = [predicted.early / measured.early, predicted.late / measured.late];
        Ok(ratios.into_iter().take(quantity_count(free)).map(logarithm).collect())
    }

    /// Residuals of the recordings `used` at several points: points × (recordings × quantities).
    fn point_residuals(
        &self,
        source: &IdentifiedMaterial,
        (points, free): (&[Point], usize),
        used: &[usize],
    ) -> Result<Vec<DVector<f64>>> {
        // Each point's recordings in turn, from the equilibria of those before.
        let residuals = |point: &Point| -> Result<DVector<f64>> {
            let mut known = Vec::new();
            let ratios = used.iter().map(|k| self.log_ratios(source, (*point, free), (*k, &mut known)));
            Ok(DVector::from_vec(ratios.collect::<Result<Vec<_>>>()?.concat()))
        };
        points.par_iter().map(residuals).collect()
    }

    /// The residuals of `used` and their Jacobian by the first `free` parameters, by differences; all but these are those of `point`.
    ///
    /// # Errors
    /// A diagnostic when a simulation is refused.
    pub fn linearised(
        &self,
        source: &IdentifiedMaterial,
        (point, free): (Point, usize),
        used: &[usize],
    ) -> Result<Linearised> {
        let perturbed = |p: usize| {
            let mut perturbed_point = point;
            perturbed_point[p] += DIFFERENCE[p];
            perturbed_point
        };
        let points: Vec<Point> = std::iter::once(point).chain((0..free).map(perturbed)).collect();
        let residuals = self.point_residuals(source, (&points, free), used)?;
        let columns: Vec<DVector<f64>> =
            (0..free).map(|p| (&residuals[p + 1] - &residuals[0]) / DIFFERENCE[p]).collect();
        Ok(Linearised { at: point, residuals: residuals[0].clone(), jacobian: DMatrix::from_columns(&columns) })
    }

    /// The fit to the recordings `used`, begun at `iterate`.
    ///
    /// # Errors
    /// A diagnostic when a simulation is refused.
    pub fn fit(&self, source: &IdentifiedMaterial, used: &[usize], mut iterate: Linearised) -> Result<Linearised> {
        for _ in 0..MAX_STEPS {
            let step = gauss_newton_step(&iterate);
            if step.amax() < ENOUGH {
                break;
            }
            let mut point = iterate.at;
            (0..step.len()).for_each(|p| point[p] += step[p]);
            let residuals = self.point_residuals(source, (&[point], step.len()), used)?.swap_remove(0);
            let missed = &residuals - &iterate.residuals - &iterate.jacobian * &step;
            let jacobian = &iterate.jacobian + missed * step.transpose() / step.norm_squared();
            iterate = Linearised { at: point, residuals, jacobian };
        }
        Ok(iterate)
    }
}

/// Quantities of a recording that are compared with so many free parameters.
fn quantity_count(free: usize) -> usize {
    if free > 2 { 2 } else { 1 }
}

/// What is missing of a step's pressure at first, Pa.
fn missing_pressure(point: Point) -> Pascal {
    1e3 * point[2]
}

/// Where a fit of so many parameters begins, with the material `source`.
pub(super) fn start(source: &IdentifiedMaterial, free: usize) -> Point {
    [0.0, if free == 1 { source.stiffening[0] } else { STIFFENING }, 0.0]
}

impl Linearised {
    /// Of some of its recordings.
    pub fn only(&self, recordings: &[usize]) -> Self {
        let each = quantity_count(self.jacobian.ncols());
        let rows: Vec<usize> = recordings.iter().flat_map(|k| (0..each).map(move |q| each * k + q)).collect();
        let rows = &rows;
        Self { at: self.at, residuals: self.residuals.select_rows(rows), jacobian: self.jacobian.select_rows(rows) }
    }
}

/// The step of least squares, within [`LONGEST`] and [`RANGES`].
fn gauss_newton_step(iterate: &Linearised) -> DVector<f64> {
    let svd = iterate.jacobian.clone().svd(true, true);
    // A direction that the recordings do not show stays where it is, instead of running to the end of its range.
    let mut step = svd.solve(&-&iterate.residuals, 1e-6).unwrap_or_else(|_| DVector::zeros(iterate.jacobian.ncols()));
    let excess = (0..step.len()).map(|p| step[p].abs() / LONGEST[p]).fold(1.0, f64::max);
    step /= excess;
    for (p, step) in step.iter_mut().enumerate() {
        *step = (iterate.at[p] + *step).clamp(RANGES[p][0], RANGES[p][1]) - iterate.at[p];
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_solves_a_linear_problem_within_its_bounds() {
        let jacobian = DMatrix::from_row_slice(3, 2, &[-1.0, -0.5, -2.0, -1.5, -1.0, -2.0]);
        let residuals = -&jacobian * DVector::from_row_slice(&[0.1, 0.2]);
        let step = gauss_newton_step(&Linearised { at: [0.0, 0.5, 0.0], residuals, jacobian: jacobian.clone() });
        assert!((step[0] - 0.1).abs() < 1e-12 && (step[1] - 0.2).abs() < 1e-12);
        let residuals = -&jacobian * DVector::from_row_slice(&[0.1, -9.0]);
        let step = gauss_newton_step(&Linearised { at: [0.0, 0.1, 0.0], residuals, jacobian });
        assert!((step[1] + 0.3).abs() < 1e-12, "the bound of C₂₀/C₁₀");
    }
}
