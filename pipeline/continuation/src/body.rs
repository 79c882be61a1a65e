//! A body of `fem` as a problem: chamber pressures and dead forces that grow in proportion to the load factor.
//!
//! Gravity and all else that the solver carries act in full. The tangent is symmetric, since `fem` assembles a chamber's
//! pressure as the second derivative of its volume, whose wall is closed.

use crate::error::ContinuationError;
use crate::problem::Problem;
use fem::{Equilibrium, Solver, System};
use si::{Metre, Pascal};
use sparse::IndefiniteFactor;

/// The load at the load factor 1.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyLoad {
    /// One per chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Dead forces, 3 entries per node, N; empty: none.
    pub forces: Vec<f64>,
}

/// A body under loads that grow with the load factor.
pub struct BodyProblem {
    solver: Solver,
    load: BodyLoad,
    factor: IndefiniteFactor,
    dof_map: DofMap,
    /// The dofs of the factor: where walls come into contact, the tangent has further entries, and another elimination order.
    factorised: DofMap,
    entries: usize,
    /// Where the tangent is assembled.
    at: Equilibrium,
    /// Where the path begins, one entry per dof.
    start: Vec<f64>,
    size: Metre,
}

/// The dofs of a body: vectors with one entry per dof as vectors with 3 entries per node.
#[derive(Debug, Clone)]
pub struct DofMap {
    /// Dof → 3 node + axis.
    full_index: Vec<u32>,
    nodes: usize,
}

impl DofMap {
    /// 3 entries per node from one per dof; zero where constrained.
    pub fn full(&self, u: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; 3 * self.nodes];
        self.full_index.iter().zip(u).for_each(|(&at, value)| full[at as usize] = *value);
        full
    }

    /// One entry per dof from 3 entries per node.
    fn gather_dofs(&self, full: &[f64]) -> Vec<f64> {
        self.full_index.iter().map(|&at| full[at as usize]).collect()
    }

    /// The node that moves most in a `mode` (one entry per dof).
    pub fn largest_node(&self, mode: &[f64]) -> usize {
        let full = self.full(mode);
        let size = |node: usize| full[3 * node..3 * node + 3].iter().map(|entry| entry * entry).sum::<f64>();
        (0..self.nodes).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }
}

/// Relative expansion under which the pressure of a sealed chamber changes; that of a fed one does not depend on the volume.
const PROBE: f64 = 1e-3;

impl BodyProblem {
    /// The body of `system` with the materials and gravity of `solver`, whose dead forces are replaced. Its path begins
    /// at rest.
    ///
    /// # Errors
    /// [`ContinuationError::Load`] when the load is not of this body or does nothing, or when a chamber is sealed: its
    /// gas would add a dense term to the tangent, which the factor and its inertia leave out.
    pub fn new(system: &System, mut solver: Solver, load: BodyLoad) -> Result<Self, ContinuationError> {
        solver.set_forces(&load.forces)?;
        check_fed(system, &solver, &load.pressures)?;
        let displacement = vec![0.0; 3 * system.mesh().nodes.len()];
        let undeformed = Equilibrium { displacement, pressures: load.pressures.clone(), ..Equilibrium::default() };
        let tangent = solver.assemble(&undeformed)?;
        let dof_map = DofMap { full_index: tangent.full_index.to_vec(), nodes: system.mesh().nodes.len() };
        let factor = IndefiniteFactor::new(&tangent)?;
        let (factorised, entries) = (dof_map.clone(), tangent.rows.len());
        let (start, size) = (vec![0.0; dof_map.full_index.len()], system.mesh().size());
        let mut problem = Self { solver, load, factor, dof_map, factorised, entries, at: undeformed, start, size };
        if problem.load(&problem.start(), 0.0).iter().all(|&force| force == 0.0) {
            let why = "a path of equilibria follows a load that grows";
            return Err(ContinuationError::Load { what: "the load moves nothing".into(), why });
        }
        Ok(problem)
    }

    /// The same body, its path beginning near `displacement` (3 entries per node, m).
    pub fn starting_at(mut self, displacement: &[f64]) -> Self {
        self.start = self.dof_map.gather_dofs(displacement);
        self
    }

    /// The dofs of its nodes.
    pub fn dof_map(&self) -> &DofMap {
        &self.dof_map
    }

    /// Pressures at a load factor, Pa; the dead forces are set.
    fn apply_load(&mut self, load_factor: f64) -> Option<Vec<Pascal>> {
        if !self.load.forces.is_empty() {
            let forces: Vec<f64> = self.load.forces.iter().map(|force| load_factor * force).collect();
            self.solver.set_forces(&forces).ok()?;
        }
        Some(self.load.pressures.iter().map(|pressure| load_factor * pressure).collect())
    }
}

impl Problem for BodyProblem {
    fn dofs(&self) -> usize {
        self.dof_map.full_index.len()
    }

    fn size(&self) -> Metre {
        self.size
    }

    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    fn residual(&mut self, u: &[f64], load_factor: f64) -> Option<Vec<f64>> {
        let pressures = self.apply_load(load_factor)?;
        let residual = self.dof_map.gather_dofs(&self.solver.residual(&self.dof_map.full(u), &pressures).ok()?);
        residual.iter().all(|entry| entry.is_finite()).then_some(residual)
    }

    // The residual is linear in the load factor, so that the difference is exact.
    fn load(&mut self, u: &[f64], _load_factor: f64) -> Vec<f64> {
        let unloaded = self.residual(u, 0.0).unwrap_or_default();
        let loaded = self.residual(u, 1.0).unwrap_or_default();
        unloaded.iter().zip(&loaded).map(|(unloaded, loaded)| unloaded - loaded).collect()
    }

    fn factorise(&mut self, u: &[f64], load_factor: f64, previous: Option<&[f64]>) -> Option<usize> {
        let pressures = self.apply_load(load_factor)?;
        self.at = Equilibrium { displacement: self.dof_map.full(u), pressures, ..Equilibrium::default() };
        let tangent = match previous.map(|previous| self.dof_map.full(previous)) {
            Some(previous) => self.solver.assemble_mixed(&self.at, &previous),
            None => self.solver.assemble(&self.at),
        };
        let tangent = tangent.ok()?;
        if tangent.rows.len() != self.entries {
            self.factor = IndefiniteFactor::new(&tangent).ok()?;
            self.entries = tangent.rows.len();
            self.factorised.full_index = tangent.full_index.to_vec();
        }
        self.factor.compute(&tangent).ok()?;
        Some(self.factor.negative_eigenvalues())
    }

    fn solve(&mut self, x: &mut [f64]) {
        let mut ordered = self.factorised.gather_dofs(&self.dof_map.full(x));
        self.factor.solve(&mut ordered);
        x.copy_from_slice(&self.dof_map.gather_dofs(&self.factorised.full(&ordered)));
    }
}

/// # Errors
/// [`ContinuationError`] when there is not one pressure per chamber, or a chamber is sealed.
fn check_fed(system: &System, solver: &Solver, pressures: &[Pascal]) -> Result<(), ContinuationError> {
    let expansion: Vec<f64> = system.mesh().nodes.iter().flat_map(|node| node.map(|x| PROBE * x)).collect();
    solver.residual(&expansion, pressures)?;
    for (chamber, &pressure) in pressures.iter().enumerate() {
        if solver.chamber_pressure(chamber, &expansion, pressures)? != pressure {
            let what = format!("chamber {chamber} is sealed");
            return Err(ContinuationError::Load { what, why: "a path is followed under pressures that are fed" });
        }
    }
    Ok(())
}
