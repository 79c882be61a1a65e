//! What a joint fit asks of a test: its conditions with what was measured, its own parameters, and predictions with their derivatives.

use std::sync::Arc;

use super::laws::Law;
use super::parameters::Parameter;
use crate::inflation_test::inflated::Shape;
use diagnostics::Result;

/// A number that is compared.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quantity {
    pub name: String,
    pub unit: &'static str,
    /// None of a condition that was not recorded.
    pub measured: Option<f64>,
    /// Standard deviation by which a good model misses it, over its value.
    pub sigma: f64,
}

/// A weight, a pressure or a strain under which a body was recorded.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condition {
    pub name: String,
    /// By which conditions of a test are ordered: beyond those that were fitted, a prediction extrapolates.
    pub level: f64,
    /// Whether it may be fitted.
    pub fitted: bool,
    pub quantities: Vec<Quantity>,
}

/// A predicted number, with its derivatives by the shared parameters and then by the test's own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Predicted {
    pub value: f64,
    pub gradient: Vec<f64>,
}

/// Equilibria that a fit has found, from which it begins the next ones.
pub(super) type Memory = Vec<Arc<Shape>>;

/// A law with the shared parameters and those of a test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub law: &'a Law,
    pub shared: &'a [f64],
    pub own: &'a [f64],
}

/// A test of a material.
pub(super) trait Test: Send + Sync {
    /// Its name, in front of its parameters.
    fn name(&self) -> &str;

    /// Its own parameters.
    fn parameters(&self) -> Vec<Parameter>;

    /// Its conditions.
    fn conditions(&self) -> &[Condition];

    /// Every quantity of a condition.
    ///
    /// # Errors
    /// A diagnostic where no shape or motion is found.
    fn predict_condition(&self, at: &Place, condition: usize, memory: &mut Memory) -> Result<Vec<Predicted>>;
}
