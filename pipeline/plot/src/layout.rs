//! Layout: a figure's panels become cells and frames on a page, which is written as SVG.
//!
//! Frames whose cells begin at the same x share their left margin, those whose cells end at the same x their right one,
//! and those of one row their upper and lower ones, so that frames are aligned. A legend without a free corner moves over
//! its frame; the margins are then computed again, until no legend moves.

use si::Point2;

use crate::canvas::{Area, Canvas, POINTS_PER_MM, TextItem};
use crate::figure::{Figure, Placed, SVG_BYTES_LIMIT};
use crate::frame::{NORMAL, SMALL};
use crate::panel::{Draw, LegendPlacement, Margins};
use crate::text::wrap_text;
use crate::{PlotError, Side, palette, svg};

/// Between two rows or columns.
const GUTTER: f64 = 9.0;
/// Height of a panel's label and title.
const HEADER: f64 = 11.0;
/// Font size of panel labels.
const LABEL_SIZE: f64 = 8.0;
/// Least left margin at which a panel's label does not overlap a legend over the frame.
const LABEL_CLEARANCE: f64 = 17.0;
/// Around the whole figure.
const EDGE: f64 = 1.5;
/// Least side of a frame, mm.
const LEAST_MM: f64 = 5.0;

/// A panel with its cell on the page.
struct PanelLayout<'a> {
    placed: &'a Placed,
    row: usize,
    label: Option<String>,
    cell: Area,
    header: f64,
    legend: LegendPlacement,
}

impl Figure {
    /// The figure as SVG text. The same figure gives the same bytes.
    ///
    /// # Errors
    /// [`PlotError`] when an axis cannot show a number, a frame is too small, or the text is above [`SVG_BYTES_LIMIT`].
    pub fn svg(&self) -> Result<String, PlotError> {
        let text = match &self.animation {
            Some(animation) => animation.svg()?,
            None => {
                let mut canvas = Canvas::default();
                let page = draw_figure(self, &mut canvas)?;
                svg::write_svg(&canvas, page)?
            }
        };
        match text.len() {
            bytes if bytes > SVG_BYTES_LIMIT => Err(PlotError::TooLarge { bytes, limit: SVG_BYTES_LIMIT }),
            _ => Ok(text),
        }
    }
}

/// Draws a figure and returns the size of its page, in points of print.
fn draw_figure(figure: &Figure, canvas: &mut Canvas) -> Result<Point2, PlotError> {
    let mut layouts = panel_layouts(figure)?;
    for layout in &layouts {
        layout.as_drawable().check_content()?;
    }
    // each pass moves at least one legend over its frame and none back, so the loop ends
    let frames = loop {
        let frames = panel_frames(&layouts)?;
        let mut legend_moved = false;
        for (layout, frame) in layouts.iter_mut().zip(&frames) {
            if layout.legend == LegendPlacement::Inside && !layout.as_drawable().legend_fits(*frame)? {
                layout.legend = LegendPlacement::Over;
                legend_moved = true;
            }
        }
        if !legend_moved {
            break frames;
        }
    };
    for (layout, frame) in layouts.iter().zip(frames) {
        layout.as_drawable().draw_panel(canvas, frame, layout.legend)?;
        layout.draw_header(canvas);
    }
    Ok(draw_title_and_note(figure, canvas, layouts.iter().map(|s| s.cell.to[1]).fold(0.0, f64::max)))
}

/// Title and note of the figure; returns the page's size.
fn draw_title_and_note(figure: &Figure, canvas: &mut Canvas, bottom: f64) -> Point2 {
    let width = figure.width_mm * POINTS_PER_MM;
    if let Some(title) = &figure.title {
        canvas.draw_text(bold_text([EDGE, EDGE + 0.5 * HEADER], title));
    }
    let Some(note) = &figure.note else { return [width, bottom + EDGE] };
    let lines = wrap_text(note, width - 2.0 * EDGE, SMALL);
    for (k, line) in lines.iter().enumerate() {
        let text = TextItem::new([width - EDGE, bottom + (k as f64 + 0.5) * NORMAL + 2.0], line, SMALL);
        canvas.draw_text(text.side(Side::Left).colour(palette::MUTED));
    }
    [width, bottom + lines.len() as f64 * NORMAL + 2.0 + EDGE]
}

