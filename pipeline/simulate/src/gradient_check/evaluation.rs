//! Evaluation of a case's loss for a gradient check, with tolerances tight enough for differences.

use fem::{
    DynamicSettings, Equilibrium, InitialValueProblem, LossGradient, MotionGradient, Parameter, RegionProperties,
    Relaxation, Solver, Springpot, State, StaticSettings, Trajectory,
};
use si::{Pascal, Second};

use super::loss::Loss;
use super::parameters::CaseParameter;
use crate::Body;
use crate::case::Case;
use diagnostics::{Diagnostic, Result};

/// Tolerances of equilibria and steps, relative to the body's size, for differences of 1e-6.
const AT_REST: f64 = 1e-12;
const IN_MOTION: f64 = 1e-11;
/// Bytes that a recorded motion may take.
const MEMORY: usize = 1 << 31;

/// A case, its body and its solution as it is.
pub(super) struct Evaluation<'a> {
    case: &'a Case,
    body: &'a Body<'a>,
    solver: Solver,
    steps: usize,
    solved: Solved,
    loss: Loss,
}

/// The solution as the case has it.
enum Solved {
    Rest(Box<Equilibrium>),
    Motion(Box<Trajectory>),
}

impl<'a> Evaluation<'a> {
    /// # Errors
    /// A [`Diagnostic`] when the case cannot be solved.
    pub fn new(case: &'a Case, body: &'a Body, steps: usize) -> Result<Self> {
        let solver = body.solver(case)?;
        let solved = Solved::Motion(Box::<Trajectory>::default());
        let mut evaluation = Self { case, body, solver, steps, solved, loss: Loss::around(&[]) };
        evaluation.solved = match case.dynamic {
            None => Solved::Rest(Box::new(evaluation.solve_rest(&evaluation.perturbed_pressures(None), None)?)),
            Some(_) => Solved::Motion(Box::new(evaluation.solve_motion(None)?)),
        };
        evaluation.loss = Loss::around(&evaluation.loss_shape()?);
        Ok(evaluation)
    }

    /// ∂L/∂θ of every parameter, by the adjoint and by forward sensitivities.
    pub fn derivatives(&mut self, parameters: &[CaseParameter]) -> Result<Vec<(f64, f64)>> {
        let Self { solver, solved, loss, .. } = self;
        match solved {
            Solved::Rest(at) => rest_derivatives(solver, at, &loss.slope(&at.displacement), parameters),
            Solved::Motion(made) => motion_derivatives(solver, made, loss, parameters),
        }
    }

    /// L with one parameter perturbed by `part` of its step.
    pub(crate) fn loss_at(&mut self, parameter: &CaseParameter, part: f64) -> Result<f64> {
        let value = parameter.value + part * parameter.turn;
        self.set_parameter(parameter.parameter, value)?;
        let shape = match &self.solved {
            Solved::Rest(at) => {
                let start = at.displacement.clone();
                self.solve_rest(&self.perturbed_pressures(Some((parameter.parameter, value))), Some(&start))
                    .map(|at| at.displacement)
            }
            Solved::Motion(_) => {
                self.solve_motion(Some((parameter.parameter, value))).and_then(|made| self.last_of(&made))
            }
        };
        self.set_parameter(parameter.parameter, parameter.value)?;
        Ok(self.loss.value(&shape?))
    }

    fn set_parameter(&mut self, parameter: Parameter, value: f64) -> Result<()> {
        let body = self.body;
        let is = |region: usize| &body.system.regions()[region];
        match parameter {
            Parameter::Stiffening { region, term } => {
                let mut ratios = is(region).stiffening;
                ratios[term] = value;
                self.solver.set_stiffening(region, ratios).map_err(Diagnostic::from)
            }
            _ if relaxing_region(parameter).is_some() => self.set_relaxation(parameter, value),
            Parameter::YoungsModulus(region) => {
                self.solver.set_elastic(region, value, is(region).poissons_ratio).map_err(Diagnostic::from)
            }
            Parameter::PoissonsRatio(region) => {
                self.solver.set_elastic(region, is(region).youngs_modulus, value).map_err(Diagnostic::from)
            }
            Parameter::Density(region) => self.solver.set_density(region, value).map_err(Diagnostic::from),
            Parameter::Force { node, axis } => {
                let mut forces = self.body.forces.clone();
                forces[3 * node + axis] = value;
                self.solver.set_forces(&forces).map_err(Diagnostic::from)
            }
            _ => Ok(()),
        }
    }

