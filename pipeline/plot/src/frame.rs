//! Frames: the box of a panel with its grid, ticks, numbers and axis labels.
//!
//! Stands on: `axis`, `ruler`, `canvas`, `text`. Never knows: what is drawn inside.

use crate::canvas::{Area, Canvas, Item, Words};
use crate::mark_ink::Ground;
use crate::panel::Margins;
use crate::ruler::{Ruler, Ticks};
use crate::{Axis, Side, palette, text};

/// Size of the numbers beside an axis and of legends.
pub const SMALL: f64 = 6.5;
/// Size of axis labels.
pub const NORMAL: f64 = 7.0;
/// Width of the box.
const BOX_LINE: f64 = 0.6;
/// Width of grid lines.
const GRID_LINE: f64 = 0.4;
/// Length of a tick.
const TICK: f64 = 2.2;
/// Between a tick and its number, and between numbers and label.
const GAP: f64 = 2.2;
/// Least room for one number on a lying axis beside its own width.
const APART_X: f64 = 10.0;
/// Least distance of numbers on a standing axis.
const APART_Y: f64 = 14.0;

/// A frame: the ground with its two axes.
pub struct Frame<'a> {
    /// Where marks are drawn.
    pub ground: Ground,
    /// Along.
    pub x: &'a Axis,
    /// Up.
    pub y: &'a Axis,
}

impl<'a> Frame<'a> {
    /// A frame with both axes' ends.
    pub fn new(frame: Area, x: &'a Axis, x_ends: (f64, f64), y: &'a Axis, y_ends: (f64, f64)) -> Self {
        let across = Ruler { scale: x.scale, ends: x_ends, places: (frame.from[0], frame.to[0]) };
        let up = Ruler { scale: y.scale, ends: y_ends, places: (frame.to[1], frame.from[1]) };
        Self { ground: Ground { x: across, y: up, frame }, x, y }
    }

    /// The room that numbers and labels need around it.
    pub fn margins(&self) -> Margins {
        let (across, up) = (self.x_ticks(), standing_ticks(&self.ground.y));
        let last = across.major.last().map_or(0.0, |(value, text)| {
            0.5 * text::width(text, SMALL) - (self.ground.frame.to[0] - self.ground.x.place(*value))
        });
        let numbers = if self.y.written { GAP + widest(&up) + GAP + NORMAL } else { 0.0 };
        let below = if self.x.written { GAP + SMALL + GAP + NORMAL } else { 0.0 };
        let right = if self.x.written { last.max(0.0) + 1.0 } else { 1.0 };
        Margins { left: TICK + numbers, right, top: 0.5 * SMALL, bottom: TICK + below, beyond: 0.0 }
    }

    /// Ticks of the lying axis, as many as its own numbers leave room for.
    fn x_ticks(&self) -> Ticks {
        let first = self.ground.x.ticks(APART_X + 12.0);
        self.ground.x.ticks(APART_X + widest(&first))
    }

    /// Light lines at the numbers, under everything else.
    pub fn draw_grid(&self, canvas: &mut Canvas) {
        let Area { from, to } = self.ground.frame;
        for (value, _) in self.x_ticks().major {
            let x = self.ground.x.place(value);
            canvas.segment([x, from[1]], [x, to[1]], GRID_LINE, palette::FAINT);
        }
        for (value, _) in standing_ticks(&self.ground.y).major {
            let y = self.ground.y.place(value);
            canvas.segment([from[0], y], [to[0], y], GRID_LINE, palette::FAINT);
        }
    }

    /// Box, ticks, numbers and labels, over everything else.
    pub fn draw(&self, canvas: &mut Canvas) {
        let Area { from, to } = self.ground.frame;
        canvas.outline(self.ground.frame, BOX_LINE, palette::INK);
        self.draw_x(canvas, to[1]);
        self.draw_y(canvas, from[0]);
    }

    fn draw_x(&self, canvas: &mut Canvas, base: f64) {
        let ticks = self.x_ticks();
        for value in &ticks.minor {
            let x = self.ground.x.place(*value);
            canvas.segment([x, base], [x, base + 0.6 * TICK], GRID_LINE, palette::INK);
        }
        for (value, text) in &ticks.major {
            let x = self.ground.x.place(*value);
            canvas.segment([x, base], [x, base + TICK], BOX_LINE, palette::INK);
            if self.x.written {
                canvas.words([x, base + TICK + GAP + 0.4 * SMALL], text, SMALL, Side::Centre, palette::INK);
            }
        }
        if self.x.written {
            let below = base + TICK + GAP + SMALL + GAP + 0.4 * NORMAL;
            let at = [self.ground.frame.centre()[0], below];
            canvas.words(at, &self.x.title(), NORMAL, Side::Centre, palette::INK);
        }
    }

    fn draw_y(&self, canvas: &mut Canvas, base: f64) {
        let ticks = standing_ticks(&self.ground.y);
        for value in &ticks.minor {
            let y = self.ground.y.place(*value);
            canvas.segment([base - 0.6 * TICK, y], [base, y], GRID_LINE, palette::INK);
        }
        for (value, text) in &ticks.major {
            let y = self.ground.y.place(*value);
            canvas.segment([base - TICK, y], [base, y], BOX_LINE, palette::INK);
            if self.y.written {
                canvas.words([base - TICK - GAP, y], text, SMALL, Side::Left, palette::INK);
            }
        }
        if self.y.written {
            let x = base - TICK - GAP - widest(&ticks) - GAP - 0.6 * NORMAL;
            canvas.items.push(Item::Text(upright([x, self.ground.frame.centre()[1]], &self.y.title())));
        }
    }
}

/// A label that is read from below, centred at a point.
pub fn upright(at: si::Point2, text: &str) -> Words {
    let (text, side) = (text.to_owned(), Side::Centre);
    Words { at, text, size: NORMAL, side, upright: true, bold: false, colour: palette::INK }
}

/// Ticks of a standing axis.
pub fn standing_ticks(ruler: &Ruler) -> Ticks {
    ruler.ticks(APART_Y)
}

/// Width of the widest number.
pub fn widest(ticks: &Ticks) -> f64 {
    ticks.major.iter().map(|(_, t)| text::width(t, SMALL)).fold(0.0, f64::max)
}
