//! A reduced tail that steps in real time: modes by proper orthogonal decomposition with empirical cubature (ECSW) \[farhat2014\],
//! \[hernandez2017\], relaxing silicone, chambers, and still water by slender-body theory, with nothing else of the simulator.
//!
//! [`TwinData`] holds the arrays; [`Twin`] lays them out for a processor's vectors and steps a [`TwinState`] by BDF2. [`file`](mod@file) reads and
//! writes them as safetensors. The equations are those of the reduced model in `fem`, to the tolerance of a step.
//! A [`Recording`] keeps a motion, whose derivatives [`Twin::adjoint`] gives; [`gradient_check`] compares them with differences.
//! [`package`] is the crate by itself, as it is exported.
//!
//! ```
//! use twin::{Chamber, Output, Region, Twin, TwinData};
//!
//! // one coordinate: a cube of rubber of 1 m³ that is stretched along x, and a chamber whose volume grows with it
//! let along_x = vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
//! let rubber = Region {
//!     name: "rubber".into(), mu: 1e5, lambda: 4e5, stiffening: [0.0; 2], branches: vec![], weights: vec![1.0], gradients: along_x
//! };
//! let air = Chamber {
//!     name: "air".into(), range: [0.0, 2e4], at_rest: 1.0, linear: vec![1.0], quadratic: vec![0.0], cubic: vec![0.0]
//! };
//! let stretch = Output { name: "end_x".into(), row: vec![1.0], at_rest: 1.0 };
//! let data = TwinData {
//!     mass: vec![10.0], size: 0.1, regions: vec![rubber], chambers: vec![air], sections: vec![], outputs: vec![stretch],
//!     half: false, provenance: vec![],
//! };
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

// Without them it would step at a third of its speed, and single-precision products would round otherwise.
#[cfg(all(
    target_arch = "x86_64",
    not(all(target_feature = "avx2", target_feature = "fma")),
    not(feature = "portable"),
    not(doc),
    not(doctest)
))]
compile_error!(
    "the crate `twin` is built with AVX2 and FMA: put `[target.'cfg(target_arch = \"x86_64\")']` and `rustflags = [\"-C\", \"target-cpu=x86-64-v3\"]` \
     into .cargo/config.toml of your workspace, or set RUSTFLAGS=\"-C target-cpu=x86-64-v3\"; the feature `portable` takes any processor, at a third of the speed"
);

mod adjoint;
mod chambers;
mod check;
mod data;
mod data_sheet;
mod dense;
mod elastic;
mod equations;
mod error;
pub mod example;
pub mod file;
mod gradient;
pub mod gradient_check;
mod history;
mod lanes;
mod law;
mod layout;
mod metadata;
pub mod package;
mod recording;
mod saved_state;
mod single_precision;
mod solid_adjoint;
mod state;
mod step;
mod twin;
mod unpack;
mod water;
mod water_adjoint;
mod workspace;

pub use data::{Chamber, Output, Region, Section, TwinData};
pub use error::TwinError;
pub use gradient::{LossGradient, MotionGradient, RegionGradient};
pub use recording::Recording;
pub use state::{TwinState, Work};
pub use twin::Twin;

/// SCRIPT: the same in JavaScript, for a page. `Twin(buffer)` of the file's bytes has `start`, `step` and `output`.
pub const SCRIPT: &str = include_str!("twin.js");
