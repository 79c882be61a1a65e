//! Newton's method for a potential: descends to a minimum, and asks for a new factor only when the old one is too slow.
//!
//! Direction −H g, where H is the inverse of the last factor, turned with the body since (`turn`) and bettered by what
//! the steps since then taught (`memory`). Where the tangent has no factor, its convex part stands in.
//! The search ends on the size of a step: a stiff sheet puts a floor of rounding under the residual (FACTS).
//!
//! A careful step must lower the energy [armijo1966]; near the minimum, where differences of energy are rounding, its
//! slope must have fallen instead [hager2005]. Leaps do not ask: a long turn of a stiff thin sheet stretches it in
//! second order, and a search along the energy would cut every step short.
//!
//! Stands on: `potential`, `factor`, `memory`, `turn`, `search`. Never knows: a load step, a time step.

use crate::algebra::bordered::Bordered;
use crate::algebra::factor::{Factor, NoFactor};
use crate::algebra::memory::Memory;
use crate::algebra::vectors::dot;
use crate::body::turn::Turn;
use crate::descent::potential::{Curvature, Energy, Potential};
use crate::descent::search::{Found, Gait, Rule, Search, Stall};
use crate::parts::Parts;
use si::Metre;

/// Part of the body's size that one step may move a node: longer ones leave the region where the tangent means much.
const LONGEST: f64 = 0.3;
/// Cuts of a careful step before its direction is given up.
const CUTS: usize = 25;
/// Halvings of a leap that turns an element inside out.
const HALVINGS: usize = 6;

/// Numbers of one search, kept from search to search.
pub(crate) struct Newton {
    /// Lower triangle of the last tangent.
    pub values: Vec<f64>,
    /// What the last tangent has beside them.
    pub full: Bordered,
    factor: Factor,
    /// The same of the factorised tangent.
    factor_full: Bordered,
    memory: Memory,
    /// Where the factor was made, 3 a node.
    made_at: Vec<f64>,
    /// How the body has turned since.
    turn: Option<Turn>,
    gradient: Vec<f64>,
    trial_gradient: Vec<f64>,
}

impl Newton {
    pub fn new(parts: &Parts) -> Self {
        let full = 3 * parts.mesh.nodes.len();
        Self {
            values: vec![0.0; parts.pattern.entries()],
            full: Bordered::default(),
            factor: Factor::new(&parts.symbolic),
            factor_full: Bordered::default(),
            memory: Memory::default(),
            made_at: vec![0.0; full],
            turn: None,
            gradient: vec![0.0; full],
            trial_gradient: vec![0.0; full],
        }
    }

    /// Whether there is a factor to solve with.
    pub fn is_ready(&self) -> bool {
        self.factor.is_ready()
    }

    /// Moves `u` (3 a node, m) to a minimum of `on`; `before` is where a straight line to `u` began, if one did.
    ///
    /// # Errors
    /// [`Stall`]; `u` is then somewhere on the way.
    pub fn minimise(
        &mut self,
        on: &Potential,
        u: &mut [f64],
        before: Option<&[f64]>,
        rule: &Rule,
    ) -> Result<Found, Stall> {
        let mut energy = on.energy(u, &mut self.gradient);
        if !energy.value.is_finite() {
            return Err(Stall::InsideOut);
        }
        let mut search = Search::new(rule.fresh || !self.is_ready(), before);
        self.memory.clear();
        self.turn_to(on, u);
        while search.found.iterations < rule.limit {
            if self.advance(on, u, &mut energy, &mut search, rule)? {
                return Ok(search.found);
            }
        }
        let Found { iterations, .. } = search.found;
        Err(Stall::TooSlow { step: search.last, iterations, tolerance: rule.tolerance })
    }

    /// One direction and the step along it; says whether it was the last.
    fn advance(
        &mut self,
        on: &Potential,
        u: &mut [f64],
        energy: &mut Energy,
        search: &mut Search,
        rule: &Rule,
    ) -> Result<bool, Stall> {
        let new = std::mem::take(&mut search.renew);
        if new {
            let before = search.before.as_deref().filter(|_| rule.gait == Gait::Leaping);
            search.count_factor(self.renew(on, u, before)?);
            search.check(u, on.parts.size)?;
        }
        let (direction, size) = self.direction(on)?;
        search.found.iterations += 1;
        if size <= rule.tolerance {
            on.parts.pattern.spread(&direction, 1.0, u);
            return Ok(true);
        }
        if !new && search.is_worn(size, rule) {
            search.renew = true;
            return Ok(false);
        }
        search.before = Some(u.to_vec());
        match self.step(on, u, &direction, size, *energy, rule.gait) {
            Some((next, whole)) => {
                *energy = next;
                search.renew = !whole;
                search.count_step(size);
            }
            None if !new => search.renew = true,
            None if rule.gait == Gait::Leaping => return Err(Stall::InsideOut),
            None => return Err(Stall::NoDescent { iterations: search.found.iterations }),
        }
        Ok(false)
    }

