//! Diagrams: boxes, arrows, springs and words, for how something is built or what follows what.
//!
//! Coordinates are millimetres of the diagram's own sheet, x to the right and y upwards; the sheet is fitted into the
//! panel, words keep their size.
//!
//! Stands on: `parts`, `symbols`, `canvas`. Never knows: what its boxes mean.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, Words};
use crate::frame::NORMAL;
use crate::mark::Side;
use crate::panel::{Draw, Margins, Where};
use crate::panels::{Panel, parts, symbols};
use crate::{Colour, Dash, PlotError, palette};

/// One part of a diagram.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A rectangle with words in its middle, one line each.
    Box {
        /// Its middle, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The words, one line each; the first one is bold when there are more.
        lines: Vec<String>,
        /// Its ground.
        fill: Colour,
    },
    /// A line with a head at its end, and words beside its middle piece.
    Arrow {
        /// Its points, mm.
        points: Vec<Point2>,
        /// Words beside its middle.
        text: Option<(String, Side)>,
        /// Its colour.
        colour: Colour,
        /// How it is broken.
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
        /// How it is broken.
        dash: Dash,
    },
    /// A filled polygon with a thin rim.
    Polygon {
        /// Its corners, mm.
        points: Vec<Point2>,
        /// Its ground.
        fill: Colour,
    },
    /// A filled circle with a thin rim.
    Disc {
        /// Its middle, mm.
        at: Point2,
        /// Its radius, mm.
        radius: f64,
        /// Its ground.
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
    /// A rectangle with a bold line and small words under it, wrapped to its width.
    Card {
        /// Its middle, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The bold line.
        title: String,
        /// The words.
        words: String,
        /// Its ground.
        fill: Colour,
    },
    /// A line between two points with a bar and a head at each end, and words beside its middle: how long something is.
    Dimension {
        /// One end, mm.
        from: Point2,
        /// Other end, mm.
        to: Point2,
        /// The words.
        text: String,
        /// Where they stand.
        side: Side,
    },
    /// A panel of its own in a rectangle: a scene, a picture.
    Inset {
        /// The rectangle's middle, mm.
        at: Point2,
        /// Its sides, mm.
        size: Point2,
        /// The panel; its margins are left out.
        panel: Box<Panel>,
    },
    /// Words.
    Text {
        /// Where, mm.
        at: Point2,
        /// The words.
        text: String,
        /// On which side of the point they stand.
        side: Side,
        /// Their colour.
        colour: Colour,
    },
}

/// A drawing of parts on a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// Sides of its sheet, mm; the panel shows all of it, in print at true size when the panel is as large.
    pub size: Point2,
    /// What is drawn, the last one on top.
    pub parts: Vec<Part>,
}

/// Line width of rims, springs and arrows.
const LINE: f64 = 0.8;
/// Length of an arrow's head.
const HEAD: f64 = 5.0;
/// Height of a line of words in a box.
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

