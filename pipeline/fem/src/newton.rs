//! Newton's method for a potential: descends to a minimum, and asks for a new factor only when the old one is too slow.
//!
//! Direction −H g, where H is the inverse of the last factor, bettered by what the steps since then taught (`memory`).
//! A step must lower the energy [armijo1966]; near the minimum, where differences of energy are rounding, its slope
//! must have fallen instead [hager2005]. Where the tangent has no factor, its convex part stands in.
//! The search ends on the size of a step: a stiff sheet puts a floor of rounding under the residual (FACTS).
//!
//! Stands on: `potential`, `factor`, `memory`. Never knows: a load step, a time step.

use crate::factor::{Factor, NoFactor};
use crate::memory::Memory;
use crate::potential::{Curvature, Energy, Potential, dot};
use crate::system::Parts;
use si::Metre;

/// When to stop, and how much patience to have with an old factor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule {
    /// The last step moves no node further than this.
    pub tolerance: Metre,
    /// Directions at most.
    pub limit: usize,
    /// A factor is renewed when it promises to need more further directions than this.
    pub patience: f64,
    /// Whether to begin with a new factor.
    pub fresh: bool,
}

/// How a search ended well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    /// Directions computed.
    pub iterations: usize,
    /// Factors made.
    pub factorisations: usize,
}

/// Why a search gave up.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Stall {
    /// An element is turned inside out where the search began.
    #[error("an element is turned inside out at the start")]
    InsideOut,
    /// Steps did not become small.
    #[error("the last step is still {step:.2e} m after {iterations} iterations; the limit is {tolerance:.2e} m")]
    TooSlow {
        /// Size of the last step, m.
        step: Metre,
        /// Iterations made.
        iterations: usize,
        /// Size to reach, m.
        tolerance: Metre,
    },
    /// No step along a direction lowers the energy.
    #[error("no step lowers the energy after {iterations} iterations")]
    NoDescent {
        /// Iterations made.
        iterations: usize,
    },
    /// The tangent could not be factorised well.
    #[error("the factor leaves a residual of {residual:.1e}; the limit is 1e-6")]
    Inexact {
        /// ‖Kx − b‖ / ‖b‖
        residual: f64,
    },
    /// A force is NaN or infinite.
    #[error("a force is not a finite number")]
    NotANumber,
}

/// Part of the body's size that one step may move a node: longer ones leave the region where the tangent means much.
const LONGEST: f64 = 0.3;
/// Halvings of one step before its direction is given up.
const HALVINGS: usize = 25;

/// Numbers of one search, kept from search to search.
pub(crate) struct Newton {
    /// Lower triangle of the last tangent.
    pub values: Vec<f64>,
    pub factor: Factor,
    memory: Memory,
    gradient: Vec<f64>,
    trial_gradient: Vec<f64>,
}

impl Newton {
    pub fn new(parts: &Parts) -> Self {
        let full = 3 * parts.mesh.nodes.len();
        Self {
            values: vec![0.0; parts.pattern.entries()],
            factor: Factor::new(&parts.symbolic),
            memory: Memory::default(),
            gradient: vec![0.0; full],
            trial_gradient: vec![0.0; full],
        }
    }

    /// Moves `u` (3 a node, m) to a minimum of `on`.
    ///
    /// # Errors
    /// [`Stall`]; `u` is then somewhere on the way.
    pub fn minimise(&mut self, on: &Potential, u: &mut [f64], rule: &Rule) -> Result<Found, Stall> {
        let mut energy = on.energy(u, &mut self.gradient);
        if !energy.value.is_finite() {
            return Err(Stall::InsideOut);
        }
        let mut found = Found { iterations: 0, factorisations: 0 };
        let (mut renew, mut before) = (rule.fresh || !self.factor.is_ready(), None);
        let mut last = f64::INFINITY;
        while found.iterations < rule.limit {
            let new = std::mem::take(&mut renew);
            if new {
                self.renew(on, u)?;
                found.factorisations += 1;
                before = None;
            }
            let (direction, size) = self.direction(on)?;
            found.iterations += 1;
            last = size;
            if size <= rule.tolerance {
                on.parts.pattern.spread(&direction, 1.0, u);
                return Ok(found);
            }
            if before.is_some_and(|before| promised(size / before, size / rule.tolerance) > rule.patience) {
                renew = true;
                continue;
            }
            match self.step(on, u, &direction, size, energy) {
                Some((next, whole)) => {
                    energy = next;
                    before = Some(size);
                    renew = !whole;
                }
                None if new => return Err(Stall::NoDescent { iterations: found.iterations }),
                None => renew = true,
            }
        }
        Err(Stall::TooSlow { step: last, iterations: found.iterations, tolerance: rule.tolerance })
    }

