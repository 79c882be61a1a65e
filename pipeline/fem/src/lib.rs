//! Finite elements for soft bodies: statics and dynamics under chamber pressure, with gradients.
//!
//! A [`Mesh`] with [`RegionProperties`] and [`Clamps`] becomes a [`System`], checked once and then immutable: shape
//! gradients, sparsity, elimination order and the structure of the factor. Each thread takes a [`Solver`] from it, which
//! owns the numbers: `equilibrium` under given pressures, `adjoint` and `sensitivity` there, `march` through time.
//!
//! Stands on: `si`, `faer` (Cholesky), `nalgebra` (3 × 3 matrices). Never knows: a mesher, a file, a specimen.

mod algebra;
mod attached;
mod body;
pub mod boxes;
mod checks;
mod clamps;
mod descent;
mod energy;
mod forces;
mod gas;
mod given;
mod linear;
mod load;
mod loads;
pub mod material;
pub mod materials;
mod mesh;
mod motion;
mod options;
mod parameter;
mod parts;
mod projective;
mod reduced;
mod refusal;
mod region;
mod solver;
mod stall;
mod statics;
mod system;

pub use attached::Masses;
pub use clamps::Clamps;
pub use descent::search::Stall;
pub use forces::Forces;
pub use linear::LowerTriangle;
pub use material::Material;
pub use mesh::{Chamber, Elements, Faces, Mesh};
pub use motion::backward::Slope;
pub use motion::gather::MotionGradient;
pub use motion::march::{Adaptive, March, Scheme, State};
pub use motion::trajectory::Trajectory;
pub use options::Options;
pub use parameter::Parameter;
pub use projective::{Projective, ProjectiveError, ProjectiveSettings};
pub use reduced::{Around, Drive, Kept, Moment, Reduced, ReducedError, Reduction, Still};
pub use refusal::SetupError;
pub use region::RegionProperties;
pub use solver::Solver;
pub use stall::SolveError;
pub use statics::adjoint::{Gradient, RegionGradient};
pub use statics::equilibrium::{Equilibrium, StaticSettings};
pub use system::System;
