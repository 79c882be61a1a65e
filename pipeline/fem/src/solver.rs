//! Solvers: the public face of statics, dynamics and adjoints on one system. Each thread takes its own.

use crate::adjoint::dynamics::LossGradient;
use crate::adjoint::gradient::{Gradient, MotionGradient, RegionGradient};
use crate::adjoint::parameter::Parameter;
use crate::dynamics::settings::{InitialValueProblem, State, StepControl};
use crate::dynamics::trajectory::Trajectory;
use crate::loads::gas::Gas;
use crate::newton::iteration::Interrupt;
use crate::properties::RegionProperties;
use crate::setup_error::SetupError;
use crate::solve_error::SolveError;
use crate::solver_state::{SolverState, check_values};
use crate::statics::equilibrium::{Equilibrium, StaticSettings};
use crate::system_data::SystemData;
use crate::validation;
use materials::Relaxation;
use si::{KilogramPerCubicMetre, Metre, MetrePerSecondSquared, Pascal, Second};
use std::sync::Arc;

/// Solves one system. `Send`, so that each thread can have its own.
pub struct Solver {
    pub(crate) state: SolverState,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Solver").field("properties", &self.properties()).finish_non_exhaustive()
    }
}

/// Interruption.
impl Solver {
    /// Asks `interrupt` before every Newton iteration whether to end; a solve that ends fails with
    /// [`crate::NonConvergence::Interrupted`]. It must answer the same until that solve has returned.
    pub fn set_interrupt(&mut self, interrupt: Option<Interrupt>) {
        self.state.newton.interrupt = interrupt;
    }
}

/// Materials and loads.
impl Solver {
    pub(crate) fn new(data: Arc<SystemData>) -> Self {
        Self { state: SolverState::new(data) }
    }

    /// Current properties of the regions.
    pub fn properties(&self) -> &[RegionProperties] {
        &self.state.inputs.properties
    }

    /// Sets E (Pa) and ν of `region`. The last factor is kept and can still precondition a warm start.
    ///
    /// # Errors
    /// [`SetupError`] when there is no such region or the constants are out of range; nothing is then changed.
    pub fn set_elastic(
        &mut self,
        region: usize,
        youngs_modulus: Pascal,
        poissons_ratio: f64,
    ) -> Result<(), SetupError> {
        self.check_region(region)?;
        validation::check_elastic(region, youngs_modulus, poissons_ratio)?;
        let inputs = &mut self.state.inputs;
        inputs.properties[region].youngs_modulus = youngs_modulus;
        inputs.properties[region].poissons_ratio = poissons_ratio;
        inputs.elastic[region].moduli = inputs.properties[region].moduli();
        self.state.linearised = None;
        Ok(())
    }

    /// Sets C₂₀/C₁₀ and C₃₀/C₁₀ of `region`; without effect on laws that do not stiffen.
    ///
    /// # Errors
    /// As [`Solver::set_elastic`].
    pub fn set_stiffening(&mut self, region: usize, ratios: [f64; 2]) -> Result<(), SetupError> {
        self.check_region(region)?;
        validation::check_stiffening(region, ratios)?;
        let inputs = &mut self.state.inputs;
        inputs.properties[region].stiffening = ratios;
        inputs.elastic[region].moduli = inputs.properties[region].moduli();
        self.state.linearised = None;
        Ok(())
    }

    /// Multiplies the moduli of every element by its own of `factors` (one per element); an empty list stands for 1. E of
    /// an element is then its factor times that of its region.
    ///
    /// # Errors
    /// [`SetupError`] when there is not one positive number per element, or a region relaxes; nothing is then changed.
    pub fn set_element_factors(&mut self, factors: &[f64]) -> Result<(), SetupError> {
        validation::element_factors(&self.state.data.mesh, factors)?;
        let relaxations: Vec<&Relaxation> = self.properties().iter().map(|region| &region.relaxation).collect();
        validation::element_factors_relax(factors, &relaxations)?;
        self.state.inputs.factors = factors.to_vec();
        self.state.linearised = None;
        Ok(())
    }

    /// Sets the relaxation of `region`; it acts in motions, quasi-static ones included. An equilibrium is that of long
    /// times.
    ///
    /// # Errors
    /// [`SetupError`] when there is no such region, or its law is not objective.
    pub fn set_relaxation(&mut self, region: usize, relaxation: Relaxation) -> Result<(), SetupError> {
        self.check_region(region)?;
        validation::check_relaxation(region, self.properties()[region].material, &relaxation)?;
        validation::element_factors_relax(&self.state.inputs.factors, &[&relaxation])?;
        self.state.inputs.properties[region].relaxation = relaxation;
        Ok(())
    }

