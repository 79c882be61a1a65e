//! Streams: the numbers of gmsh's files, as text or as bytes of either order.

use super::raw_mesh::MeshFileError;
use super::tokens::Tokens;

/// What to do after most errors.
pub(super) const AGAIN: &str = "save the mesh again as version 4.1 (gmsh -format msh41 -save)";

/// The encoding of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    Text,
    Little,
    Big,
}

/// The numbers of a file of gmsh.
pub(super) struct Stream<'a> {
    pub tokens: Tokens<'a>,
    pub form: Form,
}

impl Stream<'_> {
    /// Reads the integer 1, from which the byte order of a binary file follows.
    pub(crate) fn find_form(&mut self) -> Result<(), MeshFileError> {
        let mark: [u8; 4] = self.tokens.take_bytes("the mark of the byte order")?;
        self.form = if i32::from_le_bytes(mark) == 1 { Form::Little } else { Form::Big };
        Ok(())
    }

    /// The end of a section.
    pub(crate) fn end_section(&mut self, section: &str) -> Result<(), MeshFileError> {
        let expected = format!("$End{section}");
        match self.tokens.next() {
            Some(word) if word == expected.as_bytes() => Ok(()),
            _ => Err(self.tokens.error(
                format!("the section {section} does not end where it must"),
                format!("{expected} was expected after the numbers that were announced"),
                AGAIN,
            )),
        }
    }

    /// A whole number of 4 bytes.
    pub(crate) fn read_int(&mut self, quantity: &str) -> Result<i64, MeshFileError> {
        match self.form {
            Form::Text => self.tokens.next_number(quantity),
            Form::Little => Ok(i32::from_le_bytes(self.tokens.take_bytes(quantity)?).into()),
            Form::Big => Ok(i32::from_be_bytes(self.tokens.take_bytes(quantity)?).into()),
        }
    }

    /// A count or a number of a node or element, of 8 bytes.
    pub fn read_size(&mut self, quantity: &str) -> Result<u64, MeshFileError> {
        match self.form {
            Form::Text => self.tokens.next_number(quantity),
            Form::Little => Ok(u64::from_le_bytes(self.tokens.take_bytes(quantity)?)),
            Form::Big => Ok(u64::from_be_bytes(self.tokens.take_bytes(quantity)?)),
        }
    }

    pub(crate) fn read_real(&mut self, quantity: &str) -> Result<f64, MeshFileError> {
        match self.form {
            Form::Text => self.tokens.next_number(quantity),
            Form::Little => Ok(f64::from_le_bytes(self.tokens.take_bytes(quantity)?)),
            Form::Big => Ok(f64::from_be_bytes(self.tokens.take_bytes(quantity)?)),
        }
    }

    /// Skips the rest of the line of a section's name, after which binary numbers begin.
    pub(crate) fn begin_section(&mut self) {
        if self.form != Form::Text {
            self.tokens.rest_of_line();
        }
    }
}
