//! Arrays of VTK's XML: text, base64 or appended bytes, whole or in zlib's blocks, as numbers.
//!
//! Encoded arrays begin with a header of counts: the bytes that follow, or for blocks their number, size, the size of the
//! last and the compressed size of each. Header and blocks may be encoded one after the other, each with its own padding.

use super::raw_mesh::MeshFileError;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use roxmltree::Node;
use std::io::Read;

const AGAIN: &str = "save the mesh again, as text or base64 without lz4 and lzma";
/// Limit of the numbers in one array, and of its bytes for each of them: five million nodes, ten times what can be solved here.
const MAX_NUMBERS: usize = 1 << 24;
const MAX_BYTES: usize = 8 * MAX_NUMBERS;

/// Bytes behind the XML.
pub(super) struct Tail<'a> {
    bytes: &'a [u8],
    base64: bool,
}

impl<'a> Tail<'a> {
    /// The XML before the appended bytes, and those behind their underscore, if the file has some.
    pub(crate) fn cut_off(file: &'a [u8]) -> (&'a [u8], Option<Self>) {
        let find = |from: usize, mark: &[u8]| {
            file[from..].windows(mark.len()).position(|bytes| bytes == mark).map(|place| from + place)
        };
        let Some(start) = find(0, b"<AppendedData") else { return (file, None) };
        let open = find(start, b">").unwrap_or(file.len());
        let tag = String::from_utf8_lossy(&file[start..open]).replace('\'', "\"");
        let begin = find(open, b"_").map_or(file.len(), |place| place + 1);
        (&file[..start], Some(Self { bytes: &file[begin..], base64: tag.contains("\"base64\"") }))
    }
}

/// How the arrays of one file are written.
pub(super) struct Codec<'a> {
    big: bool,
    wide_header: bool,
    blocks: bool,
    tail: Option<Tail<'a>>,
}

impl<'a> Codec<'a> {
    pub fn new(root: Node, tail: Option<Tail<'a>>) -> Result<Self, MeshFileError> {
        let blocks = match root.attribute("compressor") {
            None => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(MeshFileError::new(format!("arrays are packed by {other}"), "zlib's are read", AGAIN));
            }
        };
        let big = root.attribute("byte_order") == Some("BigEndian");
        Ok(Self { big, wide_header: root.attribute("header_type") == Some("UInt64"), blocks, tail })
    }

    /// All numbers of a `DataArray`.
    pub fn array_values(&self, array: Node) -> Result<Vec<f64>, MeshFileError> {
        let text = || -> String { array.children().filter(Node::is_text).filter_map(|node| node.text()).collect() };
        match array.attribute("format") {
            Some("binary") => self.parse_numbers(array, &self.unpack_bytes(&decode_base64(text().as_bytes())?)?),
            Some("appended") => self.parse_numbers(array, &self.appended_bytes(array)?),
            _ => text().split_ascii_whitespace().map(parse_number).collect(),
        }
    }

    fn appended_bytes(&self, array: Node) -> Result<Vec<u8>, MeshFileError> {
        let offset: Option<usize> = array.attribute("offset").and_then(|word| word.trim().parse().ok());
        let tail = self.tail.as_ref().and_then(|tail| Some((tail, tail.bytes.get(offset?..)?)));
        match tail {
            None => Err(cut_error()),
            Some((Tail { base64: false, .. }, bytes)) => self.unpack_bytes(bytes),
            Some((_, bytes)) => self.unpack_bytes(&decode_base64(bytes)?),
        }
    }

    /// The array's own bytes from those that begin with its header.
    fn unpack_bytes(&self, bytes: &[u8]) -> Result<Vec<u8>, MeshFileError> {
        let count = |place: usize| self.header_count(bytes, place);
        let step = if self.wide_header { 8 } else { 4 };
        if !self.blocks {
            let length = count(0)?;
            return Ok(bytes.get(step..).and_then(|remaining| remaining.get(..length)).ok_or_else(cut_error)?.to_vec());
        }
        let (blocks, size, last) = (count(0)?, count(1)?, count(2)?);
        check_bound(blocks.saturating_mul(size), MAX_BYTES, "bytes")?;
        let mut remaining =
            blocks.checked_add(3).and_then(|n| bytes.get(n.checked_mul(step)?..)).ok_or_else(cut_error)?;
        let mut unpacked = Vec::new();
        for block in 0..blocks {
            let (packed, after) = remaining.split_at_checked(count(3 + block)?).ok_or_else(cut_error)?;
            // The size of the last block is given where it is not full.
            let declared = if block + 1 == blocks && last > 0 { last.min(size) } else { size };
            inflate_block(packed, declared, &mut unpacked)?;
            remaining = after;
        }
        Ok(unpacked)
    }

    /// The header's count at `place`.
    fn header_count(&self, bytes: &[u8], place: usize) -> Result<usize, MeshFileError> {
        let kind = if self.wide_header { "UInt64" } else { "UInt32" };
        let (step, read) = number_reader(kind, self.big).ok_or_else(cut_error)?;
        let entry = place.checked_mul(step).and_then(|start| bytes.get(start..start.checked_add(step)?));
        Ok(read(entry.ok_or_else(cut_error)?) as usize)
    }

    fn parse_numbers(&self, array: Node, bytes: &[u8]) -> Result<Vec<f64>, MeshFileError> {
        let kind = array.attribute("type").unwrap_or_default();
        let (step, read) = number_reader(kind, self.big).ok_or_else(|| {
            MeshFileError::new(format!("an array is of type `{kind}`"), "VTK has no such type", AGAIN)
        })?;
        check_bound(bytes.len() / step, MAX_NUMBERS, "numbers")?;
        if !bytes.len().is_multiple_of(step) {
            let why = format!("{} bytes are no whole number of `{kind}`, which has {step}", bytes.len());
            return Err(MeshFileError::new("an array ends within a number", why, AGAIN));
        }
        Ok(bytes.chunks_exact(step).map(read).collect())
    }
}