    /// Sets one number of a region's relaxation, the others being the case's.
    fn set_relaxation(&mut self, parameter: Parameter, value: f64) -> Result<()> {
        let region = relaxing_region(parameter).unwrap_or_default();
        let case_relaxation = &self.body.system.regions()[region].relaxation;
        let relaxation = match (parameter, case_relaxation.as_springpot()) {
            (Parameter::SpringpotStrength(_), Some(springpot)) => {
                Relaxation::springpot(Springpot { strength: value, ..springpot })
            }
            (Parameter::SpringpotExponent(_), Some(springpot)) => {
                Relaxation::springpot(Springpot { exponent: value, ..springpot })
            }
            _ => {
                let mut branches = case_relaxation.branches().to_vec();
                match parameter {
                    Parameter::RelaxationStrength { branch, .. } => branches[branch].strength = value,
                    Parameter::RelaxationTime { branch, .. } => branches[branch].time = value,
                    _ => {}
                }
                Relaxation::maxwell(&branches)
            }
        };
        self.solver.set_relaxation(region, relaxation?).map_err(Diagnostic::from)
    }

    /// Pressures of the last level, with one gain perturbed where requested.
    fn perturbed_pressures(&self, turned: Option<(Parameter, f64)>) -> Vec<Pascal> {
        let level = self.case.statics.as_ref().and_then(|set| set.levels.last().copied()).unwrap_or(1.0);
        let mut pressures = self.body.pressures(self.case, |chamber| chamber.pressure.at_level(level));
        perturb_gain(&mut pressures, turned);
        pressures
    }

    fn solve_rest(&mut self, pressures: &[Pascal], start: Option<&[f64]>) -> Result<Equilibrium> {
        let load_steps = self.case.statics.as_ref().map_or(3, |set| set.load_steps);
        let settings = StaticSettings { tolerance: AT_REST, load_steps, ..StaticSettings::default() };
        self.solver.equilibrium(pressures, start, &settings).map_err(Diagnostic::from)
    }

    fn solve_motion(&mut self, turned: Option<(Parameter, f64)>) -> Result<Trajectory> {
        let Some(set) = &self.case.dynamic else { return Ok(Trajectory::default()) };
        let value = |parameter: Parameter, case_value: f64| match turned {
            Some((of, value)) if of == parameter => value,
            _ => case_value,
        };
        let settings = DynamicSettings {
            step: set.step.or(set.adaptive.map(|bounds| bounds.longest)).unwrap_or(DynamicSettings::default().step),
            scheme: set.scheme.into(),
            mass_damping: value(Parameter::MassDamping, set.mass_damping),
            stiffness_damping: value(Parameter::StiffnessDamping, set.stiffness_damping),
            tolerance: IN_MOTION,
        };
        let beat = |time: Second| {
            let mut pressures = self.body.pressures(self.case, |chamber| chamber.pressure.value_at(time));
            perturb_gain(&mut pressures, turned);
            pressures
        };
        let rest_state = State::rest(self.body.solid.nodes().len());
        self.solver
            .record(
                &InitialValueProblem { settings: &settings, initial: &rest_state, pressures: &beat },
                self.steps,
                MEMORY,
            )
            .map_err(Diagnostic::from)
    }

    /// The shape that the loss is taken of.
    fn loss_shape(&mut self) -> Result<Vec<f64>> {
        match &self.solved {
            Solved::Rest(at) => Ok(at.displacement.clone()),
            Solved::Motion(trajectory) => {
                let trajectory = trajectory.clone();
                self.last_of(&trajectory)
            }
        }
    }

    fn last_of(&mut self, made: &Trajectory) -> Result<Vec<f64>> {
        let mut last = Vec::new();
        let mut see = |_: Second, state: &State| last.clone_from(&state.displacement);
        self.solver.replay(made, &mut see)?;
        Ok(last)
    }
}

