//! The canvas: drawing items in order, in points of print (1/72 inch, y downwards), before they become SVG.

use si::Point2;

use crate::{Colour, Dash, Side, palette, text};

/// Points of print in a millimetre.
pub(crate) const POINTS_PER_MM: f64 = 72.0 / 25.4;

/// An axis-aligned rectangle, in points of print.
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

    /// Its horizontal side.
    pub fn width(&self) -> f64 {
        self.to[0] - self.from[0]
    }

    /// Its vertical side.
    pub fn height(&self) -> f64 {
        self.to[1] - self.from[1]
    }

    /// Its centre.
    pub fn centre(&self) -> Point2 {
        [0.5 * (self.from[0] + self.to[0]), 0.5 * (self.from[1] + self.to[1])]
    }

    /// Grown (or shrunk, below 0) on every side.
    pub fn grown(&self, margin: f64) -> Self {
        Self { from: self.from.map(|v| v - margin), to: self.to.map(|v| v + margin) }
    }

    /// Whether a point lies in it.
    pub fn contains(&self, p: Point2) -> bool {
        (0..2).all(|k| p[k] >= self.from[k] && p[k] <= self.to[k])
    }

    /// Whether two share a point.
    pub(crate) fn intersects(&self, other: &Self) -> bool {
        (0..2).all(|k| self.from[k] <= other.to[k] && self.to[k] >= other.from[k])
    }

    /// Its corners, in order around it.
    pub fn corners(&self) -> Vec<Point2> {
        vec![self.from, [self.to[0], self.from[1]], self.to, [self.from[0], self.to[1]]]
    }
}

/// One line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct TextItem {
    /// Its anchor at half of its height; `side` decides how the text is aligned to it.
    pub at: Point2,
    /// Its characters.
    pub text: String,
    /// Font size.
    pub size: f64,
    /// Its alignment: `Left` ends at the anchor, `Right` begins there, any other is centred.
    pub side: Side,
    /// Rotated by 90°, read upwards.
    pub vertical: bool,
    /// In bold type.
    pub bold: bool,
    /// Its colour.
    pub colour: Colour,
}

impl TextItem {
    /// Horizontal black text of normal weight, centred at a point.
    pub fn new(at: Point2, text: &str, size: f64) -> Self {
        let (text, side, colour) = (text.to_owned(), Side::Centre, palette::BLACK);
        Self { at, text, size, side, vertical: false, bold: false, colour }
    }

    /// The same text with another alignment.
    pub fn side(self, side: Side) -> Self {
        Self { side, ..self }
    }

    /// The same text in another colour.
    pub fn colour(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }

    /// The same text in bold type.
    pub(crate) fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same text, rotated by 90°.
    pub(crate) fn vertical(self) -> Self {
        Self { vertical: true, ..self }
    }

    /// The same text with its anchor moved.
    pub(crate) fn shifted_by(self, shift: Point2) -> Self {
        Self { at: [self.at[0] + shift[0], self.at[1] + shift[1]], ..self }
    }

    /// The bounding box of the text.
    pub(crate) fn text_area(&self) -> Area {
        let width = text::width(&self.text, self.size) * if self.bold { text::BOLD } else { 1.0 };
        let begin = match self.side {
            Side::Right => 0.0,
            Side::Left => -width,
            _ => -0.5 * width,
        };
        let half = 0.5 * self.size;
        let [x, y] = self.at;
        match self.vertical {
            false => Area { from: [x + begin, y - half], to: [x + begin + width, y + half] },
            true => Area { from: [x - half, y - begin - width], to: [x + half, y - begin] },
        }
    }
}

/// One drawing item.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A line through points.
    Path {
        /// The points.
        points: Vec<Point2>,
        /// Line width.
        width: f64,
        /// Its dash pattern.
        dash: Dash,
        /// Its colour.
        colour: Colour,
        /// Opacity, 0 to 1.
        opacity: f64,
    },
    /// A filled polygon.
    Polygon {
        /// Its corners.
        points: Vec<Point2>,
        /// Its colour.
        colour: Colour,
        /// Opacity, 0 to 1.
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
        /// Opacity, 0 to 1.
        opacity: f64,
    },
    /// A line of text.
    Text(TextItem),
    /// A picture that fills a rectangle.
    Picture {
        /// The rectangle.
        area: Area,
        /// The file's bytes.
        png: Vec<u8>,
    },
}

/// Drawing items in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Canvas {
    /// The items, the last one on top.
    pub items: Vec<Item>,
}

impl Canvas {
    /// A solid or broken line.
    pub(crate) fn draw_path(&mut self, points: Vec<Point2>, width: f64, dash: Dash, colour: Colour) {
        self.items.push(Item::Path { points, width, dash, colour, opacity: 1.0 });
    }

    /// A straight solid line.
    pub(crate) fn draw_segment(&mut self, from: Point2, to: Point2, width: f64, colour: Colour) {
        self.draw_path(vec![from, to], width, Dash::Solid, colour);
    }

    /// The outline of a rectangle.
    pub(crate) fn draw_outline(&mut self, area: Area, width: f64, colour: Colour) {
        let mut points = area.corners();
        points.push(area.from);
        points.push([area.to[0], area.from[1]]); // the first side is repeated, so that the last corner is mitred like the others
        self.draw_path(points, width, Dash::Solid, colour);
    }

    /// A filled rectangle.
    pub(crate) fn fill_area(&mut self, area: Area, colour: Colour, opacity: f64) {
        self.items.push(Item::Polygon { points: area.corners(), colour, opacity });
    }

    /// A line of text.
    pub(crate) fn draw_text(&mut self, text: TextItem) {
        self.items.push(Item::Text(text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotated_text_has_a_bounding_box_with_swapped_sides() {
        let text = TextItem::new([10.0, 50.0], "mmmm", 8.0);
        let (horizontal, vertical) = (text.text_area(), text.vertical().text_area());
        assert!((horizontal.width() - vertical.height()).abs() < 1e-12 && (horizontal.height() - 8.0).abs() < 1e-12);
        assert_eq!(horizontal.centre(), vertical.centre());
    }
}
