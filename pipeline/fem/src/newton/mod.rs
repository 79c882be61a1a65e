//! Newton's method for the potential of a body: potential, iteration, globalisation, and solves with its tangent.

pub(crate) mod iteration;
pub(crate) mod lagged_factor;
pub(crate) mod line_search;
pub(crate) mod options;
pub(crate) mod potential;
pub(crate) mod tangent_solve;
