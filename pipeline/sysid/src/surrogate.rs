//! Surrogate of equilibria: the initial guess of an equilibrium, kriged from earlier ones.
//!
//! Without gravity the shape of a body follows from which chamber is filled, from its pressure over the modulus of the softest
//! material, from the other moduli over that one, from the Poisson's ratios and from the stiffening. Shapes anywhere in that reduced space
//! predict others by ordinary kriging with a wide Gaussian, close to polynomial interpolation [krige1951].

use nalgebra::{DMatrix, DVector};
use si::Pascal;

use crate::model::{BODY, Elastic};

/// Correlation length: the width of the Gaussian, in units of [`Load::away`].
const WIDTH: f64 = 2.0;
/// Nugget, relative to the variance: it keeps weights small where shapes lie close together.
const NOISE: f64 = 1e-9;
/// Number of nearest shapes in a prediction.
const NEAREST: usize = 20;
/// Number of shapes kept, the newest.
const KEPT: usize = 400;
/// Largest sum of absolute weights: above it the prediction extrapolates, and the nearest shape is the better initial guess.
const STRETCHED: f64 = 6.0;
/// Scales of the Poisson's ratios of the softest material, which is nearly incompressible, and of others, relative to the logarithm
/// of a modulus.
const BY_RATIO: [f64; 2] = [10.0, 1.0];

/// The load of an equilibrium: the filled chamber, and coordinates in the space of dimensionless constants.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    chamber: usize,
    /// The pressure first.
    at: Vec<f64>,
}

impl Load {
    /// Of a body with these constants whose `chamber` is filled with `pressure`; `unit` is the pressure over a modulus that counts as one.
    pub fn new(chamber: usize, pressure: Pascal, elastic: &Elastic, unit: f64) -> Self {
        let (e, nu) = (&elastic.youngs_moduli, &elastic.poissons_ratios);
        let moduli = e[1..].iter().map(|other| (other / e[BODY]).ln());
        let ratios = nu.iter().enumerate().map(|(region, nu)| BY_RATIO[region.min(1)] * nu);
        let constants = moduli.chain(ratios).chain(elastic.stiffening);
        Self { chamber, at: std::iter::once(pressure / e[BODY] / unit).chain(constants).collect() }
    }

    /// The same body at rest.
    pub fn without(mut self) -> Self {
        self.at[0] = 0.0;
        self
    }

    /// The load at `part` (0 to 1) of the way to `other`, whose chamber it has.
    pub fn towards(&self, other: &Self, part: f64) -> Self {
        let at = self.at.iter().zip(&other.at).map(|(from, to)| from + part * (to - from)).collect();
        Self { chamber: other.chamber, at }
    }

    /// The pressure and the constants of a body with this load whose softest material has the modulus `body`.
    pub fn constants(&self, body: Pascal, unit: f64) -> (Pascal, Elastic) {
        let solids = self.at.len() / 2 - 1;
        let (moduli, rest) = self.at[1..].split_at(solids - 1);
        let (ratios, stiffening) = rest.split_at(solids);
        let ratio = |(region, nu): (usize, &f64)| nu / BY_RATIO[region.min(1)];
        let elastic = Elastic {
            youngs_moduli: std::iter::once(body).chain(moduli.iter().map(|other| body * other.exp())).collect(),
            poissons_ratios: ratios.iter().enumerate().map(ratio).collect(),
            stiffening: [stiffening[0], stiffening[1]],
        };
        (self.at[0] * body * unit, elastic)
    }

    fn away(&self, other: &Self) -> f64 {
        self.at.iter().zip(&other.at).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}

/// A load and the shape under it, m, 3 a node.
pub(crate) type KnownShape = (Load, Vec<f64>);

/// Shapes and their loads.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surrogate {
    shapes: Vec<KnownShape>,
}

impl Surrogate {
    /// Adds a shape.
    pub fn add(&mut self, load: Load, shape: Vec<f64>) {
        if self.shapes.len() == KEPT {
            self.shapes.remove(0);
        }
        self.shapes.push((load, shape));
    }

    /// Whether it has no shape.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// The nearest shape of this and of `others` with its load, and the one predicted from all of them; none where neither has one of
    /// the same chamber.
    pub fn predict<'a>(&'a self, others: &'a Self, load: &Load) -> Option<(&'a KnownShape, Vec<f64>)> {
        let alike = self.shapes.iter().chain(&others.shapes).filter(|(known, _)| known.chamber == load.chamber);
        let mut near: Vec<(f64, &KnownShape)> = alike.map(|shape| (shape.0.away(load), shape)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(NEAREST);
        let &(_, nearest) = near.first()?;
        let places: Vec<Load> =
            near.iter().map(|(_, (known, _))| known.clone()).chain([load.clone().without()]).collect();
        let Some(weights) = weights(&places, load) else { return Some((nearest, nearest.1.clone())) };
        let mut predicted = vec![0.0; nearest.1.len()];
        for ((_, (_, shape)), weight) in near.iter().zip(weights.iter()) {
            predicted.iter_mut().zip(shape).for_each(|(sum, u)| *sum += weight * u);
        }
        Some((nearest, predicted))
    }
}

