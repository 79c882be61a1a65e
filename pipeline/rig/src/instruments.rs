//! The force instruments of the bench: what a load cell in air or over a tank would say, and all that is not thrust in it.
//!
//! force on the fixture → a light mass on a spring → the cell → standing waves and buoyancy beside it → drift, noise and
//! steps of the amplifier → a log on its own clock. Each is a file of its own.
//!
//! Stands on: the settings, chance. Never knows: finite elements, a camera.

pub mod amplifier;
pub mod buoyancy;
pub mod cell;
pub mod fixture;
pub mod hammer;
pub mod oscillator;
pub mod tank;
