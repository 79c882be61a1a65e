//! Recovery: errors of the pipeline's estimates against the hidden truth of the virtual bench. The one stage that may read it.

use std::path::Path as FilePath;

use lab::card::Origin;
use lab::truth::{self, TrueTrack, TrueTrial};
use mesh::wall::{Walls, buckling_pressure};
use serde::{Deserialize, Serialize};
use si::{Pascal, Point2, Second};

use crate::records::{
    Camera, CorrectedForce, Drag, Estimate, Identified, Inflation, Interval, LoadCell, Markers, Motion, Path, Quantity,
    REPORTED, Recovered, RecoveredSpecimen, Relaxation, Tank, Tracks, Validation, WallErrors,
};
use crate::subject::{Specimen, Study, condition_of};
use diagnostics::{Diagnostic, Result};
use sysid::relaxation::dynamic_modulus;
use workflow::needs::Every;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::{Name, Part};

/// The stage.
pub struct Recovery;

/// Identified parameters of the specimens: elasticity, relaxation, water.
type Parameters = (Every<Identified>, Every<Relaxation>, Every<Drag>);

/// What the identified models predict.
type Predictions = (Every<Validation>, Every<Inflation>);

/// Walls of a true body by pressure, Pa, and the errors of its model's.
type WallComparison = (Vec<(Pascal, Walls)>, Option<WallErrors>);

/// Records of all films: pixels, positions, motions.
type Films = (Every<Tracks>, Every<Markers>, Every<Motion>);

/// `[recovery]` in `study.toml`: nothing to set.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

/// What it reads of the cards: the specimens of the virtual bench, whose truth is known.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub struct Card(Vec<Virtual>);

/// A specimen of the virtual bench.
#[derive(Debug, Serialize)]
struct Virtual {
    name: String,
    trials: Vec<String>,
    /// The fixture's recording of water at rest.
    still_water: Option<String>,
    /// The channel in which the identified model is inflated.
    inflated: Option<String>,
}

impl Part<Study> for Card {
    fn part_of(of: &Study) -> Self {
        Self(virtual_specimens(of).map(Virtual::of).collect())
    }
}

impl Virtual {
    fn of(specimen: &Specimen) -> Self {
        let still = specimen.card.fixture.iter().find(|f| f.of == lab::card::FixtureOf::StillWater);
        Self {
            name: specimen.card.name.clone(),
            trials: specimen.card.trial.iter().map(|t| t.id.clone()).collect(),
            still_water: still.map(|f| f.id.clone()),
            inflated: specimen.highest_staircase().and_then(|t| t.trial.experiment.channels().first().cloned()),
        }
    }

    /// The subject of one of its trials.
    fn subject(&self, trial: &str) -> Name {
        Name(format!("{}/{trial}", self.name))
    }
}

impl Stage for Recovery {
    type Settings = Settings;
    type Card = Card;
    type Needs =
        ((Every<Camera>, Films, (Parameters, Predictions)), (Every<LoadCell>, Every<Tank>, Every<CorrectedForce>));
    type Makes = Recovered;
    const DESCRIPTION: &'static str = "estimates are compared with the hidden truth";
    const VERSION: u32 = 10;

    fn raw(of: &Study) -> Vec<RawFile> {
        virtual_specimens(of).flat_map(files).collect()
    }

