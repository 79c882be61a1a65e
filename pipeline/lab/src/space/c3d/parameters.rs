//! The parameters of a `.c3d`: groups of named lists.

use std::collections::BTreeMap;

use super::words::Words;

/// A list of numbers or letters.
#[derive(Debug, Clone, Copy)]
struct Parameter {
    /// −1 letters, 1 bytes, 2 integers, 4 real numbers.
    kind: i8,
    /// Letters of a text, where there are letters.
    first_size: usize,
    /// Items.
    count: usize,
    /// Where they stand.
    at: usize,
}

/// The parameters by group and name, in upper case.
pub(super) struct Parameters<'a> {
    words: Words<'a>,
    all: BTreeMap<(String, String), Parameter>,
}

impl<'a> Parameters<'a> {
    /// Reads the entries from byte `begin` on, each of which says where the next one stands.
    pub(super) fn new(words: Words<'a>, begin: usize) -> Self {
        let (mut groups, mut entries) = (BTreeMap::new(), Vec::new());
        let mut entry = begin + 4;
        while entry < words.bytes.len() {
            // a locked entry has a name of negative length
            let length = usize::from(words.byte(entry).cast_signed().unsigned_abs());
            let group = words.byte(entry + 1).cast_signed();
            if length == 0 || group == 0 {
                break;
            }
            let name = read_letters(&words, entry + 2, length).to_ascii_uppercase();
            let next = entry + 2 + length;
            match group {
                ..0 => drop(groups.insert(group.unsigned_abs(), name)),
                _ => entries.push((group.unsigned_abs(), name, read_parameter(&words, next + 2))),
            }
            match words.count(next) {
                0 => break,
                offset => entry = next + usize::from(offset),
            }
        }
        let named = |(group, name, parameter)| Some(((groups.get(&group).cloned()?, name), parameter));
        Self { words, all: entries.into_iter().filter_map(named).collect() }
    }

    fn find_parameter(&self, group: &str, name: &str) -> Option<&Parameter> {
        self.all.get(&(group.to_owned(), name.to_owned()))
    }

    /// The numbers of a parameter, integers without their sign, as counts are.
    pub(super) fn number_list(&self, group: &str, name: &str) -> Vec<f64> {
        let Some(&Parameter { kind, count, at, .. }) = self.find_parameter(group, name) else { return Vec::new() };
        let present = count.min(self.words.bytes.len());
        let number = |i: usize| match kind {
            4 => f64::from(self.words.real(at + 4 * i)),
            2 => f64::from(self.words.count(at + 2 * i)),
            _ => f64::from(self.words.byte(at + i)),
        };
        (0..present).map(number).collect()
    }

    /// The texts of a parameter, without the blanks around them.
    pub(super) fn text_list(&self, group: &str, name: &str) -> Vec<String> {
        let Some(&Parameter { first_size, count, at, .. }) = self.find_parameter(group, name) else {
            return Vec::new();
        };
        let texts = count.checked_div(first_size).unwrap_or_default().min(self.words.bytes.len());
        let text = |i: usize| read_letters(&self.words, at + i * first_size, first_size).trim().to_owned();
        (0..texts).map(text).collect()
    }
}

fn read_parameter(words: &Words, at: usize) -> Parameter {
    let sizes = usize::from(words.byte(at + 1));
    let dimensions: Vec<usize> = (0..sizes).map(|i| usize::from(words.byte(at + 2 + i))).collect();
    let count = dimensions.iter().fold(1, |product: usize, size| product.saturating_mul(*size));
    let first_size = dimensions.first().copied().unwrap_or(1);
    Parameter { kind: words.byte(at).cast_signed(), first_size, count, at: at + 2 + sizes }
}

/// Letters are ASCII by the format; other programs write their system's own.
fn read_letters(words: &Words, at: usize, count: usize) -> String {
    let end = (at + count).min(words.bytes.len());
    let bytes = words.bytes.get(at..end).unwrap_or_default();
    let ends = |c: char| c.is_whitespace() || c == '\0';
    String::from_utf8_lossy(bytes).trim_matches(ends).to_owned()
}
