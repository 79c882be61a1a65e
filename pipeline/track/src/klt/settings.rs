//! Settings of the tracker: what it expects of markers, and the limits of its gates.

/// What the tracker expects of markers and what it refuses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Radius of the disc that holds a whole marker with a margin of light background, px.
    pub radius: f64,
    /// How far a clicked position may lie from the marker's centre, px.
    pub click_radius: f64,
    /// Least difference between background and marker, grey levels.
    pub contrast_limit: f64,
    /// Largest mean difference from the marker of the first frame, grey levels a pixel.
    pub residual_limit: f64,
    /// Largest step between two frames, of a marker by itself or against its neighbour, px. Together they may move by twice that.
    pub jump_limit: f64,
    /// Largest distance between flow and centroid, px.
    pub flow_centroid_limit: f64,
    /// Largest distance from its start at which flow that is followed there and back may end, px.
    pub forward_backward_limit: f64,
    /// Largest change of the distance between neighbouring markers from one frame to the next, as a share of it.
    pub neighbour_distance_limit: f64,
    /// Least correlation with the marker of the first frame at which a hidden marker is found again, no unit.
    pub correlation_limit: f64,
    /// How many frames in a row a marker may be hidden.
    pub patience: usize,
    /// Quantiser of the codec that the film went through (H.264, 0 to 51); 0 for none.
    pub quantiser: u8,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            radius: 18.0,
            click_radius: 9.0,
            contrast_limit: 25.0,
            residual_limit: 12.0,
            jump_limit: 20.0,
            flow_centroid_limit: 2.0,
            forward_backward_limit: 1.0,
            neighbour_distance_limit: 0.35,
            correlation_limit: 0.8,
            patience: 0,
            quantiser: 20,
        }
    }
}
