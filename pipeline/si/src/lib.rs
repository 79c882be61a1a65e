//! The ground floor: units as words, points, and evenly sampled series.
//!
//! Everything in the house is in SI: metre, second, pascal, newton, radian. The aliases carry no checking; they say
//! in a signature what a number is. `paper/symbols.md` has the letters that formulas use.
//!
//! Stands on: nothing of the house. Never knows: a tail, a mesh, a file.

mod series;
pub mod vec3;

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

/// A point or vector in a plane; its unit is said where it is used (m in `shape` and `lab`, px in `track`).
pub type Point2 = [f64; 2];
/// A point or vector in space, m unless said otherwise.
pub type Point3 = [f64; 3];

/// One millibar in pascal, for the logs of valves and the axes of figures.
pub const MILLIBAR: Pascal = 100.0;
/// One millimetre in metres, for CAD files and the axes of figures.
pub const MILLIMETRE: Metre = 1e-3;
