//! Marks are painted: each shape is transformed by two rulers and clipped to the frame.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::mark::{Mark, Marker, Shape, Side};
use crate::ruler::Ruler;
use crate::{Dash, PlotError, clip, palette};

/// The area that marks are painted in: one ruler for each axis, and the clipping rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlotArea {
    /// Horizontal axis.
    pub x: Ruler,
    /// Vertical axis.
    pub y: Ruler,
    /// The clipping rectangle.
    pub frame: Area,
}

/// Width of the lines of empty markers and crosses, as a part of their size.
const MARKER_LINE: f64 = 0.24;

impl PlotArea {
    fn page_place(&self, p: &Point2) -> Point2 {
        [self.x.place_of(p[0]), self.y.place_of(p[1])]
    }

    /// Refuses a mark with numbers that an axis cannot show.
    pub(crate) fn check_mark(&self, mark: &Mark) -> Result<(), PlotError> {
        mark.check()?;
        for (ruler, values, name) in [(&self.x, mark.all_x(), "x"), (&self.y, mark.all_y(), "y")] {
            if let Some(&value) = values.iter().find(|v| ruler.scale == crate::Scale::Log && **v <= 0.0) {
                return Err(PlotError::NotPositive { axis: name.to_owned(), value });
            }
        }
        Ok(())
    }

    /// Draws a mark.
    pub(crate) fn draw_mark(&self, canvas: &mut Canvas, mark: &Mark) {
        match &mark.shape {
            Shape::Line(points) => self.draw_line(canvas, mark, points),
            Shape::Points { at, marker, error_bars } => {
                let half = |i: usize| error_bars.as_ref().map(|halves| halves[i]);
                self.draw_points(canvas, mark, *marker, at.iter().enumerate().map(|(i, p)| (*p, half(i))));
            }
            Shape::Band { x, low, high } => {
                let upper_curve = x.iter().zip(high).map(|(x, y)| [*x, *y]);
                let lower_curve = x.iter().zip(low).rev().map(|(x, y)| [*x, *y]);
                self.draw_polygon(canvas, mark, &upper_curve.chain(lower_curve).collect::<Vec<_>>());
            }
            Shape::Area(points) => self.draw_polygon(canvas, mark, points),
            Shape::Text { at, text, side } => {
                self.draw_text(canvas, TextItem::new(*at, text, mark.size).side(*side).colour(mark.colour));
            }
            Shape::HorizontalLine(y) => self.draw_line(canvas, mark, &[[self.x.ends.0, *y], [self.x.ends.1, *y]]),
            Shape::VerticalLine(x) => self.draw_line(canvas, mark, &[[*x, self.y.ends.0], [*x, self.y.ends.1]]),
            Shape::Span(from, to) => {
                let (low, high) = self.y.ends;
                self.draw_polygon(canvas, mark, &[[*from, low], [*to, low], [*to, high], [*from, high]]);
            }
        }
    }

    fn draw_line(&self, canvas: &mut Canvas, mark: &Mark, points: &[Point2]) {
        let places: Vec<Point2> = points.iter().map(|p| self.page_place(p)).collect();
        for points in clip::clip_line(&places, &self.frame) {
            let Mark { size: width, dash, colour, opacity, .. } = *mark;
            canvas.items.push(Item::Path { points, width, dash, colour, opacity });
        }
    }

    fn draw_polygon(&self, canvas: &mut Canvas, mark: &Mark, points: &[Point2]) {
        let places: Vec<Point2> = points.iter().map(|p| self.page_place(p)).collect();
        let points = clip::clip_polygon(&places, &self.frame);
        if points.len() > 2 {
            canvas.items.push(Item::Polygon { points, colour: mark.colour, opacity: mark.opacity });
        }
    }

    /// Markers, each with the half length of its error bar, when it has one.
    fn draw_points(
        &self,
        canvas: &mut Canvas,
        mark: &Mark,
        marker: Marker,
        at: impl Iterator<Item = (Point2, Option<f64>)>,
    ) {
        for (p, half) in at {
            let page_point = self.page_place(&p);
            if !self.frame.grown(0.01).contains(page_point) {
                continue;
            }
            if let Some(half) = half {
                let bar = [self.page_place(&[p[0], p[1] - half]), self.page_place(&[p[0], p[1] + half])];
                error_bar(canvas, mark, bar, &self.frame);
            }
            draw_marker(canvas, mark, page_point, marker);
        }
    }

