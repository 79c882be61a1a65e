//! The problem that an optimiser is built for: named parameters, an initial guess and bounds.
//!
//! Every point that an optimiser asks for lies within the bounds. A caller whose parameters span orders of magnitude passes their
//! logarithms, so that one unit means the same on each axis.

use crate::OptimiseError;

/// Box constraints, one interval a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// Lower bounds, one a parameter.
    pub low: Vec<f64>,
    /// Upper bounds, one a parameter.
    pub high: Vec<f64>,
}

impl Bounds {
    /// The nearest point of the box.
    pub fn clamp(&self, point: &[f64]) -> Vec<f64> {
        point.iter().zip(self.low.iter().zip(&self.high)).map(|(x, (l, h))| x.clamp(*l, *h)).collect()
    }

    /// Whether a point lies in the box, its faces included.
    pub fn contains_point(&self, point: &[f64]) -> bool {
        point.len() == self.low.len() && self.clamp(point) == point
    }
}

/// Named parameters with an initial guess and bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    names: Vec<String>,
    start: Vec<f64>,
    bounds: Bounds,
}

impl Problem {
    /// A problem in named parameters from a start within bounds (all of one length).
    ///
    /// # Errors
    /// [`OptimiseError`] when a length differs, a bound is not finite or not in order, or the start lies outside.
    pub fn new(names: &[&str], start: Vec<f64>, bounds: Bounds) -> Result<Self, OptimiseError> {
        let expected = names.len();
        if expected == 0 {
            return Err(OptimiseError::Length { what: "the list of parameters", found: 0, expected: 1 });
        }
        for (what, found) in [
            ("the start", start.len()),
            ("the lower bounds", bounds.low.len()),
            ("the upper bounds", bounds.high.len()),
        ] {
            if found != expected {
                return Err(OptimiseError::Length { what, found, expected });
            }
        }
        for (i, name) in names.iter().enumerate() {
            let (low, high, value, parameter) = (bounds.low[i], bounds.high[i], start[i], (*name).to_owned());
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(OptimiseError::Bounds { parameter, low, high });
            }
            if !(low..=high).contains(&value) {
                return Err(OptimiseError::Start { parameter, value, low, high });
            }
        }
        Ok(Self { names: names.iter().map(|&n| n.to_owned()).collect(), start, bounds })
    }

    /// The parameters' names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The initial guess.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// The bounds.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Number of parameters.
    pub fn dimension(&self) -> usize {
        self.names.len()
    }

    /// A point as text: `body = -1.25, spine = 0.41`.
    pub(crate) fn described_point(&self, point: &[f64]) -> String {
        let parts: Vec<String> = self.names.iter().zip(point).map(|(n, v)| format!("{n} = {v}")).collect();
        parts.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(low: f64, high: f64) -> Bounds {
        Bounds { low: vec![low; 2], high: vec![high; 2] }
    }

    #[test]
    fn a_start_outside_of_its_bounds_is_refused_by_name() {
        let error = Problem::new(&["body", "spine"], vec![0.0, 3.0], bounds(-1.0, 1.0)).unwrap_err();
        assert!(error.to_string().starts_with("the optimisation starts at `spine` = 3"), "{error}");
    }

    #[test]
    fn bounds_in_the_wrong_order_are_refused_by_name() {
        let error = Problem::new(&["body", "spine"], vec![0.0, 0.0], bounds(1.0, -1.0)).unwrap_err();
        assert!(matches!(error, OptimiseError::Bounds { ref parameter, .. } if parameter == "body"), "{error}");
    }

    #[test]
    fn a_start_of_another_length_is_refused() {
        let error = Problem::new(&["body", "spine"], vec![0.0], bounds(-1.0, 1.0)).unwrap_err();
        assert!(matches!(error, OptimiseError::Length { found: 1, expected: 2, .. }), "{error}");
    }

    #[test]
    fn a_clamped_point_lies_on_the_nearest_face() {
        let unit = bounds(-1.0, 1.0);
        assert_eq!(unit.clamp(&[-4.0, 0.5]), vec![-1.0, 0.5]);
        assert!(unit.contains_point(&[-1.0, 1.0]) && !unit.contains_point(&[0.0, 1.1]));
    }
}
