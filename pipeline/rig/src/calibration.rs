//! The calibration film: the checkerboard in many poses, each held for several frames, then flat on the plane.

use std::path::Path;

use diagnostics::Result;
use si::Second;

use crate::film::{self, Frames};
use crate::random::RandomStream;
use crate::renderer::Renderer;
use crate::scene::board::{self, BoardPose};
use crate::settings::Settings;

/// The pose of the board in every frame.
pub(crate) struct Calibration {
    places: Vec<BoardPose>,
    /// Start and end of the interval in which the board lies on the plane, s.
    pub(crate) flat: [Second; 2],
    /// The board is at rest in every frame whose number is a multiple of this.
    pub(crate) every: usize,
}

impl Calibration {
    /// A recording of `poses` poses, drawn with `seed`.
    pub(crate) fn new(set: &Settings, renderer: &Renderer, poses: usize, seed: u64) -> Self {
        let layout = board::board_layout(&set.plane);
        let mut stops =
            board::calibration_poses(&renderer.camera, &layout, poses, &mut RandomStream::new(seed, "board"));
        stops.push(board::flat_pose(&set.plane));
        let (held, moving) = (set.calibration.held, set.calibration.moving);
        let mut places = Vec::new();
        for pair in stops.windows(2) {
            places.extend((0..held).map(|_| pair[0]));
            places
                .extend((1..=moving).map(|i| board::pose_between(&pair[0], &pair[1], i as f64 / (moving + 1) as f64)));
        }
        let first = places.len();
        places.extend((0..set.calibration.flat).map(|_| stops[stops.len() - 1]));
        let flat = [first, places.len() - 1].map(|frame| frame as f64 / set.camera.rate);
        Self { places, flat, every: held + moving }
    }

    /// Number of frames.
    pub(crate) fn frame_count(&self) -> usize {
        self.places.len()
    }

    /// Writes the film to `path`.
    ///
    /// # Errors
    /// When the encoder fails or the file cannot be written.
    pub(crate) fn write_film(&self, path: &Path, set: &Settings, renderer: &Renderer, tick: &dyn Fn()) -> Result<()> {
        let layout = board::board_layout(&set.plane);
        let draw = |frame: usize| {
            renderer.expose_canvas(&renderer.board_frame(&layout, &self.places[frame]), "calibration", frame)
        };
        film::write_film(path, &set.camera, &Frames { count: self.frame_count(), draw: &draw }, tick)
    }
}
