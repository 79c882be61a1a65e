//! Surrogate of equilibria: the initial guess of an equilibrium, kriged from earlier ones.
//!
//! Without gravity the shape of a body follows from which chamber is filled, from its pressure over the modulus of the softest
//! material, from the other moduli over that one, from the Poisson's ratios and from the stiffening. Shapes anywhere in that reduced space
//! predict others by kriging; those with known derivatives by these constants, by their expansions. Kriging with derivatives [morris1993] was
//! tried: where a wall buckles, shapes change within a tenth of its correlation length, and its smoothing was off by millimetres.

mod kriging;
mod load;

use kriging::weights;
pub use load::{Extra, Load, Slope};

/// Number of nearest shapes in a prediction by kriging.
const NEAREST: usize = 20;
/// Number of nearest expansions in a prediction by them.
const EXPANSIONS: usize = 4;
/// Constants so near to each other are the same on a path of rising pressure: 2 % of the ratio of moduli.
const SAME_CONSTANTS: f64 = 0.02;
/// Pressures so near to each other are the same, relative to that at the end of the path.
const SAME_PRESSURE: f64 = 1e-3;
/// A shape so much nearer than the nearest with derivatives predicts better by kriging.
const NEARER: f64 = 0.25;
/// Number of shapes kept, the newest; of these, so many with their derivatives, each of which is as large as a shape.
const KEPT: usize = 400;
const KEPT_SLOPES: usize = 80;

/// A load and the shape under it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KnownShape {
    /// The load.
    pub load: Load,
    /// The shape, in the unknowns of what found it.
    pub shape: Vec<f64>,
    /// Its derivatives; none where they are not known.
    pub slopes: Vec<Slope>,
}

impl KnownShape {
    /// Without derivatives.
    pub fn new(load: Load, shape: Vec<f64>) -> Self {
        Self { load, shape, slopes: Vec::new() }
    }

    /// The body of `load` with so many unknowns at rest.
    pub fn at_rest(load: &Load, unknowns: usize) -> Self {
        Self::new(load.clone().without(), vec![0.0; unknowns])
    }
}

/// Shapes and their loads.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surrogate {
    shapes: Vec<KnownShape>,
}

impl Surrogate {
    /// Adds a shape.
    pub fn add(&mut self, known: KnownShape) {
        if self.shapes.len() == KEPT {
            self.shapes.remove(0);
        }
        if let Some(old) = self.shapes.len().checked_sub(KEPT_SLOPES) {
            self.shapes[old].slopes.clear();
        }
        self.shapes.push(known);
    }

    /// All shapes, the newest first, without those whose loads differ by less than `apart` from that of a newer one.
    pub(crate) fn newest_apart(&self, apart: f64) -> Vec<&KnownShape> {
        let mut distinct: Vec<&KnownShape> = Vec::new();
        for known in self.shapes.iter().rev() {
            let is_alike = |other: &&KnownShape| {
                other.load.chamber == known.load.chamber && other.load.distance_to(&known.load) < apart
            };
            if !distinct.iter().any(is_alike) {
                distinct.push(known);
            }
        }
        distinct
    }

    /// Whether it has no shape.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// The known shapes below the pressure of `load`, of the same chamber and of nearly the same constants, by rising pressure; of those so
    /// near to each other that they are one equilibrium, the first.
    pub(crate) fn below(&self, load: &Load) -> Vec<&KnownShape> {
        let on_the_way = |known: &&KnownShape| {
            let known_load = &known.load;
            known_load.chamber == load.chamber
                && known_load.part_of(load) < 1.0
                && known_load.constants_distance(load) < SAME_CONSTANTS
        };
        let mut below: Vec<&KnownShape> = self.shapes.iter().filter(on_the_way).collect();
        below.sort_by(|a, b| a.load.at[0].total_cmp(&b.load.at[0]));
        below.dedup_by(|next, kept| next.load.part_of(load) - kept.load.part_of(load) < SAME_PRESSURE);
        below
    }

