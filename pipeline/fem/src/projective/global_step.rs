//! The global step: A = c M + Σ V (2μ + 3λ) GᵀG, the same along each axis, factorised once.
//!
//! A couples no two axes. Axes with the same constrained nodes share one scalar matrix and its factor.

use super::ProjectiveError;
use crate::assembly::elastic::Elastic;
use crate::assembly::mass::{Mass, MassAssembly};
use crate::system_data::{SystemData, block_positions};
use nalgebra::Matrix3;
use si::vec3;
use sparse::{CONSTRAINED, Factor, FactorError, Pattern, Symbolic};

/// A⁻¹.
pub(crate) struct GlobalStep {
    matrices: Vec<Scalar>,
}

/// One scalar matrix and the axes along which it acts.
struct Scalar {
    symbolic: Symbolic,
    factor: Factor,
    /// For each axis, for each row of the matrix: the row in the body's own elimination order.
    axes: Vec<Vec<u32>>,
}

impl std::fmt::Debug for GlobalStep {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "GlobalStep of {} scalar matrices", self.matrices.len())
    }
}

impl GlobalStep {
    /// From the elastic constants of all regions and c = `rate`, 1/s².
    ///
    /// # Errors
    /// [`ProjectiveError::Factor`]
    pub fn new(data: &SystemData, elastic: &[Elastic], rate: f64) -> Result<Self, ProjectiveError> {
        let constrained =
            |axis: usize| -> Vec<bool> { data.pattern.dof.iter().map(|dof| dof[axis] == CONSTRAINED).collect() };
        let mut groups: Vec<(Vec<bool>, Vec<usize>)> = Vec::new();
        for axis in 0..3 {
            let constrained = constrained(axis);
            match groups.iter_mut().find(|(other, _)| *other == constrained) {
                Some((_, axes)) => axes.push(axis),
                None if constrained.iter().all(|constrained| *constrained) => {}
                None => groups.push((constrained, vec![axis])),
            }
        }
        let assembly = GlobalMatrix { data, elastic, rate };
        let factorised = |(constrained, axes): &(Vec<bool>, Vec<usize>)| {
            assembly
                .factorised_matrix(constrained, axes)
                .map_err(|cause| ProjectiveError::Factor { axis: axes[0], cause })
        };
        Ok(Self { matrices: groups.iter().map(factorised).collect::<Result<_, _>>()? })
    }

    /// x ← A⁻¹ x, in the body's elimination order.
    pub fn solve(&mut self, x: &mut [f64]) {
        for Scalar { symbolic, factor, axes } in &mut self.matrices {
            for rows in axes {
                let mut right_side: Vec<f64> = rows.iter().map(|&at| x[at as usize]).collect();
                factor.solve(symbolic, &mut right_side);
                rows.iter().zip(right_side).for_each(|(&at, value)| x[at as usize] = value);
            }
        }
    }
}

/// The matrix A before it is assembled.
struct GlobalMatrix<'a> {
    data: &'a SystemData,
    elastic: &'a [Elastic],
    /// c, 1/s².
    rate: f64,
}

