//! Transfer: each tail is held out in turn; every thrust model is trained on all runs of the others and evaluated on all of its runs.
//!
//! Markers, velocities and pressures stay in their units, as in the paper's network; their normalisation is computed on the training
//! tails.

use rayon::prelude::*;

use super::thrust;
use ::thrust::score::score;
use ::thrust::{MODELS, Run, ThrustModel, TrainingSettings};
use diagnostics::Result;
use records::{HeldOut, Layout, Scored, Thrust, Transfer as Record};
use workflow::needs::Every;
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Transfer;

/// A tail's name and its runs.
type Tail<'a> = (String, &'a [Run]);

impl Stage for Transfer {
    type Settings = thrust::Settings;
    type Card = ();
    type Needs = Every<Thrust, Layout>;
    type Makes = Record;
    const DESCRIPTION: &'static str = "thrust models are evaluated on a held-out tail";
    const VERSION: u32 = 3;
    const SECTION: &'static str = "thrust";

    fn run((): &(), set: &thrust::Settings, Every(needs): Self::Needs, context: &dyn StageContext) -> Result<Record> {
        let alike = Layout::alike_layouts(&needs.iter().map(|(layout, _)| layout.clone()).collect::<Vec<_>>());
        let is_alike = |name: &String| alike.contains(name);
        let tails: Vec<Tail> = needs.iter().map(|(layout, t)| (layout.name.clone(), t.runs.as_slice())).collect();
        let (tails, unlike_tails): (Vec<Tail>, Vec<Tail>) = tails.into_iter().partition(|(name, _)| is_alike(name));
        let training = set.training_settings(set.network_seeds()[0]);
        let scores = held_out(&tails, &training, &|part, text| context.progress(part, text));
        Ok(Record { scores, left_out: unlike_tails.into_iter().map(|(name, _)| name).collect() })
    }
}

/// Every model on every tail; `progress` receives the fraction done and the current item.
fn held_out(tails: &[Tail], training: &TrainingSettings, progress: &(dyn Fn(f64, &str) + Sync)) -> Vec<HeldOut> {
    let pairs: Vec<(usize, ThrustModel)> =
        (0..tails.len()).flat_map(|tail| MODELS.map(|model| (tail, model))).collect();
    let judged = |(number, (tail, model)): (usize, &(usize, ThrustModel))| {
        let name = &tails[*tail].0;
        let text = format!("{} without {name}", model.name());
        let heard = |part: f64| progress((number as f64 + part) / pairs.len() as f64, &text);
        HeldOut {
            tail: name.clone(),
            scored: held_out_score(&Split::holding_out(tails, *tail), *model, training, &heard),
        }
    };
    pairs.par_iter().enumerate().map(judged).collect()
}

/// Runs on which a model is trained, and those on which it is evaluated.
struct Split<'a> {
    train: Vec<&'a Run>,
    test: Vec<&'a Run>,
}

impl<'a> Split<'a> {
    /// One tail is held out.
    fn holding_out(tails: &[Tail<'a>], out: usize) -> Self {
        let training_tails = tails.iter().enumerate().filter(|(tail, _)| *tail != out);
        let train = training_tails.flat_map(|(_, (_, runs))| runs.iter()).collect();
        Self { train, test: tails[out].1.iter().collect() }
    }
}

/// Trains a model and evaluates it; `heard` receives the fraction done.
fn held_out_score(split: &Split, kind: ThrustModel, training: &TrainingSettings, heard: &dyn Fn(f64)) -> Scored {
    let Split { train, test } = split;
    let model = kind.fit(train, training, heard);
    let predicted: Vec<Vec<f64>> = test.iter().map(|run| model.predict(run)).collect();
    Scored {
        split_rule: "tail".into(),
        model: kind.name().into(),
        seed: 0,
        score: score(test, &predicted),
        runs: [train.len(), test.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::thrust::models::testing;

    /// Runs of a tail whose force is theory's prediction multiplied by `times`.
    fn runs(amplitude: f64, times: f64) -> Vec<Run> {
        let one = |i: u64| {
            let mut run = testing::run([1.0, 2.0, 3.0][i as usize % 3], amplitude, i);
            run.force.iter_mut().for_each(|f| *f *= times);
            run
        };
        (0..3).map(one).collect()
    }

    fn scores(third: &[Run]) -> Vec<HeldOut> {
        let (first, second) = (runs(2e4, 1.0), runs(3e4, 1.0));
        let tails = [("a".to_owned(), &first[..]), ("b".to_owned(), &second[..]), ("c".to_owned(), third)];
        let mut training = testing::training();
        training.training.epochs = 2;
        held_out(&tails, &training, &|_, _| {})
    }

    fn of(scores: &[HeldOut], tail: &str, model: ThrustModel) -> Scored {
        scores.iter().find(|h| h.tail == tail && h.scored.model == model.name()).unwrap().scored.clone()
    }

    #[test]
    fn a_law_that_all_tails_share_is_carried_to_the_one_held_out() {
        let found = scores(&runs(1.5e4, 1.0));
        assert_eq!(found.len(), 3 * MODELS.len());
        for tail in ["a", "b", "c"] {
            // the noise is some hundredths of the forces' deviation; the NRMSE of the mean is at least 1 by definition
            let (theory, mean) = (of(&found, tail, ThrustModel::Theory), of(&found, tail, ThrustModel::Mean));
            assert!(theory.score.nrmse < 0.15 && mean.score.nrmse >= 1.0, "{tail}: {:?}", theory.score);
            assert_eq!(theory.runs, [6, 3]);
        }
    }

    #[test]
    fn a_held_out_tail_is_not_trained_on() {
        let found = scores(&runs(1e4, -3.0));
        // its force has the opposite sign and three times the size: a model trained on it would have an error below 4/3 of its size
        let theory = of(&found, "c", ThrustModel::Theory).score;
        assert!(theory.nrmse > 1.2, "{theory:?}");
    }
}