    /// The nearest known shape, and the one predicted from all of them; none where there is none of the same chamber.
    pub fn predict<'a>(surrogates: &[&'a Self], load: &Load) -> Option<(&'a KnownShape, Vec<f64>)> {
        let alike = surrogates
            .iter()
            .flat_map(|surrogate| &surrogate.shapes)
            .filter(|known| known.load.chamber == load.chamber);
        let mut neighbours: Vec<(f64, &KnownShape)> =
            alike.map(|known| (known.load.distance_to(load), known)).collect();
        neighbours.sort_by(|a, b| a.0.total_cmp(&b.0));
        let &(closest, nearest) = neighbours.first()?;
        let with_slopes = neighbours.iter().filter(|(_, known)| !known.slopes.is_empty());
        let mut expanded: Vec<(f64, &KnownShape)> =
            with_slopes.map(|(_, known)| (known.load.expansion_distance(load), *known)).collect();
        expanded.sort_by(|a, b| a.0.total_cmp(&b.0));
        expanded.truncate(EXPANSIONS);
        match expanded.first() {
            Some((_, first)) if closest >= NEARER * first.load.distance_to(load) => {
                Some((first, mean_expansion(&expanded, load)))
            }
            _ => Some((nearest, kriged_shape(&neighbours, load).unwrap_or_else(|| nearest.shape.clone()))),
        }
    }
}

/// The mean of the first-order expansions about shapes with derivatives, by the inverse fourth power of their distance: Shepard's method with
/// gradients [shepard1968].
fn mean_expansion(about: &[(f64, &KnownShape)], load: &Load) -> Vec<f64> {
    // An expansion of first order errs by the square of the distance: inverse variances.
    let weight = |distance: f64| distance.max(TINY).powi(-4);
    let total_weight: f64 = about.iter().map(|(distance, _)| weight(*distance)).sum();
    let mut sum = vec![0.0; about[0].1.shape.len()];
    for (distance, known) in about {
        let weight = weight(*distance);
        let mut add = |part: f64, field: &[f64]| sum.iter_mut().zip(field).for_each(|(sum, u)| *sum += part * u);
        add(weight / total_weight, &known.shape);
        known
            .slopes
            .iter()
            .for_each(|s| add(weight / total_weight * load.coordinate_difference(&known.load, s.coordinate), &s.slope));
    }
    sum
}

/// By kriging from the nearest values; none where it would extrapolate.
fn kriged_shape(neighbours: &[(f64, &KnownShape)], load: &Load) -> Option<Vec<f64>> {
    let neighbours = &neighbours[..neighbours.len().min(NEAREST)];
    let places: Vec<Load> =
        // Every body is known at rest, where its displacement is zero: the shape adds nothing, but takes its weight
        // from the others.
        neighbours.iter().map(|(_, known)| known.load.clone()).chain([load.clone().without()]).collect();
    let weights = weights(&places, load)?;
    let mut predicted = vec![0.0; neighbours[0].1.shape.len()];
    for ((_, known), weight) in neighbours.iter().zip(weights.iter()) {
        predicted.iter_mut().zip(&known.shape).for_each(|(sum, u)| *sum += weight * u);
    }
    Some(predicted)
}

