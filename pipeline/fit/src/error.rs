//! What can be wrong with a fit, said so that the next move is clear.
//!
//! Stands on: nothing. Never knows: what a parameter means; it repeats the name that the caller gave.

/// Why a search cannot begin or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// A list whose length is not the number of parameters (or of asked points).
    #[error(
        "{what} has {found} entries where {expected} are needed\n  why: it must match the search, entry by entry\n  do:  build it from the names, the start or the points that were asked for"
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
        "the bounds of `{parameter}` are {low} and {high}\n  why: the lower one must be below the upper one and both finite\n  do:  correct them where the search is set up"
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
        "the search starts at `{parameter}` = {value}\n  why: its bounds are {low} and {high}\n  do:  start between them, or widen them"
    )]
    Start {
        /// The parameter's name.
        parameter: String,
        /// Where the search was to start.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A setting that no search can work with.
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
        /// The loss that was told.
        loss: f64,
        /// The point, with names.
        at: String,
    },
    /// A gradient that no step can be made from.
    #[error(
        "the gradient of the loss by `{parameter}` is {value} at {at}\n  why: {why}\n  do:  check the derivative by this parameter against a difference"
    )]
    Gradient {
        /// The parameter's name.
        parameter: String,
        /// The component that was told.
        value: f64,
        /// The point, with names.
        at: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// An evaluation without what the optimiser works on.
    #[error(
        "{optimiser} was told a loss without its {missing} at {at}\n  why: it cannot make a step without\n  do:  compute what `Optimiser::needs` asks for"
    )]
    Missing {
        /// The optimiser.
        optimiser: &'static str,
        /// What was left out.
        missing: &'static str,
        /// The point, with names.
        at: String,
    },
    /// A point that was told is not one that was asked for.
    #[error(
        "{optimiser} was told about {told} but had asked for {asked}\n  why: evaluations answer the asked points in their order\n  do:  hand them back in the order of `ask`"
    )]
    OtherPoint {
        /// The optimiser.
        optimiser: &'static str,
        /// The point that was told.
        told: String,
        /// The point that was asked for.
        asked: String,
    },
    /// Measurements that leave a parameter undetermined.
    #[error(
        "the measurements do not determine {parameters} parameters\n  why: {why}\n  do:  measure more, at other loads or markers, or hold a parameter"
    )]
    Undetermined {
        /// How many parameters are free.
        parameters: usize,
        /// What was found.
        why: String,
    },
}
