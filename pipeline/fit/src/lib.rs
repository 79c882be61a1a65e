//! Fitting: finding the parameters with which a simulation agrees best with a measurement.
//!
//! [`optimiser`] says what an optimiser is (it asks for points, it is told their losses), `optimisers` holds one
//! file each and the list `ALL`, [`minimise()`] runs one of them over a problem and keeps every evaluation, and
//! [`least_squares`] turns residuals and their Jacobian into a step, [`weigh`] gives them one deviation each, and [`posterior`]
//! says how sure the parameters are.
//! Paper: section IV, system identification.
//!
//! [`network`] is the dense network that learns a number from many.
//!
//! Stands on: `si`, nalgebra, faer, safetensors. Never knows: a mesh, a material, a specimen, how a loss is computed.

pub mod bounds;
mod error;
pub mod least_squares;
pub mod minimise;
pub mod network;
pub mod optimiser;
pub mod optimisers;
pub mod posterior;
pub mod weigh;

pub use bounds::{Bounds, Search};
pub use error::FitError;
pub use least_squares::{Covariance, Residuals};
pub use minimise::{History, Problem, Tried, minimise};
pub use optimiser::{Evaluation, Finished, Needs, Optimiser};
pub use posterior::Direction;
pub use weigh::Weighing;
