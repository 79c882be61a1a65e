//! Rungs: the ladder of models, from what anyone would guess to a network; each is fitted to runs and then tells others.
//!
//! A new rung: its place in [`LADDER`] and its arm in [`Rung::fit`].
//!
//! Stands on: run, its members. Never knows: which runs are held out.

pub mod linear;
pub mod network;
pub mod theory;

#[cfg(test)]
pub(crate) mod testing;

use super::Run;
use linear::Weighted;

pub use network::Lesson;

/// A kind of model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rung {
    /// The mean force of all runs.
    Mean,
    /// A straight line in f A and its square, one force a run.
    Linear,
    /// A static curve of the pressures.
    Pressure,
    /// A finite impulse response of the marks' motion.
    Fir,
    /// Elongated-body theory as the paper has it; nothing fitted.
    Ebt,
    /// Lighthill's terms, drag and inertia, five coefficients.
    Theory,
    /// The paper's network.
    Network,
    /// Theory, and a small network for what it leaves.
    Hybrid,
}

/// Every rung, the simplest first.
pub const LADDER: [Rung; 8] =
    [Rung::Mean, Rung::Linear, Rung::Pressure, Rung::Fir, Rung::Ebt, Rung::Theory, Rung::Network, Rung::Hybrid];

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub enum Fitted {
    /// Weights of columns.
    Weighted(Weighted),
    /// Nothing fitted.
    Ebt,
    /// A network.
    Network(Box<fit::network::Network>),
    /// Weights of theory's columns, then a network for the rest.
    Hybrid(Weighted, Box<fit::network::Network>),
}

impl Rung {
    /// Its name in tables and metrics.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Linear => "linear",
            Self::Pressure => "pressure",
            Self::Fir => "fir",
            Self::Ebt => "ebt",
            Self::Theory => "theory",
            Self::Network => "network",
            Self::Hybrid => "hybrid",
        }
    }

    /// The model fitted to `runs`; `progress` hears how far it is, 0 to 1.
    pub fn fit(self, runs: &[&Run], lesson: &Lesson, progress: &dyn Fn(f64)) -> Fitted {
        match self {
            Self::Mean | Self::Linear | Self::Pressure | Self::Fir | Self::Theory => {
                Fitted::Weighted(Weighted::fit(self, runs))
            }
            Self::Ebt => Fitted::Ebt,
            Self::Network => Fitted::Network(Box::new(network::learn(runs, None, lesson, progress))),
            Self::Hybrid => {
                let theory = Weighted::fit(Self::Theory, runs);
                let small = Lesson { training: lesson.small(), ..lesson.clone() };
                let rest = network::learn(runs, Some(&theory), &small, progress);
                Fitted::Hybrid(theory, Box::new(rest))
            }
        }
    }
}

impl Fitted {
    /// The force (N) at every sample of a run.
    pub fn tell(&self, run: &Run) -> Vec<f64> {
        match self {
            Self::Weighted(weighted) => weighted.tell(run),
            Self::Ebt => run.terms.iter().map(|t| t.simple).collect(),
            Self::Network(network) => network::tell(network, run),
            Self::Hybrid(theory, rest) => {
                theory.tell(run).iter().zip(network::tell(rest, run)).map(|(t, r)| t + r).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::score::score;

    #[test]
    fn each_rung_tells_a_run_it_never_saw_and_the_better_ones_beat_the_mean() {
        let runs: Vec<Run> = (0..6).map(|i| testing::run([1.0, 2.0, 3.0][i % 3], 2e4, i as u64)).collect();
        let train: Vec<&Run> = runs.iter().collect();
        let unseen = testing::run(2.0, 2e4, 77);
        let lesson = testing::lesson();
        let error = |rung: Rung| score(&[&unseen], &[rung.fit(&train, &lesson, &|_| {}).tell(&unseen)]).nrmse;
        let mean = error(Rung::Mean);
        for rung in [Rung::Fir, Rung::Theory, Rung::Network, Rung::Hybrid] {
            assert!(error(rung) < 0.7 * mean, "{}: {} of {mean}", rung.name(), error(rung));
        }
        assert!(error(Rung::Theory) < 0.1, "the force of this run is theory's own");
    }
}
