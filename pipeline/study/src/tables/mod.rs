//! The tables of the paper, in its order.
//!
//! Stands on: the contract in `table.rs` and its members. Never knows: a file name, a stage's code.
//! A new table: its file and its line in [`ALL`].

mod bench_realism;
mod best_flap;
mod cells;
mod instruments;
mod mesh_honesty;
mod methods;
mod optics;
mod prototypes;
mod recovery;
mod thrust_models;
mod trials;
mod validation;

use crate::entry::{Entry, table};

/// Every table.
pub const ALL: &[Entry] = &[
    table::<prototypes::Prototypes>(),
    table::<trials::Trials>(),
    table::<methods::Methods>(),
    table::<validation::Validation>(),
    table::<thrust_models::ThrustModels>(),
    table::<best_flap::BestFlap>(),
    table::<recovery::Recovery>(),
    table::<mesh_honesty::MeshHonesty>(),
    table::<bench_realism::BenchRealism>(),
    table::<optics::Optics>(),
];
