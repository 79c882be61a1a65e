//! Training in epochs of shuffled mini-batches, with early stopping on validation samples.
//!
//! The validation samples must come from training trials; they decide when to stop and which weights are kept, and nothing else.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::layer::{self, LayerGradient};
use super::{Network, Samples, Scale};
use crate::optimisers::adam::{BiasCorrection, Update};

/// Training options.
#[derive(Debug, Clone, PartialEq)]
pub struct Training {
    /// Units of each hidden layer.
    pub hidden: Vec<usize>,
    /// α of Adam.
    pub step: f32,
    /// Samples in a batch.
    pub batch: usize,
    /// Passes through all samples, at most.
    pub epochs: usize,
    /// Epochs without a lower validation error after which training stops.
    pub patience: usize,
    /// Seed of the initial weights and of the order of the samples.
    pub seed: u64,
}

/// Mean squared errors of an epoch, as a share of the targets' variance in training.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Over the batches, while the weights changed.
    pub training: f32,
    /// On the validation samples.
    pub validation: f32,
}

/// A trained network and its training history.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// With the weights of the best epoch.
    pub network: Network,
    /// Every epoch.
    pub epochs: Vec<Epoch>,
    /// The epoch whose weights were kept, from 0.
    pub best_epoch: usize,
}

/// A network trained on `samples`; `validation` decides when to stop, and without validation samples the last epoch is kept.
///
/// `observe` is called after each epoch, step_numbered from 0. Bit-identical for a seed.
pub fn train(
    settings: &Training,
    samples: &Samples,
    validation: &Samples,
    observe: &mut dyn FnMut(usize, Epoch),
) -> Trained {
    let mut network = Network::new(Scale::of_samples(samples), &settings.hidden, settings.seed);
    let mut best = network.clone();
    let (mut best_epoch, mut lowest_error, mut epochs) = (0, f32::INFINITY, Vec::new());
    let standardised = network.standardised_rows(&samples.inputs);
    let Scale { answer_mean, answer_spread, .. } = network.scale;
    let targets: Vec<f32> = samples.targets.iter().map(|y| (y - answer_mean) / answer_spread).collect();
    let mut trainer = Trainer::new(&network, settings);
    for epoch in 0..settings.epochs {
        let training = trainer.run_epoch(&mut network, &standardised, &targets, settings);
        let error = validation_error(&network, validation);
        let epoch_errors = Epoch { training, validation: error };
        epochs.push(epoch_errors);
        observe(epoch, epoch_errors);
        if error < lowest_error || validation.row_count() == 0 {
            (best_epoch, lowest_error, best) = (epoch, error, network.clone());
        }
        if validation.row_count() > 0 && epoch >= best_epoch + settings.patience {
            break;
        }
    }
    Trained { network: best, epochs, best_epoch }
}

fn validation_error(network: &Network, samples: &Samples) -> f32 {
    let spread = f64::from(network.scale.answer_spread);
    let predictions = network.predict(&samples.inputs);
    let squares = predictions.iter().zip(&samples.targets).map(|(f, y)| (f64::from(f - y) / spread).powi(2));
    (squares.sum::<f64>() / samples.row_count().max(1) as f64) as f32
}

/// β₁ and β₂, as published and as in PyTorch.
const DECAY: [f32; 2] = [0.9, 0.999];

/// State of the training from batch to batch.
struct Trainer {
    draw: ChaCha8Rng,
    adams: Vec<[Update<f32>; 2]>,
    gradients: Vec<LayerGradient>,
    step_number: i32,
}

impl Trainer {
    fn new(network: &Network, settings: &Training) -> Self {
        let adams = network
            .layers
            .iter()
            .map(|l| [l.weight.len(), l.bias.len()].map(|size| Update::new(size, DECAY, BiasCorrection::OfStep)));
        let gradients = vec![LayerGradient::default(); network.layers.len()];
        // The order of the samples has its own stream, so that it is independent of the initial weights.
        Self {
            draw: ChaCha8Rng::seed_from_u64(settings.seed ^ 0x0bad_cafe),
            adams: adams.collect(),
            gradients,
            step_number: 0,
        }
    }

    fn run_epoch(&mut self, network: &mut Network, standardised: &[f32], targets: &[f32], settings: &Training) -> f32 {
        let (width, mut order) = (network.input_width(), (0..targets.len()).collect::<Vec<usize>>());
        for i in (1..order.len()).rev() {
            order.swap(i, (self.draw.next_u64() % (i as u64 + 1)) as usize);
        }
        let mut squares = 0.0_f64;
        for selection in order.chunks(settings.batch) {
            let x: Vec<f32> =
                selection.iter().flat_map(|&i| &standardised[i * width..(i + 1) * width]).copied().collect();
            let y: Vec<f32> = selection.iter().map(|&i| targets[i]).collect();
            squares += self.run_batch(network, x, &y, settings.step);
        }
        (squares / targets.len() as f64) as f32
    }

