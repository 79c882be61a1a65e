//! The calibration recording: the checkerboard in many poses, each held for some frames, then flat on the plane.
//!
//! Stands on: the studio, the scene's board. Never knows: a specimen.

use std::path::Path;

use si::Second;

use crate::draw::Draw;
use crate::fault::Fault;
use crate::film;
use crate::scene::board::{self, Place};
use crate::settings::Settings;
use crate::studio::Studio;

/// Where the board is in every frame.
pub struct Calibration {
    places: Vec<Place>,
    /// First and last second in which the board lies still on the plane.
    pub flat: [Second; 2],
    /// The board is still in every frame whose number is a multiple of this.
    pub every: usize,
}

impl Calibration {
    /// A recording of `poses` poses, drawn with `seed`.
    pub fn new(set: &Settings, studio: &Studio, poses: usize, seed: u64) -> Self {
        let layout = board::layout(&set.plane);
        let mut stops = board::poses(&studio.camera, &layout, poses, &mut Draw::new(seed, "board"));
        stops.push(board::flat(&set.plane));
        let (held, moving) = (set.calibration.held, set.calibration.moving);
        let mut places = Vec::new();
        for pair in stops.windows(2) {
            places.extend((0..held).map(|_| pair[0]));
            places.extend((1..=moving).map(|i| board::between(&pair[0], &pair[1], i as f64 / (moving + 1) as f64)));
        }
        let first = places.len();
        places.extend((0..set.calibration.flat).map(|_| stops[stops.len() - 1]));
        let flat = [first, places.len() - 1].map(|frame| frame as f64 / set.camera.rate);
        Self { places, flat, every: held + moving }
    }

    /// Frames in all.
    pub fn frames(&self) -> usize {
        self.places.len()
    }

    /// Films it.
    ///
    /// # Errors
    /// [`Fault`] when the encoder or the disk refuses.
    pub fn shoot(&self, path: &Path, set: &Settings, studio: &Studio, tick: &dyn Fn()) -> Result<(), Fault> {
        let layout = board::layout(&set.plane);
        let draw = |frame: usize| studio.expose(&studio.board(&layout, &self.places[frame]), "calibration", frame);
        film::shoot(path, &set.camera, self.frames(), &draw, tick)
    }
}
