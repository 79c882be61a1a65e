//! Statics: the shape in which a body rests under given pressures.
//!
//! From a state nearby, Newton goes there at once. From rest, or when that fails, the load is raised in steps with
//! linear extrapolation; a step that fails is halved, an easy one makes the next longer. A short step that still fails is
//! searched for downhill, and at last by creeping (`creep`): so the body comes through the snap of a thin wall.
//!
//! Stands on: `solver`, `newton`, `potential`, `creep`. Never knows: time, a measurement.

use crate::algebra::vectors::dot;
use crate::descent::search::{Gait, Rule, Stall};
use crate::solver::Solver;
use crate::stall::SolveError;
use crate::statics::equilibrium::{Equilibrium, StaticSettings};
use si::Pascal;

/// Part of the body's size to which load steps on the way are solved: they only lead to the next.
const ON_THE_WAY: f64 = 1e-5;
/// Smallest load step, as a part of the load.
const SHORTEST: f64 = 1.0 / 256.0;
/// A load step that whole steps do not manage is halved while it is longer than this; then it is searched for downhill.
const CAREFUL: f64 = 1.0 / 24.0;
/// A load step with this many factors or fewer makes the next one half as long again.
const EASY: usize = 8;
/// Leaps at most, before care is taken instead: those that arrive need four to twelve directions.
const LEAPS: usize = 25;
/// A factor is renewed in statics when it promises to need more directions than this: it costs about that many.
const PATIENCE: f64 = 8.0;

impl Solver {
    /// The equilibrium under `pressures` (one a chamber, Pa) and the dead forces set before.
    ///
    /// `start`: a displacement nearby (3 a node, m), as another pressure level or slightly other properties left it.
    ///
    /// # Errors
    /// [`SolveError`]; `NoEquilibrium` holds the last converged state.
    pub fn equilibrium(
        &mut self,
        pressures: &[Pascal],
        start: Option<&[f64]>,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        self.check_pressures(pressures)?;
        check_settings(settings)?;
        self.linearised = None;
        if let Some(start) = start {
            self.check_field("the start", start)?;
            let mut direct = self.begin(pressures);
            direct.displacement.copy_from_slice(&self.with_held_at_rest(start));
            let rule = self.rule(settings.tolerance, settings);
            if settings.reuse_factor && self.glide(&mut direct, pressures, &rule) {
                return Ok(self.finished(direct, false));
            }
            if self.descend(&mut direct, None, pressures, 1.0, &rule).is_ok() {
                return Ok(self.finished(direct, false));
            }
        }
        self.climb(pressures, settings)
    }

    /// The same from a shape that was `found` nearby, by way of the one that is `foretold` from that and others (3 a node, m).
    ///
    /// A shape put together from others stretches a stiff sheet where it turns; the stress of such a stretch is left out, as
    /// along a load step.
    ///
    /// # Errors
    /// As [`Solver::equilibrium`].
    pub fn equilibrium_ahead(
        &mut self,
        pressures: &[Pascal],
        found: &[f64],
        foretold: &[f64],
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        self.check_pressures(pressures)?;
        check_settings(settings)?;
        self.check_field("the shape found", found)?;
        self.check_field("the shape foretold", foretold)?;
        self.linearised = None;
        let mut ahead = self.begin(pressures);
        ahead.displacement = self.with_held_at_rest(foretold);
        let (before, rule) = (self.with_held_at_rest(found), self.rule(settings.tolerance, settings));
        if self.descend(&mut ahead, Some(&before), pressures, 1.0, &rule).is_ok() {
            return Ok(self.finished(ahead, false));
        }
        self.equilibrium(pressures, Some(found), settings)
    }

    /// Moves `at` to its equilibrium by the factor there is, and says whether it got there.
    fn glide(&mut self, at: &mut Equilibrium, pressures: &[Pascal], rule: &Rule) -> bool {
        let potential = self.given.at_rest(&self.parts, pressures, 1.0);
        let ready = self.newton.is_ready();
        let found = ready.then(|| self.newton.glide(&potential, &mut at.displacement, rule)).flatten();
        at.iterations += found.map_or(0, |found| found.iterations);
        found.is_some()
    }

    /// Raises the load from rest.
    fn climb(&mut self, pressures: &[Pascal], settings: &StaticSettings) -> Result<Equilibrium, SolveError> {
        let mut path = vec![(0.0, self.begin(pressures))];
        let mut stride = 1.0 / settings.load_steps.max(1) as f64;
        let mut halved = 0;
        loop {
            let reached = path[path.len() - 1].0;
            let target = if reached + stride > 1.0 - SHORTEST { 1.0 } else { reached + stride };
            match self.load_step(&path, target, pressures, settings) {
                Ok((at, _)) if target == 1.0 => return Ok(self.finished(at, true)),
                Ok((at, factors)) => {
                    path.push((target, at));
                    path.drain(..path.len() - 2);
                    stride *= if factors <= EASY { 1.5 } else { 1.0 };
                }
                Err(_) if stride > SHORTEST && halved < settings.halvings => {
                    stride *= 0.5;
                    halved += 1;
                }
                Err(stall) => return Err(self.lost(path, stride, pressures, stall)),
            }
        }
    }

