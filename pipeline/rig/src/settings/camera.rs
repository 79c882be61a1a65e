//! Settings of the camera, the objects beside the tail and the water surface.

use serde::Deserialize;
use si::{Hertz, Metre, Point2, Point3, Radian, Second};

/// The camera.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// px.
    pub width: usize,
    /// px.
    pub height: usize,
    /// Frames a second.
    pub rate: Hertz,
    /// Range of fx, px.
    pub focal: [f64; 2],
    /// fy / fx.
    pub aspect: f64,
    /// Principal point, px.
    pub centre: Point2,
    /// k1, k2, k3.
    pub radial: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
    /// Position, m, CAD frame.
    pub above: Point3,
    /// Rotations about the image axes right, down and view, degrees.
    pub tilt: [f64; 3],
    /// Exposure time around the frame's time, s. The lamp's brightness is averaged over it; the tail is drawn at each row's time, without
    /// motion blur.
    pub exposure: Second,
    /// From the first row's time to the last one's, s.
    pub readout: Second,
    /// Standard deviation of a pixel, grey levels.
    pub noise: f64,
    /// Quantiser of H.264.
    pub quantiser: u8,
}

/// The plane under the tail, and the checkerboard that is laid on it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// z, m.
    pub height: Metre,
    /// Of the grid, m.
    pub pitch: Metre,
    /// Width of a grid line, m.
    pub line: Metre,
    /// Squares of the checkerboard.
    pub columns: usize,
    /// Squares of the checkerboard.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
    /// Place of its inner corner (0, 0), m.
    pub corner: Point2,
}

/// The film of the checkerboard.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Frames in each pose.
    pub held: usize,
    /// Frames between two poses.
    pub moving: usize,
    /// Frames on the plane, at the end.
    pub flat: usize,
}

/// The lamp.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Its centre, m.
    pub at: Point3,
    /// Its radius, m.
    pub radius: Metre,
}

/// The water over the tail.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// z of the surface as measured, m.
    pub surface: Metre,
    /// Range of the error of that measurement, m.
    pub surface_error: [Metre; 2],
    /// Refractive index, no unit.
    pub index: f64,
    /// Root of the mean squared slope of the ripples, rad.
    pub ripple: [Radian; 2],
    /// Lengths of their waves, m.
    pub wavelength: [Metre; 2],
    /// Number of diffuse reflections, which move with the ripples.
    pub glints: usize,
    /// Range of their brightness, grey levels.
    pub glint: [f64; 2],
    /// Range of their width (standard deviation), px.
    pub glint_size: [f64; 2],
}
