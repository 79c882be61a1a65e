//! Scanner: calls of the additional words in a page, with their arguments and blocks.

/// A call: `#word("name", digits: 2)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call<'a> {
    /// The word.
    pub word: &'a str,
    /// Its first argument; empty where it has none.
    pub name: &'a str,
    /// All its arguments that are names.
    pub names: Vec<&'a str>,
    /// Its `digits`.
    pub digits: Option<usize>,
    /// Where it begins and ends in the page, bytes.
    pub span: (usize, usize),
}

/// The first call of one of `words` at or after `from`.
pub(crate) fn next_call<'a>(text: &'a str, words: &[&'a str], from: usize) -> Option<Call<'a>> {
    let starts = text[from..].match_indices('#').map(|(i, _)| from + i);
    starts.into_iter().find_map(|start| parsed_call(text, words, start))
}

fn parsed_call<'a>(text: &'a str, words: &[&'a str], start: usize) -> Option<Call<'a>> {
    let tail = &text[start + 1..];
    let is_call = |w: &&&str| tail.strip_prefix(**w).is_some_and(|remainder| remainder.starts_with('('));
    let word = words.iter().find(is_call)?;
    let arguments_start = start + 1 + word.len() + 1;
    let end = arguments_start + text[arguments_start..].find(')')?;
    let parts: Vec<&str> = text[arguments_start..end].split(',').map(str::trim).collect();
    let names: Vec<&str> = parts.iter().filter(|p| p.starts_with('"')).map(|p| p.trim_matches('"')).collect();
    let name = names.first().copied().unwrap_or_default();
    let digits = parts.iter().find_map(|p| p.strip_prefix("digits:")).and_then(|n| n.trim().parse().ok());
    Some(Call { word, name, names, digits, span: (start, end + 1) })
}

/// The inside of a block that begins at `from`, and where it ends; nothing where none begins or it never closes.
pub(crate) fn block_inside(text: &str, from: usize) -> Option<(&str, usize)> {
    let mut depth = 0_usize;
    let mut escaped = false;
    for (i, c) in text.get(from..)?.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '[' => depth += 1,
            ']' => depth = depth.checked_sub(1)?,
            _ if depth == 0 => return None,
            _ => {}
        }
        if depth == 0 && c == ']' {
            return Some((&text[from + 1..from + i], from + i + 1));
        }
    }
    None
}

/// The line of a place, from 1.
pub(crate) fn line_number(text: &str, at: usize) -> usize {
    1 + text[..at].matches('\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_is_read_with_its_arguments() {
        let found = next_call("x #other(1) #num(\"a.b\", digits: 2).", &["num", "val"], 0).unwrap();
        assert_eq!((found.word, found.name, found.digits, found.span), ("num", "a.b", Some(2), (12, 34)));
        assert!(next_call("#numbers(\"a\")", &["num"], 0).is_none());
    }

    #[test]
    fn a_block_holds_blocks_and_ends_at_its_own_bracket() {
        assert_eq!(block_inside("[a #b[c] \\] d] e", 0), Some(("a #b[c] \\] d", 14)));
        assert_eq!(block_inside("a", 0), None);
        assert_eq!(block_inside("[a", 0), None);
    }

    #[test]
    fn a_line_is_counted_from_one() {
        assert_eq!(line_number("a\nb\nc", 4), 3);
    }
}
