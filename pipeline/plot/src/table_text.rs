//! Tables as text: CSV for programs, LaTeX (booktabs) for the paper, SVG for the browser.

use crate::canvas::{Canvas, POINTS_PER_MM, TextItem};
use crate::frame::{NORMAL, SMALL};
use crate::table::{Alignment, Column, Table};
use crate::{PlotError, Side, palette, svg, text};

/// What an empty cell shows.
const NONE: &str = "–";
/// Height of a row in the SVG.
const ROW: f64 = 11.0;
/// Between two columns in the SVG.
const APART: f64 = 12.0;
/// Around the SVG.
const EDGE: f64 = 3.0;

impl Table {
    /// Comma-separated values with one head line; a group's head stands before its column's.
    pub fn csv(&self) -> String {
        let head = |c: &Column| match c.group.as_str() {
            "" => c.head(),
            group => format!("{group}: {}", c.head()),
        };
        let line = |cells: Vec<String>| cells.iter().map(|c| quote_cell(c)).collect::<Vec<_>>().join(",") + "\n";
        let rows = self.rows.iter().map(|row| line(row.clone()));
        std::iter::once(line(self.columns.iter().map(head).collect())).chain(rows).collect()
    }

    /// A LaTeX tabular with the rules of booktabs.
    pub fn latex(&self) -> String {
        let letter = |c: &Column| if c.alignment == Alignment::Left { 'l' } else { 'r' };
        let shape: String = self.columns.iter().map(letter).collect();
        let line = |cells: Vec<String>| format!("{} \\\\\n", cells.join(" & "));
        let mut tex = format!("\\begin{{tabular}}{{@{{}}{shape}@{{}}}}\n\\toprule\n");
        if self.columns.iter().any(|c| !c.group.is_empty()) {
            let head = |(head, from, to): &(&str, usize, usize)| match to - from {
                1 => escape_latex(head),
                span => format!("\\multicolumn{{{span}}}{{c}}{{{}}}", escape_latex(head)),
            };
            tex += &line(self.groups().iter().map(head).collect());
            let rule = |(_, from, to): &(&str, usize, usize)| format!("\\cmidrule(lr){{{}-{to}}}", from + 1);
            tex += &self.groups().iter().filter(|g| g.2 - g.1 > 1).map(rule).collect::<Vec<_>>().join(" ");
            tex.push('\n');
        }
        tex += &line(self.columns.iter().map(|c| escape_latex(&c.head())).collect());
        tex += "\\midrule\n";
        for row in &self.rows {
            tex += &line(row.iter().map(|cell| escape_latex(shown_cell(cell))).collect());
        }
        tex + "\\bottomrule\n\\end{tabular}\n"
    }

    /// The table as SVG text, as wide as its cells.
    ///
    /// # Errors
    /// [`PlotError::Encoder`] when plotters refuses.
    pub fn svg(&self) -> Result<String, PlotError> {
        let ends = self.column_ends();
        let right = ends.last().map_or(0.0, |e| e.1);
        let mut canvas = Canvas::default();
        let mut y = EDGE;
        draw_rule(&mut canvas, (EDGE, right), y, 0.9);
        if self.columns.iter().any(|c| !c.group.is_empty()) {
            y += ROW;
            self.draw_groups(&mut canvas, &ends, y);
        }
        y += ROW;
        for (column, end) in self.columns.iter().zip(&ends) {
            canvas.draw_text(cell_text(column, *end, y - 0.5 * ROW, &column.head()).bold());
        }
        draw_rule(&mut canvas, (EDGE, right), y, 0.6);
        for row in &self.rows {
            y += ROW;
            for ((column, end), text) in self.columns.iter().zip(&ends).zip(row) {
                canvas.draw_text(cell_text(column, *end, y - 0.5 * ROW, shown_cell(text)));
            }
        }
        draw_rule(&mut canvas, (EDGE, right), y + 0.5, 0.9);
        if let Some(note) = &self.note {
            y += ROW;
            let text = TextItem::new([EDGE, y - 0.35 * ROW], note, SMALL);
            canvas.draw_text(text.side(Side::Right).colour(palette::MUTED));
        }
        let note = self.note.as_ref().map_or(0.0, |n| text::width(n, SMALL) + EDGE);
        svg::write_svg(&canvas, [right.max(note) + EDGE, y + EDGE + 0.01 * POINTS_PER_MM])
    }

    /// Left and right end of each column's cells, in points of print.
    fn column_ends(&self) -> Vec<(f64, f64)> {
        let mut widths: Vec<f64> = (0..self.columns.len()).map(|i| self.column_width(i)).collect();
        for (head, from, to) in self.groups() {
            let inner: f64 = widths[from..to].iter().sum::<f64>() + APART * (to - from - 1) as f64;
            let more = (text::width(head, NORMAL) * text::BOLD - inner).max(0.0) / (to - from) as f64;
            widths[from..to].iter_mut().for_each(|w| *w += more);
        }
        let next_ends = |x: &mut f64, w: f64| {
            let end = (*x, *x + w);
            *x += w + APART;
            Some(end)
        };
        widths.into_iter().scan(EDGE, next_ends).collect()
    }

