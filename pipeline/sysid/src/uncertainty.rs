//! Uncertainty of identified moduli: covariance, a sentence, and advice on which data would reduce it.

use optimize::posterior::UNCERTAIN;
use optimize::{Bounds, Covariance};
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal};

use crate::body::Body;
use crate::discretisation::MeshError;

/// The covariance of all parameters of an identification, the logarithms of the moduli first.
pub struct Posterior {
    /// The covariance of what the films leave open.
    pub covariance: Covariance,
    /// The discretisation error, or why it is not known.
    pub discretisation: std::result::Result<MeshError, String>,
    /// χ² over the degrees of freedom.
    pub chi_square: f64,
}

/// Uncertainty of the parameters.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Uncertainty {
    /// Standard deviations of the logarithms of the parameters; the discretisation error is in them where it is known.
    pub sigma: Vec<f64>,
    /// Their correlations: parameters × parameters.
    pub correlation: Vec<f64>,
    /// Reduced χ² (over the degrees of freedom): near 1 when the covariance is right.
    pub chi_square: f64,
    /// By how much the discretisation error shifts the logarithm of each parameter, estimated on a finer mesh; empty where it is not known.
    pub discretisation: Vec<f64>,
    /// Largest difference of a marker's displacement from that on the finer mesh, m; none where it is not known.
    pub mesh_error: Option<Metre>,
    /// A sentence on which parameters are determined.
    pub words: String,
    /// Which data would reduce the uncertainty, and which estimates reached the end of the plausible range.
    pub advice: Vec<String>,
}

impl Uncertainty {
    /// Of the first two parameters; none of a single one.
    pub fn first_correlation(&self) -> Option<f64> {
        (self.sigma.len() > 1).then(|| self.correlation[1])
    }

    /// The factor from a parameter that makes up for the error of its mesh to that of the material; 1 where the error is not known.
    // The deviation of this correction is the correction itself: what a third mesh would add, four fifths of it at second order and half as
    // many cells again in each direction.
    pub fn mesh_correction(&self, parameter: usize) -> f64 {
        (-self.discretisation.get(parameter).copied().unwrap_or_default()).exp()
    }

    /// Covariance of two parameters without the discretisation error: of what is predicted on the same mesh, which has that error as well and
    /// for which the parameters make up.
    pub fn on_the_same_mesh(&self, i: usize, j: usize) -> f64 {
        let correlation = if i == j { 1.0 } else { self.correlation[i * self.sigma.len() + j] };
        let shift = |k: usize| self.discretisation.get(k).copied().unwrap_or_default();
        self.sigma[i] * self.sigma[j] * correlation - shift(i) * shift(j)
    }
}

/// Profile likelihood: χ² over one parameter, minimised over the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// The solid's name and `_e`.
    pub parameter: String,
    /// Pa.
    pub value: Vec<f64>,
    /// χ² above its minimum.
    pub chi_square: Vec<f64>,
}

/// The uncertainty of the moduli at the best point of a search over their logarithms, and the bounds of that search.
pub fn of(body: &Body, posterior: &Posterior, (best, bounds): (&[f64], &Bounds)) -> Uncertainty {
    let names: Vec<&str> = body.materials.iter().map(|m| m.name.as_str()).collect();
    let count = names.len();
    let films = posterior.covariance.marginal(count);
    let discretisation =
        posterior.discretisation.as_ref().map(|error| error.shift[..count].to_vec()).unwrap_or_default();
    let moduli = if discretisation.is_empty() { films } else { films.with_error(&discretisation) };
    let sigma: Vec<f64> = (0..count).map(|k| moduli.sigma(k)).collect();
    let mut advice = more_data(&names, &sigma);
    advice.extend(bound_notes(body, best, bounds));
    advice.extend(
        posterior.discretisation.as_ref().err().map(|reason| format!("the error of the mesh is not known: {reason}")),
    );
    Uncertainty {
        sigma,
        correlation: (0..count * count).map(|k| moduli.correlation(k / count, k % count)).collect(),
        chi_square: posterior.chi_square,
        words: moduli.summary(&names),
        discretisation,
        mesh_error: posterior.discretisation.as_ref().ok().map(|error| error.largest),
        advice,
    }
}

/// Advice on further recordings for each uncertain modulus.
fn more_data(names: &[&str], sigma: &[f64]) -> Vec<String> {
    let loose = names.iter().zip(sigma).filter(|(_, s)| **s > UNCERTAIN);
    let text = "has an uncertainty of a tenth or more: film more markers between clamp and tip, or hold more pressures in every channel";
    loose.map(|(name, _)| format!("E of {name} {text}")).collect()
}

/// Fraction of the plausible range that counts as its end.
const END: f64 = 0.02;

/// A note for each modulus at a bound of the search: the card's plausible range, or the feasible lower bound.
fn bound_notes(body: &Body, estimate: &[f64], bounds: &Bounds) -> Vec<String> {
    let ends = |k: usize| {
        let part = (estimate[k] - bounds.low[k]) / (bounds.high[k] - bounds.low[k]);
        !(END..=1.0 - END).contains(&part)
    };
    let word = |k: usize| {
        let [low, high] =
            [bounds.low[k], bounds.high[k]].map(|log_ratio| 1e-6 * body.materials[k].youngs_modulus * log_ratio.exp());
        format!("E of {} reached a bound of the search, {low:.3} to {high:.3} MPa", body.materials[k].name)
    };
    (0..estimate.len()).filter(|&k| ends(k)).map(word).collect()
}

