//! The network as a model: from positions, velocities and pressures to force; early stopping on a validation part of the training runs.

use optimize::network::{Network, Samples, Training, train};

use super::linear::Weighted;
use crate::Run;

/// How networks are trained.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingSettings {
    /// The paper's network.
    pub training: Training,
    /// Fraction of the training runs used for early stopping.
    pub validation_fraction: f64,
    /// Hidden units of the small network that is trained on theory's residual.
    pub residual_hidden_layers: Vec<usize>,
}

impl TrainingSettings {
    /// The training of the small network.
    pub fn small(&self) -> Training {
        Training { hidden: self.residual_hidden_layers.clone(), ..self.training.clone() }
    }
}

/// A network trained on the force of runs, or on its residual after `theory`. A fixed fraction of the runs is used for early stopping.
pub(crate) fn trained_network(
    runs: &[&Run],
    theory: Option<&Weighted>,
    training: &TrainingSettings,
    progress: &dyn Fn(f64),
) -> Network {
    let interval = (1.0 / training.validation_fraction.clamp(1e-3, 0.5)).round() as usize;
    let is_validation = |i: usize| runs.len() > 1 && i % interval == interval / 2;
    let (mut samples, mut validation) = (Samples::default(), Samples::default());
    for (i, run) in runs.iter().enumerate() {
        add_samples(run, theory, if is_validation(i) { &mut validation } else { &mut samples });
    }
    validation.width = samples.width;
    let epochs = training.training.epochs.max(1) as f64;
    train(&training.training, &samples, &validation, &mut |epoch, _| progress((epoch + 1) as f64 / epochs)).network
}

fn add_samples(run: &Run, theory: Option<&Weighted>, samples: &mut Samples) {
    let predicted = theory.map(|t| t.predict(run));
    for i in 0..run.len() {
        let row = run.row(i);
        samples.width = row.len();
        samples.inputs.extend(row);
        samples.targets.push((run.force[i] - predicted.as_ref().map_or(0.0, |t| t[i])) as f32);
    }
}

/// A network's prediction for a run, N.
pub fn predict(network: &Network, run: &Run) -> Vec<f64> {
    let rows: Vec<f32> = (0..run.len()).flat_map(|i| run.row(i)).collect();
    network.predict(&rows).into_iter().map(f64::from).collect()
}

#[cfg(test)]
mod tests {
    use crate::models::testing;

    #[test]
    fn the_network_of_the_residual_has_its_own_layers_and_the_training_of_the_other() {
        let set = testing::training();
        let small = set.small();
        assert_eq!((small.hidden, small.epochs, small.seed), (set.residual_hidden_layers, 40, 5));
    }
}