    /// One load step to the part `target`, from the extrapolated path or, when that is inside out, from its end.
    fn load_step(
        &mut self,
        path: &[(f64, Equilibrium)],
        target: f64,
        pressures: &[Pascal],
        settings: &StaticSettings,
    ) -> Result<(Equilibrium, usize), Stall> {
        let tolerance = if target == 1.0 { settings.tolerance } else { settings.tolerance.max(ON_THE_WAY) };
        let leaping = self.rule(tolerance, settings);
        let careful = Rule { gait: Gait::Careful, limit: settings.iterations, ..leaping };
        let raised: Vec<Pascal> = pressures.iter().map(|pressure| target * pressure).collect();
        let (_, end) = &path[path.len() - 1];
        let guess = ahead(path, target);
        let before = (path.len() > 1).then_some(end.displacement.as_slice());
        let mut attempt = |from: &[f64], before, rule| {
            let mut next = Equilibrium { displacement: from.to_vec(), pressures: raised.clone(), ..end.clone() };
            self.descend(&mut next, before, &raised, target, rule).map(|factors| (next, factors))
        };
        let leapt = attempt(&guess, before, &leaping);
        if leapt.is_ok() || target - path[path.len() - 1].0 > CAREFUL {
            return leapt;
        }
        let mut found = attempt(&guess, None, &careful);
        if found == Err(Stall::InsideOut) {
            found = attempt(&end.displacement, None, &careful);
        }
        found.or_else(|_| {
            let mut next = Equilibrium { pressures: raised.clone(), ..end.clone() };
            self.creep(&mut next, &raised, target, &careful).map(|factors| (next, factors))
        })
    }

    fn begin(&self, pressures: &[Pascal]) -> Equilibrium {
        Equilibrium {
            displacement: vec![0.0; 3 * self.parts.mesh.nodes.len()],
            pressures: pressures.to_vec(),
            iterations: 0,
            factorisations: 0,
            residual: 0.0,
            stepped: false,
            snaps: Vec::new(),
        }
    }

    /// Leaps with a new factor to begin with.
    fn rule(&self, tolerance: f64, settings: &StaticSettings) -> Rule {
        Rule {
            tolerance: tolerance * self.parts.size,
            limit: settings.iterations.min(LEAPS),
            patience: PATIENCE,
            trials: 1,
            fresh: true,
            gait: Gait::Leaping,
        }
    }

    /// The same displacement with nothing at held freedoms.
    pub(crate) fn with_held_at_rest(&self, displacement: &[f64]) -> Vec<f64> {
        let mut free = Vec::new();
        self.parts.pattern.gather(displacement, &mut free);
        let mut full = vec![0.0; displacement.len()];
        self.parts.pattern.spread(&free, 1.0, &mut full);
        full
    }

    fn finished(&self, mut at: Equilibrium, stepped: bool) -> Equilibrium {
        at.stepped = stepped;
        at.residual = self.unbalanced(&at);
        at
    }

    /// ‖∂Π/∂u‖ over the norm of the loads' own part of it, at free nodes; 0 when nothing pushes.
    fn unbalanced(&self, at: &Equilibrium) -> f64 {
        let potential = self.given.at_rest(&self.parts, &at.pressures, 1.0);
        let norm = |full: &[f64]| {
            let mut free = Vec::new();
            self.parts.pattern.gather(full, &mut free);
            dot(&free, &free).sqrt()
        };
        let mut gradient = vec![0.0; at.displacement.len()];
        potential.energy(&at.displacement, &mut gradient);
        let mut elastic = vec![0.0; gradient.len()];
        self.parts.body().energy(&self.given.elastic, &at.displacement, 1.0, &mut elastic);
        let left = norm(&gradient);
        let pushed = norm(&elastic);
        if pushed > 0.0 { left / pushed } else { 0.0 }
    }

    fn lost(&self, mut path: Vec<(f64, Equilibrium)>, stride: f64, pressures: &[Pascal], stall: Stall) -> SolveError {
        let (reached, at) = path.swap_remove(path.len() - 1);
        let pressure = pressures
            .iter()
            .fold(0.0, |most: f64, pressure| if pressure.abs() > most.abs() { *pressure } else { most });
        let last_converged = (reached > 0.0).then(|| Box::new(self.finished(at, true)));
        SolveError::NoEquilibrium { reached, stride, pressure, stall, last_converged }
    }
}

/// The straight line through the last two states of the path, at the part `target` of the load.
fn ahead(path: &[(f64, Equilibrium)], target: f64) -> Vec<f64> {
    let (reached, end) = &path[path.len() - 1];
    let Some((earlier, start)) = path.len().checked_sub(2).map(|at| &path[at]) else {
        return end.displacement.clone();
    };
    let part = (target - reached) / (reached - earlier);
    end.displacement.iter().zip(&start.displacement).map(|(now, then)| now + part * (now - then)).collect()
}

fn check_settings(settings: &StaticSettings) -> Result<(), SolveError> {
    if !(settings.tolerance > 0.0 && settings.tolerance <= 1e-2) {
        let (what, range) = ("the tolerance", "above 0 and at most 0.01 of the body's size");
        return Err(SolveError::Setting { what, value: settings.tolerance, range });
    }
    if settings.iterations == 0 {
        return Err(SolveError::Setting { what: "the limit of iterations", value: 0.0, range: "at least 1" });
    }
    Ok(())
}
