//! The studio: camera, backdrop and sensor of one specimen's recordings, and the frames they make.
//!
//! Stands on: the scene. Never knows: time, a file.

use si::{Metre, Point3};
use track::Gray;
use track::board::Board;

use crate::camera::Camera;
use crate::draw::Draw;
use crate::scene::board::{self, Place};
use crate::scene::paint::Mark;
use crate::scene::sensor::Sensor;
use crate::scene::skin::Skin;
use crate::scene::{Canvas, backdrop};
use crate::settings::{self, Settings};

/// Camera, backdrop and sensor.
pub struct Studio {
    /// The camera.
    pub camera: Camera,
    lamp: settings::Lamp,
    clamp: Metre,
    still: Canvas,
    sensor: Sensor,
}

/// What is filmed in a trial: the tail's skin and its marks.
pub struct Subject {
    /// The skin.
    pub skin: Skin,
    /// The marks on it.
    pub marks: Vec<Mark>,
}

impl Studio {
    /// The studio of a specimen: its camera is hung with `seed`, its holder grips as far as `clamp` (m).
    pub fn new(set: &Settings, seed: u64, clamp: Metre) -> Self {
        let camera = Camera::drawn(&set.camera, &mut Draw::new(seed, "camera"));
        let still = backdrop::draw(&camera, &set.plane, &set.lamp);
        let sensor = Sensor::new(camera.width, camera.height, set.camera.noise, seed);
        Self { camera, lamp: set.lamp.clone(), clamp, still, sensor }
    }

    /// The tail with its nodes at `nodes` (m), the lamp at `lit` (0 to 1); before the sensor.
    pub fn tail(&self, subject: &Subject, nodes: &[Point3], lit: f64) -> Canvas {
        let mut canvas = self.still.clone();
        subject.skin.draw(&mut canvas, &self.camera, nodes);
        subject.marks.iter().for_each(|mark| mark.draw(&mut canvas, &self.camera, nodes));
        backdrop::holder(&mut canvas, &self.camera, self.clamp);
        if lit > 0.0 {
            backdrop::light(&mut canvas, &self.camera, &self.lamp, lit);
        }
        canvas
    }

    /// The checkerboard; before the sensor.
    pub fn board(&self, board: &Board, place: &Place) -> Canvas {
        let mut canvas = self.still.clone();
        board::draw(&mut canvas, &self.camera, board, place);
        canvas
    }

    /// What the sensor makes of a canvas; `label` and `frame` name its noise.
    pub fn expose(&self, canvas: &Canvas, label: &str, frame: usize) -> Gray {
        self.sensor.expose(canvas, label, frame)
    }
}
