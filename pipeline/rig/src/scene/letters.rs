//! The label "virtual bench" in every frame, drawn in strokes.

use si::Point2;

use super::Canvas;

/// Strokes of a letter on a grid of 4 × 6, from the top left; each a line from (column, row) to (column, row).
fn letter_strokes(letter: char) -> &'static [[u8; 4]] {
    match letter {
        'A' => &[[0, 6, 2, 0], [2, 0, 4, 6], [1, 4, 3, 4]],
        'B' => &[[0, 0, 0, 6], [0, 0, 3, 0], [3, 0, 3, 3], [0, 3, 4, 3], [4, 3, 4, 6], [0, 6, 4, 6]],
        'C' => &[[4, 0, 0, 0], [0, 0, 0, 6], [0, 6, 4, 6]],
        'E' => &[[4, 0, 0, 0], [0, 0, 0, 6], [0, 6, 4, 6], [0, 3, 3, 3]],
        'H' => &[[0, 0, 0, 6], [4, 0, 4, 6], [0, 3, 4, 3]],
        'I' => &[[2, 0, 2, 6]],
        'L' => &[[0, 0, 0, 6], [0, 6, 4, 6]],
        'N' => &[[0, 6, 0, 0], [0, 0, 4, 6], [4, 6, 4, 0]],
        'R' => &[[0, 6, 0, 0], [0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [2, 3, 4, 6]],
        'T' => &[[0, 0, 4, 0], [2, 0, 2, 6]],
        'U' => &[[0, 0, 0, 6], [0, 6, 4, 6], [4, 6, 4, 0]],
        'V' => &[[0, 0, 2, 6], [2, 6, 4, 0]],
        _ => &[],
    }
}

/// Position and look of a text.
pub(crate) struct Style {
    /// Its top left corner, px.
    pub(crate) at: Point2,
    /// Height of the letters, px.
    pub(crate) size: f64,
    /// Grey level.
    pub(crate) level: f32,
}

/// Writes `text` (capitals).
pub(crate) fn write_text(canvas: &mut Canvas, text: &str, style: &Style) {
    let Style { at, size, level } = *style;
    let unit = size / 6.0;
    for (i, letter) in text.chars().enumerate() {
        let left_edge = at[0] + 6.0 * unit * i as f64;
        let grid_point = |column: u8, row: u8| [left_edge + unit * f64::from(column), at[1] + unit * f64::from(row)];
        for [a, b, c, d] in letter_strokes(letter) {
            canvas.draw_stroke(grid_point(*a, *b), grid_point(*c, *d), 0.9 * unit, level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_the_label_is_drawn() {
        for letter in lab::VIRTUAL_BENCH.to_uppercase().chars().filter(|c| *c != ' ') {
            let mut canvas = Canvas::filled(40, 40, 0.0);
            write_text(&mut canvas, &letter.to_string(), &Style { at: [10.0, 10.0], size: 18.0, level: 1.0 });
            assert!(canvas.levels.iter().sum::<f32>() > 30.0, "{letter}");
        }
    }
}