fn bold_text(at: Point2, text: &str) -> TextItem {
    TextItem::new(at, text, LABEL_SIZE).side(Side::Right).bold()
}

/// Cells and labels of all panels, row after row.
fn panel_layouts(figure: &Figure) -> Result<Vec<PanelLayout<'_>>, PlotError> {
    if figure.rows.iter().any(|r| r.panels.is_empty()) || figure.rows.is_empty() {
        return Err(PlotError::Empty {
            what: if figure.rows.is_empty() { "the figure" } else { "a row of the figure" },
        });
    }
    let single = figure.rows.iter().map(|r| r.panels.len()).sum::<usize>() == 1;
    let mut letters = 'a'..='z';
    let mut layouts = Vec::new();
    let mut y = EDGE + if figure.title.is_some() { HEADER } else { 0.0 };
    for (index, row) in figure.rows.iter().enumerate() {
        let height = row.height_mm * POINTS_PER_MM;
        let headed = row.panels.iter().any(|p| p.title.is_some() || (p.has_panel_label && !single));
        let header = if headed { HEADER } else { 0.0 };
        let shares: f64 = row.panels.iter().map(|p| p.share).sum();
        let width_of_cells = figure.width_mm * POINTS_PER_MM - 2.0 * EDGE - GUTTER * (row.panels.len() - 1) as f64;
        let mut x = EDGE;
        for placed in &row.panels {
            let label = (placed.has_panel_label && !single).then(|| letters.next()).flatten().map(|l| format!("({l})"));
            let width = width_of_cells * placed.share / shares;
            let cell = Area::new([x, y], [width, height]);
            layouts.push(PanelLayout { placed, row: index, label, cell, header, legend: LegendPlacement::Inside });
            x += width + GUTTER;
        }
        y += height + GUTTER;
    }
    Ok(layouts)
}

/// The frames of all panels, with shared margins where cells begin or end at the same x.
fn panel_frames(layouts: &[PanelLayout]) -> Result<Vec<Area>, PlotError> {
    let own_margins: Vec<_> = layouts.iter().map(PanelLayout::panel_margins).collect::<Result<_, _>>()?;
    let widest = |side: fn(&Margins) -> f64, together: &dyn Fn(&PanelLayout) -> bool| {
        let panels = layouts.iter().zip(&own_margins).filter(|(s, _)| together(s));
        panels.filter_map(|(_, m)| m.as_ref()).map(side).fold(0.0, f64::max)
    };
    let is_same = |a: f64, b: f64| (a - b).abs() < 0.5;
    let frame = |(index, layout): (usize, &PanelLayout)| {
        let body = layout.cell_body();
        let Some(alone) = own_margins[index] else { return Ok(body) };
        let margins = Margins {
            left: widest(|m| m.left, &|s| is_same(s.cell.from[0], layout.cell.from[0])),
            right: widest(|m| m.right, &|s| is_same(s.cell.to[0], layout.cell.to[0])),
            top: widest(|m| m.top, &|s| s.row == layout.row),
            bottom: widest(|m| m.bottom, &|s| s.row == layout.row),
            beyond: alone.beyond,
        };
        let from = [body.from[0] + margins.left, body.from[1] + margins.top];
        check_frame(
            index,
            Area { from, to: [body.to[0] - margins.right - margins.beyond, body.to[1] - margins.bottom] },
        )
    };
    layouts.iter().enumerate().map(frame).collect()
}

/// Refuses a frame below the least size.
fn check_frame(index: usize, frame: Area) -> Result<Area, PlotError> {
    let [width, height] = [frame.width(), frame.height()].map(|v| v / POINTS_PER_MM);
    match width.min(height) < LEAST_MM {
        true => Err(PlotError::TooSmall { panel: index + 1, width, height, least: LEAST_MM }),
        false => Ok(frame),
    }
}

