//! The global step: A = c M + Σ V (2μ + 3λ) GᵀG, the same along each axis, factorised once.
//!
//! A couples no two axes. Where two axes are held at the same nodes they share one scalar matrix and its factor.
//!
//! Stands on: `sparse`, `factor`, `mass`. Never knows: a displacement, a load.

use super::ProjectiveError;
use crate::algebra::factor::{Factor, Symbolic};
use crate::algebra::graph::Graph;
use crate::algebra::sparse::{HELD, Pattern};
use crate::body::assembly::Elastic;
use crate::body::mass::Mass;
use crate::clamps::Clamps;
use crate::parts::Parts;
use crate::system::places;
use nalgebra::Matrix3;
use si::vec3;

/// A⁻¹.
pub(crate) struct Global {
    matrices: Vec<Scalar>,
}

/// One scalar matrix and the axes along which it acts.
struct Scalar {
    symbolic: Symbolic,
    factor: Factor,
    /// For each axis, for each row of the matrix: the place in the body's own elimination order.
    axes: Vec<Vec<u32>>,
}

impl std::fmt::Debug for Global {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Global of {} scalar matrices", self.matrices.len())
    }
}

impl Global {
    /// From the weights of all regions and c = `rate`, 1/s².
    ///
    /// # Errors
    /// [`ProjectiveError::NoFactor`]
    pub fn new(parts: &Parts, elastic: &[Elastic], rate: f64) -> Result<Self, ProjectiveError> {
        let held = |axis: usize| -> Vec<bool> { parts.pattern.freedom.iter().map(|at| at[axis] == HELD).collect() };
        let mut found: Vec<(Vec<bool>, Vec<usize>)> = Vec::new();
        for axis in 0..3 {
            let held = held(axis);
            match found.iter_mut().find(|(other, _)| *other == held) {
                Some((_, axes)) => axes.push(axis),
                None if held.iter().all(|held| *held) => {}
                None => found.push((held, vec![axis])),
            }
        }
        let make = |(held, axes): &(Vec<bool>, Vec<usize>)| {
            scalar(parts, elastic, rate, held, axes).map_err(|why| ProjectiveError::NoFactor { axis: axes[0], why })
        };
        Ok(Self { matrices: found.iter().map(make).collect::<Result<_, _>>()? })
    }

    /// x ← A⁻¹ x, in the body's elimination order.
    pub fn solve(&mut self, x: &mut [f64]) {
        for Scalar { symbolic, factor, axes } in &mut self.matrices {
            for places in axes {
                let mut along: Vec<f64> = places.iter().map(|&at| x[at as usize]).collect();
                factor.solve(symbolic, &mut along);
                places.iter().zip(along).for_each(|(&at, value)| x[at as usize] = value);
            }
        }
    }
}

/// The matrix between the nodes that are not `held`, in the pattern of a body that moves along x alone.
fn scalar(parts: &Parts, elastic: &[Elastic], rate: f64, held: &[bool], axes: &[usize]) -> Result<Scalar, String> {
    let mesh = &parts.mesh;
    let mut clamps = Clamps::none();
    held.iter().enumerate().for_each(|(node, &held)| clamps.hold(node as u32, [held, true, true]));
    let pattern = Pattern::new(&mesh.nodes, &Graph::new(mesh.nodes.len(), &mesh.elements), &clamps);
    let places = places(mesh, &pattern);
    let mut values = vec![0.0; pattern.entries()];
    let densities: Vec<f64> = parts.regions.iter().map(|region| region.density).collect();
    Mass::new(mesh, &pattern, &places, &parts.overlaps, &densities, &parts.options.masses).add_to(rate, &mut values);
    add_projections(parts, elastic, &pattern, &places, &mut values);
    let symbolic = Symbolic::new(&pattern).map_err(|fault| fault.to_string())?;
    let mut factor = Factor::new(&symbolic);
    let probe = vec![1.0; pattern.freedoms()];
    factor.make(&symbolic, &pattern, &values, &probe).map_err(|fault| format!("{fault:?}"))?;
    let along = |axis: &usize| {
        let place = |&at: &u32| parts.pattern.freedom[at as usize / 3][*axis];
        pattern.origin.iter().map(place).collect()
    };
    Ok(Scalar { symbolic, factor, axes: axes.iter().map(along).collect() })
}

