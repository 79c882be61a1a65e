//! Glints: soft reflections of the room's lights in the water, which wander with its ripples.
//!
//! A surface tilted by s turns a reflection by 2 s, so a glint wanders by 2 s times its light's distance.
//!
//! Stands on: the canvas, the water. Never knows: what lies under the water.

use si::{Point2, Second};

use super::Canvas;
use crate::camera::View;
use crate::draw::Draw;
use crate::settings;

/// From the camera over the surface to a light at the ceiling, m: what a slope is multiplied by.
const AWAY: f64 = 2.0;
/// A glint is drawn this far from its middle, in deviations; there it is 1 % of its brightness.
const FAR: f64 = 3.0;

/// One reflection.
#[derive(Debug, Clone, Copy)]
pub struct Glint {
    middle: Point2,
    size: f64,
    bright: f64,
}

/// The reflections of one recording.
pub fn drawn(set: &settings::Water, width: usize, height: usize, draw: &mut Draw) -> Vec<Glint> {
    let glint = |_| {
        let middle = [draw.between([0.1, 0.9]) * width as f64, draw.between([0.1, 0.9]) * height as f64];
        Glint { middle, size: draw.between(set.glint_size), bright: draw.between(set.glint) }
    };
    (0..set.glints).map(glint).collect()
}

impl Glint {
    /// Adds the reflection to a canvas at time `t` (s); nothing without water.
    pub fn draw(&self, canvas: &mut Canvas, view: &View, t: Second) {
        let Some(water) = &view.water else { return };
        let focal = view.camera.lens.fx;
        let eye = view.camera.eye();
        let tilt = water.slope([eye[0], eye[1]], t);
        let scale = 2.0 * AWAY * focal;
        let middle = [self.middle[0] + scale * tilt[0], self.middle[1] - scale * tilt[1]];
        let span = |k: usize, size: usize| {
            let ends = [-FAR, FAR].map(|far| (middle[k] + far * self.size).clamp(0.0, size as f64) as usize);
            ends[0]..ends[1]
        };
        let fall = |x: usize, k: usize| (-0.5 * ((x as f64 - middle[k]) / self.size).powi(2)).exp();
        let columns = span(0, canvas.width);
        let across: Vec<f32> = columns.clone().map(|u| (self.bright * fall(u, 0)) as f32).collect();
        for v in span(1, canvas.height) {
            let share = fall(v, 1) as f32;
            let row = &mut canvas.levels[v * canvas.width..][columns.clone()];
            row.iter_mut().zip(&across).for_each(|(level, bright)| *level += share * bright);
        }
    }
}
