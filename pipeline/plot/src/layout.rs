//! Layout: cells for panels, shared margins so that frames line up, letters, and legends that cover no data.
//!
//! Frames whose cells begin at the same place share their left margin, those that end together their right one, and
//! those of one row their upper and lower ones. A legend that finds no free corner moves over its frame, and the
//! margins are found again.
//!
//! Stands on: `figure`, `panel`. Never knows: what a panel shows.

use si::Point2;

use crate::canvas::{Area, Canvas, Item, POINTS_PER_MM, Words};
use crate::figure::{Figure, Placed};
use crate::frame::{NORMAL, SMALL};
use crate::panel::{Draw, Margins, Where};
use crate::{PlotError, Side, palette};

/// Between two rows or columns.
const GUTTER: f64 = 9.0;
/// Room for letter and title over a panel.
const HEADER: f64 = 11.0;
/// Size of letters.
const LETTER: f64 = 8.0;
/// Room before a frame in which a letter stands clear of a legend.
const LETTER_ROOM: f64 = 17.0;
/// Around the whole figure.
const EDGE: f64 = 1.5;
/// Least side of a frame, mm.
const LEAST_MM: f64 = 5.0;

/// One panel on its way to the page.
struct Seat<'a> {
    placed: &'a Placed,
    row: usize,
    letter: Option<String>,
    cell: Area,
    header: f64,
    legend: Where,
}

/// Draws a figure and returns the size of its page, in points of print.
pub fn draw(figure: &Figure, canvas: &mut Canvas) -> Result<Point2, PlotError> {
    let mut seats = seats(figure)?;
    for seat in &seats {
        seat.draw().check()?;
    }
    let frames = loop {
        let frames = frames(&seats)?;
        let mut moved = false;
        for (seat, frame) in seats.iter_mut().zip(&frames) {
            if seat.legend == Where::Inside && !seat.draw().legend_fits(*frame)? {
                seat.legend = Where::Over;
                moved = true;
            }
        }
        if !moved {
            break frames;
        }
    };
    for (seat, frame) in seats.iter().zip(frames) {
        seat.draw().draw(canvas, frame, seat.legend)?;
        seat.draw_header(canvas);
    }
    Ok(draw_rim(figure, canvas, seats.iter().map(|s| s.cell.to[1]).fold(0.0, f64::max)))
}

/// Title and note of the figure; returns the page's size.
fn draw_rim(figure: &Figure, canvas: &mut Canvas, bottom: f64) -> Point2 {
    let width = figure.width_mm * POINTS_PER_MM;
    if let Some(title) = &figure.title {
        canvas.items.push(Item::Text(bold([EDGE, EDGE + 0.5 * HEADER], title)));
    }
    let Some(note) = &figure.note else { return [width, bottom + EDGE] };
    canvas.words([width - EDGE, bottom + 0.5 * NORMAL + 2.0], note, SMALL, Side::Left, palette::MUTED);
    [width, bottom + NORMAL + 2.0 + EDGE]
}

fn bold(at: Point2, text: &str) -> Words {
    let (text, side) = (text.to_owned(), Side::Right);
    Words { at, text, size: LETTER, side, upright: false, bold: true, colour: palette::INK }
}

/// Cells and letters of all panels, row after row.
fn seats(figure: &Figure) -> Result<Vec<Seat<'_>>, PlotError> {
    if figure.rows.iter().any(|r| r.panels.is_empty()) || figure.rows.is_empty() {
        return Err(PlotError::Empty {
            what: if figure.rows.is_empty() { "the figure" } else { "a row of the figure" },
        });
    }
    let single = figure.rows.iter().map(|r| r.panels.len()).sum::<usize>() == 1;
    let mut letters = 'a'..='z';
    let mut seats = Vec::new();
    let mut y = EDGE + if figure.title.is_some() { HEADER } else { 0.0 };
    for (index, row) in figure.rows.iter().enumerate() {
        let height = row.height_mm * POINTS_PER_MM;
        let headed = row.panels.iter().any(|p| p.title.is_some() || (p.lettered && !single));
        let header = if headed { HEADER } else { 0.0 };
        let shares: f64 = row.panels.iter().map(|p| p.share).sum();
        let room = figure.width_mm * POINTS_PER_MM - 2.0 * EDGE - GUTTER * (row.panels.len() - 1) as f64;
        let mut x = EDGE;
        for placed in &row.panels {
            let letter = (placed.lettered && !single).then(|| letters.next()).flatten().map(|l| format!("({l})"));
            let width = room * placed.share / shares;
            let cell = Area::new([x, y], [width, height]);
            seats.push(Seat { placed, row: index, letter, cell, header, legend: Where::Inside });
            x += width + GUTTER;
        }
        y += height + GUTTER;
    }
    Ok(seats)
}

/// The frames of all seats, with margins shared where cells begin or end together.
fn frames(seats: &[Seat]) -> Result<Vec<Area>, PlotError> {
    let own: Vec<_> = seats.iter().map(Seat::margins).collect::<Result<_, _>>()?;
    let widest = |side: fn(&Margins) -> f64, together: &dyn Fn(&Seat) -> bool| {
        let with = seats.iter().zip(&own).filter(|(s, _)| together(s));
        with.filter_map(|(_, m)| m.as_ref()).map(side).fold(0.0, f64::max)
    };
    let near = |a: f64, b: f64| (a - b).abs() < 0.5;
    let frame = |(index, seat): (usize, &Seat)| {
        let body = seat.body();
        let Some(alone) = own[index] else { return Ok(body) };
        let margins = Margins {
            left: widest(|m| m.left, &|s| near(s.cell.from[0], seat.cell.from[0])),
            right: widest(|m| m.right, &|s| near(s.cell.to[0], seat.cell.to[0])),
            top: widest(|m| m.top, &|s| s.row == seat.row),
            bottom: widest(|m| m.bottom, &|s| s.row == seat.row),
            beyond: alone.beyond,
        };
        let from = [body.from[0] + margins.left, body.from[1] + margins.top];
        roomy(index, Area { from, to: [body.to[0] - margins.right - margins.beyond, body.to[1] - margins.bottom] })
    };
    seats.iter().enumerate().map(frame).collect()
}

