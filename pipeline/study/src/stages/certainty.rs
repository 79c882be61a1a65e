//! Certainty: how sure identified moduli are, in numbers and in words, and what would make them surer.
//!
//! Stands on: fit's posterior. Never knows: how a displacement was simulated.

use fit::posterior::UNCERTAIN;
use fit::{Bounds, Evaluation, Search};
use lab::card::Card;
use si::Pascal;

use super::fitting::NAMES;
use crate::fault::{Fault, Outcome};
use crate::records::{Certainty, Profile};

/// The certainty of the moduli at the best point of a search over their logarithms.
///
/// # Errors
/// A [`Fault`] when the best point has no residuals, or they do not determine the moduli.
pub fn of(card: &Card, best: &Evaluation, search: &Search) -> Outcome<Certainty> {
    let Some(residuals) = &best.residuals else {
        return Err(Fault::from_tool("the best point of the search came without its residuals"));
    };
    let posterior = residuals.posterior(2).map_err(Fault::from_tool)?;
    let sigma = vec![posterior.sigma(0), posterior.sigma(1)];
    let mut advice = more_data(&sigma);
    advice.extend(implausible(card, &best.at, search.bounds()));
    Ok(Certainty {
        sigma,
        correlation: posterior.correlation(0, 1),
        chi_square: residuals.reduced_chi_square(2),
        words: posterior.in_words(&NAMES),
        advice,
    })
}

/// What to film where a modulus stays uncertain: a word for each.
fn more_data(sigma: &[f64]) -> Vec<String> {
    let loose = NAMES.iter().zip(sigma).filter(|(_, s)| **s > UNCERTAIN);
    let said =
        "is known to a tenth at best: film more markers between clamp and fin, or hold more pressures on both sides";
    loose.map(|(name, _)| format!("E of {name} {said}")).collect()
}

/// Part of the way across the plausible range that counts as its end.
const END: f64 = 0.02;

/// A word for each modulus that the search would have taken beyond its box: what the card calls plausible, and bears the films.
fn implausible(card: &Card, at: &[f64], bounds: &Bounds) -> Vec<String> {
    let solids = [&card.solid.body, &card.solid.spine];
    let ends = |k: usize| {
        let part = (at[k] - bounds.low[k]) / (bounds.high[k] - bounds.low[k]);
        !(END..=1.0 - END).contains(&part)
    };
    let word = |k: usize| {
        let [low, high] = [bounds.low[k], bounds.high[k]].map(|at| 1e-6 * solids[k].youngs_modulus * at.exp());
        format!("E of {} stopped at the end of what was searched, {low:.3} to {high:.3} MPa", NAMES[k])
    };
    (0..2).filter(|&k| ends(k)).map(word).collect()
}

/// χ² over each modulus with the other at its best, from χ² over both (spine × body).
pub fn profiles(body: &[Pascal], spine: &[Pascal], chi_square: &[f64]) -> Vec<Profile> {
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
    fn a_loose_modulus_asks_for_more_markers_and_a_tight_one_does_not() {
        assert!(more_data(&[0.01, 0.3])[0].starts_with("E of spine is known"));
        assert!(more_data(&[0.01, 0.05]).is_empty());
    }
}
