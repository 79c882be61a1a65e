//! Equilibrium paths u(λ) of nonlinear problems through limit points and bifurcations, by the arc-length method.
//!
//! [`follow`] advances along the solutions of r(u, λ) = 0 of a [`Problem`] in steps of an arc length and watches the
//! tangent K = ∂r/∂u: a change of its inertia says that a critical point was passed, which is then located, classified
//! as limit point or bifurcation, and reported with its mode ([`CriticalPoint`]). [`BodyProblem`] makes a problem of a
//! body of `fem` under chamber pressures and dead forces that grow with the load factor λ.
//!
//! ```
//! use continuation::{BodyLoad, BodyProblem, CriticalKind, PathSettings, follow};
//! use fem::{Clamps, Forces, RegionProperties, System, box_mesh, materials};
//!
//! // A clamped strip under a compressive force on its end, 100 × 10 × 2 mm: Euler's force is π² E I / 4 L² = 0.33 mN.
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = box_mesh::quadratic([0.1, 0.01, 0.002], [8, 2, 2]);
//! let clamps = Clamps::below_x(&mesh, 1e-9);
//! let material = materials::by_name("neo_hookean").ok_or("no such law")?;
//! let end = mesh.nodes.iter().position(|at| *at == [0.1, 0.005, 0.001]).ok_or("no node in the middle of the end")?;
//! let forces = Forces::none(&mesh).on_node(end as u32, [-5e-4, 0.0, 0.0])?.as_slice().to_vec();
//! let system = System::new(mesh, vec![RegionProperties::elastic(material, 2e5, 0.3, 1070.0)], clamps)?;
//!
//! let mut problem = BodyProblem::new(&system, system.solver(), BodyLoad { pressures: Vec::new(), forces })?;
//! let path = follow(&mut problem, &PathSettings::default(), &mut |_| {})?;
//! let buckled = &path.critical[0];
//! assert_eq!(buckled.kind, CriticalKind::Bifurcation);
//! assert!((5e-4 * buckled.load_factor - 3.3e-4).abs() < 0.2e-4);
//! # Ok(())
//! # }
//! ```
//!
//! Depends on `si`, `sparse` and `fem`; on `nalgebra` (small eigenproblems) and `thiserror`.

mod body;
mod branch;
mod constraint;
mod corrector;
mod critical;
mod error;
mod follow;
mod point;
mod problem;
mod segment;
mod settings;
mod subspace;

pub use body::{BodyLoad, BodyProblem, DofMap};
pub use error::{ContinuationError, StepFailure};
pub use follow::follow;
pub use point::{CriticalKind, CriticalPoint, Path, PathEnd, PathEvent, PathPoint};
pub use problem::Problem;
pub use settings::{Branch, PathSettings};
