//! Optimal actuation: amplitude and frequency of the square wave of pressure with the greatest mean thrust in the simulator.
//!
//! The reduced model flaps in still water with the drag identified from a release; thrust models thrust on measured motions are
//! evaluated on the simulated ones. The search stays within the pressures and frequencies of the force measurements, beyond which no
//! thrust model was thrust, and within the pressures of identification, beyond which a slack wall may buckle. By fitted theory a waveform of
//! many harmonics is optimised too, behind a valve with the time constants of the logs of identification.

use std::path::Path;

use hydro::Coefficients;
use optimize::network::Network;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use signal::step_response::pulses;

use ::thrust::ascent::Limits;
use ::thrust::flapping::FlappingModel;
use ::thrust::models::linear::Weighted;
use ::thrust::optimal_waveform::OptimalWaveforms;
use ::thrust::outline::Outline;
use ::thrust::real_time::{Surroundings, twin_data};
use ::thrust::square_wave_search::{ActuationPoint, Best, Search, best_recorded, check, highest_pressure};
use ::thrust::waveform::Valve;
use ::thrust::waveform_thrust::WaveformModel;
use ::thrust::{Fitted, Run, ThrustModel};
use diagnostics::{Diagnostic, Result};
use records::selections::IdentificationTrials;
use records::subject::Specimen;
use records::{Drag, Identified, Level, Mesh, Motion, OptimalActuation as Record, Reduced, Relaxation, Thrust};
use sysid::{Body, ReducedBody};
use twin::Twin;
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
    /// Settling cycles, and cycles over which the thrust of a waveform is averaged: more than for a scan, so that none lives on the transient.
    waveform_cycles: [usize; 2],
    /// Iterations of the ascent of a waveform.
    waveform_iterations: usize,
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
        Self { body: Body::of(&of.card), halves: halves_of_chambers(&of.card) }
    }
}

/// The first two channels that any trial fills in turn fill their chambers in the two halves of a cycle.
fn halves_of_chambers(card: &lab::Card) -> Vec<Option<usize>> {
    let flapping = card.trial.iter().map(|t| t.experiment.channels()).find(|channels| channels.len() > 1);
    let channels_in_turn = flapping.map(|channels| &channels[..2]).unwrap_or_default();
    card.chamber.iter().map(|chamber| channels_in_turn.iter().position(|channel| *channel == chamber.channel)).collect()
}

impl Stage for OptimalActuation {
    type Settings = Settings;
    type Card = Card;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, (Thrust, Maybe<Drag>, IdentificationTrials<Motion>));
    type Makes = Record;
    const DESCRIPTION: &'static str = "the actuation of greatest mean thrust is optimised";
    const VERSION: u32 = 13;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Record> {
        let ((mesh, identified, reduced), relaxation, (thrust, Maybe(water), films)) = needs;
        let limits = search_limits(&thrust.runs, &identified, set.iterations)?;
        let outline = Outline::new(&card.body, &mesh.solid);
        let (wet, spots) = outline.whole(thrust.density, thrust.sections)?;
        let model = mesh.model(&card.body)?.with_spots(spots);
        let reduced_body = ReducedBody::of(&model, &relaxation.silicone(&model, &identified)?, &reduced.data)?;
        let tail = outline.marker_tail(thrust.density, thrust.sections)?;
        let stations: Vec<usize> = (card.body.markers.len()..reduced_body.markers()).collect();
        let (rows, stations) = (reduced_body.rows(&card.body.markers_by_x()), reduced_body.rows(&stations));
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
        let models = fitted_models(&thrust)?;
        let search = Search { flapping: &flapping, models: &models, limits, sharpness: set.sharpness, scan: set.scan };
        let (scan, unsolved) = search.scan(&|part| context.progress(0.2 + 0.3 * part, "scanning"))?;
        context.progress(0.5, "gradient ascent");
        let best = best_by_model(&search, &scan, &thrust.runs)?;
        context.progress(0.8, "gradient ascent of a waveform");
        let recorded = best_recorded(&thrust.runs, &limits)?;
        let actuated = Actuated { flapping: &flapping, theory: &thrust.coefficients, limits, set };
        Ok(Record {
            waveforms: actuated.optimal_waveforms(&films, recorded)?,
            highest_pa: limits.amplitude,
            frequencies_hz: limits.frequency,
            best,
            scan,
            unsolved,
            check: check(&flapping, &models[0].1, recorded)?,
            coordinates: reduced_body.coordinates(),
        })
    }
}

