//! Needs: the records that a stage, figure or table reads, as a type, so that undeclared records cannot be read.
//!
//! A record is found for the subject at hand; [`Every`] gathers a kind of record over all its subjects; a project adds selections of its
//! own with [`read_each`]. Where records come with their subjects, these are reduced to a [`Part`], which enters the key.

use diagnostics::{Diagnostic, Result};
use serde_json::Value;

use crate::record::{Record, RecordFiles};
use crate::subject::{Name, Part, Subject, SubjectOf};

/// A record's name: which stage, of what.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RecordId {
    /// The stage that makes it.
    pub stage: &'static str,
    /// The subject's name.
    pub subject: String,
}

impl std::fmt::Display for RecordId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.stage, self.subject)
    }
}

/// A source of records.
pub trait RecordReader: Sync {
    /// A record's files.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the record is missing or its bytes are not those that were written.
    fn files(&self, id: &RecordId) -> Result<RecordFiles>;
}

/// A set of records that can be read for a subject.
pub trait Needs<Of>: Sized {
    /// Their names.
    fn ids(subject: &Of) -> Vec<RecordId>;

    /// The parts read of their subjects, for the key; null where only records are read.
    fn parts(subject: &Of) -> Value {
        let _ = subject;
        Value::Null
    }

    /// The records themselves.
    ///
    /// # Errors
    /// A [`Diagnostic`] when one is missing or unreadable.
    fn read(subject: &Of, reader: &dyn RecordReader) -> Result<Self>;
}

/// The record's name for a subject.
pub fn id<R: Record>(subject: &R::Of) -> RecordId {
    RecordId { stage: R::STAGE, subject: subject.name() }
}

/// The names of the records of these subjects.
pub fn ids_of<R: Record>(subjects: &[R::Of]) -> Vec<RecordId> {
    subjects.iter().map(id::<R>).collect()
}

/// The parts of these subjects, as they enter a key.
pub fn parts_of<S, P: Part<S>>(subjects: &[S]) -> Value {
    let part = |subject: &S| serde_json::to_value(P::part_of(subject)).unwrap_or_default();
    subjects.iter().map(part).collect()
}

/// The record of each of these subjects, with the part of the subject.
///
/// # Errors
/// A [`Diagnostic`] when one is missing or unreadable.
pub fn read_each<R: Record, P: Part<R::Of>>(subjects: &[R::Of], reader: &dyn RecordReader) -> Result<Vec<(P, R)>> {
    subjects.iter().map(|s| Ok((P::part_of(s), read_one(s, reader)?))).collect()
}

/// The record of a subject.
///
/// # Errors
/// A [`Diagnostic`] when it is missing or unreadable.
pub fn read_one<R: Record>(subject: &R::Of, reader: &dyn RecordReader) -> Result<R> {
    let id = id::<R>(subject);
    R::from_files(&reader.files(&id)?).map_err(|e| {
        Diagnostic::new(format!("record `{id}` cannot be read"), &e, format!("study run {} --fresh", id.stage))
            .caused_by(e)
    })
}

impl<S, R> Needs<S> for R
where
    R: Record,
    R::Of: SubjectOf<S>,
{
    fn ids(subject: &S) -> Vec<RecordId> {
        vec![id::<R>(&R::Of::subject_of(subject))]
    }

    fn read(subject: &S, reader: &dyn RecordReader) -> Result<Self> {
        read_one(&R::Of::subject_of(subject), reader)
    }
}

/// A kind of record over all its subjects, each with its part of the subject: its name when no other is asked for.
pub struct Every<R, P = Name>(pub Vec<(P, R)>);

impl<R: Record, P> Every<R, P> {
    /// Whether there is any.
    pub fn any(universe: &<R::Of as Subject>::Universe) -> bool {
        !Self::subjects(universe).is_empty()
    }

    fn subjects(universe: &<R::Of as Subject>::Universe) -> Vec<R::Of> {
        R::Of::all(universe).into_iter().filter(R::is_made_for).collect()
    }
}

impl<U, R, P> Needs<U> for Every<R, P>
where
    R: Record,
    R::Of: Subject<Universe = U>,
    P: Part<R::Of>,
{
    fn ids(universe: &U) -> Vec<RecordId> {
        ids_of::<R>(&Self::subjects(universe))
    }

    fn parts(universe: &U) -> Value {
        parts_of::<R::Of, P>(&Self::subjects(universe))
    }

    fn read(universe: &U, reader: &dyn RecordReader) -> Result<Self> {
        read_each(&Self::subjects(universe), reader).map(Self)
    }
}

/// An optional record: none where the subject has none.
pub struct Maybe<R>(pub Option<R>);

impl<S, R> Needs<S> for Maybe<R>
where
    R: Record,
    R::Of: SubjectOf<S>,
{
    fn ids(subject: &S) -> Vec<RecordId> {
        let record_subject = R::Of::subject_of(subject);
        if R::is_made_for(&record_subject) { vec![id::<R>(&record_subject)] } else { Vec::new() }
    }

    fn read(subject: &S, reader: &dyn RecordReader) -> Result<Self> {
        let record_subject = R::Of::subject_of(subject);
        R::is_made_for(&record_subject).then(|| read_one(&record_subject, reader)).transpose().map(Self)
    }
}

impl<S> Needs<S> for () {
    fn ids(_: &S) -> Vec<RecordId> {
        Vec::new()
    }

    fn read(_: &S, _: &dyn RecordReader) -> Result<Self> {
        Ok(())
    }
}

/// Tuples of needs are needs.
macro_rules! tuple_needs {
    ($($part:ident),+) => {
        impl<S, $($part: Needs<S>),+> Needs<S> for ($($part,)+) {
            fn ids(subject: &S) -> Vec<RecordId> {
                [$($part::ids(subject)),+].concat()
            }

            fn parts(subject: &S) -> Value {
                let parts = [$($part::parts(subject)),+];
                if parts.iter().all(Value::is_null) { Value::Null } else { parts.into_iter().collect() }
            }

            fn read(subject: &S, reader: &dyn RecordReader) -> Result<Self> {
                Ok(($($part::read(subject, reader)?,)+))
            }
        }
    };
}

tuple_needs!(A, B);
tuple_needs!(A, B, C);
tuple_needs!(A, B, C, D);
