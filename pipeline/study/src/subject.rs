//! Subjects: what a record is a record of — the whole study, one specimen, or one trial of a specimen.
//!
//! Stands on: the cards of `lab`. Never knows: a stage, a path.

use std::sync::Arc;

use lab::card::{self, Card};
use si::Pascal;

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
    pub card: Arc<Card>,
}

/// One recording of an actuator.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The card it stands in.
    pub card: Arc<Card>,
    /// Its own entry there.
    pub trial: Arc<card::Trial>,
}

impl Trial {
    /// Whether parameters may be fitted to it.
    pub fn is_for_identification(&self) -> bool {
        self.trial.role == card::Role::Identify
    }

    /// Whether it was weighed under water, so that there is thrust in its force log.
    pub fn is_weighed_in_water(&self) -> bool {
        self.trial.force.is_some() && self.is_in_water()
    }

    /// Whether it was filmed under water.
    pub fn is_in_water(&self) -> bool {
        self.trial.medium == card::Medium::Water
    }

    /// Whether it is a staircase in water: what its releases show is the water's.
    pub fn is_staircase_in_water(&self) -> bool {
        self.is_in_water() && matches!(self.trial.experiment, card::Experiment::Staircase { .. })
    }

    /// Tracks on the card that another program or instrument made of it.
    pub fn made_elsewhere(&self) -> Option<&card::Tracks> {
        self.card.tracks.iter().find(|tracks| tracks.trial == self.trial.id)
    }

    /// Tracks of it that are places in space already, with no lens between, and how their axes lie.
    pub fn in_space(&self) -> Option<(&card::Tracks, &card::Axes)> {
        self.made_elsewhere().and_then(|tracks| Some((tracks, tracks.space.as_ref()?)))
    }

    /// The trials of the same experiment in the same medium with the same role, this one among them, in the order of the card.
    pub fn repeats(&self) -> Vec<Trial> {
        let same = |t: &&card::Trial| {
            t.experiment == self.trial.experiment && t.medium == self.trial.medium && t.role == self.trial.role
        };
        let of = |trial: &card::Trial| Trial { card: self.card.clone(), trial: Arc::new(trial.clone()) };
        self.card.trial.iter().filter(same).map(of).collect()
    }

    /// Whether it is the first of its repeats.
    pub fn is_first_repeat(&self) -> bool {
        self.repeats().first().is_some_and(|first| first.trial.id == self.trial.id)
    }

    /// The highest pressure that a staircase asks for, Pa; none of a trial that flaps.
    pub fn highest_level(&self) -> Option<Pascal> {
        match &self.trial.experiment {
            card::Experiment::Staircase { levels, .. } => levels.iter().copied().reduce(f64::max),
            card::Experiment::Flapping { .. } => None,
        }
    }

    /// Whether no staircase of the specimen goes higher, and none before it on the card as high.
    pub fn is_highest_staircase(&self) -> bool {
        let of = Specimen { card: self.card.clone() };
        of.highest_staircase().is_some_and(|highest| highest.trial.id == self.trial.id)
    }

    /// What its repeats have in common, as metrics name it: its id without its number, and without "air".
    pub fn condition(&self) -> String {
        let id = self.trial.id.trim_end_matches(|c: char| c.is_ascii_digit());
        let id = if id.ends_with('_') { id.trim_end_matches('_') } else { &self.trial.id };
        id.strip_suffix("_air").unwrap_or(id).to_owned()
    }

    /// Whether a model is judged by it.
    pub fn is_for_validation(&self) -> bool {
        self.trial.role == card::Role::Validate
    }
}

/// Anything that records are made of.
pub trait Scope: Clone + Send + Sync {
    /// Every subject of this kind, in a fixed order.
    fn all(study: &Study) -> Vec<Self>;

    /// Its name in the names of records: "all", "nemo" or "nemo/static_left".
    fn name(&self) -> String;
}

/// A subject that can be found from another: a trial knows its specimen.
pub trait SeenFrom<Other>: Scope {
    /// This subject, as seen from the other.
    fn seen_from(other: &Other) -> Self;
}

impl Scope for Study {
    fn all(study: &Study) -> Vec<Self> {
        vec![study.clone()]
    }

    fn name(&self) -> String {
        "all".into()
    }
}

impl Scope for Specimen {
    fn all(study: &Study) -> Vec<Self> {
        study.specimens.clone()
    }

    fn name(&self) -> String {
        self.card.name.clone()
    }
}

impl Specimen {
    /// Its trials, in the order of the card.
    pub fn trials(&self) -> Vec<Trial> {
        let of = |trial: &card::Trial| Trial { card: self.card.clone(), trial: Arc::new(trial.clone()) };
        self.card.trial.iter().map(of).collect()
    }

    /// The first of the staircases that go highest.
    pub fn highest_staircase(&self) -> Option<Trial> {
        let higher = |best: Option<Trial>, next: Trial| match &best {
            Some(before) if before.highest_level() >= next.highest_level() => best,
            _ => next.highest_level().is_some().then_some(next).or(best),
        };
        self.trials().into_iter().fold(None, higher)
    }
}

impl Scope for Trial {
    fn all(study: &Study) -> Vec<Self> {
        study.specimens.iter().flat_map(Specimen::trials).collect()
    }

    fn name(&self) -> String {
        format!("{}/{}", self.card.name, self.trial.id)
    }
}

impl<S: Scope> SeenFrom<S> for S {
    fn seen_from(other: &S) -> Self {
        other.clone()
    }
}

impl SeenFrom<Trial> for Specimen {
    fn seen_from(trial: &Trial) -> Self {
        Specimen { card: trial.card.clone() }
    }
}
