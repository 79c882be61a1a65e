//! A specimen on the bench: what the parts of its recording share.

use std::path::Path;

use diagnostics::{Diagnostic, Result};
use lab::card::{Experiment, Trial};
use lab::truth::Unbonded;
use rayon::prelude::*;
use si::{MILLIMETRE, Metre, Pascal};
use tail_cad::Tail;

use super::Request;
use crate::bench::Bench;
use crate::calibration::Calibration;
use crate::camera::flat_disc;
use crate::card::{self, RestObservation};
use crate::physics::{self, Body, BodySettings, CentreLine, FlappingModel, Fluid, PressureSweep, SoftenedModel};
use crate::random::RandomStream;
use crate::renderer::{Renderer, Subject};
use crate::scene::canvas::area_centroid;
use crate::scene::mark::Mark;
use crate::scene::skin::Skin;
use crate::settings::{self, Profile, Settings};
use crate::specimen::{HiddenProperties, SHEET, Specimen};

/// Largest distance of a mark from the skin of the bench's mesh, m. The card's point lies on the CAD surface; the mesh approximates it.
const SKIN_DISTANCE_LIMIT: Metre = 2e-4;

/// A specimen on the bench.
pub(super) struct Setup<'a> {
    /// What is recorded.
    pub(super) request: &'a Request<'a>,
    /// The specimen's name.
    pub(super) name: &'a str,
    /// Its settings.
    own: &'a settings::Specimen,
    /// Extent and resolution.
    pub(super) profile: &'a Profile,
    /// Its nominal shape.
    pub(super) tail: Tail,
    /// Its hidden properties.
    pub(super) hidden: HiddenProperties,
    /// The specimen as a finite-element system.
    pub(super) body: Body,
    /// The camera and its surroundings.
    pub(super) renderer: Renderer,
    subject: Subject,
    marks: Vec<String>,
    /// Its trials, in the card's order.
    pub(super) trials: Vec<Trial>,
}

impl<'a> Setup<'a> {
    /// The specimen of a request.
    ///
    /// # Errors
    /// When the tail's dimensions are inconsistent, a material law is unknown, or a mark lies off the skin.
    pub(super) fn new(specimen: &'a Specimen, request: &'a Request<'a>) -> Result<Self> {
        let Request { set, profile, .. } = *request;
        let (name, own, profile) = (&*specimen.name, &set.specimen[&*specimen.name], &set.profile[profile]);
        let (tail, hidden) = ((specimen.tail)(), HiddenProperties::drawn(set, own));
        let laws = [&*set.material[&own.body].law, &*set.material[SHEET].law];
        let settings = BodySettings { resolution: &profile.resolution, clamp: own.clamp, laws };
        let body = Body::new(&tail, &settings, &hidden)?;
        let renderer = Renderer::new(set, own.seed, own.clamp);
        let places = card::painted_marks(&tail, own, &hidden.marks);
        let subject = Subject { skin: Skin::new(&body.mesh), marks: paint_marks(&body, &places, own.marker_diameter)? };
        let marks = places.into_iter().map(|(name, _)| name).collect();
        let trials = card::planned_trials(own, profile);
        Ok(Self { request, name, own, profile, tail, hidden, body, renderer, subject, marks, trials })
    }

    /// What everything hidden of it is drawn from.
    pub(super) fn seed(&self) -> u64 {
        self.own.seed
    }

    /// The pressures of each side's sweep, Pa.
    pub(super) fn sweep_pressures(&self) -> Vec<Pascal> {
        let set = self.request.set;
        physics::even_pressures(
            self.own.highest_pressure() * (1.0 + set.causes.supply) - set.valve.droop,
            self.profile.levels,
        )
    }

    /// The centre line of the tail as it was cast.
    pub(super) fn centre_line(&self) -> CentreLine {
        CentreLine::of_tail(&self.hidden.cast_tail(&self.tail), &self.body, self.own.clamp)
    }

    /// Where the silicone does not adhere to the sheet.
    pub(super) fn true_unbonded(&self) -> Option<Unbonded> {
        let tail = self.hidden.cast_tail(&self.tail);
        let ([from, to], side) = (tail.unbonded_stretch()?, tail.unbonded?.side);
        Some(Unbonded { side: if side == 0 { "-y" } else { "+y" }.to_owned(), from, to })
    }

