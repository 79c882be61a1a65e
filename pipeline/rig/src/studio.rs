//! The studio: camera, water, backdrop and sensor of one specimen's recordings, and the frames they make.
//!
//! Stands on: the scene. Never knows: whose motion it films, a file.

use lab::card::Medium;
use si::{Metre, Second};
use track::Gray;
use track::board::Board;
use track::pose::Pose;

use crate::camera::{Camera, Passing, View, Water};
use crate::draw::Draw;
use crate::scene::board::{self, Place};
use crate::scene::glints::{self, Glint};
use crate::scene::paint::Mark;
use crate::scene::sensor::Sensor;
use crate::scene::skin::Skin;
use crate::scene::{Canvas, backdrop};
use crate::settings::{self, Settings};

/// Camera, water, backdrop and sensor.
pub struct Studio {
    /// The camera.
    pub camera: Camera,
    /// The water of the trials in water, at rest, as high as it truly stands.
    pub water: Water,
    seed: u64,
    set: settings::Water,
    lamp: settings::Lamp,
    clamp: Metre,
    plane: settings::Plane,
    nudge: settings::Nudge,
    dry: Canvas,
    sensor: Sensor,
}

/// What is filmed in a trial: the tail's skin and its marks.
pub struct Subject {
    /// The skin.
    pub skin: Skin,
    /// The marks on it.
    pub marks: Vec<Mark>,
}

/// The studio in one recording: the camera as a hand left it that started it, dry, or under its own ripples and glints.
pub struct Set<'a> {
    /// What the camera sees through.
    pub view: View,
    studio: &'a Studio,
    still: Canvas,
    glints: Vec<Glint>,
}

impl Subject {
    /// Nodes of the mesh that are in the picture, rising.
    pub fn nodes(&self) -> Vec<u32> {
        rising(self.skin.nodes().iter().copied().chain(self.mark_nodes()))
    }

    /// Nodes of the mesh that carry marks, rising.
    pub fn mark_nodes(&self) -> Vec<u32> {
        rising(self.marks.iter().flat_map(Mark::nodes))
    }
}

fn rising(nodes: impl Iterator<Item = u32>) -> Vec<u32> {
    nodes.collect::<std::collections::BTreeSet<u32>>().into_iter().collect()
}

impl Studio {
    /// The studio of a specimen: its camera is hung and its tank filled with `seed`, its holder grips as far as `clamp` (m).
    pub fn new(set: &Settings, seed: u64, clamp: Metre) -> Self {
        let camera = Camera::drawn(&set.camera, &mut Draw::new(seed, "camera"));
        let high = Draw::new(seed, "water").between(set.water.surface_error);
        let water = Water::still(set.water.surface + high, set.water.index);
        let dry = backdrop::draw(&View { camera, water: None }, &set.plane, &set.lamp);
        let sensor = Sensor::new(camera.width, camera.height, set.camera.noise, seed);
        let (plane, nudge) = (set.plane.clone(), set.causes.nudge);
        Self { camera, water, seed, set: set.water.clone(), lamp: set.lamp.clone(), clamp, plane, nudge, dry, sensor }
    }

    /// The studio in the recording `label`.
    pub fn set(&self, medium: Medium, label: &str) -> Set<'_> {
        let draw = |what: &str| Draw::new(self.seed, &format!("{what} {label}"));
        let camera = self.camera.nudged(&self.nudge, &mut draw("nudge"));
        let at_rest = (medium == Medium::Water).then(|| self.water.clone());
        let still = backdrop::draw(&View { camera, water: at_rest }, &self.plane, &self.lamp);
        match medium {
            Medium::Air => Set { view: View { camera, water: None }, studio: self, still, glints: Vec::new() },
            Medium::Water => {
                let water = self.water.rippled(&self.set, &mut draw("ripples"));
                let glints = glints::drawn(&self.set, camera.width, camera.height, &mut draw("glints"));
                Set { view: View { camera, water: Some(water) }, studio: self, still, glints }
            }
        }
    }

    /// The checkerboard, in air; before the sensor.
    pub fn board(&self, board: &Board, place: &Place) -> Canvas {
        let mut canvas = self.dry.clone();
        board::draw(&mut canvas, &self.camera, board, place);
        canvas
    }

    /// What the sensor makes of a canvas; `label` and `frame` name its noise.
    pub fn expose(&self, canvas: &Canvas, label: &str, frame: usize) -> Gray {
        self.sensor.expose(canvas, label, frame)
    }
}

impl Set<'_> {
    /// Where the camera is.
    pub fn pose(&self) -> lab::truth::Pose {
        let Pose { rotation, translation } = self.view.camera.pose;
        lab::truth::Pose { rotation, translation }
    }

    /// How much later than the frame's time the lamp's rows are read, s.
    pub fn lamp_late(&self) -> Second {
        let lamp = self.view.still(self.studio.lamp.at);
        lamp.map_or(0.0, |[_, v]| self.view.camera.late(v))
    }

    /// The tail as it passes, the lamp at `lit` (0 to 1); before the sensor.
    pub fn tail(&self, subject: &Subject, by: &Passing, lit: f64) -> Canvas {
        let (studio, view) = (self.studio, &self.view);
        let mut canvas = self.still.clone();
        subject.skin.draw(&mut canvas, view, by);
        subject.marks.iter().for_each(|mark| mark.draw(&mut canvas, view, by));
        backdrop::holder(&mut canvas, view, studio.clamp);
        if lit > 0.0 {
            backdrop::light(&mut canvas, view, &studio.lamp, lit);
        }
        self.glints.iter().for_each(|glint| glint.draw(&mut canvas, view, by.time));
        canvas
    }
}
