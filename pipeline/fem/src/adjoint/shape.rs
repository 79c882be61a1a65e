//! Derivatives of an equilibrium by the shape of the undeformed body.
//!
//! A velocity field V moves the nodes of the mesh, X(w) = X + w V, at constant displacements u. With H = F − I and L = ∇V:
//! dF = −H L, d∇N_a = −Lᵀ ∇N_a and d(dV) = tr L dV, so that ∂f_a/∂w = Σ w (∂P : dF + tr L P − P Lᵀ) ∇N_a [haslinger2003, section 3.3].
//! A chamber's pressure depends on X + u alone; the weight follows the mass of each node.

use crate::assembly::mass::ShapeProducts;
use crate::loads::{Load, add_gravity};
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::Equilibrium;
use si::Point3;
use sparse::{add, dot};

/// Largest motion of a node in differences of polynomials, as a fraction of the body's size: their rounding is then 1e-11, and the cubic
/// term of a curved element's mass below that.
const DIFFERENCE: f64 = 1e-4;

impl SolverState {
    /// See [`crate::Solver::shape_sensitivity`].
    pub(crate) fn shape_sensitivity(&mut self, at: &Equilibrium, velocity: &[f64]) -> Result<Vec<f64>, SolveError> {
        let mut right = vec![0.0; at.displacement.len()];
        add(&mut right, -1.0, &self.shape_residual_derivative(at, velocity)?);
        self.solve_at(at, &right)
    }

    /// See [`crate::Solver::shape_gradient`].
    pub(crate) fn shape_gradient(
        &mut self,
        at: &Equilibrium,
        dloss_du: &[f64],
        velocities: &[&[f64]],
    ) -> Result<Vec<f64>, SolveError> {
        self.check_field("the derivative of the loss", dloss_du)?;
        let lambda = self.solve_at(at, dloss_du)?;
        velocities.iter().map(|velocity| Ok(-dot(&lambda, &self.shape_residual_derivative(at, velocity)?))).collect()
    }

    /// ∂r/∂w at fixed u, 3 entries per node, N per unit of w.
    fn shape_residual_derivative(&self, at: &Equilibrium, velocity: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_field("the velocity of the nodes", velocity)?;
        self.check_morphable()?;
        let mut derivative = vec![0.0; velocity.len()];
        self.inputs.body(&self.data).shape_derivative(&at.displacement, velocity, &mut derivative);
        let largest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        if largest > 0.0 {
            let step = DIFFERENCE * self.data.size / largest;
            self.add_pressure_derivative(at, (velocity, step), &mut derivative);
            self.add_weight_derivative((velocity, step), &mut derivative);
        }
        Ok(derivative)
    }

    /// # Errors
    /// [`SolveError::Setting`] where a part of the potential has no derivative by shape here.
    fn check_morphable(&self) -> Result<(), SolveError> {
        let refused = |what, range| Err(SolveError::Setting { what, value: 1.0, range });
        if self.data.contact.is_some() {
            return refused("contact in a derivative by shape", "0: solve without contact");
        }
        if self.inputs.elastic.iter().any(|elastic| elastic.mean_dilatation) {
            return refused("mean dilatation in a derivative by shape", "0: use quadratic elements without it");
        }
        if self.inputs.ambient.iter().any(Option::is_some) {
            return refused("a sealed chamber in a derivative by shape", "0: prescribe its pressure");
        }
        Ok(())
    }

    /// Adds that of the chambers.
    fn add_pressure_derivative(&self, at: &Equilibrium, (velocity, step): (&[f64], f64), derivative: &mut [f64]) {
        let moved =
            |part: f64| -> Vec<f64> { at.displacement.iter().zip(velocity).map(|(u, v)| u + part * v).collect() };
        // Forces of pressure are quadratic in the places of the nodes: a central difference is exact.
        let (above, below) = (moved(step), moved(-step));
        for (chamber, pressure) in self.data.chambers.iter().zip(&at.pressures).filter(|(_, p)| **p != 0.0) {
            chamber.add_gradient(&above, 0.5 * pressure / step, derivative);
            chamber.add_gradient(&below, -0.5 * pressure / step, derivative);
        }
    }

    /// Adds that of the weight.
    fn add_weight_derivative(&self, (velocity, step): (&[f64], f64), derivative: &mut [f64]) {
        if self.inputs.gravity == [0.0; 3] {
            return;
        }
        let mut nodal_mass = vec![0.0; self.data.mesh.nodes.len()];
        for side in [1.0, -1.0] {
            let mesh = crate::Mesh {
                nodes: moved_nodes(&self.data.mesh.nodes, velocity, side * step),
                ..self.data.mesh.clone()
            };
            let products = ShapeProducts::new(&mesh, self.data.options.lumped_mass);
            for (region, properties) in self.inputs.properties.iter().enumerate() {
                products.add_nodal_mass(&mesh, region, -side * 0.5 * properties.density / step, &mut nodal_mass);
            }
        }
        add_gravity(&nodal_mass, self.inputs.gravity, derivative);
    }
}

/// X + part V.
pub(crate) fn moved_nodes(nodes: &[Point3], velocity: &[f64], part: f64) -> Vec<Point3> {
    let moved = |(x, v): (&Point3, &[f64])| [0, 1, 2].map(|axis| x[axis] + part * v[axis]);
    nodes.iter().zip(velocity.chunks_exact(3)).map(moved).collect()
}
