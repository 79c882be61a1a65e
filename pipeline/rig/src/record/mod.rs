//! Recording a specimen: from its shape and hidden properties to a folder such as a laboratory could have filled.
//!
//! This module alone chooses paths, keeps finished recordings and replaces stale ones.

use std::path::Path;

use crate::side::Side;
use diagnostics::{Diagnostic, Result};
use lab::card::Trial;
use lab::truth::{self, Lens, Pose, TrueForce, TrueInflation, TrueTrial, Truth};
use mesh::wall::{Section, Walls, end_rotation};
use rayon::prelude::*;
use si::{MILLIMETRE, Metre, Pascal};
use tail_cad::Tail;

use crate::bench::Bench;
use crate::calibration::Calibration;
use crate::camera::flat_disc;
use crate::card::{self, CardContent, RestObservation};
use crate::checkpoint;
use crate::folder;
use crate::force_log;
use crate::physics::{self, Body, BodySettings, CentreLine, FlappingModel, Fluid, PressureSweep, snapshots};
use crate::progress::{Progress, Task};
use crate::random::RandomStream;
use crate::renderer::{Renderer, Subject};
use crate::scene::canvas::centroid;
use crate::scene::mark::Mark;
use crate::scene::skin::Skin;
use crate::settings::Settings;
use crate::specimen::{HiddenProperties, SHEET, Specimen};
use crate::stamp::{self, FolderState};
use crate::trial;

/// What is recorded of a specimen, and where.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The settings of the bench.
    pub set: &'a Settings,
    /// Name of the profile: extent and resolution.
    pub profile: &'a str,
    /// The folder that will hold the specimen's folder.
    pub into: &'a Path,
    /// Where progress is reported.
    pub progress: &'a Progress,
}

/// Result of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The recording was up to date.
    UpToDate,
    /// The recording was made.
    Recorded,
}

/// Largest distance of a mark from the skin of the bench's mesh, m. The card's point lies on the CAD surface; the mesh approximates it.
const SKIN_DISTANCE_LIMIT: Metre = 2e-4;

/// Records `specimen` into `into/<name>`, unless an up-to-date recording is there.
///
/// # Errors
/// When the folder was not made by the bench, a solve does not converge, or a file cannot be written.
pub fn record(specimen: &Specimen, request: &Request) -> Result<Status> {
    let (folder, stamp) = (request.into.join(&*specimen.name), stamp::text(specimen, request.profile));
    if stamp::inspect(&folder, &stamp)? == FolderState::Current {
        return Ok(Status::UpToDate);
    }
    let partial = folder::begin(request.into, &specimen.name, stamp::FILE, &stamp)?;
    fill(specimen, request, &partial).map_err(|e| e.of(&*specimen.name))?;
    checkpoint::clear(&partial)?;
    folder::finish(&partial, &folder)?;
    Ok(Status::Recorded)
}

fn fill(specimen: &Specimen, request: &Request, folder: &Path) -> Result<()> {
    let Request { set, progress, .. } = *request;
    let (name, own, tail) = (&*specimen.name, &set.specimen[&*specimen.name], (specimen.tail)());
    let profile = &set.profile[request.profile];
    let hidden = HiddenProperties::drawn(set, own);
    write_solids(name, &tail, set.cad.fineness, folder)?;
    let laws = [&*set.material[&own.body].law, &*set.material[SHEET].law];
    let body = Body::new(&tail, &BodySettings { resolution: &profile.resolution, clamp: own.clamp, laws }, &hidden)?;
    let renderer = Renderer::new(set, own.seed, own.clamp);
    let places = card::painted(&tail, own, &hidden.marks);
    let subject = Subject { skin: Skin::new(&body.mesh), marks: paint(&body, &places, own.marker_diameter)? };
    let marks: Vec<String> = places.into_iter().map(|(name, _)| name).collect();
    let top = own.highest() * (1.0 + set.causes.supply) - set.valve.droop;
    let pressures = physics::even_pressures(top, profile.levels);
    let sweeps = sweep(progress.begin("statics", name, 2 * profile.levels), &body, &pressures)?;
    let trials = card::trials(own, profile);
    let line = CentreLine::of(&hidden.cast(&tail), &body, own.clamp);
    let flapping_model = reduce(progress.begin("reduce", name, snapshots::COUNT), &body, line, &sweeps)?;
    let bench = Bench {
        set,
        profile,
        name,
        seed: own.seed,
        body: &body,
        sweeps: &sweeps,
        flapping_model: &flapping_model,
        fluid: fluid(set, own.seed),
        renderer: &renderer,
        subject: &subject,
        marks: &marks,
        progress,
    };
    let film = Calibration::new(set, &renderer, profile.poses, own.seed);
    let observed = observe_at_rest(&bench)?;
    let card = card::write(&CardContent { name, set, tail: &tail, trials: &trials }, &observed, &film);
    folder::write(folder, lab::folder::CARD, lab::card::write(&card).as_bytes())?;
    let (trial, mut force) = record_all(&bench, &film, &trials, folder)?;
    for fixture in &card.fixture {
        force.push(force_log::record_fixture(set, own.seed, fixture, folder)?);
    }
    let Fluid { density, added, drag } = bench.fluid;
    let truth = Truth {
        cell: Some(force_log::truth(set, own.seed)),
        fluid: Some(truth::Fluid { density, added, drag }),
        inflation: Side::BOTH.iter().zip(&sweeps).filter_map(|(side, sweep)| inflation(&body, *side, sweep)).collect(),
        trial,
        force,
        ..truth(name, own.seed, &hidden, &renderer)
    };
    folder::write(folder, lab::folder::TRUTH, lab::truth::write(&truth).as_bytes())
}

