//! A spectrum by its strengths at a few knots: the branches between two knots have strengths interpolated over the logarithm of their times.
//!
//! One branch a decade leaves a ripple of ±4 e^(−π²/ln 10) = 5 % in the loss of an even spectrum, which no strengths can take away; two leave less
//! than 0.1 % (the Fourier coefficient of ½ sech, the loss of one branch over the logarithm of the frequency). A search begins at knots a decade apart;
//! then every branch is free under its prior, so that what films leave open within a decade is in the intervals.

use fem::Branch;
use nalgebra::DMatrix;
use si::Second;

/// Knots of a spectrum.
#[derive(Debug, Clone)]
pub(super) struct Knots {
    /// Rising, s.
    pub(super) times: Vec<Second>,
    /// Branches from one knot to the next.
    pub(super) per_interval: usize,
    /// Logarithm of the median of the prior of each strength.
    pub(super) median: Vec<f64>,
}

impl Knots {
    /// A knot at every branch, and the strengths there (logarithms) of a spectrum with `log_strengths` at the knots.
    pub(super) fn free_every_branch(&self, log_strengths: &[f64]) -> (Self, Vec<f64>) {
        let strengths = |log_strengths: &[f64]| self.branches(log_strengths).iter().map(|b| b.strength.ln()).collect();
        let times = self.branches(log_strengths).iter().map(|b| b.time).collect();
        (Self { times, per_interval: 1, median: strengths(&self.median) }, strengths(log_strengths))
    }

    /// The branches, whose strengths are those at the knots (`log_strengths`) spread over the branches of an interval. A branch at either end
    /// stands for all of its knot's outer half.
    pub(super) fn branches(&self, log_strengths: &[f64]) -> Vec<Branch> {
        let (weights, parts) = (self.knot_weights(), self.per_interval.max(1));
        let count = weights.nrows();
        let share = |k: usize| {
            let inner = 1.0 / parts as f64;
            let outer = [k == 0, k + 1 == count].into_iter().filter(|end| *end).count();
            inner + 0.5 * (1.0 - inner) * outer as f64
        };
        let sum = |k: usize, value: &dyn Fn(usize) -> f64| -> f64 {
            weights.row(k).iter().enumerate().map(|(knot, weight)| weight * value(knot)).sum::<f64>()
        };
        let time = |k: usize| match k % parts {
            0 => self.times[k / parts],
            _ => sum(k, &|knot| self.times[knot].ln()).exp(),
        };
        let strength = |k: usize| share(k) * sum(k, &|knot| log_strengths[knot]).exp();
        (0..count).map(|k| Branch { strength: strength(k), time: time(k) }).collect()
    }

    /// Weights of the knots in each branch: branches × knots, each row a sum of one.
    pub(super) fn knot_weights(&self) -> DMatrix<f64> {
        let (knots, parts) = (self.times.len(), self.per_interval.max(1));
        let weight = |branch: usize, knot: usize| {
            let distance = branch as f64 / parts as f64 - knot as f64;
            (1.0 - distance.abs()).max(0.0)
        };
        let branches = if knots == 0 { 0 } else { (knots - 1) * parts + 1 };
        DMatrix::from_fn(branches, knots, weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem::Relaxation;

    const TIMES: [f64; 5] = [0.002, 0.02, 0.2, 2.0, 20.0];

    fn knots(per_interval: usize) -> Knots {
        Knots { times: TIMES.to_vec(), per_interval, median: vec![0.1_f64.ln(); 5] }
    }

    #[test]
    fn freed_branches_are_the_same_spectrum() {
        let at = [0.3, 0.1, 0.2, 0.05, 0.4_f64].map(f64::ln);
        let (freed, strengths) = knots(2).free_every_branch(&at);
        assert!(freed.times.len() == 9 && (freed.median[3] - 0.05_f64.ln()).abs() < 1e-12);
        let pairs = freed.branches(&strengths).into_iter().zip(knots(2).branches(&at));
        assert!(pairs.into_iter().all(|(a, b)| (a.strength / b.strength - 1.0).abs() < 1e-12));
    }

    /// Largest over least loss modulus of an even spectrum over its middle decade.
    fn ripple(per_interval: usize) -> f64 {
        let branches = knots(per_interval).branches(&[0.01_f64.ln(); 5]);
        let spectrum = Relaxation::maxwell(&branches).unwrap();
        let loss = |i: i32| spectrum.complex_modulus(5.0 * 10_f64.powf(f64::from(i) / 40.0 - 0.5))[1];
        let (least, most) = (0..=40).map(loss).fold((f64::MAX, 0.0_f64), |(l, m), x| (l.min(x), m.max(x)));
        most / least - 1.0
    }

    #[test]
    fn two_branches_an_interval_leave_no_ripple_in_the_loss() {
        // ±5.5 %, and what little the ends of four decades tilt the middle one
        assert!((ripple(1) - 0.11).abs() < 0.03, "{}", ripple(1));
        assert!(ripple(2) < 0.03, "{}", ripple(2));
    }

    #[test]
    fn a_knot_gives_as_much_relaxation_however_many_branches_spread_it() {
        let all = |per_interval| {
            let branches = knots(per_interval).branches(&[0.1_f64.ln(); 5]);
            branches.iter().map(|b| b.strength).sum::<f64>()
        };
        let alone = Knots { times: vec![0.1], ..knots(3) }.branches(&[0.1_f64.ln()]);
        assert!(alone.len() == 1 && (alone[0].strength - 0.1).abs() < 1e-12);
        assert!((all(1) - 0.5).abs() < 1e-12 && (all(2) - 0.5).abs() < 1e-12 && (all(3) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn branches_at_the_knots_have_their_times_and_one_an_interval_their_strengths() {
        let at = [0.3, 0.1, 0.2, 0.05, 0.4_f64].map(f64::ln);
        let one = knots(1).branches(&at);
        let two = knots(2).branches(&at);
        assert!(one.len() == 5 && two.len() == 9);
        for (k, ln) in at.iter().enumerate() {
            assert!((one[k].strength - ln.exp()).abs() < 1e-12 && (two[2 * k].time / TIMES[k] - 1.0).abs() < 1e-12);
        }
        // geometric means half way
        assert!(
            (two[3].time - (0.02 * 0.2_f64).sqrt()).abs() < 1e-12
                && (two[3].strength - 0.5 * (0.02_f64).sqrt()).abs() < 1e-12
        );
    }
}
