//! Uncertainty of identified moduli: covariance, a sentence, and advice on which data would reduce it.

use optimize::posterior::UNCERTAIN;
use optimize::{Bounds, Evaluation, Problem};
use si::Pascal;
use sysid::Body;

use super::fitting::NAMES;
use crate::records::{Profile, Uncertainty};
use diagnostics::{Diagnostic, Result};

/// The uncertainty of the moduli at the best point of a search over their logarithms.
///
/// # Errors
/// A [`Diagnostic`] when the best point has no residuals, or they do not determine the moduli.
pub fn of(body: &Body, best: &Evaluation, search: &Problem) -> Result<Uncertainty> {
    let Some(residuals) = &best.residuals else {
        return Err(Diagnostic::new(
            "the best point has no residuals",
            "it was evaluated without them",
            "report it with the recordings",
        ));
    };
    let posterior = residuals.posterior(2)?;
    let sigma = vec![posterior.sigma(0), posterior.sigma(1)];
    let mut advice = more_data(&sigma);
    advice.extend(implausible(body, &best.at, search.bounds()));
    Ok(Uncertainty {
        sigma,
        correlation: posterior.correlation(0, 1),
        chi_square: residuals.reduced_chi_square(2),
        words: posterior.summary(&NAMES),
        advice,
    })
}

/// Advice on further recordings for each uncertain modulus.
fn more_data(sigma: &[f64]) -> Vec<String> {
    let loose = NAMES.iter().zip(sigma).filter(|(_, s)| **s > UNCERTAIN);
    let text = "has an uncertainty of a tenth or more: film more markers between clamp and fin, or hold more pressures on both sides";
    loose.map(|(name, _)| format!("E of {name} {text}")).collect()
}

/// Fraction of the plausible range that counts as its end.
const END: f64 = 0.02;

/// A note for each modulus at a bound of the search: the card's plausible range, or the feasible lower bound.
fn implausible(body: &Body, at: &[f64], bounds: &Bounds) -> Vec<String> {
    let ends = |k: usize| {
        let part = (at[k] - bounds.low[k]) / (bounds.high[k] - bounds.low[k]);
        !(END..=1.0 - END).contains(&part)
    };
    let word = |k: usize| {
        let [low, high] = [bounds.low[k], bounds.high[k]].map(|at| 1e-6 * body.materials[k].youngs_modulus * at.exp());
        format!("E of {} reached a bound of the search, {low:.3} to {high:.3} MPa", NAMES[k])
    };
    (0..2).filter(|&k| ends(k)).map(word).collect()
}

/// Profile likelihoods: χ² over each modulus, minimised over the other, from χ² over both (spine × body).
pub(crate) fn profiles(body: &[Pascal], spine: &[Pascal], chi_square: &[f64]) -> Vec<Profile> {
    let lowest = chi_square.iter().copied().fold(f64::INFINITY, f64::min);
    let least = |cells: &mut dyn Iterator<Item = usize>| {
        cells.map(|cell| chi_square[cell]).fold(f64::INFINITY, f64::min) - lowest
    };
    let columns = body.len();
    let over_body = (0..columns).map(|c| least(&mut (0..spine.len()).map(|r| r * columns + c)));
    let over_spine = (0..spine.len()).map(|r| least(&mut (0..columns).map(|c| r * columns + c)));
    vec![
        Profile { parameter: "body_e".into(), value: body.to_vec(), chi_square: over_body.collect() },
        Profile { parameter: "spine_e".into(), value: spine.to_vec(), chi_square: over_spine.collect() },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_takes_the_best_of_the_other_parameter() {
        let both = profiles(&[1.0, 2.0, 3.0], &[10.0, 20.0], &[5.0, 3.0, 4.0, 2.0, 9.0, 6.0]);
        assert_eq!(both[0].chi_square, [0.0, 1.0, 2.0]);
        assert_eq!(both[1].chi_square, [1.0, 0.0]);
    }

    #[test]
    fn an_uncertain_modulus_gives_advice_and_a_certain_one_does_not() {
        assert!(more_data(&[0.01, 0.3])[0].starts_with("E of spine has an uncertainty"));
        assert!(more_data(&[0.01, 0.05]).is_empty());
    }
}
