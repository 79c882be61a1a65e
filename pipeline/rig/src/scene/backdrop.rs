//! The backdrop: what stands still under and beside the tail.
//!
//! A dark plate with a white grid, the unlit lamp, and the words that say who recorded it; over the tail's head, the
//! holder's block and its two rods.
//!
//! Under water all of it is seen through the surface at rest: what does not move is drawn once.
//!
//! Stands on: the canvas and the camera. Never knows: the tail.

use si::{Metre, Point3};

use super::{Canvas, letters};
use crate::camera::{View, flat_disc};
use crate::settings;

/// Grey levels, 0 to 255, before uneven light and noise.
const PLATE: f32 = 46.0;
const LINE: f32 = 176.0;
const BLOCK: f32 = 26.0;
const ROD: f32 = 118.0;
const DARK_LAMP: f32 = 60.0;
const BEZEL: f32 = 20.0;
const WORDS: f32 = 150.0;
/// A lit lamp stays under the sensor's white, so that a part of an exposure can be read from it.
const LIT_LAMP: f32 = 232.0;

/// The grid reaches this far from the CAD frame's origin, m, x and y.
const REACH: [[Metre; 2]; 2] = [[-0.11, 0.26], [-0.14, 0.14]];
/// Corners of a grid line on each side, so that the lens may bend it.
const BENDS: usize = 60;

/// Everything that stands still and lies under the tail.
pub fn draw(view: &View, plane: &settings::Plane, lamp: &settings::Lamp) -> Canvas {
    let mut canvas = Canvas::filled(view.camera.width, view.camera.height, PLATE);
    for (axis, reach) in REACH.iter().enumerate() {
        let [low, high] = reach.map(|end| (end / plane.pitch).round() as i32);
        for i in low..=high {
            line(&mut canvas, view, plane, axis, f64::from(i) * plane.pitch);
        }
    }
    disc(&mut canvas, view, lamp, 1.5, BEZEL);
    disc(&mut canvas, view, lamp, 1.0, DARK_LAMP);
    sign(&mut canvas, view.camera.height as f64);
    canvas
}

/// A label at the bottom left that says who recorded it.
fn sign(canvas: &mut Canvas, height: f64) {
    let (left, right, top, bottom) = (14.0, 244.0, height - 44.0, height - 8.0);
    canvas.fill(&[[left, top], [right, top], [right, bottom], [left, bottom]], BLOCK);
    letters::write(canvas, &lab::VIRTUAL_BENCH.to_uppercase(), [24.0, height - 34.0], 16.0, WORDS);
}

/// The lamp at `share` (0 to 1) of its full light.
pub fn light(canvas: &mut Canvas, view: &View, lamp: &settings::Lamp, share: f64) {
    disc(canvas, view, lamp, 1.0, DARK_LAMP + (LIT_LAMP - DARK_LAMP) * share as f32);
}

/// The holder: a block that grips the head as far as `edge` (m), and the two rods that carry it.
pub fn holder(canvas: &mut Canvas, view: &View, edge: Metre) {
    for y in [-0.011, 0.011] {
        slab(canvas, view, [-0.12, y - 0.004], [-0.02, y + 0.004], 0.020, ROD);
        slab(canvas, view, [-0.12, y - 0.001], [-0.02, y + 0.0015], 0.024, 1.5 * ROD);
    }
    slab(canvas, view, [-0.030, -0.024], [edge, 0.024], 0.0255, BLOCK);
    slab(canvas, view, [-0.026, -0.020], [edge - 0.004, 0.020], 0.0265, 1.5 * BLOCK);
}

/// A flat rectangle from `low` to `high` (m, x and y) at height `z`.
fn slab(canvas: &mut Canvas, view: &View, low: [Metre; 2], high: [Metre; 2], z: Metre, level: f32) {
    let corners = [[low[0], low[1], z], [high[0], low[1], z], [high[0], high[1], z], [low[0], high[1], z]];
    if let Some(outline) = view.outline(&corners) {
        canvas.fill(&outline, level);
    }
}

/// The grid line at `place` (m) across `axis`, as long as the picture shows it.
fn line(canvas: &mut Canvas, view: &View, plane: &settings::Plane, axis: usize, place: Metre) {
    let [from, to] = REACH[1 - axis];
    let at = |i: usize, side: f64| -> Point3 {
        let along = from + (to - from) * i as f64 / BENDS as f64;
        let across = place + 0.5 * side * plane.line;
        if axis == 0 { [across, along, plane.height] } else { [along, across, plane.height] }
    };
    let seen = |i: &usize| view.still(at(*i, 0.0)).is_some();
    let shown: Vec<usize> = (0..=BENDS).filter(seen).collect();
    let there = shown.iter().map(|i| at(*i, -1.0));
    let corners: Vec<Point3> = there.chain(shown.iter().rev().map(|i| at(*i, 1.0))).collect();
    if let Some(outline) = view.outline(&corners) {
        canvas.fill(&outline, LINE);
    }
}

fn disc(canvas: &mut Canvas, view: &View, lamp: &settings::Lamp, size: f64, level: f32) {
    if let Some(outline) = view.outline(&flat_disc(lamp.at, size * lamp.radius, 48)) {
        canvas.fill(&outline, level);
    }
}
