//! Example frames: two frames of one film, the tail at rest and under constant pressure. Paper: figure 1.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Point3, Second};
use track::Gray;
use track::video::Film;

use crate::records::{self, Camera, FrameData, Motion, Path, Tracks};
use crate::subject::Trial;
use diagnostics::{Diagnostic, Result};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Example;

/// `[example_frames]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The level of the staircase nearest to this pressure is extracted, Pa.
    pressure: Pascal,
    /// The window, in lengths of the specimen: from and to along it, and to either side.
    window: [f64; 3],
}

/// The fraction of a hold after which the tail is at rest.
const SETTLED: f64 = 0.9;

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    markers: Vec<Point3>,
    length: Metre,
    first_frame: usize,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        Self {
            markers: of.card.marker.iter().map(|m| m.at).collect(),
            length: of.card.length,
            first_frame: of.trial.first_frame,
        }
    }
}

impl Stage for Example {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Camera, Tracks, Motion);
    type Makes = records::ExampleFrames;
    const DESCRIPTION: &'static str = "one frame at rest and one under pressure are extracted";
    const VERSION: u32 = 3;

    fn raw(of: &Trial) -> Vec<RawFile> {
        of.film().into_iter().collect()
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        needs: Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::ExampleFrames> {
        let (camera, tracks, motion) = needs;
        let held = held(&motion, set.pressure).ok_or_else(no_hold)?;
        let frame = motion.time.partition_point(|&t| t < held.time).min(motion.time.len().saturating_sub(1));
        let wanted = [card.first_frame, card.first_frame + frame];
        let [rest, under_pressure] = frames(wanted, context)?;
        let at = |frame: usize| -> Vec<Point2> { tracks.markers.iter().map(|m: &Path| m.at[frame]).collect() };
        let rest_px = at(0);
        let seen = FrameData {
            time_s: motion.time[frame],
            command_pa: held.command,
            pressures_pa: held.measured,
            px_per_m: scale(card, &rest_px).ok_or_else(no_scale)?,
            window_px: window(card, &camera, &set.window),
            held_px: at(frame),
            rest_px,
        };
        Ok(records::ExampleFrames { rest, held: under_pressure, seen })
    }
}

/// A moment at which a pressure has been held for a while.
struct Held {
    time: Second,
    command: Pascal,
    measured: Vec<Pascal>,
}

/// Near the end of the last run of samples whose command is the one nearest to a pressure.
fn held(motion: &Motion, near: Pascal) -> Option<Held> {
    let command = |i: usize| motion.gauges.iter().map(|g| g.command[i]).fold(0.0, f64::max);
    let order = |a: &usize, b: &usize| (command(*a) - near).abs().total_cmp(&(command(*b) - near).abs());
    let level = command((0..motion.log_time.len()).filter(|&i| command(i) > 0.0).min_by(order)?);
    let last = (0..motion.log_time.len()).rev().find(|&i| command(i) == level)?;
    let first = (0..last).rev().find(|&i| command(i) != level).map_or(0, |i| i + 1);
    let at = first + (SETTLED * (last - first) as f64) as usize;
    let settled = at..=last;
    let mean = |values: &[Pascal]| values[settled.clone()].iter().sum::<f64>() / (last - at + 1) as f64;
    let measured = motion.gauges.iter().map(|g| mean(&g.measured)).collect();
    Some(Held { time: motion.log_time[at], command: level, measured })
}

/// Two frames of the film, by their numbers.
fn frames(wanted: [usize; 2], context: &dyn StageContext) -> Result<[Gray; 2]> {
    let mut found: [Option<Gray>; 2] = [None, None];
    for frame in Film::open(&context.path("video")?)?.take(wanted[1] + 1) {
        let frame = frame?;
        for (place, _) in found.iter_mut().zip(wanted).filter(|(_, number)| *number == frame.index) {
            *place = Some(frame.gray.clone());
        }
        context.progress(frame.index as f64 / wanted[1].max(1) as f64, "decoding the film");
    }
    match found {
        [Some(rest), Some(held)] => Ok([rest, held]),
        _ => Err(too_short(wanted[1], context)),
    }
}

/// Pixels per metre: distances of the markers in the picture over those on the card.
fn scale(of: &Card, seen: &[Point2]) -> Option<f64> {
    let flat = |p: si::Point3| [p[0], p[1]];
    let apart = |a: Point2, b: Point2| (a[0] - b[0]).hypot(a[1] - b[1]);
    let card: Vec<Point2> = of.markers.iter().map(|&at| flat(at)).collect();
    let length = |points: &[Point2]| points.windows(2).map(|w| apart(w[0], w[1])).sum::<f64>();
    let metres = length(&card);
    (metres > 0.0 && seen.len() == card.len()).then(|| length(seen) / metres)
}

/// The region of the picture in which the specimen moves, refraction neglected: left, top, right, bottom, px.
fn window(card: &Card, camera: &Camera, [from, to, aside]: &[f64; 3]) -> [usize; 4] {
    let corners = [[*from, -aside], [*from, *aside], [*to, -aside], [*to, *aside]];
    let place = |[x, y]: [f64; 2]| [card.length * x, card.length * y, 0.0];
    let seen = corners.into_iter().filter_map(|c| camera.lens.project(camera.pose.apply(place(c))));
    let seen: Vec<Point2> = seen.collect();
    let ends = |k: usize| {
        let low = seen.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min).max(0.0);
        let high = seen.iter().map(|p| p[k]).fold(0.0, f64::max).min(camera.size_px[k] as f64);
        [low.min(high) as usize, high as usize]
    };
    let ([left, right], [top, bottom]) = (ends(0), ends(1));
    [left, top, right, bottom]
}

fn no_hold() -> Diagnostic {
    Diagnostic::new(
        "the trial holds no pressure",
        "its log commands none above zero",
        "give the staircase on the card the levels that were commanded",
    )
}

fn no_scale() -> Diagnostic {
    let what = "the scale of the pictures is not known";
    Diagnostic::new(what, "it takes two markers that lie apart", "add a second [[marker]] to the card")
}

fn too_short(frame: usize, context: &dyn StageContext) -> Diagnostic {
    let what = format!("{} has no frame {frame}", context.display_path("video"));
    Diagnostic::new(
        what,
        "the film ends before the pressure is held",
        "cut last_frame on the card to the film's length",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::{Clock, Gauge};

    fn staircase() -> Motion {
        let command: Vec<f64> = (0..400).map(|i| [0.0, 1e4, 0.0, 2e4][i / 100]).collect();
        let measured = command.iter().map(|c| 0.95 * c).collect();
        Motion {
            time: Vec::new(),
            markers: Vec::new(),
            rest: Vec::new(),
            gauges: vec![Gauge { chamber: "left".into(), command, measured }],
            log_time: (0..400).map(|i| 0.005 * f64::from(i)).collect(),
            clock: Clock { offset: 0.0, scale: 1.0, lamp: 0.0, sigma: 0.0 },
            sampling: lab::Sampling::default(),
        }
    }

    #[test]
    fn the_level_nearest_to_a_pressure_is_taken_when_it_has_settled() {
        let held = held(&staircase(), 11.9e3).unwrap();
        assert!((held.command, held.time) == (1e4, 0.005 * 189.0), "{} Pa at {} s", held.command, held.time);
        // the mean of equal samples: round-off alone
        assert!((held.measured[0] - 9.5e3).abs() < 1e-9);
    }

    #[test]
    fn a_log_without_a_command_holds_nothing() {
        let mut silent = staircase();
        silent.gauges[0].command.fill(0.0);
        assert!(held(&silent, 1e4).is_none());
    }
}
