//! Camera: a film of a checkerboard becomes the lens, and the pose in which it lies on the plane becomes the place of the
//! camera over the specimen. Paper: section IV, distortion and parallax.
//!
//! Stands on: track. Never knows: a trial.

use lab::card::{self, BoardKind, LensKind, Plane};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Point2, Point3};
use track::board::dots::Dots;
use track::board::{Board, Target};
use track::calibrate::{Calibration, View, calibrate, joint_covariance, pose_from_plane, reprojection};
use track::lens::{Bend, VALUES, opencv};
use track::pose::Pose;

use crate::fault::{Fault, Outcome};
use crate::records;
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Camera;

/// `[camera]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Largest reprojection error that is believed, px.
    reprojection_limit_px: f64,
}

/// What the film shows.
struct Seen {
    views: Vec<View>,
    on_plane: Vec<Vec<Point2>>,
    size: (usize, usize),
}

impl Stage for Camera {
    type Settings = Settings;
    type Needs = ();
    type Makes = records::Camera;
    const STORY: &'static str = "a checkerboard's film becomes lens and place";
    const EDITION: u32 = 2;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let camera = &of.card.camera;
        let lens = camera.coefficients.iter().map(|file| RawFile::new("lens", &of.card.name, file));
        std::iter::once(RawFile::new("calibration", &of.card.name, &camera.calibration)).chain(lens).collect()
    }

    fn card(of: &Specimen) -> Value {
        let camera = &of.card.camera;
        let (board, plane) = (&camera.board, &camera.plane);
        json!({
            "frame_every": camera.frame_every,
            "dots": board.kind == BoardKind::Dots,
            "fisheye": camera.lens == LensKind::Fisheye,
            "known": camera.coefficients,
            "board": [board.columns as f64, board.rows as f64, board.square],
            "plane": [plane.seconds, plane.origin, plane.along, [plane.height, 0.0]],
        })
    }

    fn run(of: &Specimen, set: &Settings, (): (), desk: &dyn Desk) -> Outcome<records::Camera> {
        let camera = &of.card.camera;
        let board = target(&camera.board);
        let seen = look(camera, &board, desk)?;
        let (width, height) = seen.size;
        let found = match &camera.coefficients {
            Some(_) => known(camera, &board, &seen.views, desk)?,
            None => calibrate(&seen.views, &board.points(), bend(camera), seen.size).map_err(Fault::from_tool)?,
        };
        if found.reprojection_px > set.reprojection_limit_px {
            return Err(not_believed(desk, found.reprojection_px, set.reprojection_limit_px));
        }
        let corners: Vec<Point3> = board.points().iter().map(|c| in_cad(&camera.plane, [c[0], c[1]])).collect();
        let on_plane = mean(&seen.on_plane);
        let pose = pose_from_plane(&found.lens, &corners, &on_plane).map_err(Fault::from_tool)?;
        let covariance = joint_covariance((&found.lens, &found.covariance), &pose, &corners, &on_plane);
        Ok(records::Camera {
            lens: found.lens,
            pose,
            reprojection_px: found.reprojection_px,
            covariance: covariance.map_err(Fault::from_tool)?,
            size_px: [width, height],
            views: seen.views.len(),
        })
    }
}

/// The board of a card as the finder takes it.
pub(crate) fn target(board: &card::Board) -> Target {
    let (columns, rows) = (board.columns, board.rows);
    match board.kind {
        BoardKind::Checkerboard => Target::Checkerboard(Board { columns, rows, square: board.square }),
        BoardKind::Dots => Target::Dots(Dots { columns, rows, pitch: board.square }),
    }
}

fn bend(camera: &card::Camera) -> Bend {
    match camera.lens {
        LensKind::BrownConrady => Bend::BrownConrady,
        LensKind::Fisheye => Bend::Fisheye,
    }
}

/// The lens of the card's coefficients, taken as exact, held against every view of the board.
fn known(camera: &card::Camera, board: &Target, views: &[View], desk: &dyn Desk) -> Outcome<Calibration> {
    let text = String::from_utf8(desk.bytes("lens")?);
    let text =
        text.map_err(|e| Fault::new(format!("{} is not text", desk.place("lens")), e, "write it with OpenCV again"))?;
    let lens = opencv::read(&text, bend(camera) == Bend::Fisheye)
        .map_err(|e| Fault::from_tool(format!("{}: {e}", desk.place("lens"))))?;
    let points = board.points();
    let poses: Result<Vec<Pose>, _> = views.iter().map(|v| pose_from_plane(&lens, &points, &v.corners)).collect();
    let poses = poses.map_err(Fault::from_tool)?;
    let misses = poses.iter().zip(views).map(|(pose, v)| reprojection(&lens, pose, &points, &v.corners).powi(2));
    let reprojection_px = (misses.sum::<f64>() / views.len() as f64).sqrt();
    Ok(Calibration { lens, poses, reprojection_px, covariance: [[0.0; VALUES]; VALUES] })
}

/// Looks for the board in one frame of every few; frames in which it lies on the plane are kept apart as well.
fn look(camera: &card::Camera, board: &Target, desk: &dyn Desk) -> Outcome<Seen> {
    let film = desk.film("calibration")?;
    let info = film.info();
    let mut seen = Seen { views: Vec::new(), on_plane: Vec::new(), size: (info.width, info.height) };
    let mut last_refusal = String::new();
    for frame in film {
        let frame = frame.map_err(Fault::from_tool)?;
        if !frame.index.is_multiple_of(camera.frame_every.max(1)) {
            continue;
        }
        desk.progress(frame.index as f64 / info.frames.max(1) as f64, "looking for the board");
        match board.find(&frame.gray) {
            Ok(corners) => {
                let [from, to] = camera.plane.seconds;
                if (from..=to).contains(&frame.time) {
                    seen.on_plane.push(corners.clone());
                }
                seen.views.push(View { corners });
            }
            Err(refusal) => last_refusal = format!("at {:.2} s: {refusal}", frame.time),
        }
    }
    match (seen.views.is_empty(), seen.on_plane.is_empty()) {
        (true, _) => Err(Fault::from_tool(format!("{} shows no board; {last_refusal}", desk.place("calibration")))),
        (_, true) => Err(not_on_plane(desk, camera)),
        _ => Ok(seen),
    }
}

/// A place on the board that lies on the plane, in the CAD frame, m.
fn in_cad(plane: &Plane, [across, down]: Point2) -> Point3 {
    let [c, s] = plane.along;
    [plane.origin[0] + across * c - down * s, plane.origin[1] + across * s + down * c, plane.height]
}

fn mean(views: &[Vec<Point2>]) -> Vec<Point2> {
    let count = views.len() as f64;
    let corner = |i: usize| [0, 1].map(|k| views.iter().map(|v| v[i][k]).sum::<f64>() / count);
    (0..views[0].len()).map(corner).collect()
}

fn not_on_plane(desk: &dyn Desk, camera: &card::Camera) -> Fault {
    let [from, to] = camera.plane.seconds;
    Fault::new(
        format!("{} shows no board between {from} and {to} s", desk.place("calibration")),
        "that is when it should lie on the plane (card, [camera.plane] seconds)",
        "correct the seconds on the card, or film the board on the plane again",
    )
}

fn not_believed(desk: &dyn Desk, measured: f64, limit: f64) -> Fault {
    Fault::new(
        format!("the lens fitted to {} is not to be believed", desk.place("calibration")),
        format!(
            "it misses the corners by {measured:.2} px; the limit is {limit:.2} px (study.toml, [camera] reprojection_limit_px)"
        ),
        "check the number of squares on the card, and film the board at rest and sharp",
    )
}
