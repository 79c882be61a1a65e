//! Tracking errors: which gate a marker failed, measured value against limit.

use crate::Gray;
use si::Point2;

/// A marker that is no longer seen, or not to be trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("marker {marker} is lost at frame {frame}, near ({:.1}, {:.1}) px\n  why: {why}\n  do:  look at frame {frame} of the film there; end the trial before it if something hides the marker", .near[0], .near[1])]
pub struct TrackingError {
    /// Which marker, in the order of the clicks.
    pub marker: usize,
    /// Which frame, from 0.
    pub frame: usize,
    /// Where it was looked for, px.
    pub near: Point2,
    /// Measured against limit.
    pub why: FailedGate,
    /// The frame around that place, to look at.
    pub crop: Gray,
}

/// Half the side of the crop around a lost marker, px.
const SHOWN: usize = 64;

/// Which marker is expected where in which frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    /// In the order of the clicks.
    pub(super) marker: usize,
    /// From 0.
    pub(super) frame: usize,
    /// Expected position, px.
    pub(super) near: Point2,
}

impl TrackingError {
    /// What a frame shows of a marker that fails a gate.
    pub(super) fn with_crop(picture: &Gray, Expected { marker, frame, near }: Expected, why: FailedGate) -> Self {
        let corner = near.map(|c| (c.round().max(0.0) as usize).saturating_sub(SHOWN));
        let side = if picture.check().is_ok() { 2 * SHOWN + 1 } else { 0 };
        let crop = picture.crop(corner[0], corner[1], side, side);
        Self { marker, frame, near, why, crop }
    }
}

/// Which gate a marker failed, with what was measured.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FailedGate {
    /// The marker's window leaves the picture.
    #[error("its window of radius {radius:.1} px leaves the picture of {width} × {height} px")]
    LeavesFrame {
        /// Radius of the window, px.
        radius: f64,
        /// Width of the picture, px.
        width: usize,
        /// Height of the picture, px.
        height: usize,
    },
    /// Nothing dark enough.
    #[error("it stands out by {measured:.1} grey levels; the limit is {limit:.1} (contrast_limit)")]
    LowContrast {
        /// Measured, grey levels.
        measured: f64,
        /// Limit, grey levels.
        limit: f64,
    },
    /// The marker looks different.
    #[error("its window differs by {measured:.2} grey levels a pixel; the limit is {limit:.2} (residual_limit)")]
    HighResidual {
        /// Measured, grey levels a pixel.
        measured: f64,
        /// Limit, grey levels a pixel.
        limit: f64,
    },
    /// A step too long.
    #[error("it moved by {measured:.1} px since the frame before; the limit is {limit:.1} (jump_limit)")]
    Jump {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// Flow and centroid point to different places.
    #[error("flow and centroid lie {measured:.2} px apart; the limit is {limit:.2} (flow_centroid_limit)")]
    FlowCentroid {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// Flow does not lead back.
    #[error(
        "flow there and back ends {measured:.2} px from its start; the limit is {limit:.2} (forward_backward_limit)"
    )]
    ForwardBackward {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// Nothing looks like the marker.
    #[error("nothing near correlates with it by more than {measured:.2}; the limit is {limit:.2} (correlation_limit)")]
    LowCorrelation {
        /// Measured, no unit.
        measured: f64,
        /// Limit, no unit.
        limit: f64,
    },
    /// A sudden change of the distance from a neighbour.
    #[error("its distance from marker {other} changed by {:.0} % since the frame before; the limit is {:.0} (neighbour_distance_limit)", 100.0 * .measured, 100.0 * .limit)]
    NeighbourDistance {
        /// The neighbour.
        other: usize,
        /// Measured, no unit.
        measured: f64,
        /// Limit, no unit.
        limit: f64,
    },
    /// Two clicks or two tracks on one marker.
    #[error("it is {measured:.1} px from marker {other}; two markers cannot be nearer than {limit:.1} px (radius)")]
    Merged {
        /// The other marker.
        other: usize,
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// No spot, but a dark region.
    #[error("{share:.0} % of the rim of its window is dark; a marker leaves all but {limit:.0} % light", share = 100.0 * .measured, limit = 100.0 * .limit)]
    DarkRim {
        /// Measured, no unit.
        measured: f64,
        /// Limit, no unit.
        limit: f64,
    },
    /// A click too far from any marker.
    #[error("the nearest dark spot lies {measured:.1} px from the click; the limit is {limit:.1} (click_radius)")]
    FarFromClick {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// A window too small for a marker.
    #[error("its window has the radius {measured} px; the least is {limit:.1} (radius)")]
    SmallWindow {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// A frame that lacks grey levels.
    #[error("the picture has {levels} grey levels for {width} × {height} px")]
    Levels {
        /// Grey levels.
        levels: usize,
        /// Width of the picture, px.
        width: usize,
        /// Height of the picture, px.
        height: usize,
    },
    /// A frame of another size.
    #[error("the picture has {width} × {height} px, the first one had another size")]
    Resized {
        /// Width of the picture, px.
        width: usize,
        /// Height of the picture, px.
        height: usize,
    },
}
