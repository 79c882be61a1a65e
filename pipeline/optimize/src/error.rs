//! The error of this crate: what is wrong with a problem or an evaluation, why, and what to do.

/// Why an optimisation cannot begin or continue.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OptimiseError {
    /// A list whose length is not the number of parameters (or of asked points).
    #[error(
        "{what} has {found} entries where {expected} are needed\n  why: it must match the parameters or points, entry by entry\n  do:  build it from the names, the start or the points that were asked for"
    )]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that fits.
        expected: usize,
    },
    /// A lower bound that is not below the upper one, or a bound that is not a number.
    #[error(
        "the bounds of `{parameter}` are {low} and {high}\n  why: the lower one must be below the upper one and both finite\n  do:  correct them where the problem is set up"
    )]
    Bounds {
        /// The parameter's name.
        parameter: String,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A start that lies outside of the bounds.
    #[error(
        "the optimisation starts at `{parameter}` = {value}\n  why: its bounds are {low} and {high}\n  do:  start between them, or widen them"
    )]
    Start {
        /// The parameter's name.
        parameter: String,
        /// The initial guess.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A setting without meaning.
    #[error(
        "the setting `{setting}` of {optimiser} is {value}\n  why: it must be {needed}\n  do:  correct it in the settings"
    )]
    Setting {
        /// The optimiser that has the setting.
        optimiser: &'static str,
        /// The setting's name.
        setting: &'static str,
        /// What was given.
        value: f64,
        /// What is possible.
        needed: &'static str,
    },
    /// A loss that is not a number.
    #[error(
        "the loss is {loss} at {at}\n  why: a loss is a number; where the simulation has no solution it is infinite, never NaN\n  do:  look at the simulation at these parameters"
    )]
    Loss {
        /// The loss.
        loss: f64,
        /// The point, with names.
        at: String,
    },
    /// A gradient that permits no step.
    #[error(
        "the gradient of the loss by `{parameter}` is {value} at {at}\n  why: {why}\n  do:  check the derivative by this parameter against a difference"
    )]
    Gradient {
        /// The parameter's name.
        parameter: String,
        /// The component.
        value: f64,
        /// The point, with names.
        at: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// An evaluation without what the optimiser needs.
    #[error(
        "the evaluation for {optimiser} at {at} has no {missing}\n  why: its steps are computed from it\n  do:  compute what `Optimiser::needs` asks for"
    )]
    Missing {
        /// The optimiser.
        optimiser: &'static str,
        /// What was left out.
        missing: &'static str,
        /// The point, with names.
        at: String,
    },
    /// An evaluation at another point than the one that was asked for.
    #[error(
        "{optimiser} asked for {asked} and was given an evaluation at {evaluated}\n  why: evaluations belong to the points that were asked for, in their order\n  do:  return them in the order of `ask`"
    )]
    OtherPoint {
        /// The optimiser.
        optimiser: &'static str,
        /// The point that was evaluated.
        evaluated: String,
        /// The point that was asked for.
        asked: String,
    },
    /// Measurements that leave a parameter undetermined.
    #[error(
        "the measurements do not determine {parameters} parameters\n  why: {why}\n  do:  measure more, at other loads or markers, or fix a parameter"
    )]
    Undetermined {
        /// How many parameters are free.
        parameters: usize,
        /// What was found.
        why: String,
    },
}
