//! The tables of the paper, in its order.
//!
//! Stands on: the contract in `table.rs` and its members. Never knows: a file name, a stage's code.
//! A new table: its file and its line in [`ALL`].

mod mesh_honesty;
mod methods;
mod optics;
mod thrust_models;
mod trials;

use crate::entry::{Entry, table};

/// Every table.
pub const ALL: &[Entry] = &[
    table::<methods::Methods>(),
    table::<mesh_honesty::MeshHonesty>(),
    table::<optics::Optics>(),
    table::<trials::Trials>(),
    table::<thrust_models::ThrustModels>(),
];
