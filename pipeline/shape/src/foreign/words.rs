//! Words: a file as blank-separated words that know their line, with stretches of bytes between them.
//!
//! Stands on: `draft` (its refusal). Never knows: a format.

use super::draft::Malformed;
use std::str::FromStr;

/// Where a reader stands in a file.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// What the file is called in messages, beside its line.
    part: &'static str,
    /// What begins a comment that runs to the end of its line.
    comment: Option<u8>,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8], part: &'static str, comment: Option<u8>) -> Self {
        Self { bytes, at: 0, line: 1, part, comment }
    }

    /// The next word, or nothing at the end.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        while let Some(&byte) = self.bytes.get(self.at) {
            if Some(byte) == self.comment {
                self.rest_of_line();
            } else if byte.is_ascii_whitespace() {
                self.line += usize::from(byte == b'\n');
                self.at += 1;
            } else {
                break;
            }
        }
        let rest = &self.bytes[self.at..];
        let ends = |byte: &u8| byte.is_ascii_whitespace() || Some(*byte) == self.comment;
        let length = rest.iter().position(ends).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then(|| &rest[..length])
    }

    /// The next word without passing it.
    pub fn peek(&self) -> Option<&'a [u8]> {
        self.clone().next()
    }

    /// The next word, which is `what`.
    pub fn word(&mut self, what: &str) -> Result<&'a str, Malformed> {
        let word = self.next().ok_or_else(|| self.cut(what))?;
        std::str::from_utf8(word).map_err(|_| {
            self.refuse(format!("{what} is no text"), "the bytes there are no letters", "save the mesh again")
        })
    }

    /// The next word as a number, which is `what`.
    pub fn number<T: FromStr>(&mut self, what: &str) -> Result<T, Malformed> {
        let word = self.word(what)?;
        word.parse().map_err(|_| {
            let act = "save the mesh again; the file was cut or edited";
            self.refuse(format!("`{}` stands for {what}", short(word)), "it cannot be read as such a number", act)
        })
    }

    /// The rest of the line, without its end, which is passed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.line += usize::from(length < rest.len());
        self.at += (length + 1).min(rest.len());
        &rest[..length]
    }

    /// The next `count` bytes as they are, which are `what`.
    pub fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Malformed> {
        let found = self.bytes[self.at..].first_chunk::<N>().copied().ok_or_else(|| self.cut(what))?;
        self.at += N;
        Ok(found)
    }

    /// Passes everything up to `mark`, and it too; says whether it was there.
    pub fn pass(&mut self, mark: &str) -> bool {
        let found = self.bytes[self.at..].windows(mark.len()).position(|bytes| bytes == mark.as_bytes());
        let length = found.map_or(self.bytes.len() - self.at, |place| place + mark.len());
        self.line += self.bytes[self.at..self.at + length].iter().filter(|byte| **byte == b'\n').count();
        self.at += length;
        found.is_some()
    }

    /// A refusal at the present line.
    pub fn refuse(&self, what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Malformed {
        self.place(Malformed::new(what, why, act))
    }

    /// Says of a refusal that it happened here.
    pub fn place(&self, fault: Malformed) -> Malformed {
        fault.at(format!("{}line {}: ", self.part, self.line))
    }

    fn cut(&self, what: &str) -> Malformed {
        self.refuse(format!("the file ends before {what}"), "it was cut short", "save the mesh again")
    }
}

/// The beginning of a word, for messages.
pub(super) fn short(word: &str) -> String {
    word.chars().take(24).collect()
}
