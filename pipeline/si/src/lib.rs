//! SI units as type aliases, points, and evenly sampled series.
//!
//! All quantities are in SI units: metre, second, pascal, newton, radian. The aliases are not checked by the compiler; they document
//! a signature. `paper/symbols.md` lists the symbols of formulas.
//!
//! ```
//! use si::{Second, Series};
//!
//! let pressure = Series::new(0.0, 200.0, vec![0.0, 100.0, 300.0])?;
//! let time: Second = 0.0075;
//! assert_eq!(pressure.at(time), 200.0);
//! # Ok::<(), si::SeriesError>(())
//! ```
//!
//! Depends on no other crate of the workspace.

mod modulus_unit;
mod series;
pub mod vec3;

pub use modulus_unit::ModulusUnit;
pub use series::{Series, SeriesError};

/// Length, m.
pub type Metre = f64;
/// Time, s.
pub type Second = f64;
/// Stress or pressure, Pa.
pub type Pascal = f64;
/// Force, N.
pub type Newton = f64;
/// Energy, J.
pub type Joule = f64;
/// Angle, rad.
pub type Radian = f64;
/// Frequency or sampling rate, 1/s.
pub type Hertz = f64;
/// Area, m².
pub type SquareMetre = f64;
/// Volume, m³.
pub type CubicMetre = f64;
/// Density, kg/m³.
pub type KilogramPerCubicMetre = f64;
/// Mass, kg.
pub type Kilogram = f64;
/// Acceleration, m/s².
pub type MetrePerSecondSquared = f64;

/// A point or vector in a plane; its unit is stated where it is used (px in `track`, m elsewhere).
pub type Point2 = [f64; 2];
/// A point or vector in space, m unless stated otherwise.
pub type Point3 = [f64; 3];

/// One millibar in pascal, for the logs of valves and the axes of figures.
pub const MILLIBAR: Pascal = 100.0;
/// One millimetre in metres, for CAD files and the axes of figures.
pub const MILLIMETRE: Metre = 1e-3;