impl GlobalMatrix<'_> {
    /// The matrix between the nodes that are not `constrained`, in the pattern of a body that moves along x alone.
    fn factorised_matrix(&self, constrained: &[bool], axes: &[usize]) -> Result<Scalar, FactorError> {
        let (data, mesh) = (self.data, &self.data.mesh);
        let constrained: Vec<[bool; 3]> = constrained.iter().map(|&constrained| [constrained, true, true]).collect();
        let pattern = Pattern::new(&mesh.nodes, &mesh.graph(), &constrained);
        let block_positions = block_positions(mesh, &pattern);
        let assembly =
            MassAssembly { mesh, pattern: &pattern, block_positions: &block_positions, products: &data.products };
        let mut values = vec![0.0; pattern.entries()];
        let densities: Vec<f64> = data.regions.iter().map(|region| region.density).collect();
        Mass::new(&assembly, &densities, &data.options.masses).add_to(self.rate, &mut values);
        self.add_projections(&pattern, &block_positions, &mut values);
        let symbolic = Symbolic::new(&pattern)?;
        let mut factor = Factor::new(&symbolic);
        let probe = vec![1.0; pattern.dofs()];
        factor.compute(&symbolic, &pattern, &values, &probe)?;
        let rows = |axis: &usize| {
            let row = |&at: &u32| data.pattern.dof[at as usize / 3][*axis];
            pattern.full_index.iter().map(row).collect()
        };
        Ok(Scalar { symbolic, factor, axes: axes.iter().map(rows).collect() })
    }

    /// Adds V (2μ + 3λ) ∇N_a · ∇N_b of every element.
    fn add_projections(&self, pattern: &Pattern, block_positions: &[u32], values: &mut [f64]) {
        let data = self.data;
        let mut position = block_positions.iter();
        for (element, gradients) in data.reference.gradients.chunks_exact(4).enumerate() {
            let moduli = self.elastic[data.mesh.regions[element] as usize].moduli;
            let weight = data.reference.weights[element] * (2.0 * moduli.mu + 3.0 * moduli.lambda);
            let nodes = data.mesh.elements.nodes(element);
            for a in 0..4 {
                for b in 0..=a {
                    let block = Matrix3::identity() * (weight * vec3::dot(gradients[a], gradients[b]));
                    let position = *position.next().unwrap_or(&CONSTRAINED);
                    pattern.add(values, position, (nodes[a], nodes[b]), &block);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::properties::RegionProperties;
    use crate::system::System;
    use crate::{Clamps, box_mesh};
    use materials::{by_name, polar_rotation};

    /// F of an element.
    fn deformation(data: &SystemData, element: usize, u: &[f64]) -> Matrix3<f64> {
        let mut sum = Matrix3::identity();
        for (&node, gradient) in data.mesh.elements.nodes(element).iter().zip(&data.reference.gradients[4 * element..])
        {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                sum[(i, j)] += u[3 * node as usize + i] * gradient[j];
            }
        }
        sum
    }

    #[test]
    #[allow(non_snake_case)]
    fn a_step_along_the_preconditioned_gradient_is_the_minimum_with_fixed_projections() {
        let mesh = box_mesh::linear([0.03, 0.02, 0.01], [3, 2, 2]);
        let clamps =
            Clamps::below_x(&mesh, 1e-9).and(&Clamps::where_nodes(&mesh, [false, false, true], |at| at[2] < 1e-9));
        let material = by_name("corotated").unwrap();
        let region = RegionProperties::elastic(material, 2e5, 0.4, 1e3);
        let system = System::new(mesh, vec![region], clamps).unwrap();
        let (data, state) = (&system.data, system.solver().state);
        let mut global = GlobalStep::new(data, &state.inputs.elastic, 0.0).unwrap();
        assert_eq!(global.matrices.len(), 2, "x and y share one");
        let bent: Vec<f64> = (0..3 * data.mesh.nodes.len()).map(|at| 1e-3 * (0.9 * at as f64).sin()).collect();
        let u = state.with_constraints(&bent);
        let mut gradient_of_energy = vec![0.0; u.len()];
        state.inputs.at_rest(data, &[]).energy(&u, &mut gradient_of_energy);
        let mut step = data.pattern.gather(&gradient_of_energy);
        global.solve(&mut step);
        let now = data.pattern.gather(&u);
        // Σ V Gᵀ (2μ R + 3λ F' − (2μ + 3λ) I) with F' = F − (R : F − 3) R/3
        let mut projected = vec![0.0; u.len()];
        let moduli = state.inputs.elastic[0].moduli;
        for element in 0..data.mesh.elements.len() {
            let F = deformation(data, element, &u);
            let R = polar_rotation(&F).unwrap();
            let near = F - R * ((R.dot(&F) - 3.0) / 3.0);
            let (shear, volumetric) = (2.0 * moduli.mu, 3.0 * moduli.lambda);
            let target = (R * shear + near * volumetric - Matrix3::identity() * (shear + volumetric))
                * data.reference.weights[element];
            for (a, &node) in data.mesh.elements.nodes(element).iter().enumerate() {
                let gradient = nalgebra::Vector3::from(data.reference.gradients[4 * element + a]);
                let force = target * gradient;
                (0..3).for_each(|axis| projected[3 * node as usize + axis] += force[axis]);
            }
        }
        let mut minimum = data.pattern.gather(&projected);
        global.solve(&mut minimum);
        let far = now.iter().zip(&step).zip(&minimum).map(|((now, step), minimum)| (now - step - minimum).abs());
        assert!(far.fold(0.0, f64::max) < 1e-14);
        assert!(step.iter().any(|step| step.abs() > 1e-5), "the step is not zero");
    }
}
