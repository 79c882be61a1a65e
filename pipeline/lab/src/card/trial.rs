//! `[[trial]]`: one recording, and what was asked of the specimen in it.
//!
//! Stands on: `si`. Never knows: what was measured in it.

use serde::Deserialize;
use si::{Hertz, Pascal, Second};

/// One recording.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Flat")]
pub struct Trial {
    /// Its name, unique on the card.
    pub id: String,
    /// What it may be used for.
    pub role: Role,
    /// What surrounds the specimen.
    pub medium: Medium,
    /// Video, relative to the card.
    pub video: String,
    /// Pressure log, relative to the card.
    pub pressure: String,
    /// Force log, relative to the card, where the specimen hung on a load cell.
    pub force: Option<String>,
    /// What it is to the learning of thrust; nothing when the card is silent.
    pub split: Option<Split>,
    /// First frame worth using; the markers are clicked in this one. 0 when the card is silent.
    pub first_frame: usize,
    /// Last frame worth using; the end of the video when the card is silent.
    pub last_frame: Option<usize>,
    /// What was done.
    pub experiment: Experiment,
}

/// What was done in a trial.
#[derive(Debug, Clone, PartialEq)]
pub enum Experiment {
    /// One side is filled to a level, held, emptied, and filled to the next.
    Staircase {
        /// The side that is filled.
        side: Side,
        /// Commanded pressures, Pa, in their order.
        levels: Vec<Pascal>,
        /// How long each level is commanded, s.
        hold: Second,
        /// How long the side is open to air between levels, s.
        pause: Second,
    },
    /// Both sides in turn, in a square wave.
    Flapping {
        /// The side that is filled first.
        side: Side,
        /// Commanded pressure, Pa.
        amplitude: Pascal,
        /// Full cycles (left and right) a second.
        frequency: Hertz,
        /// Full cycles.
        cycles: usize,
    },
}

/// What a trial may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters may be fitted to it.
    Identify,
    /// Never fitted to; a model is judged by it.
    Validate,
    /// Thrust is learnt from it or judged by it, as its split says.
    Thrust,
}

/// What a trial is to the learning of thrust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// Models are fitted to it.
    Train,
    /// Models are judged by it.
    Test,
}

/// What surrounds the specimen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Medium {
    /// Air.
    Air,
    /// Water.
    Water,
}

/// A side of the specimen: its chambers and its columns in the pressure log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Positive y.
    Left,
    /// Negative y.
    Right,
}

impl Role {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Validate => "validate",
            Self::Thrust => "thrust",
        }
    }
}

impl Split {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Test => "test",
        }
    }
}

impl Medium {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::Water => "water",
        }
    }
}

impl Side {
    /// The word on the card and in the log.
    pub fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// The other side.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

impl Experiment {
    /// The word on the card.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Staircase { .. } => "staircase",
            Self::Flapping { .. } => "flapping",
        }
    }

    /// The side that is filled first, or alone.
    pub fn side(&self) -> Side {
        match self {
            Self::Staircase { side, .. } | Self::Flapping { side, .. } => *side,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Staircase,
    Flapping,
}

/// A trial as it stands on the card: the keys of every kind side by side.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Flat {
    id: String,
    kind: Kind,
    role: Role,
    medium: Medium,
    side: Side,
    video: String,
    pressure: String,
    force: Option<String>,
    split: Option<Split>,
    first_frame: Option<usize>,
    last_frame: Option<usize>,
    levels: Option<Vec<Pascal>>,
    hold: Option<Second>,
    pause: Option<Second>,
    amplitude: Option<Pascal>,
    frequency: Option<Hertz>,
    cycles: Option<usize>,
}

impl TryFrom<Flat> for Trial {
    type Error = String;

    fn try_from(flat: Flat) -> Result<Self, String> {
        let experiment = flat.experiment().map_err(|said| format!("{said} in trial `{}`", flat.id))?;
        Ok(Self {
            experiment,
            id: flat.id,
            role: flat.role,
            medium: flat.medium,
            video: flat.video,
            pressure: flat.pressure,
            force: flat.force,
            split: flat.split,
            first_frame: flat.first_frame.unwrap_or(0),
            last_frame: flat.last_frame,
        })
    }
}

impl Flat {
    fn experiment(&self) -> Result<Experiment, String> {
        let side = self.side;
        match self.kind {
            Kind::Staircase => {
                refuse("staircase", "amplitude", &self.amplitude)?;
                refuse("staircase", "frequency", &self.frequency)?;
                refuse("staircase", "cycles", &self.cycles)?;
                let levels = need("staircase", "levels", &self.levels)?;
                let (hold, pause) = (need("staircase", "hold", &self.hold)?, need("staircase", "pause", &self.pause)?);
                Ok(Experiment::Staircase { side, levels, hold, pause })
            }
            Kind::Flapping => {
                refuse("flapping", "levels", &self.levels)?;
                refuse("flapping", "hold", &self.hold)?;
                refuse("flapping", "pause", &self.pause)?;
                Ok(Experiment::Flapping {
                    side,
                    amplitude: need("flapping", "amplitude", &self.amplitude)?,
                    frequency: need("flapping", "frequency", &self.frequency)?,
                    cycles: need("flapping", "cycles", &self.cycles)?,
                })
            }
        }
    }
}

fn need<T: Clone>(kind: &str, key: &str, value: &Option<T>) -> Result<T, String> {
    value.clone().ok_or_else(|| format!("kind `{kind}` needs the key `{key}`, which is missing"))
}

fn refuse<T>(kind: &str, key: &str, value: &Option<T>) -> Result<(), String> {
    match value {
        None => Ok(()),
        Some(_) => Err(format!("kind `{kind}` has no key `{key}`, but it is given")),
    }
}
