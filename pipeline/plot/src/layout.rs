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
    let own: Vec<_> = seats.iter().map(|s| s.draw().margins(s.body(), s.legend)).collect::<Result<_, _>>()?;
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
