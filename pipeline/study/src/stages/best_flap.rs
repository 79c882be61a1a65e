//! Best flap: which amplitude and frequency of a square wave of pressure give the most thrust, asked of the simulator.
//!
//! The identified model, reduced, flaps in still water, its drag as a release told it; models of thrust that were learnt from real motions are told of the
//! simulated ones. No wave leaves the pressures and frequencies that were weighed, beyond which no model of thrust has learnt
//! anything, nor the pressures by which moduli were identified, beyond which a slack wall may leave its shape. A coarse scan comes first, then steps uphill along differences.
//!
//! Stands on: the swing, the room `thrust`. Never knows: how moduli, damping or models of thrust were found.

use fit::network::Network;
use hydro::Coefficients;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Pascal, Second, Series};

use super::swing;
use crate::fault::{Fault, Outcome};
use crate::model::{Model, Small};
use crate::needs::Maybe;
use crate::records::{Best, BestFlap as Record, Check, Damping, Drag, Flap, Identified, Level, Mesh, Reduced, Thrust};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;
use crate::thrust::climb::{Limits, climb};
use crate::thrust::outline::{self, Outline};
use crate::thrust::rungs::linear::Weighted;
use crate::thrust::simulated::Wave;
use crate::thrust::swim::{Asked, Swimmer, mean};
use crate::thrust::{Fitted, Run, Rung};

/// The stage.
pub struct BestFlap;

/// `[best_flap]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Of the water's drag across the flow where no release in water told it, no unit.
    drag: f64,
    /// How square the wave is: k of σ(k sin 2πft), no unit.
    sharpness: f64,
    /// Steps of a beat.
    per_beat: usize,
    /// Beats before the mean thrust begins, and beats of it.
    beats: [usize; 2],
    /// Amplitudes and frequencies of the scan.
    scan: [usize; 2],
    /// Steps uphill that are tried.
    rounds: usize,
}

impl Stage for BestFlap {
    type Settings = Settings;
    type Needs = ((Mesh, Identified, Reduced), Damping, (Thrust, Maybe<Drag>));
    type Makes = Record;
    const STORY: &'static str = "the simulator is asked for the flap of the most thrust";
    const EDITION: u32 = 5;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio, s.density]);
        json!({
            "body": region(&solid.body),
            "spine": region(&solid.spine),
            "clamp": card.clamp.below_x,
            "length": card.length,
            "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>(),
            "sides": card.chamber.iter().map(|c| c.log.word()).collect::<Vec<_>>(),
        })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<Record> {
        let ((mesh, identified, reduced), damping, (learnt, Maybe(water))) = needs;
        let limits = limits(&learnt.runs, &identified, set.rounds)?;
        let outline = Outline::new(&of.card, &mesh.solid);
        let (wet, spots) = outline.whole(learnt.density, learnt.sections).map_err(Fault::from_tool)?;
        let model = Model::new(&mesh, &of.card)?.and(spots);
        let elastic = swing::identified(&model, &identified);
        let small = Small::of(&model, &elastic, &reduced.kept)?;
        let tail = outline.marked(learnt.density, learnt.sections).map_err(Fault::from_tool)?;
        let rows = small.rows(&outline::order(&of.card));
        let stations = small.rows(&(of.card.marker.len()..small.markers()).collect::<Vec<_>>());
        let swimmer = Swimmer {
            small: &small,
            tail: &tail,
            rows: &rows,
            wet: (&wet, &stations),
            sides: of.card.chamber.iter().map(|c| c.log).collect(),
            by: water.map_or(Coefficients { added: 1.0, drag: set.drag }, |w| w.by),
            half: model.system.mesh().symmetry_plane_z,
            stiffness_damping: damping.stiffness_damping,
            per_beat: set.per_beat,
            beats: set.beats,
        };
        let models = models(&learnt)?;
        let scan = scan(&swimmer, &models, &limits, set, &|part| desk.progress(0.2 + 0.3 * part, "scanning"))?;
        desk.progress(0.5, "climbing");
        let filmed = learnt.runs.iter().map(Run::swing).fold(f64::MIN_POSITIVE, f64::max);
        let climbed = |place: usize| uphill(&swimmer, &models, place, &scan, filmed, limits, set);
        let best = (0..models.len()).into_par_iter().map(climbed).collect::<Outcome<_>>()?;
        Ok(Record {
            highest_pa: limits.amplitude,
            frequencies_hz: limits.frequency,
            best,
            scan,
            check: check(&swimmer, &models[0].1, &learnt.runs, &limits)?,
            coordinates: small.coordinates(),
        })
    }
}

/// What was weighed bounds what is asked, and of pressures also what moduli were identified by.
fn limits(runs: &[Run], identified: &Identified, rounds: usize) -> Outcome<Limits> {
    let most = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let slowest = runs.iter().map(|r| r.frequency).fold(f64::INFINITY, f64::min);
    let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
    let amplitude = most(highest).min(known);
    if amplitude <= 0.0 || !slowest.is_finite() {
        return Err(Fault::new(
            "no wave may be asked for",
            "no pressure was both weighed and identified by",
            "weigh a run",
        ));
    }
    Ok(Limits { amplitude, frequency: [slowest, most(|r| r.frequency)], rounds })
}

