//! The levels of one solver, each from the equilibria of earlier ones.

use std::time::Instant;

use fem::{Parameter, StaticSettings};
use si::{Point2, Second};

use super::level::{Derivatives, LevelCorrection, PressureLevel, SimulatedLevel};
use super::statics::{EquilibriumShape, Statics, Unknowns};
use crate::load_path::{Beginning, LoadPath, Steps};
use crate::model::{BODY, Elastic};
use crate::surrogate::{Extra, KnownShape, Load, Surrogate};
use diagnostics::{Diagnostic, Result};

/// Newton iterations after which a guess from other bodies is given up: of those that lead to an equilibrium nearly all need fewer. With 12 half of
/// the guesses beyond the buckle of a thin tail were given up near their end, and 14 levels took 106 s instead of 83 s.
const GUESSED: usize = 20;

/// The data of one solve, shared by its solvers.
pub(super) struct Part<'a> {
    pub unknowns: &'a Unknowns,
    /// By level: what is added to it; empty: nothing.
    pub corrections: &'a [LevelCorrection],
    pub levels: &'a [PressureLevel],
    pub settings: &'a StaticSettings,
    /// Equilibria of earlier solves.
    pub known: &'a Surrogate,
    pub unit: f64,
    pub elastic: Elastic,
    pub derivatives: Derivatives,
}

/// Levels with their numbers, and the shapes on the paths that had to be followed to them.
#[derive(Default)]
pub(super) struct Solved {
    pub levels: Vec<(usize, SimulatedLevel)>,
    pub on_the_way: Vec<KnownShape>,
}

impl Solved {
    pub fn and(mut self, other: Self) -> Self {
        self.levels.extend(other.levels);
        self.on_the_way.extend(other.on_the_way);
        self
    }
}

