//! Markers: pixel tracks are projected to metres in the plane of the CAD frame, each marker at its own height over the calibrated
//! plane, with lens distortion, refraction and rolling shutter. Paper: section IV.

mod carry;
mod elsewhere;

use lab::{card::Medium, rest::ShownBy};
use serde::{Deserialize, Serialize};
use si::{Metre, Point2, Radian, Second, vec3};
use track::grid::{self, Grid};
use track::lens::Lens;
use track::picture_size;
use track::pose::Pose;
use track::refraction::{RefractiveCamera, Water};
use track::shutter::{self, Shutter};
use track::video::Film;

use carry::{Shared, UncertaintySources};
use diagnostics::{Diagnostic, Result};
use records::subject::Trial;
use records::{self, Camera, CovarianceParts, FilmPose, OmittedCorrection, Path, Tracks};
use workflow::needs::Maybe;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Markers;

/// `[markers]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Standard deviation of a marker's height over the calibrated plane, m.
    height_sigma: Metre,
    /// Standard deviation of a marker's centre against the material point under it, along x and y, m: the skin under
    /// a marker stretches unevenly.
    mark_sigma: Metre,
    /// Standard deviation of the height of the water's surface, m.
    surface_sigma: Metre,
    /// Standard deviation of its refractive index, no unit.
    index_sigma: f64,
    /// Root mean square slope of ripples on the surface, rad.
    ripple: Radian,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    /// z of each marker, m.
    heights: Vec<Metre>,
    /// x and y of each marker at rest, m.
    painted: Vec<Point2>,
    /// Length of the specimen, m.
    length: Metre,
    /// z of the calibrated plane, m.
    plane: Metre,
    /// Pitch of the grid on the plane, m.
    grid: Option<Metre>,
    /// How long a picture's rows take to be read, s.
    readout: Second,
    /// The water between camera and specimen.
    water: Option<lab::card::Water>,
    first_frame: usize,
    space: Option<elsewhere::Card>,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        let camera = of.card.camera.as_ref();
        Self {
            heights: of.card.marker.iter().map(|m| m.at[2]).collect(),
            painted: of.card.marker.iter().map(|m| [m.at[0], m.at[1]]).collect(),
            length: of.card.length,
            plane: camera.map_or(0.0, |c| c.plane.height),
            grid: camera.and_then(|c| c.plane.grid).filter(|_| of.made_elsewhere().is_none()),
            readout: camera.map_or(0.0, |c| c.readout),
            water: of.card.water.clone().filter(|_| of.trial.medium == Medium::Water),
            first_frame: of.trial.first_frame,
            space: elsewhere::Card::of(of),
        }
    }
}

impl Stage for Markers {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Maybe<Camera>, Maybe<Tracks>);
    type Makes = records::Markers;
    const DESCRIPTION: &'static str = "pixels are projected to metres";
    const VERSION: u32 = 5;

    fn raw(of: &Trial) -> Vec<RawFile> {
        let space = of.in_space().map(|(tracks, _)| RawFile::new(elsewhere::WORD, &of.card.name, &tracks.file));
        let film = of.film().filter(|_| of.in_space().is_none());
        space.into_iter().chain(film).collect()
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        (Maybe(camera), Maybe(tracks)): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::Markers> {
        let film = tracks.as_ref().map(|tracks| tracks.time.clone());
        let (Some(camera), Some(tracks), None) = (camera, tracks, &card.space) else {
            return elsewhere::markers_in_space(card.space.as_ref(), film.as_deref(), set.mark_sigma, context);
        };
        let calibrated = RefractiveCamera { lens: camera.lens, pose: camera.pose, water: card.refracting_water() };
        let film_pose = film_pose(card, &calibrated, context)?;
        let pose_in_film = |s: &FilmPose| Pose { rotation: s.rotation, translation: s.translation_m };
        let pose = film_pose.as_ref().map_or(calibrated.pose, pose_in_film);
        let camera_model = RefractiveCamera { pose, ..calibrated };
        let shutter = Shutter { readout: card.readout, height: camera.size_px[1] };
        let heights = card.heights.clone();
        let positions = marker_positions(&camera_model, &shutter, &tracks, &heights)?;
        let info = Film::open(&context.path("video")?)?.info();
        picture_size::check(camera.size_px, [info.width, info.height])
            .map_err(|e| Diagnostic::from(e).while_doing(context.display_path("video")))?;
        let shown = |((path, painted), at): ((&Path, &Point2), &Vec<Point2>)| (path.name.clone(), *painted, at[0]);
        let rest_positions: Vec<_> = tracks.markers.iter().zip(&card.painted).zip(&positions).map(shown).collect();
        lab::rest::check(&context.display_path("video"), &rest_positions, card.length, ShownBy::Film)?;
        let sources = set.uncertainty_sources(&camera);
        let covariance =
            |(path, height): (&Path, &Metre)| carry::marker_covariances(&camera_model, path, *height, &sources);
        let covariances = tracks.markers.iter().zip(&heights).map(covariance);
        let (spreads, parts): (Vec<_>, Vec<CovarianceParts>) =
            covariances.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        let uncorrected = without_corrections(&camera_model, &shutter, &heights, card.plane);
        let effect = |(correction, camera_model, shutter, heights): UncorrectedModel| {
            let uncorrected = marker_positions(&camera_model, &shutter, &tracks, &heights)?;
            Ok(effect_of_correction(correction, &positions, &uncorrected))
        };
        let left_out = uncorrected.into_iter().map(effect).collect::<Result<_>>()?;
        let named = tracks.markers.iter().zip(positions).zip(spreads);
        let markers = named.map(|((path, at), spread)| Path { name: path.name.clone(), at, spread }).collect();
        Ok(records::Markers { time: tracks.time, markers, parts, left_out, stand: film_pose })
    }
}

