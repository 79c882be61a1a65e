//! The records of the pipeline, one file each, in the order of the data; their subjects, and selections of them.
//!
//! A record is what a stage makes and what later stages, figures and tables read. It knows its files, its metrics and its summary, and nothing
//! of the stage.
//!
//! Depends on `si`, `diagnostics`, `lab`, `mesh`, `fem`, `track`, `signal`, `optimize`, `hydro`, `sysid`, `thrust` and `workflow`.

mod calibration;
mod camera;
mod cell;
mod corrected_force;
mod drag;
mod example_frames;
mod findings;
mod four_parameters;
mod identified;
mod inflation;
mod markers;
mod mesh;
mod mesh_sensitivity;
mod method_comparison;
mod motion;
mod optimal_actuation;
mod paths;
mod recovered;
mod reduced;
mod relaxation;
mod runs;
pub mod selections;
pub mod subject;
mod tank;
mod thrust;
mod tracks;
mod transfer;
mod validation;

pub use self::thrust::{Crosstalk, Means, Scored, Thrust, Trace};
pub use calibration::{Calibration, Coverage};
pub use camera::Camera;
pub use cell::{Fixture, LoadCell};
pub use corrected_force::CorrectedForce;
pub use drag::Drag;
pub use example_frames::{ExampleFrames, FrameData, HeldLevel};
pub use findings::{Finding, Findings};
pub use four_parameters::{Four, FourParameters};
pub use identified::{IdentificationDurations, Identified, Moduli, Stiffening};
pub use inflation::{Inflation, Shape};
pub use markers::{CovarianceParts, FilmPose, Markers, OmittedCorrection};
pub use mesh::{Cavity, Mesh, Quality};
pub use mesh_sensitivity::{Cells, MeshResult, MeshSensitivity};
pub use method_comparison::{EvaluatedPoint, MethodComparison, Search, Surface};
pub use motion::{Clock, Gauge, Motion};
pub use optimal_actuation::OptimalActuation;
pub use paths::Path;
pub use recovered::{Recovered, Specimen as RecoveredSpecimen, WallErrors};
pub use reduced::Reduced;
pub use relaxation::REPORTED;
pub use relaxation::Relaxation;
pub use sysid::estimate::{Estimate, Quantity, QuantityKind};
pub use sysid::uncertainty::{Profile, Uncertainty};
pub use sysid::{Covariance2, Level, NoiseModel};
pub use tank::{Tank, is_still_water};
pub use tracks::Tracks;
pub use transfer::{HeldOut, Layout, Transfer};
pub use validation::PAPER_MODEL;
pub use validation::{Interval, ScoredModel, Validation};

/// A file of a record that disagrees with another one, or with itself.
fn inconsistent_file(file: &str, cause: impl Into<String>) -> workflow::record::RecordError {
    workflow::record::RecordError::Scalars { file: file.into(), cause: cause.into() }
}

/// A subject's name inside a metric's id.
fn subject_id(subject: &str) -> String {
    subject.replace('/', "_")
}
