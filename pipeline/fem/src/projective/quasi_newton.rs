//! Local and global steps accelerated by L-BFGS with A⁻¹ as the initial inverse (quasi-Newton), for a step and for its
//! adjoint.
//!
//! In a step, a line search on the energy limits each iteration. In the adjoint the energy ½ zᵀKz − b · z is quadratic,
//! so that the optimal length of each iteration is known.        [liu2017], [du2021]

use super::global_step::GlobalStep;
use super::{ProjectiveError, ProjectiveSettings};
use crate::loads::Load;
use crate::newton::line_search::{LineSearch, MAX_TRIALS};
use crate::newton::potential::{Energy, Potential};
use sparse::{LbfgsHistory, dot};

/// Minimisation of one potential.
pub(crate) struct QuasiNewton<'a> {
    on: &'a Potential<'a>,
    global: &'a mut GlobalStep,
    history: LbfgsHistory,
}

/// Π and ∇Π at free dofs.
struct Iterate {
    energy: Energy,
    gradient: Vec<f64>,
}

impl<'a> QuasiNewton<'a> {
    pub fn new(on: &'a Potential<'a>, global: &'a mut GlobalStep) -> Self {
        Self { on, global, history: LbfgsHistory::default() }
    }

    /// Moves `u` (3 entries per node, m) to the minimum. The residual is relative to the forces at `start`; when `u` is
    /// inverted, the iteration starts at `start`. Returns the number of iterations.
    ///
    /// # Errors
    /// [`ProjectiveError`]
    pub fn minimise(
        mut self,
        u: &mut Vec<f64>,
        start: &[f64],
        settings: &ProjectiveSettings,
    ) -> Result<usize, ProjectiveError> {
        let size = size_of_forces(self.on, start);
        let mut iterate = self.iterate_at(u);
        if !iterate.energy.value.is_finite() {
            u.copy_from_slice(start);
            iterate = self.iterate_at(u);
        }
        if !iterate.energy.value.is_finite() {
            return Err(ProjectiveError::InvertedElement);
        }
        for iterations in 0..=settings.max_iterations {
            let residual = dot(&iterate.gradient, &iterate.gradient).sqrt();
            if residual <= settings.tolerance * size {
                return Ok(iterations);
            }
            if self.take_step(u, &mut iterate) {
                continue;
            }
            // The history may mislead; the plain global step is always a direction of descent.
            self.history.clear();
            if !self.take_step(u, &mut iterate) {
                return Err(ProjectiveError::LineSearchFailed { iterations, residual: residual / size });
            }
        }
        let residual = dot(&iterate.gradient, &iterate.gradient).sqrt() / size;
        Err(ProjectiveError::IterationLimit {
            residual,
            iterations: settings.max_iterations,
            tolerance: settings.tolerance,
        })
    }

    /// The local step: the projections of all elements enter through the gradient of the energy.
    fn iterate_at(&self, u: &[f64]) -> Iterate {
        let mut gradient = vec![0.0; u.len()];
        let energy = self.on.energy(u, &mut gradient);
        Iterate { energy, gradient: self.on.data.pattern.gather(&gradient) }
    }

    /// The global step with a line search; whether it lowered the energy.
    fn take_step(&mut self, u: &mut Vec<f64>, iterate: &mut Iterate) -> bool {
        let mut direction = iterate.gradient.clone();
        self.history.apply(&mut direction, |x| self.global.solve(x));
        direction.iter_mut().for_each(|entry| *entry = -*entry);
        let search = LineSearch { start: iterate.energy, slope: dot(&iterate.gradient, &direction) };
        if search.slope.is_nan() || search.slope >= 0.0 {
            return false;
        }
        let mut part = 1.0;
        for _ in 0..MAX_TRIALS {
            let mut trial = u.clone();
            self.on.data.pattern.scatter(&direction, part, &mut trial);
            let next = self.iterate_at(&trial);
            if search.accepts(part, next.energy, dot(&next.gradient, &direction)) {
                direction.iter_mut().for_each(|entry| *entry *= part);
                let change = next.gradient.iter().zip(&iterate.gradient).map(|(new, old)| new - old).collect();
                self.history.push(direction, change);
                (*u, *iterate) = (trial, next);
                return true;
            }
            part *= search.shorten(part, next.energy);
        }
        false
    }
}

/// ‖loads‖ + ‖elastic forces‖ + ‖c M (u − û)‖ at `u`, N: the size that the residual is relative to.
fn size_of_forces(on: &Potential, u: &[f64]) -> f64 {
    let norm = |full: &[f64]| {
        let free = on.data.pattern.gather(full);
        dot(&free, &free).sqrt()
    };
    let mut loads = vec![0.0; u.len()];
    on.gases().for_each(|gas| gas.add_gradient(u, &mut loads));
    on.dead.add_gradient(u, on.load_factor, &mut loads);
    let mut elastic = vec![0.0; u.len()];
    on.data.body(on.elastic).energy(u, &mut elastic);
    let inertial = on.inertia.map_or(0.0, |inertia| {
        let mut away = on.data.pattern.gather(u);
        away.iter_mut().zip(&inertia.centre).for_each(|(at, centre)| *at -= centre);
        let mut force = vec![0.0; away.len()];
        on.mass.multiply(&on.data.pattern, &away, &mut force);
        inertia.rate * dot(&force, &force).sqrt()
    });
    norm(&loads) + norm(&elastic) + inertial
}

/// z with K z = `b` at free dofs, and the number of iterations; `multiply` writes K x into its second argument.
///
/// # Errors
/// [`ProjectiveError`]
pub(crate) fn adjoint_solve(
    multiply: impl Fn(&[f64], &mut [f64]),
    global: &mut GlobalStep,
    b: &[f64],
    settings: &ProjectiveSettings,
) -> Result<(Vec<f64>, usize), ProjectiveError> {
    let goal = settings.tolerance * dot(b, b).sqrt();
    let (mut z, mut residual, mut image) = (vec![0.0; b.len()], b.to_vec(), vec![0.0; b.len()]);
    let mut history = LbfgsHistory::default();
    for iterations in 0..=settings.max_iterations {
        if dot(&residual, &residual).sqrt() <= goal {
            return Ok((z, iterations));
        }
        let mut direction = residual.clone();
        history.apply(&mut direction, |x| global.solve(x));
        multiply(&direction, &mut image);
        let curvature = dot(&direction, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            return Err(ProjectiveError::NotStable { iterations });
        }
        let part = dot(&residual, &direction) / curvature;
        direction.iter_mut().for_each(|entry| *entry *= part);
        z.iter_mut().zip(&direction).for_each(|(z, step)| *z += step);
        let change: Vec<f64> = image.iter().map(|entry| part * entry).collect();
        residual.iter_mut().zip(&change).for_each(|(residual, change)| *residual -= change);
        history.push(direction, change);
    }
    let residual = dot(&residual, &residual).sqrt() / dot(b, b).sqrt();
    let (iterations, tolerance) = (settings.max_iterations, settings.tolerance);
    Err(ProjectiveError::IterationLimit { residual, iterations, tolerance })
}
