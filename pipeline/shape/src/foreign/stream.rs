//! Stream: the numbers of gmsh's files, as words or as bytes of either order.
//!
//! Stands on: `words`. Never knows: what a section holds.

use super::draft::Malformed;
use super::words::Words;

/// The way out of most refusals.
pub(super) const AGAIN: &str = "save the mesh again as version 4.1 (gmsh -format msh41 -save)";

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    Text,
    Little,
    Big,
}

/// Where a reader of gmsh's numbers stands.
pub(super) struct Stream<'a> {
    pub words: Words<'a>,
    pub form: Form,
}

impl Stream<'_> {
    /// Reads the mark from which a binary file's byte order is known.
    pub fn find_form(&mut self) -> Result<(), Malformed> {
        let one: [u8; 4] = self.words.take("the mark of the byte order")?;
        self.form = if i32::from_le_bytes(one) == 1 { Form::Little } else { Form::Big };
        Ok(())
    }

    /// The end of a section.
    pub fn end(&mut self, section: &str) -> Result<(), Malformed> {
        let expected = format!("$End{section}");
        match self.words.next() {
            Some(word) if word == expected.as_bytes() => Ok(()),
            _ => Err(self.words.refuse(
                format!("the section {section} does not end where it should"),
                format!("{expected} was expected after the numbers that were announced"),
                AGAIN,
            )),
        }
    }

    /// A whole number of 4 bytes.
    pub fn int(&mut self, what: &str) -> Result<i64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(i32::from_le_bytes(self.words.take(what)?).into()),
            Form::Big => Ok(i32::from_be_bytes(self.words.take(what)?).into()),
        }
    }

    /// A count or a number of a node or element, of 8 bytes.
    pub fn size(&mut self, what: &str) -> Result<u64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(u64::from_le_bytes(self.words.take(what)?)),
            Form::Big => Ok(u64::from_be_bytes(self.words.take(what)?)),
        }
    }

    pub fn real(&mut self, what: &str) -> Result<f64, Malformed> {
        match self.form {
            Form::Text => self.words.number(what),
            Form::Little => Ok(f64::from_le_bytes(self.words.take(what)?)),
            Form::Big => Ok(f64::from_be_bytes(self.words.take(what)?)),
        }
    }

    /// Past the line of a section's name, where binary numbers begin.
    pub fn begin(&mut self) {
        if self.form != Form::Text {
            self.words.rest_of_line();
        }
    }
}
