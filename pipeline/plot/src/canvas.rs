//! The canvas: what is drawn, in order, in points of print (1/72 inch, y downwards), before it becomes SVG.
//!
//! Stands on: `si`, the palette and `text`. Never knows: SVG, or what a mark or a panel is.

use si::Point2;

use crate::{Colour, Dash, Side, text};

/// Points of print in a millimetre.
pub const POINTS_PER_MM: f64 = 72.0 / 25.4;

/// An upright rectangle, in points of print.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left and upper ends.
    pub from: Point2,
    /// Right and lower ends.
    pub to: Point2,
}

impl Area {
    /// From its left upper corner and its size.
    pub fn new(from: Point2, size: Point2) -> Self {
        Self { from, to: [from[0] + size[0], from[1] + size[1]] }
    }

    /// Across.
    pub fn width(&self) -> f64 {
        self.to[0] - self.from[0]
    }

    /// Up.
    pub fn height(&self) -> f64 {
        self.to[1] - self.from[1]
    }

    /// Its middle.
    pub fn centre(&self) -> Point2 {
        [0.5 * (self.from[0] + self.to[0]), 0.5 * (self.from[1] + self.to[1])]
    }

    /// Grown (or shrunk, below 0) on every side.
    pub fn grown(&self, by: f64) -> Self {
        Self { from: self.from.map(|v| v - by), to: self.to.map(|v| v + by) }
    }

    /// Whether a point lies in it.
    pub fn holds(&self, p: Point2) -> bool {
        (0..2).all(|k| p[k] >= self.from[k] && p[k] <= self.to[k])
    }

    /// Whether two share a point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.from[k] <= other.to[k] && self.to[k] >= other.from[k])
    }

    /// Its corners, in order around it.
    pub fn corners(&self) -> Vec<Point2> {
        vec![self.from, [self.to[0], self.from[1]], self.to, [self.from[0], self.to[1]]]
    }
}

/// Words on paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Words {
    /// Left, middle or right of the words' middle height, as `side` says.
    pub at: Point2,
    /// The words.
    pub text: String,
    /// Font size.
    pub size: f64,
    /// Where the words stand: `Left` ends at the point, `Right` begins there, any other is centred.
    pub side: Side,
    /// Read from below.
    pub upright: bool,
    /// Heavy letters.
    pub bold: bool,
    /// Their colour.
    pub colour: Colour,
}

impl Words {
    /// The rectangle that the words fill.
    pub fn area(&self) -> Area {
        let width = text::width(&self.text, self.size) * if self.bold { text::BOLD } else { 1.0 };
        let begin = match self.side {
            Side::Right => 0.0,
            Side::Left => -width,
            _ => -0.5 * width,
        };
        let half = 0.5 * self.size;
        let [x, y] = self.at;
        match self.upright {
            false => Area { from: [x + begin, y - half], to: [x + begin + width, y + half] },
            true => Area { from: [x - half, y - begin - width], to: [x + half, y - begin] },
        }
    }
}

/// One thing on the canvas.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A line through points.
    Path {
        /// The points.
        points: Vec<Point2>,
        /// Line width.
        width: f64,
        /// How it is broken.
        dash: Dash,
        /// Its colour.
        colour: Colour,
        /// 1 covers.
        opacity: f64,
    },
    /// A filled polygon.
    Polygon {
        /// Its corners.
        points: Vec<Point2>,
        /// Its colour.
        colour: Colour,
        /// 1 covers.
        opacity: f64,
    },
    /// A circle.
    Disc {
        /// Its centre.
        at: Point2,
        /// Its radius.
        radius: f64,
        /// Line width of an empty circle; none: filled.
        line: Option<f64>,
        /// Its colour.
        colour: Colour,
        /// 1 covers.
        opacity: f64,
    },
    /// Words.
    Text(Words),
    /// A picture that fills a rectangle.
    Picture {
        /// The rectangle.
        area: Area,
        /// The file's bytes.
        png: Vec<u8>,
    },
}

/// What is drawn, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Canvas {
    /// The things, the last one on top.
    pub items: Vec<Item>,
}

impl Canvas {
    /// A solid or broken line.
    pub fn path(&mut self, points: Vec<Point2>, width: f64, dash: Dash, colour: Colour) {
        self.items.push(Item::Path { points, width, dash, colour, opacity: 1.0 });
    }

    /// A straight solid line.
    pub fn segment(&mut self, from: Point2, to: Point2, width: f64, colour: Colour) {
        self.path(vec![from, to], width, Dash::Solid, colour);
    }

    /// The outline of a rectangle.
    pub fn outline(&mut self, area: Area, width: f64, colour: Colour) {
        let mut points = area.corners();
        points.push(area.from);
        points.push([area.to[0], area.from[1]]); // once more round the corner, so that it is mitred like the others
        self.path(points, width, Dash::Solid, colour);
    }

    /// A filled rectangle.
    pub fn filled(&mut self, area: Area, colour: Colour, opacity: f64) {
        self.items.push(Item::Polygon { points: area.corners(), colour, opacity });
    }

    /// Words of normal weight, read from the left.
    pub fn words(&mut self, at: Point2, text: &str, size: f64, side: Side, colour: Colour) {
        let text = text.to_owned();
        self.items.push(Item::Text(Words { at, text, size, side, upright: false, bold: false, colour }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn upright_words_fill_a_standing_rectangle() {
        let mut words = Words {
            at: [10.0, 50.0],
            text: "mmmm".to_owned(),
            size: 8.0,
            side: Side::Centre,
            upright: false,
            bold: false,
            colour: Colour(0, 0, 0),
        };
        let lying = words.area();
        words.upright = true;
        let standing = words.area();
        assert!((lying.width() - standing.height()).abs() < 1e-12 && (lying.height() - 8.0).abs() < 1e-12);
        assert_eq!(lying.centre(), standing.centre());
    }
}
