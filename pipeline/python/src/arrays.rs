//! Arrays of numpy as slices, and vectors as arrays, without copies.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::errors::input_error;

/// One-dimensional, contiguous, of double precision: what the Python part of the package hands over.
pub(crate) type Reals<'py> = PyReadonlyArray1<'py, f64>;

/// An array that takes a vector over; it is read-only where the solver may read it again.
pub(crate) fn numpy_array<'py>(py: Python<'py>, values: Vec<f64>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, values)
}

/// The numbers of an array.
///
/// # Errors
/// `InputError` when they do not lie one after the other.
pub(crate) fn number_slice<'a>(name: &str, values: &'a Reals<'_>) -> PyResult<&'a [f64]> {
    values.as_slice().map_err(|_| {
        input_error(
            format!("{name} is not contiguous"),
            "its numbers do not lie one after the other",
            "pass a copy of it",
        )
    })
}

/// The numbers of an array as a vector.
///
/// # Errors
/// As [`number_slice`].
pub(crate) fn number_vector(name: &str, values: &Reals<'_>) -> PyResult<Vec<f64>> {
    number_slice(name, values).map(<[f64]>::to_vec)
}

/// The power of two just below the largest of `numbers`, 1 where all are 0. Derivatives are linear in cotangents and directions, so that what is
/// divided by it before and multiplied after keeps its digits, and products of its numbers neither overflow nor vanish.
pub(crate) fn scale_of<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    let largest = numbers.into_iter().fold(0.0_f64, |most, number| most.max(number.abs()));
    if largest > 0.0 && largest.is_finite() { largest.log2().floor().clamp(-1000.0, 1000.0).exp2() } else { 1.0 }
}

/// Node numbers of elements of `N` nodes, from whole numbers of any sign.
///
/// # Errors
/// `InputError` when one is below 0 or too large.
pub(crate) fn node_numbers(values: &[i64]) -> PyResult<Vec<u32>> {
    let number = |&value: &i64| {
        u32::try_from(value).map_err(|_| {
            input_error(
                format!("an element names the node {value}"),
                "nodes are counted from 0, and there are at most 4294967295",
                "check the elements",
            )
        })
    };
    values.iter().map(number).collect()
}

/// Whether an array's length is that of an axis.
///
/// # Errors
/// `InputError` when it is not.
pub(crate) fn check_length(name: &str, given: usize, required: usize) -> PyResult<()> {
    if given == required {
        return Ok(());
    }
    Err(input_error(format!("{name} has {given} numbers"), format!("{required} are required"), "check its shape"))
}
