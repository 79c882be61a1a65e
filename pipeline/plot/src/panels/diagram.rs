//! Diagrams: boxes, arrows, springs and text on a sheet.
//!
//! Coordinates are millimetres on the diagram's sheet, x to the right and y upwards. The sheet is scaled to fit the
//! panel; text keeps its size.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::frame::NORMAL;
use crate::mark::Side;
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::panels::{Panel, parts, symbols};
use crate::{Colour, Dash, PlotError, palette};

/// One part of a diagram.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A rectangle with centred lines of text.
    Box {
        /// Its centre, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The lines of text; the first one is bold when there are more.
        lines: Vec<String>,
        /// Its fill colour.
        fill: Colour,
    },
    /// A line with a head at its end, and text beside its middle segment.
    Arrow {
        /// Its points, mm.
        points: Vec<Point2>,
        /// Text beside its middle.
        text: Option<(String, Side)>,
        /// Its colour.
        colour: Colour,
        /// Its dash pattern.
        dash: Dash,
    },
    /// A line.
    Line {
        /// Its points, mm.
        points: Vec<Point2>,
        /// Its colour.
        colour: Colour,
        /// Its width, points of print.
        width: f64,
        /// Its dash pattern.
        dash: Dash,
    },
    /// A filled polygon with a thin outline.
    Polygon {
        /// Its corners, mm.
        points: Vec<Point2>,
        /// Its fill colour.
        fill: Colour,
    },
    /// A filled circle with a thin outline.
    Disc {
        /// Its centre, mm.
        at: Point2,
        /// Its radius, mm.
        radius: f64,
        /// Its fill colour.
        fill: Colour,
    },
    /// A zigzag between two points, mm.
    Spring {
        /// One end.
        from: Point2,
        /// Other end.
        to: Point2,
    },
    /// A dashpot between two points, mm.
    Damper {
        /// The rod's end.
        from: Point2,
        /// The cup's end.
        to: Point2,
    },
    /// A wall between two points, hatched on its left side, mm.
    Wall {
        /// One end.
        from: Point2,
        /// Other end.
        to: Point2,
    },
    /// A rectangle with a bold title and small text under it, wrapped to its width.
    Card {
        /// Its centre, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The bold title.
        title: String,
        /// The text under the title.
        text: String,
        /// Its fill colour.
        fill: Colour,
    },
    /// A dimension line: a bar and an arrow head at each end, and text beside its middle.
    Dimension {
        /// One end, mm.
        from: Point2,
        /// Other end, mm.
        to: Point2,
        /// The text.
        text: String,
        /// On which side of the line it is.
        side: Side,
    },
    /// A panel inside of the diagram, such as a scene or a picture.
    Inset {
        /// The rectangle's centre, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The panel; its margins are left out.
        panel: Box<Panel>,
    },
    /// Text beside a point.
    Text {
        /// The point, mm.
        at: Point2,
        /// The text.
        text: String,
        /// On which side of the point it is.
        side: Side,
        /// Its colour.
        colour: Colour,
    },
}

/// Parts on a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// Sides of its sheet, mm; printed at true size when the panel is as large.
    pub size: Point2,
    /// The parts, the last one on top.
    pub parts: Vec<Part>,
}

/// Line width of outlines, springs and arrows.
const LINE: f64 = 0.8;
/// Length of an arrow's head.
const HEAD: f64 = 5.0;
/// Height of a line of text in a box.
const LEADING: f64 = 8.6;

impl Diagram {
    /// An empty sheet, sides in mm.
    pub fn new(width: f64, height: f64) -> Self {
        Self { size: [width, height], parts: Vec::new() }
    }

    /// The same diagram with one more part.
    pub fn with(mut self, part: Part) -> Self {
        self.parts.push(part);
        self
    }
}

/// The map from the sheet to the page.
struct Sheet {
    origin: Point2,
    zoom: f64,
}

impl Sheet {
    fn new(size: Point2, cell: Area) -> Self {
        let zoom = (cell.width() / size[0]).min(cell.height() / size[1]);
        let centre = cell.centre();
        Self { origin: [centre[0] - 0.5 * zoom * size[0], centre[1] + 0.5 * zoom * size[1]], zoom }
    }

    fn page_place(&self, p: Point2) -> Point2 {
        [self.origin[0] + self.zoom * p[0], self.origin[1] - self.zoom * p[1]]
    }

    fn page_places(&self, points: &[Point2]) -> Vec<Point2> {
        points.iter().map(|p| self.page_place(*p)).collect()
    }

