//! The tangent at an equilibrium as a linear problem of its own: assembled, factorised, solved, handed out.
//!
//! Newton and the adjoint do all of this by themselves; this is for those who want modes, condensation, or timings.
//!
//! Stands on: `newton`, `tangent`. Never knows: what the solution is for.

use crate::solver::Solver;
use crate::stall::SolveError;
use crate::statics::equilibrium::Equilibrium;

/// A symmetric matrix by columns, its lower triangle alone: rows and columns in the order of elimination.
#[derive(Debug, Clone, Copy)]
pub struct LowerTriangle<'a> {
    /// freedoms + 1: where each column begins in `rows` and `values`.
    pub columns: &'a [u32],
    /// Row of each entry, rising within a column, the diagonal first.
    pub rows: &'a [u32],
    /// N/m.
    pub values: &'a [f64],
    /// Freedom → 3 node + axis.
    pub origin: &'a [u32],
}

impl Solver {
    /// Assembles the exact tangent ∂²Π/∂u² at `at`; a sealed chamber's full block is left out.
    ///
    /// # Errors
    /// [`SolveError`] when `at` is not of this system.
    pub fn assemble(&mut self, at: &Equilibrium) -> Result<LowerTriangle<'_>, SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_pressures(&at.pressures)?;
        self.linearised = None;
        let Self { parts, given, newton, .. } = self;
        let potential = given.at_rest(parts, &at.pressures, 1.0);
        potential.stiffness(&at.displacement, &mut newton.values);
        potential.add_other_curvature(&at.displacement, &mut newton.values);
        let pattern = &parts.pattern;
        Ok(LowerTriangle {
            columns: &pattern.columns,
            rows: &pattern.rows,
            values: &newton.values,
            origin: &pattern.origin,
        })
    }

    /// Factorises what was assembled last at `at`, and checks the factor on one solve.
    ///
    /// # Errors
    /// [`SolveError::NotStable`] when it is not positive definite.
    pub fn factorise(&mut self, at: &Equilibrium) -> Result<(), SolveError> {
        let Self { parts, given, newton, .. } = self;
        let potential = given.at_rest(parts, &at.pressures, 1.0);
        let mut probe = vec![0.0; parts.pattern.freedoms()];
        parts.pattern.multiply(&newton.values, &vec![1.0; probe.len()], &mut probe);
        newton.factorise(&potential, &at.displacement, &probe).map_err(|_| SolveError::NotStable)
    }

    /// x with K x = `b` by the last factor, both 3 a node; held freedoms come out as nothing.
    ///
    /// # Errors
    /// [`SolveError`] when `b` has the wrong length, or nothing was factorised yet.
    pub fn solve(&mut self, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the right-hand side", b)?;
        if !self.newton.is_ready() {
            return Err(SolveError::NotStable);
        }
        let mut free = Vec::new();
        self.parts.pattern.gather(b, &mut free);
        self.newton.solve(&self.parts, &mut free);
        let mut full = vec![0.0; b.len()];
        self.parts.pattern.spread(&free, 1.0, &mut full);
        Ok(full)
    }
}