    /// The calibration film.
    pub(super) fn calibration_film(&self) -> Calibration {
        Calibration::new(self.request.set, &self.renderer, self.profile.poses, self.own.seed)
    }

    /// Does something on the bench, with the equilibria and the reduced model of the specimen.
    ///
    /// # Errors
    /// Those of what is done; also when an equilibrium of the reduced model is not found.
    pub(super) fn on_bench<T>(
        &self,
        (sweeps, reduced): (&[PressureSweep; 2], &fem::ReducedModelData),
        run: &dyn Fn(&Bench) -> Result<T>,
    ) -> Result<T> {
        let flapping_model = FlappingModel::of_reduced_data(&self.body, self.centre_line(), sweeps, reduced)?;
        let softened = self.softened_models(&flapping_model, &sweeps[0].pressures)?;
        let Request { set, progress, .. } = *self.request;
        run(&Bench {
            set,
            profile: self.profile,
            name: self.name,
            seed: self.own.seed,
            body: &self.body,
            sweeps,
            flapping_model: &flapping_model,
            softened: &softened,
            fluid: draw_fluid(set, self.own.seed),
            renderer: &self.renderer,
            subject: &self.subject,
            marks: &self.marks,
            progress,
        })
    }

    /// The model after the cycles of every amplitude among the trials.
    fn softened_models(&self, model: &FlappingModel, pressures: &[Pascal]) -> Result<Vec<(Pascal, SoftenedModel)>> {
        let amplitude = |trial: &Trial| match trial.experiment {
            Experiment::Flapping { amplitude, .. } => Some(amplitude),
            Experiment::Staircase { .. } => None,
        };
        let mut amplitudes: Vec<Pascal> = self.trials.iter().filter_map(amplitude).collect();
        amplitudes.sort_by(f64::total_cmp);
        amplitudes.dedup();
        let mullins = &self.request.set.causes.mullins;
        amplitudes
            .into_par_iter()
            .map(|amplitude| Ok((amplitude, model.softened_model(mullins, pressures, amplitude)?)))
            .collect()
    }

    /// The pixels of the marks and of the lamp while the tail is at rest.
    pub(super) fn observe_at_rest(&self) -> Result<RestObservation> {
        let (camera, lamp, rest) = (&self.renderer.camera, &self.request.set.lamp, &self.body.mesh.nodes);
        let outside = || {
            let message = "a mark or the lamp is outside the picture";
            in_settings(message, "the card gives their pixels at rest", "move the camera, the mark or the lamp")
        };
        let marks = self.subject.marks.iter().map(|m| m.pixel_at_rest(camera, rest)).collect::<Option<Vec<_>>>();
        let rim = camera.outline(&flat_disc(lamp.at, lamp.radius, 48)).ok_or_else(outside)?;
        let middle = area_centroid(&rim);
        let radius = rim.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(f64::INFINITY, f64::min);
        Ok(RestObservation { marks: marks.ok_or_else(outside)?, lamp: (middle, radius) })
    }
}

/// The water of a specimen's recordings.
fn draw_fluid(set: &Settings, seed: u64) -> Fluid {
    let mut random = RandomStream::new(seed, "fluid");
    let (added, drag) = (random.uniform(set.fluid.added), random.uniform(set.fluid.drag));
    Fluid { density: set.fluid.density, added, drag }
}

fn paint_marks(body: &Body, places: &[(String, si::Point3)], diameter: Metre) -> Result<Vec<Mark>> {
    let painted = |(name, position): &(String, si::Point3)| {
        let (mark, distance) = Mark::paint_on_skin(&body.mesh, *position, diameter);
        if distance <= SKIN_DISTANCE_LIMIT {
            return Ok(mark);
        }
        let x = position[0] / MILLIMETRE;
        let message = format!("mark {name} at x = {x:.1} mm is {:.2} mm from the skin", distance / MILLIMETRE);
        let why = format!("the limit is {:.2} mm", SKIN_DISTANCE_LIMIT / MILLIMETRE);
        Err(in_settings(&message, &why, "choose an x on the back of the silicone, or a finer mesh"))
    };
    places.iter().map(painted).collect()
}

fn in_settings(what: &str, why: &str, action: &str) -> Diagnostic {
    Diagnostic::file(Path::new("bench.toml"), what, why, action)
}
