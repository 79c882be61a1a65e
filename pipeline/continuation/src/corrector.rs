//! Newton's method for r(u, λ) = 0 with one constraint, by block elimination of the bordered system on the factor of K.
//!
//! K is singular at a limit point, the bordered matrix is not: du = K⁻¹(−r) + dλ K⁻¹q stays finite, since both parts grow
//! along the same mode and dλ makes them cancel.

use crate::constraint::Constraint;
use crate::error::StepFailure;
use crate::point::Sample;
use crate::problem::Problem;
use crate::subspace::{Accuracy, Subspace};

/// Iterations at most: those that converge need 3 to 7.
const MAX_ITERATIONS: usize = 12;
/// A Newton step above this fraction of the body's size is far outside of the basin of convergence.
const MAX_NEWTON_STEP: f64 = 0.5;
/// Halvings of a Newton step that inverts an element.
const MAX_HALVINGS: usize = 5;
/// Below this fraction of the body's size the tangent is assembled exactly: it then is that of the path.
const EXACT_BELOW: f64 = 1e-4;

/// Solves points of one problem.
pub(crate) struct Corrector<'a> {
    pub problem: &'a mut dyn Problem,
    /// m
    pub tolerance: f64,
    pub subspace: Subspace,
    pub factorisations: usize,
}

/// An initial guess, and where the step to it began.
pub(crate) struct Guess<'a> {
    pub u: Vec<f64>,
    pub load_factor: f64,
    pub previous: Option<&'a [f64]>,
}

impl Corrector<'_> {
    /// The point of the path that fulfils `constraint`, from a `guess` near to it.
    ///
    /// # Errors
    /// [`StepFailure`]
    pub fn solve(&mut self, guess: Guess, constraint: Constraint, accuracy: Accuracy) -> Result<Sample, StepFailure> {
        let Guess { u, load_factor, previous } = guess;
        let residual = self.problem.residual(&u, load_factor).ok_or(StepFailure::NotDefined)?;
        let mut iterate = Iterate { u, load_factor, residual };
        let mut previous = previous.map(<[f64]>::to_vec);
        let mut step = f64::INFINITY;
        for iterations in 1..=MAX_ITERATIONS {
            let predecessor = previous.as_deref().filter(|_| step > EXACT_BELOW * self.problem.size());
            let is_exact = predecessor.is_none();
            let newton = self.newton_step(&iterate, predecessor, &constraint)?;
            step = sparse::max_abs(&newton.du);
            if step > MAX_NEWTON_STEP * self.problem.size() {
                return Err(StepFailure::IterationLimit { step, iterations });
            }
            let next = self.take_step(&iterate, &newton).ok_or(StepFailure::NotDefined)?;
            previous = Some(std::mem::replace(&mut iterate, next).u);
            // The inertia of an approximate tangent is not that of the path.
            if step <= self.tolerance && is_exact {
                let pairs = self.subspace.refine_eigenpairs(&mut |x| self.problem.solve(x), accuracy);
                let (Iterate { u, load_factor, .. }, Newton { by_load, negative, .. }) = (iterate, newton);
                return Ok(Sample { u, load_factor, by_load, negative, pairs, iterations });
            }
        }
        Err(StepFailure::IterationLimit { step, iterations: MAX_ITERATIONS })
    }

    fn newton_step(
        &mut self,
        at: &Iterate,
        from: Option<&[f64]>,
        constraint: &Constraint,
    ) -> Result<Newton, StepFailure> {
        self.factorisations += 1;
        let negative = self.problem.factorise(&at.u, at.load_factor, from).ok_or(StepFailure::Singular)?;
        let mut by_residual: Vec<f64> = at.residual.iter().map(|entry| -entry).collect();
        self.problem.solve(&mut by_residual);
        let mut by_load = self.problem.load(&at.u, at.load_factor);
        self.problem.solve(&mut by_load);
        let load_step = constraint.linearise_at(&at.u, at.load_factor).load_step(&by_residual, &by_load);
        let mut du = by_residual;
        sparse::add(&mut du, load_step, &by_load);
        Ok(Newton { du, load_step, by_load, negative })
    }

    /// The whole step, or as much of it as the residual is defined for: a long one may invert an element.
    fn take_step(&mut self, iterate: &Iterate, newton: &Newton) -> Option<Iterate> {
        let mut part = 1.0;
        for _ in 0..MAX_HALVINGS {
            let (mut u, load_factor) = (iterate.u.clone(), iterate.load_factor + part * newton.load_step);
            sparse::add(&mut u, part, &newton.du);
            if let Some(residual) = self.problem.residual(&u, load_factor) {
                return Some(Iterate { u, load_factor, residual });
            }
            part *= 0.5;
        }
        None
    }
}

/// A state of the iteration.
struct Iterate {
    u: Vec<f64>,
    load_factor: f64,
    residual: Vec<f64>,
}

/// One Newton step with what its factor says.
struct Newton {
    du: Vec<f64>,
    load_step: f64,
    by_load: Vec<f64>,
    negative: usize,
}
