//! A reduced tail as a file of safetensors.
//!
//! All arrays are of 64-bit floating-point numbers, in SI units and rows first. The metadata state how many coordinates, regions, chambers,
//! sections and outputs there are, and their names: a file that lacks one, or has another array, is refused.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use safetensors::{Dtype, tensor::TensorView};

use crate::data::TwinData;
use crate::error::TwinError;
use crate::layout::{Counts, array_numbers};
use crate::metadata::json_object;
use crate::unpack::unpack_file;

/// Limit of a file that is read, bytes: a thousand times that of a tail of 40 coordinates.
const LARGEST: u64 = 512 << 20;

/// Writes a tail's arrays.
///
/// # Errors
/// [`TwinError::Data`] when they do not belong together, [`TwinError::File`] when the file cannot be written.
pub fn write(path: &Path, data: &TwinData) -> Result<(), TwinError> {
    fs::write(path, bytes(data)?).map_err(|e| refused_file(path, e))
}

/// Reads a tail's arrays.
///
/// # Errors
/// [`TwinError::File`] when the file is no regular one, is larger than 512 MiB, cannot be read, or [`parse`] refuses it.
pub fn read(path: &Path) -> Result<TwinData, TwinError> {
    parse(&read_regular(path).map_err(|e| refused_file(path, e))?, path)
}

/// The tail in the content of the file `path`.
///
/// # Errors
/// [`TwinError::File`] when an array is missing, cut, of another shape or type, or none of a tail, or a number is out of range.
pub fn parse(bytes: &[u8], path: &Path) -> Result<TwinData, TwinError> {
    let data = unpack_file(bytes).map_err(|what| refused_file(path, what))?;
    data.find_fault().map_err(|what| refused_file(path, what))?;
    Ok(data)
}

/// The bytes of a regular file below the limit.
// A pipe or a device would never end, and a file may grow while it is read.
fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    let mut bytes = Vec::new();
    if !metadata.is_file() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    if metadata.len() <= LARGEST {
        File::open(path)?.take(LARGEST + 1).read_to_end(&mut bytes)?;
    }
    let length = metadata.len().max(bytes.len() as u64);
    let text = || format!("it has {} MiB; the limit is {} MiB", length >> 20, LARGEST >> 20);
    if length > LARGEST { Err(io::Error::new(ErrorKind::FileTooLarge, text())) } else { Ok(bytes) }
}

fn refused_file(path: &Path, message: impl std::fmt::Display) -> TwinError {
    TwinError::File { file: path.display().to_string(), what: message.to_string() }
}

/// The file's content.
///
/// # Errors
/// [`TwinError::Data`] when the arrays do not belong together.
pub fn bytes(data: &TwinData) -> Result<Vec<u8>, TwinError> {
    data.check_data()?;
    let (counts, numbers) = (Counts::of_data(data), array_numbers(data));
    let raw: Vec<Vec<u8>> =
        numbers.iter().map(|values| values.iter().flat_map(|value| value.to_le_bytes()).collect()).collect();
    // length: the check above holds each list of numbers against its array
    let arrays = counts.arrays().into_iter().zip(&raw);
    let views = arrays.map(|(array, bytes)| Ok((array.name, TensorView::new(Dtype::F64, array.shape, bytes)?)));
    let views = views.collect::<Result<Vec<_>, _>>();
    let bytes = views.and_then(|views| safetensors::serialize(views, None));
    let bytes = bytes.map_err(|e: safetensors::SafeTensorError| TwinError::Data { what: e.to_string() })?;
    Ok(with_metadata(&bytes, &json_object(data)))
}