/// How the sheet lies on paper.
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

    fn place(&self, p: Point2) -> Point2 {
        [self.origin[0] + self.zoom * p[0], self.origin[1] - self.zoom * p[1]]
    }

    fn places(&self, points: &[Point2]) -> Vec<Point2> {
        points.iter().map(|p| self.place(*p)).collect()
    }

    fn area(&self, at: Point2, size: Point2) -> Area {
        let ([x, y], half) = (self.place(at), size.map(|v| 0.5 * self.zoom * v));
        Area { from: [x - half[0], y - half[1]], to: [x + half[0], y + half[1]] }
    }

    fn draw(&self, canvas: &mut Canvas, part: &Part) -> Result<(), PlotError> {
        match part {
            Part::Card { at, size, title, words, fill } => {
                parts::card(canvas, self.area(*at, *size), title, words, *fill);
            }
            Part::Dimension { from, to, text, side } => {
                parts::dimension(canvas, self.place(*from), self.place(*to));
                let ([a, b], [c, d]) = (self.place(*from), self.place(*to));
                beside(canvas, [0.5 * (a + c), 0.5 * (b + d)], text, *side, palette::INK);
            }
            Part::Inset { at, size, panel } => {
                panel.as_draw().draw(canvas, self.area(*at, *size), Where::Inside)?;
            }
            Part::Box { at, size, lines, fill } => self.boxed(canvas, *at, *size, lines, *fill),
            Part::Arrow { points, text, colour, dash } => self.arrow(canvas, points, text.as_ref(), *colour, *dash),
            Part::Line { points, colour, width, dash } => canvas.path(self.places(points), *width, *dash, *colour),
            Part::Polygon { points, fill } => self.polygon(canvas, points, *fill),
            Part::Disc { at, radius, fill } => {
                let (at, radius) = (self.place(*at), self.zoom * radius);
                canvas.items.push(Item::Disc { at, radius, line: None, colour: *fill, opacity: 1.0 });
                canvas.items.push(Item::Disc { at, radius, line: Some(0.6), colour: palette::INK, opacity: 1.0 });
            }
            Part::Spring { from, to } => {
                let line = symbols::spring(self.place(*from), self.place(*to), 5, 4.0);
                canvas.path(line, LINE, Dash::Solid, palette::INK);
            }
            Part::Damper { from, to } => {
                for line in symbols::damper(self.place(*from), self.place(*to), 5.0) {
                    canvas.path(line, LINE, Dash::Solid, palette::INK);
                }
            }
            Part::Wall { from, to } => self.wall(canvas, *from, *to),
            Part::Text { at, text, side, colour } => beside(canvas, self.place(*at), text, *side, *colour),
        }
        Ok(())
    }

    fn boxed(&self, canvas: &mut Canvas, at: Point2, size: Point2, lines: &[String], fill: Colour) {
        let ([x, y], area) = (self.place(at), self.area(at, size));
        canvas.filled(area, fill, 1.0);
        canvas.outline(area, LINE, palette::INK);
        for (i, line) in lines.iter().enumerate() {
            let down = (i as f64 - 0.5 * (lines.len() as f64 - 1.0)) * LEADING;
            canvas.items.push(Item::Text(Words {
                at: [x, y + down],
                text: line.clone(),
                size: NORMAL,
                side: Side::Centre,
                upright: false,
                bold: i == 0 && lines.len() > 1,
                colour: palette::INK,
            }));
        }
    }

    fn arrow(&self, canvas: &mut Canvas, points: &[Point2], text: Option<&(String, Side)>, colour: Colour, dash: Dash) {
        let mut places = self.places(points);
        let Some([.., from, to]) = places.last_chunk::<2>().copied() else { return };
        let head = symbols::arrow_head(from, to, HEAD);
        // the line ends inside of the head, so that its blunt end does not show
        let last = places.len() - 1;
        places[last] = [0.5 * (head[1][0] + head[2][0]), 0.5 * (head[1][1] + head[2][1])];
        let middle = places[(places.len() - 1) / 2..]
            .iter()
            .take(2)
            .fold([0.0; 2], |s, p| [s[0] + 0.5 * p[0], s[1] + 0.5 * p[1]]);
        canvas.path(places, LINE, dash, colour);
        canvas.items.push(Item::Polygon { points: head, colour, opacity: 1.0 });
        if let Some((text, side)) = text {
            beside(canvas, middle, text, *side, palette::INK);
        }
    }

    fn polygon(&self, canvas: &mut Canvas, points: &[Point2], fill: Colour) {
        let places = self.places(points);
        let closed = [&places[..], &places[..places.len().min(2)]].concat();
        canvas.items.push(Item::Polygon { points: places, colour: fill, opacity: 1.0 });
        canvas.path(closed, 0.6, Dash::Solid, palette::INK);
    }

    fn wall(&self, canvas: &mut Canvas, from: Point2, to: Point2) {
        let (from, to) = (self.place(from), self.place(to));
        canvas.segment(from, to, 1.2, palette::INK);
        for [a, b] in symbols::hatching(to, from, 4.0, 4.0) {
            canvas.segment(a, b, 0.6, palette::INK);
        }
    }
}

/// Words beside a point, with a small gap.
fn beside(canvas: &mut Canvas, at: Point2, text: &str, side: Side, colour: Colour) {
    let away = match side {
        Side::Above => [0.0, -6.0],
        Side::Below => [0.0, 6.0],
        Side::Left => [-3.5, 0.0],
        Side::Right => [3.5, 0.0],
        Side::Centre => [0.0, 0.0],
    };
    canvas.words([at[0] + away[0], at[1] + away[1]], text, NORMAL, side, colour);
}

impl Draw for Diagram {
    fn check(&self) -> Result<(), PlotError> {
        if self.parts.is_empty() {
            return Err(PlotError::Empty { what: "a diagram" });
        }
        let insets =
            self.parts.iter().filter_map(|p| if let Part::Inset { panel, .. } = p { Some(panel) } else { None });
        insets.map(|panel| panel.as_draw()).try_for_each(Draw::check)?;
        match self.size.iter().position(|v| !(v.is_finite() && *v > 0.0)) {
            Some(index) => {
                Err(PlotError::NotFinite { what: "a diagram's size".to_owned(), index, value: self.size[index] })
            }
            None => Ok(()),
        }
    }

    fn margins(&self, _cell: Area, _legend: Where) -> Result<Option<Margins>, PlotError> {
        Ok(None)
    }

    fn draw(&self, canvas: &mut Canvas, cell: Area, _legend: Where) -> Result<(), PlotError> {
        let sheet = Sheet::new(self.size, cell);
        self.parts.iter().try_for_each(|part| sheet.draw(canvas, part))
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
        let corner = sheet.place([0.0, 30.0]);
        assert!((0..2).all(|k| (corner[k] - cell.from[k]).abs() < 1e-9));
    }
}
