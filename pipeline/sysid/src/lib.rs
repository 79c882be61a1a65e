//! System identification: moduli, damping and their uncertainty from measured displacements.
//!
//! A [`Model`] is a meshed body with its materials and markers; a [`LevelSolver`] finds its equilibria at several pressure levels with
//! their derivatives; a [`Misfit`] compares them with measured displacements. [`Snapshots::reduce`] projects the identified model onto a few dozen
//! coordinates ([`ReducedBody`]), in which motions are integrated, such as those under measured pressures
//! ([`actuated`]). [`surfaces`] are those of a mesh for figures, [`silhouette`]s those of a tail as a camera sees it.
//! [`relaxation`] identifies the spectrum of the silicone from
//! transients; a [`joint_fit`] shares a material between free vibration, inflation and tensile tests; [`estimate`]s stand beside what they estimate, [`free_vibration`] a body that was held straight and released; [`inflation_test`] predicts one whose chamber is inflated, of
//! the material that another test identified.
//!
//! ```
//! // one marker at one pressure level, measured and simulated, m
//! let level = sysid::Level {
//!     trial: "static_left".into(),
//!     pressures_pa: vec![20e3, 0.0],
//!     rest_m: vec![[0.1, 0.0]],
//!     measured_m: vec![[-0.001, 0.010]],
//!     covariance_m2: vec![[1e-10, 0.0, 1e-10]],
//!     shared_m2: vec![[5e-11, 0.0, 5e-11]],
//!     simulated_m: vec![[-0.001, 0.012]],
//! };
//! assert!((level.largest_error() - 0.002).abs() < 1e-12);
//! ```
//!
//! Depends on `diagnostics`, `fem`, `hydro` (the centre line), `lab` (cards), `mesh`, `optimize`, `plot` (the figure of a free vibration test, surfaces of a mesh in figures), `si`, `signal`,
//! `simulate`, `twin`.

pub mod actuated;
mod body;
mod cells;
mod certified;
mod discrepancy;
pub mod discretisation;
pub mod estimate;
pub mod free_vibration;
mod identified_materials;
pub mod inflation_test;
mod interpolation;
pub mod joint_fit;
pub mod landscape;
mod lateral_loads;
mod levels;
mod load_path;
mod loss;
mod meshed;
mod metrics_file;
mod misfit;
mod model;
mod moduli_search;
mod noise;
mod reduced;
pub mod relaxation;
mod rigid;
mod search;
pub mod silhouette;
mod snapshots;
mod stepped;
mod stiffening;
mod stroke;
pub mod surfaces;
mod surrogate;
mod time_steps;
mod trained_box;
pub mod uncertainty;
mod wall_offset;

pub use body::{Body, Material};
pub use cells::count_cells;
pub use certified::{Certificate, Certified, CertifiedSearch, SearchDurations};
pub use discrepancy::Discrepancy;
pub use identified_materials::{IdentifiedMaterial, IdentifiedMaterials};
pub use levels::{Derivatives, LevelSolver, PressureLevel, SimulatedLevel, SimulatedMesh};
pub use loss::{Evaluated, Loss, SearchResult, WallGauge, statics};
pub use meshed::{Meshed, NamedRegion};
pub use misfit::Misfit;
pub use model::{Attached, BODY, Elastic, Model, Viscoelastic, by_node};
pub use moduli_search::{Minimum, ModuliSearch, SearchModel};
pub use noise::{Covariance2, Level, NoiseModel};
pub use reduced::{ForcedMotion, ReducedBody, even_times};
pub use search::{Interrupted, feasible_lower_bound};
pub use snapshots::{Reduction, Snapshots};
pub use stiffening::{Stiffened, StiffeningProblem, residuals_of};
pub use stroke::Stroke;
pub use time_steps::TimeSteps;
pub use trained_box::{TimedSearch, TrainedBox};
