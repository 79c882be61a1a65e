//! The stages of the pipeline, in the order of the data.
//!
//! To add a stage: its file here, its record in `records/`, its line in [`ALL`], its section in `study.toml`.

mod amplitude;
mod assemble;
mod baselines;
mod calibration;
pub mod camera;
pub mod clock;
mod deviations;
mod direction;
mod discretisation;
mod drag;
mod example_frames;
mod findings;
mod fitting;
mod four_parameters;
mod gradients;
mod identify;
mod inflate;
pub mod load_cell;
mod loss_surface;
pub mod markers;
pub mod mesh;
mod mesh_sensitivity;
mod method_comparison;
mod optimal_actuation;
mod plateaus;
mod recovery;
pub(crate) mod reduce;
mod relaxation;
mod repeats;
mod simulation;
pub mod tank;
mod thrust;
pub mod track;
mod transfer;
mod validate;
mod walls;
pub mod wave;

use records::subject::Study;
use workflow::entry::{Entry, stage};

/// Every stage.
#[rustfmt::skip] // one line a stage, in the order of the data
pub const ALL: &[Entry<Study>] = &[
    stage::<mesh::Mesh>(),                          // two STL files                 → elements, chambers, marker points
    stage::<camera::Camera>(),                      // calibration film              → lens and camera pose
    stage::<track::Track>(),                        // film                          → marker tracks, px
    stage::<markers::Markers>(),                    // pixels                        → positions in the plane, m
    stage::<clock::Clock>(),                        // LED, logs, positions          → displacements and pressures on one clock
    stage::<load_cell::LoadCell>(),                 // hammer taps                   → transfer function of the fixture
    stage::<tank::Tank>(),                          // water at rest                 → standing waves of the tank
    stage::<wave::Wave>(),                          // force log                     → force without waves and drift
    stage::<example_frames::Example>(),             // one film                      → two of its frames, dents of its silhouette
    stage::<identify::Identify>(),                  // quasi-static displacements    → Young's moduli with their covariance
    stage::<method_comparison::Comparison>(),       // the same pressure levels      → searches by every method, the loss between
    stage::<inflate::Inflate>(),                    // identified model              → its shapes under pressure
    stage::<four_parameters::FourParameters>(),     // the same pressure levels      → both moduli and both Poisson's ratios
    stage::<mesh_sensitivity::MeshSensitivity>(),   // the same pressure levels      → moduli on other meshes
    stage::<reduce::Reduce>(),                      // identified model              → hyper-reduced model (POD with empirical cubature)
    stage::<relaxation::Relaxation>(),              // transients in air             → relaxation of the silicone
    stage::<drag::Drag>(),                          // a release under water         → added mass and normal drag
    stage::<validate::Validate>(),                  // validation trials             → error of the prediction
    stage::<thrust::Thrust>(),                      // motion, pressure, force       → thrust models
    stage::<transfer::Transfer>(),                  // runs of all tails             → thrust models on a held-out tail
    stage::<optimal_actuation::OptimalActuation>(), // reduced model, thrust models  → actuation of greatest mean thrust
    stage::<recovery::Recovery>(),                  // estimates, hidden truth       → errors of the estimates
    stage::<findings::Findings>(),                  // records                       → metrics that decide claims
    stage::<calibration::Calibration>(),            // errors over many specimens    → share of truths inside their intervals
];