    fn run(card: &Self::Card, _: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Recovered> {
        let ((Every(cameras), films, (parameters, (Every(predictions), Every(inflated)))), weighed) = needs;
        let mut recovered = Recovered::default();
        for specimen in &card.0 {
            let truth = read(context, &specimen.name)?;
            let mut estimates = beside(specimen, &truth, &parameters)?;
            for (_, camera) in cameras.iter().filter(|(s, _)| s.0 == specimen.name) {
                let off = 100.0 * (camera.lens.fx / truth.lens.fx - 1.0).abs();
                recovered.focal_error_percent = recovered.focal_error_percent.max(off);
            }
            judge_forces(&mut recovered, specimen, &truth, &weighed);
            for id in &specimen.trials {
                let Some(true_trial) = truth.trial.iter().find(|t| t.id == *id) else {
                    return Err(no_trial(&specimen.name, id));
                };
                let true_tracks = true_tracks(context, &specimen.name, id)?;
                judge(&mut recovered, &specimen.subject(id), (true_trial, &true_tracks), &films);
                let predicted = predictions.iter().filter(|(trial, _)| *trial == specimen.subject(id));
                estimates.extend(predicted.filter_map(|(_, found)| amplitude(condition_of(id), found, &true_tracks)));
            }
            if !estimates.is_empty() {
                let (hidden, walls) = walls(specimen, &truth, (&parameters.0, &inflated))?;
                recovered.specimens.push(RecoveredSpecimen { name: specimen.name.clone(), estimates, walls, hidden });
            }
        }
        Ok(recovered)
    }
}

/// Estimates of a specimen beside the truth; none where its moduli were not identified.
fn beside(
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(identified), Every(relaxed), Every(dragged)): &Parameters,
) -> Result<Vec<Estimate>> {
    let this = |s: &Name| s.0 == specimen.name;
    let Some((_, found)) = identified.iter().find(|(s, _)| this(s)) else { return Ok(Vec::new()) };
    let estimate = |quantity, found, hidden, sigma| Estimate { quantity, found, hidden, sigma };
    let real = spectrum(&truth.body)?;
    let held = truth.body.youngs_modulus * real.modulus(found.modulus_time);
    let (best, sigma) = (&found.best, &found.sigma);
    let mut all = vec![
        estimate(Quantity::BodyModulus, best[0], held, sigma[0] / best[0]),
        estimate(Quantity::SpineModulus, best[1], truth.spine.youngs_modulus, sigma[1] / best[1]),
    ];
    for (_, relaxation) in relaxed.iter().filter(|(s, _)| this(s)) {
        for frequency in REPORTED {
            let (found, sigma) = (relaxation.spectrum.at(frequency)?, relaxation.spectrum.sigma_at(frequency)?);
            let real = dynamic_modulus(&real, frequency, relaxation.spectrum.modulus_time_s);
            let quantities = [Quantity::StorageRatio(frequency), Quantity::LossFactor(frequency)];
            all.extend(
                quantities.into_iter().enumerate().map(|(k, q)| estimate(q, found[k], real[k], sigma[k] / found[k])),
            );
        }
    }
    for ((_, Drag { by, sigma, .. }), hidden) in dragged.iter().filter(|(s, _)| this(s)).zip(&truth.fluid) {
        all.push(estimate(Quantity::AddedMass, by.added, hidden.added, sigma.added / by.added));
        all.push(estimate(Quantity::NormalDrag, by.drag, hidden.drag, sigma.drag / by.drag));
    }
    Ok(all)
}

