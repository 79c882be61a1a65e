//! Equations of one time step of a reduced model, and its static equilibrium: Newton's method in full steps, and where that fails in damped
//! ones with a lagged tangent.

use nalgebra::{DMatrix, DVector, Dyn, LU};
use si::{Hertz, Pascal, Second};

use super::contact::ReducedContact;
use super::elastic_forces::{ActingRegion, ReducedTangent};
use super::error::ReducedError;
use super::model::ReducedModel;
use crate::dynamics::settings::DynamicSettings;
use crate::dynamics::stencil::Stencil;

/// Full steps at most: a time step takes three or four.
const FULL_STEPS: usize = 12;
/// A full step that leaves more than this fraction of the one before asks for a new tangent.
const REFACTORISE_FULL_ABOVE: f64 = 0.1;
/// A first full step that is longer than this, relative to the snapshots, asks for a new tangent.
const NEARBY: f64 = 1e-4;
/// Full steps longer than this, relative to the snapshots, lead nowhere.
const FARTHEST: f64 = 10.0;
/// Damped iterations at most.
const MAX_ITERATIONS: usize = 60;
/// A damped step that leaves more than this fraction of the one before asks for a new tangent, which costs as much as about
/// seven forces.
const REFACTORISE_ABOVE: f64 = 0.3;
/// The same in the second attempt.
const RETRY_ABOVE: f64 = 0.1;
/// A first step on a new tangent that is longer than this, relative to the snapshots, asks for another tangent.
const NEAR: f64 = 1e-3;
/// Steps shorter than this, relative to the snapshots, are taken whole: their slope is too close to rounding for a line
/// search.
const SHORT: f64 = 1e-6;
/// Stencils whose γ differ by less than this, relative, are the same.
const SAME_GAMMA: f64 = 1e-9;
/// A step along the convex part of the tangent may be so many times as long: away from a saddle, as a wall buckles, whole
/// ones grow by a per cent each.
pub(super) const LONGEST: f64 = 1024.0;
/// Bisections of a line search at most.
const MAX_BISECTIONS: usize = 20;
/// Largest size of the last step, relative to the snapshots.
const TOLERANCE: f64 = 1e-8;
/// Step of the differences by which external forces are linearised, relative to the snapshots.
// Far above rounding; an error of a millionth is less than what a lagged tangent has.
const DIFFERENCE: f64 = 1e-6;

/// A trial state of one step.
#[derive(Debug, Clone, Copy)]
pub struct StepState<'a> {
    /// The end of the step, s; of an equilibrium 0.
    pub time: Second,
    /// q
    pub coordinates: &'a DVector<f64>,
    /// q̇, 1/s.
    pub velocity: &'a DVector<f64>,
    /// γ and w of ẋ = γ x + Σ wⱼ xₙ₋ⱼ, for external forces with a history of their own, newest first.
    pub gamma: Hertz,
    /// See `gamma`.
    pub weights: &'a [Hertz],
}

/// An external force on a reduced model, such as that of water.
pub trait ExternalForce {
    /// Q, J per unit of q.
    fn force(&self, at: &StepState) -> DVector<f64>;

    /// Called when a step has converged to `at`; of a step that is halved, at the end of each part.
    fn accept(&mut self, at: &StepState);
}

/// No external force.
#[derive(Debug, Clone, Copy)]
pub struct NoForce;

impl ExternalForce for NoForce {
    fn force(&self, at: &StepState) -> DVector<f64> {
        DVector::zeros(at.coordinates.len())
    }

    fn accept(&mut self, _: &StepState) {}
}

/// The error of a step from `time` whose last iteration was of size `change`.
pub(super) fn no_convergence(time: Second, change: f64) -> ReducedError {
    ReducedError::NoConvergence { time, max_iterations: MAX_ITERATIONS, change, tolerance: TOLERANCE }
}

/// Lagged tangent: its factor, and the γ that it was assembled with.
pub(super) struct LaggedTangent {
    factor: LU<f64, Dyn, Dyn>,
    gamma: Hertz,
}