    fn column_width(&self, i: usize) -> f64 {
        let head = text::width(&self.columns[i].head(), NORMAL) * text::BOLD;
        self.rows.iter().map(|row| text::width(shown_cell(&row[i]), NORMAL)).fold(head, f64::max)
    }

    fn draw_groups(&self, canvas: &mut Canvas, ends: &[(f64, f64)], y: f64) {
        for (head, from, to) in self.groups().into_iter().filter(|g| !g.0.is_empty()) {
            let (left, right) = (ends[from].0, ends[to - 1].1);
            let position = [0.5 * (left + right), y - 0.5 * ROW];
            canvas.draw_text(TextItem::new(position, head, NORMAL).bold());
            draw_rule(canvas, (left, right), y, 0.4);
        }
    }
}

fn draw_rule(canvas: &mut Canvas, (from, to): (f64, f64), y: f64, width: f64) {
    canvas.draw_segment([from, y], [to, y], width, palette::BLACK);
}

/// The text of a cell, aligned in its column.
fn cell_text(column: &Column, (left, right): (f64, f64), y: f64, text: &str) -> TextItem {
    let colour = if column.published { palette::MUTED } else { palette::BLACK };
    let (x, side) = match column.alignment {
        Alignment::Left => (left, Side::Right),
        Alignment::Right => (right, Side::Left),
    };
    TextItem::new([x, y], text, NORMAL).side(side).colour(colour)
}

fn shown_cell(cell: &str) -> &str {
    if cell.is_empty() { NONE } else { cell }
}

/// A cell of CSV, in quotes when it needs them (RFC 4180).
fn quote_cell(cell: &str) -> String {
    match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_owned(),
    }
}

/// Text with LaTeX's special characters escaped.
fn escape_latex(text: &str) -> String {
    let escape = |c: char| match c {
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{c}"),
        '~' => "\\textasciitilde{}".to_owned(),
        '^' => "\\textasciicircum{}".to_owned(),
        '\\' => "\\textbackslash{}".to_owned(),
        '−' => "$-$".to_owned(),
        '±' => "$\\pm$".to_owned(),
        '×' => "$\\times$".to_owned(),
        '·' => "$\\cdot$".to_owned(),
        '–' => "--".to_owned(),
        _ => c.to_string(),
    };
    text.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let [ours, published] = Column::beside_published("total_time", "min");
        let columns = vec![Column::text("method"), ours, published];
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let rows = vec![row(["Adam, 4 steps", "1.2", "22"]), row(["R&D 50 % \\ {x}", "−3 ± 1", ""])];
        Table::new(columns, rows).unwrap().noted("virtual bench")
    }

    #[test]
    fn latex_escapes_every_special_character() {
        let tex = table().latex();
        assert!(tex.contains("R\\&D 50 \\% \\textbackslash{} \\{x\\} & $-$3 $\\pm$ 1 & -- \\\\"), "{tex}");
        assert!(tex.contains("\\multicolumn{2}{c}{total\\_time}") && tex.contains("\\cmidrule(lr){2-3}"), "{tex}");
    }

    #[test]
    fn csv_quotes_a_cell_with_a_comma() {
        let expected = "method,total_time: ours (min),total_time: published (min)\n\"Adam, 4 steps\",1.2,22\n";
        assert!(table().csv().starts_with(expected));
    }

    #[test]
    fn the_svg_of_a_table_holds_its_cells_as_text() {
        let svg = table().svg().unwrap();
        assert!(svg.contains("Adam, 4 steps</text>") && svg.contains("R&amp;D"), "{svg}");
    }

    #[test]
    fn a_note_makes_the_svg_of_a_table_one_row_higher() {
        let height = |table: &Table| -> f64 {
            let svg = table.svg().unwrap();
            let mm = svg.split_once("height=\"").unwrap().1.split_once("mm").unwrap().0;
            mm.parse::<f64>().unwrap() * POINTS_PER_MM
        };
        let with = table();
        let without = Table { note: None, ..with.clone() };
        assert!((height(&with) - height(&without) - ROW).abs() < 0.1, "{} {}", height(&with), height(&without));
    }

    #[test]
    fn what_latex_would_take_for_a_command_or_does_not_know_is_written_as_a_command() {
        assert_eq!(escape_latex("a_1 × 5 % ± 2·x"), "a\\_1 $\\times$ 5 \\% $\\pm$ 2$\\cdot$x");
        assert_eq!(escape_latex("−1–2 ~ ^ \\"), "$-$1--2 \\textasciitilde{} \\textasciicircum{} \\textbackslash{}");
    }
}