/// The square wave of greatest thrust by each thrust model, by gradient ascent from the points of a scan.
fn best_by_model(search: &Search, scan: &[ActuationPoint], runs: &[Run]) -> Result<Vec<Best>> {
    let filmed_amplitude = runs.iter().map(Run::amplitude_of_tip).fold(f64::MIN_POSITIVE, f64::max);
    let optimised = |model: usize| search.ascend_from(scan, model, filmed_amplitude);
    (0..search.models.len()).into_par_iter().map(optimised).collect()
}

/// A valve with the time constants of the films' pressure logs; none where no log holds a pulse.
fn valve_of_films(films: &IdentificationTrials<Motion>) -> Option<Valve> {
    let of_film =
        |film: &Motion| -> Vec<_> { film.gauges.iter().flat_map(|g| pulses(&film.log_time, g.signals())).collect() };
    Valve::of(&films.0.iter().flat_map(|(_, film)| of_film(film)).collect::<Vec<_>>())
}

/// What a waveform is optimised for.
struct Actuated<'a> {
    flapping: &'a FlappingModel<'a>,
    /// The five coefficients of fitted theory.
    theory: &'a [f64],
    limits: Limits,
    set: &'a Settings,
}

impl Actuated<'_> {
    /// The optimal waveforms behind the valve of the films; none without one, or for a law that no twin has. Thrust is without
    /// the constant of fitted theory, which a tail at rest has too: over no air it would be without limit.
    fn optimal_waveforms(
        &self,
        films: &IdentificationTrials<Motion>,
        recorded: &Run,
    ) -> Result<Option<OptimalWaveforms>> {
        let Self { flapping, theory, limits, set } = *self;
        let Some(valve) = valve_of_films(films) else { return Ok(None) };
        let &[edge_flux, momentum_rate, drag, inertia, _] = theory else { return Ok(None) };
        if !flapping.reduced_body.has_twin() {
            return Ok(None);
        }
        let (wet, rows) = flapping.wet;
        let water = Surroundings { tail: wet, rows, by: flapping.by, half: flapping.half };
        let data = twin_data(flapping.reduced_body, Some(&water), &[])?;
        let model = WaveformModel {
            twin: &Twin::new(data.clone())?,
            chambers: &data.chambers,
            halves: &flapping.halves,
            rows: flapping.rows,
            theory: (flapping.tail, [edge_flux, momentum_rate, drag, inertia, 0.0]),
            share: if flapping.half { 0.5 } else { 1.0 },
            valve,
            limits: Limits { iterations: set.waveform_iterations, ..limits },
            steps_per_cycle: set.steps_per_cycle,
            cycles: set.waveform_cycles,
        };
        model.optimal_waveforms(recorded).map(Some)
    }
}

/// Limits of the search: the range of the force measurements, and for pressures also that of identification.
fn search_limits(runs: &[Run], identified: &Identified, iterations: usize) -> Result<Limits> {
    let highest_of = |property: fn(&Run) -> f64| runs.iter().map(property).fold(0.0, f64::max);
    let slowest = runs.iter().map(|r| r.frequency).fold(f64::INFINITY, f64::min);
    let highest_identified = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
    let amplitude = highest_of(highest_pressure).min(highest_identified);
    if amplitude <= 0.0 || !slowest.is_finite() {
        return Err(Diagnostic::new(
            "there is no actuation to optimise",
            "no pressure occurs both in force measurements and in identification",
            "record a trial with a force log",
        ));
    }
    Ok(Limits { amplitude, frequency: [slowest, highest_of(|r| r.frequency)], iterations })
}

/// Fitted theory and the network, thrust on the card's training runs.
fn fitted_models(thrust: &Thrust) -> Result<Vec<(ThrustModel, Fitted)>> {
    let theory = Weighted { model: ThrustModel::Theory, weights: thrust.coefficients.clone() };
    let file = Path::new("network.safetensors");
    let network = Network::from_safetensors(&thrust.network).map_err(|e| Diagnostic::from(e).in_file(file))?;
    Ok(vec![
        (ThrustModel::Theory, Fitted::Weighted(theory)),
        (ThrustModel::Network, Fitted::Network(Box::new(network))),
    ])
}
