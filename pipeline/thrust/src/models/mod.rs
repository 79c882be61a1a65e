//! Thrust models, from the mean to a network; each is fitted to runs and predicts others.
//!
//! A new model: its place in [`MODELS`] and its arm in [`ThrustModel::fit`].

pub mod linear;
pub mod network;

pub mod testing;

use super::Run;
use linear::Weighted;

pub use network::TrainingSettings;

/// A kind of model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThrustModel {
    /// The mean force of all runs.
    Mean,
    /// A straight line in f A and its square, one force a run.
    Linear,
    /// A static curve of the pressures.
    Pressure,
    /// A finite impulse response of the markers' motion.
    Fir,
    /// Elongated-body theory as in the paper; nothing fitted.
    Ebt,
    /// Lighthill's terms, drag and inertia, five coefficients.
    Theory,
    /// The paper's network.
    Network,
    /// Theory, and a small network for its residual.
    Hybrid,
}

/// Every model, the simplest first.
pub const MODELS: [ThrustModel; 8] = [
    ThrustModel::Mean,
    ThrustModel::Linear,
    ThrustModel::Pressure,
    ThrustModel::Fir,
    ThrustModel::Ebt,
    ThrustModel::Theory,
    ThrustModel::Network,
    ThrustModel::Hybrid,
];

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub enum Fitted {
    /// Weights of columns.
    Weighted(Weighted),
    /// Nothing fitted.
    Ebt,
    /// A network.
    Network(Box<optimize::network::Network>),
    /// Weights of theory's columns, then a network for the rest.
    Hybrid(Weighted, Box<optimize::network::Network>),
}

impl ThrustModel {
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

    /// The model fitted to `runs`; `progress` receives the fraction done, 0 to 1.
    pub fn fit(self, runs: &[&Run], training: &TrainingSettings, progress: &dyn Fn(f64)) -> Fitted {
        match self {
            Self::Mean | Self::Linear | Self::Pressure | Self::Fir | Self::Theory => {
                Fitted::Weighted(Weighted::fit(self, runs))
            }
            Self::Ebt => Fitted::Ebt,
            Self::Network => Fitted::Network(Box::new(network::trained_network(runs, None, training, progress))),
            Self::Hybrid => {
                let theory = Weighted::fit(Self::Theory, runs);
                let residual_training = TrainingSettings { training: training.small(), ..training.clone() };
                let residual_network = network::trained_network(runs, Some(&theory), &residual_training, progress);
                Fitted::Hybrid(theory, Box::new(residual_network))
            }
        }
    }
}

impl Fitted {
    /// The force (N) at every sample of a run.
    pub fn predict(&self, run: &Run) -> Vec<f64> {
        match self {
            Self::Weighted(weighted) => weighted.predict(run),
            Self::Ebt => run.terms.iter().map(|t| t.trailing_edge).collect(),
            Self::Network(network) => network::predict(network, run),
            Self::Hybrid(theory, residual_network) => {
                theory.predict(run).iter().zip(network::predict(residual_network, run)).map(|(t, r)| t + r).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::score;

    #[test]
    fn each_model_predicts_a_held_out_run_and_the_better_ones_improve_on_the_mean() {
        let runs: Vec<Run> = (0..6).map(|i| testing::run([1.0, 2.0, 3.0][i % 3], 2e4, i as u64)).collect();
        let train: Vec<&Run> = runs.iter().collect();
        let unseen = testing::run(2.0, 2e4, 77);
        let training = testing::training();
        let error =
            |model: ThrustModel| score(&[&unseen], &[model.fit(&train, &training, &|_| {}).predict(&unseen)]).nrmse;
        let mean = error(ThrustModel::Mean);
        for model in [ThrustModel::Fir, ThrustModel::Theory, ThrustModel::Network, ThrustModel::Hybrid] {
            assert!(error(model) < 0.7 * mean, "{}: {} of {mean}", model.name(), error(model));
        }
        assert!(error(ThrustModel::Theory) < 0.1, "the force of this run is that of theory");
    }
}
