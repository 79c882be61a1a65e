//! Local and global steps, sped up by what they teach: L-BFGS with A⁻¹ as its first guess, forwards and backwards.
//!
//! Forwards a step that does not lower the energy is cut. Backwards the energy ½ zᵀKz − b · z is quadratic, so that the
//! best length of each step is known.        [liu2017], [du2021]
//!
//! Stands on: `potential`, `memory`, `global`. Never knows: a time step, a scalar that is differentiated.

use super::global::Global;
use super::{ProjectiveError, ProjectiveSettings};
use crate::algebra::memory::Memory;
use crate::algebra::vectors::dot;
use crate::descent::newton::{descends, shorter};
use crate::descent::potential::{Energy, Potential};
use crate::load::Load;

/// Cuts of a step before its direction is given up.
const CUTS: usize = 25;

/// Moves `u` (3 a node, m) to the minimum of `on`; the forces at `from` are what the residual is measured by. Begins at
/// `from` itself where `u` is inside out. Returns the iterations.
///
/// # Errors
/// [`ProjectiveError`]
pub(crate) fn minimise(
    on: &Potential,
    global: &mut Global,
    u: &mut Vec<f64>,
    from: &[f64],
    settings: &ProjectiveSettings,
) -> Result<usize, ProjectiveError> {
    let whole = size_of_forces(on, from);
    let mut here = Place::at(on, u);
    if !here.energy.value.is_finite() {
        u.copy_from_slice(from);
        here = Place::at(on, u);
    }
    if !here.energy.value.is_finite() {
        return Err(ProjectiveError::InsideOut);
    }
    let mut memory = Memory::default();
    for iterations in 0..=settings.iterations {
        let residual = dot(&here.slope, &here.slope).sqrt();
        if residual <= settings.tolerance * whole {
            return Ok(iterations);
        }
        if take(on, global, &mut memory, u, &mut here) {
            continue;
        }
        // what past steps taught may mislead: the plain global step always descends
        memory.clear();
        if !take(on, global, &mut memory, u, &mut here) {
            return Err(ProjectiveError::NoDescent { iterations, residual: residual / whole });
        }
    }
    let residual = dot(&here.slope, &here.slope).sqrt() / whole;
    Err(ProjectiveError::TooSlow { residual, iterations: settings.iterations, tolerance: settings.tolerance })
}

/// Π and ∇Π at free nodes.
struct Place {
    energy: Energy,
    slope: Vec<f64>,
}

impl Place {
    /// The local step: each element's projection is what its stress is made of.
    fn at(on: &Potential, u: &[f64]) -> Self {
        let mut gradient = vec![0.0; u.len()];
        let energy = on.energy(u, &mut gradient);
        let mut slope = Vec::new();
        on.parts.pattern.gather(&gradient, &mut slope);
        Self { energy, slope }
    }
}

/// The global step, and as much of it as lowers the energy; says whether any did.
fn take(on: &Potential, global: &mut Global, memory: &mut Memory, u: &mut Vec<f64>, here: &mut Place) -> bool {
    let mut direction = here.slope.clone();
    memory.apply(&mut direction, |x| global.solve(x));
    direction.iter_mut().for_each(|entry| *entry = -*entry);
    let slope = dot(&here.slope, &direction);
    if slope.is_nan() || slope >= 0.0 {
        return false;
    }
    let mut part = 1.0;
    for _ in 0..CUTS {
        let mut trial = u.clone();
        on.parts.pattern.spread(&direction, part, &mut trial);
        let there = Place::at(on, &trial);
        if descends(here.energy, there.energy, part, slope, dot(&there.slope, &direction)) {
            direction.iter_mut().for_each(|entry| *entry *= part);
            memory.learn(direction, there.slope.iter().zip(&here.slope).map(|(new, old)| new - old).collect());
            (*u, *here) = (trial, there);
            return true;
        }
        part *= shorter(here.energy, there.energy, part, slope);
    }
    false
}

/// ‖loads‖ + ‖elastic forces‖ + ‖c M (u − û)‖ at `u`, N: what has to come into balance.
fn size_of_forces(on: &Potential, u: &[f64]) -> f64 {
    let norm = |full: &[f64]| {
        let mut free = Vec::new();
        on.parts.pattern.gather(full, &mut free);
        dot(&free, &free).sqrt()
    };
    let mut loads = vec![0.0; u.len()];
    on.gases().for_each(|gas| gas.add_gradient(u, &mut loads));
    on.dead.add_gradient(u, on.dead_strength, &mut loads);
    let mut elastic = vec![0.0; u.len()];
    on.parts.body().energy(on.elastic, u, 1.0, &mut elastic);
    let drawn = on.inertia.map_or(0.0, |inertia| {
        let mut away = Vec::new();
        on.parts.pattern.gather(u, &mut away);
        away.iter_mut().zip(&inertia.centre).for_each(|(at, centre)| *at -= centre);
        let mut push = vec![0.0; away.len()];
        on.mass.multiply(&on.parts.pattern, &away, &mut push);
        inertia.rate * dot(&push, &push).sqrt()
    });
    norm(&loads) + norm(&elastic) + drawn
}

/// z with K z = `b` at free nodes, and the iterations; `image` writes K x into its second argument.
///
/// # Errors
/// [`ProjectiveError`]
pub(crate) fn solve(
    image: impl Fn(&[f64], &mut [f64]),
    global: &mut Global,
    b: &[f64],
    settings: &ProjectiveSettings,
) -> Result<(Vec<f64>, usize), ProjectiveError> {
    let goal = settings.tolerance * dot(b, b).sqrt();
    let (mut z, mut left, mut bent) = (vec![0.0; b.len()], b.to_vec(), vec![0.0; b.len()]);
    let mut memory = Memory::default();
    for iterations in 0..=settings.iterations {
        if dot(&left, &left).sqrt() <= goal {
            return Ok((z, iterations));
        }
        let mut direction = left.clone();
        memory.apply(&mut direction, |x| global.solve(x));
        image(&direction, &mut bent);
        let curvature = dot(&direction, &bent);
        if curvature.is_nan() || curvature <= 0.0 {
            return Err(ProjectiveError::NotStable { iterations });
        }
        let part = dot(&left, &direction) / curvature;
        direction.iter_mut().for_each(|entry| *entry *= part);
        z.iter_mut().zip(&direction).for_each(|(z, step)| *z += step);
        let change: Vec<f64> = bent.iter().map(|entry| part * entry).collect();
        left.iter_mut().zip(&change).for_each(|(left, change)| *left -= change);
        memory.learn(direction, change);
    }
    let residual = dot(&left, &left).sqrt() / dot(b, b).sqrt();
    Err(ProjectiveError::TooSlow { residual, iterations: settings.iterations, tolerance: settings.tolerance })
}
