//! Equilibria at several pressure levels, solved in parallel; initial guesses are kriged from earlier equilibria.

mod level;
mod part;
mod reduced;
mod solver;
pub(crate) mod statics;

pub use level::{Derivatives, PressureLevel, SimulatedLevel};
pub use reduced::SimulatedMesh;
pub use solver::LevelSolver;
