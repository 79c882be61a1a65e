//! Time of one epoch of the paper's network on one thread: 50 000 samples of 16 inputs, batches of 128.

use std::time::Instant;

use optimize::network::{Samples, Training, train};

fn samples(rows: usize) -> Samples {
    let input = |i: usize| (0.013 * i as f32 + 0.7 * (i % 16) as f32).sin();
    let inputs: Vec<f32> = (0..16 * rows).map(input).collect();
    let targets = inputs.chunks(16).map(|x| x[0] * x[1] - x[5].abs()).collect();
    Samples { width: 16, inputs, targets }
}

fn main() {
    let hidden = vec![200, 300, 200];
    let set = Training { hidden, step: 1e-3, batch: 128, epochs: 3, patience: 3, seed: 1 };
    let start = Instant::now();
    let made = train(&set, &samples(50_000), &samples(1_000), &mut |_, _| {});
    println!("{:.2} s an epoch, error {:.4}", start.elapsed().as_secs_f64() / 3.0, made.epochs[2].training);
    if let Ok(bytes) = made.network.to_safetensors() {
        println!("{} weights, {} bytes", made.network.parameter_count(), bytes.len());
    }
}
