//! Example frames: two frames of one film, the tail at rest and under constant pressure, and the silhouette of the tail at every held pressure.
//! Paper: figure 1.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Point3};
use track::Gray;
use track::pose::Pose;
use track::silhouette::Outline;
use track::video::Film;

use super::plateaus::command_holds;
use diagnostics::{Diagnostic, Result};
use mesh::wall::Walls;
use records::subject::Trial;
use records::{self, Camera, FrameData, HeldLevel, Markers, Motion, Path, Tracks};
use sysid::silhouette::Stations;
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
    /// Grey levels: of the ground from the first to the second, of the tail near its outline from the second to the third.
    outline: [f64; 3],
}

/// The fraction of a hold after which the tail is at rest.
const SETTLED: f64 = 0.9;

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    markers: Vec<Point3>,
    length: Metre,
    first_frame: usize,
    /// Where the clamp ends, m; none under water, where a silhouette would be that of refracted rays.
    clamp: Option<Metre>,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        Self {
            markers: of.card.marker.iter().map(|m| m.at).collect(),
            length: of.card.length,
            first_frame: of.trial.first_frame,
            clamp: (!of.is_in_water()).then(|| of.card.clamp.end()),
        }
    }
}

impl Stage for Example {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Camera, Tracks, Markers, Motion);
    type Makes = records::ExampleFrames;
    const DESCRIPTION: &'static str = "frames and silhouettes under held pressures are extracted";
    const VERSION: u32 = 5;

    fn raw(of: &Trial) -> Vec<RawFile> {
        of.film().into_iter().collect()
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        needs: Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::ExampleFrames> {
        let (camera, tracks, markers, motion) = needs;
        let holds = settled_frames(&motion);
        let shown = nearest_hold(&holds, set.pressure).ok_or_else(no_hold)?;
        let frames: Vec<usize> = std::iter::once(0).chain(holds.iter().map(|hold| hold.frame)).collect();
        let mut pictures = decoded_pictures(card, &frames, context)?;
        let film_pose = markers.stand.map(|s| Pose { rotation: s.rotation, translation: s.translation_m });
        let posed_camera = Camera { pose: film_pose.unwrap_or(camera.pose), ..camera };
        let filmed = frames.iter().copied().zip(&pictures);
        let silhouettes = wall_silhouettes((card, set), (&posed_camera, &motion), filmed);
        let pressures = holds.iter().map(|hold| hold.measured.iter().copied().fold(0.0, f64::max));
        let walls = pressures.zip(silhouettes).filter_map(|(p, walls)| Some((p, walls?))).collect();
        let shown_hold = &holds[shown];
        let markers_px = |frame: usize| -> Vec<Point2> { tracks.markers.iter().map(|m: &Path| m.at[frame]).collect() };
        let window_px = picture_window(card, &camera, &set.window);
        let level = |hold: &Held| HeldLevel { pressures_pa: hold.measured.clone(), markers_px: markers_px(hold.frame) };
        let frame_data = FrameData {
            time_s: motion.time[shown_hold.frame],
            command_pa: shown_hold.command,
            pressures_pa: shown_hold.measured.clone(),
            px_per_m: picture_scale(card, &markers_px(0)).ok_or_else(no_scale)?,
            window_px,
            held_px: markers_px(shown_hold.frame),
            rest_px: markers_px(0),
            eye_m: posed_camera.pose.centre(),
            camera_pose: (posed_camera.pose.rotation, posed_camera.pose.translation),
            levels: holds.iter().map(level).collect(),
            walls,
        };
        let [left, top, right, bottom] = window_px;
        let crop = |picture: &Gray| picture.crop(left, top, right - left, bottom - top);
        let levels = pictures[1..].iter().map(crop).collect();
        let (held, rest) = (pictures.swap_remove(shown + 1), pictures.swap_remove(0));
        Ok(records::ExampleFrames { held, rest, levels, seen: frame_data })
    }
}

/// The pictures of frames of the trial, from its first frame on.
fn decoded_pictures(card: &Card, frames: &[usize], context: &dyn StageContext) -> Result<Vec<Gray>> {
    let numbers: Vec<usize> = frames.iter().map(|frame| card.first_frame + frame).collect();
    let film = Film::open(&context.path("video")?)?;
    let pictures = film.pictures(&numbers, |part| context.progress(part, "decoding the film"))?;
    pictures.ok_or_else(|| too_short(&numbers, context))
}

/// Dent and bulge in each frame after the first, that at rest; none where the card or the picture shows no outline.
fn wall_silhouettes<'a>(
    (card, set): (&Card, &Settings),
    (camera, motion): (&Camera, &Motion),
    frames: impl Iterator<Item = (usize, &'a Gray)>,
) -> Vec<Option<Walls>> {
    let Some(stations) = card.clamp.and_then(|clamp| Stations::new(clamp, &card.markers)) else { return Vec::new() };
    let frame_silhouettes = frames.map(|(frame, picture)| {
        let outline = Outline { picture, lens: &camera.lens, pose: &camera.pose, grey: set.outline };
        let displacements: Vec<Point2> = motion.markers.iter().map(|m| m.at[frame]).collect();
        (stations.silhouette(&displacements, |normal, reach| outline.edge(normal, reach)), displacements)
    });
    let frame_silhouettes: Vec<_> = frame_silhouettes.collect();
    frame_silhouettes.iter().skip(1).map(|inflated| stations.walls(inflated, &frame_silhouettes[0].0)).collect()
}