/// The walls of the true body by pressure, Pa, and the errors of those of the model; none where a wall of either does not buckle.
// The true shapes are those after all relaxation. A shape follows from pressure over modulus, the sheet's share aside, so under that multiple
// of its pressure each is also the shape at the time of the identified moduli.
fn walls(
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(identified), inflated): (&Every<Identified>, &[(Name, Inflation)]),
) -> Result<WallComparison> {
    let found = identified.iter().find(|(s, _)| s.0 == specimen.name);
    let inflation = inflated.iter().find(|(s, _)| s.0 == specimen.name);
    let hidden = truth.inflation.iter().find(|one| Some(&one.channel) == specimen.inflated.as_ref());
    let (Some((_, found)), Some((_, inflation)), Some(hidden)) = (found, inflation, hidden) else {
        return Ok(Default::default());
    };
    let stiffer = spectrum(&truth.body)?.modulus(found.modulus_time);
    let pressures: Vec<Pascal> = hidden.pressure.iter().map(|p| stiffer * p).collect();
    let (dent, x, bulge) = (&hidden.dent, &hidden.dent_at, &hidden.bulge);
    let one = |i: usize| Walls { dent_m: dent[i], dent_at: [x[i], 0.0, 0.0], bulge_m: bulge[i] };
    let all = pressures.iter().enumerate().map(|(i, pressure)| (*pressure, one(i))).collect();
    let highest = inflation.shapes.iter().rfind(|shape| pressures.last().is_some_and(|top| shape.pressure() <= *top));
    let critical = (inflation.buckling_pressure(), buckling_pressure(&pressures, &hidden.dent));
    let ((Some(model), Some(body)), Some(shape)) = (critical, highest) else { return Ok((all, None)) };
    let there = |of: &[f64]| at(&pressures, of, shape.pressure());
    let errors = WallErrors {
        critical_pressure_pa: model - body,
        hidden_critical_pressure_pa: body,
        dent: shape.walls.dent_m / there(&hidden.dent) - 1.0,
        dent_at_m: shape.walls.dent_at[0] - there(&hidden.dent_at),
        bulge: shape.walls.bulge_m / there(&hidden.bulge) - 1.0,
        rotation: shape.rotation - there(&hidden.rotation),
    };
    Ok((all, Some(errors)))
}

/// The value of `of` at pressure `p` (Pa) between two of the rising `pressures`.
fn at(pressures: &[Pascal], of: &[f64], p: Pascal) -> f64 {
    let above = pressures.partition_point(|q| *q < p).clamp(1, pressures.len() - 1);
    let part = (p - pressures[above - 1]) / (pressures[above] - pressures[above - 1]);
    of[above - 1] + part * (of[above] - of[above - 1])
}

/// The predicted amplitude of the tip in a validation trial beside the true one, whose tracks are given.
fn amplitude(condition: String, found: &Validation, tracks: &[TrueTrack]) -> Option<Estimate> {
    let track = tracks.iter().find(|track| track.marker == found.marker)?;
    let lateral = |t: &Second| track.at[frame_at(&track.time, *t)][1] - track.at[0][1];
    let squares: f64 = found.time.iter().map(|t| lateral(t).powi(2)).sum();
    let hidden = (squares / found.time.len().max(1) as f64).sqrt();
    let Interval { value, sigma } = found.amplitude;
    Some(Estimate { quantity: Quantity::TipAmplitude(condition), found: value, hidden, sigma })
}

/// The true relaxation.
fn spectrum(of: &truth::Properties) -> Result<fem::Relaxation> {
    let branches: Vec<fem::Branch> =
        of.branch.iter().map(|b| fem::Branch { strength: b.strength, time: b.time }).collect();
    fem::Relaxation::maxwell(&branches).map_err(Diagnostic::from)
}

/// Updates the largest errors with those of a specimen's force instruments.
fn judge_forces(
    recovered: &mut Recovered,
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(cells), Every(tanks), Every(pulls)): &(Every<LoadCell>, Every<Tank>, Every<CorrectedForce>),
) {
    let worse = |old: Option<f64>, new: f64| Some(old.map_or(new, |old| old.max(new)));
    for ((_, cell), hidden) in cells.iter().filter(|(s, _)| s.0 == specimen.name).zip(&truth.cell) {
        let frequency = (hidden.stiffness / hidden.mass).sqrt() / std::f64::consts::TAU;
        let off = 100.0 * (cell.in_time.natural_frequency_hz / frequency - 1.0).abs();
        recovered.load_cell_frequency_error_percent = worse(recovered.load_cell_frequency_error_percent, off);
    }
    for (_, tank) in tanks.iter().filter(|(s, _)| s.0 == specimen.name) {
        let still = specimen.still_water.as_ref();
        let Some(hidden) = still.and_then(|id| truth.force.iter().find(|t| t.id == *id)) else { continue };
        for (found, real) in pairs(tank, &hidden.waves) {
            let part = |turn: fn(f64) -> f64| found.amplitude * turn(found.phase) - real.amplitude * turn(real.phase);
            let left = part(f64::cos).hypot(part(f64::sin));
            recovered.wave_residual_mn = worse(recovered.wave_residual_mn, 1e3 * left);
        }
        for (trial, pull) in pulls.iter() {
            let Some(id) = specimen.trials.iter().find(|id| specimen.subject(id) == *trial) else { continue };
            let waves = truth.force.iter().find(|t| t.id == *id).map_or(&[][..], |t| &t.waves);
            if !waves.is_empty() {
                let left = 1e3 * left_of(pull, waves, tank);
                recovered.wave_residual_mn = worse(recovered.wave_residual_mn, left);
            }
        }
    }
}

