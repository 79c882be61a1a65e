//! Optimal actuation: amplitude and frequency of the square wave of pressure with the greatest mean thrust in the simulator.
//!
//! The reduced model flaps in still water with the drag identified from a release; thrust models thrust on measured motions are
//! evaluated on the simulated ones. The search stays within the pressures and frequencies of the force measurements, beyond which no
//! thrust model was thrust, and within the pressures of identification, beyond which a slack wall may buckle. A coarse scan is
//! followed by gradient ascent with finite differences.

use hydro::Coefficients;
use optimize::network::Network;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Second, Series};

use crate::records::{
    ActuationPoint, Best, Check, Drag, Identified, Level, Mesh, OptimalActuation as Record, Reduced, Relaxation, Thrust,
};
use crate::subject::Specimen;
use ::thrust::ascent::{Limits, ascend};
use ::thrust::flapping::{FlappingModel, MeanThrust, mean};
use ::thrust::models::linear::Weighted;
use ::thrust::outline::Outline;
use ::thrust::square_wave::SquareWave;
use ::thrust::{Fitted, Run, ThrustModel};
use diagnostics::{Diagnostic, Result};
use sysid::{Body, ReducedBody};
use workflow::needs::Maybe;
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct OptimalActuation;

/// `[optimal_actuation]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Normal drag coefficient where none was identified from a release in water, no unit.
    normal_drag_coefficient: f64,
    /// Sharpness of the wave: k of σ(k sin 2πft), no unit.
    sharpness: f64,
    /// Time steps of a cycle.
    steps_per_cycle: usize,
    /// Settling cycles, and cycles over which thrust is averaged.
    cycles: [usize; 2],
    /// Amplitudes and frequencies of the scan.
    scan: [usize; 2],
    /// Iterations of the ascent.
    iterations: usize,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    body: Body,
    /// The half of the cycle in which each chamber is filled; none of a chamber that stays vented.
    halves: Vec<Option<usize>>,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { body: Body::of(&of.card), halves: halves(&of.card) }
    }
}

/// The first two channels that any trial fills in turn fill their chambers in the two halves of a cycle.
fn halves(card: &lab::Card) -> Vec<Option<usize>> {
    let flapping = card.trial.iter().map(|t| t.experiment.channels()).find(|channels| channels.len() > 1);
    let turn = flapping.map(|channels| &channels[..2]).unwrap_or_default();
    card.chamber.iter().map(|chamber| turn.iter().position(|channel| *channel == chamber.channel)).collect()
}

impl Stage for OptimalActuation {
    type Settings = Settings;
    type Card = Card;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, (Thrust, Maybe<Drag>));
    type Makes = Record;
    const DESCRIPTION: &'static str = "the actuation of greatest mean thrust is optimised";
    const VERSION: u32 = 7;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Record> {
        let ((mesh, identified, reduced), relaxation, (thrust, Maybe(water))) = needs;
        let limits = limits(&thrust.runs, &identified, set.iterations)?;
        let outline = Outline::new(&card.body, &mesh.solid);
        let (wet, spots) = outline.whole(thrust.density, thrust.sections)?;
        let model = mesh.model(&card.body)?.with_spots(spots);
        let reduced_body = ReducedBody::of(&model, &relaxation.silicone(&model, &identified)?, &reduced.data)?;
        let tail = outline.marked(thrust.density, thrust.sections)?;
        let rows = reduced_body.rows(&card.body.markers_by_x());
        let stations = reduced_body.rows(&(card.body.markers.len()..reduced_body.markers()).collect::<Vec<_>>());
        let flapping = FlappingModel {
            reduced_body: &reduced_body,
            tail: &tail,
            rows: &rows,
            wet: (&wet, &stations),
            halves: card.halves.clone(),
            by: water.map_or(Coefficients { added: 1.0, drag: set.normal_drag_coefficient }, |w| w.by),
            half: model.system.mesh().symmetry_plane_z,
            steps_per_cycle: set.steps_per_cycle,
            cycles: set.cycles,
        };
        let models = models(&thrust)?;
        let search = Search { flapping: &flapping, models: &models, limits, set };
        let scan = search.scan(&|part| context.progress(0.2 + 0.3 * part, "scanning"))?;
        context.progress(0.5, "gradient ascent");
        let filmed = thrust.runs.iter().map(Run::amplitude_of_tip).fold(f64::MIN_POSITIVE, f64::max);
        let optimised = |place: usize| search.ascend_from(&scan, place, filmed);
        let best = (0..models.len()).into_par_iter().map(optimised).collect::<Result<_>>()?;
        Ok(Record {
            highest_pa: limits.amplitude,
            frequencies_hz: limits.frequency,
            best,
            scan,
            check: check(&flapping, &models[0].1, &thrust.runs, &limits)?,
            coordinates: reduced_body.coordinates(),
        })
    }
}

/// Limits of the search: the range of the force measurements, and for pressures also that of identification.
fn limits(runs: &[Run], identified: &Identified, iterations: usize) -> Result<Limits> {
    let most = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let slowest = runs.iter().map(|r| r.frequency).fold(f64::INFINITY, f64::min);
    let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
    let amplitude = most(highest).min(known);
    if amplitude <= 0.0 || !slowest.is_finite() {
        return Err(Diagnostic::new(
            "there is no actuation to optimise",
            "no pressure occurs both in force measurements and in identification",
            "record a trial with a force log",
        ));
    }
    Ok(Limits { amplitude, frequency: [slowest, most(|r| r.frequency)], iterations })
}

