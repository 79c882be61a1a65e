//! Camera: a film of a checkerboard gives the lens, and the pose in which it lies on the plane gives the pose of the
//! camera relative to the specimen. Paper: section IV, distortion and parallax.

use lab::card::{self, BoardKind, LensKind};
use serde::{Deserialize, Serialize};
use si::{Metre, Point2, Point3, Second};
use std::path::Path;
use track::board::{Target, TargetKind};
use track::calibrate::{
    Calibration, View, calibrate, focal_difference, joint_covariance, pose_from_plane, reprojection_error,
};
use track::lens::{Distortion, VALUES, opencv, opencv::KnownLens};
use track::picture_size;
use track::pose::Pose;
use track::video::Film;

use diagnostics::{Diagnostic, Result};
use records::subject::Specimen;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Camera;

/// `[camera]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Largest reprojection error that is accepted, px.
    reprojection_limit_px: f64,
}

/// Views of the board in the calibration film.
struct BoardViews {
    views: Vec<View>,
    on_plane: Vec<View>,
    size: (usize, usize),
}

/// What it reads of the card; nothing where nothing is tracked in a film.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub struct Card(Option<CalibrationFilm>);

/// The calibration on the card.
#[derive(Debug, Serialize)]
struct CalibrationFilm {
    frame_every: usize,
    lens: LensKind,
    coefficients: Option<String>,
    board: card::Board,
    plane: CalibrationPlane,
}

/// The plane on which the board lies at the end of the film.
#[derive(Debug, Serialize)]
struct CalibrationPlane {
    seconds: [Second; 2],
    origin: Point2,
    along: Point2,
    height: Metre,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self(of.card.camera.clone().map(|camera| {
            let card::Camera { frame_every, lens, coefficients, board, plane, .. } = camera;
            let card::Plane { seconds, origin, along, height, .. } = plane;
            let plane = CalibrationPlane { seconds, origin, along, height };
            CalibrationFilm { frame_every, lens, coefficients, board, plane }
        }))
    }
}

impl Stage for Camera {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::Camera;
    const DESCRIPTION: &'static str = "lens and pose are calibrated from a checkerboard";
    const VERSION: u32 = 3;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let raw = |word: &str, file: &str| RawFile::new(word, &of.card.name, file);
        let camera = of.card.camera.iter();
        camera
            .flat_map(|camera| {
                let lens = camera.coefficients.iter().map(|file| raw("lens", file));
                std::iter::once(raw("calibration", &camera.calibration)).chain(lens)
            })
            .collect()
    }

    fn run(card: &Self::Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::Camera> {
        let Card(Some(camera)) = card else { return Err(no_camera()) };
        let board = board_target(&camera.board);
        let board_views = detect_board(camera, &board, context)?;
        let (width, height) = board_views.size;
        let calibration = match &camera.coefficients {
            Some(_) => known_calibration(camera, &board, &board_views, context)?,
            None => calibrate(&board_views.views, &board.points(), lens_distortion(camera), board_views.size)?,
        };
        let is_known = camera.coefficients.is_some();
        let contradiction = is_known
            .then(|| focal_difference(&calibration.lens, &board_views.views, &board.points(), board_views.size))
            .flatten();
        if calibration.reprojection_px > set.reprojection_limit_px {
            let measured_and_limit = [calibration.reprojection_px, set.reprojection_limit_px];
            return Err(not_believed(context, measured_and_limit, is_known));
        }
        let plane_view = View::mean(&board_views.on_plane);
        let on_board = plane_view.points(&board.points());
        let corners: Vec<Point3> = on_board.iter().map(|c| in_cad(&camera.plane, [c[0], c[1]])).collect();
        let pose = pose_from_plane(&calibration.lens, &corners, &plane_view.corners)?;
        let covariance =
            joint_covariance((&calibration.lens, &calibration.covariance), &pose, &corners, &plane_view.corners);
        Ok(records::Camera {
            lens: calibration.lens,
            pose,
            reprojection_px: calibration.reprojection_px,
            covariance: covariance?,
            size_px: [width, height],
            views: board_views.views.len(),
            contradiction,
        })
    }
}

fn no_camera() -> Diagnostic {
    Diagnostic::new(
        "the card has no [camera]",
        "its markers were measured in space",
        "add [camera], or leave this stage out",
    )
}

/// The board of a card as the detector's target.
pub fn board_target(board: &card::Board) -> Target {
    let dictionary = board.dictionary.as_deref().and_then(|name| name.parse().ok()); // its name was checked with the card
    let kind = match board.kind {
        BoardKind::Checkerboard => TargetKind::Checkerboard,
        BoardKind::Dots => TargetKind::Dots,
        BoardKind::AsymmetricDots => TargetKind::AsymmetricDots,
        BoardKind::Charuco => TargetKind::charuco(board.marker, dictionary),
    };
    Target::new(kind, [board.columns, board.rows], board.square)
}