/// Each wave that was found, with the true one nearest to its frequency.
fn pairs<'a>(
    tank: &'a Tank,
    real: &'a [truth::TrueWave],
) -> impl Iterator<Item = (&'a signal::wave::Wave, &'a truth::TrueWave)> {
    let off = |found: f64, wave: &truth::TrueWave| (wave.frequency - found).abs();
    tank.waves.iter().filter_map(move |found| {
        let near =
            |a: &&truth::TrueWave, b: &&truth::TrueWave| off(found.frequency, a).total_cmp(&off(found.frequency, b));
        real.iter().min_by(near).map(|real| (found, real))
    })
}

/// Root mean square residual of a trial's standing waves after their removal, N. The decay of a true wave is taken as identified.
fn left_of(pull: &CorrectedForce, waves: &[truth::TrueWave], tank: &Tank) -> f64 {
    let first = pull.time[0];
    let real = |t: Second| -> f64 {
        let one = |(found, real): (&signal::wave::Wave, &truth::TrueWave)| {
            let angle = std::f64::consts::TAU * real.frequency * t + real.phase;
            real.amplitude * (-found.decay * t).exp() * angle.cos()
        };
        pairs(tank, waves).map(one).sum()
    };
    let squares = pull.time.iter().zip(&pull.waves).map(|(t, found)| (found - real(t - first)).powi(2));
    (squares.sum::<f64>() / pull.time.len() as f64).sqrt()
}

fn virtual_specimens(of: &Study) -> impl Iterator<Item = &Specimen> {
    of.specimens.iter().filter(|s| s.card.origin == Origin::VirtualBench)
}

/// The truth's file, and one file of true tracks a trial.
fn files(specimen: &Specimen) -> Vec<RawFile> {
    let name = &specimen.card.name;
    let tracks =
        specimen.card.trial.iter().map(|t| RawFile::new(&tracks_word(name, &t.id), name, &tracks_place(&t.id)));
    std::iter::once(RawFile::new(&truth_word(name), name, lab::folder::TRUTH)).chain(tracks).collect()
}

fn truth_word(specimen: &str) -> String {
    format!("truth of {specimen}")
}

fn tracks_word(specimen: &str, trial: &str) -> String {
    format!("true tracks of {specimen}/{trial}")
}

fn tracks_place(trial: &str) -> String {
    format!("truth/{trial}.csv")
}

fn read(context: &dyn StageContext, specimen: &str) -> Result<truth::Truth> {
    let (text, place) = text(context, &truth_word(specimen))?;
    truth::parse(&text, FilePath::new(&place))
}

fn text(context: &dyn StageContext, word: &str) -> Result<(String, String)> {
    let place = context.display_path(word);
    let text = String::from_utf8(context.bytes(word)?);
    let text = text.map_err(|e| Diagnostic::new(format!("{place} is not text"), e, "record the specimen again"))?;
    Ok((text, place))
}