/// Adds V (2μ + 3λ) ∇N_a · ∇N_b of every element.
fn add_projections(parts: &Parts, elastic: &[Elastic], pattern: &Pattern, places: &[u32], values: &mut [f64]) {
    let mut place = places.iter();
    for (element, gradients) in parts.rest.gradients.chunks_exact(4).enumerate() {
        let lame = elastic[parts.mesh.regions[element] as usize].lame;
        let weight = parts.rest.weights[element] * (2.0 * lame.mu + 3.0 * lame.lambda);
        let nodes = parts.mesh.elements.nodes(element);
        for a in 0..4 {
            for b in 0..=a {
                let block = Matrix3::identity() * (weight * vec3::dot(gradients[a], gradients[b]));
                pattern.add(values, *place.next().unwrap_or(&HELD), (nodes[a], nodes[b]), &block);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::{by_name, turn_of};
    use crate::region::RegionProperties;
    use crate::system::System;
    use crate::{Clamps, boxes};

    /// F of an element.
    fn deformation(parts: &Parts, element: usize, u: &[f64]) -> Matrix3<f64> {
        let mut sum = Matrix3::identity();
        for (&node, gradient) in parts.mesh.elements.nodes(element).iter().zip(&parts.rest.gradients[4 * element..]) {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                sum[(i, j)] += u[3 * node as usize + i] * gradient[j];
            }
        }
        sum
    }

    #[test]
    #[allow(non_snake_case)]
    fn a_step_along_the_slope_is_the_minimum_with_all_projections_held() {
        let mesh = boxes::linear([0.03, 0.02, 0.01], [3, 2, 2]);
        let clamps =
            Clamps::below_x(&mesh, 1e-9).and(&Clamps::where_nodes(&mesh, [false, false, true], |at| at[2] < 1e-9));
        let material = by_name("corotated").unwrap();
        let region = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.4, density: 1e3 };
        let system = System::new(mesh, vec![region], clamps).unwrap();
        let (parts, solver) = (&system.parts, system.solver());
        let mut global = Global::new(parts, &solver.given.elastic, 0.0).unwrap();
        assert_eq!(global.matrices.len(), 2, "x and y share one");
        let bent: Vec<f64> = (0..3 * parts.mesh.nodes.len()).map(|at| 1e-3 * (0.9 * at as f64).sin()).collect();
        let u = solver.with_held_at_rest(&bent);
        let mut slope = vec![0.0; u.len()];
        solver.given.at_rest(parts, &[], 0.0).energy(&u, &mut slope);
        let (mut step, mut now, mut held) = (Vec::new(), Vec::new(), Vec::new());
        parts.pattern.gather(&slope, &mut step);
        global.solve(&mut step);
        parts.pattern.gather(&u, &mut now);
        // Σ V Gᵀ (2μ R + 3λ F' − (2μ + 3λ) I) with F' = F − (R : F − 3) R/3
        let mut pull = vec![0.0; u.len()];
        let lame = solver.given.elastic[0].lame;
        for element in 0..parts.mesh.elements.len() {
            let F = deformation(parts, element, &u);
            let R = turn_of(&F).unwrap();
            let near = F - R * ((R.dot(&F) - 3.0) / 3.0);
            let (turn, swell) = (2.0 * lame.mu, 3.0 * lame.lambda);
            let wanted = (R * turn + near * swell - Matrix3::identity() * (turn + swell)) * parts.rest.weights[element];
            for (a, &node) in parts.mesh.elements.nodes(element).iter().enumerate() {
                let gradient = nalgebra::Vector3::from(parts.rest.gradients[4 * element + a]);
                let force = wanted * gradient;
                (0..3).for_each(|axis| pull[3 * node as usize + axis] += force[axis]);
            }
        }
        parts.pattern.gather(&pull, &mut held);
        global.solve(&mut held);
        let far = now.iter().zip(&step).zip(&held).map(|((now, step), held)| (now - step - held).abs());
        assert!(far.fold(0.0, f64::max) < 1e-14);
        assert!(step.iter().any(|step| step.abs() > 1e-5), "it goes somewhere");
    }
}
