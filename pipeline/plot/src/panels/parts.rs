//! Parts of a diagram that are more than one shape: cards with wrapped text, dimension lines.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::panels::symbols;
use crate::text::wrap_text;
use crate::{Colour, Dash, palette};

/// Font size of a card's title.
const TITLE: f64 = 6.6;
/// Font size of a card's text.
const BODY: f64 = 5.4;
/// Height of a line of a card's text.
const LEADING: f64 = 6.4;
/// Between a card's outline and its text.
const PADDING: f64 = 2.0;
/// Line width of a card and of a dimension.
pub const LINE: f64 = 0.6;
/// Length of a dimension's arrow heads.
const HEAD: f64 = 4.0;
/// Half length of a dimension's bars.
const BAR: f64 = 2.5;

/// A filled rectangle with an outline.
pub(crate) fn filled_box(canvas: &mut Canvas, area: Area, fill: Colour, line: f64) {
    canvas.fill_area(area, fill, 1.0);
    canvas.draw_outline(area, line, palette::BLACK);
}

/// A bold title and small text under it, wrapped to the width of a card.
pub(crate) fn card_text(canvas: &mut Canvas, area: Area, title: &str, text: &str) {
    let width = area.width() - 2.0 * PADDING;
    let (heads, lines) = (wrap_text(title, width, TITLE * crate::text::BOLD), wrap_text(text, width, BODY));
    let high = (heads.len() + lines.len()) as f64 * LEADING;
    let (x, top) = (area.centre()[0], area.centre()[1] - 0.5 * high + 0.5 * LEADING);
    let line_position = |line: usize| [x, top + line as f64 * LEADING];
    for (i, line) in heads.iter().enumerate() {
        canvas.draw_text(TextItem::new(line_position(i), line, TITLE).bold());
    }
    for (i, line) in lines.iter().enumerate() {
        canvas.draw_text(TextItem::new(line_position(heads.len() + i), line, BODY));
    }
}

/// A line with a bar and a head at each end.
pub(crate) fn draw_dimension(canvas: &mut Canvas, from: Point2, to: Point2) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]).max(f64::MIN_POSITIVE);
    let bar_offset = [-way[1] / length * BAR, way[0] / length * BAR];
    canvas.draw_path(vec![from, to], LINE, Dash::Solid, palette::BLACK);
    for (end, other) in [(to, from), (from, to)] {
        canvas.draw_segment(
            [end[0] - bar_offset[0], end[1] - bar_offset[1]],
            [end[0] + bar_offset[0], end[1] + bar_offset[1]],
            LINE,
            palette::BLACK,
        );
        if length > 2.5 * HEAD {
            let points = symbols::arrow_head(other, end, HEAD);
            canvas.items.push(Item::Polygon { points, colour: palette::BLACK, opacity: 1.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_dimension_has_bars_and_no_heads() {
        let heads = |length: f64| {
            let mut canvas = Canvas::default();
            draw_dimension(&mut canvas, [0.0, 0.0], [length, 0.0]);
            canvas.items.iter().filter(|i| matches!(i, Item::Polygon { .. })).count()
        };
        assert_eq!((heads(5.0), heads(40.0)), (0, 2));
    }
}