/// Kriging weights of the shapes at `places` for `load`; they sum to one. None where they would extrapolate.
fn weights(places: &[Load], load: &Load) -> Option<DVector<f64>> {
    let n = places.len();
    let alike = |a: &Load, b: &Load| (-0.5 * (a.away(b) / WIDTH).powi(2)).exp();
    let among = DMatrix::from_fn(n, n, |i, j| alike(&places[i], &places[j]) + if i == j { NOISE } else { 0.0 });
    let factor = among.cholesky()?;
    let (towards, level) =
        (factor.solve(&DVector::from_fn(n, |i, _| alike(&places[i], load))), factor.solve(&DVector::repeat(n, 1.0)));
    let weights = &towards + &level * ((1.0 - towards.sum()) / level.sum());
    (weights.iter().map(|w| w.abs()).sum::<f64>() < STRETCHED).then_some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(pressure: f64, body: f64, spine: f64) -> Load {
        let poissons_ratios = vec![0.49, 0.38];
        let elastic = Elastic { youngs_moduli: vec![body, spine], poissons_ratios, stiffening: [0.0; 2] };
        Load::new(0, pressure, &elastic, 0.1)
    }

    /// A smooth function of the load, zero at rest.
    fn shape(of: &Load) -> Vec<f64> {
        let (s, r) = (of.at[0], of.at[1]);
        vec![s + 0.3 * s * s - 0.2 * s * r, (0.4 * s).sin()]
    }

    #[test]
    fn the_constants_of_a_load_are_those_that_it_was_made_of() {
        let elastic = Elastic {
            youngs_moduli: vec![2e5, 3e9, 4e6],
            poissons_ratios: vec![0.49, 0.38, 0.41],
            stiffening: [0.1, 0.03],
        };
        let (pressure, made) = Load::new(1, 7e3, &elastic, 0.1).constants(2e5, 0.1);
        assert!((pressure - 7e3).abs() < 1e-8 && made.stiffening == elastic.stiffening);
        let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-12);
        assert!(close(&made.youngs_moduli, &elastic.youngs_moduli));
        assert!(close(&made.poissons_ratios, &elastic.poissons_ratios));
    }

    #[test]
    fn shapes_on_a_grid_predict_those_between() {
        let mut known = Surrogate::default();
        for (body, spine) in [(1e5, 2e9), (1.5e5, 2e9), (1e5, 3e9), (1.5e5, 3e9)] {
            for pressure in [4e3, 8e3, 1.2e4, 1.6e4] {
                let at = load(pressure, body, spine);
                let shape = shape(&at);
                known.add(at, shape);
            }
        }
        let at = load(1.1e4, 1.2e5, 2.4e9);
        let predicted = known.predict(&Surrogate::default(), &at).expect("shapes are known").1;
        predicted.iter().zip(shape(&at)).for_each(|(a, b)| assert!((a - b).abs() < 1e-3, "{a} for {b}"));
    }

    #[test]
    fn one_shape_predicts_about_twice_the_displacement_for_twice_the_load() {
        let mut known = Surrogate::default();
        known.add(load(4e3, 1e5, 2e9), vec![1.0]);
        let predicted = known.predict(&Surrogate::default(), &load(8e3, 1e5, 2e9)).expect("a shape is known").1[0];
        assert!((1.5..2.1).contains(&predicted), "{predicted}");
    }

    #[test]
    fn weights_add_up_to_one_far_from_all_that_is_known() {
        let places = [2e7, 2e9, 2e11].map(|spine| load(8e3, 1e5, spine));
        let sum = weights(&places, &load(8e3, 1e5, 2e15)).expect("the weights are small").sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn a_shape_of_another_chamber_is_not_used() {
        let mut known = Surrogate::default();
        known.add(Load { chamber: 1, ..load(4e3, 1e5, 2e9) }, vec![1.0]);
        assert_eq!(known.predict(&Surrogate::default(), &load(4e3, 1e5, 2e9)), None);
    }

    #[test]
    fn shapes_found_twice_do_not_break_it() {
        let (mut mine, mut others) = (Surrogate::default(), Surrogate::default());
        for _ in 0..3 {
            mine.add(load(4e3, 1e5, 2e9), vec![1.0]);
            others.add(load(4e3, 1e5, 2e9), vec![1.0]);
        }
        let predicted = mine.predict(&others, &load(4e3, 1e5, 2e9)).expect("a shape is known").1[0];
        assert!((predicted - 1.0).abs() < 1e-6, "{predicted}");
    }
}
