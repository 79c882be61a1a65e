//! Lists of numbers and words in a text of YAML, JSON or XML, by their keys.
//!
//! Calibration files are flat: a key, perhaps a table of rows, columns and type, and its numbers, in brackets, in lines that begin with `-`, or in an
//! element. So much is read of each of the three notations, and comments are none of it.

/// Keys of a matrix that may stand before its data.
const BEFORE_DATA: [&str; 6] = ["rows", "cols", "dt", "type_id", "data", "name"];

/// A text without its comments.
pub(super) struct Values {
    text: String,
    is_xml: bool,
}

impl Values {
    pub(super) fn new(text: &str) -> Self {
        let text = text.trim_start_matches('\u{feff}');
        let is_xml = text.trim_start().starts_with('<');
        Self { text: if is_xml { without_remarks(text) } else { without_hashes(text) }, is_xml }
    }

    /// The numbers of the first of the keys that stands in the text.
    pub(super) fn numbers_of(&self, keys: &[&str]) -> Option<Vec<f64>> {
        let text_after = keys.iter().find_map(|key| self.texts_after(key).next())?;
        let list = if self.is_xml {
            element_text(text_after)?
        } else {
            bracketed_text(text_after).or_else(|| dashed_lines(text_after))?
        };
        let words = list
            .split(|c: char| c.is_whitespace() || ",[]".contains(c))
            .filter(|word| !word.is_empty() && *word != "-");
        words.map(|word| word.trim_end_matches('.').parse().ok()).collect()
    }

    /// The word of the first of the keys that stands in the text.
    pub(super) fn word_of<'a>(&'a self, keys: &[&'a str]) -> Option<&'a str> {
        let text_after = keys.iter().find_map(|key| self.texts_after(key).next())?;
        let text_after = if self.is_xml {
            text_after.split_once('>')?.1.trim_start()
        } else {
            text_after.trim_start_matches([' ', '\t'])
        };
        let end = text_after.find(|c: char| c.is_whitespace() || ",<}".contains(c)).unwrap_or(text_after.len());
        Some(text_after[..end].trim_matches(['"', '\'']))
    }

    /// How many times a key stands in the text.
    pub(super) fn count_key(&self, key: &str) -> usize {
        self.texts_after(key).count()
    }

    /// What follows each place of a key: behind its colon, or the rest of its opening tag.
    fn texts_after<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a str> {
        self.text.match_indices(key).filter_map(move |(at, _)| {
            let (before, tail) = (&self.text[..at], &self.text[at + key.len()..]);
            if self.is_xml {
                return (before.ends_with('<') && tail.starts_with(['>', ' ', '\n', '\t'])).then_some(tail);
            }
            let begins = before.is_empty() || before.ends_with(['\n', ' ', '\t', '"', '\'', '{', ',']);
            let tail = tail.trim_start_matches(['"', '\'']).trim_start_matches([' ', '\t']);
            tail.strip_prefix(':').filter(|_| begins)
        })
    }
}

/// What stands in the brackets that follow a key; none where another key comes first, whose data it would be.
fn bracketed_text(rest: &str) -> Option<&str> {
    let open = rest.find('[')?;
    let text_before_bracket = rest[..open].trim_start_matches(|c: char| c != '\n' && c != '{' && c != ',');
    let keys = text_before_bracket.split(['\n', ',', '{']).filter_map(|line| line.split_once(':'));
    if keys.map(|(key, _)| key.trim_matches(['"', '\'', ' ', '\t', '\r'])).any(|key| !BEFORE_DATA.contains(&key)) {
        return None;
    }
    let mut depth = 0;
    let close = rest[open..].find(|c: char| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        depth == 0
    })?;
    Some(&rest[open + 1..open + close])
}

/// The lines that begin with a dash below a key, or below its `data`.
fn dashed_lines(rest: &str) -> Option<&str> {
    let mut offset = rest.find('\n')? + 1;
    let mut begin = None;
    while let Some(line) = rest[offset..].split_inclusive('\n').next() {
        let word = line.trim();
        let is_dash = word.starts_with('-');
        let is_header = word.split_once(':').is_some_and(|(key, _)| BEFORE_DATA.contains(&key.trim()));
        match (begin, is_dash) {
            (None, true) => begin = Some(offset),
            (None, false) if word.is_empty() || is_header => {}
            (None, false) => return None,
            (Some(_), true) => {}
            (Some(_), false) => break,
        }
        offset += line.len();
    }
    let list = &rest[begin?..offset];
    // a dash before a number without a blank is its sign
    Some(list)
}

/// The text of an element, or of the data in it.
fn element_text(rest: &str) -> Option<&str> {
    let inner = rest.split_once('>')?.1;
    let tag = |text: &'static str| inner.find(text);
    match (tag("<data>"), tag("</")) {
        (Some(data), _) => inner[data + 6..].split_once('<').map(|(list, _)| list),
        (None, Some(end)) => Some(&inner[..end]),
        _ => None,
    }
}

fn without_remarks(text: &str) -> String {
    let mut parts = text.split("<!--");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| kept + part.split_once("-->").map_or("", |(_, after)| after))
}

fn without_hashes(text: &str) -> String {
    let bare = |line: &str| match line.find('#') {
        Some(at) if at == 0 || line[..at].ends_with([' ', '\t']) => format!("{}\n", &line[..at]),
        _ => format!("{line}\n"),
    };
    text.lines().map(bare).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_every_notation() {
        for text in [
            "K: [1., -2, 3e1]\n",
            "K: !!opencv-matrix\n  rows: 1\n  dt: d\n  data: [ 1.,\n   -2, 3e1 ]\n",
            "K:\n- 1.0\n- -2.0\n- 30.0\nother: [9]\n",
            "K:\n  rows: 1\n  data:\n  - 1\n  - -2\n  - 30\n",
            "{\"other\": [9], \"K\": {\"type_id\": \"opencv-matrix\", \"rows\": 1, \"data\": [1, -2, 30]}}",
            "{\"K\": [[1, -2], [30]]}",
            "<?xml version=\"1.0\"?>\n<a><!-- K --><K type_id=\"x\"><rows>1</rows><data>\n1. -2 3e1</data></K></a>",
            "<a><K>1 -2 30</K></a>",
        ] {
            assert_eq!(Values::new(text).numbers_of(&["K"]), Some(vec![1.0, -2.0, 30.0]), "{text}");
        }
        for text in ["K: 3\nD: [1]\n", "K:\nD:\n- 1\n", "<a><B>1</B></a>", "k1: [1]"] {
            assert_eq!(Values::new(text).numbers_of(&["K"]), None, "{text}");
        }
    }

    #[test]
    fn a_word_is_that_of_its_key_and_none_of_a_comment() {
        let yaml = "# model: fisheye\nmodel: \"radtan\" # not fisheye\nother: x\n";
        assert_eq!(Values::new(yaml).word_of(&["model"]), Some("radtan"));
        assert_eq!(Values::new("{\"model\": \"fisheye\"}").word_of(&["model"]), Some("fisheye"));
        assert_eq!(Values::new("<a><model>fisheye</model></a>").word_of(&["model"]), Some("fisheye"));
        assert_eq!(Values::new(yaml).word_of(&["kind"]), None);
    }
}
