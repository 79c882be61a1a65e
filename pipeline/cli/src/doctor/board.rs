//! Checks of the film of the calibration board: long enough, and the board is detected, lies still and faces the camera while it lies on
//! the plane.

use lab::card::{self, LensKind};
use si::{Point2, Second};
use track::calibrate::{View, pose_from_plane};
use track::lens::{Lens, opencv};
use track::pose::Pose;
use track::video::Film;

use super::Project;
use super::finding::Finding;
use records::subject::Specimen;
use study::stages::camera::{Camera, board_target};
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
pub(crate) fn board_findings(project: &Project, specimen: &Specimen) -> (Option<RoughCamera>, Vec<Finding>) {
    let Some(camera) = &specimen.card.camera else { return (None, Vec::new()) };
    let is_present = project.file_path(&specimen.card.name, &camera.calibration).exists();
    if !is_present || specimen.trials().iter().all(|trial| trial.in_space().is_some()) {
        return (None, Vec::new());
    }
    let raw = Camera::raw(specimen);
    let context = inspection_context(project.folders, &raw);
    match views_on_plane(camera, &context) {
        Err(finding) => (None, vec![finding]),
        Ok((size, views)) => {
            let mut findings = lens_note(camera, &context).into_iter().collect::<Vec<_>>();
            findings.extend(plane_findings(camera, &context, &views));
            // what is wrong on the plane is wrong in the stage, too
            if findings.iter().all(|finding| !finding.must_fix()) {
                findings.extend(calibration_finding(project, specimen, &context));
            }
            (Some(RoughCamera { size, pose: approximate_pose(camera, size, &views[0].view) }), findings)
        }
    }
}

/// What the file of a known lens gives, where that is not the lens itself.
fn lens_note(camera: &card::Camera, context: &dyn StageContext) -> Option<Finding> {
    camera.coefficients.as_ref()?;
    // a missing file is reported with the card, one that is no lens by the stage
    let text = String::from_utf8_lossy(&context.bytes("lens").ok()?).into_owned();
    let deviation = opencv::read(&text, camera.lens == LensKind::Fisheye).ok()?.fitted_px?;
    let reason =
        format!("a lens of five numbers stands for it, {deviation:.3} px off over the picture, as a root mean square");
    let file = context.display_path("lens");
    Some(Finding::note(format!("{file} has more than five coefficients"), reason, "leave it"))
}

/// What the stage that calibrates the camera refuses, or notes of a known lens; a lens file that is missing is reported with the card.
fn calibration_finding(project: &Project, specimen: &Specimen, context: &dyn StageContext) -> Option<Finding> {
    let lens = specimen.card.camera.as_ref().and_then(|camera| camera.coefficients.as_ref());
    if lens.is_some_and(|file| !project.file_path(&specimen.card.name, file).exists()) {
        return None;
    }
    let settings = project.settings.section("camera");
    match settings.and_then(|settings| Camera::run(&Part::part_of(specimen), &settings, (), context)) {
        Err(refusal) => Some(Finding::from(refusal)),
        Ok(record) => {
            // of a known lens alone
            let focal = record.contradiction?;
            let what = format!("{}: {focal}", context.display_path("lens"));
            Some(Finding::note(what, focal.reason(), focal.action()))
        }
    }
}

/// The pose by an ordinary lens, of a camera that looks squarely: its focal length and the distance of the camera belong together, so that a place on the plane hardly depends on it.
fn approximate_pose(camera: &card::Camera, size: [usize; 2], view: &View) -> Option<(Lens, Pose)> {
    let [width, height] = size.map(|side| side as f64);
    let focal_length = 1.2 * width.max(height);
    let lens = Lens {
        fx: focal_length,
        fy: focal_length,
        cx: 0.5 * (width - 1.0),
        cy: 0.5 * (height - 1.0),
        ..Lens::default()
    };
    let card::Plane { origin, along: [c, s], height, .. } = camera.plane;
    let board = view.points(&board_target(&camera.board).points());
    let corners = &view.corners;
    let to_cad = |p: &[f64; 3]| [origin[0] + p[0] * c - p[1] * s, origin[1] + p[0] * s + p[1] * c, height];
    let points: Vec<_> = board.iter().map(to_cad).collect();
    let grid: Vec<Point2> = board.iter().map(|p| [p[0], p[1]]).collect();
    // of a plane that is tilted against the picture, the focal length decides how far
    let is_square = tilt_angle(&grid, corners).to_degrees() <= TILTED;
    Some((lens, pose_from_plane(&lens, &points, corners).ok().filter(|_| is_square)?))
}

/// The board in a frame, and the frame's time.
struct TimedView {
    time: Second,
    view: View,
}

