//! `[search]` and `[[tracks]]`: where markers are looked for that nobody clicked, and tracks that were made elsewhere.
//!
//! Stands on: `si`, ranges. Never knows: a picture, what a file of tracks holds.

use serde::Deserialize;
use si::{Point3, Second};

use super::{Card, check};
use crate::range::{Checked, found, within};

/// `[search]`: markers are found in the first frame of every trial, as many as the card has.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// Left, top, right and bottom of the part of the picture that holds the markers and nothing like them, px.
    pub region: [f64; 4],
    /// Where in the picture the card's second marker lies from its first, and so on: what is found is named in this order.
    #[serde(default)]
    pub order: Order,
    /// What is looked for.
    #[serde(default)]
    pub by: Sought,
}

/// A direction in the picture, along which markers follow each other as they do on the card.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// The first marker is the leftmost.
    #[default]
    Rightwards,
    /// The first marker is the rightmost.
    Leftwards,
    /// The first marker is the uppermost.
    Downwards,
    /// The first marker is the lowermost.
    Upwards,
}

/// What a marker looks like to the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sought {
    /// A dark spot on ground that is light all around it.
    #[default]
    Spots,
    /// The strongest corners (Shi and Tomasi's measure), then the dark spot of each: for marks such as crosses on ground that
    /// has dark spots of its own.
    Corners,
}

/// `[[tracks]]`: the markers of one trial's film, followed by another program or instrument.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tracks {
    /// The trial's id.
    pub trial: String,
    /// CSV of `study track` or of DeepLabCut in px; with `space`, a .c3d or the CSV of [`crate::space`]. Relative to the card;
    /// its markers are named as on the card.
    pub file: String,
    /// Standard deviation of a place along each axis, where the file tells none: px, with `space` m.
    pub sigma: f64,
    /// How the file's axes lie, where its places are in space and no lens is between.
    #[serde(default)]
    pub space: Option<Axes>,
}

/// `[tracks.space]`: the CAD frame as the file's own axes and the film's clock have it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// When the file's first frame is, s on the film's clock.
    #[serde(default)]
    pub start: Second,
    /// Where the CAD frame's origin lies, m.
    #[serde(default)]
    pub origin: Point3,
    /// Where the CAD frame's x points, of length 1.
    #[serde(default = "x_axis")]
    pub x: Point3,
    /// Where the CAD frame's z points, of length 1.
    #[serde(default = "z_axis")]
    pub z: Point3,
}

fn x_axis() -> Point3 {
    [1.0, 0.0, 0.0]
}

fn z_axis() -> Point3 {
    [0.0, 0.0, 1.0]
}

impl Order {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rightwards => "rightwards",
            Self::Leftwards => "leftwards",
            Self::Downwards => "downwards",
            Self::Upwards => "upwards",
        }
    }
}

impl Sought {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Spots => "spots",
            Self::Corners => "corners",
        }
    }
}

/// Markers are clicked, all of them, or looked for, all of them, unless every trial's tracks were made elsewhere.
pub(super) fn markers(card: &Card) -> Checked {
    let silent = card.marker.iter().position(|m| m.clicked.is_none());
    let clicked = card.marker.iter().position(|m| m.clicked.is_some());
    let elsewhere = card.trial.iter().all(|trial| card.tracks.iter().any(|t| t.trial == trial.id));
    match (&card.search, clicked, silent) {
        (Some(search), None, _) => within_picture(search),
        (Some(_), Some(i), _) => {
            let what = format!("marker `{}` is clicked, and [search] looks for markers", card.marker[i].name);
            let why = "markers that are found are named by their order, so all are clicked or none is";
            found(&format!("marker.{i}.clicked"), what, why, "take out every `clicked`, or [search]")
        }
        (None, _, Some(i)) if !elsewhere => {
            let what = format!("nobody says where marker `{}` is in the picture", card.marker[i].name);
            let why = "it is not clicked, and the card has no [search]";
            let act = "add clicked = [u, v] (px), or [search] with region = [left, top, right, bottom] (px)";
            found(&format!("marker.{i}"), what, why, act)
        }
        _ => Ok(()),
    }
}

fn within_picture(search: &Search) -> Checked {
    let [left, top, right, bottom] = search.region;
    check::pixel("search.region", &[left, top])?;
    check::pixel("search.region", &[right, bottom])?;
    if right - left < 8.0 || bottom - top < 8.0 {
        let what = format!("search.region is {} × {} px", right - left, bottom - top);
        return found("search.region", what, "it is left, top, right, bottom", "give a region that holds every marker");
    }
    Ok(())
}

/// Tracks belong to a trial, lie in the folder, and say how well they are known.
pub(super) fn tracks(card: &Card) -> Checked {
    for (i, tracks) in card.tracks.iter().enumerate() {
        let key = format!("tracks.{i}");
        check::relative(&format!("{key}.file"), &tracks.file)?;
        let c3d = tracks.file.to_ascii_lowercase().ends_with(".c3d");
        match &tracks.space {
            Some(axes) => {
                within(&format!("{key}.sigma"), tracks.sigma, 1e-7, 0.01, "m")?;
                lying(&format!("{key}.space"), axes)?;
            }
            None if c3d => {
                let what = format!("{} holds places in space", tracks.file);
                let act =
                    "add [tracks.space] below it: start (s), origin (m), x and z of the CAD frame in the file's axes";
                return found(&format!("{key}.file"), what, "the card does not say how its axes lie", act);
            }
            None => within(&format!("{key}.sigma"), tracks.sigma, 1e-3, 100.0, "px")?,
        }
        if !card.trial.iter().any(|t| t.id == tracks.trial) {
            let what = format!("tracks of `{}`, which is no trial", tracks.trial);
            return found(&format!("{key}.trial"), what, "tracks belong to a trial on the card", "correct its name");
        }
    }
    Ok(())
}

fn lying(key: &str, axes: &Axes) -> Checked {
    within(&format!("{key}.start"), axes.start, -3600.0, 3600.0, "s")?;
    check::point(&format!("{key}.origin"), &axes.origin)?;
    let length = |v: &Point3| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    within(&format!("{key}.x"), length(&axes.x), 0.999, 1.001, "(its length)")?;
    within(&format!("{key}.z"), length(&axes.z), 0.999, 1.001, "(its length)")?;
    let along: f64 = axes.x.iter().zip(axes.z).map(|(x, z)| x * z).sum();
    within(&format!("{key}.z"), along, -1e-3, 1e-3, "(its part along x)")
}
