//! Subjects of records, from a whole project down to its smallest item.
//!
//! The types are defined by the project. The workflow needs their order, their names and the parts of them that stages read.

use serde::Serialize;

/// A subject of records.
pub trait Subject: Clone + Send + Sync {
    /// The whole of which it is one.
    type Universe: Universe;

    /// Every subject of this kind, in a fixed order.
    fn all(universe: &Self::Universe) -> Vec<Self>;

    /// Its name in the names of records, with `/` between levels: "all", "group" or "group/item".
    fn name(&self) -> String;
}

/// The whole: a subject of which there is one.
pub trait Universe: Subject<Universe = Self> {
    /// What a group of it is called, in messages.
    const GROUP: &'static str;

    /// What an item of a group is called.
    const ITEM: &'static str;

    /// The names of its groups: the first parts of its subjects' names.
    fn groups(&self) -> Vec<String>;
}

/// A subject that follows from another: an item determines its group.
pub trait SubjectOf<Other>: Subject {
    /// This subject, given the other.
    fn subject_of(other: &Other) -> Self;
}

impl<S: Subject> SubjectOf<S> for S {
    fn subject_of(other: &S) -> Self {
        other.clone()
    }
}

/// The part of a subject that a stage, figure or table reads. Its serialised form is part of the key of what is made from it: a field
/// that is read but not serialised cannot exist, because the reader receives this type and nothing else.
pub trait Part<Of>: Serialize {
    /// Takes the part from its subject.
    fn part_of(subject: &Of) -> Self;
}

impl<Of> Part<Of> for () {
    fn part_of(_: &Of) -> Self {}
}

/// A subject's name alone.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct Name(pub String);

impl<Of: Subject> Part<Of> for Name {
    fn part_of(subject: &Of) -> Self {
        Self(subject.name())
    }
}
