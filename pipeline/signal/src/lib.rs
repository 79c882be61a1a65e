//! Signals in time: edges, clocks, samples on other times, filters.
//!
//! A signal is a [`si::Series`] (evenly sampled, knows its rate) or [`resample::Samples`] (each value with its own time).
//!
//! Stands on: `si`, nalgebra, realfft. Never knows: what was measured, by which instrument, in which trial. Paper: section IV.

pub mod cell;
pub mod clock;
pub mod crosstalk;
pub mod edge;
pub mod resample;
pub mod smooth;
pub mod spectrum;
mod squares;
#[cfg(test)]
mod testing;
pub mod wave;

pub use squares::FitFailed;
