//! Finite elements for soft bodies: statics and dynamics under chamber pressure, with gradients.
//!
//! A [`Mesh`] with [`RegionProperties`] and [`Clamps`] becomes a [`System`], checked once and then immutable: shape
//! gradients, sparsity, elimination order and the structure of the factor. Each thread takes a [`Solver`] from it, which
//! owns the numbers: `equilibrium` under given pressures, `adjoint` and `sensitivity` there, `march` through time.
//!
//! Stands on: `si`, `faer` (Cholesky), `nalgebra` (3 × 3 matrices). Never knows: a mesher, a file, a specimen.

mod adaptive;
mod adjoint;
mod assembly;
mod attached;
mod backward;
mod bordered;
pub mod boxes;
mod checks;
mod clamps;
mod creep;
mod dynamics;
mod elements;
mod factor;
mod forces;
mod forward;
mod gas;
mod given;
mod glide;
mod graph;
mod krylov;
mod linear;
mod load;
mod loads;
mod march;
mod mass;
pub mod material;
pub mod materials;
mod memory;
mod mesh;
mod newton;
mod options;
mod order;
mod parameter;
mod potential;
mod projective;
mod quadrature;
mod refusal;
mod rest;
mod search;
mod solver;
mod sparse;
mod statics;
mod stencil;
mod system;
mod tangent;
mod trajectory;
mod turn;
mod wear;

pub use adjoint::{Gradient, RegionGradient};
pub use attached::Masses;
pub use backward::{MotionGradient, Slope};
pub use clamps::Clamps;

pub use forces::Forces;
pub use linear::LowerTriangle;
pub use march::{Adaptive, March, Scheme, State};
pub use material::Material;
pub use mesh::{Chamber, Elements, Faces, Mesh};
pub use options::Options;
pub use parameter::Parameter;
pub use projective::{Projective, ProjectiveError, ProjectiveSettings};
pub use refusal::SetupError;
pub use search::Stall;
pub use solver::{SolveError, Solver};
pub use statics::{Equilibrium, StaticSettings};
pub use system::{RegionProperties, System};
pub use trajectory::Trajectory;
