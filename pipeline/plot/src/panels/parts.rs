//! Parts of a diagram that are more than a shape: cards with wrapped words, dimension lines.
//!
//! Stands on: `symbols`, `canvas`, `text`. Never knows: the sheet they stand on.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, Words};
use crate::mark::Side;
use crate::panels::symbols;
use crate::{Colour, Dash, palette, text};

/// Size of a card's bold line.
const TITLE: f64 = 6.6;
/// Size of a card's words.
const WORDS: f64 = 5.4;
/// Height of a line of a card's words.
const LEADING: f64 = 6.4;
/// Between a card's rim and its words.
const RIM: f64 = 2.0;
/// Line width of a dimension.
const LINE: f64 = 0.6;
/// Length of a dimension's heads.
const HEAD: f64 = 4.0;
/// Half length of a dimension's bars.
const BAR: f64 = 2.5;

/// A rectangle with a bold line and small words under it, wrapped to its width.
pub fn card(canvas: &mut Canvas, area: Area, title: &str, words: &str, fill: Colour) {
    canvas.filled(area, fill, 1.0);
    canvas.outline(area, LINE, palette::INK);
    let room = area.width() - 2.0 * RIM;
    let (heads, lines) = (wrapped(title, room, TITLE * text::BOLD), wrapped(words, room, WORDS));
    let high = (heads.len() + lines.len()) as f64 * LEADING;
    let (x, top) = (area.centre()[0], area.centre()[1] - 0.5 * high + 0.5 * LEADING);
    let at = |line: usize| [x, top + line as f64 * LEADING];
    for (i, line) in heads.iter().enumerate() {
        let (text, side) = (line.clone(), Side::Centre);
        let bold = Words { at: at(i), text, size: TITLE, side, upright: false, bold: true, colour: palette::INK };
        canvas.items.push(Item::Text(bold));
    }
    for (i, line) in lines.iter().enumerate() {
        canvas.words(at(heads.len() + i), line, WORDS, Side::Centre, palette::INK);
    }
}

/// A line with a bar and a head at each end.
pub fn dimension(canvas: &mut Canvas, from: Point2, to: Point2) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]).max(f64::MIN_POSITIVE);
    let across = [-way[1] / length * BAR, way[0] / length * BAR];
    canvas.path(vec![from, to], LINE, Dash::Solid, palette::INK);
    for (end, other) in [(to, from), (from, to)] {
        canvas.segment(
            [end[0] - across[0], end[1] - across[1]],
            [end[0] + across[0], end[1] + across[1]],
            LINE,
            palette::INK,
        );
        if length > 2.5 * HEAD {
            let points = symbols::arrow_head(other, end, HEAD);
            canvas.items.push(Item::Polygon { points, colour: palette::INK, opacity: 1.0 });
        }
    }
}

/// Words in lines no wider than `room`, broken at spaces; a word that is wider alone has a line of its own.
fn wrapped(words: &str, room: f64, size: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if text::width(line, size) + text::width(&format!(" {word}"), size) <= room => {
                *line = format!("{line} {word}");
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapped_lines_hold_all_words_and_none_is_too_wide() {
        let words = "a film becomes the markers' places in pixels";
        let lines = wrapped(words, 60.0, WORDS);
        assert_eq!(lines.join(" "), words);
        assert!(lines.len() > 1 && lines.iter().all(|l| text::width(l, WORDS) <= 60.0), "{lines:?}");
    }

    #[test]
    fn a_short_dimension_has_bars_and_no_heads() {
        let heads = |length: f64| {
            let mut canvas = Canvas::default();
            dimension(&mut canvas, [0.0, 0.0], [length, 0.0]);
            canvas.items.iter().filter(|i| matches!(i, Item::Polygon { .. })).count()
        };
        assert_eq!((heads(5.0), heads(40.0)), (0, 2));
    }
}
