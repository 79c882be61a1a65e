//! Widths of texts, and numbers as text.
//!
//! The viewer chooses the font. Widths are those of DejaVu Sans, the widest font of `svg::FONT_FAMILIES`, so that a
//! text is never wider than its bounding box.

/// Widths of the characters ' ' to '~' in thousandths of the font size.
const WIDTHS: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636, 636, 636, 636,
    636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863,
    748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635,
    615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636,
    337, 636, 838,
];

/// Width of bold text relative to normal text.
pub(crate) const BOLD: f64 = 1.16;

/// The width of a text, in the unit of its font size.
pub fn width(text: &str, size: f64) -> f64 {
    let thousandths = |c: char| match c {
        ' '..='~' => f64::from(WIDTHS[c as usize - 32]),
        '⁰'..='⁻' | '¹' | '²' | '³' | '₀'..='₉' => 420.0,
        '−' | '×' | '±' | '→' | '≤' | '≥' => 838.0,
        '–' | '°' => 500.0,
        '·' => 318.0,
        _ => 660.0,
    };
    text.chars().map(thousandths).sum::<f64>() * size / 1000.0
}

/// A number with fixed digits after the point and a true minus sign.
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// A power of ten as it is printed: 10⁻³.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |d| RAISED[d as usize]);
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Text in lines no wider than `limit`, broken at spaces; a word that is wider has a line of its own.
pub(crate) fn wrap_text(text: &str, limit: f64, size: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if width(line, size) + width(&format!(" {word}"), size) <= limit => {
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
    fn a_text_is_as_wide_as_its_characters() {
        assert!((width("0.5", 10.0) - (6.36 + 3.18 + 6.36)).abs() < 1e-12);
    }

    #[test]
    fn numbers_have_a_true_minus_and_zero_has_none() {
        assert_eq!(number(-1.25, 1), "−1.2");
        assert_eq!(number(-0.001, 1), "0.0");
    }

    #[test]
    fn powers_of_ten_are_raised() {
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }

    #[test]
    fn wrapped_lines_hold_all_words_and_none_is_too_wide() {
        let words = "a film becomes the markers' places in pixels";
        let lines = wrap_text(words, 60.0, 5.4);
        assert_eq!(lines.join(" "), words);
        assert!(lines.len() > 1 && lines.iter().all(|l| width(l, 5.4) <= 60.0), "{lines:?}");
    }

    #[test]
    fn a_line_is_broken_only_before_a_word_that_it_cannot_hold() {
        let lines = wrap_text("a film becomes the markers' places in pixels", 60.0, 5.4);
        for pair in lines.windows(2) {
            let next = pair[1].split(' ').next().unwrap();
            assert!(width(&format!("{} {next}", pair[0]), 5.4) > 60.0, "{lines:?}");
        }
    }
}
