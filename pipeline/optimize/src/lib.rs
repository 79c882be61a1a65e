//! Optimisation and estimation: optimisers behind one contract, least squares, and a small dense network.
//!
//! | module | holds |
//! |---|---|
//! | [`optimiser`], [`optimisers`] | the ask/tell contract; grid search, CMA-ES, Adam and Gauss–Newton, and the list `ALL` |
//! | [`minimise()`] | runs an optimiser on an objective and logs every evaluation |
//! | [`levenberg_marquardt`], [`linear`] | least squares in one call: nonlinear, linear, ridge, non-negative |
//! | [`least_squares`], [`whitening`], [`posterior`] | residuals with their Jacobian, their covariance, the parameters' posterior |
//! | [`coverage`] | how often truths lie inside stated intervals |
//! | [`network`] | a multilayer perceptron for scalar regression |
//!
//! An optimiser asks for points and is told their evaluations, so the caller decides where and in what order they are simulated:
//!
//! ```
//! use optimize::optimisers::gauss_newton::{GaussNewton, Settings};
//! use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals, minimise};
//!
//! let bounds = Bounds { low: vec![-2.0], high: vec![2.0] };
//! let problem = Problem::new(&["x"], vec![1.0], bounds)?;
//! let mut optimiser = GaussNewton::new(&problem, &Settings::default())?;
//! // the residual eˣ − 2
//! let evaluate = |at: &Vec<f64>| {
//!     let residuals = Residuals { values: vec![at[0].exp() - 2.0], jacobian: vec![at[0].exp()] };
//!     let loss = residuals.half_sum_of_squares();
//!     Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(at.clone(), loss) }
//! };
//! let log = minimise(&mut optimiser, &mut |batch: &[Vec<f64>], _: Needs| -> Result<_, OptimiseError> {
//!     Ok(batch.iter().map(evaluate).collect())
//! })?;
//! assert!((log.best.at[0] - 2.0_f64.ln()).abs() < 1e-6);
//! # Ok::<(), OptimiseError>(())
//! ```
//!
//! Depends on `si`, nalgebra, faer (products of the network) and safetensors. Paper, sections IV and V.

pub mod coverage;
mod error;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod linear;
pub mod minimise;
pub mod network;
pub mod optimiser;
pub mod optimisers;
pub mod posterior;
pub mod problem;
pub mod whitening;

pub use error::OptimiseError;
pub use least_squares::{Covariance, Residuals};
pub use minimise::{EvaluationLog, LogEntry, Objective, minimise};
pub use optimiser::{Evaluation, Finished, Needs, Optimiser};
pub use posterior::PrincipalAxis;
pub use problem::{Bounds, Problem};
pub use whitening::Whitening;
