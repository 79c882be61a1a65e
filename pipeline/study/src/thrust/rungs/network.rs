//! The network as a rung: rows of marks and pressures in, force out; stopped by training runs that are set aside.
//!
//! Stands on: fit, run. Never knows: a held-out run. Paper: section V.

use fit::network::{Network, Samples, Training, train};

use super::linear::Weighted;
use crate::thrust::Run;

/// How networks are trained.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// The paper's network.
    pub training: Training,
    /// Share of the training runs that decide when to stop.
    pub aside: f64,
    /// Hidden units of the small network that learns what theory leaves.
    pub rest_hidden: Vec<usize>,
}

impl Lesson {
    /// The training of the small network.
    pub fn small(&self) -> Training {
        Training { hidden: self.rest_hidden.clone(), ..self.training.clone() }
    }
}

/// A network that learns the force of runs, or what `theory` leaves of it. Every so many runs, one is set aside.
pub fn learn(runs: &[&Run], theory: Option<&Weighted>, lesson: &Lesson, progress: &dyn Fn(f64)) -> Network {
    let every = (1.0 / lesson.aside.clamp(1e-3, 0.5)).round() as usize;
    let is_aside = |i: usize| runs.len() > 1 && i % every == every / 2;
    let (mut samples, mut aside) = (Samples::default(), Samples::default());
    for (i, run) in runs.iter().enumerate() {
        gather(run, theory, if is_aside(i) { &mut aside } else { &mut samples });
    }
    aside.width = samples.width;
    let epochs = lesson.training.epochs.max(1) as f64;
    train(&lesson.training, &samples, &aside, &mut |epoch, _| progress((epoch + 1) as f64 / epochs)).network
}

fn gather(run: &Run, theory: Option<&Weighted>, into: &mut Samples) {
    let told = theory.map(|t| t.tell(run));
    for i in 0..run.len() {
        let row = run.row(i);
        into.width = row.len();
        into.inputs.extend(row);
        into.answers.push((run.force[i] - told.as_ref().map_or(0.0, |t| t[i])) as f32);
    }
}

/// What a network says of a run, N.
pub fn tell(network: &Network, run: &Run) -> Vec<f64> {
    let rows: Vec<f32> = (0..run.len()).flat_map(|i| run.row(i)).collect();
    network.predict(&rows).into_iter().map(f64::from).collect()
}
