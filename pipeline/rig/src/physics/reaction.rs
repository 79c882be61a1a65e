//! Reactions: the force that a moving body hands to its holder, from its motion alone.
//!
//! In air nothing but the holder pushes the body as a whole, so that what it is pushed with is Σ m a over its nodes.
//!
//! Stands on: the body's masses, its motion. Never knows: what the force is measured with.

use si::{Hertz, Newton, Second};

use super::{Body, Motion};

/// A force at even times.
pub struct Reaction {
    start: Second,
    rate: Hertz,
    force: Vec<Newton>,
}

impl Reaction {
    /// Thrust (along −x) on the holder of `body` in `motion` from `start` to `end` (s), which is minus the force −Σ m a that
    /// the body's inertia exerts along x: second differences of the motion at `rate` (Hz), at which it is best known.
    pub fn of(body: &Body, motion: &dyn Motion, [start, end]: [Second; 2], rate: Hertz) -> Self {
        let masses = body.system.node_masses();
        let halves = if body.mesh.half { 2.0 } else { 1.0 };
        let moment = |i: usize| {
            let nodes = motion.nodes(start + i as f64 / rate);
            masses.iter().zip(&nodes).map(|(m, x)| m * x[0]).sum::<f64>()
        };
        let moments: Vec<f64> = (0..=((end - start) * rate) as usize).map(moment).collect();
        Self { start, rate, force: second_differences(&moments, halves * rate * rate) }
    }

    /// At time `t` (s), straight between, nothing beyond; N.
    pub fn at(&self, t: Second) -> Newton {
        let place = (t - self.start) * self.rate;
        let at = |i: f64| if i < 0.0 { 0.0 } else { self.force.get(i as usize).copied().unwrap_or(0.0) };
        let share = place - place.floor();
        at(place.floor()) * (1.0 - share) + at(place.floor() + 1.0) * share
    }
}

/// `by` times the second difference at each value; none at the ends.
fn second_differences(values: &[f64], by: f64) -> Vec<f64> {
    let middle = values.windows(3).map(|v| by * (v[0] - 2.0 * v[1] + v[2]));
    [0.0].into_iter().chain(middle).chain([0.0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Resolution, Settings};
    use crate::specimen::Hidden;
    use crate::specimens::ALL;
    use si::Point3;

    /// Every node pushed along x ever faster, by 3 m/s².
    struct Pushed(Vec<Point3>);

    impl Motion for Pushed {
        fn nodes(&self, t: Second) -> Vec<Point3> {
            self.0.iter().map(|x| [x[0] + 1.5 * t * t, x[1], x[2]]).collect()
        }
    }

    #[test]
    fn a_tail_that_is_pushed_as_a_whole_reacts_with_its_whole_mass() {
        let (set, tail) = (Settings::built_in(), (ALL[0].tail)());
        let own = &set.specimen[ALL[0].name];
        let fineness = Resolution { edge: 0.009, per_chamber: 1, per_rib: 1 };
        let body = Body::new(&tail, &fineness, own, &Hidden::drawn(own)).unwrap();
        let reaction = Reaction::of(&body, &Pushed(body.mesh.nodes.clone()), [0.0, 0.5], 60.0);
        let whole = if body.mesh.half { 2.0 } else { 1.0 } * body.system.mass();
        assert!((reaction.at(0.25) / (3.0 * whole) - 1.0).abs() < 1e-8, "{} N of {whole} kg", reaction.at(0.25));
    }

    #[test]
    fn a_parabola_has_one_acceleration() {
        let moments: Vec<f64> = (0..10).map(|i| 0.5 * 3.0 * (0.1 * f64::from(i)).powi(2)).collect();
        let force = second_differences(&moments, 100.0);
        assert!(force[1..9].iter().all(|f| (f - 3.0).abs() < 1e-9) && force.len() == 10);
    }

    #[test]
    fn a_force_is_straight_between_its_times_and_nothing_beyond() {
        let reaction = Reaction { start: 1.0, rate: 10.0, force: vec![0.0, 2.0, 4.0] };
        for (t, force) in [(0.9, 0.0), (1.05, 1.0), (1.2, 4.0), (1.25, 2.0), (2.0, 0.0)] {
            assert!((reaction.at(t) - force).abs() < 1e-9, "at {t} s");
        }
    }
}