    /// Forgets what past steps taught: the factor was made anew.
    pub fn forget(&mut self) {
        self.memory.clear();
    }

    /// Factorises the tangent at `u`, or as much of it as is positive definite.
    fn renew(&mut self, on: &Potential, u: &[f64]) -> Result<Curvature, Stall> {
        self.memory.clear();
        let mut probe = Vec::new();
        on.parts.pattern.gather(&self.gradient, &mut probe);
        for kept in [Curvature::Exact, Curvature::ConvexElastic, Curvature::Convex] {
            on.curvature(u, kept, &mut self.values);
            match self.factor.make(&on.parts.symbolic, &on.parts.pattern, &self.values, &probe) {
                Ok(()) => return Ok(kept),
                Err(NoFactor::NotPositive) => {}
                Err(NoFactor::Inexact { residual }) => return Err(Stall::Inexact { residual }),
            }
        }
        Err(Stall::NotANumber)
    }

    /// −H g in elimination order, and the largest distance that it moves a freedom, m.
    fn direction(&mut self, on: &Potential) -> Result<(Vec<f64>, Metre), Stall> {
        let mut direction = Vec::new();
        on.parts.pattern.gather(&self.gradient, &mut direction);
        let factor = &mut self.factor;
        self.memory.apply(&mut direction, |x| factor.solve(&on.parts.symbolic, x));
        direction.iter_mut().for_each(|entry| *entry = -*entry);
        let size = direction.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if direction.iter().all(|entry| entry.is_finite()) { Ok((direction, size)) } else { Err(Stall::NotANumber) }
    }

    /// Goes along `direction` as far as the energy falls; says whether that was all the way.
    fn step(
        &mut self,
        on: &Potential,
        u: &mut [f64],
        direction: &[f64],
        size: Metre,
        from: Energy,
    ) -> Option<(Energy, bool)> {
        let pattern = &on.parts.pattern;
        let (mut old, mut new) = (Vec::new(), Vec::new());
        pattern.gather(&self.gradient, &mut old);
        let slope = dot(&old, direction);
        let longest = (LONGEST * on.parts.size / size).min(1.0);
        let mut part = longest;
        let mut trial = u.to_vec();
        for _ in 0..HALVINGS {
            trial.copy_from_slice(u);
            pattern.spread(direction, part, &mut trial);
            let energy = on.energy(&trial, &mut self.trial_gradient);
            pattern.gather(&self.trial_gradient, &mut new);
            if descends(from, energy, part, slope, dot(&new, direction)) {
                u.copy_from_slice(&trial);
                std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                let step = direction.iter().map(|entry| part * entry).collect();
                self.memory.learn(step, new.iter().zip(&old).map(|(new, old)| new - old).collect());
                return Some((energy, part == 1.0));
            }
            part *= shorter(from, energy, part, slope);
        }
        None
    }
}

/// Whether the step of `part` lowers the energy enough [armijo1966], or as far as rounding lets one see, the slope.
fn descends(from: Energy, to: Energy, part: f64, slope: f64, slope_there: f64) -> bool {
    if !to.value.is_finite() {
        return false;
    }
    let change = to.value - from.value;
    change <= 1e-4 * part * slope || (change.abs() <= 1e-13 * from.size.max(to.size) && slope_there <= -0.8 * slope)
}

/// By how much to shorten a step that did not descend: to the least of a parabola, within a tenth and a half.
fn shorter(from: Energy, to: Energy, part: f64, slope: f64) -> f64 {
    let bend = to.value - from.value - part * slope;
    if bend.is_finite() && bend > 0.0 { (-part * slope / (2.0 * bend)).clamp(0.1, 0.5) } else { 0.5 }
}

/// Directions that are still needed when each is `ratio` of the one before and the first is `excess` times too long.
fn promised(ratio: f64, excess: f64) -> f64 {
    if ratio < 1.0 { excess.ln() / -ratio.ln() } else { f64::INFINITY }
}
