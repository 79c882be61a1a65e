//! A file of Rust as text: with comments blanked, with strings blanked, without its tests.
//!
//! A small scanner tells code from comments and strings; what it blanks becomes spaces, so that lines stay lines.

/// A file with its path from the top of the project, written with `/`.
#[derive(Debug, Clone)]
pub struct Source {
    pub path: String,
    pub text: String,
    /// Whether the whole file is a test or a bench.
    pub test: bool,
}

/// What the scanner is in the middle of.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    Code,
    LineComment,
    BlockComment(usize),
    Quotes,
    RawQuotes(usize),
}

impl Source {
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned(), test: false }
    }

    /// The text with comments as spaces.
    pub fn without_comments(&self) -> String {
        blanked(&self.text, false)
    }

    /// The text with comments and strings as spaces.
    pub fn code(&self) -> String {
        blanked(&self.text, true)
    }

    /// A view of the text (of the same length) with every item under `#[cfg(test)]` as spaces.
    pub fn outside_tests(&self, view: &str) -> String {
        let code = self.code();
        let mut bytes = view.as_bytes().to_vec();
        let mark = "#[cfg(test)]";
        for (start, _) in code.match_indices(mark) {
            let end = item_end(&code, start + mark.len());
            bytes[start..end].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
        }
        String::from_utf8(bytes).unwrap_or_default()
    }

    /// The modules that the file declares under `#[cfg(test)]` and that lie in files of their own.
    pub fn test_modules(&self) -> Vec<String> {
        let code = self.code();
        let after = code.split("#[cfg(test)]").skip(1).filter_map(|rest| rest.split_once("mod ")?.1.split_once(';'));
        after
            .map(|(name, _)| name.trim().to_owned())
            .filter(|n| n.chars().all(|c| c.is_alphanumeric() || c == '_'))
            .collect()
    }
}

/// Where an item that begins at `from` ends: after its block, or after its semicolon.
fn item_end(code: &str, from: usize) -> usize {
    let mut depth = 0usize;
    for (i, c) in code[from..].char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return from + i + 1,
            '}' => depth = depth.saturating_sub(1),
            ';' if depth == 0 => return from + i + 1,
            _ => {}
        }
    }
    code.len()
}

/// Blanks comments, and strings too when asked; each blanked byte becomes a space, line ends stay.
fn blanked(text: &str, strings_too: bool) -> String {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut within = Within::Code;
    let mut i = 0;
    while i < bytes.len() {
        let (next, length) = step(within, &bytes[i..]);
        let blank = match (within, next) {
            (Within::Code, Within::LineComment | Within::BlockComment(_)) => true,
            (Within::LineComment | Within::BlockComment(_), _) => true,
            (Within::Quotes | Within::RawQuotes(_), _) => strings_too,
            (Within::Code, Within::Code) => strings_too && length > 1 && bytes[i] == b'\'',
            (Within::Code, _) => false,
        };
        if blank {
            out[i..i + length].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
        }
        within = next;
        i += length;
    }
    String::from_utf8(out).unwrap_or_default()
}

/// One step of the scanner: what it is within afterwards, and how many bytes it passed.
fn step(within: Within, rest: &[u8]) -> (Within, usize) {
    let begins = |with: &str| rest.starts_with(with.as_bytes());
    match within {
        Within::Code if begins("//") => (Within::LineComment, 2),
        Within::Code if begins("/*") => (Within::BlockComment(1), 2),
        Within::Code if rest[0] == b'"' => (Within::Quotes, 1),
        Within::Code if rest[0] == b'r' => raw_start(rest).map_or((Within::Code, 1), |n| (Within::RawQuotes(n), n + 2)),
        Within::Code if rest[0] == b'\'' => (Within::Code, letter_length(rest)),
        Within::Code => (Within::Code, 1),
        Within::LineComment if rest[0] == b'\n' => (Within::Code, 1),
        Within::LineComment => (within, 1),
        Within::BlockComment(n) if begins("/*") => (Within::BlockComment(n + 1), 2),
        Within::BlockComment(1) if begins("*/") => (Within::Code, 2),
        Within::BlockComment(n) if begins("*/") => (Within::BlockComment(n - 1), 2),
        Within::BlockComment(_) => (within, 1),
        Within::Quotes if rest[0] == b'\\' => (within, rest.len().min(2)),
        Within::Quotes if rest[0] == b'"' => (Within::Code, 1),
        Within::Quotes => (within, 1),
        Within::RawQuotes(n) if begins(&format!("\"{}", "#".repeat(n))) => (Within::Code, n + 1),
        Within::RawQuotes(_) => (within, 1),
    }
}

/// The number of hashes when `r`, hashes and a quote begin here.
fn raw_start(rest: &[u8]) -> Option<usize> {
    let hashes = rest[1..].iter().take_while(|b| **b == b'#').count();
    (rest.get(1 + hashes) == Some(&b'"')).then_some(hashes)
}

/// The length of a letter in quotes ('x', '\n', '→'), or 1 for the tick of a lifetime.
fn letter_length(rest: &[u8]) -> usize {
    let end =
        |from: usize| rest[from.min(rest.len())..].iter().take(10).position(|b| *b == b'\'').map(|n| from + n + 1);
    match rest.get(1) {
        Some(b'\\') => end(3).unwrap_or(1),
        Some(first) if *first >= 128 => end(2).unwrap_or(1),
        Some(_) if rest.get(2) == Some(&b'\'') => 3,
        _ => 1,
    }
}

#[test]
fn comments_and_strings_are_told_from_code() {
    let source = Source::new("a.rs", "let a = \"x // y\"; // z\nlet b = r#\"q\"w\"#; /* c /* d */ e */ let c = '\"';");
    let bare: Vec<String> = source.code().split_whitespace().map(str::to_owned).collect();
    assert_eq!(bare.join(" "), "let a = \" ; let b = r#\" ; let c = ;");
    assert!(source.without_comments().contains("x // y") && !source.without_comments().contains('z'));
}

#[test]
fn a_lifetime_does_not_begin_a_letter() {
    let source = Source::new("a.rs", "fn f<'a>(x: &'a str) -> char { '{' } // {");
    assert_eq!(source.code().matches('{').count(), 1);
    assert!(source.code().contains("&'a str"));
}

#[test]
fn a_test_module_is_left_out_to_its_last_brace() {
    let text = "fn a() {}\n#[cfg(test)]\nmod tests {\n    fn b() { let c = \"}\"; }\n}\nfn d() {}\n#[cfg(test)]\nmod more;\nfn e() {}\n";
    let source = Source::new("a.rs", text);
    let rest = source.outside_tests(&source.text);
    assert!(rest.contains("fn a") && rest.contains("fn d") && rest.contains("fn e"));
    assert!(!rest.contains("fn b") && !rest.contains("mod more"));
    assert_eq!(rest.lines().count(), text.lines().count());
    assert_eq!(source.test_modules(), ["more"]);
}
