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
use crate::motion::march::{self, March};
use crate::motion::stencil::{Stencil, extrapolation};

/// Directions in one step before it is given up.
const LIMIT: usize = 60;
/// Directions after which a tangent is renewed.
const PATIENCE: usize = 5;
/// A direction that leaves more of the one before than this asks for a new tangent.
const SLOW: f64 = 0.3;
/// A step is found when its last direction is this small against the shapes that the body was reduced from.
const TOLERANCE: f64 = 1e-9;
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

/// One step's equations.
struct Step<'a> {
    body: &'a Reduced,
    march: &'a March,
    stencil: &'a Stencil,
    pressures: &'a [Pascal],
    scale: &'a [f64],
    around: &'a dyn Around,
    /// v̂, â, f̂.
    past: [DVector<f64>; 3],
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
        let mut tangent = None;
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
            let shape = equations.solve(past.guess(time), &mut tangent).map_err(|change| ReducedError::NoMotion {
                time: past.times[0],
                limit: LIMIT,
                change,
            })?;
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
    /// The shape at the end of the step, or the last relative change when none is found. `tangent` is kept from step to step.
    fn solve(&self, mut shape: DVector<f64>, tangent: &mut Option<LU<f64, Dyn, Dyn>>) -> Result<DVector<f64>, f64> {
        let (mut before, mut age) = (f64::INFINITY, 0);
        for _ in 0..LIMIT {
            let factor = tangent.get_or_insert_with(|| self.slopes(&shape).lu());
            let change = factor.solve(&self.residual(&shape)).ok_or(f64::INFINITY)?;
            let size = change.amax() / self.body.size;
            if !size.is_finite() {
                return Err(size);
            }
            age += 1;
            if age > 1 && size > SLOW * before || age > PATIENCE {
                (*tangent, before, age) = (None, f64::INFINITY, 0);
                if size > before {
                    continue;
                }
            } else {
                before = size;
            }
            shape -= change;
            if size < TOLERANCE {
                return Ok(shape);
            }
        }
        Err(before)
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

    /// ∂residual/∂q
    fn slopes(&self, shape: &DVector<f64>) -> DMatrix<f64> {
        let gamma = self.stencil.gamma;
        let (alpha, beta) = (self.march.mass_damping, self.march.stiffness_damping);
        let mut slopes = &self.body.mass * (gamma * (gamma + alpha));
        slopes += self.body.stiffness(shape, self.scale) * (1.0 + beta * gamma);
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
