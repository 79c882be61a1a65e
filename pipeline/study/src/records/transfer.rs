//! Transfer: how well models of thrust that learnt from all other tails tell it of a tail that they never saw.

use serde::{Deserialize, Serialize};

use super::{Scored, Thrust};
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::{Specimen, Study};

/// Every tail held out in turn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Transfer {
    /// One a tail and rung.
    pub scores: Vec<HeldOut>,
    /// Tails whose marks or chambers are not as many as most others': no model could take both.
    pub left_out: Vec<String>,
}

/// One rung that never saw one tail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// The tail's name.
    pub tail: String,
    /// How the rung tells it; its runs are counted over all other tails and over this one.
    pub scored: Scored,
}

impl Transfer {
    /// The weighed specimens that are seen by equally many marks and chambers: the most of them, else the first.
    pub fn alike(study: &Study) -> Vec<Specimen> {
        let weighed: Vec<&Specimen> = study.specimens.iter().filter(|s| Thrust::is_made_for(s)).collect();
        let layout = |s: &Specimen| (s.card.marker.len(), s.card.chamber.len());
        let like = |s: &Specimen| weighed.iter().filter(|o| layout(o) == layout(s)).count();
        let most = weighed.iter().rev().max_by_key(|s| like(s));
        let found =
            |of: &&Specimen| weighed.iter().filter(|s| layout(s) == layout(of)).map(|s| (**s).clone()).collect();
        most.map(found).unwrap_or_default()
    }
}

impl Record for Transfer {
    type Of = Study;
    const STAGE: &'static str = "transfer";

    fn is_made_for(of: &Study) -> bool {
        Self::alike(of).len() > 1
    }

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("transfer.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("transfer.json")
    }

    fn metrics(&self, _: &Study) -> Vec<Metric> {
        let both = |held: &HeldOut| {
            let (id, score) = (format!("transfer.{}.{}", held.tail, held.scored.rung), &held.scored.score);
            [
                Metric::new(format!("{id}.nrmse"), score.nrmse, ""),
                Metric::new(format!("{id}.mean_error_percent"), score.mean_error_percent, "%"),
            ]
        };
        self.scores.iter().flat_map(both).collect()
    }

    fn telling(&self) -> String {
        let mut tails: Vec<&str> = self.scores.iter().map(|held| held.tail.as_str()).collect();
        tails.dedup();
        let best = |tail: &&str| {
            let of = self.scores.iter().filter(|held| held.tail == *tail).map(|held| &held.scored);
            let best = of.min_by(|a, b| a.score.nrmse.total_cmp(&b.score.nrmse));
            best.map(|b| format!("{tail} best by {} (NRMSE {:.2})", b.rung, b.score.nrmse))
        };
        let mut said: Vec<String> = tails.iter().filter_map(best).collect();
        let out = |tail: &String| format!("{tail} left out: its marks or chambers are not as many as the others'");
        said.extend(self.left_out.iter().map(out));
        said.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::card::{Card, Medium, Role, Split};

    /// A weighed tail with so many marks.
    fn tail(name: &str, marks: usize) -> Specimen {
        let text = include_str!("../../tests/card.toml");
        let mut card: Card = lab::card::parse(text, std::path::Path::new("card.toml")).unwrap();
        card.name = name.into();
        card.marker = std::iter::repeat_n(card.marker[0].clone(), marks).collect();
        card.trial.truncate(1);
        card.trial.push(card.trial[0].clone());
        for (trial, split) in card.trial.iter_mut().zip([Split::Train, Split::Test]) {
            (trial.medium, trial.role, trial.split) = (Medium::Water, Role::Thrust, Some(split));
            trial.force = Some("force.parquet".into());
        }
        Specimen { card: card.into() }
    }

    fn alike(specimens: Vec<Specimen>) -> Vec<String> {
        Transfer::alike(&Study { specimens }).iter().map(|s| s.card.name.clone()).collect()
    }

    #[test]
    fn a_tail_with_other_marks_than_most_is_left_out() {
        assert_eq!(alike(vec![tail("a", 3), tail("b", 6), tail("c", 6)]), ["b", "c"]);
        assert_eq!(alike(vec![tail("a", 6), tail("b", 3)]), ["a"]);
        assert!(!Transfer::is_made_for(&Study { specimens: vec![tail("a", 6), tail("b", 3)] }));
    }
}
