//! The card of a specimen (`specimen.toml`): everything that is known before the first computation.
//!
//! All numbers are SI; pixels are pixels of the video. The CAD frame is the frame of the STL files: x along the tail
//! from the clamp to the fin's tip, y sideways, z up towards the camera.

mod board;
mod camera;
mod check;
mod clamp;
mod entry;
mod fixture;
mod log;
mod marker_sources;
mod marks;
mod read;
mod recordings;
mod solids;
mod trial;
mod write;

use serde::{Deserialize, Serialize};
use si::{Metre, Point2, Point3};

pub use camera::{Board, BoardKind, Camera, LensKind, Plane};
pub use check::{check_log, check_tank};
pub use clamp::Clamp;
pub use entry::is_name;
pub use fixture::{Fixture, FixtureOf};
pub(crate) use log::dimension_of;
pub use log::{Log, LogColumn, LogKind, Place, Unit};
pub use marks::{Axes, Detector, Order, Search, Tracks};
pub use read::{parse, read};
pub use solids::{BODY, Part, SPINE, Solid, Solids};
pub use trial::{Experiment, Medium, Role, Split, Trial};
pub use write::write;

/// A specimen's card.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// The specimen's name, equal to its folder's.
    pub name: String,
    /// Who recorded it.
    pub origin: Origin,
    /// Length by which errors are divided, m.
    pub length: Metre,
    /// Its solids.
    pub solid: Solids,
    /// The clamped part.
    pub clamp: Clamp,
    /// The air chambers, one entry each connected cavity.
    pub chamber: Vec<Chamber>,
    /// The tracked marks on the back, from the head to the fin.
    pub marker: Vec<Marker>,
    /// The search for markers that are not clicked.
    #[serde(default)]
    pub search: Option<Search>,
    /// The camera and its calibration, where markers are tracked in films.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// The water that the camera looks through, where a trial is in water.
    #[serde(default)]
    pub water: Option<Water>,
    /// The LED that synchronises video and logs, where there is a video.
    #[serde(default)]
    pub led: Option<Led>,
    /// The recordings.
    pub trial: Vec<Trial>,
    /// Tracks of markers from other programs; a film without them is tracked by this pipeline.
    #[serde(default)]
    pub tracks: Vec<Tracks>,
    /// Recordings of the load cell's fixture without a specimen; none by default.
    #[serde(default)]
    pub fixture: Vec<Fixture>,
    /// How the instruments write their logs.
    #[serde(default)]
    pub log: Log,
    /// The tank, where trials are in water.
    #[serde(default)]
    pub tank: Option<Tank>,
}

impl Card {
    /// The channels of the pressure logs, in the order of the chambers.
    pub fn channels(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for chamber in &self.chamber {
            if !names.contains(&chamber.channel) {
                names.push(chamber.channel.clone());
            }
        }
        names
    }

    /// The first of the staircases with the highest level.
    pub fn highest_staircase(&self) -> Option<&Trial> {
        highest_trial(self.trial.iter())
    }

    /// The first of the staircases in air with the highest level, of all staircases where none is in air: through water the outline of a body
    /// is that of refracted rays.
    pub fn highest_staircase_in_air(&self) -> Option<&Trial> {
        highest_trial(self.trial.iter().filter(|trial| trial.medium == Medium::Air))
            .or_else(|| self.highest_staircase())
    }

    /// Tracks of a trial that another program or instrument made.
    pub fn made_elsewhere(&self, trial: &Trial) -> Option<&Tracks> {
        self.tracks.iter().find(|tracks| tracks.trial == trial.id)
    }

    /// Imported positions of a trial in space, without a camera model, and the orientation of their axes.
    pub fn in_space(&self, trial: &Trial) -> Option<(&Tracks, &Axes)> {
        self.made_elsewhere(trial).and_then(|tracks| Some((tracks, tracks.space.as_ref()?)))
    }
}

/// The first of the staircases among `trials` with the highest level.
fn highest_trial<'a>(trials: impl Iterator<Item = &'a Trial>) -> Option<&'a Trial> {
    let level = |trial: &Trial| trial.experiment.highest_level();
    let higher = |best: Option<_>, next| match best {
        Some(best_trial) if level(best_trial) >= level(next) => best,
        _ => level(next).map(|_| next).or(best),
    };
    trials.fold(None, higher)
}

/// Who recorded a specimen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub enum Origin {
    /// Computed by the virtual bench; nothing in it was measured.
    #[serde(rename = "virtual bench")]
    VirtualBench,
    /// Measured.
    #[serde(rename = "laboratory")]
    Laboratory,
}

impl Origin {
    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::VirtualBench => crate::VIRTUAL_BENCH,
            Self::Laboratory => "laboratory",
        }
    }
}

/// The unit of the coordinates in the STL files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Millimetres, as most CAD programs write.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    #[serde(alias = "in")]
    Inch,
}

impl LengthUnit {
    /// One of it in metres.
    pub fn metres(self) -> Metre {
        match self {
            Self::Mm => 1e-3,
            Self::Cm => 1e-2,
            Self::M => 1.0,
            Self::Inch => 0.0254,
        }
    }

    /// The value on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::Inch => "inch",
        }
    }
}

/// `[[chamber]]`: one connected cavity.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Chamber {
    /// Its name.
    pub name: String,
    /// A point inside it, m, CAD frame.
    pub at: Point3,
    /// The channel of the pressure logs that fills it; several chambers may share one.
    #[serde(alias = "log")]
    pub channel: String,
}

/// `[[marker]]`: one dark mark on the back.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// Where it was painted, m, CAD frame.
    pub at: Point3,
    /// Where it was clicked in the first frame of every trial, px (u to the right, v down, centre of the first pixel 0, 0); none
    /// where [`Search`] finds it.
    #[serde(default)]
    pub clicked: Option<Point2>,
    /// Its diameter, m; needed where it is tracked in a film.
    #[serde(default)]
    pub diameter: Option<Metre>,
}

/// `[water]`: the still surface above the specimen, in the trials whose medium is water.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// z of the surface, m, CAD frame.
    pub surface: Metre,
    /// Refractive index, no unit: 1.333 for fresh water at 20 °C.
    pub index: f64,
}

/// `[tank]`: the basin in which trials in water are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tank {
    /// Inner length along the actuator, m.
    pub length: Metre,
    /// Depth of the water, m.
    pub depth: Metre,
}

/// `[led]`: the LED that is on during a trial.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Led {
    /// Its centre in the picture, px.
    pub centre: Point2,
    /// Its radius in the picture, px.
    pub radius: f64,
}
