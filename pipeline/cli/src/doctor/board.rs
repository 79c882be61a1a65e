//! Checks of the film of the calibration board: long enough, and the board is detected, lies still and faces the camera while it lies on
//! the plane.

use lab::card::{self, LensKind};
use si::{Point2, Second};
use track::calibrate::pose_from_plane;
use track::lens::{Lens, opencv};
use track::pose::Pose;
use track::video::Film;

use super::Look;
use super::finding::Finding;
use study::stages::camera::{Camera, target};
use study::subject::Specimen;
use workflow::runner::inspection_context;
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// A corner that moves by more, px, is that of a board that is carried.
const MOVED: f64 = 3.0;
/// A plane that is tilted by more against the picture, degrees, may not be the one that was meant.
const TILTED: f64 = 10.0;

/// The camera as one view of the board shows it, without its distortion.
#[derive(Debug, Clone, Copy)]
pub struct RoughCamera {
    /// Width and height of its pictures, px.
    pub size: [usize; 2],
    /// Its lens and where it is; none where the board does not show it.
    pub pose: Option<(Lens, Pose)>,
}

/// Findings on the calibration film, and the camera. Needed where a trial is tracked in pixels.
pub fn look(look: &Look, of: &Specimen) -> (Option<RoughCamera>, Vec<Finding>) {
    let Some(camera) = &of.card.camera else { return (None, Vec::new()) };
    let there = look.path(&of.card.name, &camera.calibration).exists();
    if !there || of.trials().iter().all(|trial| trial.in_space().is_some()) {
        return (None, Vec::new());
    }
    let raw = Camera::raw(of);
    let context = inspection_context(look.folders, &raw);
    let mut found = match &camera.coefficients {
        Some(_) => lens(look, of, camera, &context),
        None => Vec::new(),
    };
    match on_plane(camera, &context) {
        Err(finding) => {
            found.push(finding);
            (None, found)
        }
        Ok((size, seen)) => {
            found.extend(lying(camera, &context, &seen));
            (Some(RoughCamera { size, pose: rough(camera, size, &seen[0].1) }), found)
        }
    }
}

/// What the file of the lens gives, and what the stage that uses it refuses.
fn lens(look: &Look, of: &Specimen, camera: &card::Camera, context: &dyn StageContext) -> Vec<Finding> {
    // a missing file is reported with the card
    let Ok(bytes) = context.bytes("lens") else { return Vec::new() };
    let (file, text) = (context.display_path("lens"), String::from_utf8_lossy(&bytes).into_owned());
    let fitted = opencv::read(&text, camera.lens == LensKind::Fisheye).ok().and_then(|known| known.fitted_px);
    let note = |off: f64| {
        let why =
            format!("a lens of five numbers stands for it, {off:.3} px off over the picture, as a root mean square");
        Finding::note(format!("{file} has more than five coefficients"), why, "leave it")
    };
    let set = look.settings.section("camera");
    let run = set.and_then(|set| Camera::run(&Part::part_of(of), &set, (), context));
    fitted.map(note).into_iter().chain(run.err().map(Finding::from)).collect()
}

/// The pose by an ordinary lens, of a camera that looks squarely: its focal length and the distance of the camera belong together, so that a place on the plane hardly depends on it.
fn rough(camera: &card::Camera, size: [usize; 2], corners: &[Point2]) -> Option<(Lens, Pose)> {
    let [width, height] = size.map(|side| side as f64);
    let f = 1.2 * width.max(height);
    let lens = Lens { fx: f, fy: f, cx: 0.5 * (width - 1.0), cy: 0.5 * (height - 1.0), ..Lens::default() };
    let card::Plane { origin, along: [c, s], height, .. } = camera.plane;
    let board = target(&camera.board).points();
    let in_cad = |p: &[f64; 3]| [origin[0] + p[0] * c - p[1] * s, origin[1] + p[0] * s + p[1] * c, height];
    let points: Vec<_> = board.iter().map(in_cad).collect();
    let flat: Vec<Point2> = board.iter().map(|p| [p[0], p[1]]).collect();
    // of a plane that is tilted against the picture, the focal length decides how far
    let is_square = tilt(&flat, corners).to_degrees() <= TILTED;
    Some((lens, pose_from_plane(&lens, &points, corners).ok().filter(|_| is_square)?))
}

/// The board's corners in a frame, and the frame's time.
type View = (Second, Vec<Point2>);

