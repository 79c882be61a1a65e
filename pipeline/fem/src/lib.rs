//! Nonlinear finite elements for soft bodies with pressurised chambers: statics, dynamics, gradients and reduced-order
//! models.
//!
//! A [`Mesh`] of 4- or 10-node tetrahedra, or of 8- or 20-node hexahedra, with [`RegionProperties`] and [`Clamps`] becomes a [`System`], validated once
//! and then immutable: reference geometry, sparsity, elimination order and symbolic factorisation. Each thread takes a
//! [`Solver`] from it: [`Solver::equilibrium`] under given pressures (Newton's method with load stepping),
//! [`Solver::integrate`] in time (implicit Euler or BDF2), adjoint gradients and forward sensitivities of both.
//! [`System::reduce`] makes a [`ReducedModel`] (POD with hyper-reduction), [`Projective`] is projective dynamics for
//! comparison.
//!
//! All quantities are in SI units; vectors of nodal quantities hold 3 entries per node.
//!
//! ```
//! use fem::{Clamps, RegionProperties, StaticSettings, System, box_mesh, materials};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = box_mesh::quadratic([0.06, 0.01, 0.01], [6, 1, 1]);
//! let clamps = Clamps::below_x(&mesh, 1e-9);
//! let material = materials::by_name("neo_hookean").ok_or("no such law")?;
//! let silicone = RegionProperties::elastic(material, 2e5, 0.45, 1070.0);
//! let system = System::new(mesh, vec![silicone], clamps)?;
//!
//! let mut solver = system.solver();
//! solver.set_gravity([0.0, 0.0, -9.81])?;
//! let equilibrium = solver.equilibrium(&[], None, &StaticSettings::default())?;
//!
//! // The derivative of L = ½ |u|² by Young's modulus: a stiffer beam sags less.
//! let gradient = solver.adjoint(&equilibrium, &equilibrium.displacement)?;
//! assert!(gradient[0].youngs_modulus < 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! Depends on `si`, `sparse` and `materials`; on `faer` (matrix products), `nalgebra` (small dense matrices), `rayon` and `thiserror`.

mod adjoint;
mod assembly;
mod contact;
mod dynamics;
mod inputs;
mod loads;
mod mesh;
mod modes;
mod newton;
mod projective;
mod properties;
mod rom;
mod setup_error;
mod solve_error;
mod solver;
mod solver_state;
mod solver_tangent;
mod statics;
mod system;
mod system_data;
mod validation;
mod viscoelastic;

pub use adjoint::dynamics::LossGradient;
pub use adjoint::gradient::{Gradient, MotionGradient, RegionGradient};
pub use adjoint::parameter::Parameter;
pub use contact::Contact;
pub use dynamics::settings::{DynamicSettings, InitialValueProblem, Scheme, State, StepControl};
pub use dynamics::trajectory::Trajectory;
pub use loads::Forces;
pub use materials::{self, Branch, MAX_BRANCHES, Material, Relaxation, RelaxationError, Springpot, material};
pub use mesh::clamps::Clamps;
pub use mesh::{Chamber, Elements, Faces, Mesh};
pub use mesh::{box_mesh, wedges};
pub use modes::Mode;
pub use newton::iteration::Interrupt;
pub use newton::options::NonConvergence;
pub use projective::{Projective, ProjectiveError, ProjectiveSettings};
pub use properties::{Masses, Options, RegionProperties};
pub use rom::{
    Actuation, ExternalForce, NoForce, ReducedArrays, ReducedContact, ReducedEquilibrium, ReducedError, ReducedModel,
    ReducedModelData, ReducedMotion, ReducedRegion, ReducedSolver, ReducedState, ReducedStep, ReducedStepGradient,
    ReductionSettings, Snapshot, StepState,
};
pub use setup_error::SetupError;
pub use solve_error::SolveError;
pub use solver::Solver;
pub use sparse::{FactorError, LowerTriangle};
pub use statics::equilibrium::{Equilibrium, StaticSettings};
pub use statics::load_path::{LoadRamp, extrapolated};
pub use system::System;
