//! Energy-conserving sampling and weighting (ECSW) [farhat2014]: hyper-reduction by an empirical cubature
//! [hernandez2017].
//!
//! The virtual work of each quadrature point along each mode at each snapshot makes one column of the training matrix;
//! a few columns with non-negative weights must reproduce the sum of all. Non-negative weights keep the reduced energy
//! bounded below, as that of the full model is; weights of either sign could make a stable body unstable. Errors count by the displacements that they
//! make (`compliance`).

use nalgebra::{DMatrix, DVector, SVector};
use rayon::prelude::*;
use si::CubicMetre;

use super::compliance::compliances;
use super::elastic_forces::{ModeGradient, Points, mode_deformation};
use super::model::Sampled;
use super::points::{mode_gradient, point_shares, points_of_region};
use super::training::TrainingShape;
use crate::assembly::elastic::Elastic;
use crate::inputs::Inputs;
use crate::system_data::SystemData;
use materials::material::{Material, Moduli};
use sparse::{NnlsColumns, add, nnls};

/// Weight of an error at a perturbation snapshot relative to one at a snapshot.
const PERTURBATION_WEIGHT: f64 = 0.1;

/// A shape counts at most as one whose forces move it so many times as far as those of the median snapshot. One along a single coordinate is of no
/// load and may have hardly any stiffness left: of a thin tail two moved thirty times as far as any snapshot, the tolerance was theirs, and of 86
/// snapshots 55 points met it, with which the walls had no stable equilibrium.
const SOFT: f64 = 10.0;

/// Of the quadrature points of a region about so many may be sampled.
// Neighbours do nearly the same work. From a quarter of the points of a tail the cubature had as many points, and took a tenth of the time.
const CANDIDATES: usize = 24_000;
/// Points whose virtual work is summed at once.
const CHUNK: usize = 512;

/// The sampled quadrature points of each region: number in the full model, and weight, m³.
pub(super) fn sample_points(
    system: &SystemData,
    modes: &DMatrix<f64>,
    snapshots: &[TrainingShape],
    tolerance: f64,
) -> Sampled {
    let elastic = Inputs::new(system).elastic;
    let moduli: Vec<Moduli> = elastic.iter().map(|elastic| elastic.moduli).collect();
    let perturbations = perturbations(snapshots).into_iter().map(|q| (q, moduli.clone()));
    let shapes: Vec<TrainingShape> = snapshots.iter().cloned().chain(perturbations).collect();
    let compliances = compliances(system, modes, &shapes);
    let sample = |(region, elastic): (usize, &Elastic)| {
        let of_region = |((q, moduli), compliance): (&TrainingShape, _)| (q.clone(), moduli[region], compliance);
        let training = Training {
            system,
            modes,
            material: elastic.material,
            shapes: shapes.iter().zip(&compliances).map(of_region).collect(),
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
    /// Coordinates, moduli and compliance of the snapshots, then of the perturbations.
    shapes: Vec<(DVector<f64>, Moduli, &'a DMatrix<f64>)>,
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
        for (q, moduli, compliance) in &self.shapes {
            let (_, stress) =
                self.material.energy_and_stress(&mode_deformation(&gradients, q), moduli.shared(shear, bulk));
            let stress = SVector::<f64, 9>::from_column_slice(stress.as_slice());
            work.extend((*compliance * (gradients.tr_mul(&stress) * weight)).iter());
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

    /// One weight per row: displacements of all snapshots count by their size, so do those of the perturbations, and the volume counts as much as
    /// the largest. Those above [`SOFT`] times the median count as if they were of that size.
    fn row_weights(&self, sums: &[f64]) -> Vec<f64> {
        let (volume, displacements) = sums.split_last().map_or((1.0, sums), |(volume, rest)| (*volume, rest));
        let r = self.modes.ncols();
        let size = |of_shape: &[f64]| of_shape.iter().map(|x| x * x).sum::<f64>().sqrt();
        let sizes: Vec<f64> = displacements.chunks_exact(r).map(size).collect();
        let limit = SOFT * median(&sizes[..self.snapshots]);
        let largest = sizes[..self.snapshots].iter().fold(f64::MIN_POSITIVE, |most, size| most.max(size.min(limit)));
        let weight = |(shape, size): (usize, &f64)| {
            let kind = if shape < self.snapshots { 1.0 } else { PERTURBATION_WEIGHT };
            kind / largest * (limit / size.max(limit))
        };
        let weights = sizes.iter().enumerate().flat_map(|shape| std::iter::repeat_n(weight(shape), r));
        weights.chain([1.0 / volume]).collect()
    }
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

/// 0 of none.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// Perturbation snapshots: along each coordinate alone, as far as the snapshots reach.
// Without them nothing determines the stiffness of coordinates that the snapshots excite little.
fn perturbations(snapshots: &[TrainingShape]) -> Vec<DVector<f64>> {
    let r = snapshots.first().map_or(0, |(q, _)| q.len());
    let far = |i: usize| snapshots.iter().fold(0.0, |greatest: f64, (q, _)| greatest.max(q[i].abs()));
    (0..r).map(|i| DVector::from_fn(r, |k, _| if k == i { far(i) } else { 0.0 })).collect()
}