/// The board in every frame in which it should lie on the plane.
fn on_plane(camera: &card::Camera, context: &dyn StageContext) -> Result<([usize; 2], Vec<View>), Finding> {
    let [from, to] = camera.plane.seconds;
    let place = context.display_path("calibration");
    let film = context.path("calibration").and_then(|path| Ok(Film::open_board(&path, camera.frame_every)?));
    let (film, every) = film.map_err(Finding::from)?;
    let info = film.info();
    let lasts = info.frames as f64 / info.rate;
    if lasts < from {
        let why = format!("on the card the board lies on the plane from {from} to {to} s");
        let act = "correct seconds under [camera.plane] on the card";
        return Err(Finding::fix(format!("{place} lasts {lasts:.2} s"), why, act));
    }
    let finder = target(&camera.board);
    let mut message = format!("none of its frames of which one in {every} is used is in this interval");
    let mut seen = Vec::new();
    for frame in film {
        let frame = frame.map_err(|e| Finding::message(&e.to_string()))?;
        if !(from..=to).contains(&frame.time) || !frame.index.is_multiple_of(every) {
            continue;
        }
        match finder.find(&frame.gray) {
            Ok(corners) => seen.push((frame.time, corners)),
            Err(e) => message = e.to_string(),
        }
    }
    if !seen.is_empty() {
        return Ok(([info.width, info.height], seen));
    }
    let why = message.replace("\n  why:", ";").replace("\n  do:", "; do:");
    let act = "check columns, rows and seconds on the card, or film the board again, whole and sharp";
    Err(Finding::fix(format!("{place} shows no board between {from} and {to} s"), why, act))
}

/// Whether the board lies still, and squarely before the camera.
fn lying(camera: &card::Camera, context: &dyn StageContext, seen: &[View]) -> Vec<Finding> {
    let place = context.display_path("calibration");
    let [from, to] = camera.plane.seconds;
    let (_, first) = &seen[0];
    let farthest = |(time, corners): &View| (*time, distance(first, corners));
    let most = seen.iter().map(farthest).fold((from, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    if most.1 > MOVED {
        return vec![Finding::fix(
            format!("{place}: the board moves by {:.1} px between {from} and {to} s", most.1),
            format!("it is at {:.2} s where it is not at first; on the plane it lies still, within {MOVED} px", most.0),
            "correct seconds under [camera.plane] on the card: the time in which the board lies on the plane",
        )];
    }
    let board: Vec<Point2> = target(&camera.board).points().iter().map(|p| [p[0], p[1]]).collect();
    let tilt = tilt(&board, first).to_degrees();
    if tilt <= TILTED {
        return Vec::new();
    }
    vec![Finding::note(
        format!("{place}: between {from} and {to} s the board is tilted by about {tilt:.0}° against the picture"),
        "as it lies then, so lies the plane in which markers move",
        "if the camera looks at that plane squarely, correct seconds under [camera.plane] on the card",
    )]
}

/// The largest distance between the same corners, px.
fn distance(a: &[Point2], b: &[Point2]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max)
}

/// The angle between board and picture, from the shortening of one direction against the other; `board` in m, `corners` in px.
// A camera far away sees a board that is tilted by θ compressed by cos θ across its axis, whatever the focal length.
fn tilt(board: &[Point2], corners: &[Point2]) -> f64 {
    let mean = |of: &[Point2], k: usize| of.iter().map(|p| p[k]).sum::<f64>() / of.len() as f64;
    let centred = |of: &[Point2]| -> Vec<Point2> {
        let middle = [mean(of, 0), mean(of, 1)];
        of.iter().map(|p| [p[0] - middle[0], p[1] - middle[1]]).collect()
    };
    let (board, corners) = (centred(board), centred(corners));
    // a grid has no mixed second moment: each column of the affine map by itself
    let column = |k: usize| {
        let square: f64 = board.iter().map(|p| p[k] * p[k]).sum();
        [0, 1].map(|row| board.iter().zip(&corners).map(|(p, q)| p[k] * q[row]).sum::<f64>() / square)
    };
    let ([a, b], [c, d]) = (column(0), column(1));
    let (sum, determinant) = (a * a + b * b + c * c + d * d, (a * d - b * c).abs());
    let split = (sum * sum - 4.0 * determinant * determinant).max(0.0).sqrt();
    ((sum - split) / (sum + split)).max(0.0).sqrt().clamp(0.0, 1.0).acos()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board of 8 × 5 corners that is turned by `turn` in the picture and compressed along a direction of its own by cos(`tilt`).
    fn seen(tilt: f64, turn: f64) -> (Vec<Point2>, Vec<Point2>) {
        let board: Vec<Point2> = (0..40).map(|i| [0.02 * f64::from(i % 8), 0.02 * f64::from(i / 8)]).collect();
        let ([s, c], [sa, ca]) = (turn.sin_cos().into(), 0.7_f64.sin_cos().into());
        let place = |p: &Point2| {
            let (along, across) = (ca * p[0] + sa * p[1], tilt.cos() * (ca * p[1] - sa * p[0]));
            [500.0 + 4e3 * (c * along - s * across), 300.0 + 4e3 * (s * along + c * across)]
        };
        let corners = board.iter().map(place).collect();
        (board, corners)
    }

    #[test]
    fn the_tilt_of_a_compressed_board_is_found_in_any_direction() {
        for (angle, turn) in [(0.0, 0.3), (0.35, 0.0), (0.6, 2.0)] {
            let (board, corners) = seen(angle, turn);
            assert!((tilt(&board, &corners) - angle).abs() < 1e-6, "{angle} {turn}");
        }
    }
}
