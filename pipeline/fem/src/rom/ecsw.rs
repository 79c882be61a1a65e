//! Energy-conserving sampling and weighting (ECSW) [farhat2014]: hyper-reduction by an empirical cubature
//! [hernandez2017].
//!
//! The virtual work of each quadrature point along each mode at each snapshot makes one column of the training matrix;
//! a few columns with non-negative weights must reproduce the sum of all. Non-negative weights keep the reduced energy
//! bounded below, as that of the full model is; weights of either sign could make a stable body unstable.

use nalgebra::{DMatrix, DVector, SVector};
use rayon::prelude::*;
use si::CubicMetre;

use super::elastic_forces::{ModeGradient, Points, mode_deformation};
use super::model::Sampled;
use crate::assembly::elastic::Elastic;
use crate::inputs::Inputs;
use crate::system_data::SystemData;
use materials::material::{Material, Moduli};
use sparse::{NnlsColumns, add, nnls};

/// Forces of snapshots below this fraction of the largest force are matched to the same absolute error.
// Without the floor, snapshots near rest would ask for the same relative error of forces that hardly matter.
const WEAK: f64 = 0.05;
/// Weight of an error at a perturbation snapshot relative to one at a snapshot.
const PERTURBATION_WEIGHT: f64 = 0.1;

/// Of the quadrature points of a region about so many may be sampled.
// Neighbours do nearly the same work. From a quarter of the points of a tail the cubature had as many points, and took a tenth of the time.
const CANDIDATES: usize = 24_000;
/// Points whose virtual work is summed at once.
const CHUNK: usize = 512;

/// A shape at which the cubature must reproduce the forces: q, and the moduli of each region that acted.
pub(super) type TrainingShape = (DVector<f64>, Vec<Moduli>);

/// The sampled quadrature points of each region: number in the full model, and weight, m³.
pub(super) fn sample_points(
    system: &SystemData,
    modes: &DMatrix<f64>,
    snapshots: &[TrainingShape],
    tolerance: f64,
) -> Sampled {
    let elastic = Inputs::new(system).elastic;
    let perturbations = perturbations(snapshots);
    let sample = |(region, elastic): (usize, &Elastic)| {
        let shapes = snapshots.iter().map(|(q, moduli)| (q.clone(), moduli[region]));
        let shapes = shapes.chain(perturbations.iter().map(|q| (q.clone(), elastic.moduli)));
        let training = Training {
            system,
            modes,
            material: elastic.material,
            shapes: shapes.collect(),
            snapshots: snapshots.len(),
        };
        training.sample_region(&points_of_region(system, region), tolerance)
    };
    elastic.iter().enumerate().map(sample).collect()
}

/// What the cubature of one region is trained on.
struct Training<'a> {
    system: &'a SystemData,
    modes: &'a DMatrix<f64>,
    material: &'static dyn Material,
    /// Coordinates and moduli of the snapshots, then of the perturbations.
    shapes: Vec<(DVector<f64>, Moduli)>,
    snapshots: usize,
}

