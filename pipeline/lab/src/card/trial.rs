//! `[[trial]]`: one recording and its commanded pressures.

use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal, Second};

/// One recording.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "Entry")]
pub struct Trial {
    /// Its name, unique on the card.
    pub id: String,
    /// The use of its motion.
    pub role: Role,
    /// The use of its force in the training of thrust models.
    pub split: Option<Split>,
    /// What surrounds the specimen.
    pub medium: Medium,
    /// Video, relative to the card; none where the markers were measured in space and nothing was filmed.
    pub video: Option<String>,
    /// Pressure log, relative to the card.
    pub pressure: String,
    /// Force log, relative to the card, where the specimen hung on a load cell.
    pub force: Option<String>,
    /// First frame worth using; the markers are clicked in this one. 0 by default.
    pub first_frame: usize,
    /// Last frame worth using; the end of the video by default.
    pub last_frame: Option<usize>,
    /// What was done.
    pub experiment: Experiment,
}

/// What was done in a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Experiment {
    /// Channels are filled to a level, held, vented, and filled to the next.
    Staircase {
        /// The channels that are filled, together.
        channels: Vec<String>,
        /// Commanded pressures, Pa, in their order.
        levels: Vec<Pascal>,
        /// How long each level is commanded, s.
        hold: Second,
        /// How long the channels are open to air between levels, s.
        pause: Second,
    },
    /// Channels in turn, in a square wave: each for an equal part of the cycle, a single one for half of it.
    Flapping {
        /// The channels, in the order in which they are filled.
        channels: Vec<String>,
        /// Commanded pressure, Pa.
        amplitude: Pascal,
        /// Full cycles a second.
        frequency: Hertz,
        /// Full cycles.
        cycles: usize,
    },
}

/// The use of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters may be fitted to it.
    Identify,
    /// Validation data, never fitted to.
    Validate,
    /// Neither: recorded for its force.
    Thrust,
}

/// The part of the data of thrust models to which a trial belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// Training data.
    Train,
    /// Test data, never used in training.
    Test,
}

/// What surrounds the specimen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Medium {
    /// Air.
    Air,
    /// Water.
    Water,
}

impl Role {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Validate => "validate",
            Self::Thrust => "thrust",
        }
    }
}

impl Split {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Test => "test",
        }
    }
}

impl Medium {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::Water => "water",
        }
    }
}

impl Experiment {
    /// From the first command to the end of the last, s.
    pub fn duration(&self) -> Second {
        match self {
            Self::Staircase { levels, hold, pause, .. } => levels.len() as f64 * (hold + pause) - pause,
            Self::Flapping { frequency, cycles, .. } => *cycles as f64 / frequency,
        }
    }

    /// The value on the card.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Staircase { .. } => "staircase",
            Self::Flapping { .. } => "flapping",
        }
    }

    /// The channels that it drives: together in a staircase, in turn when flapping.
    pub fn channels(&self) -> &[String] {
        match self {
            Self::Staircase { channels, .. } | Self::Flapping { channels, .. } => channels,
        }
    }

    /// The highest commanded pressure of a staircase, Pa; none of a flapping trial.
    pub fn highest_level(&self) -> Option<Pascal> {
        match self {
            Self::Staircase { levels, .. } => levels.iter().copied().reduce(f64::max),
            Self::Flapping { .. } => None,
        }
    }

    /// The channels that are filled first.
    pub fn first_channels(&self) -> &[String] {
        match self {
            Self::Staircase { channels, .. } => channels,
            Self::Flapping { channels, .. } => &channels[..1],
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Staircase,
    Flapping,
}

/// The keys of a trial on the card, of all kinds.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: String,
    kind: Kind,
    role: Role,
    split: Option<Split>,
    medium: Medium,
    /// Earlier cards name the side that is filled first.
    #[serde(alias = "side")]
    channels: Driven,
    video: Option<String>,
    pressure: String,
    force: Option<String>,
    first_frame: Option<usize>,
    last_frame: Option<usize>,
    levels: Option<Vec<Pascal>>,
    hold: Option<Second>,
    pause: Option<Second>,
    amplitude: Option<Pascal>,
    frequency: Option<Hertz>,
    cycles: Option<usize>,
}

impl TryFrom<Entry> for Trial {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let experiment = entry.to_experiment().map_err(|reason| format!("{reason} in trial `{}`", entry.id))?;
        Ok(Self {
            experiment,
            id: entry.id,
            role: entry.role,
            split: entry.split,
            medium: entry.medium,
            video: entry.video,
            pressure: entry.pressure,
            force: entry.force,
            first_frame: entry.first_frame.unwrap_or(0),
            last_frame: entry.last_frame,
        })
    }
}

/// The channels of a trial: a list, or the one that is filled first, or alone.
#[derive(Deserialize)]
#[serde(untagged)]
enum Driven {
    All(Vec<String>),
    First(String),
}

impl Driven {
    /// The channels that are driven; a first side of a tail that flaps is followed by the other.
    fn channel_names(&self, kind: &Kind) -> Vec<String> {
        match (self, kind) {
            (Self::All(channels), _) => channels.clone(),
            (Self::First(first), Kind::Staircase) => vec![first.clone()],
            (Self::First(first), Kind::Flapping) => match first.as_str() {
                "left" => vec!["left".to_owned(), "right".to_owned()],
                "right" => vec!["right".to_owned(), "left".to_owned()],
                _ => vec![first.clone()],
            },
        }
    }
}

impl Entry {
    fn to_experiment(&self) -> Result<Experiment, String> {
        let channels = self.channels.channel_names(&self.kind);
        if channels.is_empty() {
            return Err("`channels` is empty".to_owned());
        }
        match self.kind {
            Kind::Staircase => {
                refuse_value("staircase", "amplitude", &self.amplitude)?;
                refuse_value("staircase", "frequency", &self.frequency)?;
                refuse_value("staircase", "cycles", &self.cycles)?;
                let levels = required_value("staircase", "levels", &self.levels)?;
                let (hold, pause) = (
                    required_value("staircase", "hold", &self.hold)?,
                    required_value("staircase", "pause", &self.pause)?,
                );
                Ok(Experiment::Staircase { channels, levels, hold, pause })
            }
            Kind::Flapping => {
                refuse_value("flapping", "levels", &self.levels)?;
                refuse_value("flapping", "hold", &self.hold)?;
                refuse_value("flapping", "pause", &self.pause)?;
                Ok(Experiment::Flapping {
                    channels,
                    amplitude: required_value("flapping", "amplitude", &self.amplitude)?,
                    frequency: required_value("flapping", "frequency", &self.frequency)?,
                    cycles: required_value("flapping", "cycles", &self.cycles)?,
                })
            }
        }
    }
}

fn required_value<T: Clone>(kind: &str, key: &str, value: &Option<T>) -> Result<T, String> {
    value.clone().ok_or_else(|| format!("kind `{kind}` needs the key `{key}`, which is missing"))
}

fn refuse_value<T>(kind: &str, key: &str, value: &Option<T>) -> Result<(), String> {
    match value {
        None => Ok(()),
        Some(_) => Err(format!("kind `{kind}` has no key `{key}`, but it is given")),
    }
}