/// Distance at which two loads are the same.
const TINY: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Elastic;

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
    fn a_path_begins_at_the_highest_known_pressure_below_its_end_with_the_same_constants() {
        let mut surrogate = Surrogate::default();
        for (pressure, body, spine) in [(4e3, 1e5, 2e9), (8e3, 1e5, 2e9), (1.1e4, 1e5, 2.2e9), (1.6e4, 1e5, 2e9)] {
            let sample = load(pressure, body, spine);
            surrogate.add(KnownShape::new(sample.clone(), shape(&sample)));
        }
        let begin = |to: Load| surrogate.below(&to).last().map(|found| found.load.part_of(&to));
        let is_near = |part: Option<f64>, wanted: f64| part.is_some_and(|part| (part - wanted).abs() < 1e-12);
        assert!(is_near(begin(load(1.2e4, 1e5, 2e9)), 8.0 / 12.0));
        // the same body, softer: all its pressures count for more
        assert!(is_near(begin(load(7e3, 0.5e5, 1e9)), 8.0 / 14.0));
        assert_eq!(begin(load(1.2e4, 1e5, 4e9)), None);
        assert_eq!(begin(load(3e3, 1e5, 2e9)), None);
        // each equilibrium once, by rising pressure
        surrogate.add(KnownShape::new(load(4e3 + 1.0, 1e5, 2e9), vec![0.0; 2]));
        let below: Vec<f64> = surrogate.below(&load(1.2e4, 1e5, 2e9)).iter().map(|found| found.load.at[0]).collect();
        assert_eq!(below, [4e3, 8e3].map(|pressure| load(pressure, 1e5, 2e9).at[0]));
    }

    #[test]
    fn shapes_on_a_grid_predict_those_between() {
        let mut surrogate = Surrogate::default();
        for (body, spine) in [(1e5, 2e9), (1.5e5, 2e9), (1e5, 3e9), (1.5e5, 3e9)] {
            for pressure in [4e3, 8e3, 1.2e4, 1.6e4] {
                let sample = load(pressure, body, spine);
                let shape = shape(&sample);
                surrogate.add(KnownShape::new(sample, shape));
            }
        }
        let query = load(1.1e4, 1.2e5, 2.4e9);
        let predicted = Surrogate::predict(&[&surrogate], &query).expect("shapes are known").1;
        predicted.iter().zip(shape(&query)).for_each(|(a, b)| assert!((a - b).abs() < 1e-3, "{a} for {b}"));
    }

    /// ∂shape/∂E of both solids and ∂shape/∂ratio of stiffening, by differences.
    fn by_constants(pressure: f64, body: f64, spine: f64) -> Vec<Vec<f64>> {
        let shape_at = |body: f64, spine: f64| shape(&load(pressure, body, spine));
        let slope = |high: Vec<f64>, low: Vec<f64>, by: f64| high.iter().zip(low).map(|(a, b)| (a - b) / by).collect();
        let (h, k) = (1e-4 * body, 1e-4 * spine);
        vec![
            slope(shape_at(body + h, spine), shape_at(body - h, spine), 2.0 * h),
            slope(shape_at(body, spine + k), shape_at(body, spine - k), 2.0 * k),
        ]
    }

    #[test]
    fn two_shapes_with_their_derivatives_predict_better_than_without() {
        let largest_error = |with: bool| {
            let mut surrogate = Surrogate::default();
            for (pressure, body, spine) in [(8e3, 1e5, 2e9), (1.2e4, 1.3e5, 3e9)] {
                let sample = load(pressure, body, spine);
                let slopes = sample.slopes(&[body, spine], by_constants(pressure, body, spine), Extra::Stiffening);
                let slopes = if with { slopes } else { Vec::new() };
                surrogate.add(KnownShape { shape: shape(&sample), load: sample, slopes });
            }
            let query = load(9e3, 1.1e5, 2.6e9);
            let predicted = Surrogate::predict(&[&surrogate], &query).expect("shapes are known").1;
            predicted.iter().zip(shape(&query)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(
            largest_error(true) < 0.05 * largest_error(false) && largest_error(true) < 2e-3,
            "{} {}",
            largest_error(true),
            largest_error(false)
        );
    }

    #[test]
    fn slopes_are_derivatives_by_the_coordinates_of_the_load() {
        let query = load(9e3, 1.1e5, 2.6e9);
        let slopes = query.slopes(&[1.1e5, 2.6e9], by_constants(9e3, 1.1e5, 2.6e9), Extra::Stiffening);
        assert_eq!(slopes.iter().map(|s| s.coordinate).collect::<Vec<_>>(), [0, 1]);
        for Slope { coordinate, slope } in slopes {
            let perturbed = |by: f64| {
                let mut shifted = query.clone();
                shifted.at[coordinate] += by;
                shape(&shifted)
            };
            let (high, low) = (perturbed(1e-4), perturbed(-1e-4));
            for (k, found) in slope.iter().enumerate() {
                let difference = (high[k] - low[k]) / 2e-4;
                assert!(
                    (found - difference).abs() < 1e-4 * difference.abs().max(0.1),
                    "{coordinate}: {found} for {difference}"
                );
            }
        }
    }

    #[test]
    fn one_shape_predicts_about_twice_the_displacement_for_twice_the_load() {
        let mut surrogate = Surrogate::default();
        surrogate.add(KnownShape::new(load(4e3, 1e5, 2e9), vec![1.0]));
        let predicted = Surrogate::predict(&[&surrogate], &load(8e3, 1e5, 2e9)).expect("a shape is known").1[0];
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
        let mut surrogate = Surrogate::default();
        surrogate.add(KnownShape::new(Load { chamber: 1, ..load(4e3, 1e5, 2e9) }, vec![1.0]));
        assert_eq!(Surrogate::predict(&[&surrogate], &load(4e3, 1e5, 2e9)), None);
    }

    #[test]
    fn shapes_found_twice_do_not_break_it() {
        let (mut mine, mut others) = (Surrogate::default(), Surrogate::default());
        for _ in 0..3 {
            mine.add(KnownShape::new(load(4e3, 1e5, 2e9), vec![1.0]));
            others.add(KnownShape::new(load(4e3, 1e5, 2e9), vec![1.0]));
        }
        let predicted = Surrogate::predict(&[&mine, &others], &load(4e3, 1e5, 2e9)).expect("a shape is known").1[0];
        assert!((predicted - 1.0).abs() < 1e-6, "{predicted}");
    }
}
