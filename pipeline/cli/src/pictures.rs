//! What needs a picture and is left out where nothing was filmed.

use lab::card::Card;
use study::Runner;
use workflow::runner::Goal;

/// What is not made of a trial without a film.
pub(crate) const LEFT_OUT: &str =
    "camera, track, example_frames and what figures show of a picture are left out for it";

/// The trials of a card of which there is no film, in words; none where all are filmed.
pub(crate) fn unfilmed_trials(card: &Card) -> Option<String> {
    let trials: Vec<&str> = card.trial.iter().filter(|t| t.video.is_none()).map(|t| t.id.as_str()).collect();
    (!trials.is_empty()).then(|| format!("there is no film of {}", trials.join(", ")))
}

/// A sentence for each specimen of the goal of which something was not filmed.
pub fn left_out(runner: &Runner, goal: &Goal) -> Vec<String> {
    let is_asked = |card: &&Card| goal.group.as_ref().is_none_or(|name| *name == card.name);
    let cards = runner.universe.specimens.iter().map(|specimen| specimen.card.as_ref()).filter(is_asked);
    cards.filter_map(|card| Some(format!("{}: {}; {LEFT_OUT}", card.name, unfilmed_trials(card)?))).collect()
}