    /// Sets the density of `region`.
    ///
    /// # Errors
    /// As [`Solver::set_elastic`].
    pub fn set_density(&mut self, region: usize, density: KilogramPerCubicMetre) -> Result<(), SetupError> {
        self.check_region(region)?;
        validation::check_density(region, density)?;
        let SolverState { data, inputs, linearised, .. } = &mut self.state;
        inputs.properties[region].density = density;
        inputs.update_mass(data);
        *linearised = None;
        Ok(())
    }

    /// Sets dead forces (3 entries per node, N), in addition to all pressures; an empty list removes them.
    ///
    /// # Errors
    /// [`SolveError`] when the list is neither empty nor 3 entries per node, or an entry is not finite.
    pub fn set_forces(&mut self, forces: &[f64]) -> Result<(), SolveError> {
        if !forces.is_empty() {
            self.state.check_field("a list of forces", forces)?;
        }
        self.state.inputs.forces = forces.to_vec();
        self.state.inputs.update_dead_forces();
        self.state.linearised = None;
        Ok(())
    }

    /// Prescribes `displacements` (3 entries per node, m) of constrained dofs, as of the grips of a testing machine; an empty list holds them at
    /// rest again. Load stepping moves them in proportion to the load; a motion holds them from its beginning on. The force on the body at a
    /// clamp is the sum of [`Solver::residual`] over its nodes.
    ///
    /// # Errors
    /// [`SolveError`] when the list is neither empty nor 3 entries per node, an entry is not finite, or one of a free dof is not zero.
    pub fn prescribe(&mut self, displacements: &[Metre]) -> Result<(), SolveError> {
        if !displacements.is_empty() {
            self.state.check_field("a list of prescribed displacements", displacements)?;
        }
        let axes = self.state.data.constrained.iter().flatten();
        if let Some((&value, _)) = displacements.iter().zip(axes).find(|(u, is_held)| **u != 0.0 && !**is_held) {
            let (what, range) = ("a prescribed displacement", "zero along an axis that no clamp holds");
            return Err(SolveError::Setting { what, value, range });
        }
        self.state.inputs.prescribed = displacements.to_vec();
        self.state.linearised = None;
        Ok(())
    }

    /// Sets the gravity that acts on the body and on the attached masses.
    ///
    /// # Errors
    /// [`SolveError`] when a component is not finite.
    pub fn set_gravity(&mut self, gravity: [MetrePerSecondSquared; 3]) -> Result<(), SolveError> {
        check_values("gravity", &gravity, 3)?;
        self.state.inputs.gravity = gravity;
        self.state.inputs.update_dead_forces();
        self.state.linearised = None;
        Ok(())
    }

    /// Seals `chamber` at this absolute ambient pressure, or opens it again (`None`).
    ///
    /// The pressure that is given for a sealed chamber is the gauge pressure of its gas at rest volume; from there it
    /// follows (p + pₐ) V₀ = (g + pₐ) V, see [`Solver::chamber_pressure`].
    ///
    /// # Errors
    /// [`SetupError`] when there is no such chamber, or the ambient pressure is not positive.
    pub fn set_sealed(&mut self, chamber: usize, ambient: Option<Pascal>) -> Result<(), SetupError> {
        let count = self.state.inputs.ambient.len();
        if chamber >= count {
            return Err(SetupError::NoSuchIndex { part: "chamber", index: chamber, count });
        }
        if let Some(ambient) = ambient.filter(|ambient| !(*ambient > 0.0 && *ambient < 1e8)) {
            return Err(SetupError::AmbientPressure { chamber, ambient });
        }
        self.state.inputs.ambient[chamber] = ambient;
        self.state.linearised = None;
        Ok(())
    }

    /// Gauge pressure in `chamber` at `displacement` (3 entries per node, m) when `pressures` are given, Pa.
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length, or there is no such chamber.
    pub fn chamber_pressure(
        &self,
        chamber: usize,
        displacement: &[f64],
        pressures: &[Pascal],
    ) -> Result<Pascal, SolveError> {
        self.state.check_field("a displacement", displacement)?;
        self.state.check_pressures(pressures)?;
        if chamber >= pressures.len() {
            let (what, range) = ("a chamber number", "below the number of chambers");
            return Err(SolveError::Setting { what, value: chamber as f64, range });
        }
        let (pressure, ambient) = (pressures[chamber], self.state.inputs.ambient[chamber]);
        Ok(Gas { chamber: &self.state.data.chambers[chamber], pressure, ambient }.gauge_at(displacement))
    }

