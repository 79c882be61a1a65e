//! Markers: pixel tracks become metres in the plane of the CAD frame, each marker at its own height over the calibrated
//! plane, seen through the lens, through water where there is some, by a shutter that rolls. Paper: section IV.
//!
//! Stands on: track. Never knows: what the markers sit on, the logs.

mod carry;
mod elsewhere;

use lab::card::Medium;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Point2, Radian, Second, vec3};
use track::grid::{self, Grid};
use track::lens::Lens;
use track::pose::Pose;
use track::shutter::{self, Shutter};
use track::sight::{Sight, Water};

use crate::fault::{Fault, Outcome};
use crate::needs::Maybe;
use crate::records::{self, Camera, LeftOut, Parts, Path, Stand, Tracks};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Trial;
use carry::{Doubts, Shared};

/// The stage.
pub struct Markers;

/// `[markers]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How well a marker's height over the calibrated plane is known, standard deviation, m.
    height_sigma: Metre,
    /// How well the middle of a mark stands for the point under it, standard deviation along x and y, m: the skin under
    /// a mark stretches unevenly.
    mark_sigma: Metre,
    /// How well the height of the water's surface is known, standard deviation, m.
    surface_sigma: Metre,
    /// How well its refractive index is known, standard deviation, no unit.
    index_sigma: f64,
    /// How much ripples tilt the surface, root of the mean squared slope, rad.
    ripple: Radian,
}

impl Stage for Markers {
    type Settings = Settings;
    type Needs = (Maybe<Camera>, Tracks);
    type Makes = records::Markers;
    const STORY: &'static str = "pixels become metres in the plane";
    const EDITION: u32 = 3;

    fn raw(of: &Trial) -> Vec<RawFile> {
        let space = of.in_space().map(|(tracks, _)| RawFile::new(elsewhere::WORD, &of.card.name, &tracks.file));
        let film = grid(of).map(|_| RawFile::new("video", &of.card.name, &of.trial.video));
        space.into_iter().chain(film).collect()
    }

    fn card(of: &Trial) -> Value {
        let water = water(of).map(|w| [w.surface, w.index]);
        json!({
            "heights": of.card.marker.iter().map(|m| m.at[2]).collect::<Vec<_>>(),
            "plane": of.card.camera.plane.height,
            "grid": grid(of).map(|g| g.pitch),
            "readout": of.card.camera.readout,
            "water": water,
            "space": elsewhere::card(of),
        })
    }

    fn run(
        of: &Trial,
        set: &Settings,
        (Maybe(camera), tracks): Self::Needs,
        desk: &dyn Desk,
    ) -> Outcome<records::Markers> {
        let Some(camera) = camera.filter(|_| of.in_space().is_none()) else {
            return elsewhere::places(of, &tracks.time, set.mark_sigma, desk);
        };
        let hung = Sight { lens: camera.lens, pose: camera.pose, water: water(of) };
        let stand = stood(of, &hung, desk)?;
        let pose = stand.as_ref().map_or(hung.pose, |s| Pose { rotation: s.rotation, translation: s.translation_m });
        let sight = Sight { pose, ..hung };
        let shutter = Shutter { readout: of.card.camera.readout, height: camera.size_px[1] };
        let heights: Vec<Metre> = of.card.marker.iter().map(|m| m.at[2]).collect();
        let whole = places(&sight, &shutter, &tracks, &heights)?;
        let doubts = Doubts {
            shared: Shared::new(&camera.covariance, [set.surface_sigma, set.index_sigma, set.height_sigma]),
            ripple: set.ripple,
            mark: set.mark_sigma,
        };
        let carried =
            tracks.markers.iter().zip(&heights).map(|(path, height)| carry::all(&sight, path, *height, &doubts));
        let (spreads, parts): (Vec<_>, Vec<Parts>) = carried.collect::<Outcome<Vec<_>>>()?.into_iter().unzip();
        let mut left_out = Vec::new();
        for (correction, sight, shutter, heights) in without(&sight, &shutter, &heights, of.card.camera.plane.height) {
            let other = places(&sight, &shutter, &tracks, &heights)?;
            left_out.push(worth(correction, &whole, &other));
        }
        let named = tracks.markers.iter().zip(whole).zip(spreads);
        let markers = named.map(|((path, at), spread)| Path { name: path.name.clone(), at, spread }).collect();
        Ok(records::Markers { time: tracks.time, markers, parts, left_out, stand })
    }
}