    /// Factorises the tangent at `u`, or as much of it as is positive definite; says whether that was all of it.
    fn renew(&mut self, on: &Potential, u: &[f64], before: Option<&[f64]>) -> Result<bool, Stall> {
        let mut probe = Vec::new();
        on.parts.pattern.gather(&self.gradient, &mut probe);
        let all = [Curvature::Foreseen, Curvature::Exact, Curvature::ConvexElastic, Curvature::Convex];
        for &kept in &all[usize::from(before.is_none())..] {
            on.curvature(u, before.unwrap_or(&[]), kept, &mut self.values);
            self.full = Bordered::new(on.full_blocks(u));
            match self.factorise(on, u, &probe) {
                Ok(()) => return Ok(matches!(kept, Curvature::Foreseen | Curvature::Exact)),
                Err(NoFactor::NotPositive) => {}
                Err(NoFactor::Inexact { residual }) => return Err(Stall::Inexact { residual }),
            }
        }
        Err(Stall::NotANumber)
    }

    /// Factorises `values`, the tangent at `u`, and takes in what it has beside them.
    ///
    /// # Errors
    /// [`NoFactor`]
    pub fn factorise(&mut self, on: &Potential, u: &[f64], probe: &[f64]) -> Result<(), NoFactor> {
        let symbolic = &on.parts.symbolic;
        self.memory.clear();
        self.turn = None;
        self.made_at.copy_from_slice(u);
        self.factor.make(symbolic, &on.parts.pattern, &self.values, probe)?;
        self.factor_full = Bordered::new(on.full_blocks(u));
        let factor = &mut self.factor;
        if self.factor_full.prepare(|x| factor.solve(symbolic, x)) { Ok(()) } else { Err(NoFactor::NotPositive) }
    }

    /// Turns the factor to `u`.
    pub fn turn_to(&mut self, on: &Potential, u: &[f64]) {
        self.turn = self.is_ready().then(|| Turn::between(&on.parts.body(), on.elastic, &self.made_at, u));
    }

    /// x ← H x by the turned factor alone, in elimination order.
    pub fn solve(&mut self, parts: &Parts, x: &mut [f64]) {
        let freedom = &parts.pattern.freedom;
        self.turn.iter().for_each(|turn| turn.apply(freedom, true, x));
        self.factor.solve(&parts.symbolic, x);
        self.factor_full.correct(x);
        self.turn.iter().for_each(|turn| turn.apply(freedom, false, x));
    }

    /// −H g in elimination order, and the largest distance that it moves a freedom, m.
    fn direction(&mut self, on: &Potential) -> Result<(Vec<f64>, Metre), Stall> {
        let mut direction = Vec::new();
        on.parts.pattern.gather(&self.gradient, &mut direction);
        let memory = std::mem::take(&mut self.memory);
        memory.apply(&mut direction, |x| self.solve(on.parts, x));
        self.memory = memory;
        direction.iter_mut().for_each(|entry| *entry = -*entry);
        let size = direction.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if direction.iter().all(|entry| entry.is_finite()) { Ok((direction, size)) } else { Err(Stall::NotANumber) }
    }

    /// Goes along `direction`: carefully as far as the energy falls, leaping as far as no element turns inside out.
    /// Says whether that was all the way.
    fn step(
        &mut self,
        on: &Potential,
        u: &mut [f64],
        direction: &[f64],
        size: Metre,
        from: Energy,
        gait: Gait,
    ) -> Option<(Energy, bool)> {
        let pattern = &on.parts.pattern;
        let (mut old, mut new) = (Vec::new(), Vec::new());
        pattern.gather(&self.gradient, &mut old);
        let slope = dot(&old, direction);
        let mut part = (LONGEST * on.parts.size / size).min(1.0);
        let mut trial = u.to_vec();
        for _ in 0..if gait == Gait::Careful { CUTS } else { HALVINGS } {
            trial.copy_from_slice(u);
            pattern.spread(direction, part, &mut trial);
            let energy = on.energy(&trial, &mut self.trial_gradient);
            pattern.gather(&self.trial_gradient, &mut new);
            let taken = match gait {
                Gait::Careful => descends(from, energy, part, slope, dot(&new, direction)),
                Gait::Leaping => energy.value.is_finite(),
            };
            if taken {
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
pub(crate) fn descends(from: Energy, to: Energy, part: f64, slope: f64, slope_there: f64) -> bool {
    if !to.value.is_finite() {
        return false;
    }
    let change = to.value - from.value;
    change <= 1e-4 * part * slope || (change.abs() <= 1e-13 * from.size.max(to.size) && slope_there <= -0.8 * slope)
}

/// By how much to shorten a step that did not descend: to the least of a parabola, within a tenth and a half.
pub(crate) fn shorter(from: Energy, to: Energy, part: f64, slope: f64) -> f64 {
    let bend = to.value - from.value - part * slope;
    if bend.is_finite() && bend > 0.0 { (-part * slope / (2.0 * bend)).clamp(0.1, 0.5) } else { 0.5 }
}
