//! Whether markers move as the model does: a film that is mirrored about the body's own axis shows its markers at rest where they belong, and
//! their motion on the other side; so do channels that were exchanged.

use si::Point2;

use super::fitting::Fitting;
use diagnostics::{Diagnostic, Result};
use sysid::Minimum;

/// Correlation of measured and simulated displacements of a film below which they are opposite, no unit: whatever its modulus, a body that bends
/// to the right side has more than 0.9, its mirror image less than −0.9.
const OPPOSITE: f64 = -0.5;

impl Fitting<'_> {
    /// Refuses a film whose markers move against the model at the best moduli.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the trial.
    pub(super) fn check_direction(&self, minimum: &Minimum) -> Result<()> {
        let mut trials: Vec<&str> = self.origins.iter().map(|(trial, _)| trial.as_str()).collect();
        trials.dedup();
        for trial in trials {
            // length: a trial and a simulated level for each measured one
            let levels = self.origins.iter().zip(&self.loss.misfit.levels).zip(&minimum.levels);
            let of_trial = levels.filter(|((origin, _), _)| origin.0 == trial);
            let pairs = of_trial.map(|((_, measured), simulated)| (&measured.measured[..], &simulated.markers[..]));
            let correlation = correlation(pairs);
            if correlation < OPPOSITE {
                return Err(opposite_motion(trial, correlation));
            }
        }
        Ok(())
    }
}

/// Correlation of displacements about zero, no unit: Σ a·b / √(Σ a² Σ b²).
fn correlation<'a>(pairs: impl Iterator<Item = (&'a [Point2], &'a [Point2])>) -> f64 {
    let [mut products, mut measured, mut simulated] = [0.0; 3];
    // length: both have a displacement for each marker
    for (a, b) in pairs.flat_map(|(a, b)| a.iter().zip(b)) {
        products += a[0] * b[0] + a[1] * b[1];
        measured += a[0] * a[0] + a[1] * a[1];
        simulated += b[0] * b[0] + b[1] * b[1];
    }
    products / (measured * simulated).sqrt().max(f64::MIN_POSITIVE)
}

fn opposite_motion(trial: &str, correlation: f64) -> Diagnostic {
    let defect = format!("the markers of `{trial}` move to the side opposite to the model's");
    let reason =
        format!("measured and simulated displacements have a correlation of {correlation:.2}; the limit is {OPPOSITE}");
    let action =
        "check that the film is not mirrored against the calibration, and which chamber each channel fills on the card";
    Diagnostic::new(defect, reason, action)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_motion_is_opposite_whatever_its_size() {
        let model = [[-1e-3, 5e-3], [-2e-3, 9e-3]];
        let with = |scale: f64, side: f64| {
            let film = model.map(|[x, y]| [scale * x, scale * side * y]);
            correlation([(&film[..], &model[..])].into_iter())
        };
        assert!(with(0.2, 1.0) > 0.99 && with(3.0, 1.0) > 0.99);
        assert!(with(0.2, -1.0) < -0.9 && with(3.0, -1.0) < -0.9);
        assert_eq!(correlation([(&[[0.0; 2]][..], &[[1.0; 2]][..])].into_iter()), 0.0, "nothing moves");
        assert!(opposite_motion("static_left", -0.9).to_string().contains("not mirrored"));
    }
}
