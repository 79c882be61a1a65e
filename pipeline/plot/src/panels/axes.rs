//! Axes: curves, points, bands and text on two axes.

use crate::canvas::{Area, Canvas};
use crate::frame::{AxisRange, Frame};
use crate::mark::{Mark, Shape};
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::{Axis, PlotError, legend};

/// Where labelled marks are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Legend {
    /// In a corner where nothing is drawn, else over the frame.
    #[default]
    Free,
    /// Over the frame.
    Over,
    /// Nowhere.
    None,
}

/// Curves and points on two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The marks, the last one on top.
    pub marks: Vec<Mark>,
    /// Where labelled marks are listed.
    pub legend: Legend,
    /// The same scale on both axes (equal aspect ratio); the range of the shorter axis is widened.
    pub equal: bool,
}

/// Margin at both ends of an axis without a given range, as a fraction of the data's range.
const MARGIN: f64 = 0.05;

impl Axes {
    /// Empty axes.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self { x, y, marks: Vec::new(), legend: Legend::Free, equal: false }
    }

    /// The same axes with one more mark.
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// The same axes with their legend elsewhere.
    pub fn legend(self, legend: Legend) -> Self {
        Self { legend, ..self }
    }

    /// The same axes with equal aspect ratio.
    pub fn equal(self) -> Self {
        Self { equal: true, ..self }
    }

    /// The frame in a rectangle of the page.
    fn axes_frame(&self, area: Area) -> Result<Frame<'_>, PlotError> {
        // curves may begin and end at the frame; a marker there would be cut by it
        let has_markers = self.marks.iter().any(|m| matches!(m.shape, Shape::Points { .. }));
        let x_margin = if has_markers { MARGIN } else { 0.0 };
        let mut x = self.x.shown_ends(self.marks.iter().flat_map(Mark::all_x), x_margin)?;
        let mut y = self.y.shown_ends(self.marks.iter().flat_map(Mark::all_y), MARGIN)?;
        if self.equal {
            let (across, up) = ((x.1 - x.0) / area.width(), (y.1 - y.0) / area.height());
            x = widened_range(x, across, up);
            y = widened_range(y, up, across);
        }
        Ok(Frame::new(area, AxisRange { axis: &self.x, ends: x }, AxisRange { axis: &self.y, ends: y }))
    }

    fn painted_marks(&self, frame: &Frame) -> Canvas {
        let mut canvas = Canvas::default();
        self.marks.iter().for_each(|mark| frame.plot_area.draw_mark(&mut canvas, mark));
        canvas
    }

    fn listed_marks(&self) -> Vec<&Mark> {
        if self.legend == Legend::None { Vec::new() } else { legend::listed_marks(&self.marks) }
    }
}

/// Both ends moved outwards until a point of print shows `wanted` units instead of `now`.
fn widened_range((low, high): (f64, f64), now: f64, wanted: f64) -> (f64, f64) {
    let more = 0.5 * (high - low) * (wanted / now - 1.0).max(0.0);
    (low - more, high + more)
}

impl Draw for Axes {
    fn check_content(&self) -> Result<(), PlotError> {
        let frame = self.axes_frame(Area::new([0.0; 2], [100.0; 2]))?;
        self.marks.iter().try_for_each(|mark| frame.plot_area.check_mark(mark))
    }

    fn frame_margins(&self, cell: Area, legend: LegendPlacement) -> Result<Option<Margins>, PlotError> {
        // tick labels decide the margins, and the frame's size decides the ticks: two passes
        let first = self.axes_frame(cell)?.label_margins();
        let inner = Area {
            from: [cell.from[0] + first.left, cell.from[1]],
            to: [cell.to[0] - first.right, (cell.to[1] - first.bottom).max(cell.from[1] + 1.0)],
        };
        let mut margins = self.axes_frame(inner)?.label_margins();
        if legend == LegendPlacement::Over {
            margins.top += legend::height_over(&self.listed_marks(), inner.width());
        }
        Ok(Some(margins))
    }

    fn legend_fits(&self, frame: Area) -> Result<bool, PlotError> {
        let listed = self.listed_marks();
        let drawn = self.painted_marks(&self.axes_frame(frame)?);
        let fits = self.legend == Legend::Free && legend::free_place(&listed, frame, &drawn).is_some();
        Ok(listed.is_empty() || fits)
    }