/// The region whose relaxation has this parameter.
fn relaxing_region(parameter: Parameter) -> Option<usize> {
    match parameter {
        Parameter::RelaxationStrength { region, .. }
        | Parameter::RelaxationTime { region, .. }
        | Parameter::SpringpotStrength(region)
        | Parameter::SpringpotExponent(region) => Some(region),
        _ => None,
    }
}

/// Perturbs the gain of one chamber.
fn perturb_gain(pressures: &mut [Pascal], turned: Option<(Parameter, f64)>) {
    if let Some((Parameter::PressureGain(chamber), gain)) = turned {
        pressures[chamber] *= gain;
    }
}

fn rest_derivatives(
    solver: &mut Solver,
    at: &Equilibrium,
    slope: &[f64],
    parameters: &[CaseParameter],
) -> Result<Vec<(f64, f64)>> {
    let gradient = solver.gradient(at, slope)?;
    let mut derivatives = Vec::new();
    for parameter in parameters {
        let backward = match parameter.parameter {
            Parameter::YoungsModulus(region) => gradient.regions[region].youngs_modulus,
            Parameter::PoissonsRatio(region) => gradient.regions[region].poissons_ratio,
            Parameter::Density(region) => gradient.regions[region].density,
            Parameter::Stiffening { region, term } => gradient.regions[region].stiffening[term],
            Parameter::PressureGain(chamber) => gradient.pressures[chamber] * at.pressures[chamber],
            Parameter::Force { node, axis } => gradient.forces[3 * node + axis],
            _ => 0.0,
        };
        let change = solver.sensitivity(at, parameter.parameter)?;
        derivatives.push((backward, dot(&change, slope)));
    }
    Ok(derivatives)
}

fn motion_derivatives(
    solver: &mut Solver,
    trajectory: &Trajectory,
    loss: &Loss,
    parameters: &[CaseParameter],
) -> Result<Vec<(f64, f64)>> {
    let last = trajectory.steps();
    let mut slope = Vec::new();
    let mut asks = |n: usize, state: &State| {
        if n != last {
            return LossGradient::default();
        }
        slope = loss.slope(&state.displacement);
        LossGradient { displacement: slope.clone(), velocity: Vec::new() }
    };
    let gradient = solver.trajectory_adjoint(trajectory, &mut asks)?;
    let parameters: Vec<Parameter> = parameters.iter().map(|parameter| parameter.parameter).collect();
    let mut forward = vec![0.0; parameters.len()];
    let mut see = |n: usize, changes: &[&State]| {
        if n == last {
            forward.iter_mut().zip(changes).for_each(|(sum, change)| *sum = dot(&change.displacement, &slope));
        }
    };
    solver.trajectory_sensitivity(trajectory, &parameters, &mut see)?;
    let regions = solver.properties();
    let pair = |(parameter, forward): (&Parameter, f64)| (of_motion(&gradient, regions, *parameter), forward);
    Ok(parameters.iter().zip(forward).map(pair).collect())
}

fn of_motion(by: &MotionGradient, regions: &[RegionProperties], parameter: Parameter) -> f64 {
    let springpot = |region: usize, which: usize| {
        let by_strength: Vec<f64> = by.relaxation[region].iter().map(|by| by[0]).collect();
        regions[region].relaxation.springpot_gradient(&by_strength).map_or(0.0, |by| by[which])
    };
    match parameter {
        Parameter::Stiffening { region, term } => by.regions[region].stiffening[term],
        Parameter::RelaxationStrength { region, branch } => by.relaxation[region][branch][0],
        Parameter::RelaxationTime { region, branch } => by.relaxation[region][branch][1],
        Parameter::SpringpotStrength(region) => springpot(region, 0),
        Parameter::SpringpotExponent(region) => springpot(region, 1),
        Parameter::YoungsModulus(region) => by.regions[region].youngs_modulus,
        Parameter::PoissonsRatio(region) => by.regions[region].poissons_ratio,
        Parameter::Density(region) => by.regions[region].density,
        Parameter::PressureGain(chamber) => by.pressure_gains[chamber],
        Parameter::Force { node, axis } => by.forces[3 * node + axis],
        Parameter::MassDamping => by.mass_damping,
        Parameter::StiffnessDamping => by.stiffness_damping,
        _ => 0.0,
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