fn lens_distortion(camera: &CalibrationFilm) -> Distortion {
    match camera.lens {
        LensKind::BrownConrady => Distortion::BrownConrady,
        LensKind::Fisheye => Distortion::Fisheye,
    }
}

/// The lens of the card's coefficients, taken as exact, checked against every view of the board.
fn known_calibration(
    camera: &CalibrationFilm,
    board: &Target,
    board_views: &BoardViews,
    context: &dyn StageContext,
) -> Result<Calibration> {
    let lens_path = context.display_path("lens");
    let text = lab::log::decoded(context.bytes("lens")?, Path::new(&lens_path))?;
    let in_file = |e: Diagnostic| e.in_file(Path::new(&lens_path));
    let fisheye = lens_distortion(camera) == Distortion::Fisheye;
    let KnownLens { lens, size, .. } = opencv::read(&text, fisheye).map_err(|e| in_file(e.into()))?;
    picture_size::check(size.unwrap_or(board_views.size.into()), board_views.size.into())
        .map_err(|e| in_file(e.into()))?;
    let points = board.points();
    let views = &board_views.views;
    let pose = |view: &View| pose_from_plane(&lens, &view.points(&points), &view.corners);
    let poses = views.iter().map(pose).collect::<Result<Vec<Pose>, _>>()?;
    let miss =
        |(pose, view): (&Pose, &View)| reprojection_error(&lens, pose, &view.points(&points), &view.corners).powi(2);
    let misses = poses.iter().zip(views).map(miss);
    let reprojection_px = (misses.sum::<f64>() / views.len() as f64).sqrt();
    Ok(Calibration { lens, poses, reprojection_px, covariance: [[0.0; VALUES]; VALUES] })
}

/// Searches one frame of every few for the board; frames in which it lies on the plane are also collected separately.
fn detect_board(camera: &CalibrationFilm, board: &Target, context: &dyn StageContext) -> Result<BoardViews> {
    let (film, every) = Film::open_board(&context.path("calibration")?, camera.frame_every)?;
    let info = film.info();
    let mut board_views = BoardViews { views: Vec::new(), on_plane: Vec::new(), size: (info.width, info.height) };
    let mut last_refusal: Option<Diagnostic> = None;
    for frame in film {
        let frame = frame?;
        if !frame.index.is_multiple_of(every) {
            continue;
        }
        context.progress(frame.index as f64 / info.frames.max(1) as f64, "detecting the board");
        match board.find(&frame.gray) {
            Ok(view) => {
                let [from, to] = camera.plane.seconds;
                if (from..=to).contains(&frame.time) {
                    board_views.on_plane.push(view.clone());
                }
                board_views.views.push(view);
            }
            Err(refusal) => {
                last_refusal = Some(Diagnostic::from(refusal).while_doing(format!("at {:.2} s", frame.time)))
            }
        }
    }
    match (board_views.views.is_empty(), board_views.on_plane.is_empty()) {
        (true, _) => Err(no_board(last_refusal, context)),
        (_, true) => Err(not_on_plane(context, camera)),
        _ => Ok(board_views),
    }
}

/// A place on the board that lies on the plane, in the CAD frame, m.
fn in_cad(plane: &CalibrationPlane, [across, down]: Point2) -> Point3 {
    let [c, s] = plane.along;
    [plane.origin[0] + across * c - down * s, plane.origin[1] + across * s + down * c, plane.height]
}

fn not_on_plane(context: &dyn StageContext, camera: &CalibrationFilm) -> Diagnostic {
    let [from, to] = camera.plane.seconds;
    Diagnostic::new(
        format!("{} shows no board between {from} and {to} s", context.display_path("calibration")),
        "that is when it should lie on the plane (card, [camera.plane] seconds)",
        "correct the seconds on the card, or film the board on the plane again",
    )
}

fn not_believed(context: &dyn StageContext, [measured, limit]: [f64; 2], is_known: bool) -> Diagnostic {
    let film = context.display_path("calibration");
    let reason = format!(
        "its reprojection error is {measured:.2} px; the limit is {limit:.2} px (study.toml, [camera] reprojection_limit_px)"
    );
    let (defect, action) = if is_known {
        let lens = context.display_path("lens");
        (
            format!("the lens of {lens} is not that of {film}"),
            "name the lens file of this camera, zoom and size of pictures, leave `coefficients` out so that the lens is fitted to the board, or correct the board on the card",
        )
    } else {
        (
            format!("the lens fitted to {film} is not accurate enough"),
            "check the number of squares on the card, and film the board at rest and sharp",
        )
    };
    Diagnostic::new(defect, reason, action)
}

fn no_board(last_refusal: Option<Diagnostic>, context: &dyn StageContext) -> Diagnostic {
    let no_view = format!("{} shows no board", context.display_path("calibration"));
    match last_refusal {
        Some(refusal) => refusal.while_doing(no_view),
        None => {
            Diagnostic::new(no_view, "none of its frames was searched", "lower frame_every of [camera] on the card")
        }
    }
}