/// The highest pressure that was measured in a run, Pa: less than was commanded where there is no time to fill.
fn highest(run: &Run) -> Pascal {
    run.pressure.iter().flatten().copied().fold(0.0, f64::max)
}

type Named = (Rung, Fitted);

/// Tuned theory and the network, as they were learnt from the runs of the card's training side.
fn models(learnt: &Thrust) -> Outcome<Vec<Named>> {
    let theory = Weighted { rung: Rung::Theory, weights: learnt.coefficients.clone() };
    let network = Network::from_safetensors(&learnt.network).map_err(Fault::from_tool)?;
    Ok(vec![(Rung::Theory, Fitted::Weighted(theory)), (Rung::Network, Fitted::Network(Box::new(network)))])
}

/// Waves over the limits, evenly: amplitudes from half the highest, frequencies from end to end.
fn scan(
    swimmer: &Swimmer,
    models: &[Named],
    limits: &Limits,
    set: &Settings,
    heard: &(dyn Fn(f64) + Sync),
) -> Outcome<Vec<Flap>> {
    let [amplitudes, frequencies] = set.scan.map(|n| n.max(1));
    let frequencies = if limits.frequency[1] > limits.frequency[0] { frequencies } else { 1 };
    let even = |i: usize, n: usize, from: f64| from + (1.0 - from) * i as f64 / (n.max(2) - 1) as f64;
    let places: Vec<[f64; 2]> = (0..amplitudes)
        .flat_map(|a| {
            (0..frequencies).map(move |f| [even(amplitudes - 1 - a, amplitudes, 0.5), even(f, frequencies, 0.0)])
        })
        .collect();
    let like = Wave { amplitude: 0.0, frequency: 0.0, sharpness: set.sharpness };
    let one = |(number, place): (usize, &[f64; 2])| {
        let wave = limits.wave(*place, like);
        let run = swimmer.run(&wave)?;
        heard(number as f64 / places.len() as f64);
        Ok(flap(&wave, models.iter().map(|(_, model)| mean(model, &run)).collect()))
    };
    places.par_iter().enumerate().map(one).collect()
}

fn flap(wave: &Wave, thrust_n: Vec<f64>) -> Flap {
    Flap { amplitude_pa: wave.amplitude, frequency_hz: wave.frequency, thrust_n }
}

/// From the best of the scan uphill, as the model at `place` tells it; `filmed` is the largest swing that was (m).
fn uphill(
    swimmer: &Swimmer,
    models: &[Named],
    place: usize,
    scan: &[Flap],
    filmed: Metre,
    limits: Limits,
    set: &Settings,
) -> Outcome<Best> {
    let (rung, model) = &models[place];
    let start = scan.iter().max_by(|a, b| a.thrust_n[place].total_cmp(&b.thrust_n[place]));
    let start = start.ok_or_else(|| Fault::new("no wave was scanned", "[best_flap] scan is empty", "scan some"))?;
    let start = Wave { amplitude: start.amplitude_pa, frequency: start.frequency_hz, sharpness: set.sharpness };
    let mut hill = Asked { swimmer, model, limits, marches: scan.len() };
    let way = climb(&mut hill, start, &limits)?;
    let marches = hill.marches;
    let run = swimmer.run(&way[way.len() - 1].0)?;
    Ok(Best {
        model: rung.name().into(),
        way: way.iter().map(|(wave, thrust)| flap(wave, vec![*thrust])).collect(),
        told_n: models.iter().map(|(_, model)| mean(model, &run)).collect(),
        swing_over_filmed: run.swing() / filmed,
        marches,
    })
}

/// A square wave overshoots what a held step reaches: a run counts as within the limits up to this part of them.
const NEAR: f64 = 1.05;

/// Of the runs within the limits, that of the most mean force beside its simulation under its measured pressures, whole beats of which go round.
fn check(swimmer: &Swimmer, theory: &Fitted, runs: &[Run], limits: &Limits) -> Outcome<Check> {
    let force = |run: &Run| run.force.iter().sum::<f64>() / run.len().max(1) as f64;
    let within = runs.iter().filter(|r| highest(r) <= NEAR * limits.amplitude);
    let run = within.max_by(|a, b| force(a).total_cmp(&force(b))).ok_or_else(|| {
        let limit = format!("moduli were identified up to {:.0} Pa", limits.amplitude);
        Fault::new("no weighed run can be held against the simulator", limit, "weigh one at a lower pressure")
    })?;
    let column = |c: usize| Series::new(0.0, run.rate, run.pressure.iter().map(|p| p[c]).collect());
    let gauges: Vec<Series> =
        (0..swimmer.sides.len()).map(column).collect::<Result<_, _>>().map_err(Fault::from_tool)?;
    let beats = (run.len() as f64 / run.rate * run.frequency).round().max(1.0);
    let around = |t: Second| t.rem_euclid(beats / run.frequency);
    let pressures = |t: Second| gauges.iter().map(|g| g.at(around(t))).collect();
    let simulated = swimmer.flap(run.frequency, run.amplitude, &pressures)?;
    Ok(Check {
        run: run.id.clone(),
        swing_m: [simulated.swing(), run.swing()],
        mean_n: [mean(theory, &simulated), mean(theory, run), force(run)],
    })
}