    fn draw_panel(&self, canvas: &mut Canvas, area: Area, place: LegendPlacement) -> Result<(), PlotError> {
        let frame = self.axes_frame(area)?;
        frame.draw_grid(canvas);
        let drawn = self.painted_marks(&frame);
        let free = legend::free_place(&self.listed_marks(), area, &drawn);
        canvas.items.extend(drawn.items);
        frame.draw_frame(canvas);
        match (place, free) {
            (LegendPlacement::Over, _) => legend::draw_over(canvas, &self.listed_marks(), area),
            (LegendPlacement::Inside, Some(free)) => legend::draw_inside(canvas, &self.listed_marks(), free),
            (LegendPlacement::Inside, None) => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palette;

    const FRAME: Area = Area { from: [20.0, 10.0], to: [220.0, 110.0] };

    /// A curve that is different for each seed.
    fn curve(seed: u32) -> Mark {
        let phase = f64::from(seed) * 0.71;
        let y = |x: f64| (x + phase).sin() + 0.6 * (1.7 * x - 2.0 * phase).cos();
        let points = (0..=120).map(|i| f64::from(i) * 0.05).map(|x| [x, y(x)]).collect();
        Mark::line(points, palette::SIMULATED).labelled("simulated")
    }

    fn axes(seed: u32) -> Axes {
        let (x, y) = (Axis::linear("time", "s"), Axis::linear("tip", "mm"));
        Axes::new(x, y).with(curve(seed)).with(Mark::points(vec![[2.0, 0.1]], crate::Marker::Disc, palette::BLACK))
    }

    #[test]
    fn a_legend_inside_covers_no_data() {
        let mut inside = 0;
        for seed in 0..40 {
            let axes = axes(seed);
            let drawn = axes.painted_marks(&axes.axes_frame(FRAME).unwrap());
            if let Some(place) = legend::free_place(&axes.listed_marks(), FRAME, &drawn) {
                inside += 1;
                assert!(!drawn.touches_area(&place), "seed {seed}");
            }
        }
        assert!(inside > 10, "the seeds include free corners");
    }

    #[test]
    fn a_legend_without_a_free_corner_is_placed_over_the_frame() {
        let full = axes(0).with(Mark::span(0.0, 6.0, palette::BLACK));
        assert!(!full.legend_fits(FRAME).unwrap());
        let top = |place| full.frame_margins(FRAME, place).unwrap().unwrap().top;
        assert!(top(LegendPlacement::Over) > top(LegendPlacement::Inside) + 5.0);
    }

    #[test]
    fn equal_axes_show_a_circle_as_a_circle() {
        let circle = (0..=64).map(|i| f64::from(i) * 0.1).map(|a| [3.0 * a.cos(), 3.0 * a.sin()]).collect();
        let axes = Axes::new(Axis::linear("x", "mm"), Axis::linear("y", "mm"));
        let axes = axes.with(Mark::line(circle, palette::BODY)).equal();
        let plot_area = axes.axes_frame(FRAME).unwrap().plot_area;
        let across = plot_area.x.place_of(3.0) - plot_area.x.place_of(-3.0);
        let up = plot_area.y.place_of(-3.0) - plot_area.y.place_of(3.0);
        assert!((across - up).abs() < 1e-9);
    }

    #[test]
    fn text_near_the_frame_is_moved_inside() {
        let corner = Mark::text([6.0, 2.0], "a long remark", crate::Side::Right, palette::BLACK);
        let axes = Axes::new(Axis::linear("x", "").range(0.0, 6.0), Axis::linear("y", "").range(0.0, 2.0)).with(corner);
        let drawn = axes.painted_marks(&axes.axes_frame(FRAME).unwrap());
        let [crate::canvas::Item::Text(text)] = &drawn.items[..] else { panic!("one text is drawn") };
        assert!(FRAME.contains(text.text_area().from) && FRAME.contains(text.text_area().to));
    }

    #[test]
    fn the_ticks_that_decide_the_margins_are_those_of_the_frame_that_is_left() {
        // a frame so narrow that what its margins leave has other ticks than the whole cell
        let axes = Axes::new(Axis::linear("x", "").range(0.0, 1.0), Axis::linear("y", "").range(0.0, 1000.0));
        for width in [60.0, 75.0, 90.0, 120.0] {
            let cell = Area::new([5.0, 5.0], [width, 60.0]);
            let first = axes.axes_frame(cell).unwrap().label_margins();
            let left = Area {
                from: [cell.from[0] + first.left, cell.from[1]],
                to: [cell.to[0] - first.right, cell.to[1] - first.bottom],
            };
            let margins = axes.frame_margins(cell, LegendPlacement::Inside).unwrap().unwrap();
            assert_eq!(margins.left, axes.axes_frame(left).unwrap().label_margins().left);
            assert_eq!(margins.right, axes.axes_frame(left).unwrap().label_margins().right);
        }
    }
}