/// The same content with `metadata`, a JSON object, at the begin of its header.
fn with_metadata(bytes: &[u8], metadata: &str) -> Vec<u8> {
    let length = bytes.first_chunk().map_or(0, |length| u64::from_le_bytes(*length)) as usize;
    let (header, arrays) = bytes[size_of::<u64>()..].split_at(length);
    let mut new_header = format!("{{\"__metadata__\":{metadata},").into_bytes();
    new_header.extend(header[1..].trim_ascii_end());
    // arrays begin at multiples of eight bytes
    new_header.resize(new_header.len().next_multiple_of(size_of::<u64>()), b' ');
    [&(new_header.len() as u64).to_le_bytes(), &*new_header, arrays].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Chamber, Output, Region, Section, Twin};

    fn tail() -> TwinData {
        let wave = |count: usize, by: f64| (0..count).map(|k| (by + 1.7 * k as f64).sin()).collect::<Vec<f64>>();
        let region = |name: &str, branches: Vec<[f64; 2]>| Region {
            name: name.into(),
            mu: 1e5,
            lambda: 1e6,
            stiffening: [1e3, -2e2],
            branches,
            weights: vec![1e-6; 5],
            gradients: wave(5 * 2 * 9, 0.3),
        };
        let (name, range) = ("left \"side\"".into(), [0.0, 2e4]);
        let chamber =
            Chamber { name, range, at_rest: 1e-5, linear: wave(2, 0.1), quadratic: wave(4, 0.2), cubic: wave(6, 0.5) };
        let section = Section { slope: wave(4, 0.4), value: wave(4, 0.9), by: [0.1, 0.2, 0.3, 0.4] };
        TwinData {
            mass: vec![1.0, 0.2, 0.2, 3.0],
            size: 2.0,
            regions: vec![region("silicone", vec![[0.1, 0.02], [0.2, 3.0]]), region("sheet", vec![])],
            chambers: vec![chamber],
            sections: vec![section],
            outputs: ["tip_x", "tip_y"]
                .map(|name| Output { name: name.into(), row: wave(2, 0.7), at_rest: 0.1 })
                .to_vec(),
            half: true,
            provenance: vec![("specimen".into(), "nemo".into()), ("version".into(), "0.1.0".into())],
        }
    }

    #[test]
    fn a_tail_survives_its_file() {
        let data = tail();
        assert_eq!(parse(&bytes(&data).unwrap(), Path::new("tail")).unwrap(), data);
        let bare = TwinData { chambers: vec![], sections: vec![], outputs: vec![], ..data };
        assert_eq!(parse(&bytes(&bare).unwrap(), Path::new("tail")).unwrap(), bare);
        Twin::new(bare).unwrap();
    }

    #[test]
    fn the_same_tail_gives_the_same_bytes_and_words_come_first() {
        let whole = bytes(&tail()).unwrap();
        assert_eq!(bytes(&tail()).unwrap(), whole);
        let begin = r#"{"__metadata__":{"counts":"coordinates=2;points=5,5;branches=2,0;chambers=1;sections=1;outputs=2","regions":"silicone,sheet","chambers":"left \"side\"","outputs":"tip_x,tip_y","symmetry":"half","provenance":"specimen=nemo;version=0.1.0"}"#;
        assert!(whole[8..].starts_with(begin.as_bytes()), "{}", String::from_utf8_lossy(&whole[8..200]));
    }

    #[test]
    fn arrays_that_do_not_belong_together_are_neither_written_nor_stepped() {
        let short = TwinData { mass: vec![1.0; 9], ..tail() };
        let error = Twin::new(short.clone()).unwrap_err();
        assert!(error.to_string().contains("`region0.gradients` has 90 numbers, not 135"), "{error}");
        assert_eq!(bytes(&short).unwrap_err(), error);
        assert!(Twin::new(TwinData { size: 0.0, ..tail() }).unwrap_err().to_string().contains("`size`"));
    }

    #[test]
    fn names_that_the_file_could_not_separate_and_ranges_that_fall_are_refused() {
        let refused = |data: TwinData| bytes(&data).unwrap_err().to_string();
        let (mut comma, mut falling, mut separator) = (tail(), tail(), tail());
        comma.regions[0].name = "a,b".into();
        falling.chambers[0].range = [1.0, 0.5];
        separator.provenance[0].1 = "x;y".into();
        assert!(refused(comma).contains("`regions` has the name \"a,b\""));
        assert!(refused(falling).contains("`chamber0.range`"));
        assert!(refused(separator).contains("`provenance`"));
    }
}
