//! Training: epochs of shuffled batches, and stopping when samples that are set aside are met no better.
//!
//! The samples set aside must come from training trials; they decide when to stop and which weights to keep, and nothing else.
//!
//! Stands on: layer, adam. Never knows: what is predicted, a held-out trial.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::adam::Adam;
use super::layer::{self, Pull};
use super::{Network, Samples, Scale};

/// How to train.
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
    /// Epochs without a better error on the samples set aside, after which training stops.
    pub patience: usize,
    /// Of the first weights and of the order of the samples.
    pub seed: u64,
}

/// Mean squared errors after an epoch, over the answers' variance in training.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Over the batches, while their weights changed.
    pub training: f32,
    /// On the samples set aside.
    pub aside: f32,
}

/// A trained network and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// With the weights of the best epoch.
    pub network: Network,
    /// Every epoch.
    pub epochs: Vec<Epoch>,
    /// Which one was kept, from 0.
    pub kept: usize,
}

/// A network trained on `samples`; `aside` decides when to stop, and with no rows the last epoch is kept.
///
/// Each epoch ends with `observe`, from 0. Bit-identical for a seed.
pub fn train(set: &Training, samples: &Samples, aside: &Samples, observe: &mut dyn FnMut(usize, Epoch)) -> Outcome {
    let mut network = Network::new(Scale::of(samples), &set.hidden, set.seed);
    let mut best = network.clone();
    let (mut kept, mut lowest, mut epochs) = (0, f32::INFINITY, Vec::new());
    let standard = network.standard(&samples.inputs);
    let Scale { answer_mean, answer_spread, .. } = network.scale;
    let answers: Vec<f32> = samples.answers.iter().map(|y| (y - answer_mean) / answer_spread).collect();
    let mut walk = Walk::new(&network, set);
    for epoch in 0..set.epochs {
        let training = walk.epoch(&mut network, &standard, &answers, set);
        let error = error(&network, aside);
        let now = Epoch { training, aside: error };
        epochs.push(now);
        observe(epoch, now);
        if error < lowest || aside.rows() == 0 {
            (kept, lowest, best) = (epoch, error, network.clone());
        }
        if aside.rows() > 0 && epoch >= kept + set.patience {
            break;
        }
    }
    Outcome { network: best, epochs, kept }
}

fn error(network: &Network, samples: &Samples) -> f32 {
    let spread = f64::from(network.scale.answer_spread);
    let found = network.predict(&samples.inputs);
    let squares = found.iter().zip(&samples.answers).map(|(f, y)| (f64::from(f - y) / spread).powi(2));
    (squares.sum::<f64>() / samples.rows().max(1) as f64) as f32
}

/// What is kept from batch to batch.
struct Walk {
    draw: ChaCha8Rng,
    adams: Vec<[Adam; 2]>,
    pulls: Vec<Pull>,
    number: i32,
}

impl Walk {
    fn new(network: &Network, set: &Training) -> Self {
        let adams = network.layers.iter().map(|l| [Adam::new(l.weight.len()), Adam::new(l.bias.len())]);
        let pulls = vec![Pull::default(); network.layers.len()];
        // the order of samples has its own stream, so that it does not follow from the weights
        Self { draw: ChaCha8Rng::seed_from_u64(set.seed ^ 0x0bad_cafe), adams: adams.collect(), pulls, number: 0 }
    }

    fn epoch(&mut self, network: &mut Network, standard: &[f32], answers: &[f32], set: &Training) -> f32 {
        let (width, mut order) = (network.width(), (0..answers.len()).collect::<Vec<usize>>());
        for i in (1..order.len()).rev() {
            order.swap(i, (self.draw.next_u64() % (i as u64 + 1)) as usize);
        }
        let mut squares = 0.0_f64;
        for chosen in order.chunks(set.batch) {
            let x: Vec<f32> = chosen.iter().flat_map(|&i| &standard[i * width..(i + 1) * width]).copied().collect();
            let y: Vec<f32> = chosen.iter().map(|&i| answers[i]).collect();
            squares += self.batch(network, x, &y, set.step);
        }
        (squares / answers.len() as f64) as f32
    }

