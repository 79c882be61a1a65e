//! Checks of what a trial was recorded with: a film with its lamp and camera, or markers in space alone.

use super::{Card, Trial};
use crate::range::{Checked, violation};

/// Every trial has a film or markers in space, and the card has the lamp, camera and discs of those that are filmed.
pub(super) fn recordings(card: &Card) -> Checked {
    card.trial.iter().enumerate().try_for_each(|(i, trial)| match (&trial.video, card.in_space(trial)) {
        (None, None) => {
            let what = format!("trial `{}` has neither a film nor markers in space", trial.id);
            let why = "its motion is tracked in a film, or measured by another instrument";
            violation(&format!("trial.{i}"), what, why, "add video, or [[tracks]] of this trial with [tracks.space]")
        }
        (None, Some(_)) => no_frames(&format!("trial.{i}"), trial),
        (Some(_), Some(_)) => lamp(card, trial),
        (Some(_), None) => lamp(card, trial).and_then(|()| camera(card, trial)),
    })
}

/// Frames are those of a film.
fn no_frames(key: &str, trial: &Trial) -> Checked {
    let key = match (trial.first_frame, trial.last_frame) {
        (0, None) => return Ok(()),
        (0, Some(_)) => format!("{key}.last_frame"),
        (_, _) => format!("{key}.first_frame"),
    };
    let what = format!("trial `{}` has no film, but {key} is given", trial.id);
    violation(&key, what, "frames are numbered in a film; markers in space are used whole", "take it out")
}

fn lamp(card: &Card, trial: &Trial) -> Checked {
    if card.led.is_some() {
        return Ok(());
    }
    let what = format!("trial `{}` is filmed, but the card has no [led]", trial.id);
    let why = "a lamp puts the film and the logs onto one clock";
    violation("led", what, why, "add [led] with centre and radius (px), or take video out where markers are in space")
}

fn camera(card: &Card, trial: &Trial) -> Checked {
    if card.camera.is_none() {
        let what = format!("trial `{}` is tracked in its film, but the card has no [camera]", trial.id);
        let action = "add [camera] with its board and plane, or [[tracks]] of this trial with [tracks.space]";
        return violation("camera", what, "pixels become metres by a calibrated camera", action);
    }
    match card.marker.iter().position(|marker| marker.diameter.is_none()) {
        None => Ok(()),
        Some(i) => {
            let what = format!("marker `{}` has no diameter, and trial `{}` is filmed", card.marker[i].name, trial.id);
            violation(&format!("marker.{i}"), what, "a disc is tracked in the film", "add its diameter (m)")
        }
    }
}
