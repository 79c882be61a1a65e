//! Sparse linear algebra of one body: node graph, elimination order, Cholesky factor, and the methods that extend the
//! use of a factor beyond the matrix it was made of (preconditioned conjugate gradients, quasi-Newton updates,
//! Woodbury's formula).
//!
//! Vectors of this module hold the free degrees of freedom (dofs) in elimination order.

pub(crate) mod cholesky;
pub(crate) mod lbfgs;
pub(crate) mod nested_dissection;
pub(crate) mod node_graph;
pub(crate) mod pcg;
pub(crate) mod sparsity;
pub(crate) mod woodbury;

/// a · b, summed from the first entry to the last.
// One fixed order of summation: results must not depend on the number of threads.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// sum += scale · part, of equal length or an empty part.
pub(crate) fn add(sum: &mut [f64], scale: f64, part: &[f64]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += scale * part);
}

/// Largest absolute entry.
pub(crate) fn max_abs(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}
