//! Markers that another instrument measured in three dimensions, transformed into the CAD frame without a camera model.

use std::path::Path as FilePath;

use lab::{card::Axes, rest::ShownBy};
use serde::Serialize;
use si::{Metre, Point2, Point3, Second, vec3};
use track::imported::{self, ImportedTrack, Limits};

use diagnostics::{Diagnostic, Result};
use records::subject::Trial;
use records::{CovarianceParts, Markers, Path};
use workflow::stage::StageContext;

/// The name of the file in messages.
pub(crate) const WORD: &str = "places";
/// Largest step of a marker in a frame, as a fraction of the specimen's length, of captures of so many frames a second at least: a tail
/// that flaps moves by a quarter. And the largest change of the distance of neighbours, as a share of it.
const STEP: f64 = 0.35;
const FAST: f64 = 20.0;
const NEIGHBOURS: f64 = 0.35;
const SOURCE: &str = "of the specimen's length and of the distance";

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    sigma: Metre,
    axes: Axes,
    painted: Vec<Painted>,
    length: Metre,
}

/// A marker and its position on the card, m.
#[derive(Debug, Serialize)]
struct Painted {
    name: String,
    at: Point3,
}

impl Card {
    /// The card's entry of a file of positions in space; none where it names none.
    pub fn of(trial: &Trial) -> Option<Self> {
        let painted = |m: &lab::card::Marker| Painted { name: m.name.clone(), at: m.at };
        trial.in_space().map(|(tracks, axes)| Self {
            sigma: tracks.sigma,
            axes: axes.clone(),
            painted: trial.card.marker.iter().map(painted).collect(),
            length: trial.card.length,
        })
    }
}

/// The card's markers in the file, on the clock of the film, whose frames are at `film` (s), or of the log where nothing was filmed;
/// `mark` (m) is the standard deviation of a marker's centre against its material point.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be used, does not overlap the film, or its markers are not at their card positions.
pub(crate) fn markers_in_space(
    card: Option<&Card>,
    film: Option<&[Second]>,
    mark: Metre,
    context: &dyn StageContext,
) -> Result<Markers> {
    let Some(Card { sigma, axes, painted, length }) = card else {
        let no_source = "there is neither a camera nor positions in space";
        return Err(Diagnostic::new(
            no_source,
            "no tracks on the card have [tracks.space]",
            "report it: the camera was not made",
        ));
    };
    let file_path = context.display_path(WORD);
    let file = FilePath::new(&file_path);
    let space = lab::space::read(&context.bytes(WORD)?, file)?;
    let time: Vec<Second> = space.time.iter().map(|t| axes.start + t).collect();
    film.map_or(Ok(()), |film| check_overlap(&time, film, &file_path))?;
    let (noise, mark) = ([sigma.powi(2), 0.0, sigma.powi(2)], [mark.powi(2), 0.0, mark.powi(2)]);
    let spread = [0, 1, 2].map(|k| noise[k] + mark[k]);
    let track = |marker: &Painted| {
        let positions = space.complete(&marker.name, file)?;
        let places = positions.iter().map(|position| (Some(in_cad(axes, *position)), spread));
        Ok(ImportedTrack::new(&marker.name, places))
    };
    let mut tracks = painted.iter().map(track).collect::<Result<Vec<_>>>()?;
    let shown =
        |(Painted { name, at }, track): (&Painted, &ImportedTrack)| (name.clone(), [at[0], at[1]], track.seen[0].at);
    let rest_positions: Vec<_> = painted.iter().zip(&tracks).map(shown).collect();
    lab::rest::check(&file_path, &rest_positions, *length, ShownBy::Space)?;
    let step = if time.windows(2).all(|t| FAST * (t[1] - t[0]) < 1.001) { STEP * length } else { f64::INFINITY };
    let limits = Limits { step, neighbour_distance: NEIGHBOURS, longest_gap: 0, unit: "m", source: SOURCE };
    imported::check_tracks(&mut tracks, &limits).map_err(|e| Diagnostic::from(e).in_file(file))?;
    let markers: Vec<Path> = tracks.iter().map(Path::from_import).collect();
    let parts = CovarianceParts { noise: vec![noise; time.len()], shared: vec![mark; time.len()] };
    Ok(Markers { parts: vec![parts; markers.len()], time, markers, left_out: Vec::new(), stand: None })
}

/// x and y of the CAD frame, m, of a place in the file's axes (m).
fn in_cad(axes: &Axes, position: Point3) -> Point2 {
    let relative = vec3::sub(position, axes.origin);
    [vec3::dot(relative, axes.x), vec3::dot(relative, vec3::cross(axes.z, axes.x))]
}

/// Checks that the file and the film overlap in time.
fn check_overlap(time: &[Second], film: &[Second], file_path: &str) -> Result<()> {
    let span = |t: &[Second]| (t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0));
    let ((a, b), (from, to)) = (span(time), span(film));
    if a <= to && b >= from {
        return Ok(());
    }
    Err(Diagnostic::new(
        format!("{file_path} runs from {a:.3} to {b:.3} s of the film's clock, the film from {from:.3} to {to:.3} s"),
        "the lamp in the film ties both to the logs, so they must overlap",
        "correct start of [tracks.space] on the card: the film's time of the file's first frame, in s",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_turned_into_the_axes_of_the_cad() {
        // the file's y is up; the CAD's x runs along the file's −x
        let axes = Axes { start: 0.0, origin: [0.5, 0.1, 0.0], x: [-1.0, 0.0, 0.0], z: [0.0, 1.0, 0.0] };
        let [x, y] = in_cad(&axes, [0.45, 0.12, 0.03]);
        assert!((x - 0.05).abs() < 1e-15 && (y - 0.03).abs() < 1e-15, "{x} {y}");
    }

    #[test]
    fn a_file_that_only_touches_the_film_overlaps_it_and_one_beside_it_does_not() {
        let film = [2.0, 2.5, 3.0];
        for [from, to] in [[0.0, 2.0], [3.0, 4.0], [2.2, 2.4], [1.0, 5.0]] {
            assert!(check_overlap(&[from, to], &film, "a.c3d").is_ok(), "{from} to {to}");
        }
        for [from, to] in [[0.0, 1.99], [3.01, 4.0]] {
            assert!(
                check_overlap(&[from, to], &film, "a.c3d").unwrap_err().to_string().contains("the film from 2.000")
            );
        }
    }
}