/// Updates the largest errors with those of a trial.
fn judge(
    recovered: &mut Recovered,
    trial: &Name,
    (truth, true_tracks): (&TrueTrial, &[TrueTrack]),
    (Every(tracks), Every(places), Every(motions)): &Films,
) {
    let this = |t: &Name| t == trial;
    for (_, tracks) in tracks.iter().filter(|(t, _)| this(t)) {
        let pixels = |t: &TrueTrack, i: usize| t.pixel[i];
        let found = Estimated { paths: &tracks.markers, time: &tracks.time };
        let off = found.worst_rms(true_tracks, &pixels);
        found.cover(&mut recovered.track_coverage, true_tracks, &pixels);
        if off > recovered.track_rms_px {
            (recovered.track_rms_px, recovered.track_worst) = (off, trial.0.clone());
        }
        if off > STRAYED {
            recovered.track_strayed.push(format!("{} ({off:.2} px)", trial.0.clone()));
        }
    }
    for (_, places) in places.iter().filter(|(t, _)| this(t)) {
        recovered.marker_place_mm = recovered.marker_place_mm.max(1e3 * off_at_rest(&places.markers, true_tracks));
    }
    for (_, motion) in motions.iter().filter(|(t, _)| this(t)) {
        let moved = |t: &TrueTrack, i: usize| [t.at[i][0] - t.at[0][0], t.at[i][1] - t.at[0][1]];
        let found = Estimated { paths: &motion.markers, time: &motion.time };
        let off = found.worst_rms(true_tracks, &moved);
        found.cover(&mut recovered.marker_coverage, true_tracks, &moved);
        recovered.marker_rms_mm = recovered.marker_rms_mm.max(1e3 * off);
        recovered.clock_error_ms = recovered.clock_error_ms.max(1e3 * clock_error(motion, truth));
    }
}

fn true_tracks(context: &dyn StageContext, specimen: &str, trial: &str) -> Result<Vec<TrueTrack>> {
    let (text, place) = text(context, &tracks_word(specimen, trial))?;
    truth::parse_tracks(&text, FilePath::new(&place))
}

/// A marker whose root mean square error is larger has been swapped or lost, px.
const STRAYED: f64 = 1.0;

/// Largest distance of a marker's first position from the true one, m.
fn off_at_rest(paths: &[Path], truth: &[TrueTrack]) -> f64 {
    let one = |path: &Path| {
        let track = truth.iter().find(|t| t.marker == path.name)?;
        let (found, real) = (path.at.first()?, track.at.first()?);
        Some((found[0] - real[0]).hypot(found[1] - real[1]))
    };
    paths.iter().filter_map(one).fold(0.0, f64::max)
}

/// The 95 % quantile of χ² with two degrees of freedom.
const ELLIPSE_95: f64 = 5.991;

/// Estimated positions of a film's markers.
#[derive(Clone, Copy)]
struct Estimated<'a> {
    paths: &'a [Path],
    /// Times of the frames, s.
    time: &'a [Second],
}

impl Estimated<'_> {
    /// Root mean square distance from the truth, of the marker with the largest.
    fn worst_rms(&self, truth: &[TrueTrack], true_place: &dyn Fn(&TrueTrack, usize) -> Point2) -> f64 {
        let Self { paths, time } = *self;
        let one = |path: &Path| {
            let Some(track) = truth.iter().find(|t| t.marker == path.name) else {
                return f64::INFINITY;
            };
            let off = time.iter().zip(&path.at).map(|(&t, p)| {
                let q = true_place(track, frame_at(&track.time, t));
                (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
            });
            (off.sum::<f64>() / path.at.len().max(1) as f64).sqrt()
        };
        paths.iter().map(one).fold(0.0, f64::max)
    }

    /// Counts the positions whose 95 % ellipse contains the true one.
    fn cover(
        &self,
        [held, all]: &mut [usize; 2],
        truth: &[TrueTrack],
        true_place: &dyn Fn(&TrueTrack, usize) -> Point2,
    ) {
        let Self { paths, time } = *self;
        for (path, track) in paths.iter().filter_map(|p| Some((p, truth.iter().find(|t| t.marker == p.name)?))) {
            for ((t, p), [xx, xy, yy]) in time.iter().zip(&path.at).zip(&path.spread) {
                let q = true_place(track, frame_at(&track.time, *t));
                let [x, y] = [p[0] - q[0], p[1] - q[1]];
                let square = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy);
                *held += usize::from(square < ELLIPSE_95);
                *all += 1;
            }
        }
    }
}