impl Part<'_> {
    /// Solves some levels, each from the initial guess predicted by earlier solves and by the levels before it.
    pub fn solve(&self, solver: &mut dyn Statics, numbers: &[usize]) -> Result<Solved> {
        solver.set_constants(&self.elastic)?;
        let (mut solved, mut equilibria) = (Solved::default(), Surrogate::default());
        for &number in numbers {
            let (load, began) = (self.load(number), Instant::now());
            let simulated = match self.guessed_level(number, &load, &equilibria, solver) {
                Some(simulated) => simulated,
                None => {
                    let (end, passed) = self.followed_equilibrium(number, &load, &equilibria, solver)?;
                    let forward_seconds = began.elapsed().as_secs_f64();
                    passed.iter().for_each(|shape| equilibria.add(shape.clone()));
                    solved.on_the_way.extend(passed);
                    let simulated = self.simulate_level(number, &load, (end, forward_seconds), solver);
                    simulated.map_err(|e| no_equilibrium(&self.levels[number], e))?
                }
            };
            let (shape, slopes) = (simulated.shape.clone(), simulated.slopes.clone());
            equilibria.add(KnownShape { load, shape, slopes });
            solved.levels.push((number, simulated));
        }
        Ok(solved)
    }

    pub fn load(&self, level: usize) -> Load {
        Load::new(self.levels[level].filled(), self.levels[level].top(), &self.elastic, self.unit)
    }

    /// A level whose guess leads to a stable equilibrium.
    // Beside a bifurcation Newton's method finds the saddle as readily as the minimum, whose derivatives are refused; the path of rising pressure
    // stays on the stable side.
    fn guessed_level(
        &self,
        number: usize,
        load: &Load,
        equilibria: &Surrogate,
        solver: &mut dyn Statics,
    ) -> Option<SimulatedLevel> {
        let guess = Surrogate::predict(&[equilibria, self.known], load)?;
        let began = Instant::now();
        let equilibrium = self.equilibrium_near_guess(&self.levels[number], guess, solver).ok()?;
        self.simulate_level(number, load, (equilibrium, began.elapsed().as_secs_f64()), solver).ok()
    }

    /// The equilibrium of a level at the end of a path to it, and the shapes on the way.
    fn followed_equilibrium(
        &self,
        number: usize,
        load: &Load,
        equilibria: &Surrogate,
        solver: &mut dyn Statics,
    ) -> Result<(EquilibriumShape, Vec<KnownShape>)> {
        let level = &self.levels[number];
        let nearest = Surrogate::predict(&[equilibria, self.known], load).map(|(nearest, _)| nearest);
        // A body of other constants may have its wall on the other side of a buckle, and the way from there crosses it backwards: such a level
        // took minutes. Below this one the same body has buckled or not on the way of rising pressure.
        let (below, undeformed) = (equilibria.below(load), KnownShape::at_rest(load, self.unknowns.count()));
        let (beginning, steps) = match (Beginning::on_the_way(&below, load), nearest) {
            (Some(beginning), _) => {
                let steps = beginning.last_step().map_or(Steps::FROM_NEARBY, |last| Steps::FROM_NEARBY.after(last));
                (beginning, steps)
            }
            (None, Some(nearest)) => (Beginning::at(nearest), Steps::FROM_NEARBY),
            (None, None) => (Beginning::at(&undeformed), Steps::FROM_REST),
        };
        let Self { elastic, unit, .. } = self;
        // Neither the shapes of other constants nor those before a buckle predict the way: it is extrapolated from its own points.
        let path = LoadPath { from: beginning, to: load, pressures: &level.pressures, elastic, unit: *unit, steps };
        let (points, end) = path.follow(solver, self.settings);
        let end = end.map_err(|e| no_equilibrium(level, e))?;
        Ok((end, points.into_iter().map(|point| KnownShape::new(point.load, point.shape)).collect()))
    }

    /// The equilibrium of a level near its guess, which is kriged from known ones: the Gauss-Newton search of Dory took 23 s instead of 40 s.
    fn equilibrium_near_guess(
        &self,
        level: &PressureLevel,
        (nearest, predicted): (&KnownShape, Vec<f64>),
        solver: &mut dyn Statics,
    ) -> Result<EquilibriumShape> {
        let settings = StaticSettings { max_iterations: GUESSED, ..*self.settings };
        solver.equilibrium_near(&level.pressures, &nearest.shape, &predicted, &settings)
    }

    /// Markers and derivatives at an equilibrium.
    fn simulate_level(
        &self,
        number: usize,
        load: &Load,
        (equilibrium, forward_seconds): (EquilibriumShape, Second),
        solver: &mut dyn Statics,
    ) -> Result<SimulatedLevel> {
        let unknowns = self.unknowns;
        let nothing = LevelCorrection::default();
        let correction = self.corrections.get(number).unwrap_or(&nothing);
        let markers = apply_corrections(unknowns.markers(&equilibrium.unknowns), &correction.markers);
        let began = Instant::now();
        let gradient = match self.derivatives {
            Derivatives::Gradient => solver.loss_by_moduli(&self.loss_by_markers(&self.levels[number], &markers))?,
            _ => Vec::new(),
        };
        let fields = match self.derivatives {
            Derivatives::None | Derivatives::Gradient => Vec::new(),
            wanted => solver.sensitivities(&sensitivity_parameters(wanted, self.elastic.youngs_moduli.len()))?,
        };
        let derivative_seconds = began.elapsed().as_secs_f64();
        let mut by_parameter = correction.sensitivities.iter();
        let marker_sensitivity = |field: &Vec<f64>| {
            apply_corrections(unknowns.markers(field), by_parameter.next().map_or(&[], Vec::as_slice))
        };
        let sensitivities = fields.iter().map(marker_sensitivity).collect();
        let slopes = load.slopes(&self.elastic.youngs_moduli, fields, extra_coordinates(self.derivatives));
        let shape = equilibrium.unknowns;
        Ok(SimulatedLevel {
            markers,
            gradient,
            sensitivities,
            displacement: unknowns.displacement(&shape),
            shape,
            slopes,
            forward_seconds,
            derivative_seconds,
        })
    }

    /// The derivative by each marker's displacement (1/m) of this level's part of the mean distance, 1/(levels · markers) Σ |simulated −
    /// measured|, m.
    fn loss_by_markers(&self, level: &PressureLevel, markers: &[Point2]) -> Vec<Point2> {
        let share = 1.0 / (self.levels.len() * markers.len()) as f64;
        let by_marker = |(simulated, measured): (&Point2, &Point2)| {
            let difference = [simulated[0] - measured[0], simulated[1] - measured[1]];
            let distance = difference[0].hypot(difference[1]).max(f64::MIN_POSITIVE);
            difference.map(|part| share * part / distance)
        };
        // length: one measured place a marker
        markers.iter().zip(&level.measured).map(by_marker).collect()
    }
}

/// Points with what is added to each; as they are where nothing is.
fn apply_corrections(mut points: Vec<Point2>, corrections: &[Point2]) -> Vec<Point2> {
    // length: one correction a marker, or none
    for (point, correction) in points.iter_mut().zip(corrections) {
        *point = [point[0] + correction[0], point[1] + correction[1]];
    }
    points
}

/// The moduli of all solids, then what else is wanted.
fn sensitivity_parameters(wanted: Derivatives, solids: usize) -> Vec<Parameter> {
    let moduli = (0..solids).map(Parameter::YoungsModulus);
    match wanted {
        Derivatives::AllSensitivities => moduli.chain((0..solids).map(Parameter::PoissonsRatio)).collect(),
        Derivatives::StiffeningSensitivities => moduli.chain(TERMS.map(stiffening_parameter)).collect(),
        _ => moduli.collect(),
    }
}

/// The terms of [`Parameter::Stiffening`].
const TERMS: [usize; 2] = [0, 1];

fn stiffening_parameter(term: usize) -> Parameter {
    Parameter::Stiffening { region: BODY, term }
}

/// What sensitivities are by, beside the moduli.
fn extra_coordinates(wanted: Derivatives) -> Extra {
    if wanted == Derivatives::AllSensitivities { Extra::PoissonsRatios } else { Extra::Stiffening }
}

fn no_equilibrium(level: &PressureLevel, error: Diagnostic) -> Diagnostic {
    let pressures: Vec<String> = level.pressures.iter().map(|p| format!("{:.1}", p / si::MILLIBAR)).collect();
    error.while_doing(format!("no equilibrium at {} mbar", pressures.join(" / ")))
}
