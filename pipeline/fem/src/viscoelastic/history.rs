//! Histories: the shear stress of the last step and the overstress of each branch, at every relaxing quadrature point.

use crate::assembly::kernels::{deformation_of, displacement_gradient_of};
use crate::system_data::SystemData;
use materials::step::RegionStep;
use materials::symmetric::Symmetric;
use nalgebra::Matrix3;
use si::{CubicMetre, Point3};
use std::ops::Range;

/// S_μ / μ, then the overstress of each branch per unit of μ: point by point, in the order of the elements.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    pub(crate) tensors: Vec<Symmetric>,
}

/// One relaxing quadrature point.
pub(crate) struct Point<'a> {
    /// Its number among all points of the mesh.
    pub number: usize,
    pub region: usize,
    pub nodes: &'a [u32],
    /// Gradients of the shape functions, 1/m.
    pub gradients: &'a [Point3],
    /// Of the μ part of the energy, m³.
    pub weight: CubicMetre,
    /// Place of its tensors in a history.
    pub own: Range<usize>,
}

impl Point<'_> {
    /// F at displacement `u`, 3 entries per node, m.
    pub(crate) fn deformation(&self, u: &[f64]) -> Matrix3<f64> {
        deformation_of(self.nodes, self.gradients, u)
    }

    /// ∇u, alike.
    pub(crate) fn displacement_gradient(&self, u: &[f64]) -> Matrix3<f64> {
        displacement_gradient_of(self.nodes, self.gradients, u)
    }

    /// Adds `scale` P ∇N_a to the force on each node, 3 entries per node.
    pub(crate) fn add_force(&self, stress: &Matrix3<f64>, scale: f64, forces: &mut [f64]) {
        for (&node, gradient) in self.nodes.iter().zip(self.gradients) {
            for i in 0..3 {
                let row = (0..3).map(|axis| stress[(i, axis)] * gradient[axis]).sum::<f64>();
                forces[3 * node as usize + i] += scale * row;
            }
        }
    }
}

/// Calls `visit` with every quadrature point of a region that relaxes.
pub(crate) fn for_each_point(data: &SystemData, regions: &[RegionStep], mut visit: impl FnMut(&Point, &RegionStep)) {
    let (reference, each) = (&data.reference, data.mesh.elements.nodes_each());
    let mut end = 0;
    for (element, &region) in data.mesh.regions.iter().enumerate() {
        let (region, region_step) = (region as usize, &regions[region as usize]);
        if region_step.branches.is_empty() {
            continue;
        }
        let nodes = data.mesh.elements.nodes(element);
        for (point, shares) in reference.shares.iter().enumerate() {
            let number = element * reference.points + point;
            let gradients = &reference.gradients[number * each..(number + 1) * each];
            let own_range = end..end + 1 + region_step.branches.len();
            end = own_range.end;
            visit(
                &Point {
                    number,
                    region,
                    nodes,
                    gradients,
                    weight: reference.weights[number] * shares[0],
                    own: own_range,
                },
                region_step,
            );
        }
    }
}

impl History {
    /// Of a body that has been held at `u` for ever: nothing is left of any overstress.
    pub(crate) fn relaxed(data: &SystemData, regions: &[RegionStep], u: &[f64]) -> Self {
        let mut tensors = Vec::new();
        for_each_point(data, regions, |point, region| {
            tensors.push(region.stress(&point.deformation(u)));
            tensors.extend(region.branches.iter().map(|_| [0.0; 6]));
        });
        Self { tensors }
    }

    /// The history after a step that ends at `u`.
    pub(crate) fn advanced(&self, data: &SystemData, regions: &[RegionStep], u: &[f64]) -> Self {
        let mut next = self.clone();
        for_each_point(data, regions, |point, region| {
            region.advance_history(&mut next.tensors[point.own.clone()], region.stress(&point.deformation(u)));
        });
        next
    }

    /// The tensors of one point.
    pub(crate) fn of_point(&self, point: &Point) -> &[Symmetric] {
        &self.tensors[point.own.clone()]
    }
}

/// The step that a history takes: its regions, and the histories before and after it.
#[derive(Clone, Copy)]
pub(crate) struct HistoryStep<'a> {
    pub data: &'a SystemData,
    pub regions: &'a [RegionStep],
    pub before: &'a History,
    pub now: &'a History,
    /// Displacement at its end, 3 entries per node, m.
    pub displacement: &'a [f64],
}