    /// One step of Adam on a batch; returns the sum of squared errors.
    fn run_batch(&mut self, network: &mut Network, x: Vec<f32>, targets: &[f32], step: f32) -> f64 {
        let (batch, last_layer) = (targets.len(), network.layers.len() - 1);
        let mut states = vec![x];
        for (i, layer) in network.layers.iter().enumerate() {
            let mut y = layer.forward_batch(&states[i], batch);
            if i < last_layer {
                layer::rectify_values(&mut y);
            }
            states.push(y);
        }
        let errors: Vec<f32> = states[last_layer + 1].iter().zip(targets).map(|(predicted, y)| predicted - y).collect();
        let mut gradient: Vec<f32> = errors.iter().map(|d| 2.0 * d / batch as f32).collect();
        for (i, layer) in network.layers.iter().enumerate().rev() {
            layer.weight_gradient(&states[i], &gradient, batch, &mut self.gradients[i]);
            if i > 0 {
                gradient = layer.backward_batch(&gradient, batch);
                gradient.iter_mut().zip(&states[i]).for_each(|(p, y)| *p *= f32::from(u8::from(*y > 0.0)));
            }
        }
        self.step_number += 1;
        for ((layer, [weight, bias]), gradient) in network.layers.iter_mut().zip(&mut self.adams).zip(&self.gradients) {
            weight.update_parameters(&mut layer.weight, &gradient.weight, step, self.step_number);
            bias.update_parameters(&mut layer.bias, &gradient.bias, step, self.step_number);
        }
        errors.iter().map(|d| f64::from(d * d)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rows: usize, phase: f32) -> Samples {
        let row = |i: usize| [(0.37 * i as f32 + phase).sin(), (0.11 * i as f32).cos()];
        let inputs = (0..rows).flat_map(row).collect();
        let targets = (0..rows).map(row).map(|[a, b]| 0.1 * a * a - 0.3 * (a * b).abs() + 5.0).collect();
        Samples { width: 2, inputs, targets }
    }

    fn set() -> Training {
        Training { hidden: vec![32, 48, 32], step: 1e-3, batch: 64, epochs: 40, patience: 40, seed: 3 }
    }

    #[test]
    fn a_curved_surface_is_learnt_and_interpolated() {
        let made = train(&set(), &samples(4000, 0.0), &samples(500, 0.1), &mut |_, _| {});
        let unseen = samples(500, 0.2);
        // of the targets' variance
        assert!(validation_error(&made.network, &unseen) < 2e-3, "{}", validation_error(&made.network, &unseen));
    }

    #[test]
    fn the_error_is_a_mean_over_the_rows() {
        let (once, network) = (samples(5, 0.0), Network::new(Scale::of_samples(&samples(5, 0.0)), &[4], 1));
        let (inputs, targets) = (once.inputs.repeat(2), once.targets.repeat(2));
        assert_eq!(
            validation_error(&network, &Samples { width: 2, inputs, targets }),
            validation_error(&network, &once)
        );
    }

    #[test]
    fn the_error_is_a_share_of_the_variance_of_the_targets_in_training() {
        let of = |factor: f32| {
            let mut scaled = samples(50, 0.0);
            scaled.targets.iter_mut().for_each(|y| *y *= factor);
            validation_error(&Network::new(Scale::of_samples(&scaled), &[4], 1), &scaled)
        };
        assert!((of(10.0) / of(1.0) - 1.0).abs() < 1e-3, "{} {}", of(10.0), of(1.0));
    }

    #[test]
    fn the_same_seed_gives_the_same_bits_and_another_another() {
        let quick = Training { epochs: 3, ..set() };
        let of =
            |seed| train(&Training { seed, ..quick.clone() }, &samples(500, 0.0), &samples(50, 0.1), &mut |_, _| {});
        assert_eq!(of(1), of(1));
        assert_ne!(of(1).network, of(2).network);
    }

    #[test]
    fn training_stops_when_the_validation_error_no_longer_falls() {
        let mut wrong = samples(200, 0.1);
        // the validation targets fall where those in training rise: every step makes them worse
        wrong.targets.iter_mut().for_each(|y| *y = 10.0 - *y);
        let made = train(&Training { patience: 2, ..set() }, &samples(500, 0.0), &wrong, &mut |_, _| {});
        assert!(made.epochs.len() < 40 && made.epochs.len() == made.best_epoch + 3);
    }

    #[test]
    fn the_gradient_of_a_batch_is_that_of_central_differences() {
        let all = samples(64, 0.0);
        let network = Network::new(Scale::of_samples(&all), &[16, 16], 5);
        let (standard, scale) = (network.standardised_rows(&all.inputs), network.scale.clone());
        let targets: Vec<f32> = all.targets.iter().map(|y| (y - scale.answer_mean) / scale.answer_spread).collect();
        let mut trainer = Trainer::new(&network, &set());
        let mut moved = network.clone();
        let before = trainer.run_batch(&mut moved, standard.clone(), &targets, 0.0) / 64.0;
        let gradient = trainer.gradients[1].weight.clone();
        for at in [0, 17, 101] {
            let loss = |by: f32| {
                let mut other = network.clone();
                other.layers[1].weight[at] += by;
                Trainer::new(&other, &set()).run_batch(&mut other, standard.clone(), &targets, 0.0) / 64.0
            };
            // f32: 1e-7 of a loss near one over a step of 1e-2
            let difference = (loss(1e-2) - loss(-1e-2)) / 2e-2;
            assert!(
                (difference - f64::from(gradient[at])).abs() < 1e-3 * f64::from(gradient[at]).abs().max(0.1),
                "{difference} {}",
                gradient[at]
            );
        }
        assert!(before > 0.0);
    }
}
