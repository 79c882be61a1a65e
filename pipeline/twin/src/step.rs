//! Steps of a reduced tail: BDF2, with a quasi-Newton method on a lagged tangent.
//!
//! M q̈ + f(q) = Σ p ∂V/∂q + Q. A residual costs half of a tangent, and Broyden's update of the inverse almost nothing: the
//! tangent is summed anew only where an iteration leaves more than [`REFRESH_ABOVE`] of the one before.
//!
//! The tangent's geometric part takes the stress of the last step's end, not that of the iterate, which the quadratic terms of a linear
//! step in the rotating stiff sheet spoil. Measured on a flapping tail in air, residuals and tangents a step: 9.1 and 4.1 with the iterate's
//! stress, 7.5 and 3.3 with the stress that the last iteration predicts [magisano2017], 5.9 and 2.5 with this.

use crate::chambers::{PressureWork, add};
use crate::data::{Chamber, Output, TwinData};
use crate::dense::{broyden_update, inverse, multiply};
use crate::elastic::{Acting, Solid, Stresses, add_triangle};
use crate::error::TwinError;
use crate::history::{Factors, History};
use crate::lanes::{add_reduced, splat};
use crate::single_precision;
use crate::state::{Lagged, Past, Stencil, TwinState, Work};
use crate::water::Water;

/// Iterations at most; a step that needs more is halved.
const MAX_ITERATIONS: usize = 30;
/// A step that leaves more than this fraction of the one before asks for a new tangent. Measured: 0.05 and 0.1 take equally long, 0.3 in air a tenth longer.
const REFRESH_ABOVE: f64 = 0.1;
/// Largest size of the last iteration, relative to the largest shape. 1e-7 takes a tenth longer and moves the tip of a flapping tail by 2e-3 %
/// of its length; 1e-4 excites the stiff sheet and moves it by 4 %.
const TOLERANCE: f64 = 1e-6;
/// γ (1/s) above which the tolerance falls with its square, so that what a step leaves accelerates the body by no more: that of 240 steps a second.
const SLOW: f64 = 360.0;
/// Least tolerance: rounding.
const LEAST: f64 = 1e-11;
/// Times that a step is halved at most.
const HALVINGS: usize = 6;
/// Shortest part of a change that is left of an iterate that is taken back.
const SHORTEST_PART: f64 = 1e-3;
/// Part of a chamber's range by which a pressure may lie beyond it: the noise of a gauge and the overshoot of a valve.
const RANGE_MARGIN: f64 = 0.01;
/// Steps, and γ, that differ by less than this, relative, are equal: times are sums that round.
const SAME: f64 = 1e-9;

/// A reduced tail, laid out for stepping.
#[derive(Debug, Clone)]
pub struct Twin {
    pub(crate) mass: Vec<f64>,
    size: f64,
    pub(crate) solids: Vec<Solid>,
    pub(crate) chambers: Vec<Chamber>,
    pub(crate) water: Option<Water>,
    outputs: Vec<Output>,
    tolerance: f64,
}

/// What sees the state after a part of a step, and the stencil of that part.
pub(crate) type See<'a> = dyn FnMut(&TwinState, Stencil) + 'a;

/// The equations of one step.
struct Equations<'a> {
    twin: &'a Twin,
    stencil: Stencil,
    acting: Vec<Acting>,
    pressure_work: PressureWork,
    /// Σ w of q, q̇ and the water's momentum.
    past: [Vec<f64>; 3],
}

impl Twin {
    /// Of a tail's arrays.
    ///
    /// # Errors
    /// [`TwinError::Data`] when they do not belong together.
    pub fn new(data: TwinData) -> Result<Self, TwinError> {
        data.check_data()?;
        let r = data.coordinates();
        let solids = data.regions.iter().map(|region| Solid::new(region, r)).collect();
        let water = (!data.sections.is_empty()).then(|| Water::new(&data.sections, r));
        let TwinData { mass, size, chambers, outputs, .. } = data;
        Ok(Self { mass, size, solids, chambers, water, outputs, tolerance: TOLERANCE })
    }

