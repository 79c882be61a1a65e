//! A mass on a damped spring, pulled by a force that is straight between samples: followed exactly.
//!
//! m ẍ + b ẋ + k x = u(t). Over an interval with u = u₀ + g t the motion is the particular one,
//! x = (u₀ + g t)/k − b g/k², ẋ = g/k, and what of the start is not on it, which rings down freely (first-order hold).
//!
//! Stands on: `si`. Never knows: what swings.

use si::{Kilogram, Newton, Second};

/// m, b and k, underdamped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// m, kg.
    pub mass: Kilogram,
    /// b, N s/m.
    pub damping: f64,
    /// k, N/m.
    pub stiffness: f64,
}

/// Place (m) and speed (m/s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Swing {
    /// x, m.
    pub place: f64,
    /// ẋ, m/s.
    pub speed: f64,
}

impl Oscillator {
    /// The oscillator of mass `mass` (kg), undamped angular frequency `omega` (rad/s) and damping ratio `ratio` < 1.
    pub fn tuned(mass: Kilogram, omega: f64, ratio: f64) -> Self {
        assert!(ratio < 1.0 && omega > 0.0 && mass > 0.0, "an underdamped oscillator");
        Self { mass, damping: 2.0 * ratio * omega * mass, stiffness: omega * omega * mass }
    }

    /// Undamped angular frequency, rad/s.
    pub fn omega(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// Rate of decay, 1/s, and damped angular frequency, rad/s.
    pub fn decay_and_beat(&self) -> (f64, f64) {
        let decay = 0.5 * self.damping / self.mass;
        (decay, (self.stiffness / self.mass - decay * decay).sqrt())
    }

    /// Where `swing` is `step` (s) later while the force goes straight from `from` to `to` (N). Exact but for rounding.
    pub fn after(&self, swing: Swing, [from, to]: [Newton; 2], step: Second) -> Swing {
        let slope = (to - from) / step;
        let offset = self.damping * slope / (self.stiffness * self.stiffness);
        let steady = |u: Newton| Swing { place: u / self.stiffness - offset, speed: slope / self.stiffness };
        let (begin, end) = (steady(from), steady(to));
        let left = Swing { place: swing.place - begin.place, speed: swing.speed - begin.speed };
        let free = self.free(left, step);
        Swing { place: end.place + free.place, speed: end.speed + free.speed }
    }

    /// Where `swing` is `step` (s) later with no force.
    pub fn free(&self, swing: Swing, step: Second) -> Swing {
        let (decay, beat) = self.decay_and_beat();
        let (sin, cos) = (beat * step).sin_cos();
        let lead = (swing.speed + decay * swing.place) / beat;
        let place = swing.place * cos + lead * sin;
        let turned = beat * (lead * cos - swing.place * sin);
        let shrunk = (-decay * step).exp();
        Swing { place: shrunk * place, speed: shrunk * (turned - decay * place) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Second = 1e-3;

    fn fixture() -> Oscillator {
        Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03)
    }

    #[test]
    fn a_step_of_force_is_answered_as_in_the_textbook() {
        let it = fixture();
        let ((decay, beat), mut swing) = (it.decay_and_beat(), Swing::default());
        for i in 1..=2000 {
            swing = it.after(swing, [1.0, 1.0], STEP);
            let t = STEP * f64::from(i);
            let ring = (-decay * t).exp() * ((beat * t).cos() + decay / beat * (beat * t).sin());
            assert!((swing.place * it.stiffness - (1.0 - ring)).abs() < 1e-10, "at {t} s");
        }
    }

    #[test]
    fn a_ramp_is_answered_the_same_in_one_step_as_in_a_thousand() {
        let it = fixture();
        let mut swing = Swing { place: 1e-4, speed: -0.02 };
        let at_once = it.after(swing, [0.5, 2.5], 1.0);
        for i in 0..1000 {
            let u = [f64::from(i), f64::from(i + 1)].map(|n| 0.5 + 2.0 * n * STEP);
            swing = it.after(swing, u, STEP);
        }
        assert!((swing.place - at_once.place).abs() < 1e-12 && (swing.speed - at_once.speed).abs() < 1e-10);
    }

    #[test]
    fn a_ring_down_loses_energy_at_its_damping_ratio() {
        let it = fixture();
        let ((decay, beat), start) = (it.decay_and_beat(), Swing { place: 1e-3, speed: 0.0 });
        let period = std::f64::consts::TAU / beat;
        let later = it.free(start, period);
        assert!((later.place / start.place - (-decay * period).exp()).abs() < 1e-12);
    }
}