/// The true frame nearest in time.
fn frame_at(times: &[Second], t: Second) -> usize {
    let right = times.partition_point(|&s| s < t).min(times.len() - 1);
    if right > 0 && t - times[right - 1] < times[right] - t { right - 1 } else { right }
}

/// Largest difference of found from true log time over the film, s.
fn clock_error(motion: &Motion, truth: &TrueTrial) -> Second {
    let off = |t: Second| {
        let (found, truth) = (motion.clock.offset + motion.clock.scale * t, truth.clock_offset + truth.clock_scale * t);
        (found - truth).abs()
    };
    motion.time.iter().map(|&t| off(t)).fold(0.0, f64::max)
}

fn no_trial(specimen: &str, trial: &str) -> Diagnostic {
    Diagnostic::new(
        format!("the truth has no trial `{trial}`"),
        "card and truth of a virtual specimen are written together",
        format!("rig record {specimen}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(frequency: f64, decay: f64) -> signal::wave::Wave {
        let (amplitude, phase) = (0.0, 0.0);
        signal::wave::Wave { frequency, frequency_sigma: 0.01, decay, decay_sigma: 0.01, amplitude, phase }
    }

    fn tank(waves: Vec<signal::wave::Wave>) -> Tank {
        let (noise, suppression_db, sampling) = (0.0, 0.0, lab::Sampling::default());
        Tank { waves, evidence: Vec::new(), level: 0.01, noise, suppression_db, size_m: [1.0, 0.5], sampling }
    }

    /// A log from 3 s on with these waves in it.
    fn pull(waves: Vec<f64>) -> CorrectedForce {
        let time: Vec<f64> = (0..waves.len()).map(|i| 3.0 + 0.01 * i as f64).collect();
        let none = vec![0.0; waves.len()];
        let (raw, zero, sampling) = (none.clone(), none, lab::Sampling::default());
        let (commanded, lag, warnings) = ([0.0; 2], [0.0; 2], Vec::new());
        CorrectedForce { time, raw, waves, zero, offset: 0.0, commanded, lag, sampling, warnings }
    }

    #[test]
    fn a_hidden_value_is_read_linearly_between_pressures() {
        let (pressures, values) = ([0.0, 100.0, 300.0], [1.0, 3.0, 11.0]);
        let read = [0.0, 50.0, 100.0, 150.0, 300.0].map(|p| at(&pressures, &values, p));
        assert_eq!(read, [1.0, 2.0, 3.0, 5.0, 11.0]);
    }

    #[test]
    fn waves_that_were_removed_as_they_are_leave_nothing() {
        let real = [(0.9, 2e-3, 0.4), (1.9, 1e-3, -1.0)].map(|(f, a, p)| truth::TrueWave {
            frequency: f,
            amplitude: a,
            phase: p,
        });
        let tank = tank(vec![wave(0.91, 0.05), wave(1.88, 0.1)]);
        let hidden = |i: usize| {
            let t = 0.01 * i as f64;
            let one = |(w, decay): (&truth::TrueWave, f64)| {
                w.amplitude * (-decay * t).exp() * (std::f64::consts::TAU * w.frequency * t + w.phase).cos()
            };
            real.iter().zip([0.05, 0.1]).map(one).sum::<f64>()
        };
        let exact: Vec<f64> = (0..400).map(hidden).collect();
        assert!(left_of(&pull(exact.clone()), &real, &tank) < 1e-15);
        let off: Vec<f64> = exact.iter().enumerate().map(|(i, w)| w + if i % 2 == 0 { 3e-4 } else { -3e-4 }).collect();
        assert!((left_of(&pull(off), &real, &tank) - 3e-4).abs() < 1e-15);
    }
}