/// Profile likelihoods of two solids: χ² over each modulus, minimised over the other, from χ² over both (second × first).
pub fn profiles(solids: [&str; 2], [first, second]: [&[Pascal]; 2], chi_square: &[f64]) -> Vec<Profile> {
    let lowest = chi_square.iter().copied().fold(f64::INFINITY, f64::min);
    let minimum = |cells: &mut dyn Iterator<Item = usize>| {
        cells.map(|cell| chi_square[cell]).fold(f64::INFINITY, f64::min) - lowest
    };
    let columns = first.len();
    let over_first = (0..columns).map(|c| minimum(&mut (0..second.len()).map(|r| r * columns + c))).collect();
    let over_second = (0..second.len()).map(|r| minimum(&mut (0..columns).map(|c| r * columns + c))).collect();
    let profile = |solid: &str, value: &[Pascal], chi_square| Profile {
        parameter: format!("{solid}_e"),
        value: value.to_vec(),
        chi_square,
    };
    vec![profile(solids[0], first, over_first), profile(solids[1], second, over_second)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Material;

    #[test]
    fn a_profile_takes_the_best_of_the_other_parameter() {
        let both = profiles(["a", "b"], [&[1.0, 2.0, 3.0], &[10.0, 20.0]], &[5.0, 3.0, 4.0, 2.0, 9.0, 6.0]);
        assert_eq!(both[0].chi_square, [0.0, 1.0, 2.0]);
        assert_eq!(both[1].chi_square, [1.0, 0.0]);
    }

    #[test]
    fn on_the_same_mesh_its_error_does_not_count() {
        let all = Uncertainty {
            sigma: vec![0.05, 0.1],
            correlation: vec![1.0, -0.5, -0.5, 1.0],
            discretisation: vec![0.03, -0.06],
            ..Uncertainty::default()
        };
        assert!((all.on_the_same_mesh(0, 0) - 0.0016).abs() < 1e-12);
        assert!((all.on_the_same_mesh(0, 1) + 0.0025 - 0.0018).abs() < 1e-12);
        assert!((all.on_the_same_mesh(1, 0) + 0.0025 - 0.0018).abs() < 1e-12);
        let without = Uncertainty { discretisation: Vec::new(), ..all };
        assert!((without.on_the_same_mesh(1, 1) - 0.01).abs() < 1e-12);
    }

    #[test]
    fn the_material_of_a_mesh_that_is_too_stiff_has_a_higher_modulus_than_what_was_identified_on_it() {
        let all = Uncertainty { discretisation: vec![-0.02], ..Uncertainty::default() };
        assert!((all.mesh_correction(0).ln() - 0.02).abs() < 1e-12 && all.mesh_correction(1) == 1.0);
    }

    #[test]
    fn an_uncertain_modulus_gives_advice_and_a_certain_one_does_not() {
        assert!(more_data(&["body", "spine"], &[0.01, 0.3])[0].starts_with("E of spine has an uncertainty"));
        assert!(more_data(&["body", "spine"], &[0.01, 0.05]).is_empty());
    }

    /// A body and a spine of 0.2 and 1 MPa.
    fn two_solids() -> Body {
        let material = |name: &str, youngs_modulus| Material {
            name: name.to_owned(),
            law: "neo_hookean".to_owned(),
            youngs_modulus,
            poissons_ratio: 0.49,
            density: 1e3,
            stiffening: [0.0; 2],
            stiffening_sigma: None,
            plausible: [0.5 * youngs_modulus, 2.0 * youngs_modulus],
        };
        let materials = vec![material("body", 2e5), material("spine", 1e6)];
        Body {
            materials,
            clamp: lab::card::Clamp::below(0.0),
            length: 0.1,
            markers: Vec::new(),
            marker_diameters: Vec::new(),
        }
    }

    /// Three observations of ln E₁, ln E₂ and their sum: JᵀJ = [2 1; 1 2], whose inverse is [2 −1; −1 2] / 3.
    #[test]
    fn deviations_and_correlation_are_those_of_the_observations() {
        let values = vec![3.0_f64.sqrt().recip(); 3];
        let residuals = optimize::Residuals { values, jacobian: vec![1.0, 0.0, 0.0, 1.0, 1.0, 1.0] };
        let covariance = residuals.posterior(2).unwrap();
        let posterior = Posterior { covariance, discretisation: Err("one mesh".into()), chi_square: 1.0 };
        let bounds = Bounds { low: vec![-1.0; 2], high: vec![1.0; 2] };
        let found = of(&two_solids(), &posterior, (&[0.0, 0.0], &bounds));
        assert!(found.sigma.iter().all(|sigma| (sigma - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12), "{found:?}");
        let should = [1.0, -0.5, -0.5, 1.0];
        assert!(
            found.correlation.len() == 4 && found.correlation.iter().zip(should).all(|(a, b)| (a - b).abs() < 1e-12)
        );
        assert!((found.first_correlation().unwrap() + 0.5).abs() < 1e-12);
        assert_eq!(found.advice.len(), 3, "both are uncertain, and the error of the mesh is not known: {found:?}");
    }

    #[test]
    fn a_modulus_at_an_end_of_its_range_is_named_with_the_range_in_mpa() {
        let body = two_solids();
        let bounds = Bounds { low: vec![0.5_f64.ln(); 2], high: vec![2.0_f64.ln(); 2] };
        // a fiftieth of the range counts as its end
        assert!(bound_notes(&body, &[0.0, 0.95 * 2.0_f64.ln()], &bounds).is_empty());
        let said = bound_notes(&body, &[0.0, 0.97 * 2.0_f64.ln()], &bounds);
        assert_eq!(said, ["E of spine reached a bound of the search, 0.500 to 2.000 MPa"]);
        let said = bound_notes(&body, &[0.97 * 0.5_f64.ln(), 0.0], &bounds);
        assert_eq!(said, ["E of body reached a bound of the search, 0.100 to 0.400 MPa"]);
    }
}
