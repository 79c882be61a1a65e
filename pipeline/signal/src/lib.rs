//! Processing of sampled signals: edges, clocks, resampling, zero-phase filtering, and the corrections of a force log.
//!
//! | module | method |
//! |---|---|
//! | [`edge`], [`clock`] | sub-sample edges of a two-level signal; an affine map between two clocks |
//! | [`resample`], [`smooth`], [`spectrum`] | linear interpolation; forward–backward Butterworth filter; Fourier transform |
//! | [`cell`] | transfer function of a load cell from hammer taps; regularised deconvolution |
//! | [`wave`] | standing waves in a tank: identified in still water where they rise over the noise, subtracted from a run |
//! | [`zero`] | the line of an amplifier's zero through the rests before and after a run |
//! | [`crosstalk`] | static cross-talk of pressure into force, by non-negative least squares |
//!
//! A signal is a [`si::Series`] (evenly sampled) or [`resample::Samples`] (each value with its own time).
//!
//! ```
//! use si::Series;
//! use signal::smooth::low_pass;
//!
//! let wave = |i: i32| (0.05 * f64::from(i)).sin() + 0.1 * (2.5 * f64::from(i)).sin();
//! let signal = Series::new(0.0, 100.0, (0..400).map(wave).collect()).expect("finite values");
//! let smooth = low_pass(&signal, 5.0, 2).expect("a cutoff below 50 Hz");
//! // the component of 40 Hz is removed, that of 0.8 Hz is not delayed
//! assert!((smooth.values()[200] - (0.05_f64 * 200.0).sin()).abs() < 1e-2);
//! ```
//!
//! Depends on `si`, `optimize` (least squares), nalgebra and realfft. Paper, section IV.

pub mod cell;
pub mod clock;
pub mod crosstalk;
pub mod edge;
mod polynomial;
pub mod resample;
pub mod smooth;
pub mod spectrum;
pub mod statistics;
pub mod step_response;
#[cfg(test)]
mod testing;
pub mod wave;
pub mod zero;

pub use polynomial::EstimationError;
