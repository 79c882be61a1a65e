//! Checks of where markers come from: clicks, a search in the picture, or tracks of another program.

use si::Point3;

use super::entry::{pixel, point, relative};
use super::{Axes, Card, Search};
use crate::range::{Checked, violation, within};

/// All markers are clicked, or all are searched for, unless every trial has tracks of another program.
pub(super) fn markers(card: &Card) -> Checked {
    let silent = card.marker.iter().position(|m| m.clicked.is_none());
    let clicked = card.marker.iter().position(|m| m.clicked.is_some());
    let elsewhere = card.trial.iter().all(|trial| card.tracks.iter().any(|t| t.trial == trial.id));
    match (&card.search, clicked, silent) {
        (Some(search), None, _) => within_picture(search),
        (Some(_), Some(i), _) => {
            let what = format!("marker `{}` is clicked, and [search] looks for markers", card.marker[i].name);
            let why = "markers that are found are named by their order, so all are clicked or none is";
            violation(&format!("marker.{i}.clicked"), what, why, "take out every `clicked`, or [search]")
        }
        (None, _, Some(i)) if !elsewhere => {
            let what = format!("marker `{}` has no place in the picture", card.marker[i].name);
            let why = "it is not clicked, and the card has no [search]";
            let action = "add clicked = [u, v] (px), or [search] with region = [left, top, right, bottom] (px)";
            violation(&format!("marker.{i}"), what, why, action)
        }
        _ => Ok(()),
    }
}

fn within_picture(search: &Search) -> Checked {
    let [left, top, right, bottom] = search.region;
    pixel("search.region", &[left, top])?;
    pixel("search.region", &[right, bottom])?;
    if right - left < 8.0 || bottom - top < 8.0 {
        let what = format!("search.region is {} × {} px", right - left, bottom - top);
        return violation(
            "search.region",
            what,
            "it is left, top, right, bottom",
            "give a region that holds every marker",
        );
    }
    Ok(())
}

/// Tracks must belong to a trial, be in the folder, and have a standard deviation.
pub(super) fn tracks(card: &Card) -> Checked {
    for (i, tracks) in card.tracks.iter().enumerate() {
        let key = format!("tracks.{i}");
        relative(&format!("{key}.file"), &tracks.file)?;
        let c3d = tracks.file.to_ascii_lowercase().ends_with(".c3d");
        match &tracks.space {
            Some(axes) => {
                within(&format!("{key}.sigma"), tracks.sigma, 1e-7..=0.01, "m")?;
                check_axes(&format!("{key}.space"), axes)?;
            }
            None if c3d => {
                let what = format!("{} holds places in space", tracks.file);
                let action =
                    "add [tracks.space] below it: start (s), origin (m), x and z of the CAD frame in the file's axes";
                return violation(&format!("{key}.file"), what, "the card has no axes for it", action);
            }
            None => within(&format!("{key}.sigma"), tracks.sigma, 1e-3..=100.0, "px")?,
        }
        if !card.trial.iter().any(|t| t.id == tracks.trial) {
            let what = format!("tracks of `{}`, which is no trial", tracks.trial);
            return violation(
                &format!("{key}.trial"),
                what,
                "tracks belong to a trial on the card",
                "correct its name",
            );
        }
    }
    Ok(())
}

fn check_axes(key: &str, axes: &Axes) -> Checked {
    within(&format!("{key}.start"), axes.start, -1e10..=1e10, "s")?;
    point(&format!("{key}.origin"), &axes.origin)?;
    let length = |v: &Point3| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    within(&format!("{key}.x"), length(&axes.x), 0.999..=1.001, "(its length)")?;
    within(&format!("{key}.z"), length(&axes.z), 0.999..=1.001, "(its length)")?;
    let along: f64 = axes.x.iter().zip(axes.z).map(|(x, z)| x * z).sum();
    within(&format!("{key}.z"), along, -1e-3..=1e-3, "(its part along x)")
}