    /// The same with another tolerance of a step: the largest size of its last iteration relative to the largest shape, 1e-6 unless set.
    /// Differences of motions need one near 1e-11, the least.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(LEAST), ..self }
    }

    /// r.
    pub fn coordinates(&self) -> usize {
        self.mass.len().isqrt()
    }

    /// At rest for ever.
    pub fn start(&self) -> TwinState {
        let history = |solid: &Solid| History::at_rest(solid.block_count(), solid.branches.len());
        TwinState {
            time: 0.0,
            past: Past::at_rest(self.coordinates()),
            pressures: vec![0.0; self.chambers.len()],
            histories: self.solids.iter().map(history).collect(),
            factors: (0.0, Vec::new()),
            lagged: None,
            stresses: vec![Stresses::default(); self.solids.len()],
            work: Work::default(),
        }
    }

    /// Names of the outputs.
    pub fn outputs(&self) -> impl Iterator<Item = &str> {
        self.outputs.iter().map(|output| &*output.name)
    }

    /// The chambers: their channels and ranges.
    pub fn chambers(&self) -> &[Chamber] {
        &self.chambers
    }

    /// The number of the output of this name.
    ///
    /// # Errors
    /// [`TwinError::Output`], with the names that there are.
    pub fn output_number(&self, name: &str) -> Result<usize, TwinError> {
        let number = self.outputs.iter().position(|output| output.name == name);
        number.ok_or_else(|| TwinError::Output {
            name: name.to_owned(),
            names: self.outputs().collect::<Vec<_>>().join(", "),
        })
    }

    /// The displacement that is output `number`, m.
    ///
    /// # Panics
    /// When there is no such output, or the state has other coordinates.
    pub fn output(&self, state: &TwinState, number: usize) -> f64 {
        let (row, q) = (self.output_row(number), state.coordinates());
        assert_eq!(row.len(), q.len(), "a state of other coordinates");
        row.iter().zip(q).map(|(row, q)| row * q).sum()
    }

    /// The row of r numbers that gives output `number`, m per unit of q.
    ///
    /// # Panics
    /// When there is no such output.
    pub fn output_row(&self, number: usize) -> &[f64] {
        &self.outputs[number].row
    }

    /// The largest entry of q over that of the shapes which the tail was reduced from: above 1 it is larger than anything that was seen, and its
    /// shape is extrapolated.
    pub fn excursion(&self, state: &TwinState) -> f64 {
        largest_entry(state.coordinates()) / self.size
    }

    /// The volume of a chamber, m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber, or the state has other coordinates.
    pub fn chamber_volume(&self, state: &TwinState, chamber: usize) -> f64 {
        assert_eq!(self.coordinates(), state.coordinates().len(), "a state of other coordinates");
        self.chambers[chamber].volume(state.coordinates())
    }

    /// Steps by `duration` seconds, at whose end the chambers have these `pressures`, Pa. Where no step of that length is found, it is
    /// halved, with pressures that rise evenly. An error leaves the state as it was.
    ///
    /// # Errors
    /// [`TwinError`] when an input is wrong, a pressure is beyond the range of its chamber, the state is of another twin, or no step is found.
    pub fn step(&self, state: &mut TwinState, pressures: &[f64], duration: f64) -> Result<(), TwinError> {
        self.step_seen((state, &mut |_, _| {}), pressures, duration)
    }

    /// [`Twin::step`]; `see` is shown the state after every part of it, and the stencil of that part.
    pub(crate) fn step_seen(
        &self,
        seen: (&mut TwinState, &mut See),
        pressures: &[f64],
        duration: f64,
    ) -> Result<(), TwinError> {
        self.check_state(seen.0)?;
        self.check_pressures(pressures)?;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(TwinError::Input { what: format!("a step of {duration} s") });
        }
        match self.attempt_step(seen.0, pressures, duration) {
            Ok(stencil) => (seen.1)(seen.0, stencil),
            Err(error) => self.step_in_halves(seen, (pressures, duration), error)?,
        }
        Ok(())
    }

    /// # Errors
    /// [`TwinError::Input`] when they are not one finite number for each chamber, [`TwinError::Pressure`] when one is beyond its range.
    fn check_pressures(&self, pressures: &[f64]) -> Result<(), TwinError> {
        if pressures.len() != self.chambers.len() || pressures.iter().any(|p| !p.is_finite()) {
            let what = format!("the pressures {pressures:?} of {} chambers", self.chambers.len());
            return Err(TwinError::Input { what });
        }
        let is_beyond = |(chamber, pressure): &(&Chamber, &f64)| {
            let [low, high] = chamber.range;
            let margin = RANGE_MARGIN * (high - low);
            !(low - margin..=high + margin).contains(pressure)
        };
        match self.chambers.iter().zip(pressures).find(is_beyond) {
            Some((Chamber { name, range, .. }, pressure)) => {
                Err(TwinError::Pressure { chamber: name.clone(), pressure: *pressure, range: *range })
            }
            None => Ok(()),
        }
    }

    /// A step in parts after the whole one failed with `error`; where that fails too, the state is as it was.
    fn step_in_halves(
        &self,
        (state, see): (&mut TwinState, &mut See),
        (pressures, duration): (&[f64], f64),
        error: TwinError,
    ) -> Result<(), TwinError> {
        state.lagged = None;
        let before = state.clone();
        let stepped = self.step_two_halves((state, see), (pressures, duration), (HALVINGS, error));
        if stepped.is_err() {
            *state = TwinState { work: state.work, ..before };
        }
        stepped
    }

    /// # Errors
    /// [`TwinError::State`] when the state is of a twin with other coordinates, chambers, regions, points or branches.
    pub(crate) fn check_state(&self, state: &TwinState) -> Result<(), TwinError> {
        let own_sizes = self.solids.iter().map(|solid| History::size(solid.block_count(), solid.branches.len()));
        let fits = state.coordinates().len() == self.coordinates()
            && state.pressures.len() == self.chambers.len()
            && own_sizes.eq(state.histories.iter().map(History::own_size));
        let counts = || [state.coordinates().len(), state.pressures.len(), state.histories.len()];
        let required = || [self.coordinates(), self.chambers.len(), self.solids.len()];
        if fits { Ok(()) } else { Err(TwinError::State { counts: counts(), required: required() }) }
    }

    fn step_in_parts(
        &self,
        (state, see): (&mut TwinState, &mut See),
        pressures: &[f64],
        duration: f64,
        halvings: usize,
    ) -> Result<(), TwinError> {
        match self.attempt_step(state, pressures, duration) {
            Ok(stencil) => {
                see(state, stencil);
                Ok(())
            }
            Err(error) => {
                state.lagged = None;
                self.step_two_halves((state, see), (pressures, duration), (halvings, error))
            }
        }
    }

    /// The halves of a step that failed with `error`, which is returned where it may not be halved again.
    fn step_two_halves(
        &self,
        (state, see): (&mut TwinState, &mut See),
        (pressures, duration): (&[f64], f64),
        (halvings, error): (usize, TwinError),
    ) -> Result<(), TwinError> {
        if halvings == 0 {
            return Err(error);
        }
        let middle: Vec<f64> = state.pressures.iter().zip(pressures).map(|(a, b)| 0.5 * (a + b)).collect();
        self.step_in_parts((state, see), &middle, 0.5 * duration, halvings - 1)?;
        self.step_in_parts((state, see), pressures, 0.5 * duration, halvings - 1)
    }

    /// One step of the scheme; the state changes only where it is found.
    fn attempt_step(&self, state: &mut TwinState, pressures: &[f64], duration: f64) -> Result<Stencil, TwinError> {
        self.prepare_factors(state, duration);
        let equations = Equations::new(self, state, pressures, duration);
        let time = state.time + duration;
        let (q, stresses) = equations.solve_step(state, time)?;
        for ((history, factors), now) in state.histories.iter_mut().zip(&state.factors.1).zip(&stresses) {
            history.advance(factors, &now.relaxing);
        }
        state.stresses = stresses;
        let velocity = equations.velocity(&q);
        let momentum = equations.momentum((&q, &velocity));
        state.past.push_state(time, [q, velocity, momentum]);
        (state.time, state.pressures) = (time, pressures.to_vec());
        state.work.steps += 1;
        Ok(equations.stencil)
    }

    /// The branches' factors over a step of this length.
    pub(crate) fn prepare_factors(&self, state: &mut TwinState, duration: f64) {
        if (state.factors.0 / duration - 1.0).abs() > SAME {
            let factors_of_solid =
                |solid: &Solid| solid.branches.iter().map(|branch| Factors::new(*branch, duration)).collect();
            state.factors = (duration, self.solids.iter().map(factors_of_solid).collect());
        }
    }
}

