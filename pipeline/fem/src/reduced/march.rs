//! A reduced body in motion: the whole body's equations on V, and whatever surrounds it.
//!
//! VᵀMV q̈ + α VᵀMV q̇ + f(q) + β ḟ(q) = Σ p ∂V/∂q + Q,  the same stencils in time as for the whole body. Each step is solved by
//! Newton's method on a tangent that is renewed when it no longer serves.
//!
//! Stands on: `stencil`, `march` (the settings), the reduced forces. Never knows: what Q comes from.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector, Dyn, LU};
use si::{Hertz, Pascal, Second};

use super::Reduced;
use super::forces::Stress;
use crate::motion::march::{self, March};
use crate::motion::stencil::{Stencil, extrapolation};

/// Directions in one step before it is given up.
const LIMIT: usize = 60;
/// A direction that leaves more of the one before than this asks for a new tangent, which costs as much as twenty directions.
pub(super) const PATIENT: f64 = 0.3;
/// The same for a step that was not found so: it is tried once more from a tangent of its own.
const STRICT: f64 = 0.1;
/// So does a first one by a new tangent that is longer than this, against the shapes that the body was reduced from.
const NEAR: f64 = 1e-3;
/// Directions shorter than this, against the same, are gone whole: their pull is too close to rounding to be searched along.
const SHORT: f64 = 1e-6;
/// Steps whose γ differ by less have one stencil, of the size of γ.
const SAME: f64 = 1e-9;
/// How often a direction is halved at most.
const HALVINGS: usize = 20;
/// A step is found when its last direction is this small against the shapes that the body was reduced from.
const TOLERANCE: f64 = 1e-8;
/// Step of the differences by which surroundings are linearised, against the same.
const NUDGE: f64 = 1e-6;

/// Why a body cannot be reduced, or moves no further.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReducedError {
    /// Shapes of another system, or none.
    #[error(
        "{count} shapes cannot span this body\n  why: each needs {right} numbers, 3 a node\n  do:  hand over displacements of this system"
    )]
    Shapes {
        /// How many there are.
        count: usize,
        /// Numbers that each needs.
        right: usize,
    },
    /// A region whose dilatation is averaged.
    #[error(
        "a region averages its dilatation over each element\n  why: chosen points stand alone\n  do:  reduce without mean_dilatation"
    )]
    MeanDilatation,
    /// Kept of another system, or spoilt.
    #[error("the kept reduced body is not of this system\n  why: {what}\n  do:  reduce this system anew")]
    Foreign {
        /// What does not fit.
        what: String,
    },
    /// Settings out of range.
    #[error(transparent)]
    Settings(#[from] crate::stall::SolveError),
    /// A step without a solution.
    #[error(
        "no motion of the reduced body is found after {time:.4} s\n  why: {limit} directions leave a change of {change:.1e} of the largest shape; {TOLERANCE:.0e} is enough\n  do:  take shorter steps, or reduce from shapes nearer to this motion"
    )]
    NoMotion {
        /// Of the last step that was found, s.
        time: Second,
        /// Directions tried.
        limit: usize,
        /// The last one, no unit.
        change: f64,
    },
}

impl ReducedError {
    pub(super) fn no_motion(time: Second, change: f64) -> Self {
        Self::NoMotion { time, limit: LIMIT, change }
    }
}

/// What pushes from inside at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// One a chamber, Pa.
    pub pressures: Vec<Pascal>,
}

/// A trial state of one step.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// q
    pub shape: &'a DVector<f64>,
    /// q̇, 1/s.
    pub speed: &'a DVector<f64>,
    /// γ and w of ẋ = γ x + Σ wⱼ xₙ₋ⱼ, for what the surroundings themselves keep of the past, newest first.
    pub gamma: Hertz,
    /// See `gamma`.
    pub weights: &'a [Hertz],
}

/// What surrounds a reduced body and pushes on it.
pub trait Around {
    /// Q, J a unit of q.
    fn force(&self, at: &Moment) -> DVector<f64>;

    /// A step has ended at `at`.
    fn accept(&mut self, at: &Moment);
}

/// Nothing around.
#[derive(Debug, Clone, Copy)]
pub struct Still;

impl Around for Still {
    fn force(&self, at: &Moment) -> DVector<f64> {
        DVector::zeros(at.shape.len())
    }

    fn accept(&mut self, _: &Moment) {}
}

/// What the next step needs from the past, newest first.
struct Past {
    times: VecDeque<Second>,
    shapes: VecDeque<DVector<f64>>,
    speeds: VecDeque<DVector<f64>>,
    forces: VecDeque<DVector<f64>>,
}

