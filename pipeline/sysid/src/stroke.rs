//! The first strokes of a flapping motion of the whole body, whose shapes teach a reduced model what equilibria do not hold.
//!
//! In motion walls pass through their buckles against inertia and relaxation, in shapes that no pressure and lateral load holds still. Measured on
//! half a tail of thin walls at 2 Hz, largest distance of the tip from the whole body's, of the length: 2.4 % by 36 coordinates of 52 equilibria, 0.5 %
//! by 28 of 40 equilibria and the strokes, which cost about as much as the twelve equilibria under both pressures that they take the place of.

use diagnostics::Result;
use fem::{Branch, DynamicSettings, InitialValueProblem, Relaxation, Scheme, State};
use si::{Hertz, Pascal, Second};

use crate::model::{Elastic, Model, Viscoelastic};

/// A flapping motion that is to come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Highest pressure, Pa.
    pub amplitude: Pascal,
    /// Hz.
    pub frequency: Hertz,
}

/// Time steps in which a chamber is filled: 240 a second at 2 Hz.
const STEPS_PER_TURN: usize = 60;
/// Of a turn, the part in which the pressure rises, and falls in the next one.
// An edge of a tenth of a second at 2 Hz: with edges of some 50 ms a step of a tail of thin walls took three to five times as long.
const RISE: f64 = 0.4;
/// Every so many steps teach: neighbours are alike.
const SEEN: usize = 2;
/// Strength by decade of the relaxation, s: its prior, as it is identified in motions of the reduced model.
// Without it whole steps failed that silicone damps.
const RELAXATION: [(Second, f64); 5] = [(0.002, 0.1), (0.02, 0.1), (0.2, 0.1), (2.0, 0.1), (20.0, 0.1)];

impl Stroke {
    /// Shapes (3 entries a node, m) of `model` while each of its chambers whose highest pressure in `top` is above 0 is filled in turn.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when the constants are refused.
    pub(crate) fn shapes(&self, model: &Model, elastic: &Elastic, top: &[Pascal]) -> Result<Vec<Vec<f64>>> {
        let turns = turns(top);
        let branches = RELAXATION.map(|(time, strength)| Branch { strength, time });
        let silicone = Viscoelastic { elastic: elastic.clone(), relaxation: Relaxation::maxwell(&branches)? };
        let mut solver = model.system.solver();
        silicone.apply(&mut solver)?;
        let step = self.turn_duration() / STEPS_PER_TURN as f64;
        let settings = DynamicSettings { step, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
        let initial = State::rest(model.system.mesh().nodes.len());
        let pressures = |t: Second| self.pressures(&turns, top.len(), t);
        let problem = InitialValueProblem { settings: &settings, initial: &initial, pressures: &pressures };
        let (mut shapes, mut steps) = (Vec::new(), 0);
        let mut see = |_: Second, state: &State| {
            steps += 1;
            if steps % SEEN == 0 {
                shapes.push(state.displacement.clone());
            }
        };
        // A motion that is lost on the way has taught what it reached; how far the model is from the whole body is measured where it predicts.
        let _ = solver.integrate(&problem, turns.len() * STEPS_PER_TURN, &mut see);
        Ok(shapes)
    }

    fn turn_duration(&self) -> Second {
        0.5 / self.frequency
    }

    /// Pressures of so many `chambers` at a time, Pa.
    fn pressures(&self, turns: &[Option<usize>], chambers: usize, t: Second) -> Vec<Pascal> {
        let mut pressures = vec![0.0; chambers];
        for (turn, chamber) in turns.iter().enumerate() {
            let since_begin = t / self.turn_duration() - turn as f64;
            if let Some(chamber) = chamber {
                pressures[*chamber] += self.amplitude * (edge(since_begin) - edge(since_begin - 1.0));
            }
        }
        pressures
    }
}

/// The chamber that is filled in each turn; one alone is vented in the next.
fn turns(top: &[Pascal]) -> Vec<Option<usize>> {
    let mut turns: Vec<Option<usize>> = (0..top.len()).filter(|k| top[*k] > 0.0).map(Some).collect();
    if turns.len() == 1 {
        turns.push(None);
    }
    turns
}

/// From 0 to 1 over [`RISE`] of a turn, smoothly.
fn edge(since_begin: f64) -> f64 {
    let part = (since_begin / RISE).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chambers_are_filled_in_turn_and_one_alone_is_vented() {
        let stroke = Stroke { amplitude: 2e4, frequency: 2.0 };
        let three = turns(&[1e4, 0.0, 1e4]);
        assert_eq!(three, [Some(0), Some(2)]);
        assert_eq!(stroke.pressures(&three, 3, 0.2), [2e4, 0.0, 0.0]);
        let change = stroke.pressures(&three, 3, 0.3);
        assert!(change[0] > 0.0 && change[2] > 0.0 && (change[0] + change[2] - 2e4).abs() < 1e-9, "{change:?}");
        assert_eq!(stroke.pressures(&three, 3, 0.45), [0.0, 0.0, 2e4]);
        assert_eq!(stroke.pressures(&turns(&[1e4]), 1, 0.5), [0.0]);
    }
}
