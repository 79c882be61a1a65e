//! Parameters of a joint fit: how each is searched, and what is known of it beforehand.

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub name: String,
    pub unit: &'static str,
    /// Start and range, in the unit of the search.
    pub start: f64,
    pub range: [f64; 2],
    /// Whether the search runs in its logarithm.
    pub logarithmic: bool,
    /// Mean and standard deviation beforehand, in the unit of the search.
    pub prior: Option<[f64; 2]>,
}

impl Parameter {
    /// Searched by its logarithm.
    pub(super) fn logarithmic(name: &str, unit: &'static str, start: f64, range: [f64; 2]) -> Self {
        let (start, range) = (start.ln(), range.map(f64::ln));
        Self { name: name.to_owned(), unit, start, range, logarithmic: true, prior: None }
    }

    /// Searched as it is.
    pub fn linear(name: &str, unit: &'static str, start: f64, range: [f64; 2]) -> Self {
        Self { name: name.to_owned(), unit, start, range, logarithmic: false, prior: None }
    }

    /// With a prior about its start, of the standard deviation `sigma` in the unit of the search.
    pub(super) fn known_to(self, sigma: f64) -> Self {
        Self { prior: Some([self.start, sigma]), ..self }
    }

    /// Mean and standard deviation beforehand: where nothing is known, as wide as its range, so that a direction that no test determines stays
    /// finite.
    pub(super) fn knowledge(&self) -> [f64; 2] {
        let width = self.range[1] - self.range[0];
        // beside the start, where its gradient would be zero, which the search takes for a mistake
        self.prior.unwrap_or([self.start + 1e-6 * width, width])
    }

    /// In its own unit, at a place of the search.
    pub fn value(&self, place: f64) -> f64 {
        if self.logarithmic { place.exp() } else { place }
    }

    /// Its standard deviation in its own unit, from that of the search.
    pub fn deviation(&self, place: f64, sigma: f64) -> f64 {
        if self.logarithmic { self.value(place) * sigma } else { sigma }
    }

    /// Whether a place of the search lies on an end of the range.
    pub(super) fn is_on_bound(&self, place: f64) -> bool {
        let [low, high] = self.range;
        (place - low).min(high - place) < 1e-4 * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_parameter_has_its_value_and_deviation_in_its_unit() {
        let modulus = Parameter::logarithmic("modulus", "Pa", 2e5, [1e5, 4e5]).known_to(0.1);
        assert!((modulus.value(modulus.start) / 2e5 - 1.0).abs() < 1e-12);
        assert!((modulus.deviation(modulus.start, 0.1) / 2e4 - 1.0).abs() < 1e-12);
        assert_eq!(modulus.prior, Some([2e5_f64.ln(), 0.1]));
        assert!(modulus.is_on_bound(1e5_f64.ln()) && !modulus.is_on_bound(1.1e5_f64.ln()));
        let exponent = Parameter::linear("exponent", "", 0.3, [0.0, 1.0]);
        assert_eq!((exponent.value(0.4), exponent.deviation(0.4, 0.1)), (0.4, 0.1));
    }
}
