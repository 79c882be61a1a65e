//! Frames: the box of a panel with its grid lines, ticks, tick labels and axis labels.

use crate::canvas::{Area, Canvas, TextItem};
use crate::mark_painter::PlotArea;
use crate::panel::Margins;
use crate::ruler::{Ruler, Ticks};
use crate::{Axis, Side, palette, text};

/// Font size of tick labels and legends.
pub const SMALL: f64 = 6.5;
/// Font size of axis labels.
pub(crate) const NORMAL: f64 = 7.0;
/// Width of the box.
const BOX_LINE: f64 = 0.6;
/// Width of grid lines.
const GRID_LINE: f64 = 0.4;
/// Length of a tick.
const TICK: f64 = 2.2;
/// Between a tick and its label, and between tick labels and axis label.
const GAP: f64 = 2.2;
/// Least gap between two tick labels of the horizontal axis.
const APART_X: f64 = 10.0;
/// Least distance of tick labels on the vertical axis.
const APART_Y: f64 = 14.0;

/// An axis with the range that it shows.
pub struct AxisRange<'a> {
    /// The axis.
    pub axis: &'a Axis,
    /// Its lower and upper end.
    pub ends: (f64, f64),
}

/// A frame: the plot area with its two axes.
pub struct Frame<'a> {
    /// Where marks are drawn.
    pub plot_area: PlotArea,
    /// Horizontal axis.
    pub x: &'a Axis,
    /// Vertical axis.
    pub y: &'a Axis,
}

impl<'a> Frame<'a> {
    /// A frame around a rectangle with the ranges of both axes.
    pub fn new(frame: Area, x: AxisRange<'a>, y: AxisRange<'a>) -> Self {
        let horizontal = Ruler { scale: x.axis.scale, ends: x.ends, places: (frame.from[0], frame.to[0]) };
        let vertical = Ruler { scale: y.axis.scale, ends: y.ends, places: (frame.to[1], frame.from[1]) };
        Self { plot_area: PlotArea { x: horizontal, y: vertical, frame }, x: x.axis, y: y.axis }
    }

    /// The margins for tick labels and axis labels.
    pub(crate) fn label_margins(&self) -> Margins {
        let (horizontal, vertical) = (self.x_ticks(), vertical_ticks(&self.plot_area.y));
        let last = horizontal.major.last().map_or(0.0, |(value, text)| {
            0.5 * text::width(text, SMALL) - (self.plot_area.frame.to[0] - self.plot_area.x.place_of(*value))
        });
        let numbers = if self.y.tick_labels { GAP + widest_label(&vertical) + GAP + NORMAL } else { 0.0 };
        let below = if self.x.tick_labels { GAP + SMALL + GAP + NORMAL } else { 0.0 };
        let right = if self.x.tick_labels { last.max(0.0) + 1.0 } else { 1.0 };
        Margins { left: TICK + numbers, right, top: 0.5 * SMALL, bottom: TICK + below, beyond: 0.0 }
    }

    /// Ticks of the horizontal axis, as many as fit without an overlap of their labels.
    fn x_ticks(&self) -> Ticks {
        // the width of a label depends on the digits, hence on the number of ticks: a first guess gives the width
        let first = self.plot_area.x.ticks(APART_X + 12.0);
        self.plot_area.x.ticks(APART_X + widest_label(&first))
    }

    /// Grid lines at the major ticks, under everything else.
    pub(crate) fn draw_grid(&self, canvas: &mut Canvas) {
        let Area { from, to } = self.plot_area.frame;
        for (value, _) in self.x_ticks().major {
            let x = self.plot_area.x.place_of(value);
            canvas.draw_segment([x, from[1]], [x, to[1]], GRID_LINE, palette::FAINT);
        }
        for (value, _) in vertical_ticks(&self.plot_area.y).major {
            let y = self.plot_area.y.place_of(value);
            canvas.draw_segment([from[0], y], [to[0], y], GRID_LINE, palette::FAINT);
        }
    }

    /// Box, ticks and labels, over everything else.
    pub fn draw_frame(&self, canvas: &mut Canvas) {
        let Area { from, to } = self.plot_area.frame;
        canvas.draw_outline(self.plot_area.frame, BOX_LINE, palette::BLACK);
        self.draw_x(canvas, to[1]);
        self.draw_y(canvas, from[0]);
    }

    fn draw_x(&self, canvas: &mut Canvas, base: f64) {
        let ticks = self.x_ticks();
        for value in &ticks.minor {
            let x = self.plot_area.x.place_of(*value);
            canvas.draw_segment([x, base], [x, base + 0.6 * TICK], GRID_LINE, palette::BLACK);
        }
        for (value, text) in &ticks.major {
            let x = self.plot_area.x.place_of(*value);
            canvas.draw_segment([x, base], [x, base + TICK], BOX_LINE, palette::BLACK);
            if self.x.tick_labels {
                canvas.draw_text(TextItem::new([x, base + TICK + GAP + 0.4 * SMALL], text, SMALL));
            }
        }
        if self.x.tick_labels {
            let below = base + TICK + GAP + SMALL + GAP + 0.4 * NORMAL;
            let position = [self.plot_area.frame.centre()[0], below];
            canvas.draw_text(TextItem::new(position, &self.x.full_title(), NORMAL));
        }
    }

    fn draw_y(&self, canvas: &mut Canvas, base: f64) {
        let ticks = vertical_ticks(&self.plot_area.y);
        for value in &ticks.minor {
            let y = self.plot_area.y.place_of(*value);
            canvas.draw_segment([base - 0.6 * TICK, y], [base, y], GRID_LINE, palette::BLACK);
        }
        for (value, text) in &ticks.major {
            let y = self.plot_area.y.place_of(*value);
            canvas.draw_segment([base - TICK, y], [base, y], BOX_LINE, palette::BLACK);
            if self.y.tick_labels {
                canvas.draw_text(TextItem::new([base - TICK - GAP, y], text, SMALL).side(Side::Left));
            }
        }
        if self.y.tick_labels {
            let x = base - TICK - GAP - widest_label(&ticks) - GAP - 0.6 * NORMAL;
            canvas.draw_text(
                TextItem::new([x, self.plot_area.frame.centre()[1]], &self.y.full_title(), NORMAL).vertical(),
            );
        }
    }
}

/// Ticks of a vertical axis.
pub(crate) fn vertical_ticks(ruler: &Ruler) -> Ticks {
    ruler.ticks(APART_Y)
}

/// Width of the widest tick label.
pub(crate) fn widest_label(ticks: &Ticks) -> f64 {
    ticks.major.iter().map(|(_, t)| text::width(t, SMALL)).fold(0.0, f64::max)
}
