//! Recording a specimen: from its shape and what is hidden in it to a folder that a laboratory could have filled.
//!
//! This is the bench's runner: it alone chooses paths, keeps finished recordings and replaces its own stale ones.
//!
//! Stands on: every room of the bench. Never knows: the command line.

use std::path::Path;

use lab::card::{Side, Trial};
use lab::truth::{self, Lens, Pose, TrueForce, TrueTrial, Truth};
use rayon::prelude::*;
use shape::tail::Tail;
use si::{MILLIMETRE, Metre};

use crate::calibration::Calibration;
use crate::camera::flat_disc;
use crate::card::{self, Seen};
use crate::draw::Draw;
use crate::fault::Fault;
use crate::folder;
use crate::physics::{Body, Fluid, Ladder, Swimmer, training};
use crate::progress::Progress;
use crate::receipts;
use crate::scene::canvas::centroid;
use crate::scene::paint::Mark;
use crate::scene::skin::Skin;
use crate::settings::{self, Profile, Settings};
use crate::specimen::{Hidden, SHEET, Specimen};
use crate::stamp::{self, Found};
use crate::studio::{Studio, Subject};
use crate::trial::{self, Bench};
use crate::weighing;

/// What became of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The recording was there already.
    Kept,
    /// It was made.
    Made,
}

/// Marks may be this far from the bench's own skin, m: the card's place and the mesh's differ by the mesh's fineness.
const OFF_SKIN: Metre = 2e-4;

/// Records `specimen` with the settings' `profile` into `into/<name>`, unless it is there.
///
/// # Errors
/// [`Fault`] when the folder is not the bench's, the body cannot be solved, or the disk refuses.
pub fn record(
    specimen: &Specimen,
    set: &Settings,
    profile: &str,
    into: &Path,
    progress: &Progress,
) -> Result<Outcome, Fault> {
    let (folder, stamp) = (into.join(specimen.name), stamp::text(specimen, profile));
    if stamp::look(&folder, &stamp)? == Found::Current {
        return Ok(Outcome::Kept);
    }
    let partial = folder::begin(into, specimen.name, stamp::FILE, &stamp)?;
    fill(specimen, set, &set.profile[profile], &partial, progress).map_err(|e| Fault::at(specimen.name, e))?;
    receipts::clear(&partial)?;
    folder::finish(&partial, &folder)?;
    Ok(Outcome::Made)
}

fn fill(
    specimen: &Specimen,
    set: &Settings,
    profile: &Profile,
    folder: &Path,
    progress: &Progress,
) -> Result<(), Fault> {
    let (name, own, tail) = (specimen.name, &set.specimen[specimen.name], (specimen.tail)());
    let hidden = Hidden::drawn(set, own);
    write_solids(name, &tail, set.cad.fineness, folder)?;
    let materials = [&set.material[&own.body], &set.material[SHEET]];
    let body = Body::new(&tail, &profile.resolution, own.clamp, materials, &hidden)?;
    let studio = Studio::new(set, own.seed, own.clamp);
    let places = card::painted(&tail, own, &hidden.marks);
    let subject = Subject { skin: Skin::new(&body.mesh), marks: paint(&body, &places, own.marker_diameter)? };
    let marks: Vec<String> = places.into_iter().map(|(name, _)| name).collect();
    let ladders = climb(name, &body, set, own, profile, progress)?;
    let trials = card::trials(own, profile);
    let swimmer = train(name, &body, &hidden.cast(&tail), own.clamp, &ladders, progress)?;
    let bench = Bench {
        set,
        profile,
        name,
        seed: own.seed,
        body: &body,
        ladders: &ladders,
        swimmer: &swimmer,
        fluid: fluid(set, own.seed),
        studio: &studio,
        subject: &subject,
        marks: &marks,
        progress,
    };
    let film = Calibration::new(set, &studio, profile.poses, own.seed);
    let seen = first_sight(&bench)?;
    let card = card::write(name, set, &tail, &trials, &seen, &film);
    folder::write(folder, lab::folder::CARD, lab::card::write(&card).as_bytes())?;
    let (trial, mut force) = side_by_side(&bench, &film, &trials, folder)?;
    for fixture in &card.fixture {
        force.push(weighing::of_fixture(set, own.seed, fixture, folder)?);
    }
    let Fluid { density, added, drag } = bench.fluid;
    let truth = Truth {
        cell: Some(weighing::truth(set, own.seed)),
        fluid: Some(truth::Fluid { density, added, drag }),
        trial,
        force,
        ..truth(name, own.seed, &hidden, &studio)
    };
    folder::write(folder, lab::folder::TRUTH, lab::truth::write(&truth).as_bytes())
}

/// The water of a specimen's recordings.
fn fluid(set: &Settings, seed: u64) -> Fluid {
    let mut draw = Draw::new(seed, "fluid");
    let (added, drag) = (draw.between(set.fluid.added), draw.between(set.fluid.drag));
    Fluid { density: set.fluid.density, added, drag }
}

/// Both sides' ladders, to the highest pressure that a run may settle at.
fn climb(
    name: &str,
    body: &Body,
    set: &Settings,
    own: &settings::Specimen,
    profile: &Profile,
    progress: &Progress,
) -> Result<[Ladder; 2], Fault> {
    let top = own.highest() * (1.0 + set.causes.supply) - set.valve.droop;
    let task = progress.begin("statics", name, 2 * profile.rungs);
    let side = |side: Side| Ladder::climb(body, side, top, profile.rungs, &|| task.tick());
    let (left, right) = rayon::join(|| side(Side::Left), || side(Side::Right));
    task.done(&format!("{} equilibria of {} unknowns", 2 * profile.rungs, body.system.freedoms()));
    Ok([left?, right?])
}

