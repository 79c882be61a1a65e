//! Colour bars: what the colours of a heat map or of a painted mesh mean.
//!
//! Stands on: `ruler`, `frame`, the palette. Never knows: what is painted.

use crate::axis::{Axis, Scale};
use crate::canvas::{Area, Canvas, Item};
use crate::frame::{NORMAL, SMALL, standing_ticks, upright, widest};
use crate::raster::Raster;
use crate::ruler::Ruler;
use crate::{Colour, PlotError, Side, palette};

/// What colours mean: an axis without a place of its own.
pub type ColourBar = Axis;

/// Between the frame and its bar.
const AWAY: f64 = 6.0;
/// Width of the bar.
const WIDE: f64 = 6.5;
/// Length of a tick and of the gaps around numbers.
const GAP: f64 = 2.0;
/// Dots of the bar's picture; a map of 9 colours between which is mixed needs no more.
const DOTS: usize = 256;

/// A colour bar with its ends.
#[derive(Debug, Clone, Copy)]
pub struct Bar<'a> {
    axis: &'a ColourBar,
    ends: (f64, f64),
}

impl<'a> Bar<'a> {
    /// A bar that holds these values (those that are not finite are passed over).
    pub fn new(axis: &'a ColourBar, values: impl Iterator<Item = f64>) -> Result<Self, PlotError> {
        Ok(Self { axis, ends: axis.ends(values.filter(|v| v.is_finite()), 0.0)? })
    }

    /// Where a value lies between the ends, 0 to 1 inside.
    pub fn part(&self, value: f64) -> f64 {
        Ruler { scale: self.axis.scale, ends: self.ends, places: (0.0, 1.0) }.place(value)
    }

    /// The colour of a value; grey where there is none.
    pub fn colour(&self, value: f64) -> Colour {
        match self.axis.scale {
            _ if !value.is_finite() => palette::MISSING,
            Scale::Log if value <= 0.0 => palette::heat(0.0),
            _ => palette::heat(self.part(value)),
        }
    }

    /// Round values for contours, as many as a bar of this height has numbers.
    pub fn levels(&self, height: f64) -> Vec<f64> {
        standing_ticks(&self.ruler(height, 0.0)).major.into_iter().map(|(value, _)| value).collect()
    }

    fn ruler(&self, from: f64, to: f64) -> Ruler {
        Ruler { scale: self.axis.scale, ends: self.ends, places: (from, to) }
    }

    /// The room that the bar takes to the right of a frame of this height.
    pub fn width(&self, height: f64) -> f64 {
        let numbers = widest(&standing_ticks(&self.ruler(height, 0.0)));
        AWAY + WIDE + GAP + GAP + numbers + GAP + NORMAL
    }

    /// Draws the bar to the right of a frame.
    pub fn draw(&self, canvas: &mut Canvas, frame: Area) -> Result<(), PlotError> {
        let area = Area { from: [frame.to[0] + AWAY, frame.from[1]], to: [frame.to[0] + AWAY + WIDE, frame.to[1]] };
        let dots = (0..DOTS).map(|i| palette::heat(1.0 - i as f64 / (DOTS - 1) as f64));
        let dots = dots.flat_map(|c| [c.0, c.1, c.2, 255]).collect();
        canvas.items.push(Item::Picture { area, png: Raster { width: 1, height: DOTS, dots }.png()? });
        canvas.outline(area, 0.5, palette::INK);
        let ticks = standing_ticks(&self.ruler(area.to[1], area.from[1]));
        for (value, text) in &ticks.major {
            let y = self.ruler(area.to[1], area.from[1]).place(*value);
            canvas.segment([area.to[0], y], [area.to[0] + GAP, y], 0.5, palette::INK);
            canvas.words([area.to[0] + 2.0 * GAP, y], text, SMALL, Side::Right, palette::INK);
        }
        let x = area.to[0] + 3.0 * GAP + widest(&ticks) + 0.5 * NORMAL;
        canvas.items.push(Item::Text(upright([x, area.centre()[1]], &self.axis.title())));
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
        assert_eq!(bar.colour(1e-3), palette::heat(0.0));
        assert_eq!(bar.colour(1e-1), palette::heat(1.0));
        assert_eq!(bar.colour(f64::INFINITY), palette::MISSING);
    }
}