impl<'a> Equations<'a> {
    fn new(twin: &'a Twin, state: &TwinState, pressures: &[f64], duration: f64) -> Self {
        let stencil = state.past.step_stencil(duration);
        let acting = |((solid, history), factors): ((&Solid, &History), &Vec<Factors>)| {
            let mut held_stress = Vec::new();
            history.hold_stress(solid.mu, factors, &mut held_stress);
            Acting { constants: solid.constants_with_gain(factors.iter().map(|by| by.gain).sum()), held: held_stress }
        };
        let mut pressure_work = PressureWork::none(twin.coordinates());
        pressure_work.set_pressures(&twin.chambers, pressures);
        let past = [&state.past.coordinates, &state.past.velocities, &state.past.momenta];
        Self {
            twin,
            acting: twin.solids.iter().zip(&state.histories).zip(&state.factors.1).map(acting).collect(),
            pressure_work,
            past: past.map(|past| stencil.weighted_history(past)),
            stencil,
        }
    }

    /// q at the end of the step, and the stresses of its last residual.
    fn solve_step(&self, state: &mut TwinState, time: f64) -> Result<(Vec<f64>, Vec<Stresses>), TwinError> {
        let mut q = state.past.initial_guess(time);
        let (mut residual, mut stresses) = self.residual(&q, &mut state.work);
        if !is_finite(&residual) {
            q = state.coordinates().to_vec();
            (residual, stresses) = self.residual(&q, &mut state.work);
        }
        let fits = |lagged: &Lagged| (lagged.gamma / self.stencil.gamma - 1.0).abs() < SAME;
        let mut lagged = state.lagged.take().filter(fits);
        let loosest_tolerance = self.twin.tolerance;
        let tolerance = loosest_tolerance * (SLOW / self.stencil.gamma).powi(2).clamp(LEAST / loosest_tolerance, 1.0);
        let start_time = state.time;
        let failed = |change| TwinError::NoConvergence { time: start_time, iterations: MAX_ITERATIONS, change };
        let (mut change, mut size) = (Vec::new(), f64::INFINITY);
        for _ in 0..MAX_ITERATIONS {
            let usable = lagged.take().and_then(|lagged| next_change(lagged, &change, &residual));
            let (own, next) = match usable {
                Some(found) => found,
                None => self.inverse_tangent(&q, state).map(|own| first_change(own, &residual)).ok_or(failed(size))?,
            };
            (lagged, change) = (Some(own), next);
            add(&mut q, -1.0, &change);
            size = largest_entry(&change) / self.twin.size;
            if size < tolerance {
                state.lagged = lagged;
                return Ok((q, stresses));
            }
            if !size.is_finite() {
                break;
            }
            (residual, stresses) = self.residual(&q, &mut state.work);
            if !is_finite(&residual) {
                (residual, stresses, lagged) = self.taken_back((&mut q, &change), &mut state.work);
            }
        }
        Err(failed(size))
    }