/// The lines under the specimen, where a film is looked at and the card names them.
fn grid(of: &Trial) -> Option<Grid> {
    let plane = &of.card.camera.plane;
    plane.grid.filter(|_| of.made_elsewhere().is_none()).map(|pitch| Grid { pitch, height: plane.height })
}

/// Where the camera stood in the film's first frame.
fn stood(of: &Trial, hung: &Sight, desk: &dyn Desk) -> Outcome<Option<Stand>> {
    let Some(grid) = grid(of) else { return Ok(None) };
    let Some(frame) = desk.film("video")?.nth(of.trial.first_frame) else { return Ok(None) };
    let frame = frame.map_err(Fault::from_tool)?;
    let found = grid::stand(&frame.gray, hung, &grid);
    Ok(found.map(|found| Stand {
        rotation: found.pose.rotation,
        translation_m: found.pose.translation,
        pieces: found.pieces,
        off_m: found.off,
        moved_m: vec3::norm(vec3::sub(found.pose.centre(), hung.pose.centre())),
    }))
}

/// The water that a trial is seen through.
fn water(of: &Trial) -> Option<Water> {
    let filled = of.card.water.as_ref().filter(|_| of.trial.medium == Medium::Water);
    filled.map(|w| Water { surface: w.surface, index: w.index })
}

/// Every marker in every frame, m, at the frame's own time.
fn places(sight: &Sight, shutter: &Shutter, tracks: &Tracks, heights: &[Metre]) -> Outcome<Vec<Vec<Point2>>> {
    let one = |(path, height): (&Path, &Metre)| {
        let met = path
            .at
            .iter()
            .enumerate()
            .map(|(frame, &pixel)| sight.meet(pixel, *height).ok_or_else(|| no_ray(&path.name, frame, pixel)));
        let read: Vec<Second> = tracks.time.iter().zip(&path.at).map(|(t, [_, v])| t + shutter.late(*v)).collect();
        Ok(shutter::at_times(&tracks.time, &read, &met.collect::<Outcome<Vec<_>>>()?))
    };
    tracks.markers.iter().zip(heights).map(one).collect()
}

/// What the sight would be without each of the corrections that the trial has.
fn without(
    sight: &Sight,
    shutter: &Shutter,
    heights: &[Metre],
    plane: Metre,
) -> Vec<(&'static str, Sight, Shutter, Vec<Metre>)> {
    let lens = Lens { fx: sight.lens.fx, fy: sight.lens.fy, cx: sight.lens.cx, cy: sight.lens.cy, ..Lens::default() };
    let mut all = vec![
        ("parallax", *sight, *shutter, vec![plane; heights.len()]),
        ("distortion", Sight { lens, ..*sight }, *shutter, heights.to_vec()),
    ];
    if sight.water.is_some() {
        all.push(("refraction", Sight { water: None, ..*sight }, *shutter, heights.to_vec()));
    }
    if shutter.readout > 0.0 {
        all.push(("rolling_shutter", *sight, Shutter { readout: 0.0, ..*shutter }, heights.to_vec()));
    }
    all
}

/// How far the places and displacements without a correction are from those with it.
fn worth(correction: &str, whole: &[Vec<Point2>], other: &[Vec<Point2>]) -> LeftOut {
    let (mut place, mut motion, mut count) = (0.0, 0.0, 0.0_f64);
    for (whole, other) in whole.iter().zip(other) {
        let off: Vec<Point2> = whole.iter().zip(other).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        for d in &off {
            place += d[0] * d[0] + d[1] * d[1];
            motion += (d[0] - off[0][0]).powi(2) + (d[1] - off[0][1]).powi(2);
            count += 1.0;
        }
    }
    let root = |sum: f64| (sum / count.max(1.0)).sqrt();
    LeftOut { correction: correction.into(), place_m: root(place), motion_m: root(motion) }
}

fn no_ray(marker: &str, frame: usize, pixel: Point2) -> Fault {
    Fault::new(
        format!(
            "marker `{marker}` at ({:.1}, {:.1}) px in frame {frame} meets no point of the plane",
            pixel[0], pixel[1]
        ),
        "the calibrated lens has no ray there, or it runs away from the plane",
        "film the board up to the frame's corners, or check the plane's height on the card",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_stays_the_same_moves_places_and_not_displacements() {
        let whole = vec![vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]];
        let other = vec![vec![[0.3, 0.4], [1.3, 0.4], [2.3, 0.4]]];
        let found = worth("parallax", &whole, &other);
        assert!((found.place_m - 0.5).abs() < 1e-15 && found.motion_m < 1e-15);
    }
}