/// A factor of the tangent, and the γ that it was made with.
pub(super) struct Kept {
    factor: LU<f64, Dyn, Dyn>,
    gamma: Hertz,
}

/// One step's equations.
pub(super) struct Step<'a> {
    pub body: &'a Reduced,
    pub march: &'a March,
    pub stencil: &'a Stencil,
    pub pressures: &'a [Pascal],
    pub scale: &'a [f64],
    pub around: &'a dyn Around,
    /// v̂, â, f̂.
    pub past: [DVector<f64>; 3],
}

/// What sees each new q and q̇ with its time, s.
pub type Observer<'a> = dyn FnMut(Second, &DVector<f64>, &DVector<f64>) + 'a;

impl Reduced {
    /// Moves from rest through `steps` steps: `drive` gives the pressures at a time (s from the start), `scale` (one a region)
    /// multiplies moduli, `observe` sees each new q and q̇ with its time.
    ///
    /// # Errors
    /// [`ReducedError`] when a setting is out of range or a step finds no motion.
    pub fn march(
        &self,
        march: &March,
        scale: &[f64],
        drive: &dyn Fn(Second) -> Drive,
        around: &mut dyn Around,
        steps: usize,
        observe: &mut Observer<'_>,
    ) -> Result<(), ReducedError> {
        march::check(march)?;
        let mut past = Past::at_rest(self.coordinates());
        let mut kept = None;
        for step in 1..=steps {
            let time = step as f64 * march.step;
            let stencil = past.stencil(march, time);
            let Drive { pressures } = drive(time);
            let equations = Step {
                body: self,
                march,
                stencil: &stencil,
                pressures: &pressures,
                scale,
                around: &*around,
                past: past.history(&stencil),
            };
            let shape = equations
                .solve(past.guess(time), &past.shapes[0], &mut kept, PATIENT)
                .or_else(|_| equations.solve(past.guess(time), &past.shapes[0], &mut None, STRICT))
                .map_err(|change| ReducedError::no_motion(past.times[0], change))?;
            let speed = equations.speed(&shape);
            around.accept(&Moment { shape: &shape, speed: &speed, gamma: stencil.gamma, weights: &stencil.weights });
            observe(time, &shape, &speed);
            past.take(time, shape, speed, |q| self.elastic_forces(q, scale));
        }
        Ok(())
    }
}

impl Past {
    fn at_rest(r: usize) -> Self {
        let nothing = || VecDeque::from([DVector::zeros(r)]);
        Self { times: VecDeque::from([0.0]), shapes: nothing(), speeds: nothing(), forces: nothing() }
    }

    fn stencil(&self, march: &March, time: Second) -> Stencil {
        Stencil::new(march.scheme, time - self.times[0], self.times.get(1).map(|then| self.times[0] - then))
    }

    fn history(&self, stencil: &Stencil) -> [DVector<f64>; 3] {
        [&self.shapes, &self.speeds, &self.forces]
            .map(|past| DVector::from_vec(stencil.history(past.iter().map(|x| x.as_slice()))))
    }

    /// The polynomial through the kept shapes.
    fn guess(&self, time: Second) -> DVector<f64> {
        let times: Vec<Second> = self.times.iter().copied().collect();
        let weights = extrapolation(&times, time);
        self.shapes.iter().zip(weights).fold(DVector::zeros(self.shapes[0].len()), |sum, (q, w)| sum + q * w)
    }

    fn take(
        &mut self,
        time: Second,
        shape: DVector<f64>,
        speed: DVector<f64>,
        force: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) {
        self.forces.push_front(force(&shape));
        self.shapes.push_front(shape);
        self.speeds.push_front(speed);
        self.times.push_front(time);
        [&mut self.shapes, &mut self.speeds, &mut self.forces].into_iter().for_each(|past| past.truncate(3));
        self.times.truncate(3);
    }
}

