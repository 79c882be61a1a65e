//! Colour bars: the scale of the colours of a heat map or of a painted mesh.

use crate::axis::{Axis, Scale};
use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::frame::{NORMAL, SMALL, vertical_ticks, widest_label};
use crate::raster::Raster;
use crate::ruler::Ruler;
use crate::{Colour, PlotError, Side, palette};

/// The scale of the colours: an axis whose length and place follow from its frame.
pub type ColourBar = Axis;

/// Between the frame and its bar.
const AWAY: f64 = 6.0;
/// Width of the bar.
const WIDE: f64 = 6.5;
/// Length of a tick and of the gaps around tick labels.
const GAP: f64 = 2.0;
/// Pixels of the bar's picture; 256 levels are enough for a linear interpolation between 9 colours.
const PIXELS: usize = 256;

/// A colour bar with its ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bar<'a> {
    axis: &'a ColourBar,
    ends: (f64, f64),
}

impl<'a> Bar<'a> {
    /// A bar whose range holds these values; values that are not finite are ignored.
    pub fn new(axis: &'a ColourBar, values: impl Iterator<Item = f64>) -> Result<Self, PlotError> {
        Ok(Self { axis, ends: axis.shown_ends(values.filter(|v| v.is_finite()), 0.0)? })
    }

    /// The fraction of the range at a value, 0 to 1 inside.
    pub(crate) fn fraction_of(&self, value: f64) -> f64 {
        Ruler { scale: self.axis.scale, ends: self.ends, places: (0.0, 1.0) }.place_of(value)
    }

    /// The colour of a value; grey for a missing one.
    pub(crate) fn colour_of(&self, value: f64) -> Colour {
        match self.axis.scale {
            _ if !value.is_finite() => palette::MISSING,
            Scale::Log if value <= 0.0 => palette::heat(0.0),
            _ => palette::heat(self.fraction_of(value)),
        }
    }

    /// Levels of contours: the tick values of a bar of this height.
    pub(crate) fn contour_levels(&self, height: f64) -> Vec<f64> {
        vertical_ticks(&self.bar_ruler(height, 0.0)).major.into_iter().map(|(value, _)| value).collect()
    }

    fn bar_ruler(&self, from: f64, to: f64) -> Ruler {
        Ruler { scale: self.axis.scale, ends: self.ends, places: (from, to) }
    }

    /// The width that the bar takes to the right of a frame of this height.
    pub(crate) fn total_width(&self, height: f64) -> f64 {
        let numbers = widest_label(&vertical_ticks(&self.bar_ruler(height, 0.0)));
        AWAY + WIDE + GAP + GAP + numbers + GAP + NORMAL
    }

    /// Draws the bar to the right of a frame.
    pub(crate) fn draw_bar(&self, canvas: &mut Canvas, frame: Area) -> Result<(), PlotError> {
        let area = Area { from: [frame.to[0] + AWAY, frame.from[1]], to: [frame.to[0] + AWAY + WIDE, frame.to[1]] };
        let pixels = (0..PIXELS).map(|i| palette::heat(1.0 - i as f64 / (PIXELS - 1) as f64));
        let pixels = pixels.flat_map(|c| [c.0, c.1, c.2, 255]).collect();
        canvas.items.push(Item::Picture { area, png: Raster { width: 1, height: PIXELS, pixels }.to_png()? });
        canvas.draw_outline(area, 0.5, palette::BLACK);
        let ticks = vertical_ticks(&self.bar_ruler(area.to[1], area.from[1]));
        for (value, text) in &ticks.major {
            let y = self.bar_ruler(area.to[1], area.from[1]).place_of(*value);
            canvas.draw_segment([area.to[0], y], [area.to[0] + GAP, y], 0.5, palette::BLACK);
            canvas.draw_text(TextItem::new([area.to[0] + 2.0 * GAP, y], text, SMALL).side(Side::Right));
        }
        let x = area.to[0] + 3.0 * GAP + widest_label(&ticks) + 0.5 * NORMAL;
        canvas.draw_text(TextItem::new([x, area.centre()[1]], &self.axis.full_title(), NORMAL).vertical());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_bar_have_the_ends_of_the_map() {
        let axis = ColourBar::log("loss", "");
        let bar = Bar::new(&axis, [1e-3, f64::INFINITY, 1e-1].into_iter()).unwrap();
        assert_eq!(bar.colour_of(1e-3), palette::heat(0.0));
        assert_eq!(bar.colour_of(1e-1), palette::heat(1.0));
        assert_eq!(bar.colour_of(f64::INFINITY), palette::MISSING);
    }

    #[test]
    fn a_bar_is_drawn_within_the_width_that_it_takes() {
        let axis = ColourBar::linear("load", "N");
        let bar = Bar::new(&axis, [0.0, 12_345.0].into_iter()).unwrap();
        let frame = Area { from: [0.0, 0.0], to: [100.0, 120.0] };
        let mut canvas = Canvas::default();
        bar.draw_bar(&mut canvas, frame).unwrap();
        let end = 100.0 + bar.total_width(120.0);
        assert!(!canvas.touches_area(&Area { from: [end + 0.5, -50.0], to: [end + 500.0, 200.0] }));
        assert!(canvas.touches_area(&Area { from: [end - NORMAL, -50.0], to: [end, 200.0] }));
    }
}
