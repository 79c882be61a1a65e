//! Cubature: which quadrature points of a region speak for all of them, and with what weight.
//!
//! Each point's work on each mode at each shape makes a column; a few columns with weights ≥ 0 must add up to the sum of
//! all. Weights that are not negative keep the reduced energy bounded below, as the whole body's is. [hernandez2017]
//!
//! Stands on: `parts`, `nonnegative`. Never knows: a mass, a pressure.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use si::CubicMetre;

use super::forces::{Points, Slopes, deformation};
use super::nonnegative::{self, Columns};
use crate::body::assembly::Elastic;
use crate::given::Given;
use crate::mesh::Elements;
use crate::parts::Parts;

/// Forces of shapes weaker than this share of the strongest are held to the same absolute error.
const FAINT: f64 = 0.05;
/// How much an error along a nudge counts against one of a shape.
const NUDGED: f64 = 0.1;

/// The chosen quadrature points of each region: number in the whole body, weight, m³.
pub(super) fn choose(
    parts: &Parts,
    modes: &DMatrix<f64>,
    shapes: &[DVector<f64>],
    tolerance: f64,
) -> Vec<Vec<(u32, CubicMetre)>> {
    let elastic = Given::new(parts).elastic;
    let nudges = nudges(shapes);
    let choose = |(region, elastic): (usize, &Elastic)| {
        let numbers = of_region(parts, region);
        let all: Vec<(CubicMetre, Slopes)> =
            numbers.iter().map(|&point| (parts.rest.weights[point as usize], slopes(parts, point, modes))).collect();
        let mut works = works(&all, elastic, shapes, &nudges);
        let weights = nonnegative::fit(&mut works, tolerance);
        weights.into_iter().map(|(point, weight)| (numbers[point], weight * all[point].0)).collect()
    };
    elastic.iter().enumerate().map(choose).collect()
}

/// The chosen points of each region, ready to push.
pub(super) fn points(parts: &Parts, modes: &DMatrix<f64>, chosen: &[Vec<(u32, CubicMetre)>]) -> Vec<Points> {
    let elastic = Given::new(parts).elastic;
    let points = |(elastic, chosen): (&Elastic, &Vec<(u32, CubicMetre)>)| {
        let at: Vec<(f64, Slopes)> =
            chosen.iter().map(|&(point, weight)| (weight, slopes(parts, point, modes))).collect();
        Points::new(*elastic, &at, modes.ncols())
    };
    elastic.iter().zip(chosen).map(points).collect()
}

/// Every quadrature point of a region by its number in the whole body.
fn of_region(parts: &Parts, region: usize) -> Vec<u32> {
    let inside = (0..parts.mesh.elements.len()).filter(|e| parts.mesh.regions[*e] as usize == region);
    inside.flat_map(|e| e * parts.rest.points..(e + 1) * parts.rest.points).map(|point| point as u32).collect()
}

/// G of a quadrature point: column m holds Σ_a V_a,m ⊗ ∇N_a.
fn slopes(parts: &Parts, point: u32, modes: &DMatrix<f64>) -> Slopes {
    let (point, element) = (point as usize, point as usize / parts.rest.points);
    let nodes = match &parts.mesh.elements {
        Elements::Linear(tets) => &tets[element][..],
        Elements::Quadratic(tets) => &tets[element][..],
    };
    let gradients = &parts.rest.gradients[point * nodes.len()..(point + 1) * nodes.len()];
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

/// Along each coordinate alone, as far as shapes go along it: what holds the stiffness of coordinates that shapes move little.
fn nudges(shapes: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let r = shapes[0].len();
    let far = |i: usize| shapes.iter().fold(0.0, |most: f64, q| most.max(q[i].abs()));
    (0..r).map(|i| DVector::from_fn(r, |k, _| if k == i { far(i) } else { 0.0 })).collect()
}

/// ((shapes + nudges) × modes + 1) × points: the work of each point, weighed, and its volume.
fn works(all: &[(f64, Slopes)], elastic: &Elastic, shapes: &[DVector<f64>], nudges: &[DVector<f64>]) -> Columns {
    let r = shapes[0].len();
    let rows = (shapes.len() + nudges.len()) * r + 1;
    let mut columns = Columns::new(rows, all.len());
    all.par_iter().zip(columns.each()).for_each(|((weight, slopes), column)| {
        for (q, part) in shapes.iter().chain(nudges).zip(column.chunks_exact_mut(r)) {
            let (_, stress) = elastic.material.stress(&deformation(slopes, q), elastic.lame);
            for (work, along) in part.iter_mut().zip(slopes.column_iter()) {
                *work = (weight * stress.as_slice().iter().zip(along.iter()).map(|(p, g)| p * g).sum::<f64>()) as f32;
            }
        }
        column[rows - 1] = *weight as f32;
    });
    columns.weigh(&weights(&columns, r, shapes.len()));
    columns
}

/// One a row: shapes count alike, however strong their forces; so do nudges, however faint theirs; the volume counts as one shape
/// does.
fn weights(columns: &Columns, r: usize, shapes: usize) -> Vec<f32> {
    let sums = columns.sums();
    let (volume, works) = sums.split_last().expect("a column has its volume");
    let sizes: Vec<f64> = works.chunks_exact(r).map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt()).collect();
    let strongest = sizes[..shapes].iter().fold(0.0, |most: f64, size| most.max(*size));
    let weight = |(s, size): (usize, &f64)| {
        let (faint, counts) = if s < shapes { (FAINT * strongest, 1.0) } else { (f64::MIN_POSITIVE, NUDGED) };
        std::iter::repeat_n(counts / (size + faint), r)
    };
    sizes.iter().enumerate().flat_map(weight).chain([1.0 / volume]).map(|w| w as f32).collect()
}