    /// Text anchored at a point in the units of the axes, moved to one side of it.
    fn draw_text(&self, canvas: &mut Canvas, text: TextItem) {
        let gap = 3.0;
        let offset = match text.side {
            Side::Above => [0.0, -gap - 0.4 * text.size],
            Side::Below => [0.0, gap + 0.4 * text.size],
            Side::Left => [-gap, 0.0],
            Side::Right => [gap, 0.0],
            Side::Centre => [0.0, 0.0],
        };
        let page_point = self.page_place(&text.at);
        if self.frame.grown(0.01).contains(page_point) {
            let text = TextItem { at: [page_point[0] + offset[0], page_point[1] + offset[1]], ..text };
            canvas.draw_text(TextItem { at: self.shifted_inside(&text), ..text });
        }
    }

    /// The anchor at which a text does not cross the frame.
    fn shifted_inside(&self, text: &TextItem) -> Point2 {
        let (area, inner) = (text.text_area(), self.frame.grown(-1.5));
        let shift = |k: usize| (inner.from[k] - area.from[k]).max(0.0) + (inner.to[k] - area.to[k]).min(0.0);
        [text.at[0] + shift(0), text.at[1] + shift(1)]
    }
}

fn error_bar(canvas: &mut Canvas, mark: &Mark, [low, high]: [Point2; 2], frame: &Area) {
    if let Some([a, b]) = clip::clip_segment(low, high, frame) {
        canvas.draw_segment(a, b, 0.7, mark.colour);
        for end in [a, b] {
            canvas.draw_segment([end[0] - 1.6, end[1]], [end[0] + 1.6, end[1]], 0.7, mark.colour);
        }
    }
}

/// One marker at a point of the page; also used for the legend's samples.
pub(crate) fn draw_marker(canvas: &mut Canvas, mark: &Mark, at: Point2, marker: Marker) {
    let Mark { colour, opacity, size, .. } = *mark;
    let r = 0.5 * size;
    let line = (MARKER_LINE * size).max(0.6);
    let around_point =
        |corners: &[Point2]| corners.iter().map(|c| [at[0] + r * c[0], at[1] + r * c[1]]).collect::<Vec<_>>();
    let mut cross = |ends: [[Point2; 2]; 2]| {
        for end in ends {
            canvas.draw_path(around_point(&end), line, Dash::Solid, colour);
        }
    };
    match marker {
        Marker::Cross => cross([[[-0.8, -0.8], [0.8, 0.8]], [[-0.8, 0.8], [0.8, -0.8]]]),
        Marker::Plus => cross([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]]),
        Marker::Disc => canvas.items.push(Item::Disc { at, radius: r, line: None, colour, opacity }),
        Marker::Ring => {
            canvas.items.push(Item::Disc { at, radius: r, line: None, colour: palette::PAPER, opacity });
            canvas.items.push(Item::Disc { at, radius: r, line: Some(line), colour, opacity });
        }
        Marker::Square => {
            let points = around_point(&[[-0.88, -0.88], [0.88, -0.88], [0.88, 0.88], [-0.88, 0.88]]);
            canvas.items.push(Item::Polygon { points, colour, opacity });
        }
        Marker::Triangle => {
            let points = around_point(&[[0.0, -1.15], [1.0, 0.65], [-1.0, 0.65]]);
            canvas.items.push(Item::Polygon { points, colour, opacity });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Colour;

    #[test]
    fn an_upright_cross_reaches_its_size_to_all_sides() {
        let mark = Mark::points(vec![], Marker::Plus, Colour(0, 0, 0)).sized(10.0);
        let mut canvas = Canvas::default();
        draw_marker(&mut canvas, &mark, [50.0, 50.0], Marker::Plus);
        for [right, down] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            let touched =
                |away: f64| canvas.touches_area(&Area::new([50.0 + away * right, 50.0 + away * down], [0.0; 2]));
            assert!(touched(4.9) && !touched(8.0), "{right} {down}");
        }
    }

    #[test]
    fn an_error_bar_ends_in_a_stroke_to_both_sides() {
        let mark = Mark::points(vec![], Marker::Plus, Colour(0, 0, 0));
        let mut canvas = Canvas::default();
        let frame = Area::new([0.0; 2], [100.0, 100.0]);
        error_bar(&mut canvas, &mark, [[50.0, 70.0], [50.0, 30.0]], &frame);
        let touched = |at: Point2| canvas.touches_area(&Area::new(at, [0.0; 2]));
        for end in [30.0, 70.0] {
            assert!(
                [48.5, 51.5].iter().all(|x| touched([*x, end])) && [46.0, 54.0].iter().all(|x| !touched([*x, end]))
            );
        }
        assert!(touched([50.0, 50.0]) && !touched([50.0, 25.0]) && !touched([52.0, 50.0]));
    }
}
