//! The backdrop: the fixed objects below and beside the tail.
//!
//! A dark plate with a white grid, the unlit lamp and the label "virtual bench"; over the head of the tail, the holder's block and its two
//! rods. In water all of it is refracted at the surface at rest, so that it is drawn once a recording.

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
/// The lit lamp stays below saturation, so that a partial exposure can be measured.
const LIT_LAMP: f32 = 232.0;

/// Extent of the grid in the CAD frame, m, x and y.
const REACH: [[Metre; 2]; 2] = [[-0.11, 0.26], [-0.14, 0.14]];
/// Points along each side of a grid line, so that lens distortion bends it.
const BENDS: usize = 60;
/// Corners of a disc.
const CORNERS: usize = 48;

/// The fixed objects below the tail.
pub(crate) fn draw_backdrop(view: &View, plane: &settings::Plane, lamp: &settings::Lamp) -> Canvas {
    let mut canvas = Canvas::filled(view.camera.width, view.camera.height, PLATE);
    for (axis, reach) in REACH.iter().enumerate() {
        let [low, high] = reach.map(|end| (end / plane.pitch).round() as i32);
        for i in low..=high {
            grid_line(&mut canvas, view, plane, &GridLine { axis, place: f64::from(i) * plane.pitch });
        }
    }
    fill_polygon(&mut canvas, view, &flat_disc(lamp.at, 1.5 * lamp.radius, CORNERS), BEZEL);
    fill_polygon(&mut canvas, view, &flat_disc(lamp.at, lamp.radius, CORNERS), DARK_LAMP);
    draw_label(&mut canvas, view.camera.height as f64);
    canvas
}

/// The label at the bottom left.
fn draw_label(canvas: &mut Canvas, height: f64) {
    let (left, right, top, bottom) = (14.0, 244.0, height - 44.0, height - 8.0);
    canvas.fill_polygon(&[[left, top], [right, top], [right, bottom], [left, bottom]], BLOCK);
    let style = letters::Style { at: [24.0, height - 34.0], size: 16.0, level: WORDS };
    letters::write_text(canvas, &lab::VIRTUAL_BENCH.to_uppercase(), &style);
}

/// The lamp at a `brightness` of 0 to 1.
pub(crate) fn draw_lamp(canvas: &mut Canvas, view: &View, lamp: &settings::Lamp, brightness: f64) {
    let level = DARK_LAMP + (LIT_LAMP - DARK_LAMP) * brightness as f32;
    fill_polygon(canvas, view, &flat_disc(lamp.at, lamp.radius, CORNERS), level);
}

/// The holder: a block that clamps the head up to x = `edge` (m), and its two rods.
pub(crate) fn draw_holder(canvas: &mut Canvas, view: &View, edge: Metre) {
    for y in [-0.011, 0.011] {
        fill_polygon(canvas, view, &rectangle_at([-0.12, y - 0.004], [-0.02, y + 0.004], 0.020), ROD);
        fill_polygon(canvas, view, &rectangle_at([-0.12, y - 0.001], [-0.02, y + 0.0015], 0.024), 1.5 * ROD);
    }
    fill_polygon(canvas, view, &rectangle_at([-0.030, -0.024], [edge, 0.024], 0.0255), BLOCK);
    fill_polygon(canvas, view, &rectangle_at([-0.026, -0.020], [edge - 0.004, 0.020], 0.0265), 1.5 * BLOCK);
}

/// A horizontal rectangle from `low` to `high` (m, x and y) at height `z`.
fn rectangle_at(low: [Metre; 2], high: [Metre; 2], z: Metre) -> [Point3; 4] {
    [[low[0], low[1], z], [high[0], low[1], z], [high[0], high[1], z], [low[0], high[1], z]]
}

/// Fills a fixed polygon (m); nothing if a corner has no pixel.
fn fill_polygon(canvas: &mut Canvas, view: &View, polygon: &[Point3], level: f32) {
    if let Some(outline) = view.outline(polygon) {
        canvas.fill_polygon(&outline, level);
    }
}

/// The grid line at `place` (m) on `axis`.
struct GridLine {
    axis: usize,
    place: Metre,
}

/// Draws the visible part of a grid line.
fn grid_line(canvas: &mut Canvas, view: &View, plane: &settings::Plane, line: &GridLine) {
    let GridLine { axis, place } = *line;
    let [from, to] = REACH[1 - axis];
    let point_on_edge = |i: usize, side: f64| -> Point3 {
        let lengthwise = from + (to - from) * i as f64 / BENDS as f64;
        let crosswise = place + 0.5 * side * plane.line;
        if axis == 0 { [crosswise, lengthwise, plane.height] } else { [lengthwise, crosswise, plane.height] }
    };
    let visible = |i: &usize| view.project_static(point_on_edge(*i, 0.0)).is_some();
    let visible_bends: Vec<usize> = (0..=BENDS).filter(visible).collect();
    let first_edge = visible_bends.iter().map(|i| point_on_edge(*i, -1.0));
    let corners: Vec<Point3> = first_edge.chain(visible_bends.iter().rev().map(|i| point_on_edge(*i, 1.0))).collect();
    fill_polygon(canvas, view, &corners, LINE);
}