fn roomy(index: usize, frame: Area) -> Result<Area, PlotError> {
    let [width, height] = [frame.width(), frame.height()].map(|v| v / POINTS_PER_MM);
    match width.min(height) < LEAST_MM {
        true => Err(PlotError::TooSmall { panel: index + 1, width, height, least: LEAST_MM }),
        false => Ok(frame),
    }
}

impl Seat<'_> {
    fn draw(&self) -> &dyn Draw {
        self.placed.panel.as_draw()
    }

    /// The room for labels; a legend over the frame stands beside the letter when no title is in its way.
    fn margins(&self) -> Result<Option<Margins>, PlotError> {
        let beside = self.legend == Where::Over && self.placed.title.is_none();
        let raised = |m: Margins| match beside && m.left > LETTER_ROOM {
            true => Margins { top: (m.top - self.header).max(0.5 * SMALL), ..m },
            false => m,
        };
        Ok(self.draw().margins(self.body(), self.legend)?.map(raised))
    }

    /// The cell without its header.
    fn body(&self) -> Area {
        Area { from: [self.cell.from[0], self.cell.from[1] + self.header], to: self.cell.to }
    }

    fn draw_header(&self, canvas: &mut Canvas) {
        let mut at = [self.cell.from[0], self.cell.from[1] + 0.4 * HEADER];
        if let Some(letter) = &self.letter {
            let words = bold(at, letter);
            at[0] = words.area().to[0] + 4.0;
            canvas.items.push(Item::Text(words));
        }
        if let Some(title) = &self.placed.title {
            canvas.words(at, title, NORMAL, Side::Right, palette::INK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axes, Axis, DOUBLE_COLUMN_MM, Legend, Mark, Panel, SINGLE_COLUMN_MM};

    fn axes(unit: &str, scale: f64) -> Axes {
        let line = |lag: f64| (0..90).map(|i| 0.1 * f64::from(i)).map(|x| [x, scale * (x - lag).sin()]).collect();
        Axes::new(Axis::linear("time", "s"), Axis::linear("a rather long name", unit))
            .with(Mark::line(line(0.0), palette::MEASURED).labelled("measured"))
            .with(Mark::line(line(0.4), palette::SIMULATED).labelled("simulated"))
    }

    fn texts(figure: &Figure) -> (Point2, Vec<Words>) {
        let mut canvas = Canvas::default();
        let page = draw(figure, &mut canvas).unwrap();
        let words = |item: Item| if let Item::Text(words) = item { Some(words) } else { None };
        (page, canvas.items.into_iter().filter_map(words).collect())
    }

    fn crowded() -> Figure {
        let over = |unit, scale| Panel::Axes(axes(unit, scale).legend(Legend::Over));
        Figure::new(DOUBLE_COLUMN_MM)
            .titled("everything at once")
            .row(40.0, [over("mm", 1e-4), over("N", 2e5)])
            .row(40.0, [over("mbar", 250.0).titled("a title"), Panel::Axes(axes("V", 1.0)).titled("another")])
            .noted("virtual bench")
    }

    #[test]
    fn no_two_texts_of_a_figure_overlap() {
        let (_, texts) = texts(&crowded());
        for (i, a) in texts.iter().enumerate() {
            for b in &texts[i + 1..] {
                assert!(!a.area().meets(&b.area()), "`{}` and `{}`", a.text, b.text);
            }
        }
    }

    #[test]
    fn every_text_lies_on_the_page() {
        let (page, texts) = texts(&crowded());
        let paper = Area { from: [0.0; 2], to: page };
        for words in texts {
            let area = words.area();
            assert!(paper.holds(area.from) && paper.holds(area.to), "`{}` at {area:?} of {page:?}", words.text);
        }
    }

    #[test]
    fn frames_of_a_column_line_up() {
        let figure = Figure::new(SINGLE_COLUMN_MM)
            .row(40.0, [Panel::Axes(axes("mm", 1e-4))])
            .row(40.0, [Panel::Axes(axes("mm", 1.0))]);
        let seats = seats(&figure).unwrap();
        let frames = frames(&seats).unwrap();
        assert_eq!((frames[0].from[0], frames[0].to[0]), (frames[1].from[0], frames[1].to[0]));
    }

    #[test]
    fn panels_are_lettered_in_reading_order_and_a_single_one_is_not() {
        let (_, texts) = texts(&crowded());
        let letters: Vec<_> = texts.iter().filter(|w| w.bold && w.text.starts_with('(')).map(|w| &w.text).collect();
        assert_eq!(letters, ["(a)", "(b)", "(c)", "(d)"]);
        let single = Figure::new(SINGLE_COLUMN_MM).row(40.0, [Panel::Axes(axes("mm", 1.0))]);
        assert!(seats(&single).unwrap()[0].letter.is_none());
    }
}
