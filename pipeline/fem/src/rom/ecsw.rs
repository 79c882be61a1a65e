//! Energy-conserving sampling and weighting (ECSW) [farhat2014]: hyper-reduction by an empirical cubature
//! [hernandez2017].
//!
//! The virtual work of each quadrature point along each mode at each snapshot makes one column of the training matrix;
//! a few columns with non-negative weights must reproduce the sum of all. Non-negative weights keep the reduced energy
//! bounded below, as that of the full model is; weights of either sign could make a stable body unstable.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use si::CubicMetre;

use super::elastic_forces::{ModeGradient, Points, deformation};
use super::model::Sampled;
use crate::assembly::elastic::Elastic;
use crate::inputs::Inputs;
use crate::system_data::SystemData;
use sparse::{NnlsColumns, nnls};

/// Forces of snapshots below this fraction of the largest force are matched to the same absolute error.
const WEAK: f64 = 0.05;
/// Weight of an error at a perturbation snapshot relative to one at a snapshot.
const PERTURBATION_WEIGHT: f64 = 0.1;

/// The sampled quadrature points of each region: number in the full model, and weight, m³.
pub(super) fn sample(system: &SystemData, modes: &DMatrix<f64>, snapshots: &[DVector<f64>], tolerance: f64) -> Sampled {
    let elastic = Inputs::new(system).elastic;
    let perturbations = perturbations(snapshots);
    let sample = |(region, elastic): (usize, &Elastic)| {
        let numbers = points_of_region(system, region);
        let candidate = |&point: &u32| Candidate {
            weight: system.reference.weights[point as usize],
            gradients: mode_gradient(system, point, modes),
            shares: shares(system, point),
        };
        let all: Vec<Candidate> = numbers.iter().map(candidate).collect();
        let mut training = training_matrix(&all, elastic, snapshots, &perturbations);
        let weights = nnls(&mut training, tolerance);
        weights.into_iter().map(|(point, weight)| (numbers[point], weight * all[point].weight)).collect()
    };
    elastic.iter().enumerate().map(sample).collect()
}

/// A quadrature point that may be sampled.
struct Candidate {
    weight: CubicMetre,
    gradients: ModeGradient,
    /// Of the μ and of the λ part of the energy.
    shares: [f64; 2],
}

/// The shares of the μ and λ parts of the energy that a quadrature point of the full model integrates.
fn shares(system: &SystemData, point: u32) -> [f64; 2] {
    system.reference.shares[point as usize % system.reference.points]
}

/// The sampled points with the gradients of the modes, region after region, those of equal shares together.
// A group has one law with one set of moduli, as a region of a model without shares: what steps a reduced model need not know of shares.
pub(super) fn points(system: &SystemData, modes: &DMatrix<f64>, sampled: &[Vec<(u32, CubicMetre)>]) -> Vec<Points> {
    let elastic = Inputs::new(system).elastic;
    let mut kinds: Vec<[f64; 2]> = Vec::new();
    for kind in &system.reference.shares {
        if !kinds.contains(kind) {
            kinds.push(*kind);
        }
    }
    let group = |region: usize, kind: [f64; 2]| {
        let inside = sampled[region].iter().filter(|(point, _)| shares(system, *point) == kind);
        let at: Vec<(f64, ModeGradient)> =
            inside.map(|&(point, weight)| (weight, mode_gradient(system, point, modes))).collect();
        let moduli = elastic[region].moduli.shared(kind[0], kind[1]);
        Points::new(region, Elastic { moduli, ..elastic[region] }, &at, modes.ncols())
    };
    (0..sampled.len())
        .flat_map(|region| kinds.iter().map(move |kind| (region, *kind)))
        .map(|(region, kind)| group(region, kind))
        // nothing of one set may be needed beside the other
        .filter(|points| kinds.len() == 1 || !points.weights().is_empty())
        .collect()
}