    /// Forces and stresses where an iterate `q` is taken back along its last `change` by halves until no point is turned inside out; what was known of
    /// the tangent is dropped.
    fn taken_back(
        &self,
        (q, change): (&mut Vec<f64>, &[f64]),
        work: &mut Work,
    ) -> (Vec<f64>, Vec<Stresses>, Option<Lagged>) {
        let (mut part, mut forces) = (1.0, self.residual(q, work));
        while part > SHORTEST_PART && !is_finite(&forces.0) {
            part *= 0.5;
            add(q, part, change);
            forces = self.residual(q, work);
        }
        (forces.0, forces.1, None)
    }

    /// q̇ when the step ends at q.
    fn velocity(&self, q: &[f64]) -> Vec<f64> {
        let mut velocity = self.past[0].clone();
        add(&mut velocity, self.stencil.gamma, q);
        velocity
    }

    /// Of the water, J s.
    // At the state itself: that of the last residual would leave its difference in every later step.
    fn momentum(&self, motion: (&[f64], &[f64])) -> Vec<f64> {
        let (mut unused, mut momentum) = (vec![0.0; motion.0.len()], vec![0.0; motion.0.len()]);
        if let Some(water) = &self.twin.water {
            water.add_forces(motion, self.stencil.gamma, (&mut unused, &mut momentum));
        }
        momentum
    }

