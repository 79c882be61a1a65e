//! Surfaces: which is the body, its unit, and the actuator's length.

use diagnostics::input;

use super::files::Recording;

/// A surface and its size in the file's own unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solid {
    pub(super) name: String,
    /// Longest side and volume in the file's unit.
    pub(super) length: f64,
    pub(super) volume: f64,
}

/// The surface of a file; none where it holds none.
pub(super) fn solid(recording: &Recording) -> Option<Solid> {
    let bytes = input::read(&recording.path, input::MESH).ok()?;
    // the reader refuses what is too small or too large in the unit that it is told
    let in_unit = |unit: f64| Some((unit, mesh::stl::read(&bytes, unit).ok()?));
    let (factor, surface) = [1e-3, 1.0].into_iter().find_map(in_unit)?;
    let (length, volume) = (surface.length() / factor, surface.volume().abs() / factor.powi(3));
    Some(Solid { name: recording.name.clone(), length, volume })
}

/// The unit in which a longest side is that of an actuator of hand size: its word and its metres.
pub(super) fn unit(length: f64) -> (&'static str, f64) {
    match length {
        ..1.5 => ("m", 1.0),
        _ => ("mm", 1e-3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_actuator_of_hand_size_has_its_unit() {
        assert_eq!((unit(120.0).0, unit(0.12).0), ("mm", "m"));
    }
}
