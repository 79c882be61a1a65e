//! Cubature: which quadrature points of a region speak for all of them, and with what weight.
//!
//! Each point's work on each mode at each shape makes a column; a few columns with weights ≥ 0 must add up to the sum of
//! all. Weights that are not negative keep the reduced energy bounded below, as the whole body's is. [hernandez2017]
//!
//! Stands on: `parts`, `nonnegative`. Never knows: a mass, a pressure.

use nalgebra::{DMatrix, DVector};

use super::forces::{Points, Slopes, deformation};
use super::nonnegative::{self, Columns};
use crate::body::assembly::Elastic;
use crate::given::Given;
use crate::mesh::Elements;
use crate::parts::Parts;

/// Forces of shapes weaker than this share of the strongest are held to the same absolute error.
const FAINT: f64 = 0.05;

/// The points of each region.
#[allow(non_snake_case)]
pub(super) fn choose(parts: &Parts, modes: &DMatrix<f64>, shapes: &[DVector<f64>], tolerance: f64) -> Vec<Points> {
    let elastic = Given::new(parts).elastic;
    let choose = |(region, elastic): (usize, &Elastic)| {
        let all = candidates(parts, modes, region);
        let mut works = works(&all, elastic, shapes);
        let weights = nonnegative::fit(&mut works, tolerance);
        let at = weights.into_iter().map(|(point, weight)| (weight * all[point].0, all[point].1.clone())).collect();
        Points { elastic: *elastic, at }
    };
    elastic.iter().enumerate().map(choose).collect()
}

/// Every quadrature point of a region: its weight, m³, and G.
fn candidates(parts: &Parts, modes: &DMatrix<f64>, region: usize) -> Vec<(f64, Slopes)> {
    let mut all = Vec::new();
    for element in (0..parts.mesh.elements.len()).filter(|e| parts.mesh.regions[*e] as usize == region) {
        let nodes = match &parts.mesh.elements {
            Elements::Linear(tets) => &tets[element][..],
            Elements::Quadratic(tets) => &tets[element][..],
        };
        for point in element * parts.rest.points..(element + 1) * parts.rest.points {
            let gradients = &parts.rest.gradients[point * nodes.len()..(point + 1) * nodes.len()];
            all.push((parts.rest.weights[point], slopes(nodes, gradients, modes)));
        }
    }
    all
}

/// G: column m holds Σ_a V_a,m ⊗ ∇N_a.
fn slopes(nodes: &[u32], gradients: &[si::Point3], modes: &DMatrix<f64>) -> Slopes {
    let mut slopes = Slopes::zeros(modes.ncols());
    for (node, gradient) in nodes.iter().zip(gradients) {
        let rows = modes.rows(3 * *node as usize, 3);
        for (axis, slope) in gradient.iter().enumerate() {
            let mut part = slopes.rows_mut(3 * axis, 3);
            part += rows * *slope;
        }
    }
    slopes
}

/// (shapes × modes + 1) × points: the work of each point, shapes weighed alike, and its volume.
fn works(all: &[(f64, Slopes)], elastic: &Elastic, shapes: &[DVector<f64>]) -> Columns {
    let r = shapes[0].len();
    let rows = shapes.len() * r + 1;
    let mut columns = Columns::new(rows, all.len());
    for ((weight, slopes), column) in all.iter().zip(columns.each()) {
        for (q, part) in shapes.iter().zip(column.chunks_exact_mut(r)) {
            let (_, stress) = elastic.material.stress(&deformation(slopes, q), elastic.lame);
            for (work, along) in part.iter_mut().zip(slopes.column_iter()) {
                *work = (weight * stress.as_slice().iter().zip(along.iter()).map(|(p, g)| p * g).sum::<f64>()) as f32;
            }
        }
        column[rows - 1] = *weight as f32;
    }
    columns.weigh(&weights(&columns, r));
    columns
}

/// One a row: shapes count alike, however strong their forces; the volume counts as one shape does.
fn weights(columns: &Columns, r: usize) -> Vec<f32> {
    let sums = columns.sums();
    let (volume, works) = sums.split_last().expect("a column has its volume");
    let sizes: Vec<f64> = works.chunks_exact(r).map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt()).collect();
    let strongest = sizes.iter().fold(0.0, |most: f64, size| most.max(*size));
    let of_shape = |size: &f64| std::iter::repeat_n(1.0 / (size + FAINT * strongest), r);
    sizes.iter().flat_map(of_shape).chain([1.0 / volume]).map(|w| w as f32).collect()
}