    fn residual(&self, q: &[f64], work: &mut Work) -> (Vec<f64>, Vec<Stresses>) {
        work.residuals += 1;
        let (twin, gamma) = (self.twin, self.stencil.gamma);
        let velocity = self.velocity(q);
        let mut acceleration = self.past[1].clone();
        add(&mut acceleration, gamma, &velocity);
        let mut residual = vec![0.0; q.len()];
        multiply(&twin.mass, &acceleration, &mut residual);
        let mut momentum = vec![0.0; q.len()];
        if let Some(water) = &twin.water {
            water.add_forces((q, &velocity), gamma, (&mut residual, &mut momentum));
            add(&mut residual, 1.0, &self.past[2]);
        }
        let mut lanes = vec![splat(0.0); q.len()];
        let mut stresses = vec![Stresses::default(); twin.solids.len()];
        for ((solid, acting), stresses) in twin.solids.iter().zip(&self.acting).zip(&mut stresses) {
            solid.add_forces(q, acting, (&mut lanes, stresses));
        }
        add_reduced(&lanes, &mut residual);
        self.pressure_work.subtract_gradient(q, &mut residual);
        (residual, stresses)
    }

    /// The inverse of ∂residual/∂q; none where it is singular.
    fn inverse_tangent(&self, q: &[f64], state: &mut TwinState) -> Option<Lagged> {
        state.work.tangents += 1;
        let (twin, gamma) = (self.twin, self.stencil.gamma);
        let mut tangent: Vec<f64> = twin.mass.iter().map(|m| m * gamma * gamma).collect();
        let mut lanes = single_precision::zero_triangle(q.len());
        for ((solid, acting), before) in twin.solids.iter().zip(&self.acting).zip(&state.stresses) {
            solid.add_stiffness(q, (acting, &before.law), &mut lanes);
        }
        add_triangle(single_precision::lane_sums(&lanes), &mut tangent);
        self.pressure_work.subtract_hessian(q, &mut tangent);
        if let Some(water) = &twin.water {
            water.add_stiffness((q, &self.velocity(q)), gamma, &mut tangent);
        }
        Some(Lagged { inverse: inverse(tangent)?, gamma })
    }
}

/// H r, to be subtracted.
fn first_change(lagged: Lagged, residual: &[f64]) -> (Lagged, Vec<f64>) {
    let mut change = vec![0.0; residual.len()];
    multiply(&lagged.inverse, residual, &mut change);
    (lagged, change)
}

/// The same on a lagged inverse, updated by what the change `before` it left; none where it converges too slowly.
fn next_change(lagged: Lagged, before: &[f64], residual: &[f64]) -> Option<(Lagged, Vec<f64>)> {
    let (mut lagged, mut change) = first_change(lagged, residual);
    if before.is_empty() {
        return Some((lagged, change));
    }
    let slow = largest_entry(&change) > REFRESH_ABOVE * largest_entry(before);
    (!slow && broyden_update(&mut lagged.inverse, before, &mut change)).then_some((lagged, change))
}

/// Largest absolute entry; not a number where one is not.
fn largest_entry(x: &[f64]) -> f64 {
    if x.iter().any(|entry| entry.is_nan()) {
        return f64::NAN;
    }
    x.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}

fn is_finite(forces: &[f64]) -> bool {
    forces.iter().all(|force| force.is_finite())
}
