//! Selections of records: trials that identification may use, staircases in water, repeats of a trial.
//!
//! Identification and training never read a validation trial: their inputs are selected here only.

use std::marker::PhantomData;

use diagnostics::Result;
use serde_json::Value;
use workflow::needs::{Needs, RecordId, RecordReader, id, ids_of, parts_of, read_each, read_one};
use workflow::record::Record;
use workflow::subject::{Part, SubjectOf};

use crate::subject::{Specimen, Trial, TrialId};

/// Which trials of a specimen.
pub trait Selection {
    /// Whether a trial is one of them.
    fn selects(trial: &Trial) -> bool;
}

/// A kind of record over the selected trials of a specimen that have one, each with its part of the trial.
pub struct OfTrials<R, S = Any, P = TrialId>(pub Vec<(P, R)>, pub PhantomData<S>);

/// Every trial.
pub struct Any;

/// Trials from which parameters may be identified.
pub struct Identification;

/// Staircases under water.
pub struct UnderwaterStaircases;

impl Selection for Any {
    fn selects(_: &Trial) -> bool {
        true
    }
}

impl Selection for Identification {
    fn selects(trial: &Trial) -> bool {
        trial.is_for_identification()
    }
}

impl Selection for UnderwaterStaircases {
    fn selects(trial: &Trial) -> bool {
        trial.is_staircase_in_water()
    }
}

/// A kind of record over the identification trials of a specimen.
pub type IdentificationTrials<R> = OfTrials<R, Identification>;

impl<R: Record<Of = Trial>, S: Selection, P> OfTrials<R, S, P> {
    fn subjects(specimen: &Specimen) -> Vec<Trial> {
        specimen.trials().into_iter().filter(|trial| S::selects(trial) && R::is_made_for(trial)).collect()
    }
}

impl<R: Record<Of = Trial>, S: Selection, P: Part<Trial>> Needs<Specimen> for OfTrials<R, S, P> {
    fn ids(specimen: &Specimen) -> Vec<RecordId> {
        ids_of::<R>(&Self::subjects(specimen))
    }

    fn parts(specimen: &Specimen) -> Value {
        parts_of::<Trial, P>(&Self::subjects(specimen))
    }

    fn read(specimen: &Specimen, reader: &dyn RecordReader) -> Result<Self> {
        Ok(Self(read_each(&Self::subjects(specimen), reader)?, PhantomData))
    }
}

/// A record that is read for trials in water alone.
pub struct InWater<R>(pub Option<R>);

impl<R> Needs<Trial> for InWater<R>
where
    R: Record,
    R::Of: SubjectOf<Trial>,
{
    fn ids(trial: &Trial) -> Vec<RecordId> {
        if trial.is_in_water() { vec![id::<R>(&R::Of::subject_of(trial))] } else { Vec::new() }
    }

    fn read(trial: &Trial, reader: &dyn RecordReader) -> Result<Self> {
        trial.is_in_water().then(|| read_one(&R::Of::subject_of(trial), reader)).transpose().map(Self)
    }
}

/// A kind of record over the repeats of a trial, itself among them.
pub struct Repeats<R: Record>(pub Vec<R>);

impl<R: Record<Of = Trial>> Needs<Trial> for Repeats<R> {
    fn ids(trial: &Trial) -> Vec<RecordId> {
        ids_of::<R>(&trial.repeat_trials())
    }

    fn read(trial: &Trial, reader: &dyn RecordReader) -> Result<Self> {
        trial.repeat_trials().iter().map(|repeat| read_one(repeat, reader)).collect::<Result<_>>().map(Self)
    }
}
