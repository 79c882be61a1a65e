//! The records of the pipeline, one file each, in the order of the data.
//!
//! Stands on: the contract in `record.rs`. Never knows: how a record is computed.

mod best_flap;
mod camera;
mod cell;
mod damping;
mod drag;
mod findings;
mod four_parameters;
mod identified;
mod inflation;
mod markers;
mod mesh;
mod mesh_honesty;
mod motion;
mod paths;
mod pull;
mod recovered;
mod reduced;
mod runs;
mod still;
mod tank;
mod thrust;
mod tracks;
mod transfer;
mod validation;
mod vtu;

pub use best_flap::{Best, BestFlap, Check, Flap};
pub use camera::Camera;
pub use cell::{Fixture, LoadCell, Shown};
pub use damping::Damping;
pub use drag::Drag;
pub use findings::{Finding, Findings};
pub use four_parameters::{Four, FourParameters};
pub use identified::{Certainty, Doubt, Identified, Level, Point, Profile, Search, Surface, Tried};
pub use inflation::{Inflation, Shape, Walls};
pub use markers::{LeftOut, Markers, Parts, Stand};
pub use mesh::{Cavity, Mesh, Quality};
pub use mesh_honesty::{Honest, MeshHonesty};
pub use motion::{Clock, Gauge, Motion};
pub use paths::{Path, Spread};
pub use pull::Pull;
pub use recovered::{Recovered, Specimen as RecoveredSpecimen};
pub use reduced::Reduced;
pub use still::{Seen, Still};
pub use tank::Tank;
pub use thrust::{Crosstalk, Means, Scored, Thrust, Trace};
pub use tracks::Tracks;
pub use transfer::{HeldOut, Transfer};
pub use validation::{Validation, Way};
