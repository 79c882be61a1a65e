//! Legends: one entry for each labelled mark, in an empty corner of the frame, or over the frame.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, TextItem};
use crate::frame::SMALL;
use crate::mark::{Mark, Shape, Side};
use crate::mark_painter::draw_marker;
use crate::{palette, text};

/// Length of a sample line.
const SAMPLE: f64 = 13.0;
/// Between sample and label.
const GAP: f64 = 3.0;
/// Height of a line.
const LINE: f64 = 8.6;
/// Between two entries of a line.
const BETWEEN: f64 = 8.0;
/// Between the legend and the frame or the data.
const CLEAR: f64 = 3.0;

/// The marks that are listed.
pub(crate) fn listed_marks(marks: &[Mark]) -> Vec<&Mark> {
    marks.iter().filter(|m| m.label.is_some()).collect()
}

fn mark_label(mark: &Mark) -> &str {
    mark.label.as_deref().unwrap_or("")
}

fn entry_width(mark: &Mark) -> f64 {
    SAMPLE + GAP + text::width(mark_label(mark), SMALL)
}

/// The first place in a frame where the legend covers nothing that is drawn.
pub(crate) fn free_place(entries: &[&Mark], frame: Area, drawn: &Canvas) -> Option<Area> {
    let width = entries.iter().map(|m| entry_width(m)).fold(0.0, f64::max);
    let size = [width, entries.len() as f64 * LINE];
    let inner = frame.grown(-CLEAR);
    let free = [inner.width() - size[0], inner.height() - size[1]];
    if free[0] < 0.0 || free[1] < 0.0 {
        return None;
    }
    // corners first, then the middles of the sides; the right upper corner is the usual place
    let fractions = [[1.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0], [0.5, 1.0], [1.0, 0.5], [0.0, 0.5]];
    let area_at = |f: &Point2| Area::new([inner.from[0] + f[0] * free[0], inner.from[1] + f[1] * free[1]], size);
    fractions.iter().map(area_at).find(|area| !drawn.touches_area(&area.grown(0.8 * CLEAR)))
}

/// Draws the entries under each other.
pub(crate) fn draw_inside(canvas: &mut Canvas, entries: &[&Mark], area: Area) {
    if entries.is_empty() {
        return;
    }
    canvas.fill_area(area.grown(1.0), palette::PAPER, 0.85);
    for (i, mark) in entries.iter().enumerate() {
        draw_entry(canvas, mark, [area.from[0], area.from[1] + (i as f64 + 0.5) * LINE]);
    }
}

/// The entries in lines that fit a width: how many go into each.
fn entries_per_line(entries: &[&Mark], width: f64) -> Vec<usize> {
    let mut lines = vec![0];
    let mut used = 0.0;
    for mark in entries {
        let wide = entry_width(mark) + BETWEEN;
        if used > 0.0 && used + wide - BETWEEN > width {
            lines.push(0);
            used = 0.0;
        }
        used += wide;
        if let Some(last) = lines.last_mut() {
            *last += 1;
        }
    }
    lines
}

/// The height that the legend takes over a frame of this width.
pub(crate) fn height_over(entries: &[&Mark], width: f64) -> f64 {
    if entries.is_empty() { 0.0 } else { entries_per_line(entries, width).len() as f64 * LINE + CLEAR - 1.0 }
}

/// Draws the entries over a frame, beginning at its left side.
pub(crate) fn draw_over(canvas: &mut Canvas, entries: &[&Mark], frame: Area) {
    let lines = entries_per_line(entries, frame.width());
    let top = frame.from[1] - CLEAR + 1.0 - lines.len() as f64 * LINE;
    let mut remaining = entries;
    for (row, count) in lines.into_iter().enumerate() {
        let (now, later) = remaining.split_at(count);
        let mut x = frame.from[0];
        for mark in now {
            draw_entry(canvas, mark, [x, top + (row as f64 + 0.5) * LINE]);
            x += entry_width(mark) + BETWEEN;
        }
        remaining = later;
    }
}

