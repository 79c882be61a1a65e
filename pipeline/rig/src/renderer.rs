//! The renderer: camera, water, backdrop and sensor of one specimen's recordings, and the frames that they give.

use lab::card::Medium;
use si::{Metre, Second};
use track::Gray;
use track::board::Board;
use track::pose::Pose;

use crate::camera::{Camera, FrameMotion, View, Water};
use crate::random::RandomStream;
use crate::scene::board::{self, BoardPose};
use crate::scene::glints::{self, Glint};
use crate::scene::mark::Mark;
use crate::scene::sensor::Sensor;
use crate::scene::skin::Skin;
use crate::scene::{Canvas, backdrop};
use crate::settings::{self, Settings};

/// Camera, water, backdrop and sensor.
pub struct Renderer {
    /// The camera.
    pub camera: Camera,
    /// The water of the trials in water, at rest, at its true height.
    pub water: Water,
    seed: u64,
    set: settings::Water,
    lamp: settings::Lamp,
    clamp: Metre,
    plane: settings::Plane,
    nudge: settings::PosePerturbation,
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

/// The renderer for one recording: the camera in the recording's own pose, in air or above its own ripples and glints.
pub struct RecordingRenderer<'a> {
    /// The camera and the water in front of it.
    pub view: View,
    renderer: &'a Renderer,
    backdrop: Canvas,
    glints: Vec<Glint>,
}

impl Subject {
    /// Nodes of the mesh that are visible, ascending.
    pub(crate) fn visible_nodes(&self) -> Vec<u32> {
        in_rising_order(self.skin.skin_nodes().iter().copied().chain(self.mark_nodes()))
    }

    /// Nodes of the mesh that carry marks, ascending.
    pub(crate) fn mark_nodes(&self) -> Vec<u32> {
        in_rising_order(self.marks.iter().flat_map(Mark::nodes))
    }
}

fn in_rising_order(nodes: impl Iterator<Item = u32>) -> Vec<u32> {
    nodes.collect::<std::collections::BTreeSet<u32>>().into_iter().collect()
}

impl Renderer {
    /// The renderer of a specimen: camera pose and water level are drawn with `seed`; the holder ends at x = `clamp` (m).
    pub fn new(set: &Settings, seed: u64, clamp: Metre) -> Self {
        let camera = Camera::draw_camera(&set.camera, &mut RandomStream::new(seed, "camera"));
        let error = RandomStream::new(seed, "water").uniform(set.water.surface_error);
        let water = Water::at_rest(set.water.surface + error, set.water.index);
        let dry = backdrop::draw_backdrop(&View { camera, water: None }, &set.plane, &set.lamp);
        let sensor = Sensor::new(camera.width, camera.height, set.camera.noise, seed);
        let (plane, nudge) = (set.plane.clone(), set.causes.nudge);
        Self { camera, water, seed, set: set.water.clone(), lamp: set.lamp.clone(), clamp, plane, nudge, dry, sensor }
    }

    /// The renderer for the recording `label`.
    pub fn of_recording(&self, medium: Medium, label: &str) -> RecordingRenderer<'_> {
        let draw = |what: &str| RandomStream::new(self.seed, &format!("{what} {label}"));
        let camera = self.camera.perturbed_camera(&self.nudge, &mut draw("nudge"));
        let at_rest = (medium == Medium::Water).then(|| self.water.clone());
        let backdrop = backdrop::draw_backdrop(&View { camera, water: at_rest }, &self.plane, &self.lamp);
        match medium {
            Medium::Air => {
                RecordingRenderer { view: View { camera, water: None }, renderer: self, backdrop, glints: Vec::new() }
            }
            Medium::Water => {
                let water = self.water.rippled(&self.set, &mut draw("ripples"));
                let glints = glints::draw_glints(&self.set, camera.width, camera.height, &mut draw("glints"));
                RecordingRenderer { view: View { camera, water: Some(water) }, renderer: self, backdrop, glints }
            }
        }
    }

    /// The frame of the checkerboard in air; before the sensor.
    pub(crate) fn board_frame(&self, board: &Board, pose: &BoardPose) -> Canvas {
        let mut canvas = self.dry.clone();
        board::draw_board(&mut canvas, &self.camera, board, pose);
        canvas
    }

    /// The picture of a canvas by the sensor; `label` and `frame` select the noise.
    pub fn expose_canvas(&self, canvas: &Canvas, label: &str, frame: usize) -> Gray {
        self.sensor.expose_canvas(canvas, label, frame)
    }
}

impl RecordingRenderer<'_> {
    /// Pose of the camera.
    pub(crate) fn camera_pose(&self) -> lab::truth::Pose {
        let Pose { rotation, translation } = self.view.camera.pose;
        lab::truth::Pose { rotation, translation }
    }

    /// Delay of the lamp's rows after the frame's time, s.
    pub(crate) fn lamp_delay(&self) -> Second {
        let lamp = self.view.project_static(self.renderer.lamp.at);
        lamp.map_or(0.0, |[_, v]| self.view.camera.row_delay(v))
    }

    /// The frame of the tail in `motion`, the lamp at the relative brightness `lit` (0 to 1); before the sensor.
    pub fn tail_frame(&self, subject: &Subject, motion: &FrameMotion, lit: f64) -> Canvas {
        let (renderer, view) = (self.renderer, &self.view);
        let mut canvas = self.backdrop.clone();
        subject.skin.draw_in_frame(&mut canvas, view, motion);
        subject.marks.iter().for_each(|mark| mark.draw_in_frame(&mut canvas, view, motion));
        backdrop::draw_holder(&mut canvas, view, renderer.clamp);
        if lit > 0.0 {
            backdrop::draw_lamp(&mut canvas, view, &renderer.lamp, lit);
        }
        self.glints.iter().for_each(|glint| glint.add_to_canvas(&mut canvas, view, motion.time));
        canvas
    }
}