/// Every quadrature point of a region by its number in the full model.
fn points_of_region(system: &SystemData, region: usize) -> Vec<u32> {
    let inside = (0..system.mesh.elements.len()).filter(|e| system.mesh.regions[*e] as usize == region);
    inside
        .flat_map(|e| e * system.reference.points..(e + 1) * system.reference.points)
        .map(|point| point as u32)
        .collect()
}

/// G of a quadrature point: column m holds Σ_a V_a,m ⊗ ∇N_a.
fn mode_gradient(system: &SystemData, point: u32, modes: &DMatrix<f64>) -> ModeGradient {
    let (point, element) = (point as usize, point as usize / system.reference.points);
    let nodes = system.mesh.elements.nodes(element);
    let gradients = &system.reference.gradients[point * nodes.len()..(point + 1) * nodes.len()];
    let mut mode_gradient = ModeGradient::zeros(modes.ncols());
    for (node, gradient) in nodes.iter().zip(gradients) {
        let rows = modes.rows(3 * *node as usize, 3);
        for (axis, derivative) in gradient.iter().enumerate() {
            let mut part = mode_gradient.rows_mut(3 * axis, 3);
            part += rows * *derivative;
        }
    }
    mode_gradient
}

/// Perturbation snapshots: along each coordinate alone, as far as the snapshots reach.
// Without them nothing determines the stiffness of coordinates that the snapshots excite little.
fn perturbations(snapshots: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let r = snapshots[0].len();
    let far = |i: usize| snapshots.iter().fold(0.0, |most: f64, q| most.max(q[i].abs()));
    (0..r).map(|i| DVector::from_fn(r, |k, _| if k == i { far(i) } else { 0.0 })).collect()
}

/// Training matrix, ((snapshots + perturbations) × modes + 1) × points: the weighted virtual work of each point, and
/// its volume.
fn training_matrix(
    all: &[Candidate],
    elastic: &Elastic,
    snapshots: &[DVector<f64>],
    perturbations: &[DVector<f64>],
) -> NnlsColumns {
    let r = snapshots[0].len();
    let rows = (snapshots.len() + perturbations.len()) * r + 1;
    let mut columns = NnlsColumns::new(rows, all.len());
    all.par_iter().zip(columns.each()).for_each(|(Candidate { weight, gradients, shares: [shear, bulk] }, column)| {
        let moduli = elastic.moduli.shared(*shear, *bulk);
        for (q, part) in snapshots.iter().chain(perturbations).zip(column.chunks_exact_mut(r)) {
            let (_, stress) = elastic.material.stress(&deformation(gradients, q), moduli);
            for (work, along) in part.iter_mut().zip(gradients.column_iter()) {
                *work = (weight * stress.as_slice().iter().zip(along.iter()).map(|(p, g)| p * g).sum::<f64>()) as f32;
            }
        }
        // both sums of shares over an element are its volume
        column[rows - 1] = (0.5 * (shear + bulk) * weight) as f32;
    });
    columns.scale_rows(&row_weights(&columns, r, snapshots.len()));
    columns
}

/// One weight per row: all snapshots count alike whatever the size of their forces, so do all perturbations, and the
/// volume counts as much as a snapshot.
fn row_weights(columns: &NnlsColumns, r: usize, snapshots: usize) -> Vec<f32> {
    let sums = columns.sums();
    let (volume, work) = sums.split_last().expect("a column has its volume");
    let sizes: Vec<f64> = work.chunks_exact(r).map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt()).collect();
    let largest = sizes[..snapshots].iter().fold(0.0, |most: f64, size| most.max(*size));
    let row_weight = |(s, size): (usize, &f64)| {
        let (weak, weight) =
            if s < snapshots { (WEAK * largest, 1.0) } else { (f64::MIN_POSITIVE, PERTURBATION_WEIGHT) };
        std::iter::repeat_n(weight / (size + weak), r)
    };
    sizes.iter().enumerate().flat_map(row_weight).chain([1.0 / volume]).map(|w| w as f32).collect()
}
