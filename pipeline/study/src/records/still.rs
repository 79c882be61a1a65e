//! Still: two frames of one film, the tail at rest and held under pressure, with what was seen in them.

use serde::{Deserialize, Serialize};
use si::{Pascal, Point2, Second};
use track::Gray;

use crate::record::{Parcel, Record, RecordError};
use crate::subject::Trial;

/// Two frames of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// The first frame that is used: the tail at rest.
    pub rest: Gray,
    /// The tail under pressure.
    pub held: Gray,
    /// What was seen in both.
    pub seen: Seen,
}

/// What was seen in the frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// When the frame under pressure was taken, s on the video's clock.
    pub time_s: Second,
    /// What was asked for there, Pa.
    pub command_pa: Pascal,
    /// Measured pressures in the order of the card's chambers, Pa.
    pub pressures_pa: Vec<Pascal>,
    /// The markers at rest, px.
    pub rest_px: Vec<Point2>,
    /// The markers under pressure, px.
    pub held_px: Vec<Point2>,
    /// Pixels in a metre at the markers' height.
    pub px_per_m: f64,
    /// The part of the picture in which the tail moves: left, top, right, bottom, px.
    pub window_px: [usize; 4],
}

impl Record for Still {
    type Of = Trial;
    const STAGE: &'static str = "still";

    fn is_made_for(of: &Trial) -> bool {
        of.in_space().is_none() && of.is_highest_staircase()
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        let png = |name: &str, picture: &Gray| {
            picture.to_png().map_err(|e| RecordError::Scalars { file: name.into(), cause: e.to_string() })
        };
        Parcel::default()
            .file(REST, png(REST, &self.rest)?)
            .file(HELD, png(HELD, &self.held)?)
            .scalars("still.json", &self.seen)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let picture = |name: &str| {
            Gray::from_png(parcel.bytes(name)?)
                .map_err(|e| RecordError::Scalars { file: name.into(), cause: e.to_string() })
        };
        Ok(Self { rest: picture(REST)?, held: picture(HELD)?, seen: parcel.read_scalars("still.json")? })
    }

    fn telling(&self) -> String {
        let most = self.seen.pressures_pa.iter().copied().fold(0.0, f64::max);
        format!("{:.0} mbar at {:.2} s", most / si::MILLIBAR, self.seen.time_s)
    }
}

const REST: &str = "rest.png";
const HELD: &str = "held.png";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_frames_survive_their_record() {
        let picture = |by: usize| Gray::from_fn(5, 4, |x, y| (by * (x + 5 * y)) as f64);
        let seen = Seen {
            time_s: 1.5,
            command_pa: 25e3,
            pressures_pa: vec![24.1e3, 0.0],
            rest_px: vec![[1.0, 2.0]],
            held_px: vec![[1.5, 2.5]],
            px_per_m: 5200.0,
            window_px: [0, 0, 5, 4],
        };
        let still = Still { rest: picture(3), held: picture(7), seen };
        assert_eq!(Still::unpack(&still.pack().unwrap()).unwrap(), still);
    }
}