impl PanelLayout<'_> {
    fn as_drawable(&self) -> &dyn Draw {
        self.placed.panel.as_draw()
    }

    /// The margins of the frame; a legend over the frame is placed beside the panel's label when there is no title.
    fn panel_margins(&self) -> Result<Option<Margins>, PlotError> {
        let is_beside_label = self.legend == LegendPlacement::Over && self.placed.title.is_none();
        let raised = |m: Margins| match is_beside_label && m.left > LABEL_CLEARANCE {
            true => Margins { top: (m.top - self.header).max(0.5 * SMALL), ..m },
            false => m,
        };
        Ok(self.as_drawable().frame_margins(self.cell_body(), self.legend)?.map(raised))
    }

    /// The cell without its header.
    fn cell_body(&self) -> Area {
        Area { from: [self.cell.from[0], self.cell.from[1] + self.header], to: self.cell.to }
    }

    fn draw_header(&self, canvas: &mut Canvas) {
        let mut position = [self.cell.from[0], self.cell.from[1] + 0.4 * HEADER];
        if let Some(label) = &self.label {
            let label = bold_text(position, label);
            position[0] = label.text_area().to[0] + 4.0;
            canvas.draw_text(label);
        }
        if let Some(title) = &self.placed.title {
            canvas.draw_text(TextItem::new(position, title, NORMAL).side(Side::Right));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Item;
    use crate::{Axes, Axis, DOUBLE_COLUMN_MM, Legend, Mark, Panel, SINGLE_COLUMN_MM};

    fn axes(unit: &str, scale: f64) -> Axes {
        let line = |lag: f64| (0..90).map(|i| 0.1 * f64::from(i)).map(|x| [x, scale * (x - lag).sin()]).collect();
        Axes::new(Axis::linear("time", "s"), Axis::linear("a rather long name", unit))
            .with(Mark::line(line(0.0), palette::MEASURED).labelled("measured"))
            .with(Mark::line(line(0.4), palette::SIMULATED).labelled("simulated"))
    }

    fn texts(figure: &Figure) -> (Point2, Vec<TextItem>) {
        let mut canvas = Canvas::default();
        let page = draw_figure(figure, &mut canvas).unwrap();
        let text = |item: Item| if let Item::Text(text) = item { Some(text) } else { None };
        (page, canvas.items.into_iter().filter_map(text).collect())
    }

    fn four_panels() -> Figure {
        let over = |unit, scale| Panel::Axes(axes(unit, scale).legend(Legend::Over));
        Figure::new(DOUBLE_COLUMN_MM)
            .titled("everything at once")
            .row(40.0, [over("mm", 1e-4), over("N", 2e5)])
            .row(40.0, [over("mbar", 250.0).titled("a title"), Panel::Axes(axes("V", 1.0)).titled("another")])
            .noted(&"a note that is longer than a line of the figure, ".repeat(6))
    }

    #[test]
    fn no_two_texts_of_a_figure_overlap() {
        let (_, texts) = texts(&four_panels());
        for (i, a) in texts.iter().enumerate() {
            for b in &texts[i + 1..] {
                assert!(!a.text_area().intersects(&b.text_area()), "`{}` and `{}`", a.text, b.text);
            }
        }
    }

    #[test]
    fn every_text_lies_on_the_page() {
        let (page, texts) = texts(&four_panels());
        let paper = Area { from: [0.0; 2], to: page };
        for text in texts {
            let area = text.text_area();
            assert!(paper.contains(area.from) && paper.contains(area.to), "`{}` at {area:?} of {page:?}", text.text);
        }
    }

    #[test]
    fn frames_of_a_column_are_aligned() {
        let figure = Figure::new(SINGLE_COLUMN_MM)
            .row(40.0, [Panel::Axes(axes("mm", 1e-4))])
            .row(40.0, [Panel::Axes(axes("mm", 1.0))]);
        let layouts = panel_layouts(&figure).unwrap();
        let frames = panel_frames(&layouts).unwrap();
        assert_eq!((frames[0].from[0], frames[0].to[0]), (frames[1].from[0], frames[1].to[0]));
    }

    #[test]
    fn panels_are_labelled_in_reading_order_and_a_single_one_is_not() {
        let (_, texts) = texts(&four_panels());
        let letters: Vec<_> = texts.iter().filter(|t| t.bold && t.text.starts_with('(')).map(|t| &t.text).collect();
        assert_eq!(letters, ["(a)", "(b)", "(c)", "(d)"]);
        let single = Figure::new(SINGLE_COLUMN_MM).row(40.0, [Panel::Axes(axes("mm", 1.0))]);
        assert!(panel_layouts(&single).unwrap()[0].label.is_none());
    }
}