    /// One step; returns the sum of squared errors.
    fn batch(&mut self, network: &mut Network, x: Vec<f32>, answers: &[f32], step: f32) -> f64 {
        let (batch, last) = (answers.len(), network.layers.len() - 1);
        let mut states = vec![x];
        for (i, layer) in network.layers.iter().enumerate() {
            let mut y = layer.forward(&states[i], batch);
            if i < last {
                layer::rectify(&mut y);
            }
            states.push(y);
        }
        let off: Vec<f32> = states[last + 1].iter().zip(answers).map(|(found, y)| found - y).collect();
        let mut pull: Vec<f32> = off.iter().map(|d| 2.0 * d / batch as f32).collect();
        for (i, layer) in network.layers.iter().enumerate().rev() {
            layer.gather(&states[i], &pull, batch, &mut self.pulls[i]);
            if i > 0 {
                pull = layer.backward(&pull, batch);
                pull.iter_mut().zip(&states[i]).for_each(|(p, y)| *p *= f32::from(u8::from(*y > 0.0)));
            }
        }
        self.number += 1;
        for ((layer, [weight, bias]), pull) in network.layers.iter_mut().zip(&mut self.adams).zip(&self.pulls) {
            weight.step(&mut layer.weight, &pull.weight, step, self.number);
            bias.step(&mut layer.bias, &pull.bias, step, self.number);
        }
        off.iter().map(|d| f64::from(d * d)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rows: usize, phase: f32) -> Samples {
        let row = |i: usize| [(0.37 * i as f32 + phase).sin(), (0.11 * i as f32).cos()];
        let inputs = (0..rows).flat_map(row).collect();
        let answers = (0..rows).map(row).map(|[a, b]| 0.1 * a * a - 0.3 * (a * b).abs() + 5.0).collect();
        Samples { width: 2, inputs, answers }
    }

    fn set() -> Training {
        Training { hidden: vec![32, 48, 32], step: 1e-3, batch: 64, epochs: 40, patience: 40, seed: 3 }
    }

    #[test]
    fn a_curved_surface_is_learnt_and_met_between_the_samples() {
        let made = train(&set(), &samples(4000, 0.0), &samples(500, 0.1), &mut |_, _| {});
        let unseen = samples(500, 0.2);
        // of the answers' variance
        assert!(error(&made.network, &unseen) < 2e-3, "{}", error(&made.network, &unseen));
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
    fn training_stops_when_samples_aside_are_met_no_better() {
        let mut wrong = samples(200, 0.1);
        // the answers aside fall where those in training rise: every lesson makes them worse
        wrong.answers.iter_mut().for_each(|y| *y = 10.0 - *y);
        let made = train(&Training { patience: 2, ..set() }, &samples(500, 0.0), &wrong, &mut |_, _| {});
        assert!(made.epochs.len() < 40 && made.epochs.len() == made.kept + 3);
    }

    #[test]
    fn one_step_lowers_the_error_as_the_gradient_says() {
        let all = samples(64, 0.0);
        let network = Network::new(Scale::of(&all), &[16, 16], 5);
        let (standard, scale) = (network.standard(&all.inputs), network.scale.clone());
        let answers: Vec<f32> = all.answers.iter().map(|y| (y - scale.answer_mean) / scale.answer_spread).collect();
        let mut walk = Walk::new(&network, &set());
        let mut moved = network.clone();
        let before = walk.batch(&mut moved, standard.clone(), &answers, 0.0) / 64.0;
        let pull = walk.pulls[1].weight.clone();
        for at in [0, 17, 101] {
            let loss = |by: f32| {
                let mut other = network.clone();
                other.layers[1].weight[at] += by;
                Walk::new(&other, &set()).batch(&mut other, standard.clone(), &answers, 0.0) / 64.0
            };
            // f32: 1e-7 of a loss near one over a step of 1e-2
            let difference = (loss(1e-2) - loss(-1e-2)) / 2e-2;
            assert!(
                (difference - f64::from(pull[at])).abs() < 1e-3 * f64::from(pull[at]).abs().max(0.1),
                "{difference} {}",
                pull[at]
            );
        }
        assert!(before > 0.0);
    }
}
