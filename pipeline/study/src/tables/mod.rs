//! The tables of the paper, in its order.

mod bench_realism;
mod coverage;
mod ingredients;
mod instruments;
mod mesh_sensitivity;
mod methods;
mod optics;
mod optimal_actuation;
mod prototypes;
mod recovery;
mod thrust_models;
mod trials;
mod validation;
mod waveform_thrust;

use records::subject::Study;
use workflow::entry::{Entry, table};

/// Every table.
pub const ALL: &[Entry<Study>] = &[
    table::<prototypes::Prototypes>(),
    table::<trials::Trials>(),
    table::<methods::Methods>(),
    table::<ingredients::Ingredients>(),
    table::<validation::Validation>(),
    table::<thrust_models::ThrustModels>(),
    table::<optimal_actuation::OptimalActuation>(),
    table::<waveform_thrust::WaveformThrust>(),
    table::<recovery::Recovery>(),
    table::<coverage::Coverage>(),
    table::<mesh_sensitivity::MeshSensitivity>(),
    table::<bench_realism::BenchRealism>(),
    table::<optics::Optics>(),
];
