//! The force instruments of the bench: the load cell in air or above a tank, with everything in its reading that is not thrust.
//!
//! Force on the fixture → a light mass on a spring → the cell, with standing waves and buoyancy added → drift, noise and quantisation of the
//! amplifier → a log on its own clock.

pub(crate) mod amplifier;
pub(crate) mod buoyancy;
pub(crate) mod cell;
pub(crate) mod fixture;
pub(crate) mod hammer;
pub(crate) mod oscillator;
pub(crate) mod tank;
