//! Omission: a sentence about what was not measured is left out, with the references to figures and tables that were not made.
//!
//! While a page is resolved, [`ABSENT`] stands for each number or verdict that is not at hand. A sentence ends at a full stop before a blank, at
//! an empty line, or where its brackets do.

/// Stands in a resolved text for what is not at hand, until its sentence is left out.
pub(super) const ABSENT: char = '\u{1}';

/// The text without the sentences that hold [`ABSENT`], and their number.
pub(super) fn without_absent(text: &str) -> (String, usize) {
    let (mut text, mut count) = (text.to_owned(), 0);
    while let Some(position) = text.find(ABSENT) {
        text.replace_range(sentence_start(&text, position)..sentence_end(&text, position), "");
        count += 1;
    }
    (without_empty_items(&text), count)
}

/// The text with every reference to one of some labels taken out of its parentheses, or with [`ABSENT`] in its place.
pub(super) fn without_references(text: &str, labels: &[String]) -> String {
    labels.iter().fold(text.to_owned(), |text, label| without_reference(&text, &format!("@{label}")))
}

fn without_reference(text: &str, reference: &str) -> String {
    let (mut text, mut from) = (text.to_owned(), 0);
    while let Some(start) = text[from..].find(reference).map(|start| from + start) {
        let end = start + reference.len();
        if text[end..].starts_with(|c: char| c.is_alphanumeric() || c == '_') {
            from = end;
            continue;
        }
        match parenthesis_around(&text, start) {
            Some((open, close)) => {
                let others = text[open + 1..close].split(',').map(str::trim).filter(|other| *other != reference);
                let others = others.collect::<Vec<_>>().join(", ");
                let kept = if others.is_empty() { String::new() } else { format!(" ({others})") };
                let open = text[..open].trim_end().len();
                text.replace_range(open..=close, &kept);
            }
            None => text.replace_range(start..end, &ABSENT.to_string()),
        }
    }
    text
}

/// The parentheses around a reference that hold nothing but references.
fn parenthesis_around(text: &str, position: usize) -> Option<(usize, usize)> {
    let (open, close) = (text[..position].rfind('(')?, position + text[position..].find(')')?);
    let references = text[open + 1..close].split(',').all(|part| {
        part.trim().strip_prefix('@').is_some_and(|key| key.chars().all(|c| c.is_alphanumeric() || "_:-".contains(c)))
    });
    references.then_some((open, close))
}

fn sentence_start(text: &str, position: usize) -> usize {
    let mut depth = 0_usize;
    for (i, c) in text[..position].char_indices().rev() {
        let rest = &text[i..];
        match c {
            ']' => depth += 1,
            '[' if depth == 0 => return i + 1,
            '[' => depth -= 1,
            '\n' if depth == 0 && rest.starts_with("\n\n") => return i + 2,
            '\n' if depth == 0 && rest.starts_with("\n- ") => return i + 3,
            c if depth == 0 && c.is_whitespace() && ends_sentence(&text[..i]) => return i + 1,
            _ => {}
        }
    }
    0
}

fn sentence_end(text: &str, position: usize) -> usize {
    let mut depth = 0_usize;
    for (i, c) in text[position..].char_indices().map(|(i, c)| (position + i, c)) {
        let rest = &text[i..];
        match c {
            '[' => depth += 1,
            ']' if depth == 0 => return i,
            ']' => depth -= 1,
            '\n' if depth == 0 && rest.starts_with("\n\n") => return i,
            c if depth == 0 && c.is_whitespace() && ends_sentence(&text[..i]) => return i + c.len_utf8(),
            _ => {}
        }
    }
    text.len()
}

/// A full stop, also of words in bold type and of an equation with its label.
fn ends_sentence(before: &str) -> bool {
    let equation = || before.strip_suffix(">]").and_then(|inside| inside.rsplit_once(" $ <"));
    before.ends_with('.') || before.ends_with(".*") || equation().is_some_and(|(formula, _)| formula.ends_with('.'))
}

/// Items of lists of which nothing is left.
fn without_empty_items(text: &str) -> String {
    let kept: Vec<&str> = text.split('\n').filter(|line| line.trim_end() != "-").collect();
    kept.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(text: &str) -> String {
        without_absent(&text.replace('?', &ABSENT.to_string())).0
    }

    #[test]
    fn a_sentence_is_left_out_and_its_neighbours_stay() {
        assert_eq!(left("One is 1.5 mm. Two is\n? mm, or #[3. x] of it. Three."), "One is 1.5 mm. Three.");
        assert_eq!(left("*Head.* It is ?.\n\nNext."), "*Head.* \n\nNext.");
        assert_eq!(left("It is #eq[$ a = b. $ <eq:a>]\nIt is ?."), "It is #eq[$ a = b. $ <eq:a>]\n");
        assert_eq!(left("#wide(\"a\")[Seen. It is ?.] Text."), "#wide(\"a\")[Seen. ] Text.");
    }

    #[test]
    fn two_numbers_of_one_sentence_are_one_omission() {
        assert_eq!(without_absent(&format!("A {ABSENT} and {ABSENT}. B.")), ("B.".to_owned(), 1));
    }

    #[test]
    fn an_item_without_a_sentence_is_no_item() {
        assert_eq!(left("- ?.\n- two.\n"), "- two.\n");
    }

    #[test]
    fn a_reference_leaves_its_parenthesis_or_takes_its_sentence_with_it() {
        let without = |text: &str| without_absent(&without_references(text, &["fig:a".to_owned()])).0;
        assert_eq!(without("Seen (@fig:a, @tab:b). Text (@fig:a)."), "Seen (@tab:b). Text.");
        assert_eq!(without("@fig:a shows it. Text @fig:ab."), "Text @fig:ab.");
    }
}