    fn page_area(&self, at: Point2, size: Point2) -> Area {
        let ([x, y], half) = (self.page_place(at), size.map(|v| 0.5 * self.zoom * v));
        Area { from: [x - half[0], y - half[1]], to: [x + half[0], y + half[1]] }
    }

    fn draw_part(&self, canvas: &mut Canvas, part: &Part) -> Result<(), PlotError> {
        match part {
            Part::Card { at, size, title, text, fill } => {
                let area = self.page_area(*at, *size);
                parts::filled_box(canvas, area, *fill, parts::LINE);
                parts::card_text(canvas, area, title, text);
            }
            Part::Dimension { from, to, text, side } => self.draw_dimension(canvas, [*from, *to], text, *side),
            Part::Inset { at, size, panel } => {
                panel.as_draw().draw_panel(canvas, self.page_area(*at, *size), LegendPlacement::Inside)?;
            }
            Part::Box { at, size, lines, fill } => {
                parts::filled_box(canvas, self.page_area(*at, *size), *fill, LINE);
                centred_lines(canvas, self.page_place(*at), lines);
            }
            Part::Arrow { points, text, colour, dash } => {
                let middle = self.draw_arrow(canvas, points, *colour, *dash);
                if let (Some(middle), Some((text, side))) = (middle, text) {
                    canvas.draw_text(moved_aside(TextItem::new(middle, text, NORMAL).side(*side)));
                }
            }
            Part::Line { points, colour, width, dash } => {
                canvas.draw_path(self.page_places(points), *width, *dash, *colour)
            }
            Part::Polygon { points, fill } => self.draw_polygon(canvas, points, *fill),
            Part::Disc { at, radius, fill } => self.draw_disc(canvas, *at, *radius, *fill),
            Part::Spring { from, to } => {
                let line = symbols::spring_line(self.page_place(*from), self.page_place(*to), 5, 4.0);
                canvas.draw_path(line, LINE, Dash::Solid, palette::BLACK);
            }
            Part::Damper { from, to } => self.draw_damper(canvas, *from, *to),
            Part::Wall { from, to } => self.draw_wall(canvas, *from, *to),
            Part::Text { at, text, side, colour } => {
                let item = TextItem::new(self.page_place(*at), text, NORMAL).side(*side).colour(*colour);
                canvas.draw_text(moved_aside(item));
            }
        }
        Ok(())
    }

    fn draw_dimension(&self, canvas: &mut Canvas, ends: [Point2; 2], text: &str, side: Side) {
        let [[a, b], [c, d]] = ends.map(|end| self.page_place(end));
        parts::draw_dimension(canvas, [a, b], [c, d]);
        canvas.draw_text(moved_aside(TextItem::new([0.5 * (a + c), 0.5 * (b + d)], text, NORMAL).side(side)));
    }

    fn draw_disc(&self, canvas: &mut Canvas, at: Point2, radius: f64, fill: Colour) {
        let (at, radius) = (self.page_place(at), self.zoom * radius);
        canvas.items.push(Item::Disc { at, radius, line: None, colour: fill, opacity: 1.0 });
        canvas.items.push(Item::Disc { at, radius, line: Some(0.6), colour: palette::BLACK, opacity: 1.0 });
    }

    fn draw_damper(&self, canvas: &mut Canvas, from: Point2, to: Point2) {
        for line in symbols::damper_lines(self.page_place(from), self.page_place(to), 5.0) {
            canvas.draw_path(line, LINE, Dash::Solid, palette::BLACK);
        }
    }

    /// Draws an arrow and returns the middle of its middle segment.
    fn draw_arrow(&self, canvas: &mut Canvas, points: &[Point2], colour: Colour, dash: Dash) -> Option<Point2> {
        let mut places = self.page_places(points);
        let [from, to] = places.last_chunk::<2>().copied()?;
        let head = symbols::arrow_head(from, to, HEAD);
        // the line ends at the base of the head, so that its square end does not show at the tip
        let last = places.len() - 1;
        places[last] = [0.5 * (head[1][0] + head[2][0]), 0.5 * (head[1][1] + head[2][1])];
        let middle = places[(places.len() - 1) / 2..]
            .iter()
            .take(2)
            .fold([0.0; 2], |s, p| [s[0] + 0.5 * p[0], s[1] + 0.5 * p[1]]);
        canvas.draw_path(places, LINE, dash, colour);
        canvas.items.push(Item::Polygon { points: head, colour, opacity: 1.0 });
        Some(middle)
    }

