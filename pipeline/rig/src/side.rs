//! The two sides of a tail: each has a chamber, a valve and a channel of the pressure log.

use lab::card::Experiment;
use si::Pascal;

/// A side of the tail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Positive y.
    Left,
    /// Negative y.
    Right,
}

impl Side {
    /// Both, in the order of the channels.
    pub(crate) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The name of its channel.
    pub(crate) fn channel_name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Pressures of both sides (left, right; Pa) when this one alone is filled.
    pub(crate) fn alone(self, pressure: Pascal) -> [Pascal; 2] {
        match self {
            Self::Left => [pressure, 0.0],
            Self::Right => [0.0, pressure],
        }
    }

    /// The other side.
    pub(crate) fn opposite_side(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// The side that an experiment fills first, or alone.
    pub(crate) fn first_of(experiment: &Experiment) -> Self {
        match experiment.channels().first().is_some_and(|channel| channel == Self::Right.channel_name()) {
            true => Self::Right,
            false => Self::Left,
        }
    }
}

/// The names of the channels.
pub(crate) fn channel_names() -> [String; 2] {
    Side::BOTH.map(|side| side.channel_name().to_owned())
}
