//! `[[fixture]]`: a recording of the load cell and its fixture alone, without a film: hammer taps, and still water.
//!
//! The measured force of a tail is filtered by the fixture, a light mass on a spring, and superposed by the waves that an
//! earlier run left in the tank. Taps identify the transfer function, still water the waves. They have a table of their own
//! because nothing is filmed and no pressure is commanded in them.

use serde::{Deserialize, Serialize};

use super::Medium;

/// One recording of the fixture.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "Entry")]
pub struct Fixture {
    /// Its name, unique among trials and fixtures.
    pub id: String,
    /// What surrounds the specimen.
    pub medium: Medium,
    /// Force log, relative to the card.
    pub force: String,
    /// What was done.
    pub of: FixtureOf,
}

/// What was done to the fixture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum FixtureOf {
    /// An instrumented hammer tapped it.
    Taps {
        /// The hammer's log, relative to the card, on the clock of the force log.
        hammer: String,
        /// Number of taps, where it is known: a log that was cut has fewer.
        count: Option<usize>,
    },
    /// Nothing: the log begins a second after a run has ended and shows what is left in the tank.
    StillWater,
}

impl FixtureOf {
    /// The value on the card.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Taps { .. } => "taps",
            Self::StillWater => "still_water",
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Taps,
    StillWater,
}

/// A fixture's recording as it stands on the card.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: String,
    kind: Kind,
    medium: Medium,
    force: String,
    hammer: Option<String>,
    count: Option<usize>,
}

impl TryFrom<Entry> for Fixture {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let recording = match (entry.kind, entry.hammer, entry.count) {
            (Kind::Taps, Some(hammer), count) => FixtureOf::Taps { hammer, count },
            (Kind::StillWater, None, None) => FixtureOf::StillWater,
            (Kind::Taps, None, _) => {
                let reason = "kind `taps` needs the key `hammer`, which is missing";
                return Err(format!("{reason} in fixture `{}`", entry.id));
            }
            (Kind::StillWater, ..) => {
                let reason = "kind `still_water` has no key `hammer` or `count`, but one is given";
                return Err(format!("{reason} in fixture `{}`", entry.id));
            }
        };
        Ok(Self { id: entry.id, medium: entry.medium, force: entry.force, of: recording })
    }
}
