//! A reduced tail that steps in real time: modes by proper orthogonal decomposition with empirical cubature (ECSW) [farhat2014],
//! [hernandez2017], relaxing silicone, chambers, and still water by slender-body theory, with nothing else of the simulator.
//!
//! [`TwinData`] holds the arrays; [`Twin`] lays them out for a processor's vectors and steps a [`TwinState`] by BDF2. [`file`] reads and
//! writes them as safetensors. The equations are those of the reduced model in `fem`, to the tolerance of a step.
//! A [`Recording`] keeps a motion, whose derivatives [`Twin::adjoint`] gives; [`gradient_check`] compares them with differences.
//! [`package`] is the crate by itself, as it is exported.
//!
//! ```
//! use twin::{Chamber, Region, Twin, TwinData};
//!
//! // one coordinate: a cube of rubber of 1 m³ that is stretched along x, and a chamber whose volume grows with it
//! let along_x = vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
//! let rubber = Region { mu: 1e5, lambda: 4e5, stiffening: [0.0; 2], branches: vec![], weights: vec![1.0], gradients: along_x };
//! let chamber = Chamber { at_rest: 1.0, linear: vec![1.0], quadratic: vec![0.0], cubic: vec![0.0] };
//! let outputs = vec![("stretch".to_owned(), vec![1.0])];
//! let data = TwinData { mass: vec![10.0], size: 0.1, regions: vec![rubber], chambers: vec![chamber], sections: vec![], outputs };
//! let twin = Twin::new(data)?;
//! let mut state = twin.start();
//! for _ in 0..20 {
//!     twin.step(&mut state, &[1e4], 1e-3)?;
//! }
//! assert!(twin.output(&state, 0) > 0.0);
//! # Ok::<(), twin::TwinError>(())
//! ```
//!
//! Depends on `safetensors`, `thiserror` and `wide` (vectors of eight numbers) alone.

mod adjoint;
mod chambers;
mod check;
mod data;
mod dense;
mod elastic;
mod error;
pub mod example;
pub mod file;
mod gradient;
pub mod gradient_check;
mod history;
mod lanes;
mod law;
mod layout;
pub mod package;
mod recording;
mod single_precision;
mod solid_adjoint;
mod state;
mod step;
mod unpack;
mod water;
mod water_adjoint;

pub use data::{Chamber, Region, Section, TwinData};
pub use error::TwinError;
pub use gradient::{LossGradient, MotionGradient, RegionGradient};
pub use recording::Recording;
pub use state::{TwinState, Work};
pub use step::Twin;

/// SCRIPT: the same in JavaScript, for a page. `Twin(buffer)` of the file's bytes has `start`, `step` and `output`.
pub const SCRIPT: &str = include_str!("twin.js");