impl Step<'_> {
    /// The shape at the end of the step, from a first `guess` after the shape `before`, or the last relative change when none is
    /// found.
    ///
    /// The last step's tangent is `kept` while it serves. It is made anew when a direction leaves too much of the one before it: a
    /// stiff sheet that turns makes an old one misleading, and the stress of a shape that is not yet in balance a fresh one (see
    /// `bend`).
    pub fn solve(
        &self,
        guess: DVector<f64>,
        before: &DVector<f64>,
        kept: &mut Option<Kept>,
        slow: f64,
    ) -> Result<DVector<f64>, f64> {
        let (mut shape, mut from) = (guess, before.clone());
        let mut residual = self.residual(&shape);
        if kept.as_ref().is_some_and(|k| (k.gamma / self.stencil.gamma - 1.0).abs() > SAME) {
            *kept = None;
        }
        let (mut last, carried) = (f64::INFINITY, kept.is_some());
        for _ in 0..LIMIT {
            let tangent = kept.get_or_insert_with(|| {
                let factor = self.slopes(&shape, Stress::ForeseenFrom(&from)).lu();
                Kept { factor, gamma: self.stencil.gamma }
            });
            let mut change = tangent.factor.solve(&residual).ok_or(last)?;
            if residual.dot(&change) <= 0.0 {
                change = self.slopes(&shape, Stress::Convex).lu().solve(&residual).ok_or(last)?;
                *kept = None;
            }
            let short = change.amax() < SHORT * self.body.size;
            let (part, next) =
                if short { (1.0, self.residual(&(&shape - &change))) } else { self.search(&shape, &change, &residual) };
            let size = part * change.amax() / self.body.size;
            if !size.is_finite() {
                return Err(last);
            }
            let moved = &shape - change * part;
            (from, shape, residual) = (if part == 1.0 { shape } else { moved.clone() }, moved, next);
            if part == 1.0 && size < TOLERANCE {
                return Ok(shape);
            }
            if part < 1.0 || size > slow * last || last.is_infinite() && !carried && size > NEAR {
                *kept = None;
            }
            last = size;
        }
        *kept = None;
        Err(last)
    }

    /// How much of −`change` to go from `shape`, and what is left there. All of it, unless the residual then pushes back more than
    /// it pulled at first; then to where it does neither, roughly.
    fn search(&self, shape: &DVector<f64>, change: &DVector<f64>, residual: &DVector<f64>) -> (f64, DVector<f64>) {
        let pull = residual.dot(change);
        let at = |part: f64| {
            let left = self.residual(&(shape - change * part));
            let push = -left.dot(change) / pull;
            (if push.is_finite() { push } else { f64::INFINITY }, left)
        };
        let (mut part, mut low, mut high) = (1.0, 0.0, 1.0);
        let (mut push, mut left) = at(part);
        for _ in 0..HALVINGS {
            if push.abs() <= 0.5 || part == 1.0 && push <= 1.0 {
                break;
            }
            (low, high) = if push > 0.0 { (low, part) } else { (part, high) };
            part = 0.5 * (low + high);
            (push, left) = at(part);
        }
        (part, left)
    }

    fn speed(&self, shape: &DVector<f64>) -> DVector<f64> {
        shape * self.stencil.gamma + &self.past[0]
    }

    fn moment_force(&self, shape: &DVector<f64>) -> DVector<f64> {
        let speed = self.speed(shape);
        self.around.force(&Moment { shape, speed: &speed, gamma: self.stencil.gamma, weights: &self.stencil.weights })
    }

    fn residual(&self, shape: &DVector<f64>) -> DVector<f64> {
        let (gamma, [_, a, f]) = (self.stencil.gamma, &self.past);
        let (alpha, beta) = (self.march.mass_damping, self.march.stiffness_damping);
        let speed = self.speed(shape);
        let mut residual = &self.body.mass * (&speed * (gamma + alpha) + a) + f * beta - self.moment_force(shape);
        residual += self.body.elastic_forces(shape, self.scale) * (1.0 + beta * gamma);
        for (chamber, pressure) in self.body.chambers.iter().zip(self.pressures) {
            chamber.add_gradient(shape, -pressure, &mut residual);
        }
        residual
    }

    /// ∂residual/∂q with this `stress`.
    fn slopes(&self, shape: &DVector<f64>, stress: Stress) -> DMatrix<f64> {
        let gamma = self.stencil.gamma;
        let (alpha, beta) = (self.march.mass_damping, self.march.stiffness_damping);
        let mut slopes = &self.body.mass * (gamma * (gamma + alpha));
        slopes += self.body.stiffness(shape, stress, self.scale) * (1.0 + beta * gamma);
        for (chamber, pressure) in self.body.chambers.iter().zip(self.pressures) {
            chamber.add_hessian(shape, -pressure, &mut slopes);
        }
        let (here, nudge) = (self.moment_force(shape), NUDGE * self.body.size);
        for (i, mut column) in slopes.column_iter_mut().enumerate() {
            let mut nudged = shape.clone();
            nudged[i] += nudge;
            column -= (self.moment_force(&nudged) - &here) / nudge;
        }
        slopes
    }
}
