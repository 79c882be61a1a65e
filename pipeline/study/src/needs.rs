//! Needs: the records that a stage or figure reads, as a type, so that it cannot read what it did not name.
//!
//! A record is found for the subject at hand; [`Learning`] gathers the trials that identification may see, and only
//! those; [`Every`] gathers a kind of record over all subjects, for figures and tables.
//!
//! Stands on: record, subject. Never knows: a path, which stage asks.

use crate::fault::{Fault, Outcome};
use crate::record::{Parcel, Record};
use crate::subject::{Scope, SeenFrom, Specimen, Study, Trial};

/// A record's name: which stage, of what.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id {
    /// The stage that makes it.
    pub stage: &'static str,
    /// The subject's name.
    pub subject: String,
}

impl std::fmt::Display for Id {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.stage, self.subject)
    }
}

/// Where records are handed out.
pub trait Shelf: Sync {
    /// A record's files.
    ///
    /// # Errors
    /// A [`Fault`] when the record is not there or its bytes are not those that were written.
    fn parcel(&self, id: &Id) -> Outcome<Parcel>;
}

/// A set of records that can be fetched for a subject.
pub trait Needs<Of>: Sized {
    /// Their names.
    fn wanted(of: &Of) -> Vec<Id>;

    /// The records themselves.
    ///
    /// # Errors
    /// A [`Fault`] when one is absent or unreadable.
    fn fetch(of: &Of, shelf: &dyn Shelf) -> Outcome<Self>;
}

/// The record's name for a subject.
pub fn id<R: Record>(of: &R::Of) -> Id {
    Id { stage: R::STAGE, subject: of.name() }
}

/// Every subject with its record.
fn fetch_each<R: Record>(subjects: Vec<R::Of>, shelf: &dyn Shelf) -> Outcome<Vec<(R::Of, R)>> {
    subjects.into_iter().map(|s| fetch_one(&s, shelf).map(|r| (s, r))).collect()
}

fn fetch_one<R: Record>(of: &R::Of, shelf: &dyn Shelf) -> Outcome<R> {
    let id = id::<R>(of);
    R::unpack(&shelf.parcel(&id)?)
        .map_err(|e| Fault::new(format!("record `{id}` cannot be read"), e, format!("study run {} --fresh", id.stage)))
}

impl<S, R> Needs<S> for R
where
    R: Record,
    R::Of: SeenFrom<S>,
{
    fn wanted(of: &S) -> Vec<Id> {
        vec![id::<R>(&R::Of::seen_from(of))]
    }

    fn fetch(of: &S, shelf: &dyn Shelf) -> Outcome<Self> {
        fetch_one(&R::Of::seen_from(of), shelf)
    }
}

/// A kind of record over every trial from which a specimen may be identified.
pub struct Learning<R: Record>(pub Vec<(R::Of, R)>);

impl<R: Record<Of = crate::subject::Trial>> Learning<R> {
    fn subjects(of: &Specimen) -> Vec<R::Of> {
        of.trials().into_iter().filter(|t| t.is_for_identification() && R::is_made_for(t)).collect()
    }
}

impl<R: Record<Of = crate::subject::Trial>> Needs<Specimen> for Learning<R> {
    fn wanted(of: &Specimen) -> Vec<Id> {
        Self::subjects(of).iter().map(id::<R>).collect()
    }

    fn fetch(of: &Specimen, shelf: &dyn Shelf) -> Outcome<Self> {
        fetch_each(Self::subjects(of), shelf).map(Self)
    }
}

/// A kind of record over all its subjects.
pub struct Every<R: Record>(pub Vec<(R::Of, R)>);

impl<R: Record> Every<R> {
    /// Whether there is any.
    pub fn any(of: &Study) -> bool {
        !Self::subjects(of).is_empty()
    }

    fn subjects(of: &Study) -> Vec<R::Of> {
        R::Of::all(of).into_iter().filter(R::is_made_for).collect()
    }
}

impl<R: Record> Needs<Study> for Every<R> {
    fn wanted(of: &Study) -> Vec<Id> {
        Self::subjects(of).iter().map(id::<R>).collect()
    }

    fn fetch(of: &Study, shelf: &dyn Shelf) -> Outcome<Self> {
        fetch_each(Self::subjects(of), shelf).map(Self)
    }
}

/// A record that not every subject has: none where it is not made.
pub struct Maybe<R>(pub Option<R>);

impl<S, R> Needs<S> for Maybe<R>
where
    R: Record,
    R::Of: SeenFrom<S>,
{
    fn wanted(of: &S) -> Vec<Id> {
        let of = R::Of::seen_from(of);
        if R::is_made_for(&of) { vec![id::<R>(&of)] } else { Vec::new() }
    }

    fn fetch(of: &S, shelf: &dyn Shelf) -> Outcome<Self> {
        let of = R::Of::seen_from(of);
        let found = if R::is_made_for(&of) { Some(fetch_one(&of, shelf)?) } else { None };
        Ok(Self(found))
    }
}