/// The water of a specimen's recordings.
fn fluid(set: &Settings, seed: u64) -> Fluid {
    let mut random = RandomStream::new(seed, "fluid");
    let (added, drag) = (random.uniform(set.fluid.added), random.uniform(set.fluid.drag));
    Fluid { density: set.fluid.density, added, drag }
}

/// The equilibria of both sides at `pressures` (Pa).
fn sweep(task: Task, body: &Body, pressures: &[Pascal]) -> Result<[PressureSweep; 2]> {
    let side = |side: Side| PressureSweep::solve(body, side, pressures, &|| task.tick());
    let (left, right) = rayon::join(|| side(Side::Left), || side(Side::Right));
    task.done(&format!("{} equilibria of {} unknowns", 2 * (pressures.len() - 1), body.system.dofs()));
    Ok([left?, right?])
}

/// How the walls of the body move in a sweep; none where its mesh has no nodes at mid height.
fn inflation(body: &Body, side: Side, sweep: &PressureSweep) -> Option<TrueInflation> {
    let (rest, section) = (&body.mesh.nodes, Section::of(&body.mesh)?);
    let moved = |shape: &Vec<f64>| -> Vec<si::Point3> {
        rest.iter().zip(shape.as_chunks::<3>().0).map(|(x, u)| si::vec3::add(*x, *u)).collect()
    };
    let nodes: Vec<Vec<si::Point3>> = sweep.shapes.iter().map(moved).collect();
    let walls: Vec<Walls> = nodes.iter().map(|nodes| section.walls(nodes, side == Side::Left)).collect();
    Some(TrueInflation {
        channel: side.word().to_owned(),
        pressure: sweep.pressures.clone(),
        rotation: nodes.iter().map(|nodes| end_rotation(rest, nodes)).collect(),
        bulge: walls.iter().map(|walls| walls.bulge_m).collect(),
        dent: walls.iter().map(|walls| walls.dent_m).collect(),
        dent_at: walls.iter().map(|walls| walls.dent_at[0]).collect(),
    })
}

/// The reduced model of the specimen.
fn reduce<'a>(task: Task, body: &'a Body, line: CentreLine, sweeps: &[PressureSweep; 2]) -> Result<FlappingModel<'a>> {
    let model = FlappingModel::reduce(body, line, sweeps, &|| task.tick())?;
    let points: usize = model.reduced.points().iter().sum();
    task.done(&format!("{} coordinates, {points} points", model.reduced.coordinates()));
    Ok(model)
}

/// Records the calibration and every trial in parallel; results are in the card's order. Trials with a checkpoint are not repeated.
fn record_all(
    bench: &Bench,
    film: &Calibration,
    trials: &[Trial],
    folder: &Path,
) -> Result<(Vec<TrueTrial>, Vec<TrueForce>)> {
    let one = |trial: &Trial| match checkpoint::load(folder, &trial.id) {
        Some(truth) => Ok(truth),
        None => {
            let truth = trial::record(bench, trial, folder)?;
            checkpoint::save(folder, &trial.id, &truth)?;
            Ok(truth)
        }
    };
    let all = || trials.par_iter().map(one).collect::<Result<Vec<_>>>();
    let (calibrated, recorded) = rayon::join(|| calibrate(bench, film, folder), all);
    let (trials, forces): (Vec<_>, Vec<_>) = calibrated.and(recorded)?.into_iter().map(|t| (t.trial, t.force)).unzip();
    Ok((trials, forces.into_iter().flatten().collect()))
}

