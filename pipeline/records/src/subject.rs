//! Subjects of records: the whole study, one specimen, or one trial of a specimen.

use std::sync::Arc;

use lab::card::{self, Card};
use serde::Serialize;
use sysid::Body;
use workflow::shared::Shared;
use workflow::stage::RawFile;
use workflow::subject::{Part, Subject, SubjectOf, Universe};

/// All specimens whose cards were found.
#[derive(Debug, Clone)]
pub struct Study {
    /// In alphabetical order of their names.
    pub specimens: Vec<Specimen>,
}

/// One actuator.
#[derive(Debug, Clone)]
pub struct Specimen {
    /// Its card.
    pub card: Shared<Card>,
}

/// One recording of an actuator.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Its specimen's card.
    pub card: Shared<Card>,
    /// Its entry there.
    pub trial: Arc<card::Trial>,
}

impl Trial {
    /// Whether parameters may be fitted to it.
    pub(crate) fn is_for_identification(&self) -> bool {
        self.trial.role == card::Role::Identify
    }

    /// Whether it has a force log under water.
    pub fn has_force_in_water(&self) -> bool {
        self.trial.force.is_some() && self.is_in_water()
    }

    /// Whether it was filmed under water.
    pub fn is_in_water(&self) -> bool {
        self.trial.medium == card::Medium::Water
    }

    /// Whether it is a staircase in water, whose releases determine added mass and drag.
    pub(crate) fn is_staircase_in_water(&self) -> bool {
        self.is_in_water() && matches!(self.trial.experiment, card::Experiment::Staircase { .. })
    }

    /// Tracks on the card that another program or instrument made of it.
    pub fn made_elsewhere(&self) -> Option<&card::Tracks> {
        self.card.made_elsewhere(&self.trial)
    }

    /// Imported positions of it in space, without a camera model, and the orientation of their axes.
    pub fn in_space(&self) -> Option<(&card::Tracks, &card::Axes)> {
        self.card.in_space(&self.trial)
    }

    /// The film as a raw file; none where the markers were measured in space and nothing was filmed.
    pub fn film(&self) -> Option<RawFile> {
        self.trial.video.as_ref().map(|video| RawFile::new("video", &self.card.name, video))
    }

    /// The trials of the same experiment in the same medium with the same role, this one among them, in the order of the card.
    pub(crate) fn repeat_trials(&self) -> Vec<Trial> {
        let subject = |trial: &card::Trial| Trial { card: self.card.clone(), trial: Arc::new(trial.clone()) };
        self.on_card().map(subject).collect()
    }

    /// The entries of its repeats.
    fn on_card(&self) -> impl Iterator<Item = &card::Trial> {
        let trial = &*self.trial;
        let key = |t: &card::Trial| (t.medium, t.role);
        self.card.trial.iter().filter(move |t| key(t) == key(trial) && t.experiment == trial.experiment)
    }

    /// Whether it is the first of its repeats.
    pub(crate) fn is_first_repeat(&self) -> bool {
        self.on_card().next().is_some_and(|first| first.id == self.trial.id)
    }

    /// What its repeats have in common, as figures and tables name it.
    pub fn condition(&self) -> String {
        condition_of(&self.trial.id)
    }

    /// Whether it is a validation trial.
    pub fn is_for_validation(&self) -> bool {
        self.trial.role == card::Role::Validate
    }
}

impl Subject for Study {
    type Universe = Study;

    fn all(study: &Study) -> Vec<Self> {
        vec![study.clone()]
    }

    fn name(&self) -> String {
        "all".into()
    }
}

impl Universe for Study {
    const GROUP: &'static str = "specimen";
    const ITEM: &'static str = "trial";

    fn groups(&self) -> Vec<String> {
        self.specimens.iter().map(Subject::name).collect()
    }
}

impl Subject for Specimen {
    type Universe = Study;

    fn all(study: &Study) -> Vec<Self> {
        study.specimens.clone()
    }

    fn name(&self) -> String {
        self.card.name.clone()
    }
}

impl Specimen {
    /// Whether it is a soft body around a stiff sheet, from their STL files.
    pub(crate) fn has_sheet(&self) -> bool {
        self.card.solid.file(card::SPINE).is_some()
    }

    /// Its trials, in the order of the card.
    pub fn trials(&self) -> Vec<Trial> {
        let subject = |trial: &card::Trial| Trial { card: self.card.clone(), trial: Arc::new(trial.clone()) };
        self.card.trial.iter().map(subject).collect()
    }

    /// The first of the staircases with the highest level.
    pub fn highest_staircase(&self) -> Option<Trial> {
        let subject = |trial: &card::Trial| Trial { card: self.card.clone(), trial: Arc::new(trial.clone()) };
        self.card.highest_staircase().map(subject)
    }
}

impl Subject for Trial {
    type Universe = Study;

    fn all(study: &Study) -> Vec<Self> {
        study.specimens.iter().flat_map(Specimen::trials).collect()
    }

    fn name(&self) -> String {
        format!("{}/{}", self.card.name, self.trial.id)
    }
}

impl SubjectOf<Trial> for Specimen {
    fn subject_of(trial: &Trial) -> Self {
        Specimen { card: trial.card.clone() }
    }
}

/// The id of a trial, as the card has it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct TrialId(pub String);

impl Part<Trial> for TrialId {
    fn part_of(trial: &Trial) -> Self {
        Self(trial.trial.id.clone())
    }
}

impl Part<Specimen> for Body {
    fn part_of(specimen: &Specimen) -> Self {
        Body::of(&specimen.card)
    }
}

impl Part<Trial> for Body {
    fn part_of(trial: &Trial) -> Self {
        Body::of(&trial.card)
    }
}

/// What the repeats of a trial have in common: its id without its number, and without "air".
pub fn condition_of(id: &str) -> String {
    let bare = id.trim_end_matches(|c: char| c.is_ascii_digit());
    let bare = if bare.ends_with('_') { bare.trim_end_matches('_') } else { id };
    bare.strip_suffix("_air").unwrap_or(bare).to_owned()
}

/// Specimen and condition of a trial, as metrics name them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct Condition(pub String);

impl Condition {
    /// Of the trial whose subject has this name.
    pub fn of(subject: &str) -> Self {
        let (specimen, id) = subject.split_once('/').unwrap_or(("", subject));
        Self(format!("{specimen}_{}", condition_of(id)))
    }
}

impl Part<Trial> for Condition {
    fn part_of(trial: &Trial) -> Self {
        Self::of(&trial.name())
    }
}

/// Figures and tables are keyed by whole cards, as their hashes: drawing them takes milliseconds, so a finer key would gain nothing.
impl Part<Specimen> for Specimen {
    fn part_of(specimen: &Specimen) -> Self {
        specimen.clone()
    }
}

impl Part<Trial> for Trial {
    fn part_of(trial: &Trial) -> Self {
        trial.clone()
    }
}

impl Serialize for Specimen {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.card.digest().serialize(serializer)
    }
}

impl Serialize for Trial {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.card.digest(), &self.trial.id).serialize(serializer)
    }
}