/// The specimen in the coordinates in which it moves.
fn train<'a>(
    name: &str,
    body: &'a Body,
    tail: &Tail,
    clamp: Metre,
    ladders: &[Ladder; 2],
    progress: &Progress,
) -> Result<Swimmer<'a>, Fault> {
    let task = progress.begin("reduce", name, training::COUNT);
    let swimmer = Swimmer::train(body, tail, clamp, ladders, &|| task.tick())?;
    let points: usize = swimmer.reduced.points().iter().sum();
    task.done(&format!("{} coordinates, {points} points", swimmer.reduced.coordinates()));
    Ok(swimmer)
}

/// The calibration and every trial, side by side; results in the card's order. What has its receipt is there already.
fn side_by_side(
    bench: &Bench,
    film: &Calibration,
    trials: &[Trial],
    folder: &Path,
) -> Result<(Vec<TrueTrial>, Vec<TrueForce>), Fault> {
    let one = |trial: &Trial| match receipts::find(folder, &trial.id) {
        Some(hidden) => Ok(hidden),
        None => {
            let hidden = trial::record(bench, trial, folder)?;
            receipts::leave(folder, &trial.id, &hidden)?;
            Ok(hidden)
        }
    };
    let all = || trials.par_iter().map(one).collect::<Result<Vec<_>, Fault>>();
    let (calibrated, hidden) = rayon::join(|| calibrate(bench, film, folder), all);
    let (trials, forces): (Vec<_>, Vec<_>) = calibrated.and(hidden)?.into_iter().map(|h| (h.trial, h.force)).unzip();
    Ok((trials, forces.into_iter().flatten().collect()))
}

fn calibrate(bench: &Bench, film: &Calibration, folder: &Path) -> Result<(), Fault> {
    let task = bench.progress.begin("film", format!("{}/calibration", bench.name), film.frames());
    let path = folder::prepared(folder, card::CALIBRATION_FILE)?;
    film.shoot(&path, bench.set, bench.studio, &|| task.tick())?;
    task.done(&format!("{} frames", film.frames()));
    Ok(())
}

fn write_solids(name: &str, tail: &Tail, fineness: Metre, folder: &Path) -> Result<(), Fault> {
    let (body, spine) = tail.solids(fineness).map_err(|e| Fault::at("the STL files", e))?;
    for (file, part, surface) in [(card::BODY_FILE, "body", body), (card::SPINE_FILE, "spine", spine)] {
        let title = format!("{}: {part} of {name}", lab::VIRTUAL_BENCH);
        folder::write(folder, file, &shape::stl::write(&surface, MILLIMETRE, &title))?;
    }
    Ok(())
}

fn paint(body: &Body, places: &[(String, si::Point3)], diameter: Metre) -> Result<Vec<Mark>, Fault> {
    let painted = |(name, at): &(String, si::Point3)| {
        let (mark, off) = Mark::paint(&body.mesh, *at, diameter);
        if off <= OFF_SKIN {
            return Ok(mark);
        }
        let what =
            format!("mark {name} at x = {:.1} mm lies {:.2} mm off the skin", at[0] / MILLIMETRE, off / MILLIMETRE);
        let why = format!("paint lies within {:.2} mm", OFF_SKIN / MILLIMETRE);
        Err(Fault::new("bench.toml", &what, &why, "choose an x on the silicone's back, or a finer mesh"))
    };
    places.iter().map(painted).collect()
}

/// The marks and the lamp while the tail is at rest.
fn first_sight(bench: &Bench) -> Result<Seen, Fault> {
    let (camera, lamp) = (&bench.studio.camera, &bench.set.lamp);
    let hidden = || {
        Fault::new(
            "bench.toml",
            "a mark or the lamp is out of the picture",
            "the camera must see them at rest",
            "move it",
        )
    };
    let rest = &bench.body.mesh.nodes;
    let marks =
        bench.subject.marks.iter().map(|m| m.pixel(camera, rest)).collect::<Option<Vec<_>>>().ok_or_else(hidden)?;
    let rim = camera.outline(&flat_disc(lamp.at, lamp.radius, 48)).ok_or_else(hidden)?;
    let middle = centroid(&rim);
    let radius = rim.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(f64::INFINITY, f64::min);
    Ok(Seen { marks, lamp: (middle, radius) })
}

/// What is hidden but for the trials and the load cell.
fn truth(name: &str, seed: u64, hidden: &Hidden, studio: &Studio) -> Truth {
    let camera = &studio.camera;
    let l = &camera.lens;
    Truth {
        origin: lab::VIRTUAL_BENCH.to_owned(),
        specimen: name.to_owned(),
        seed,
        water_surface: Some(studio.water.surface),
        body: hidden.body.clone(),
        spine: hidden.spine.clone(),
        damping: hidden.damping.clone(),
        casting: Some(truth::Casting { asymmetry: hidden.asymmetry, markers: hidden.marks.clone() }),
        fluid: None,
        lens: Lens { fx: l.fx, fy: l.fy, cx: l.cx, cy: l.cy, k1: l.k1, k2: l.k2, p1: l.p1, p2: l.p2, k3: l.k3 },
        pose: Pose { rotation: camera.pose.rotation, translation: camera.pose.translation },
        cell: None,
        trial: Vec::new(),
        force: Vec::new(),
    }
}