    fn check_region(&self, region: usize) -> Result<(), SetupError> {
        let count = self.properties().len();
        if region < count { Ok(()) } else { Err(SetupError::NoSuchIndex { part: "region", index: region, count }) }
    }
}

/// Statics.
impl Solver {
    /// The equilibrium under `pressures` (one per chamber, Pa) and the dead forces set before.
    ///
    /// `initial_guess`: a nearby displacement (3 entries per node, m), as of another pressure level or slightly other
    /// properties. Newton's method starts there with the whole load; without it, or when that fails, the load is
    /// applied in steps from rest.
    ///
    /// # Errors
    /// [`SolveError`]; `NoEquilibrium` holds the last converged state.
    pub fn equilibrium(
        &mut self,
        pressures: &[Pascal],
        initial_guess: Option<&[f64]>,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        let equilibrium = self.state.equilibrium(pressures, initial_guess, settings)?;
        self.state.keep_constant_tangent(&equilibrium);
        Ok(equilibrium)
    }

    /// The equilibrium near a shape `predicted` from several earlier ones, of which `nearby` is the nearest (3 entries per node, m), by
    /// Newton's method alone: for callers with a path of their own to fall back on.
    ///
    /// An interpolated shape stretches a stiff sheet where it rotates. The first tangent has the stress of `nearby` in place
    /// of the stress of that stretch.
    ///
    /// # Errors
    /// [`SolveError`]; `NoEquilibrium` where Newton's method does not converge.
    pub fn equilibrium_near(
        &mut self,
        pressures: &[Pascal],
        nearby: &[f64],
        predicted: &[f64],
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        self.state.equilibrium_near(pressures, nearby, predicted, settings)
    }

