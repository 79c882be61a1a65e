//! Thrust models: mean thrust and thrust over time from motion and pressure, from the mean to a neural network.
//!
//! [`outline`] is the shape of a tail for elongated-body theory; [`run`] is one flapping trial as evenly spaced samples; `models/` has one
//! file a kind of model, and [`MODELS`] is their list; [`splits`] chooses training and test runs; [`score`] computes errors on test
//! runs with bootstrap intervals. [`square_wave`] is the actuation. [`simulated`] evaluates a trained model on the motion of the full
//! finite-element model with its adjoint gradient, [`flapping`] on that of the reduced model in [`water`]; [`ascent`] maximises either.
//! [`waveform`] is an actuation of many harmonics behind a valve, which [`waveform_thrust`] optimises by the adjoint of a
//! [`twin::Twin`]; [`optimal_waveform`] sets the optima beside square waves and a recorded flap, [`square_wave_search`] is the search among those. [`underwater`] is that model under measured
//! pressures; [`release`] identifies the
//! coefficients of that water; [`real_time`] makes the reduced model a [`twin::Twin`], which steps faster than real time.
//!
//! ```
//! use thrust::square_wave::SquareWave;
//! // the two sides alternate: at every instant their pressures add up to the amplitude
//! let wave = SquareWave { amplitude: 2e4, frequency: 2.0, sharpness: 5.0 };
//! let pressures = wave.at(0.1);
//! assert!((pressures[0] + pressures[1] - 2e4).abs() < 1e-9 && pressures[0] > pressures[1]);
//! ```
//!
//! Depends on `diagnostics`, `fem`, `hydro`, `lab` (cards), `mesh`, `optimize`, `si`, `signal`, `sysid`, `twin`.

pub mod ascent;
pub mod flapping;
pub mod models;
pub mod optimal_waveform;
pub mod outline;
pub mod real_time;
pub mod release;
pub mod run;
pub mod score;
pub mod simulated;
pub mod splits;
pub mod square_wave;
pub mod square_wave_search;
pub mod underwater;
pub mod water;
pub mod waveform;
pub mod waveform_thrust;

pub use models::{Fitted, MODELS, ThrustModel, TrainingSettings};
pub use run::Run;