/// The board in every frame in which it should lie on the plane.
fn views_on_plane(camera: &card::Camera, context: &dyn StageContext) -> Result<([usize; 2], Vec<TimedView>), Finding> {
    let [from, to] = camera.plane.seconds;
    let film_path = context.display_path("calibration");
    let film = context.path("calibration").and_then(|path| Ok(Film::open_board(&path, camera.frame_every)?));
    let (film, every) = film.map_err(Finding::from)?;
    let info = film.info();
    let duration = info.frames as f64 / info.rate;
    if duration < from {
        let reason = format!("on the card the board lies on the plane from {from} to {to} s");
        let action = "correct seconds under [camera.plane] on the card";
        return Err(Finding::fix(format!("{film_path} lasts {duration:.2} s"), reason, action));
    }
    let finder = board_target(&camera.board);
    let mut last_message = format!("none of its frames of which one in {every} is used is in this interval");
    let mut views = Vec::new();
    for frame in film {
        let frame = frame.map_err(|e| Finding::message(&e.to_string()))?;
        if !(from..=to).contains(&frame.time) || !frame.index.is_multiple_of(every) {
            continue;
        }
        match finder.find(&frame.gray) {
            Ok(view) => views.push(TimedView { time: frame.time, view }),
            Err(e) => last_message = e.to_string(),
        }
    }
    if !views.is_empty() {
        return Ok(([info.width, info.height], views));
    }
    let reason = last_message.replace("\n  why:", ";").replace("\n  do:", "; do:");
    let action = "check columns, rows and seconds on the card, or film the board again, whole and sharp";
    Err(Finding::fix(format!("{film_path} shows no board between {from} and {to} s"), reason, action))
}

/// Whether the board lies still, and squarely before the camera.
fn plane_findings(camera: &card::Camera, context: &dyn StageContext, views: &[TimedView]) -> Vec<Finding> {
    let film_path = context.display_path("calibration");
    let [from, to] = camera.plane.seconds;
    let first = &views[0].view;
    let displacement = |timed: &TimedView| (timed.time, largest_distance(first, &timed.view));
    let largest = views.iter().map(displacement).fold((from, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    if largest.1 > MOVED {
        return vec![Finding::fix(
            format!("{film_path}: the board moves by {:.1} px between {from} and {to} s", largest.1),
            format!(
                "it is at {:.2} s where it is not at first; on the plane it lies still, within {MOVED} px",
                largest.0
            ),
            "correct seconds under [camera.plane] on the card: the time in which the board lies on the plane",
        )];
    }
    let points = first.points(&board_target(&camera.board).points());
    let board: Vec<Point2> = points.iter().map(|p| [p[0], p[1]]).collect();
    let angle = tilt_angle(&board, &first.corners).to_degrees();
    if angle <= TILTED {
        return Vec::new();
    }
    vec![Finding::note(
        format!("{film_path}: between {from} and {to} s the board is tilted by about {angle:.0}° against the picture"),
        "as it lies then, so lies the plane in which markers move",
        "if the camera looks at that plane squarely, correct seconds under [camera.plane] on the card",
    )]
}

/// The largest distance between the same corners, px, of those that both views show.
fn largest_distance(a: &View, b: &View) -> f64 {
    let last = a.numbers.as_ref().map_or(a.corners.len(), |numbers| numbers.last().map_or(0, |last| last + 1));
    let pairs = (0..last).filter_map(|number| a.corner_pixel(number).zip(b.corner_pixel(number)));
    pairs.map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max)
}

/// The angle between board and picture, from the shortening of one direction against the other; `board` in m, `corners` in px.
// A camera far away sees a board that is tilted by θ compressed by cos θ across its axis, whatever the focal length.
fn tilt_angle(board: &[Point2], corners: &[Point2]) -> f64 {
    let mean_coordinate = |points: &[Point2], k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
    let centred = |points: &[Point2]| -> Vec<Point2> {
        let centroid = [mean_coordinate(points, 0), mean_coordinate(points, 1)];
        points.iter().map(|p| [p[0] - centroid[0], p[1] - centroid[1]]).collect()
    };
    let (board, corners) = (centred(board), centred(corners));
    // the affine map by least squares: M (Σ p pᵀ) = Σ q pᵀ
    let moment = |i: usize, j: usize| board.iter().map(|p| p[i] * p[j]).sum::<f64>();
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let column = |row: usize| {
        let product = |k: usize| board.iter().zip(&corners).map(|(p, q)| p[k] * q[row]).sum::<f64>();
        let (x, y) = (product(0), product(1));
        [yy * x - xy * y, xx * y - xy * x].map(|scaled| scaled / (xx * yy - xy * xy))
    };
    let ([a, c], [b, d]) = (column(0), column(1));
    let (sum, determinant) = (a * a + b * b + c * c + d * d, (a * d - b * c).abs());
    let discriminant = (sum * sum - 4.0 * determinant * determinant).max(0.0).sqrt();
    ((sum - discriminant) / (sum + discriminant)).max(0.0).sqrt().clamp(0.0, 1.0).acos()
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
            assert!((tilt_angle(&board, &corners) - angle).abs() < 1e-6, "{angle} {turn}");
        }
    }
}
