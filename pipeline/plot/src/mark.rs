//! Marks: lines, points, bands and text in the units of the axes.

use si::Point2;

use crate::{Colour, PlotError};

/// The dash pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// A continuous line.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
}

/// The symbol at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A filled disc.
    Disc,
    /// An empty circle.
    Ring,
    /// A filled square.
    Square,
    /// A filled triangle, point up.
    Triangle,
    /// A diagonal cross: ×.
    Cross,
    /// An upright cross: +.
    Plus,
}

/// On which side of its point a text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Above it, centred.
    Above,
    /// Below it, centred.
    Below,
    /// Ends before it.
    Left,
    /// Begins after it.
    Right,
    /// Centred at it.
    Centre,
}

/// The geometry of a mark.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A line through points.
    Line(Vec<Point2>),
    /// Markers at points, each with the half length of its vertical error bar.
    Points {
        /// The points.
        at: Vec<Point2>,
        /// Their symbol.
        marker: Marker,
        /// Half lengths of the error bars, one a point.
        error_bars: Option<Vec<f64>>,
    },
    /// The area between two curves over the same x.
    Band {
        /// Along the x axis.
        x: Vec<f64>,
        /// Lower curve.
        low: Vec<f64>,
        /// Upper curve.
        high: Vec<f64>,
    },
    /// A filled polygon.
    Area(Vec<Point2>),
    /// Text beside a point.
    Text {
        /// The point.
        at: Point2,
        /// The words.
        text: String,
        /// Where they stand.
        side: Side,
    },
    /// A horizontal line over the whole width, at y.
    HorizontalLine(f64),
    /// A vertical line over the whole height, at x.
    VerticalLine(f64),
    /// The whole height between two values of x.
    Span(f64, f64),
}

/// Something drawn on axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Its geometry.
    pub shape: Shape,
    /// Its colour.
    pub colour: Colour,
    /// Its entry in the legend; none: it is not listed.
    pub label: Option<String>,
    /// The dash pattern of its lines.
    pub dash: Dash,
    /// Width of lines, or diameter of markers, in points of print.
    pub size: f64,
    /// Opacity, 0 (invisible) to 1.
    pub opacity: f64,
}

impl Mark {
    fn new(shape: Shape, colour: Colour, size: f64, opacity: f64) -> Self {
        Self { shape, colour, label: None, dash: Dash::Solid, size, opacity }
    }

    /// A line.
    pub fn line(points: Vec<Point2>, colour: Colour) -> Self {
        Self::new(Shape::Line(points), colour, 1.0, 1.0)
    }

    /// Markers.
    pub fn points(at: Vec<Point2>, marker: Marker, colour: Colour) -> Self {
        Self::new(Shape::Points { at, marker, error_bars: None }, colour, 3.4, 1.0)
    }

    /// A large cross ×, for the best point.
    pub fn cross(at: Point2, colour: Colour) -> Self {
        Self::points(vec![at], Marker::Cross, colour).sized(6.5)
    }

    /// The area between two curves.
    pub fn band(x: Vec<f64>, low: Vec<f64>, high: Vec<f64>, colour: Colour) -> Self {
        Self::new(Shape::Band { x, low, high }, colour, 0.0, 0.28)
    }

    /// A filled polygon.
    pub fn area(points: Vec<Point2>, colour: Colour) -> Self {
        Self::new(Shape::Area(points), colour, 0.0, 1.0)
    }

    /// Text beside a point.
    pub fn text(at: Point2, text: &str, side: Side, colour: Colour) -> Self {
        Self::new(Shape::Text { at, text: text.to_owned(), side }, colour, 7.0, 1.0)
    }

    /// A horizontal line over the whole width.
    pub fn horizontal_line(y: f64, colour: Colour) -> Self {
        Self::new(Shape::HorizontalLine(y), colour, 0.7, 1.0)
    }

    /// A vertical line over the whole height.
    pub fn vertical_line(x: f64, colour: Colour) -> Self {
        Self::new(Shape::VerticalLine(x), colour, 0.7, 1.0)
    }

    /// The whole height between two values of x, such as a time window.
    pub fn span(from: f64, to: f64, colour: Colour) -> Self {
        Self::new(Shape::Span(from, to), colour, 0.0, 0.14)
    }

    /// The same mark, listed in the legend.
    pub fn labelled(self, label: &str) -> Self {
        Self { label: Some(label.to_owned()), ..self }
    }

    /// The same mark with a dash pattern.
    pub fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// The same mark with another line width, marker diameter or text size, in points of print.
    pub fn sized(self, size: f64) -> Self {
        Self { size, ..self }
    }

    /// The same mark with an opacity.
    pub fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The same markers with vertical error bars (half lengths, one for each point).
    pub fn with_error_bars(mut self, halves: Vec<f64>) -> Self {
        if let Shape::Points { error_bars, .. } = &mut self.shape {
            *error_bars = Some(halves);
        }
        self
    }

    /// Every x that the axis must hold.
    pub(crate) fn all_x(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Line(points) | Shape::Area(points) => points.iter().map(|p| p[0]).collect(),
            Shape::Points { at, .. } => at.iter().map(|p| p[0]).collect(),
            Shape::Band { x, .. } => x.clone(),
            Shape::Text { at, .. } => vec![at[0]],
            Shape::HorizontalLine(_) => vec![],
            Shape::VerticalLine(x) => vec![*x],
            Shape::Span(from, to) => vec![*from, *to],
        }
    }

    /// Every y that the axis must hold.
    pub(crate) fn all_y(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Line(points) | Shape::Area(points) => points.iter().map(|p| p[1]).collect(),
            Shape::Points { at, error_bars: None, .. } => at.iter().map(|p| p[1]).collect(),
            Shape::Points { at, error_bars: Some(half), .. } => {
                at.iter().zip(half).flat_map(|(p, h)| [p[1] - h, p[1] + h]).collect()
            }
            Shape::Band { low, high, .. } => [&low[..], &high[..]].concat(),
            Shape::Text { at, .. } => vec![at[1]],
            Shape::HorizontalLine(y) => vec![*y],
            Shape::VerticalLine(_) | Shape::Span(..) => vec![],
        }
    }

    /// Refuses numbers that are not finite, and lists of different lengths.
    pub(crate) fn check(&self) -> Result<(), PlotError> {
        let mark_name = || format!("the mark `{}`", self.label.as_deref().unwrap_or("without a label"));
        let same = |found: usize, expected: usize| match found == expected {
            true => Ok(()),
            false => Err(PlotError::Length { what: mark_name(), found, expected }),
        };
        match &self.shape {
            Shape::Points { at, error_bars: Some(half), .. } => same(half.len(), at.len())?,
            Shape::Band { x, low, high } => same(low.len(), x.len()).and(same(high.len(), x.len()))?,
            _ => {}
        }
        for values in [self.all_x(), self.all_y()] {
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(PlotError::NotFinite { what: mark_name(), index, value: values[index] });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_both_ends_of_every_error_bar() {
        let points = Mark::points(vec![[1.0, 10.0], [2.0, 20.0]], Marker::Disc, Colour(0, 0, 0));
        assert_eq!(points.clone().all_y(), [10.0, 20.0]);
        assert_eq!(points.with_error_bars(vec![3.0, 0.5]).all_y(), [7.0, 13.0, 19.5, 20.5]);
    }
}