/// A frame in which a pressure has been held for a while.
struct Held {
    frame: usize,
    command: Pascal,
    measured: Vec<Pascal>,
}

/// Near the end of every hold that the film shows.
fn settled_frames(motion: &Motion) -> Vec<Held> {
    command_holds(motion).into_iter().filter_map(|hold| settled_frame(motion, hold)).collect()
}

/// Near the end of a hold; none where the film ends before.
fn settled_frame(motion: &Motion, hold: Range<usize>) -> Option<Held> {
    let settled = hold.start + (SETTLED * (hold.len() - 1) as f64) as usize..hold.end;
    let frame = motion.time.partition_point(|&t| t < motion.log_time[settled.start]);
    let mean = |values: &[Pascal]| values[settled.clone()].iter().sum::<f64>() / settled.len() as f64;
    let measured = motion.gauges.iter().map(|g| mean(&g.measured)).collect();
    let command = motion.gauges.iter().map(|g| g.command[hold.start]).fold(0.0, f64::max);
    (frame < motion.time.len()).then_some(Held { frame, command, measured })
}

/// The last of the holds whose command is nearest to a pressure.
fn nearest_hold(holds: &[Held], pressure: Pascal) -> Option<usize> {
    let difference = |i: &usize| (holds[*i].command - pressure).abs();
    (0..holds.len()).rev().min_by(|a, b| difference(a).total_cmp(&difference(b)))
}

/// Pixels per metre: distances of the markers in the picture over those on the card.
fn picture_scale(card: &Card, markers_px: &[Point2]) -> Option<f64> {
    let flat = |p: si::Point3| [p[0], p[1]];
    let distance = |a: Point2, b: Point2| (a[0] - b[0]).hypot(a[1] - b[1]);
    let on_card: Vec<Point2> = card.markers.iter().map(|&at| flat(at)).collect();
    let length = |points: &[Point2]| points.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>();
    let metres = length(&on_card);
    (metres > 0.0 && markers_px.len() == on_card.len()).then(|| length(markers_px) / metres)
}

/// The region of the picture in which the specimen moves, refraction neglected: left, top, right, bottom, px.
fn picture_window(card: &Card, camera: &Camera, [from, to, aside]: &[f64; 3]) -> [usize; 4] {
    let corners = [[*from, -aside], [*from, *aside], [*to, -aside], [*to, *aside]];
    let on_plane = |[x, y]: [f64; 2]| [card.length * x, card.length * y, 0.0];
    camera.lens.window(corners.map(|c| camera.pose.apply(on_plane(c))), camera.size_px)
}

fn no_hold() -> Diagnostic {
    Diagnostic::new(
        "the trial holds no pressure",
        "its log commands none above zero",
        "give the staircase on the card the levels that were commanded",
    )
}

fn no_scale() -> Diagnostic {
    let unknown = "the scale of the pictures is not known";
    Diagnostic::new(unknown, "it takes two markers that lie apart", "add a second [[marker]] to the card")
}

fn too_short(frames: &[usize], context: &dyn StageContext) -> Diagnostic {
    let last = frames.iter().copied().max().unwrap_or(0);
    let missing_frame = format!("{} has no frame {last}", context.display_path("video"));
    Diagnostic::new(
        missing_frame,
        "the film ends before the pressure is held",
        "cut last_frame on the card to the film's length",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use records::{Clock, Gauge};

    /// Two pressures, each held for 0.5 s, in a film of `frames`, 0.01 s apart.
    fn staircase(frames: u32) -> Motion {
        let command: Vec<f64> = (0..400).map(|i| [0.0, 1e4, 0.0, 2e4][i / 100]).collect();
        let measured = command.iter().map(|c| 0.95 * c).collect();
        Motion {
            time: (0..frames).map(|i| 0.01 * f64::from(i)).collect(),
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
        let found = settled_frames(&staircase(200));
        let held = &found[nearest_hold(&found, 11.9e3).unwrap()];
        // sample 189, at 0.945 s
        assert_eq!((held.command, held.frame), (1e4, 95));
        // the mean of equal samples: round-off alone
        assert!((held.measured[0] - 9.5e3).abs() < 1e-9);
    }

    #[test]
    fn a_level_that_the_film_does_not_show_is_left_out_and_a_log_without_a_command_holds_nothing() {
        assert_eq!(settled_frames(&staircase(150)).len(), 1);
        let mut silent = staircase(200);
        silent.gauges[0].command.fill(0.0);
        assert_eq!(nearest_hold(&settled_frames(&silent), 1e4), None);
    }
}