    fn draw_polygon(&self, canvas: &mut Canvas, points: &[Point2], fill: Colour) {
        let places = self.page_places(points);
        let closed = [&places[..], &places[..places.len().min(2)]].concat();
        canvas.items.push(Item::Polygon { points: places, colour: fill, opacity: 1.0 });
        canvas.draw_path(closed, 0.6, Dash::Solid, palette::BLACK);
    }

    fn draw_wall(&self, canvas: &mut Canvas, from: Point2, to: Point2) {
        let (from, to) = (self.page_place(from), self.page_place(to));
        canvas.draw_segment(from, to, 1.2, palette::BLACK);
        for [a, b] in symbols::hatching_lines(to, from, 4.0, 4.0) {
            canvas.draw_segment(a, b, 0.6, palette::BLACK);
        }
    }
}

/// Lines of text, centred at a point; the first one is bold when there are more.
fn centred_lines(canvas: &mut Canvas, [x, y]: Point2, lines: &[String]) {
    for (i, line) in lines.iter().enumerate() {
        let offset = (i as f64 - 0.5 * (lines.len() as f64 - 1.0)) * LEADING;
        let text = TextItem::new([x, y + offset], line, NORMAL);
        canvas.draw_text(if i == 0 && lines.len() > 1 { text.bold() } else { text });
    }
}

/// A text moved from its point to its side, with a small gap.
fn moved_aside(text: TextItem) -> TextItem {
    let gap = match text.side {
        Side::Above => [0.0, -6.0],
        Side::Below => [0.0, 6.0],
        Side::Left => [-3.5, 0.0],
        Side::Right => [3.5, 0.0],
        Side::Centre => [0.0, 0.0],
    };
    text.shifted_by(gap)
}

impl Draw for Diagram {
    fn check_content(&self) -> Result<(), PlotError> {
        if self.parts.is_empty() {
            return Err(PlotError::Empty { what: "a diagram" });
        }
        let insets =
            self.parts.iter().filter_map(|p| if let Part::Inset { panel, .. } = p { Some(panel) } else { None });
        insets.map(|panel| panel.as_draw()).try_for_each(Draw::check_content)?;
        match self.size.iter().position(|v| !(v.is_finite() && *v > 0.0)) {
            Some(index) => {
                Err(PlotError::NotFinite { what: "a diagram's size".to_owned(), index, value: self.size[index] })
            }
            None => Ok(()),
        }
    }

    fn frame_margins(&self, _cell: Area, _legend: LegendPlacement) -> Result<Option<Margins>, PlotError> {
        Ok(None)
    }

    fn draw_panel(&self, canvas: &mut Canvas, cell: Area, _legend: LegendPlacement) -> Result<(), PlotError> {
        let sheet = Sheet::new(self.size, cell);
        self.parts.iter().try_for_each(|part| sheet.draw_part(canvas, part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::POINTS_PER_MM;

    #[test]
    fn a_sheet_as_large_as_its_cell_is_printed_at_true_size() {
        let cell = Area::new([10.0, 20.0], [40.0 * POINTS_PER_MM, 30.0 * POINTS_PER_MM]);
        let sheet = Sheet::new([40.0, 30.0], cell);
        assert!((sheet.zoom - POINTS_PER_MM).abs() < 1e-12);
        let corner = sheet.page_place([0.0, 30.0]);
        assert!((0..2).all(|k| (corner[k] - cell.from[k]).abs() < 1e-9));
    }

    #[test]
    fn the_text_of_a_dimension_stands_at_the_middle_of_its_line() {
        let (from, to) = ([10.0, 4.0], [30.0, 24.0]);
        let part = Part::Dimension { from, to, text: "20 mm".into(), side: Side::Centre };
        let cell = Area::new([10.0, 20.0], [40.0 * POINTS_PER_MM, 30.0 * POINTS_PER_MM]);
        let mut canvas = Canvas::default();
        Diagram::new(40.0, 30.0).with(part).draw_panel(&mut canvas, cell, LegendPlacement::Inside).unwrap();
        let text = canvas.items.iter().find_map(|item| if let Item::Text(text) = item { Some(text) } else { None });
        let middle = Sheet::new([40.0, 30.0], cell).page_place([20.0, 14.0]);
        assert!((0..2).all(|k| (text.unwrap().at[k] - middle[k]).abs() < 1e-9), "{text:?} {middle:?}");
    }
}