    /// ∂L/∂E, ∂L/∂ν and ∂L/∂ρ of every region by the adjoint method, from `dloss_du` = ∂L/∂u (3 entries per node, unit
    /// of L per m) at the equilibrium `at`.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable or a list has the wrong length.
    pub fn adjoint(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Vec<RegionGradient>, SolveError> {
        self.gradient(at, dloss_du).map(|gradient| gradient.regions)
    }

    /// As [`Solver::adjoint`], with ∂L/∂p of every chamber and ∂L/∂f of every dead force.
    ///
    /// # Errors
    /// As [`Solver::adjoint`].
    pub fn gradient(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Gradient, SolveError> {
        self.state.equilibrium_gradient(at, dloss_du)
    }

    /// du/dθ at the equilibrium `at` (forward sensitivity), 3 entries per node, m per unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable, or the parameter does not exist.
    pub fn sensitivity(&mut self, at: &Equilibrium, parameter: Parameter) -> Result<Vec<f64>, SolveError> {
        self.state.equilibrium_sensitivity(at, parameter)
    }

    /// Factorises the tangent at the equilibrium `at` before several sensitivities or adjoints of it, which then cost one solve each; without it
    /// each takes the iterations of PCG with the factor that Newton's method left, cheaper for one or two.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable, or a list has the wrong length.
    pub fn factorise_at(&mut self, at: &Equilibrium) -> Result<(), SolveError> {
        self.state.factorise_at(at)
    }

    /// Σ du/dθ δθ at the equilibrium `at` over the (θ, δθ) of `direction`, by one solve: 3 entries per node, m.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`].
    pub fn sensitivity_along(
        &mut self,
        at: &Equilibrium,
        direction: &[(Parameter, f64)],
    ) -> Result<Vec<f64>, SolveError> {
        self.state.equilibrium_sensitivity_along(at, direction)
    }

    /// du/dw at the equilibrium `at` where the nodes of the undeformed mesh move by w `velocity` (3 entries per node): 3 entries per node, m per
    /// unit of w.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable, a list has the wrong length, or the body has contact, mean dilatation or a sealed
    /// chamber.
    pub fn shape_sensitivity(&mut self, at: &Equilibrium, velocity: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.state.shape_sensitivity(at, velocity)
    }

    /// ∂L/∂w along each of `velocities` by the adjoint method, from `dloss_du` = ∂L/∂u at the equilibrium `at`; what L depends on the places of
    /// the nodes themselves is not part of it.
    ///
    /// # Errors
    /// As [`Solver::shape_sensitivity`].
    pub fn shape_gradient(
        &mut self,
        at: &Equilibrium,
        dloss_du: &[f64],
        velocities: &[&[f64]],
    ) -> Result<Vec<f64>, SolveError> {
        self.state.shape_gradient(at, dloss_du, velocities)
    }
}

/// Dynamics.
impl Solver {
    /// Integrates `problem` in time over `steps` steps of equal length; `observe` is called with each new state and its
    /// time. Returns the last state.
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length, a setting is out of range, or a step does not converge.
    pub fn integrate(
        &mut self,
        problem: &InitialValueProblem,
        steps: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<State, SolveError> {
        self.state.integrate(problem, steps, observe)
    }

    /// Integrates `problem` to the time `until` (s) with steps chosen by an error estimate; the step of its settings is
    /// not used.
    ///
    /// `observe` as in [`Solver::integrate`]. Returns the last state and the times of all states, s.
    ///
    /// # Errors
    /// As [`Solver::integrate`]; a step that does not converge is first repeated with a shorter one.
    pub fn integrate_adaptive(
        &mut self,
        problem: &InitialValueProblem,
        control: &StepControl,
        until: Second,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(State, Vec<Second>), SolveError> {
        self.state.integrate_adaptive(problem, control, until, observe)
    }

    /// As [`Solver::integrate`], and records the motion for replay and adjoint; its states take at most `memory` bytes.
    /// When they do not fit, checkpoints are stored and the states between are recomputed.
    ///
    /// # Errors
    /// As [`Solver::integrate`]; also when the checkpoints do not fit into `memory`.
    pub fn record(
        &mut self,
        problem: &InitialValueProblem,
        steps: usize,
        memory: usize,
    ) -> Result<Trajectory, SolveError> {
        let times = (0..=steps).map(|step| step as f64 * problem.settings.step).collect();
        self.record_at(problem, times, memory)
    }

    /// As [`Solver::record`], at given `times` (s, rising from 0), such as [`Solver::integrate_adaptive`] returns.
    ///
    /// # Errors
    /// As [`Solver::record`]; also when the times do not rise.
    pub fn record_at(
        &mut self,
        problem: &InitialValueProblem,
        times: Vec<Second>,
        memory: usize,
    ) -> Result<Trajectory, SolveError> {
        self.state.record_at(problem, times, memory, &mut |_, _| {})
    }

    /// As [`Solver::record`] within `memory`, and calls `observe` with each new state and its time.
    ///
    /// # Errors
    /// As [`Solver::record`].
    pub fn record_observed(
        &mut self,
        problem: &InitialValueProblem,
        steps: usize,
        memory: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<Trajectory, SolveError> {
        let times = (0..=steps).map(|step| step as f64 * problem.settings.step).collect();
        self.state.record_at(problem, times, memory, observe)
    }

    /// Calls `observe` with each state of a recorded motion, the initial one first.
    ///
    /// # Errors
    /// [`SolveError`] when a checkpoint segment cannot be recomputed: the properties are then not those of the
    /// recording.
    pub fn replay(
        &mut self,
        trajectory: &Trajectory,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(), SolveError> {
        self.state.replay(trajectory, observe)
    }

    /// The gradient of a loss of a recorded motion by the adjoint method. `loss_gradient` returns the derivative of the
    /// loss by the state after each step (numbered from 1; 0 is the initial state).
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length or the tangent of a step is not positive definite.
    pub fn trajectory_adjoint(
        &mut self,
        trajectory: &Trajectory,
        loss_gradient: &mut dyn FnMut(usize, &State) -> LossGradient,
    ) -> Result<MotionGradient, SolveError> {
        self.state.trajectory_adjoint(trajectory, loss_gradient)
    }

    /// du/dθ and dv/dθ (forward sensitivity) of every state of a recorded motion for each of `parameters`; `observe` is
    /// called with the number of the step (0 for the initial state) and one pair per parameter, 3 entries per node, per
    /// unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError`] when a parameter does not exist, or the tangent of a step is not positive definite.
    pub fn trajectory_sensitivity(
        &mut self,
        trajectory: &Trajectory,
        parameters: &[Parameter],
        observe: &mut dyn FnMut(usize, &[&State]),
    ) -> Result<(), SolveError> {
        self.state.trajectory_sensitivity(trajectory, parameters, observe)
    }
}