/// Equations of one step.
pub(super) struct Step<'a> {
    pub model: &'a ReducedModel,
    pub settings: &'a DynamicSettings,
    pub stencil: &'a Stencil,
    pub pressures: &'a [Pascal],
    /// What acts in each region, damping and relaxation included.
    pub acting: &'a [ActingRegion],
    pub external: &'a dyn ExternalForce,
    /// Between walls; none: they pass through each other.
    pub contact: Option<&'a ReducedContact>,
    /// The end of the step, s.
    pub time: Second,
    /// v̂, â, f̂.
    pub past: [DVector<f64>; 3],
}

impl ReducedModel {
    /// The equilibrium f(q) = Σ p ∂V/∂q under `pressures` (one per chamber, Pa), from the initial `guess`; `scale` (one
    /// per region) multiplies moduli.
    ///
    /// # Errors
    /// [`ReducedError::NoConvergence`] at time 0.
    pub fn equilibrium(
        &self,
        pressures: &[Pascal],
        scale: &[f64],
        guess: &DVector<f64>,
    ) -> Result<DVector<f64>, ReducedError> {
        // A stencil without rates leaves the static equations.
        let stencil = Stencil { gamma: 0.0, weights: Vec::new() };
        let zero = || DVector::zeros(self.coordinates());
        let equations = Step {
            model: self,
            settings: &DynamicSettings::default(),
            stencil: &stencil,
            pressures,
            acting: &self.elastic(scale),
            external: &NoForce,
            contact: None,
            time: 0.0,
            past: [zero(), zero(), zero()],
        };
        let solution = equations.solve(guess, guess, &mut None);
        solution.map_err(|change| no_convergence(0.0, change))
    }
}

