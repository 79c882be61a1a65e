//! Thrust of a simulated motion: its mean, and the gradient of that through the finite elements.
//!
//! A wave of pressure moves a body; marks on it are read at every step; a trained network or theory tells the thrust; its mean
//! over the steps after `settled` is L. L's slope by the marks is handed to the motion's adjoint, which gives ∂L/∂E and ∂L/∂p of
//! every step; the wave's own derivatives make ∂L/∂amplitude and ∂L/∂frequency of these. What theory has as a rate in time adds
//! up to its ends, so no step is differentiated.
//!
//! Stands on: fem, hydro, fit. Never knows: where body and model came from.

use fem::{March, Slope, Solver, State};
use fit::network::Network;
use hydro::{Tail, Terms};
use si::{Hertz, Newton, Pascal, Point2, Second};
use std::f64::consts::TAU;

use super::climb::Hill;
use crate::fault::{Fault, Outcome};

/// Bytes that a recorded motion may take.
const MEMORY: usize = 1 << 30;

/// Two sides in turn: p = A σ(±k sin 2πft), a square wave whose edges have a slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// A, Pa.
    pub amplitude: Pascal,
    /// f, Hz.
    pub frequency: Hertz,
    /// k: 1 is a sine, 20 a square.
    pub sharpness: f64,
}

/// A pressure, its rate, and both's derivatives by amplitude and frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pressed {
    value: Pascal,
    rate: f64,
    by_amplitude: [f64; 2],
    by_frequency: [f64; 2],
}

impl Wave {
    /// Pressures of two sides at time `t` (s), Pa.
    pub fn at(&self, t: Second) -> Vec<Pascal> {
        [1.0, -1.0].iter().map(|side| self.pressed(*side, t).value).collect()
    }

    fn pressed(&self, side: f64, t: Second) -> Pressed {
        let (omega, k) = (TAU * self.frequency, side * self.sharpness);
        let (sin, cos) = (omega * t).sin_cos();
        let share = 1.0 / (1.0 + (-k * sin).exp());
        let bend = share * (1.0 - share);
        // σ' = σ(1−σ), σ'' = σ'(1 − 2σ); z = k sin ωt
        let (rate_z, by_f_z) = (k * omega * cos, k * TAU * t * cos);
        let by_f_rate_z = k * TAU * cos - k * omega * TAU * t * sin;
        let by_f_rate = bend * (1.0 - 2.0 * share) * by_f_z * rate_z + bend * by_f_rate_z;
        let a = self.amplitude;
        Pressed {
            value: a * share,
            rate: a * bend * rate_z,
            by_amplitude: [share, bend * rate_z],
            by_frequency: [a * bend * by_f_z, a * by_f_rate],
        }
    }
}

/// What tells the thrust.
#[derive(Debug, Clone, Copy)]
pub enum Teller<'a> {
    /// The network: places and velocities of the marks, pressures and their rates.
    Network(&'a Network),
    /// Theory with its five coefficients, as `rungs::theory` has them.
    Theory(&'a Tail, [f64; 5]),
}

/// A body to move and what is read of it.
#[derive(Debug, Clone, Copy)]
pub struct Bench<'a> {
    /// Nodes of the body.
    pub nodes: usize,
    /// Marks as weighted nodes, from the head to the fin.
    pub marks: &'a [Vec<(u32, f64)>],
    /// How steps are taken.
    pub march: March,
    /// How many.
    pub steps: usize,
    /// Steps before the mean begins.
    pub settled: usize,
}

/// The mean thrust and what it feels.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    /// N.
    pub mean: Newton,
    /// By Young's modulus of each region, N/Pa.
    pub by_youngs_modulus: Vec<f64>,
    /// By the wave's amplitude, N/Pa.
    pub by_amplitude: f64,
    /// By its frequency, N/Hz.
    pub by_frequency: f64,
}

/// A thrust at one step and its slopes.
#[derive(Debug, Clone, PartialEq, Default)]
struct Instant {
    value: f64,
    by_place: Vec<Point2>,
    by_velocity: Vec<Point2>,
    by_pressure: Vec<f64>,
    by_rate: Vec<f64>,
}

