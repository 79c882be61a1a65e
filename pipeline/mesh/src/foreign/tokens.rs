//! Tokens: a file as blank-separated tokens with line numbers, and blocks of bytes between them.

use super::raw_mesh::MeshFileError;
use std::str::FromStr;

/// A position in a file.
#[derive(Debug, Clone)]
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// The file's name in messages, before its line.
    part: &'static str,
    /// The character that begins a comment to the end of its line.
    comment: Option<u8>,
}

impl<'a> Tokens<'a> {
    pub fn new(bytes: &'a [u8], part: &'static str, comment: Option<u8>) -> Self {
        Self { bytes, at: 0, line: 1, part, comment }
    }

    /// The next token; none at the end.
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
        let remaining = &self.bytes[self.at..];
        let ends = |byte: &u8| byte.is_ascii_whitespace() || Some(*byte) == self.comment;
        let length = remaining.iter().position(ends).unwrap_or(remaining.len());
        self.at += length;
        (length > 0).then(|| &remaining[..length])
    }

    /// The next token, which stays unread.
    pub fn peek(&self) -> Option<&'a [u8]> {
        self.clone().next()
    }

    /// The next token; `quantity` is its name in errors.
    pub(crate) fn next_word(&mut self, quantity: &str) -> Result<&'a str, MeshFileError> {
        let word = self.next().ok_or_else(|| self.cut_error(quantity))?;
        std::str::from_utf8(word).map_err(|_| {
            self.error(format!("{quantity} is no text"), "the bytes there are no letters", "save the mesh again")
        })
    }

    /// The next token as a number; `quantity` is its name in errors.
    pub(crate) fn next_number<T: FromStr>(&mut self, quantity: &str) -> Result<T, MeshFileError> {
        let word = self.next_word(quantity)?;
        word.parse().map_err(|_| {
            let act = "save the mesh again; the file was cut or edited";
            self.error(
                format!("`{}` stands for {quantity}", shortened(word)),
                "it cannot be read as such a number",
                act,
            )
        })
    }

    /// The rest of the line, without its end, which is read too.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        let remaining = &self.bytes[self.at..];
        let length = remaining.iter().position(|byte| *byte == b'\n').unwrap_or(remaining.len());
        self.line += usize::from(length < remaining.len());
        self.at += (length + 1).min(remaining.len());
        &remaining[..length]
    }

    /// The next `N` bytes; `quantity` is their name in errors.
    pub(crate) fn take_bytes<const N: usize>(&mut self, quantity: &str) -> Result<[u8; N], MeshFileError> {
        let chunk = self.bytes[self.at..].first_chunk::<N>().copied().ok_or_else(|| self.cut_error(quantity))?;
        self.at += N;
        Ok(chunk)
    }

    /// Reads everything up to `mark` and the mark itself; returns whether it was found.
    pub(crate) fn skip_to(&mut self, mark: &str) -> bool {
        let position = self.bytes[self.at..].windows(mark.len()).position(|bytes| bytes == mark.as_bytes());
        let length = position.map_or(self.bytes.len() - self.at, |place| place + mark.len());
        self.line += self.bytes[self.at..self.at + length].iter().filter(|byte| **byte == b'\n').count();
        self.at += length;
        position.is_some()
    }

    /// An error at the current line.
    pub fn error(&self, what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> MeshFileError {
        self.with_line(MeshFileError::new(what, why, act))
    }

    /// The same error with the current line.
    pub(crate) fn with_line(&self, fault: MeshFileError) -> MeshFileError {
        fault.at_place(format!("{}line {}: ", self.part, self.line))
    }

    fn cut_error(&self, quantity: &str) -> MeshFileError {
        self.error(format!("the file ends before {quantity}"), "it was cut short", "save the mesh again")
    }
}

/// The first characters of a token, for messages.
pub(super) fn shortened(word: &str) -> String {
    word.chars().take(24).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_skipped_to_with_the_lines_before_it() {
        let mut tokens = Tokens::new(b"one\ntwo\n$End three\nfour", "", None);
        assert!(tokens.skip_to("$End"));
        assert_eq!((tokens.line, tokens.rest_of_line()), (3, &b" three"[..]));
        assert!(!tokens.skip_to("$End"));
        assert_eq!((tokens.line, tokens.at), (4, 23));
    }
}
