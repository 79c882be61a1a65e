//! Transfer: thrust models trained on all other tails, evaluated on a held-out tail.

use serde::{Deserialize, Serialize};

use super::{Scored, Thrust};
use crate::subject::{Specimen, Study};
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};
use workflow::subject::Part;

/// Every tail held out in turn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Transfer {
    /// One a tail and model.
    pub scores: Vec<HeldOut>,
    /// Tails left out because their numbers of markers or chambers differ from those of most others.
    pub left_out: Vec<String>,
}

/// One model on one held-out tail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// The tail's name.
    pub tail: String,
    /// Its score; runs are counted over all other tails (training) and this one (test).
    pub scored: Scored,
}

/// Numbers of markers and chambers of a specimen: thrust models transfer between specimens with equal numbers only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layout {
    /// The specimen's name.
    pub name: String,
    /// Markers.
    pub markers: usize,
    /// Chambers.
    pub chambers: usize,
}

impl Part<Specimen> for Layout {
    fn part_of(specimen: &Specimen) -> Self {
        Self {
            name: specimen.card.name.clone(),
            markers: specimen.card.marker.len(),
            chambers: specimen.card.chamber.len(),
        }
    }
}

impl Layout {
    /// The names of the largest group with equal numbers of markers and chambers; of equal groups, the first.
    pub fn alike_layouts(layouts: &[Layout]) -> Vec<String> {
        let same = |a: &Layout, b: &Layout| (a.markers, a.chambers) == (b.markers, b.chambers);
        let group_size = |s: &Layout| layouts.iter().filter(|o| same(o, s)).count();
        let largest = layouts.iter().rev().max_by_key(|s| group_size(s));
        let names = |layout: &Layout| layouts.iter().filter(|s| same(s, layout)).map(|s| s.name.clone()).collect();
        largest.map(names).unwrap_or_default()
    }

    /// Those of specimens with force measurements.
    fn with_force(study: &Study) -> Vec<Layout> {
        study.specimens.iter().filter(|s| Thrust::is_made_for(s)).map(Part::part_of).collect()
    }
}

impl Record for Transfer {
    type Of = Study;
    const STAGE: &'static str = "transfer";

    fn is_made_for(study: &Study) -> bool {
        Layout::alike_layouts(&Layout::with_force(study)).len() > 1
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("transfer.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("transfer.json")
    }

    fn metrics(&self, _: &str) -> Vec<Metric> {
        let score_metrics = |held_out: &HeldOut| {
            let (id, score) = (format!("transfer.{}.{}", held_out.tail, held_out.scored.model), &held_out.scored.score);
            [
                Metric::new(format!("{id}.nrmse"), score.nrmse, ""),
                Metric::new(format!("{id}.mean_error_percent"), score.mean_error_percent, "%"),
            ]
        };
        self.scores.iter().flat_map(score_metrics).collect()
    }

    fn summary(&self) -> String {
        let mut tails: Vec<&str> = self.scores.iter().map(|held_out| held_out.tail.as_str()).collect();
        tails.dedup();
        let best = |tail: &&str| {
            let scores = self.scores.iter().filter(|held_out| held_out.tail == *tail).map(|held_out| &held_out.scored);
            let best = scores.min_by(|a, b| a.score.nrmse.total_cmp(&b.score.nrmse));
            best.map(|b| format!("{tail} best by {} (NRMSE {:.2})", b.model, b.score.nrmse))
        };
        let mut text: Vec<String> = tails.iter().filter_map(best).collect();
        let omission =
            |tail: &String| format!("{tail} left out: its number of markers or chambers differs from the others'");
        text.extend(self.left_out.iter().map(omission));
        text.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::card::{Card, Medium, Role, Split};

    /// A tail with force measurements and so many markers.
    fn tail(name: &str, markers: usize) -> Specimen {
        let text = include_str!("../../study/tests/card.toml");
        let mut card: Card = lab::card::parse(text, std::path::Path::new("card.toml")).unwrap();
        card.name = name.into();
        card.marker = std::iter::repeat_n(card.marker[0].clone(), markers).collect();
        card.trial.truncate(1);
        card.trial.push(card.trial[0].clone());
        for (trial, split) in card.trial.iter_mut().zip([Split::Train, Split::Test]) {
            (trial.medium, trial.role, trial.split) = (Medium::Water, Role::Thrust, Some(split));
            trial.force = Some("force.parquet".into());
        }
        Specimen { card: card.into() }
    }

    fn alike(specimens: Vec<Specimen>) -> Vec<String> {
        Layout::alike_layouts(&Layout::with_force(&Study { specimens }))
    }

    #[test]
    fn a_tail_with_another_number_of_markers_is_left_out() {
        assert_eq!(alike(vec![tail("a", 3), tail("b", 6), tail("c", 6)]), ["b", "c"]);
        assert_eq!(alike(vec![tail("a", 6), tail("b", 3)]), ["a"]);
        assert!(!Transfer::is_made_for(&Study { specimens: vec![tail("a", 6), tail("b", 3)] }));
    }
}