impl Bench<'_> {
    /// The mean thrust (N) of a body under `wave`, without a gradient.
    ///
    /// # Errors
    /// A [`Fault`] when the body finds no motion.
    pub fn mean(&self, solver: &mut Solver, wave: &Wave, teller: &Teller) -> Outcome<Newton> {
        let (mut sum, mut n) = (0.0, 0);
        let rest = State::rest(self.nodes);
        let mut see = |t: Second, state: &State| {
            n += 1;
            sum += self.instant(n, t, state, wave, teller).value;
        };
        let pressures = |t: Second| wave.at(t);
        solver.march(&self.march, &rest, &pressures, self.steps, &mut see).map_err(Fault::from_tool)?;
        Ok(sum)
    }

    /// The mean thrust and its gradient.
    ///
    /// # Errors
    /// A [`Fault`] when the body finds no motion or a step's tangent cannot be solved back.
    pub fn gradient(&self, solver: &mut Solver, wave: &Wave, teller: &Teller) -> Outcome<Told> {
        let rest = State::rest(self.nodes);
        let pressures = |t: Second| wave.at(t);
        let made = solver.record(&self.march, &rest, &pressures, self.steps, MEMORY).map_err(Fault::from_tool)?;
        let mut told = Told { mean: 0.0, by_youngs_modulus: Vec::new(), by_amplitude: 0.0, by_frequency: 0.0 };
        let times = made.times().to_vec();
        let mut asks = |n: usize, state: &State| {
            let here = self.instant(n, times[n], state, wave, teller);
            told.mean += here.value;
            for (side, (p, r)) in [1.0, -1.0].iter().zip(here.by_pressure.iter().zip(&here.by_rate)) {
                let at = wave.pressed(*side, times[n]);
                told.by_amplitude += p * at.by_amplitude[0] + r * at.by_amplitude[1];
                told.by_frequency += p * at.by_frequency[0] + r * at.by_frequency[1];
            }
            self.slope(&here, state)
        };
        let by = solver.backward(&made, &mut asks).map_err(Fault::from_tool)?;
        for (n, step) in by.pressures.iter().enumerate() {
            for (side, slope) in [1.0, -1.0].iter().zip(step) {
                let at = wave.pressed(*side, times[n + 1]);
                told.by_amplitude += slope * at.by_amplitude[0];
                told.by_frequency += slope * at.by_frequency[0];
            }
        }
        told.by_youngs_modulus = by.regions.iter().map(|r| r.youngs_modulus).collect();
        Ok(told)
    }

    /// The share of step `n` in the mean.
    fn instant(&self, n: usize, t: Second, state: &State, wave: &Wave, teller: &Teller) -> Instant {
        let first = self.settled + 1;
        let ends = match n {
            n if n == self.settled => -1.0,
            n if n == self.steps => 1.0,
            _ => 0.0,
        };
        let counted = f64::from(u8::from(n >= first));
        if counted == 0.0 && ends == 0.0 {
            return Instant::default();
        }
        let count = (self.steps - self.settled) as f64;
        let (moved, speed) = (self.read(&state.displacement), self.read(&state.velocity));
        match teller {
            Teller::Network(network) if counted > 0.0 => self.of_network(network, &moved, &speed, wave, t),
            Teller::Network(_) => Instant::default(),
            Teller::Theory(tail, c) => {
                let terms = tail.terms(&moved, &speed);
                of_theory(&terms, c, counted / count, ends / (count * self.march.step), &speed)
            }
        }
    }

    fn of_network(&self, network: &Network, moved: &[Point2], speed: &[Point2], wave: &Wave, t: Second) -> Instant {
        let sides = [1.0, -1.0].map(|side| wave.pressed(side, t));
        let flat = |points: &[Point2]| points.iter().flatten().copied().collect::<Vec<f64>>();
        let row = [flat(moved), flat(speed), sides.map(|s| s.value).to_vec(), sides.map(|s| s.rate).to_vec()].concat();
        let (value, by) = network.slope(&row);
        let part = 1.0 / (self.steps - self.settled) as f64;
        let by: Vec<f64> = by.iter().map(|b| part * b).collect();
        let marks = 2 * moved.len();
        let pairs = |of: &[f64]| of.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        Instant {
            value: part * value,
            by_place: pairs(&by[..marks]),
            by_velocity: pairs(&by[marks..2 * marks]),
            by_pressure: by[2 * marks..2 * marks + 2].to_vec(),
            by_rate: by[2 * marks + 2..].to_vec(),
        }
    }

    /// x and y of every mark.
    fn read(&self, field: &[f64]) -> Vec<Point2> {
        let one = |mark: &Vec<(u32, f64)>| {
            [0, 1].map(|k| mark.iter().map(|&(node, w)| w * field[3 * node as usize + k]).sum::<f64>())
        };
        self.marks.iter().map(one).collect()
    }

    /// Slopes by marks as slopes by nodes.
    fn slope(&self, here: &Instant, state: &State) -> Slope {
        if here.by_place.is_empty() {
            return Slope::default();
        }
        let spread = |by: &[Point2]| {
            let mut field = vec![0.0; state.displacement.len()];
            for (mark, by) in self.marks.iter().zip(by) {
                for &(node, w) in mark {
                    (0..2).for_each(|k| field[3 * node as usize + k] += w * by[k]);
                }
            }
            field
        };
        Slope { displacement: spread(&here.by_place), velocity: spread(&here.by_velocity) }
    }
}

/// Theory's share: `part` of what acts at an instant, and `ends` of what stands as a rate in time.
fn of_theory(terms: &Terms, c: &[f64; 5], part: f64, ends: f64, speed: &[Point2]) -> Instant {
    let last = speed.len() - 1;
    let shares = [(&terms.shed, part * c[0]), (&terms.drag, part * c[2]), (&terms.momentum, ends * c[1])];
    let sum = |of: fn(&hydro::Part) -> &Vec<Point2>| {
        (0..speed.len()).map(|m| [0, 1].map(|k| shares.iter().map(|(p, w)| w * of(p)[m][k]).sum())).collect()
    };
    let (by_place, mut by_velocity): (Vec<Point2>, Vec<Point2>) = (sum(|p| &p.by_place), sum(|p| &p.by_velocity));
    by_velocity[last][0] += ends * c[3];
    let value = shares.iter().map(|(p, w)| w * p.value).sum::<f64>() + ends * c[3] * speed[last][0] + part * c[4];
    Instant { value, by_place, by_velocity, ..Instant::default() }
}

/// A body as a hill to climb: its slope comes through the finite elements.
pub struct Climbed<'a> {
    /// What is read of it.
    pub bench: &'a Bench<'a>,
    /// It.
    pub solver: &'a mut Solver,
    /// Who tells its thrust.
    pub teller: &'a Teller<'a>,
}

impl Hill for Climbed<'_> {
    fn height(&mut self, wave: &Wave) -> Outcome<Newton> {
        self.bench.mean(self.solver, wave, self.teller)
    }

    fn slope(&mut self, wave: &Wave) -> Outcome<[f64; 2]> {
        let told = self.bench.gradient(self.solver, wave, self.teller)?;
        Ok([told.by_amplitude, told.by_frequency])
    }
}
