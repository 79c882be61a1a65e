//! Checks of a film against its calibration: pictures of one size, and markers at rest near their places on the card.

use lab::card::Medium;
use lab::rest::ShownBy;
use si::Point2;
use track::picture_size;
use track::refraction::{RefractiveCamera, Water};
use track::video::Info;

use super::board::RoughCamera;
use super::finding::Finding;
use diagnostics::Diagnostic;
use records::subject::Trial;

/// Whether the pictures of a film are of the calibration's size.
pub(crate) fn size_mismatch(film_path: &str, info: &Info, camera: &RoughCamera) -> Option<Finding> {
    let checked = picture_size::check(camera.size, [info.width, info.height]);
    checked.err().map(|e| Diagnostic::from(e).while_doing(film_path.to_owned()).into())
}

/// Where markers (px, in the order of the card) are in the plane, m; none without a camera, or where a ray meets no plane.
pub(crate) fn marker_positions(subject: &Trial, pixels: &[Point2], camera: &RoughCamera) -> Option<Vec<Point2>> {
    let (lens, pose) = camera.pose?;
    let water = subject.card.water.as_ref().filter(|_| subject.trial.medium == Medium::Water);
    let water = water.map(|w| Water { surface: w.surface, index: w.index });
    let refractive_camera = RefractiveCamera { lens, pose, water };
    // length: a place for each marker of the card
    let seen = subject.card.marker.iter().zip(pixels);
    seen.map(|(marker, pixel)| refractive_camera.intersect(*pixel, marker.at[2])).collect()
}

/// Whether the markers in the first frame (px) are near their places on the card.
pub(crate) fn displaced_marker(
    film_path: &str,
    subject: &Trial,
    pixels: &[Point2],
    camera: &RoughCamera,
) -> Option<Finding> {
    let positions = marker_positions(subject, pixels, camera)?;
    let painted = |(marker, shown): (&lab::card::Marker, &Point2)| {
        let [x, y, _] = marker.at;
        (marker.name.clone(), [x, y], *shown)
    };
    let markers: Vec<_> = subject.card.marker.iter().zip(&positions).map(painted).collect();
    let checked = lab::rest::check(film_path, &markers, subject.card.length, ShownBy::FilmRoughly);
    checked.err().map(Finding::from)
}
