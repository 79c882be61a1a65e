//! Checks of where markers come from: clicks, a search in the picture, or tracks of another program.

use si::Point3;

use super::entry::{check_pixel, check_point, check_relative};
use super::{Axes, Card, Search};
use crate::range::{Checked, violation, within};

/// All markers are clicked, or all are searched for, unless every trial has tracks of another program.
pub(super) fn check_markers(card: &Card) -> Checked {
    let unclicked = card.marker.iter().position(|m| m.clicked.is_none());
    let clicked = card.marker.iter().position(|m| m.clicked.is_some());
    let is_imported = card.trial.iter().all(|trial| card.tracks.iter().any(|t| t.trial == trial.id));
    match (&card.search, clicked, unclicked) {
        (Some(search), None, _) => within_picture(search),
        (Some(_), Some(i), _) => {
            let defect = format!("marker `{}` is clicked, and [search] looks for markers", card.marker[i].name);
            let reason = "markers that are found are named by their order, so all are clicked or none is";
            violation(&format!("marker.{i}.clicked"), defect, reason, "take out every `clicked`, or [search]")
        }
        (None, _, Some(i)) if !is_imported => {
            let defect = format!("marker `{}` has no place in the picture", card.marker[i].name);
            let reason = "it is not clicked, and the card has no [search]";
            let action = "add clicked = [u, v] (px), or [search] with region = [left, top, right, bottom] (px)";
            violation(&format!("marker.{i}"), defect, reason, action)
        }
        _ => Ok(()),
    }
}

fn within_picture(search: &Search) -> Checked {
    let [left, top, right, bottom] = search.region;
    check_pixel("search.region", &[left, top])?;
    check_pixel("search.region", &[right, bottom])?;
    if right - left < 8.0 || bottom - top < 8.0 {
        let defect = format!("search.region is {} × {} px", right - left, bottom - top);
        return violation(
            "search.region",
            defect,
            "it is left, top, right, bottom",
            "give a region that holds every marker",
        );
    }
    Ok(())
}

/// Tracks must belong to a trial, be in the folder, and have a standard deviation.
pub(super) fn check_tracks(card: &Card) -> Checked {
    for (i, tracks) in card.tracks.iter().enumerate() {
        let key = format!("tracks.{i}");
        check_relative(&format!("{key}.file"), &tracks.file)?;
        let is_c3d = tracks.file.to_ascii_lowercase().ends_with(".c3d");
        match &tracks.space {
            Some(axes) => {
                within(&format!("{key}.sigma"), tracks.sigma, 1e-7..=0.01, "m")?;
                check_axes(&format!("{key}.space"), axes)?;
            }
            None if is_c3d => {
                let defect = format!("{} holds places in space", tracks.file);
                let action =
                    "add [tracks.space] below it: start (s), origin (m), x and z of the CAD frame in the file's axes";
                return violation(&format!("{key}.file"), defect, "the card has no axes for it", action);
            }
            None => within(&format!("{key}.sigma"), tracks.sigma, 1e-3..=100.0, "px")?,
        }
        if !card.trial.iter().any(|t| t.id == tracks.trial) {
            let defect = format!("tracks of `{}`, which is no trial", tracks.trial);
            return violation(
                &format!("{key}.trial"),
                defect,
                "tracks belong to a trial on the card",
                "correct its name",
            );
        }
    }
    Ok(())
}

fn check_axes(key: &str, axes: &Axes) -> Checked {
    within(&format!("{key}.start"), axes.start, -1e10..=1e10, "s")?;
    check_point(&format!("{key}.origin"), &axes.origin)?;
    let length = |v: &Point3| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    within(&format!("{key}.x"), length(&axes.x), 0.999..=1.001, "(its length)")?;
    within(&format!("{key}.z"), length(&axes.z), 0.999..=1.001, "(its length)")?;
    let projection: f64 = axes.x.iter().zip(axes.z).map(|(x, z)| x * z).sum();
    within(&format!("{key}.z"), projection, -1e-3..=1e-3, "(its part along x)")
}