fn calibrate(bench: &Bench, film: &Calibration, folder: &Path) -> Result<()> {
    let task = bench.progress.begin("film", format!("{}/calibration", bench.name), film.frames());
    let path = folder::prepared(folder, card::CALIBRATION_FILE)?;
    film.write(&path, bench.set, bench.renderer, &|| task.tick())?;
    task.done(&format!("{} frames", film.frames()));
    Ok(())
}

fn write_solids(name: &str, tail: &Tail, fineness: Metre, folder: &Path) -> Result<()> {
    let (body, spine) = tail.solids(fineness).map_err(|e| Diagnostic::from(e).while_doing("the STL files"))?;
    for (file, part, surface) in [(card::BODY_FILE, "body", body), (card::SPINE_FILE, "spine", spine)] {
        let title = format!("{}: {part} of {name}", lab::VIRTUAL_BENCH);
        folder::write(folder, file, &mesh::stl::write(&surface, MILLIMETRE, &title))?;
    }
    Ok(())
}

fn paint(body: &Body, places: &[(String, si::Point3)], diameter: Metre) -> Result<Vec<Mark>> {
    let painted = |(name, at): &(String, si::Point3)| {
        let (mark, distance) = Mark::paint(&body.mesh, *at, diameter);
        if distance <= SKIN_DISTANCE_LIMIT {
            return Ok(mark);
        }
        let x = at[0] / MILLIMETRE;
        let what = format!("mark {name} at x = {x:.1} mm is {:.2} mm from the skin", distance / MILLIMETRE);
        let why = format!("the limit is {:.2} mm", SKIN_DISTANCE_LIMIT / MILLIMETRE);
        Err(in_settings(&what, &why, "choose an x on the back of the silicone, or a finer mesh"))
    };
    places.iter().map(painted).collect()
}

fn in_settings(what: &str, why: &str, action: &str) -> Diagnostic {
    Diagnostic::file(Path::new("bench.toml"), what, why, action)
}

/// The pixels of the marks and of the lamp while the tail is at rest.
fn observe_at_rest(bench: &Bench) -> Result<RestObservation> {
    let (camera, lamp) = (&bench.renderer.camera, &bench.set.lamp);
    let outside = || {
        let what = "a mark or the lamp is outside the picture";
        in_settings(what, "the card gives their pixels at rest", "move the camera, the mark or the lamp")
    };
    let rest = &bench.body.mesh.nodes;
    let marks = bench.subject.marks.iter().map(|m| m.pixel_at_rest(camera, rest)).collect::<Option<Vec<_>>>();
    let rim = camera.outline(&flat_disc(lamp.at, lamp.radius, 48)).ok_or_else(outside)?;
    let middle = centroid(&rim);
    let radius = rim.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(f64::INFINITY, f64::min);
    Ok(RestObservation { marks: marks.ok_or_else(outside)?, lamp: (middle, radius) })
}

/// The ground truth without the trials and the load cell.
fn truth(name: &str, seed: u64, hidden: &HiddenProperties, renderer: &Renderer) -> Truth {
    let camera = &renderer.camera;
    let l = &camera.lens;
    Truth {
        origin: lab::VIRTUAL_BENCH.to_owned(),
        specimen: name.to_owned(),
        seed,
        water_surface: Some(renderer.water.surface),
        body: hidden.body.clone(),
        spine: hidden.spine.clone(),
        casting: Some(truth::Casting {
            asymmetry: hidden.asymmetry,
            sheet_offset: hidden.sheet_offset,
            markers: hidden.marks.clone(),
        }),
        fluid: None,
        inflation: Vec::new(),
        lens: Lens { fx: l.fx, fy: l.fy, cx: l.cx, cy: l.cy, k1: l.k1, k2: l.k2, p1: l.p1, p2: l.p2, k3: l.k3 },
        pose: Pose { rotation: camera.pose.rotation, translation: camera.pose.translation },
        cell: None,
        trial: Vec::new(),
        force: Vec::new(),
    }
}
