//! Transfer: each tail is held out in turn; every rung of the ladder learns from all runs of the others and is judged by all of it.
//!
//! Marks, velocities and pressures stay in their units, as the paper's network takes them; what brings them to one size is
//! measured on the tails that are learnt from.
//!
//! Stands on: the runs that stage `thrust` gathered, the room `thrust`. Never knows: a recording, how a run was gathered.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::thrust;
use crate::fault::Outcome;
use crate::needs::Every;
use crate::records::{HeldOut, Scored, Thrust, Transfer as Record};
use crate::stage::{Desk, Stage};
use crate::subject::{Scope, Study};
use crate::thrust::score::score;
use crate::thrust::{LADDER, Lesson, Run, Rung};

/// The stage.
pub struct Transfer;

/// A tail's name and its runs.
type Tail<'a> = (String, &'a [Run]);

impl Stage for Transfer {
    type Settings = thrust::Settings;
    type Needs = Every<Thrust>;
    type Makes = Record;
    const STORY: &'static str = "models of thrust are tried on a tail they never saw";
    const EDITION: u32 = 1;
    const SECTION: &'static str = "thrust";

    fn card(of: &Study) -> Value {
        json!(Record::alike(of).iter().map(Scope::name).collect::<Vec<_>>())
    }

    fn run(of: &Study, set: &thrust::Settings, needs: Every<Thrust>, desk: &dyn Desk) -> Outcome<Record> {
        let alike: Vec<String> = Record::alike(of).iter().map(Scope::name).collect();
        let is_alike = |name: &String| alike.contains(name);
        let tails: Vec<Tail> = needs.0.iter().map(|(s, t)| (s.name(), t.runs.as_slice())).collect();
        let (tails, others): (Vec<Tail>, Vec<Tail>) = tails.into_iter().partition(|(name, _)| is_alike(name));
        let lesson = set.lesson(set.seeds()[0]);
        let scores = held_out(&tails, &lesson, &|part, said| desk.progress(part, said));
        Ok(Record { scores, left_out: others.into_iter().map(|(name, _)| name).collect() })
    }
}

/// Every rung on every tail; `progress` hears how far it is and at what.
fn held_out(tails: &[Tail], lesson: &Lesson, progress: &(dyn Fn(f64, &str) + Sync)) -> Vec<HeldOut> {
    let pairs: Vec<(usize, Rung)> = (0..tails.len()).flat_map(|tail| LADDER.map(|rung| (tail, rung))).collect();
    let judged = |(number, (tail, rung)): (usize, &(usize, Rung))| {
        let (name, test) = &tails[*tail];
        let said = format!("{} without {name}", rung.name());
        let heard = |part: f64| progress((number as f64 + part) / pairs.len() as f64, &said);
        HeldOut { tail: name.clone(), scored: judge(tails, *tail, test, *rung, lesson, &heard) }
    };
    pairs.par_iter().enumerate().map(judged).collect()
}

fn judge(tails: &[Tail], out: usize, test: &[Run], rung: Rung, lesson: &Lesson, heard: &dyn Fn(f64)) -> Scored {
    let others = tails.iter().enumerate().filter(|(tail, _)| *tail != out);
    let train: Vec<&Run> = others.flat_map(|(_, (_, runs))| runs.iter()).collect();
    let test: Vec<&Run> = test.iter().collect();
    let model = rung.fit(&train, lesson, heard);
    let told: Vec<Vec<f64>> = test.iter().map(|run| model.tell(run)).collect();
    Scored {
        parting: "tail".into(),
        rung: rung.name().into(),
        seed: 0,
        score: score(&test, &told),
        runs: [train.len(), test.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::rungs::testing;

    /// Runs of a tail whose force is theory's own, `times` as strong.
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
        let mut lesson = testing::lesson();
        lesson.training.epochs = 2;
        held_out(&tails, &lesson, &|_, _| {})
    }

    fn of(scores: &[HeldOut], tail: &str, rung: Rung) -> Scored {
        scores.iter().find(|h| h.tail == tail && h.scored.rung == rung.name()).unwrap().scored.clone()
    }

    #[test]
    fn a_law_that_all_tails_share_is_carried_to_the_one_held_out() {
        let found = scores(&runs(1.5e4, 1.0));
        assert_eq!(found.len(), 3 * LADDER.len());
        for tail in ["a", "b", "c"] {
            // the noise is some hundredths of these forces' deviation; the mean's error is at least 1 by what NRMSE is
            let (theory, mean) = (of(&found, tail, Rung::Theory), of(&found, tail, Rung::Mean));
            assert!(theory.score.nrmse < 0.15 && mean.score.nrmse >= 1.0, "{tail}: {:?}", theory.score);
            assert_eq!(theory.runs, [6, 3]);
        }
    }

    #[test]
    fn a_tail_that_is_held_out_teaches_nothing_about_itself() {
        let found = scores(&runs(1e4, -3.0));
        // its force is turned and three times as strong: who had seen it would tell it better than an error of 4/3 of its size
        let theory = of(&found, "c", Rung::Theory).score;
        assert!(theory.nrmse > 1.2, "{theory:?}");
    }
}