/// A record that is read for trials in water alone.
pub struct InWater<R>(pub Option<R>);

impl<R> Needs<Trial> for InWater<R>
where
    R: Record,
    R::Of: SeenFrom<Trial>,
{
    fn wanted(of: &Trial) -> Vec<Id> {
        if of.is_in_water() { vec![id::<R>(&R::Of::seen_from(of))] } else { Vec::new() }
    }

    fn fetch(of: &Trial, shelf: &dyn Shelf) -> Outcome<Self> {
        let found = of.is_in_water().then(|| fetch_one(&R::Of::seen_from(of), shelf));
        Ok(Self(found.transpose()?))
    }
}

/// A kind of record over a specimen's staircases in water.
pub struct Waded<R: Record>(pub Vec<(R::Of, R)>);

impl<R: Record<Of = Trial>> Waded<R> {
    fn subjects(of: &Specimen) -> Vec<Trial> {
        of.trials().into_iter().filter(|t| t.is_staircase_in_water() && R::is_made_for(t)).collect()
    }
}

impl<R: Record<Of = Trial>> Needs<Specimen> for Waded<R> {
    fn wanted(of: &Specimen) -> Vec<Id> {
        Self::subjects(of).iter().map(id::<R>).collect()
    }

    fn fetch(of: &Specimen, shelf: &dyn Shelf) -> Outcome<Self> {
        fetch_each(Self::subjects(of), shelf).map(Self)
    }
}

/// A kind of record over every trial of a specimen that has one.
pub struct OfTrials<R: Record>(pub Vec<(R::Of, R)>);

impl<R: Record<Of = crate::subject::Trial>> OfTrials<R> {
    fn subjects(of: &Specimen) -> Vec<R::Of> {
        of.trials().into_iter().filter(R::is_made_for).collect()
    }
}

impl<R: Record<Of = crate::subject::Trial>> Needs<Specimen> for OfTrials<R> {
    fn wanted(of: &Specimen) -> Vec<Id> {
        Self::subjects(of).iter().map(id::<R>).collect()
    }

    fn fetch(of: &Specimen, shelf: &dyn Shelf) -> Outcome<Self> {
        fetch_each(Self::subjects(of), shelf).map(Self)
    }
}

/// A kind of record over the repeats of a trial, itself among them.
pub struct Repeats<R: Record>(pub Vec<R>);

impl<R: Record<Of = Trial>> Needs<Trial> for Repeats<R> {
    fn wanted(of: &Trial) -> Vec<Id> {
        of.repeats().iter().map(id::<R>).collect()
    }

    fn fetch(of: &Trial, shelf: &dyn Shelf) -> Outcome<Self> {
        Ok(Self(of.repeats().iter().map(|s| fetch_one(s, shelf)).collect::<Outcome<_>>()?))
    }
}

impl<S> Needs<S> for () {
    fn wanted(_: &S) -> Vec<Id> {
        Vec::new()
    }

    fn fetch(_: &S, _: &dyn Shelf) -> Outcome<Self> {
        Ok(())
    }
}

impl<S, A: Needs<S>, B: Needs<S>> Needs<S> for (A, B) {
    fn wanted(of: &S) -> Vec<Id> {
        [A::wanted(of), B::wanted(of)].concat()
    }

    fn fetch(of: &S, shelf: &dyn Shelf) -> Outcome<Self> {
        Ok((A::fetch(of, shelf)?, B::fetch(of, shelf)?))
    }
}

impl<S, A: Needs<S>, B: Needs<S>, C: Needs<S>> Needs<S> for (A, B, C) {
    fn wanted(of: &S) -> Vec<Id> {
        [A::wanted(of), B::wanted(of), C::wanted(of)].concat()
    }

    fn fetch(of: &S, shelf: &dyn Shelf) -> Outcome<Self> {
        Ok((A::fetch(of, shelf)?, B::fetch(of, shelf)?, C::fetch(of, shelf)?))
    }
}

impl<S, A: Needs<S>, B: Needs<S>, C: Needs<S>, D: Needs<S>> Needs<S> for (A, B, C, D) {
    fn wanted(of: &S) -> Vec<Id> {
        [A::wanted(of), B::wanted(of), C::wanted(of), D::wanted(of)].concat()
    }

    fn fetch(of: &S, shelf: &dyn Shelf) -> Outcome<Self> {
        Ok((A::fetch(of, shelf)?, B::fetch(of, shelf)?, C::fetch(of, shelf)?, D::fetch(of, shelf)?))
    }
}
