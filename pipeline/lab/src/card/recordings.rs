//! Checks of what a trial was recorded with: a film with its lamp and camera, or markers in space alone.

use super::{Card, Trial};
use crate::range::{Checked, violation};

/// Every trial has a film or markers in space, and the card has the lamp, camera and discs of those that are filmed.
pub(super) fn check_recordings(card: &Card) -> Checked {
    card.trial.iter().enumerate().try_for_each(|(i, trial)| match (&trial.video, card.in_space(trial)) {
        (None, None) => {
            let defect = format!("trial `{}` has neither a film nor markers in space", trial.id);
            let reason = "its motion is tracked in a film, or measured by another instrument";
            violation(
                &format!("trial.{i}"),
                defect,
                reason,
                "add video, or [[tracks]] of this trial with [tracks.space]",
            )
        }
        (None, Some(_)) => check_frames(&format!("trial.{i}"), trial),
        (Some(_), Some(_)) => check_lamp(card, trial),
        (Some(_), None) => check_lamp(card, trial).and_then(|()| check_camera(card, trial)),
    })
}

/// Frames are those of a film.
fn check_frames(key: &str, trial: &Trial) -> Checked {
    let key = match (trial.first_frame, trial.last_frame) {
        (0, None) => return Ok(()),
        (0, Some(_)) => format!("{key}.last_frame"),
        (_, _) => format!("{key}.first_frame"),
    };
    let defect = format!("trial `{}` has no film, but {key} is given", trial.id);
    violation(&key, defect, "frames are numbered in a film; markers in space are used whole", "take it out")
}

fn check_lamp(card: &Card, trial: &Trial) -> Checked {
    if card.led.is_some() {
        return Ok(());
    }
    let defect = format!("trial `{}` is filmed, but the card has no [led]", trial.id);
    let reason = "a lamp puts the film and the logs onto one clock";
    violation(
        "led",
        defect,
        reason,
        "add [led] with centre and radius (px), or take video out where markers are in space",
    )
}

fn check_camera(card: &Card, trial: &Trial) -> Checked {
    if card.camera.is_none() {
        let defect = format!("trial `{}` is tracked in its film, but the card has no [camera]", trial.id);
        let action = "add [camera] with its board and plane, or [[tracks]] of this trial with [tracks.space]";
        return violation("camera", defect, "pixels become metres by a calibrated camera", action);
    }
    match card.marker.iter().position(|marker| marker.diameter.is_none()) {
        None => Ok(()),
        Some(i) => {
            let defect =
                format!("marker `{}` has no diameter, and trial `{}` is filmed", card.marker[i].name, trial.id);
            violation(&format!("marker.{i}"), defect, "a disc is tracked in the film", "add its diameter (m)")
        }
    }
}
