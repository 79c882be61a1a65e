//! Glints: diffuse reflections of the room lights in the water, which move with its ripples.
//!
//! A surface tilted by s rotates a reflection by 2 s, so a glint moves by 2 s times the distance of its light.

use si::{Point2, Second};

use super::Canvas;
use crate::camera::View;
use crate::random::RandomStream;
use crate::settings;

/// Length of the light path from the camera over the surface to a ceiling light, m.
const PATH: f64 = 2.0;
/// Radius in which a glint is drawn, in standard deviations; its brightness is 1 % there.
const RADIUS: f64 = 3.0;

/// One reflection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glint {
    middle: Point2,
    size: f64,
    bright: f64,
}

/// The reflections of one recording.
pub(crate) fn draw_glints(set: &settings::Water, width: usize, height: usize, random: &mut RandomStream) -> Vec<Glint> {
    let glint = |_| {
        let middle = [random.uniform([0.1, 0.9]) * width as f64, random.uniform([0.1, 0.9]) * height as f64];
        Glint { middle, size: random.uniform(set.glint_size), bright: random.uniform(set.glint) }
    };
    (0..set.glints).map(glint).collect()
}

impl Glint {
    /// Adds the reflection to a canvas at time `t` (s); none without water.
    pub(crate) fn add_to_canvas(&self, canvas: &mut Canvas, view: &View, t: Second) {
        let Some(water) = &view.water else { return };
        let focal = view.camera.lens.fx;
        let eye = view.camera.centre_of_projection();
        let tilt = water.surface_slope([eye[0], eye[1]], t);
        let scale = 2.0 * PATH * focal;
        let middle = [self.middle[0] + scale * tilt[0], self.middle[1] - scale * tilt[1]];
        let span = |k: usize, size: usize| {
            let ends = [-RADIUS, RADIUS].map(|end| (middle[k] + end * self.size).clamp(0.0, size as f64) as usize);
            ends[0]..ends[1]
        };
        let fall = |x: usize, k: usize| (-0.5 * ((x as f64 - middle[k]) / self.size).powi(2)).exp();
        let columns = span(0, canvas.width);
        let column_brightness: Vec<f32> = columns.clone().map(|u| (self.bright * fall(u, 0)) as f32).collect();
        for v in span(1, canvas.height) {
            let brightness = fall(v, 1) as f32;
            let row = &mut canvas.levels[v * canvas.width..][columns.clone()];
            row.iter_mut().zip(&column_brightness).for_each(|(level, bright)| *level += brightness * bright);
        }
    }
}