impl Settings {
    fn uncertainty_sources(&self, camera: &Camera) -> UncertaintySources {
        UncertaintySources {
            shared: Shared::new(&camera.covariance, [self.surface_sigma, self.index_sigma, self.height_sigma]),
            ripple: self.ripple,
            mark: self.mark_sigma,
        }
    }
}

impl Card {
    /// The lines under the specimen.
    fn line_grid(&self) -> Option<Grid> {
        self.grid.map(|pitch| Grid { pitch, height: self.plane })
    }

    fn refracting_water(&self) -> Option<Water> {
        self.water.as_ref().map(|w| Water { surface: w.surface, index: w.index })
    }
}

/// The camera pose in the film's first frame.
fn film_pose(card: &Card, calibrated: &RefractiveCamera, context: &dyn StageContext) -> Result<Option<FilmPose>> {
    let Some(grid) = card.line_grid() else { return Ok(None) };
    let Some(frame) = Film::open(&context.path("video")?)?.nth(card.first_frame) else { return Ok(None) };
    let frame = frame?;
    let grid_pose = grid::find_pose(&frame.gray, calibrated, &grid);
    Ok(grid_pose.map(|grid_pose| FilmPose {
        rotation: grid_pose.pose.rotation,
        translation_m: grid_pose.pose.translation,
        pieces: grid_pose.segments,
        off_m: grid_pose.rms_error,
        moved_m: vec3::norm(vec3::sub(grid_pose.pose.centre(), calibrated.pose.centre())),
    }))
}

/// Every marker in every frame, m, at the frame's own time.
fn marker_positions(
    camera_model: &RefractiveCamera,
    shutter: &Shutter,
    tracks: &Tracks,
    heights: &[Metre],
) -> Result<Vec<Vec<Point2>>> {
    let marker_path = |(path, height): (&Path, &Metre)| {
        let intersections = path.at.iter().enumerate().map(|(frame, &pixel)| {
            camera_model.intersect(pixel, *height).ok_or_else(|| no_ray(&path.name, frame, pixel))
        });
        let read_times: Vec<Second> =
            tracks.time.iter().zip(&path.at).map(|(t, [_, v])| t + shutter.row_delay(*v)).collect();
        Ok(shutter::at_times(&tracks.time, &read_times, &intersections.collect::<Result<Vec<_>>>()?))
    };
    tracks.markers.iter().zip(heights).map(marker_path).collect()
}

/// The name of a correction, and the camera model, shutter and heights without it.
type UncorrectedModel = (&'static str, RefractiveCamera, Shutter, Vec<Metre>);

/// The camera model without each of the corrections of the trial.
fn without_corrections(
    camera_model: &RefractiveCamera,
    shutter: &Shutter,
    heights: &[Metre],
    plane: Metre,
) -> Vec<UncorrectedModel> {
    let lens = Lens {
        fx: camera_model.lens.fx,
        fy: camera_model.lens.fy,
        cx: camera_model.lens.cx,
        cy: camera_model.lens.cy,
        ..Lens::default()
    };
    let mut omitted = vec![
        ("parallax", *camera_model, *shutter, vec![plane; heights.len()]),
        ("distortion", RefractiveCamera { lens, ..*camera_model }, *shutter, heights.to_vec()),
    ];
    if camera_model.water.is_some() {
        omitted.push(("refraction", RefractiveCamera { water: None, ..*camera_model }, *shutter, heights.to_vec()));
    }
    if shutter.readout > 0.0 {
        omitted.push(("rolling_shutter", *camera_model, Shutter { readout: 0.0, ..*shutter }, heights.to_vec()));
    }
    omitted
}

/// Difference of positions and displacements without a correction from those with it.
fn effect_of_correction(correction: &str, corrected: &[Vec<Point2>], uncorrected: &[Vec<Point2>]) -> OmittedCorrection {
    let (mut position, mut motion, mut count) = (0.0, 0.0, 0.0_f64);
    for (corrected, uncorrected) in corrected.iter().zip(uncorrected) {
        let differences: Vec<Point2> =
            corrected.iter().zip(uncorrected).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        for d in &differences {
            position += d[0] * d[0] + d[1] * d[1];
            motion += (d[0] - differences[0][0]).powi(2) + (d[1] - differences[0][1]).powi(2);
            count += 1.0;
        }
    }
    let root = |sum: f64| (sum / count.max(1.0)).sqrt();
    OmittedCorrection { correction: correction.into(), place_m: root(position), motion_m: root(motion) }
}

fn no_ray(marker: &str, frame: usize, pixel: Point2) -> Diagnostic {
    Diagnostic::new(
        format!(
            "marker `{marker}` at ({:.1}, {:.1}) px in frame {frame} meets no point of the plane",
            pixel[0], pixel[1]
        ),
        "the calibrated lens has no ray there, or the ray does not meet the plane",
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
        let found = effect_of_correction("parallax", &whole, &other);
        assert!((found.place_m - 0.5).abs() < 1e-15 && found.motion_m < 1e-15);
    }
}
