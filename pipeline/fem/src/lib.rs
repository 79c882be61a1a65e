//! Finite elements for soft bodies: statics and dynamics under chamber pressure, with gradients.
//!
//! A [`Mesh`] with [`RegionProperties`] and [`Clamps`] becomes a [`System`], checked once and then immutable: shape
//! gradients, sparsity, elimination order and symbolic factor. Each thread takes a [`Solver`] from it, which owns the
//! numbers: `equilibrium` under given pressures, `adjoint` and `sensitivity` of that equilibrium, `march` through time.
//!
//! Stands on: `si`, `faer` (Cholesky factor), `nalgebra` (3 × 3 matrices). Never knows: a mesher, a file, a specimen.

mod clamps;
pub mod material;
pub mod materials;
mod mesh;
mod published;

pub use clamps::Clamps;
pub use material::Material;
pub use mesh::{Chamber, Elements, Faces, Mesh};
pub use published::*;