/// One entry; `left_end` is the left end of its middle line.
fn draw_entry(canvas: &mut Canvas, mark: &Mark, left_end: Point2) {
    let middle = [left_end[0] + 0.5 * SAMPLE, left_end[1]];
    match &mark.shape {
        Shape::Points { marker, .. } => draw_marker(canvas, &mark.clone().sized(mark.size.min(6.0)), middle, *marker),
        Shape::Band { .. } | Shape::Area(_) | Shape::Span(..) => {
            let swatch = Area { from: [left_end[0], left_end[1] - 2.6], to: [left_end[0] + SAMPLE, left_end[1] + 2.6] };
            canvas.fill_area(swatch, mark.colour, mark.opacity);
        }
        Shape::Text { .. } => {}
        Shape::Line(_) | Shape::HorizontalLine(_) | Shape::VerticalLine(_) => line_sample(canvas, mark, left_end),
    }
    canvas
        .draw_text(TextItem::new([left_end[0] + SAMPLE + GAP, left_end[1]], mark_label(mark), SMALL).side(Side::Right));
}

/// A sample of the mark's line, with a dark outline when it has the colour of the paper.
fn line_sample(canvas: &mut Canvas, mark: &Mark, at: Point2) {
    let points = vec![at, [at[0] + SAMPLE, at[1]]];
    let Mark { size: width, dash, colour, opacity, .. } = *mark;
    if colour == palette::PAPER {
        let outline = Item::Path { points: points.clone(), width: width + 0.9, dash, colour: palette::BLACK, opacity };
        canvas.items.push(outline);
    }
    canvas.items.push(Item::Path { points, width, dash, colour, opacity });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Colour, Dash};

    const FRAME: Area = Area { from: [0.0, 0.0], to: [200.0, 100.0] };

    fn mark(label: &str) -> Mark {
        Mark::line(vec![], Colour(0, 0, 0)).labelled(label)
    }

    #[test]
    fn a_legend_is_placed_where_no_line_passes() {
        let (a, b) = (mark("measured"), mark("simulated"));
        let mut drawn = Canvas::default();
        drawn.draw_path(vec![[0.0, 90.0], [190.0, 0.0]], 1.0, Dash::Solid, Colour(0, 0, 0));
        let place = free_place(&[&a, &b], FRAME, &drawn).unwrap();
        assert!(!drawn.touches_area(&place));
        assert!(place.to[0] < 100.0, "the line ends in the right upper corner, so the left one is taken");
    }

    #[test]
    fn a_full_frame_leaves_no_place() {
        let a = mark("measured");
        let mut drawn = Canvas::default();
        drawn.fill_area(FRAME, Colour(0, 0, 0), 1.0);
        assert!(free_place(&[&a], FRAME, &drawn).is_none());
    }

    #[test]
    fn entries_that_are_too_wide_for_one_line_take_two() {
        let marks = ["one", "two", "three", "four"].map(mark);
        let entries: Vec<&Mark> = marks.iter().collect();
        assert_eq!(entries_per_line(&entries, 1000.0), vec![4]);
        assert_eq!(entries_per_line(&entries, 90.0), vec![2, 2]);
    }

    #[test]
    fn a_legend_inside_takes_a_line_an_entry() {
        let (a, b) = (mark("measured"), mark("simulated"));
        let place = free_place(&[&a, &b], FRAME, &Canvas::default()).unwrap();
        assert!((place.height() - 2.0 * LINE).abs() < 1e-12);
    }

    #[test]
    fn a_legend_over_a_frame_keeps_to_its_height() {
        let (a, b) = (mark("measured in the tank"), mark("simulated with the drag of the tank"));
        let (frame, entries) = (Area { from: [0.0, 100.0], to: [100.0, 200.0] }, [&a, &b]);
        let mut canvas = Canvas::default();
        draw_over(&mut canvas, &entries, frame);
        let upper = 100.0 - height_over(&entries, 100.0);
        let between = |from: f64, to: f64| Area { from: [-500.0, from], to: [500.0, to] };
        assert!(
            !canvas.touches_area(&between(0.0, upper)) && !canvas.touches_area(&between(100.0 - CLEAR + 1.0, 300.0))
        );
        assert!(
            canvas.touches_area(&between(upper, upper + LINE)) && canvas.touches_area(&between(upper + LINE, 100.0))
        );
    }
}
