//! Splits: the runs that a model is fitted to and those that it is evaluated on. No run is in both.

use lab::card::Split;

use super::Run;

/// A split rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplitRule {
    /// By the card: the paper's table II.
    Card,
    /// The highest frequency is held out.
    Frequency,
    /// The highest pressure is held out.
    Pressure,
}

/// Every rule, the paper's first.
pub const ALL: [SplitRule; 3] = [SplitRule::Card, SplitRule::Frequency, SplitRule::Pressure];

impl SplitRule {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Card => "card",
            Self::Frequency => "frequency",
            Self::Pressure => "pressure",
        }
    }

    /// Training runs and test runs; none when either is empty.
    pub fn part(self, runs: &[Run]) -> Option<(Vec<&Run>, Vec<&Run>)> {
        let greatest = |quantity: fn(&Run) -> f64| runs.iter().map(quantity).fold(0.0, f64::max);
        let is_test = |run: &Run| match self {
            Self::Card => run.split == Some(Split::Test),
            Self::Frequency => run.frequency > 0.999 * greatest(|r| r.frequency),
            Self::Pressure => run.amplitude > 0.999 * greatest(|r| r.amplitude),
        };
        let in_training = |run: &Run| !is_test(run) && (self != Self::Card || run.split == Some(Split::Train));
        let train: Vec<&Run> = runs.iter().filter(|r| in_training(r)).collect();
        let test: Vec<&Run> = runs.iter().filter(|r| is_test(r)).collect();
        (!train.is_empty() && !test.is_empty()).then_some((train, test))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::testing::run;

    /// Runs at 1, 2 and 3 Hz, of which the card keeps the second apart and leaves the third out.
    fn runs() -> Vec<Run> {
        let splits = [Some(Split::Train), Some(Split::Test), None];
        [1.0, 2.0, 3.0].iter().zip(splits).map(|(f, split)| Run { split, ..run(*f, 1e4 * f, 1) }).collect()
    }

    #[test]
    fn a_run_is_in_training_or_in_test_and_never_in_both() {
        let of = |rule: SplitRule| {
            let runs = runs();
            let (train, test) = rule.part(&runs).unwrap();
            [train, test].map(|part| part.iter().map(|run| run.frequency).collect::<Vec<f64>>())
        };
        assert_eq!(of(SplitRule::Card), [vec![1.0], vec![2.0]]);
        assert_eq!(of(SplitRule::Frequency), [vec![1.0, 2.0], vec![3.0]]);
        assert_eq!(of(SplitRule::Pressure), [vec![1.0, 2.0], vec![3.0]]);
    }

    #[test]
    fn runs_of_one_frequency_leave_none_for_training() {
        assert!(SplitRule::Frequency.part(&[run(2.0, 1e4, 1), run(2.0, 2e4, 2)]).is_none());
    }
}