impl Training<'_> {
    /// Of the points `numbers` of the region those that are sampled, and their weights, m³.
    fn sample_region(&self, numbers: &[u32], tolerance: f64) -> Vec<(u32, CubicMetre)> {
        let sums = self.virtual_work_sums(numbers);
        let row_weights = self.row_weights(&sums);
        // one in so many, prime to the number of points in an element so that each of its places is among them
        let points_each = self.system.reference.points;
        let interval = (numbers.len() / CANDIDATES).max(1);
        let interval =
            (interval..).find(|interval| *interval == 1 || !points_each.is_multiple_of(*interval)).unwrap_or(1);
        let candidates: Vec<u32> = numbers.iter().copied().step_by(interval).collect();
        // Of the candidates alone and in single precision: columns of all points of a tail of thin walls took a
        // gigabyte, and their least squares eleven minutes.
        let mut columns = NnlsColumns::new(sums.len(), candidates.len());
        columns.columns_mut().zip(&candidates).for_each(|(column, &point)| {
            let work = self.virtual_work(point);
            column.iter_mut().zip(work.iter().zip(&row_weights)).for_each(|(value, (w, by))| *value = (w * by) as f32);
        });
        let target: Vec<f64> = sums.iter().zip(&row_weights).map(|(sum, by)| sum * by).collect();
        let weight = |(at, weight): (usize, f64)| {
            (candidates[at], weight * self.system.reference.weights[candidates[at] as usize])
        };
        nnls(&mut columns, &target, tolerance).into_iter().map(weight).collect()
    }

    /// The virtual work of a point along each mode at each shape, and its volume.
    fn virtual_work(&self, point: u32) -> Vec<f64> {
        let (weight, gradients) =
            (self.system.reference.weights[point as usize], mode_gradient(self.system, point, self.modes));
        let [shear, bulk] = point_shares(self.system, point);
        let mut work = Vec::with_capacity(self.row_count());
        for (q, moduli) in &self.shapes {
            let (_, stress) =
                self.material.energy_and_stress(&mode_deformation(&gradients, q), moduli.shared(shear, bulk));
            let stress = SVector::<f64, 9>::from_column_slice(stress.as_slice());
            work.extend((gradients.tr_mul(&stress) * weight).iter());
        }
        // both sums of shares over an element are its volume
        work.push(0.5 * (shear + bulk) * weight);
        work
    }

    fn row_count(&self) -> usize {
        self.shapes.len() * self.modes.ncols() + 1
    }

    /// The virtual work of all points; in the same order whatever the number of threads.
    fn virtual_work_sums(&self, numbers: &[u32]) -> Vec<f64> {
        let of_chunk = |chunk: &[u32]| {
            let mut sums = vec![0.0; self.row_count()];
            for &point in chunk {
                add(&mut sums, 1.0, &self.virtual_work(point));
            }
            sums
        };
        let parts: Vec<Vec<f64>> = numbers.par_chunks(CHUNK).map(of_chunk).collect();
        let mut sums = vec![0.0; self.row_count()];
        parts.iter().for_each(|part| add(&mut sums, 1.0, part));
        sums
    }

    /// One weight per row: all snapshots count alike whatever the size of their forces, so do all perturbations, and the volume counts as
    /// much as a snapshot.
    fn row_weights(&self, sums: &[f64]) -> Vec<f64> {
        let (volume, work) = sums.split_last().map_or((1.0, sums), |(volume, work)| (*volume, work));
        let r = self.modes.ncols();
        let sizes: Vec<f64> = work.chunks_exact(r).map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt()).collect();
        let largest = sizes[..self.snapshots].iter().fold(0.0, |most: f64, size| most.max(*size));
        let row_weight = |(shape, size): (usize, &f64)| {
            let is_snapshot = shape < self.snapshots;
            let (weak, weight) =
                if is_snapshot { (WEAK * largest, 1.0) } else { (f64::MIN_POSITIVE, PERTURBATION_WEIGHT) };
            std::iter::repeat_n(weight / (size + weak), r)
        };
        sizes.iter().enumerate().flat_map(row_weight).chain([1.0 / volume]).collect()
    }
}

/// The shares of the μ and λ parts of the energy that a quadrature point of the full model integrates.
fn point_shares(system: &SystemData, point: u32) -> [f64; 2] {
    system.reference.shares[point as usize % system.reference.points]
}

/// The sampled points with the gradients of the modes, region after region, those of equal shares together.
// A group has one law with one set of moduli, as a region of a model without shares: what steps a reduced model need not know of shares.
pub(super) fn point_groups(
    system: &SystemData,
    modes: &DMatrix<f64>,
    sampled: &[Vec<(u32, CubicMetre)>],
) -> Vec<Points> {
    let elastic = Inputs::new(system).elastic;
    let mut kinds: Vec<[f64; 2]> = Vec::new();
    for kind in &system.reference.shares {
        if !kinds.contains(kind) {
            kinds.push(*kind);
        }
    }
    let group = |region: usize, kind: [f64; 2]| {
        let inside = sampled[region].iter().filter(|(point, _)| point_shares(system, *point) == kind);
        let sampled_gradients: Vec<(f64, ModeGradient)> =
            inside.map(|&(point, weight)| (weight, mode_gradient(system, point, modes))).collect();
        Points::new((region, elastic[region]), kind, &sampled_gradients, modes.ncols())
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
fn perturbations(snapshots: &[TrainingShape]) -> Vec<DVector<f64>> {
    let r = snapshots.first().map_or(0, |(q, _)| q.len());
    let far = |i: usize| snapshots.iter().fold(0.0, |greatest: f64, (q, _)| greatest.max(q[i].abs()));
    (0..r).map(|i| DVector::from_fn(r, |k, _| if k == i { far(i) } else { 0.0 })).collect()
}