/// Appends a block that must hold exactly the bytes that its header declares.
fn inflate_block(packed: &[u8], declared: usize, out: &mut Vec<u8>) -> Result<(), MeshFileError> {
    // One byte more than declared is asked for, so that a block that holds more is noticed and never inflated whole.
    let read = flate2::read::ZlibDecoder::new(packed).take(declared as u64 + 1).read_to_end(out);
    let length = read.map_err(|fault| {
        MeshFileError::new("a compressed block cannot be read", fault.to_string(), AGAIN).caused_by(fault)
    })?;
    match length == declared {
        true => Ok(()),
        false => Err(MeshFileError::new(
            format!(
                "a compressed block holds {} {declared} bytes",
                if length > declared { "more than" } else { "less than" }
            ),
            format!("its header declares {declared}"),
            AGAIN,
        )),
    }
}

/// Refuses an array that is larger than any mesh for which this program is made.
fn check_bound(count: usize, limit: usize, noun: &str) -> Result<(), MeshFileError> {
    match count <= limit {
        true => Ok(()),
        false => Err(MeshFileError::new(
            format!("an array declares {count} {noun}"),
            format!("the limit is {limit}"),
            "save a coarser mesh",
        )),
    }
}

/// Bytes a number takes, and how they are read.
type Reader = (usize, fn(&[u8]) -> f64);

/// The reader of one of VTK's types.
fn number_reader(kind: &str, big: bool) -> Option<Reader> {
    macro_rules! of {
        ($type:ty) => {{
            const STEP: usize = size_of::<$type>();
            fn little(bytes: &[u8]) -> f64 {
                <$type>::from_le_bytes(bytes.first_chunk::<STEP>().copied().unwrap_or_default()) as f64
            }
            fn large(bytes: &[u8]) -> f64 {
                <$type>::from_be_bytes(bytes.first_chunk::<STEP>().copied().unwrap_or_default()) as f64
            }
            Some((STEP, if big { large } else { little }))
        }};
    }
    match kind {
        "Float32" => of!(f32),
        "Float64" => of!(f64),
        "Int8" => of!(i8),
        "UInt8" => of!(u8),
        "Int16" => of!(i16),
        "UInt16" => of!(u16),
        "Int32" => of!(i32),
        "UInt32" => of!(u32),
        "Int64" => of!(i64),
        "UInt64" => of!(u64),
        _ => None,
    }
}

/// Base64 in one or more parts, each with its own padding, up to the first byte that is none.
fn decode_base64(text: &[u8]) -> Result<Vec<u8>, MeshFileError> {
    let is_digit = |byte: &u8| byte.is_ascii_alphanumeric() || b"+/=".contains(byte);
    // length: the array's own header says how many bytes it has, and fewer are refused
    let text: Vec<u8> = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).take_while(is_digit).collect();
    let mut bytes = Vec::new();
    for quads in text.chunk_by(|a, b| *a != b'=' || *b == b'=') {
        STANDARD.decode_vec(quads, &mut bytes).map_err(|fault| {
            let why = fault.to_string().to_lowercase();
            MeshFileError::new("an array is no base64", why, AGAIN).caused_by(fault)
        })?;
    }
    Ok(bytes)
}

fn parse_number(word: &str) -> Result<f64, MeshFileError> {
    word.parse().map_err(|_| {
        let message = format!("`{}` stands in an array", super::tokens::shortened(word));
        MeshFileError::new(message, "it cannot be read as a number", AGAIN)
    })
}

fn cut_error() -> MeshFileError {
    MeshFileError::new("the file ends inside an array", "its header announces more bytes", AGAIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_number_is_read_in_both_orders_of_its_bytes() {
        macro_rules! holds {
            ($name:literal, $value:expr) => {
                for big in [false, true] {
                    let (step, read) = number_reader($name, big).unwrap();
                    let bytes = if big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() };
                    assert_eq!((step, read(&bytes)), (bytes.len(), f64::from($value)), "{} {big}", $name);
                }
            };
        }
        holds!("Float32", 1.5f32);
        holds!("Float64", -2.25f64);
        holds!("Int8", -3i8);
        holds!("UInt8", 200u8);
        holds!("Int16", -300i16);
        holds!("UInt16", 60_000u16);
        holds!("Int32", -70_000i32);
        holds!("UInt32", 4_000_000_000u32);
        for (name, big) in [("Int64", false), ("UInt64", true)] {
            let bytes = if big { 7u64.to_be_bytes() } else { 7u64.to_le_bytes() };
            let (step, read) = number_reader(name, big).unwrap();
            assert_eq!((step, read(&bytes)), (8, 7.0));
        }
        assert!(number_reader("String", false).is_none());
    }
}
