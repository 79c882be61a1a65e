//! The story of the paper, in the order of the data.
//!
//! Stands on: the contract in `stage.rs` and its members. Never knows: a path, an order of running.
//! A new stage: its file, its record, its line in [`ALL`].

mod baselines;
mod best_flap;
pub(crate) mod camera;
mod certainty;
pub(crate) mod clock;
mod conclude;
mod damping;
mod drag;
mod findings;
mod fitting;
mod four_parameters;
mod gradients;
mod identify;
mod inflate;
mod landscape;
mod levels;
mod load_cell;
mod markers;
pub(crate) mod mesh;
mod mesh_honesty;
mod plateaus;
mod recovery;
mod reduce;
mod repeats;
mod softest;
mod still;
mod stop;
mod swing;
mod tank;
mod thrust;
pub(crate) mod track;
mod transfer;
mod validate;
mod walk;
mod wall;
mod wave;

use crate::entry::{Entry, stage};

/// Every stage.
pub const ALL: &[Entry] = &[
    stage::<mesh::Mesh>(),          // two STLs                    → tetrahedra, chambers, marker points
    stage::<camera::Camera>(),      // calibration video           → lens and plane
    stage::<track::Track>(),        // video                       → pixels
    stage::<markers::Markers>(),    // pixels                      → metres in the plane
    stage::<clock::Clock>(),        // lamp, logs, metres          → motion and pressure on one clock
    stage::<load_cell::LoadCell>(), // hammer taps               → how the load cell rings
    stage::<tank::Tank>(),          // still water                 → the tank's waves
    stage::<wave::Wave>(),          // force log                   → force without waves and drift
    stage::<still::Still>(),        // one film                    → two of its frames
    stage::<identify::Identify>(),  // quasi-static motion         → Young's moduli
    stage::<inflate::Inflate>(),    // the identified model        → its shapes under pressure
    stage::<four_parameters::FourParameters>(), // the same levels    → both moduli, both Poisson's ratios
    stage::<mesh_honesty::MeshHonesty>(), // the same levels       → moduli by other meshes
    stage::<reduce::Reduce>(),      // the identified model        → the same in a few dozen coordinates
    stage::<damping::Damping>(),    // a release               → how fast a swing dies
    stage::<drag::Drag>(),          // a release under water     → its added mass and drag
    stage::<validate::Validate>(),  // flapping never seen         → error of the prediction
    stage::<thrust::Thrust>(),      // motion, pressure, force     → models of thrust
    stage::<transfer::Transfer>(),  // all tails' runs             → models judged on a tail never seen
    stage::<best_flap::BestFlap>(), // the model, models of thrust → the flap of the most thrust
    stage::<findings::Findings>(),  // what was found              → what claims need
    stage::<recovery::Recovery>(),  // what was found, what was true → how close
];
