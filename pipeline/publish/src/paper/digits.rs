//! Digits: a decimal or a percentage in the prose must be computed (`#num`) or marked as from a source (`#said[…]`).

use super::scan;
use super::{Page, Problem};

/// Every number typed by hand in a section.
pub(crate) fn typed_by_hand(page: &Page) -> Vec<Problem> {
    if page.name.ends_with("layout.typ") {
        return Vec::new();
    }
    let prose = prose_text(&page.text);
    let problem = |position: usize| Problem {
        page: page.name.clone(),
        line: scan::line_number(&prose, position),
        what: format!(
            "`{}` is typed by hand: take it from #num(…), or #said[…] if a source has it",
            number_token(&prose, position)
        ),
    };
    number_starts(&prose).into_iter().map(problem).collect()
}

/// The page with strings, formulae, comments and `#said` blanked, line for line.
fn prose_text(text: &str) -> String {
    let mut prose = String::with_capacity(text.len());
    let mut remainder = text;
    while let Some(c) = remainder.chars().next() {
        let skipped = match c {
            '"' | '$' => remainder[1..].find(c).map(|end| end + 2),
            '/' if remainder.starts_with("//") && !prose.ends_with(':') => {
                Some(remainder.find('\n').unwrap_or(remainder.len()))
            }
            '#' if remainder.starts_with("#said[") => scan::block_inside(remainder, 5).map(|(_, end)| end),
            _ => None,
        };
        let length = skipped.unwrap_or(c.len_utf8());
        match skipped {
            Some(length) => prose.extend(remainder[..length].chars().filter(|c| *c == '\n')),
            None => prose.push(c),
        }
        remainder = &remainder[length..];
    }
    prose
}

/// Where a decimal or a percentage begins.
fn number_starts(prose: &str) -> Vec<usize> {
    let bytes = prose.as_bytes();
    let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    let starts = (0..bytes.len()).filter(|&i| digit(i) && (i == 0 || !(digit(i - 1) || bytes[i - 1] == b'.')));
    let needs_source = |&i: &usize| {
        let end = (i..).find(|&k| !digit(k)).unwrap_or(i);
        let decimal = bytes.get(end) == Some(&b'.') && digit(end + 1);
        let free_standing = i == 0 || !(bytes[i - 1].is_ascii_alphanumeric() || bytes[i - 1] == b'_');
        free_standing && (decimal || prose[end..].trim_start_matches([' ', '~']).starts_with('%'))
    };
    starts.filter(needs_source).collect()
}

fn number_token(prose: &str, start: usize) -> String {
    prose[start..].chars().take_while(|c| !c.is_whitespace() && !"],;".contains(*c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_and_percentages_in_prose_are_found_and_counts_are_not() {
        assert_eq!(number_starts("nine or 12 cells, 2.5 mm, 3 % and 10~%").len(), 3);
    }

    #[test]
    fn a_number_begins_at_its_first_digit_and_not_within_a_word_or_a_number() {
        assert_eq!(number_starts("12.5 and 3 %"), [0, 9]);
        assert!(number_starts("v1.2 mesh_2.5 1.2.3").iter().all(|&at| at == 14));
        assert_eq!(number_starts("1.2.3"), [0]);
    }

    #[test]
    fn an_address_is_no_comment() {
        assert_eq!(number_starts(&prose_text("see http://a.b 2.5")).len(), 1);
        assert!(number_starts(&prose_text("see // a.b 2.5")).is_empty());
    }

    #[test]
    fn a_number_typed_by_hand_is_named_with_its_line() {
        let page = Page { name: "a.typ".into(), text: "one\nof 2.5mm, all".into() };
        let found = typed_by_hand(&page);
        assert_eq!((found.len(), found[0].line), (1, 2));
        assert!(found[0].what.starts_with("`2.5mm` is typed by hand"), "{}", found[0].what);
    }

    #[test]
    fn strings_formulae_comments_and_what_is_said_are_no_prose() {
        assert!(number_starts(&prose_text("#num(\"a.1.5\") $0.5$ #said[2.5] // 3.1\n")).is_empty());
        assert_eq!(prose_text("$a\nb$\nx"), "\n\nx");
    }

    #[test]
    fn the_layout_may_set_its_own_lengths() {
        let layout = Page { name: "layout.typ".into(), text: "#set text(9.5pt)".into() };
        assert!(typed_by_hand(&layout).is_empty());
    }
}