/// The highest measured pressure of a run, Pa: below the command where a half cycle is too short to fill the chamber.
fn highest(run: &Run) -> Pascal {
    run.pressure.iter().flatten().copied().fold(0.0, f64::max)
}

type Named = (ThrustModel, Fitted);

/// Fitted theory and the network, thrust on the card's training runs.
fn models(thrust: &Thrust) -> Result<Vec<Named>> {
    let theory = Weighted { model: ThrustModel::Theory, weights: thrust.coefficients.clone() };
    let network = Network::from_safetensors(&thrust.network)?;
    Ok(vec![
        (ThrustModel::Theory, Fitted::Weighted(theory)),
        (ThrustModel::Network, Fitted::Network(Box::new(network))),
    ])
}

/// The search of the optimal actuation.
#[derive(Clone, Copy)]
struct Search<'a> {
    flapping: &'a FlappingModel<'a>,
    models: &'a [Named],
    limits: Limits,
    set: &'a Settings,
}

impl Search<'_> {
    /// An even grid over the limits: amplitudes from half the highest, all frequencies.
    fn scan(&self, heard: &(dyn Fn(f64) + Sync)) -> Result<Vec<ActuationPoint>> {
        let Self { flapping, models, limits, set } = *self;
        let [amplitudes, frequencies] = set.scan.map(|n| n.max(1));
        let frequencies = if limits.frequency[1] > limits.frequency[0] { frequencies } else { 1 };
        let even = |i: usize, n: usize, from: f64| from + (1.0 - from) * i as f64 / (n.max(2) - 1) as f64;
        let places: Vec<[f64; 2]> = (0..amplitudes)
            .flat_map(|a| {
                (0..frequencies).map(move |f| [even(amplitudes - 1 - a, amplitudes, 0.5), even(f, frequencies, 0.0)])
            })
            .collect();
        let like = SquareWave { amplitude: 0.0, frequency: 0.0, sharpness: set.sharpness };
        let one = |(number, place): (usize, &[f64; 2])| {
            let wave = limits.wave(*place, like);
            let run = flapping.run(&wave)?;
            heard(number as f64 / places.len() as f64);
            Ok(actuation_point(&wave, models.iter().map(|(_, model)| mean(model, &run)).collect()))
        };
        places.par_iter().enumerate().map(one).collect()
    }

    /// Gradient ascent from the best point of the scan by the model at `place`; `filmed` is the amplitude of the tip in films, m.
    fn ascend_from(&self, scan: &[ActuationPoint], place: usize, filmed: Metre) -> Result<Best> {
        let Self { flapping, models, limits, set } = *self;
        let (kind, model) = &models[place];
        let start = scan.iter().max_by(|a, b| a.thrust_n[place].total_cmp(&b.thrust_n[place]));
        let start = start.ok_or_else(|| {
            Diagnostic::new("no actuation was scanned", "`[optimal_actuation] scan` has no points", "set at least one")
        })?;
        let start =
            SquareWave { amplitude: start.amplitude_pa, frequency: start.frequency_hz, sharpness: set.sharpness };
        let mut objective = MeanThrust { flapping, model, limits, simulations: scan.len() };
        let iterates = ascend(&mut objective, start, &limits)?;
        let simulations = objective.simulations;
        let run = flapping.run(&iterates[iterates.len() - 1].0)?;
        Ok(Best {
            model: kind.name().into(),
            iterates: iterates.iter().map(|(wave, thrust)| actuation_point(wave, vec![*thrust])).collect(),
            predicted_n: models.iter().map(|(_, model)| mean(model, &run)).collect(),
            amplitude_ratio: run.amplitude_of_tip() / filmed,
            simulations,
        })
    }
}

fn actuation_point(wave: &SquareWave, thrust_n: Vec<f64>) -> ActuationPoint {
    ActuationPoint { amplitude_pa: wave.amplitude, frequency_hz: wave.frequency, thrust_n }
}

/// A square wave overshoots the pressure of a held step: a run counts as within the limits up to this factor.
const NEAR: f64 = 1.05;

/// Of the runs within the limits, the one of greatest mean force beside its simulation under its measured pressures, repeated periodically.
fn check(flapping: &FlappingModel, theory: &Fitted, runs: &[Run], limits: &Limits) -> Result<Check> {
    let force = |run: &Run| run.force.iter().sum::<f64>() / run.len().max(1) as f64;
    let within = runs.iter().filter(|r| highest(r) <= NEAR * limits.amplitude);
    let run = within.max_by(|a, b| force(a).total_cmp(&force(b))).ok_or_else(|| {
        let limit = format!("moduli were identified up to {:.0} Pa", limits.amplitude);
        Diagnostic::new(
            "no run can be compared with the simulator",
            limit,
            "record a trial with a force log at a lower pressure",
        )
    })?;
    let column = |c: usize| Series::new(0.0, run.rate, run.pressure.iter().map(|p| p[c]).collect());
    let gauges: Vec<Series> = (0..flapping.halves.len()).map(column).collect::<Result<_, _>>()?;
    let cycles = (run.len() as f64 / run.rate * run.frequency).round().max(1.0);
    let around = |t: Second| t.rem_euclid(cycles / run.frequency);
    let pressures = |t: Second| gauges.iter().map(|g| g.at(around(t))).collect();
    let simulated = flapping.run_under(run.frequency, run.amplitude, &pressures)?;
    Ok(Check {
        run: run.id.clone(),
        amplitude_m: [simulated.amplitude_of_tip(), run.amplitude_of_tip()],
        mean_n: [mean(theory, &simulated), mean(theory, run), force(run)],
    })
}