impl Step<'_> {
    /// q at the end of the step, from an initial `guess` after the coordinates `previous`; or the size of the last
    /// iteration when it does not converge. `lagged` is the tangent of the last step.
    pub fn solve(
        &self,
        guess: &DVector<f64>,
        previous: &DVector<f64>,
        lagged: &mut Option<LaggedTangent>,
    ) -> Result<DVector<f64>, f64> {
        // where a wall snaps, the shape before is nearer than the extrapolated one
        self.solve_from(guess, previous, lagged).or_else(|change| match guess == previous {
            true => Err(change),
            false => self.solve_from(previous, previous, lagged),
        })
    }

    /// The same from one initial guess: by full steps, or else by damped ones.
    fn solve_from(
        &self,
        guess: &DVector<f64>,
        previous: &DVector<f64>,
        lagged: &mut Option<LaggedTangent>,
    ) -> Result<DVector<f64>, f64> {
        let damped = |refactorise_above| self.damped_steps(guess.clone(), previous, refactorise_above);
        let by_full_steps = self.full_steps(guess, previous, lagged).ok_or(f64::INFINITY);
        by_full_steps.or_else(|_| damped(REFACTORISE_ABOVE)).or_else(|_| damped(RETRY_ABOVE))
    }

    /// By full steps; none where they do not converge.
    // An extrapolated shape stretches a stiff sheet where it rotates. The stress of that stretch makes a line search cut the step, and spoils
    // the exact tangent: the first one has the stress of `previous`, and later ones that which the last step predicted. A tail of thin
    // walls that flaps in air takes 3 residuals and 2 tangents a step; damped, it took 20 and 7.
    pub(super) fn full_steps(
        &self,
        guess: &DVector<f64>,
        previous: &DVector<f64>,
        lagged: &mut Option<LaggedTangent>,
    ) -> Option<DVector<f64>> {
        let (mut q, mut residual) = (guess.clone(), self.residual(guess));
        lagged.take_if(|tangent| !self.can_serve(tangent, &residual));
        let (mut former, mut last): (Option<DVector<f64>>, f64) = (None, f64::INFINITY);
        for _ in 0..FULL_STEPS {
            let kind = former.as_ref().map_or(ReducedTangent::FormerStress(previous), ReducedTangent::MixedPoint);
            let tangent = lagged.get_or_insert_with(|| self.factored_tangent(&q, kind));
            let change = tangent.factor.solve(&residual)?;
            let size = change.amax() / self.model.size;
            if size < TOLERANCE {
                return Some(q - change);
            }
            if size.is_nan() || size > FARTHEST || self.admissible_part(&q, &change) < 1.0 {
                break;
            }
            let next = &q - change;
            residual = self.residual(&next);
            former = Some(std::mem::replace(&mut q, next));
            if size > REFACTORISE_FULL_ABOVE * last || last.is_infinite() && size > NEARBY {
                *lagged = None;
            }
            last = size;
        }
        *lagged = None;
        None
    }

    /// Whether the tangent of a former step serves this one: its γ is the same, and what it leaves of the first step is short.
    fn can_serve(&self, tangent: &LaggedTangent, residual: &DVector<f64>) -> bool {
        let is_short = |change: DVector<f64>| change.amax() < NEARBY * self.model.size;
        (tangent.gamma / self.stencil.gamma - 1.0).abs() <= SAME_GAMMA
            && tangent.factor.solve(residual).is_some_and(is_short)
    }

    fn factored_tangent(&self, q: &DVector<f64>, kind: ReducedTangent) -> LaggedTangent {
        LaggedTangent { factor: self.tangent(q, kind).lu(), gamma: self.stencil.gamma }
    }

    /// By damped steps; the tangent is replaced when an iteration leaves more than `refactorise_above` of the one before.
    // A stiff sheet that rotates makes a lagged tangent misleading, and the stress of a shape far from equilibrium
    // spoils a new exact one: hence the mixed-integration-point tangent. Broyden's updates of the tangent were
    // measured: as many tangents and iterations.
    fn damped_steps(
        &self,
        guess: DVector<f64>,
        previous: &DVector<f64>,
        refactorise_above: f64,
    ) -> Result<DVector<f64>, f64> {
        let (mut q, mut former) = (guess, previous.clone());
        let (mut residual, mut lagged, mut last) = (self.residual(&q), None, f64::INFINITY);
        for _ in 0..MAX_ITERATIONS {
            let tangent = lagged.get_or_insert_with(|| self.factored_tangent(&q, ReducedTangent::MixedPoint(&former)));
            let mut change = tangent.factor.solve(&residual).ok_or(last)?;
            let is_no_descent = residual.dot(&change) <= 0.0;
            if is_no_descent {
                // Not a direction of descent; the convex part of the tangent gives one.
                change = self.tangent(&q, ReducedTangent::Convex).lu().solve(&residual).ok_or(last)?;
                lagged = None;
            }
            let full_size = change.amax() / self.model.size;
            if full_size < TOLERANCE {
                return Ok(q - change);
            }
            change *= self.admissible_part(&q, &change);
            let (part, next) = match (is_no_descent, full_size < SHORT) {
                (true, _) => self.line_search(&q, &change, &residual, LONGEST),
                (false, true) => (1.0, self.residual(&(&q - &change))),
                (false, false) => self.line_search(&q, &change, &residual, 1.0),
            };
            let size = part * full_size;
            if !size.is_finite() {
                return Err(last);
            }
            let advanced = &q - change * part;
            (former, q, residual) = (if part == 1.0 { q } else { advanced.clone() }, advanced, next);
            if part != 1.0 || size > refactorise_above * last || last.is_infinite() && size > NEAR {
                lagged = None;
            }
            last = size;
        }
        Err(last)
    }

    /// The part of the step −`change` from `q` by which no wall passes through another.
    fn admissible_part(&self, q: &DVector<f64>, change: &DVector<f64>) -> f64 {
        self.contact.map_or(1.0, |contact| contact.admissible_part(q, &-change))
    }

    /// `to`, or as much of the straight way from `from` to it as takes no wall through another.
    pub(crate) fn admissible_shape(&self, from: &DVector<f64>, to: &DVector<f64>) -> DVector<f64> {
        match self.admissible_part(from, &(from - to)) {
            1.0 => to.clone(),
            part => from.lerp(to, part),
        }
    }

    /// Length of the step −`change` from `q`, and the residual there. The whole step, doubled up to `longest` while the
    /// slope stays near that at the start, unless the slope at its end has the opposite sign and exceeds that at the
    /// start; then bisection to a small slope.
    // The slope decides, not the energy: external forces have no potential.
    pub(super) fn line_search(
        &self,
        q: &DVector<f64>,
        change: &DVector<f64>,
        residual: &DVector<f64>,
        longest: f64,
    ) -> (f64, DVector<f64>) {
        let start = residual.dot(change);
        let slope_and_residual = |part: f64| {
            let end_residual = self.residual(&(q - change * part));
            let slope = -end_residual.dot(change) / start;
            (if slope.is_finite() { slope } else { f64::INFINITY }, end_residual)
        };
        let (mut part, mut low, mut high) = (1.0, 0.0, 1.0);
        let (mut slope, mut end_residual) = slope_and_residual(part);
        while part < longest && slope < -0.5 {
            (low, part, high) = (part, 2.0 * part, 2.0 * part);
            (slope, end_residual) = slope_and_residual(part);
        }
        for _ in 0..MAX_BISECTIONS {
            if slope.abs() <= 0.5 || part == 1.0 && slope <= 1.0 {
                break;
            }
            (low, high) = if slope > 0.0 { (low, part) } else { (part, high) };
            part = 0.5 * (low + high);
            (slope, end_residual) = slope_and_residual(part);
        }
        (part, end_residual)
    }

    /// q̇ when the step ends at `q`.
    pub fn velocity(&self, q: &DVector<f64>) -> DVector<f64> {
        q * self.stencil.gamma + &self.past[0]
    }

    fn external_force(&self, q: &DVector<f64>) -> DVector<f64> {
        let velocity = self.velocity(q);
        let (gamma, weights) = (self.stencil.gamma, &self.stencil.weights);
        self.external.force(&StepState { time: self.time, coordinates: q, velocity: &velocity, gamma, weights })
    }

    pub(super) fn residual(&self, q: &DVector<f64>) -> DVector<f64> {
        let (gamma, [_, a, f]) = (self.stencil.gamma, &self.past);
        let (alpha, beta) = (self.settings.mass_damping, self.settings.stiffness_damping);
        let velocity = self.velocity(q);
        let mut residual = &self.model.mass * (&velocity * (gamma + alpha) + a) + f * beta - self.external_force(q);
        residual += self.model.acting_forces(q, self.acting);
        for (chamber, pressure) in self.model.chambers.iter().zip(self.pressures) {
            chamber.add_gradient(q, -pressure, &mut residual);
        }
        if let Some(contact) = self.contact {
            contact.add_gradient(q, &mut residual);
        }
        residual
    }

    /// ∂residual/∂q with the elastic tangent of this `kind`.
    fn tangent(&self, q: &DVector<f64>, kind: ReducedTangent) -> DMatrix<f64> {
        let gamma = self.stencil.gamma;
        let alpha = self.settings.mass_damping;
        let mut tangent = &self.model.mass * (gamma * (gamma + alpha));
        tangent += self.model.acting_stiffness(q, kind, self.acting);
        for (chamber, pressure) in self.model.chambers.iter().zip(self.pressures) {
            chamber.add_hessian(q, -pressure, &mut tangent);
        }
        if let Some(contact) = self.contact {
            contact.add_hessian(q, matches!(kind, ReducedTangent::Convex), &mut tangent);
        }
        let (here, step) = (self.external_force(q), DIFFERENCE * self.model.size);
        for (i, mut column) in tangent.column_iter_mut().enumerate() {
            let mut perturbed = q.clone();
            perturbed[i] += step;
            column -= (self.external_force(&perturbed) - &here) / step;
        }
        tangent
    }
}
