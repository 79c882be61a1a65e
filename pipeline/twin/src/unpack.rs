//! A reduced tail from the bytes of its file: every array that the counts ask for, of exactly that shape, and no other.

use std::collections::BTreeSet;

use safetensors::{Dtype, SafeTensors};

use crate::data::{Chamber, Output, Region, Section, TwinData};
use crate::layout::{Array, Counts};
use crate::metadata::{COUNTS, Description};

/// Letters of a file's text that a message repeats.
const LONGEST: usize = 60;

/// The tail in a file's content; the numbers themselves are checked by [`TwinData::check`].
pub(crate) fn unpack_file(bytes: &[u8]) -> Result<TwinData, String> {
    let file = SafeTensors::deserialize(bytes).map_err(|e| e.to_string())?;
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| e.to_string())?;
    let stated = metadata.metadata().as_ref().ok_or("it has no metadata")?;
    let counts = stated.get(COUNTS).ok_or_else(|| format!("its metadata have no `{COUNTS}`"))?;
    let counts = Counts::parse(counts)
        .filter(|counts| counts.fit_into(bytes.len(), file.len()))
        .ok_or_else(|| format!("its metadata state the {COUNTS} {:?}", shortened_text(counts)))?;
    let description = Description::parse(stated, &counts)?;
    let arrays = counts.arrays();
    let known_names: BTreeSet<&str> = arrays.iter().map(|array| &*array.name).collect();
    if let Some(extra) = file.names().into_iter().find(|name| !known_names.contains(*name)) {
        return Err(format!("it has the array {:?}, which no tail of these counts has", shortened_text(extra)));
    }
    let values = arrays.iter().map(|array| array_values(&file, array)).collect::<Result<Vec<_>, _>>()?;
    Ok(assemble_data(&counts, description, values.into_iter()))
}

/// The begin of a text that others wrote, for a message of one line.
fn shortened_text(text: &str) -> String {
    text.chars().take(LONGEST).collect()
}

/// The numbers of one array.
fn array_values(file: &SafeTensors, array: &Array) -> Result<Vec<f64>, String> {
    let Array { name, shape, .. } = array;
    let tensor = file.tensor(name).map_err(|_| format!("it has no array `{name}`"))?;
    if tensor.dtype() != Dtype::F64 {
        return Err(format!("`{name}` holds {:?}, not F64", tensor.dtype()));
    }
    if tensor.shape() != shape {
        return Err(format!("`{name}` has the shape {:?}, not {shape:?}", tensor.shape()));
    }
    let number = |bytes: &[u8]| f64::from_le_bytes(std::array::from_fn(|i| bytes[i]));
    // length: safetensors holds an array to the bytes of its shape, and the shape is the one that is asked for
    Ok(tensor.data().chunks_exact(size_of::<f64>()).map(number).collect())
}

/// The tail of the numbers of every array, in the order of [`Counts::arrays`].
// Each array has the shape that the same counts gave, so that no row is left over and none is missing.
fn assemble_data(counts: &Counts, description: Description, mut values: impl Iterator<Item = Vec<f64>>) -> TwinData {
    let r = counts.coordinates.max(1);
    let mut next = || values.next().unwrap_or_default();
    let (mass, size) = (next(), next()[0]);
    let Description { regions, chambers, outputs, half, provenance } = description;
    let regions = regions.into_iter().map(|name| unpack_region(name, [next(), next(), next(), next()])).collect();
    let chambers =
        chambers.into_iter().map(|name| unpack_chamber(name, [next(), next(), next(), next(), next()])).collect();
    let [slope, value, by] = [next(), next(), next()];
    let section = |i: usize| Section {
        slope: slope[2 * r * i..2 * r * (i + 1)].to_vec(),
        value: value[2 * r * i..2 * r * (i + 1)].to_vec(),
        by: std::array::from_fn(|k| by[4 * i + k]),
    };
    let sections = (0..counts.sections).map(section).collect();
    let [rows, at_rest] = [next(), next()];
    let output = |(i, name)| Output { name, row: rows[r * i..r * (i + 1)].to_vec(), at_rest: at_rest[i] };
    let outputs = outputs.into_iter().enumerate().map(output).collect();
    TwinData { mass, size, regions, chambers, sections, outputs, half, provenance }
}

fn unpack_region(name: String, [moduli, branches, weights, gradients]: [Vec<f64>; 4]) -> Region {
    Region {
        name,
        mu: moduli[0],
        lambda: moduli[1],
        stiffening: [moduli[2], moduli[3]],
        // length: branches have the shape [branches, 2]
        branches: branches.chunks_exact(2).map(|branch| [branch[0], branch[1]]).collect(),
        weights,
        gradients,
    }
}

fn unpack_chamber(name: String, [range, at_rest, linear, quadratic, cubic]: [Vec<f64>; 5]) -> Chamber {
    Chamber { name, range: [range[0], range[1]], at_rest: at_rest[0], linear, quadratic, cubic }
}
