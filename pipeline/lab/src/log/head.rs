//! The head of a log: what stands above its first line of numbers.
//!
//! A log may begin with remarks, a line `sep=;`, the head that a program of measurement writes (one `key separator value` a line), titles, and a line
//! of units. The numbers begin at the first line that is one of numbers, and is followed by another; the titles are the line above, or above the
//! units.

use super::dialect::Dialect;

/// A line of a text with its number from 1.
pub(super) type Line<'a> = (usize, &'a str);

/// Where titles and numbers of a text stand.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Head<'a> {
    pub dialect: Dialect,
    /// The line of titles, where there is one.
    pub titles: Option<Line<'a>>,
    /// The line of units below it, where there is one.
    pub units: Option<Line<'a>>,
    /// The first line that is read as numbers.
    pub begin: usize,
    /// Fields of the first line of numbers.
    pub width: usize,
}

/// Lines of a text with their numbers, whatever system ended them.
pub(super) fn numbered_lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let parts = text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'));
    parts.enumerate().map(|(index, line)| (index + 1, line))
}

/// Whether a line is neither empty nor a remark.
pub(super) fn is_content((_, line): &Line) -> bool {
    !line.starts_with('#') && !line.trim().is_empty()
}

/// Lines above the numbers at most; measuring programs write fewer than a hundred.
const LONGEST_HEAD: usize = 1000;

impl<'a> Head<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let mut head_lines: Vec<Line> = Vec::new();
        let mut separator = None;
        let mut remaining = numbered_lines(text).filter(is_content).take(LONGEST_HEAD).peekable();
        while let Some(line) = remaining.next() {
            if head_lines.is_empty() && separator.is_none() {
                separator = named_separator(line.1);
                if separator.is_some() {
                    continue;
                }
            }
            if let Some(dialect) = Dialect::numbers(line.1, separator) {
                let next = remaining.peek().and_then(|next| Dialect::numbers(next.1, Some(dialect.separator)));
                if next.is_some() || remaining.peek().is_none() {
                    let width = dialect.split_fields(line.1).len();
                    // a line that begins with a number is one of numbers, whatever is wrong with it
                    let head_length = head_lines
                        .iter()
                        .rposition(|(_, line)| !begins_with_number(line, dialect))
                        .map_or(0, |last| last + 1);
                    let begin = head_lines.get(head_length).map_or(line.0, |broken| broken.0);
                    head_lines.truncate(head_length);
                    let (titles, units) = titles_above(&head_lines, dialect, width);
                    let titles = titles.or_else(|| remark_titles(text, begin, dialect, width));
                    return Self { dialect, titles, units, begin, width };
                }
            }
            head_lines.push(line);
        }
        Self::without_numbers(head_lines.first().copied(), separator)
    }

    /// The first line is taken for titles, so that what is wrong with those below it is said of them.
    fn without_numbers(first: Option<Line<'a>>, separator: Option<u8>) -> Self {
        let (number, line) = first.unwrap_or((0, ""));
        let dialect = separator.map_or_else(|| Dialect::titles(line), Dialect::new);
        let width = dialect.split_fields(line).len();
        Self { dialect, titles: first, units: None, begin: number + 1, width }
    }
}

fn begins_with_number(line: &str, dialect: Dialect) -> bool {
    let fields = dialect.split_fields(line);
    fields.len() > 1 && dialect.is_number(&fields[0])
}

/// The separator of a line `sep=;`, as Excel writes and reads it.
fn named_separator(line: &str) -> Option<u8> {
    let line = line.trim_start_matches('\u{feff}').trim_matches(['"', ' ']);
    let (key, sign) = line.split_once('=')?;
    let sign = if sign.is_empty() { "\t" } else { sign };
    (key.eq_ignore_ascii_case("sep") && sign.len() == 1).then(|| sign.as_bytes()[0])
}

/// The titles among the lines above the numbers: the last, or the last but one where that holds units; and the units.
fn titles_above<'a>(above: &[Line<'a>], dialect: Dialect, width: usize) -> (Option<Line<'a>>, Option<Line<'a>>) {
    let has_width = |line: &Line| dialect.split_titles(line.1, width).len() == width;
    match above {
        [.., titles, last] if has_width(titles) && has_width(last) && is_units(last.1, dialect, width) => {
            (Some(*titles), Some(*last))
        }
        [.., last] => (Some(*last), None),
        [] => (None, None),
    }
}

/// Titles that stand in the remark above the numbers, as numpy writes them.
fn remark_titles(text: &str, begin: usize, dialect: Dialect, width: usize) -> Option<Line<'_>> {
    let (number, line) = numbered_lines(text).take(begin - 1).filter(|(_, line)| !line.trim().is_empty()).last()?;
    let titles = line.trim_start_matches('#').trim();
    let fields = dialect.split_titles(titles, width);
    (fields.len() == width && fields.iter().all(|field| !field.is_empty() && !dialect.is_number(field)))
        .then_some((number, titles))
}

