//! Sparse linear algebra of meshes: node graph, elimination order, Cholesky factor, indefinite factor with its inertia,
//! and the methods that extend the use of a factor beyond the matrix it was made of (preconditioned conjugate gradients,
//! quasi-Newton updates, Woodbury's formula); and non-negative least squares with few columns.
//!
//! Vectors of this crate hold the free degrees of freedom (dofs) in elimination order.
//!
//! ```
//! use sparse::{Factor, NodeGraph, Pattern, Symbolic};
//!
//! // Two nodes that share one element; the first is fixed along all axes.
//! let graph = NodeGraph::new(2, &[0, 1], 2);
//! let pattern = Pattern::new(&[[0.0; 3], [1.0, 0.0, 0.0]], &graph, &[[true; 3], [false; 3]]);
//! let symbolic = Symbolic::new(&pattern)?;
//! let mut values = vec![0.0; pattern.entries()];
//! (0..3).for_each(|column| values[pattern.columns[column] as usize] = 2.0);
//! let mut factor = Factor::new(&symbolic);
//! factor.compute(&symbolic, &pattern, &values, &[1.0; 3])?;
//! let mut x = [4.0, 6.0, 8.0];
//! factor.solve(&symbolic, &mut x);
//! assert!(x.iter().zip([2.0, 3.0, 4.0]).all(|(x, exact)| (x - exact).abs() < 1e-14));
//! # Ok::<(), sparse::FactorError>(())
//! ```
//!
//! Depends on `si`; on `faer` (factors), `nalgebra` (small dense matrices), `rayon` and `thiserror`.

mod cholesky;
mod indefinite;
mod lbfgs;
mod nested_dissection;
mod nnls;
mod node_graph;
mod pcg;
mod separator;
mod sparsity;
#[cfg(test)]
mod testing;
mod woodbury;

pub use cholesky::{Factor, FactorError, RESIDUAL_LIMIT, Symbolic};
pub use indefinite::IndefiniteFactor;
pub use lbfgs::LbfgsHistory;
pub use nnls::{NnlsColumns, nnls};
pub use node_graph::NodeGraph;
pub use pcg::{PcgOptions, conjugate_gradients};
pub use sparsity::{CONSTRAINED, LowerTriangle, Pattern};
pub use woodbury::RankOneUpdates;

/// a · b, summed from the first entry to the last.
// One fixed order of summation: results must not depend on the number of threads.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// sum += scale · part, of equal length or an empty part.
#[inline]
pub fn add(sum: &mut [f64], scale: f64, part: &[f64]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += scale * part);
}

/// Largest absolute entry.
#[inline]
pub fn max_abs(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()))
}
