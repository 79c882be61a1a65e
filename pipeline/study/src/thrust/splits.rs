//! Splits: which runs a model is fitted to, and which it is judged by. No run is ever on both sides.
//!
//! Stands on: run. Never knows: a model.

use lab::card::Split;

use super::Run;

/// A way of parting runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parting {
    /// As the card says: the paper's table II.
    Card,
    /// The highest frequency is held out.
    Frequency,
    /// The highest pressure is held out.
    Pressure,
}

/// Every way, the paper's first.
pub const ALL: [Parting; 3] = [Parting::Card, Parting::Frequency, Parting::Pressure];

impl Parting {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Card => "card",
            Self::Frequency => "frequency",
            Self::Pressure => "pressure",
        }
    }

    /// Runs to learn from and runs to be judged by; none when either side is empty.
    pub fn part(self, runs: &[Run]) -> Option<(Vec<&Run>, Vec<&Run>)> {
        let most = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
        let held = |run: &Run| match self {
            Self::Card => run.split == Some(Split::Test),
            Self::Frequency => run.frequency > 0.999 * most(|r| r.frequency),
            Self::Pressure => run.amplitude > 0.999 * most(|r| r.amplitude),
        };
        let learnt = |run: &Run| !held(run) && (self != Self::Card || run.split == Some(Split::Train));
        let train: Vec<&Run> = runs.iter().filter(|r| learnt(r)).collect();
        let test: Vec<&Run> = runs.iter().filter(|r| held(r)).collect();
        (!train.is_empty() && !test.is_empty()).then_some((train, test))
    }
}
