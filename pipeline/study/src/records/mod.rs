//! The records of the pipeline, one file each, in the order of the data.
//!
//! Stands on: the contract in `record.rs`. Never knows: how a record is computed.

mod camera;
mod identified;
mod markers;
mod mesh;
mod motion;
mod paths;
mod recovered;
mod tracks;
mod validation;
mod vtu;

pub use camera::Camera;
pub use identified::{Identified, Level, Point, Search, Surface, Tried};
pub use markers::{LeftOut, Markers, Parts};
pub use mesh::{Cavity, Mesh, Quality};
pub use motion::{Clock, Gauge, Motion};
pub use paths::{Path, Spread};
pub use recovered::{Recovered, Specimen as RecoveredSpecimen};
pub use tracks::Tracks;
pub use validation::Validation;