/// Units that logs name, without prefixes.
const UNITS: [&str; 24] = [
    "", "-", "1", "s", "sec", "seconds", "min", "h", "N", "g", "gf", "lbf", "Pa", "bar", "psi", "V", "A", "m", "in",
    "°C", "C", "K", "Hz", "counts",
];

/// Whether a line holds the units of the columns.
pub(super) fn is_units(line: &str, dialect: Dialect, width: usize) -> bool {
    let fields = dialect.split_titles(line, width);
    let unit = |field: &str| {
        let unit = field.trim_matches(['[', ']', '(', ')', ' ']);
        let bare = unit.strip_prefix(['m', 'µ', 'μ', 'u', 'k', 'M', 'h', 'c']).unwrap_or(unit);
        UNITS.contains(&unit) || UNITS[1..].contains(&bare) || unit == "%" || unit == "degC"
    };
    fields.iter().any(|field| !field.is_empty()) && fields.iter().all(|field| unit(field))
}

impl Dialect {
    /// Titles between runs of blanks may themselves have single blanks: they are then split at two.
    pub(super) fn split_titles<'a>(&self, line: &'a str, width: usize) -> Vec<std::borrow::Cow<'a, str>> {
        let fields = self.split_fields(line);
        if self.separator != b' ' || fields.len() == width {
            return fields;
        }
        line.split("  ").map(str::trim).filter(|field| !field.is_empty()).map(Into::into).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The titles and the number of the first line of numbers.
    fn head(text: &str) -> (Option<&str>, usize) {
        let head = Head::new(text);
        (head.titles.map(|(_, line)| line), head.begin)
    }

    #[test]
    fn titles_units_and_heads_are_told_from_numbers() {
        for (text, expected) in [
            ("# made by us\ntime_s,led\n0,1\n", (Some("time_s,led"), 3)),
            ("time_s;led\n\n0,5;1\n", (Some("time_s;led"), 3)),
            ("0,5\t1,25\n", (None, 1)),
            ("\"0,5\";\"1,2\"\n\"0,6\";\"1,3\"\n", (None, 1)),
            ("sep=;\nt;f\n0;1\n1;2\n", (Some("t;f"), 3)),
            ("\"sep=,\"\r\nt,f\r\n0,1\r\n", (Some("t,f"), 3)),
            ("t;f\ns;mN\n0;1\n1;2\n", (Some("t;f"), 3)),
            ("t,f,T\n[s],[N],[°C]\n0,1,2\n1,2,3\n", (Some("t,f,T"), 3)),
            ("s;N\n0;1\n1;2\n", (Some("s;N"), 2)),
            ("Rate;100\nOperator;AB\nt;f\n0;1\n1;2\n", (Some("t;f"), 4)),
            ("Channels;2\n\nTime;Force\n0;1\n1;2\n", (Some("Time;Force"), 4)),
            ("time   force\n 0.0   1.0\n 0.1   2.0\n", (Some("time   force"), 2)),
            ("# t f\n0.0 1.0\n0.1 2.0\n", (Some("t f"), 2)),
            ("# virtual bench\n0.0,1.0\n0.1,2.0\n", (None, 2)),
            ("t,f,state\n0,1,open\n1,2,shut\n", (Some("t,f,state"), 2)),
            ("0,1,open\n1,2,shut\n", (None, 1)),
            ("t,f\n", (Some("t,f"), 2)),
            ("", (None, 1)),
        ] {
            assert_eq!(head(text), expected, "{text}");
        }
    }

    #[test]
    fn the_head_of_labview_is_read_past() {
        let text = "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nDate\t2024/05/01\r\nTime\t12:00:00,5\r\n***End_of_Header***\t\r\n\
                    \r\nChannels\t1\t\r\nSamples\t3\t\r\nX0\t0,0000000000000000E+0\t\r\nDelta_X\t0,010000\t\r\n***End_of_Header***\t\t\r\n\
                    X_Value\tForce\tComment\r\n0,000000\t1,5\tbegin\r\n0,010000\t1,6\r\n0,020000\t1,7\r\n";
        let head = Head::new(text);
        assert_eq!(head.titles.map(|(_, line)| line), Some("X_Value\tForce\tComment"));
        assert_eq!((head.begin, head.width, head.dialect.decimal_comma), (13, 3, true));
    }

    #[test]
    fn lines_of_any_system_have_their_numbers() {
        for text in ["a\nb\n\nc", "a\r\nb\r\n\r\nc", "a\rb\r\rc"] {
            let all: Vec<Line> = numbered_lines(text).filter(is_content).collect();
            assert_eq!(all, [(1, "a"), (2, "b"), (4, "c")], "{text:?}");
        }
    }
}
