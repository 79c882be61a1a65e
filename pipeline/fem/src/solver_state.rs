//! State of a solver: shared system data, inputs, and the numbers of Newton's method.
//!
//! The modules `statics`, `dynamics` and `adjoint` implement their methods on it; [`crate::Solver`] is its public face.

use crate::inputs::Inputs;
use crate::newton::iteration::Newton;
use crate::solve_error::SolveError;
use crate::statics::equilibrium::Equilibrium;
use crate::system_data::SystemData;
use materials::tangent::TangentKind;
use si::Pascal;
use sparse::FactorError;
use std::sync::Arc;

/// Walls that may touch soon are coupled as well: those that are outside the range of contact by so many times it.
// On a tail of 59 000 dofs that is folded, 25 000 pairs of nodes and a factor larger by 7 %; with a margin of 2, 96 000 and 59 %.
const MARGIN: f64 = 0.6;

/// Everything that one solver owns.
pub(crate) struct SolverState {
    pub data: Arc<SystemData>,
    pub inputs: Inputs,
    pub newton: Newton,
    /// The equilibrium whose exact tangent is in `newton.tangent`.
    pub linearised: Option<Equilibrium>,
}

impl std::fmt::Debug for SolverState {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("SolverState").field("properties", &self.inputs.properties).finish_non_exhaustive()
    }
}

impl SolverState {
    pub fn new(data: Arc<SystemData>) -> Self {
        let (inputs, newton) = (Inputs::new(&data), Newton::new(&data));
        Self { data, inputs, newton, linearised: None }
    }

    /// Couples the nodes of walls in contact at `u` in the tangent, and of those that are about to touch; whether that was new. Vectors in
    /// elimination order are then no longer valid.
    ///
    /// # Errors
    /// [`FactorError::Symbolic`]
    pub(crate) fn couple_contact(&mut self, u: &[f64]) -> Result<bool, FactorError> {
        let Some(contact) = &self.data.contact else { return Ok(false) };
        let coupled = |&(a, b): &(u32, u32)| self.data.pattern.block_position(a, b).is_some();
        if contact.couplings(u, 0.0).iter().all(coupled) {
            return Ok(false);
        }
        let further = contact.couplings(u, MARGIN * contact.range());
        let data = Arc::new(self.data.with_couplings(&further)?);
        let (interrupt, spent) = (self.newton.interrupt.take(), self.newton.spent);
        self.newton = Newton::new(&data);
        (self.newton.interrupt, self.newton.spent) = (interrupt, spent);
        self.linearised = None;
        self.data = data;
        self.inputs.update_mass(&self.data);
        Ok(true)
    }

    /// `to`, or as much of the straight way from `from` to it as takes no wall through another.
    pub(crate) fn admissible_shape(&self, from: &[f64], to: Vec<f64>) -> Vec<f64> {
        let Some(contact) = &self.data.contact else { return to };
        let step: Vec<f64> = to.iter().zip(from).map(|(to, from)| to - from).collect();
        match contact.admissible_part(from, &step) {
            1.0 => to,
            part => from.iter().zip(step).map(|(from, step)| from + part * step).collect(),
        }
    }

    /// # Errors
    /// [`SolveError`] when `values` do not have 3 entries per node, or one is not finite.
    pub(crate) fn check_field(&self, what: &'static str, values: &[f64]) -> Result<(), SolveError> {
        check_values(what, values, self.data.full_length())
    }

    /// # Errors
    /// [`SolveError`] when there is not one finite pressure per chamber, or a sealed chamber has none left.
    pub(crate) fn check_pressures(&self, pressures: &[Pascal]) -> Result<(), SolveError> {
        check_values("a list of pressures", pressures, self.data.chambers.len())?;
        for (&pressure, ambient) in pressures.iter().zip(&self.inputs.ambient) {
            if ambient.is_some_and(|ambient| pressure <= -ambient) {
                let (what, range) = ("the pressure of a sealed chamber", "above a vacuum");
                return Err(SolveError::Setting { what, value: pressure, range });
            }
        }
        Ok(())
    }

    /// The same displacement with zeros at constrained dofs.
    pub(crate) fn with_constraints(&self, displacement: &[f64]) -> Vec<f64> {
        let free = self.data.pattern.gather(displacement);
        self.data.pattern.scattered(&free, 1.0, displacement.len())
    }

    /// f(u) = ∂Ψ/∂u, 3 entries per node, N.
    pub(crate) fn elastic_forces(&self, u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; u.len()];
        self.inputs.body(&self.data).energy(u, &mut forces);
        forces
    }

    /// M x at free dofs, both 3 entries per node.
    pub(crate) fn mass_times(&self, x: &[f64]) -> Vec<f64> {
        let pattern = &self.data.pattern;
        let free = pattern.gather(x);
        let mut image = vec![0.0; free.len()];
        self.inputs.mass.multiply(pattern, &free, &mut image);
        pattern.scattered(&image, 1.0, x.len())
    }

    /// K_f(u) x at free dofs with the elastic stiffness K_f, both 3 entries per node; the assembled tangent is
    /// overwritten.
    pub(crate) fn elastic_stiffness_times(&mut self, u: &[f64], x: &[f64]) -> Vec<f64> {
        let Self { data, inputs, newton, .. } = self;
        newton.tangent.fill(0.0);
        inputs.body(data).stiffness(u, TangentKind::Exact, &mut newton.tangent);
        let free = data.pattern.gather(x);
        let mut image = vec![0.0; free.len()];
        data.pattern.multiply(&newton.tangent, &free, &mut image);
        data.pattern.scattered(&image, 1.0, x.len())
    }
}

/// # Errors
/// [`SolveError`] when `values` do not have the length `required`, or one is not finite.
pub(crate) fn check_values(what: &'static str, values: &[f64], required: usize) -> Result<(), SolveError> {
    if values.len() != required {
        return Err(SolveError::Length { what, given: values.len(), required });
    }
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(SolveError::NotFinite { what, value }),
        None => Ok(()),
    }
}
