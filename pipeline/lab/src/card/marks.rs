//! `[search]` and `[[tracks]]`: detection of markers that are not clicked, and tracks from other programs.

use serde::{Deserialize, Serialize};
use si::{Point3, Second};

/// `[search]`: markers are found in the first frame of every trial, as many as the card has.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// Left, top, right and bottom of the part of the picture that holds the markers and nothing like them, px.
    pub region: [f64; 4],
    /// Direction in the picture from the card's first marker to its last; detected markers are named in this order.
    #[serde(default)]
    pub order: Order,
    /// The detector.
    #[serde(default)]
    pub by: Detector,
}

/// A direction in the picture, along which markers follow each other as they do on the card.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// The first marker is the leftmost.
    #[default]
    Rightwards,
    /// The first marker is the rightmost.
    Leftwards,
    /// The first marker is the uppermost.
    Downwards,
    /// The first marker is the lowermost.
    Upwards,
}

/// The detector of the markers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// A dark spot on ground that is light all around it.
    #[default]
    Spots,
    /// The strongest corners (Shi and Tomasi's measure), then the dark spot of each: for marks such as crosses on ground that
    /// has dark spots of its own.
    Corners,
}

/// `[[tracks]]`: the markers of one trial, tracked by another program or instrument.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tracks {
    /// The trial's id.
    pub trial: String,
    /// CSV of `study track` or of DeepLabCut in px; with `space`, a .c3d or the CSV of [`crate::space`]. Relative to the card;
    /// its markers are named as on the card.
    pub file: String,
    /// Standard deviation of a place along each axis, where the file has none: px, with `space` m.
    pub sigma: f64,
    /// Axes of the file, where its points are in space.
    #[serde(default)]
    pub space: Option<Axes>,
}

/// `[tracks.space]`: the CAD frame in the file's axes, and the time of the file's first frame.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// When the file's first frame is, s on the film's clock; of a trial without a film, on the clock of its pressure log, or as that log writes
    /// dates and times of day.
    #[serde(default, deserialize_with = "second_or_stamp")]
    pub start: Second,
    /// Where the CAD frame's origin lies, m.
    #[serde(default)]
    pub origin: Point3,
    /// Where the CAD frame's x points, of length 1.
    #[serde(default = "x_axis")]
    pub x: Point3,
    /// Where the CAD frame's z points, of length 1.
    #[serde(default = "z_axis")]
    pub z: Point3,
}

/// Seconds, or a date or time of day in a text.
fn second_or_stamp<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Second, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Stamp {
        Second(Second),
        Text(String),
    }
    match Stamp::deserialize(from)? {
        Stamp::Second(second) => Ok(second),
        Stamp::Text(text) => crate::log::iso8601(&text).ok_or_else(|| {
            serde::de::Error::custom(format!(
                "`{text}` is no time; seconds, 2024-05-01T12:00:00.125 or 12:00:00.125 were expected"
            ))
        }),
    }
}

fn x_axis() -> Point3 {
    [1.0, 0.0, 0.0]
}

fn z_axis() -> Point3 {
    [0.0, 0.0, 1.0]
}

impl Order {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rightwards => "rightwards",
            Self::Leftwards => "leftwards",
            Self::Downwards => "downwards",
            Self::Upwards => "upwards",
        }
    }
}

impl Detector {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Spots => "spots",
            Self::Corners => "corners",
        }
    }
}
