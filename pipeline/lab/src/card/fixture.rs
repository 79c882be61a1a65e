//! `[[fixture]]`: a recording of the load cell and its fixture alone, without a film: hammer taps, and still water.
//!
//! What the cell says of a tail went through its fixture first, a light mass on a spring, and stands on the waves that an
//! earlier run left in the tank. Taps show the one, still water the other. They stand in a table of their own because
//! nothing is filmed and no pressure is commanded in them.
//!
//! Stands on: `serde`. Never knows: what the logs hold.

use serde::Deserialize;

use super::Medium;

/// One recording of the fixture.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Flat")]
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
#[derive(Debug, Clone, PartialEq)]
pub enum FixtureOf {
    /// An instrumented hammer tapped it.
    Taps {
        /// The hammer's log, relative to the card, on the clock of the force log.
        hammer: String,
    },
    /// Nothing: the log begins a second after a run has ended and shows what is left in the tank.
    StillWater,
}

impl FixtureOf {
    /// The word on the card.
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
struct Flat {
    id: String,
    kind: Kind,
    medium: Medium,
    force: String,
    hammer: Option<String>,
}

impl TryFrom<Flat> for Fixture {
    type Error = String;

    fn try_from(flat: Flat) -> Result<Self, String> {
        let of = match (flat.kind, flat.hammer) {
            (Kind::Taps, Some(hammer)) => FixtureOf::Taps { hammer },
            (Kind::StillWater, None) => FixtureOf::StillWater,
            (Kind::Taps, None) => {
                let said = "kind `taps` needs the key `hammer`, which is missing";
                return Err(format!("{said} in fixture `{}`", flat.id));
            }
            (Kind::StillWater, Some(_)) => {
                let said = "kind `still_water` has no key `hammer`, but it is given";
                return Err(format!("{said} in fixture `{}`", flat.id));
            }
        };
        Ok(Self { id: flat.id, medium: flat.medium, force: flat.force, of })
    }
}
