//! Markers that another instrument measured in space: turned into the CAD frame, with no lens between.
//!
//! Stands on: the places of `lab`. Never knows: a pixel.

use std::path::Path as FilePath;

use lab::card::{Axes, Tracks};
use serde_json::{Value, json};
use si::{Metre, Point2, Point3, Second, vec3};

use crate::fault::{Fault, Outcome};
use crate::records::{Markers, Parts, Path};
use crate::stage::Desk;
use crate::subject::Trial;

/// The word for the file.
pub const WORD: &str = "places";
/// A marker may be this far from where it was painted in the first frame, as a share of the specimen's length: a slip of unit,
/// origin or axis is farther.
const ASTRAY: f64 = 0.2;

/// What the card says of the file.
pub fn card(of: &Trial) -> Value {
    let said = |(tracks, axes): (&Tracks, &Axes)| {
        json!({
            "sigma": tracks.sigma,
            "axes": [axes.origin, axes.x, axes.z],
            "start": axes.start,
            "painted": of.card.marker.iter().map(|m| json!([m.name, m.at])).collect::<Vec<_>>(),
            "length": of.card.length,
        })
    };
    of.in_space().map_or(Value::Null, said)
}

/// The card's markers in the file, on the film's clock, whose frames are at `film` (s); `mark` (m) is how well a mark's middle
/// stands for its point.
///
/// # Errors
/// A [`Fault`] when the file cannot be used, lies beside the film, or its markers are not where they were painted.
pub fn places(of: &Trial, film: &[Second], mark: Metre, desk: &dyn Desk) -> Outcome<Markers> {
    let Some((tracks, axes)) = of.in_space() else {
        let what = "there is neither a camera nor places in space";
        return Err(Fault::new(
            what,
            "no tracks on the card have [tracks.space]",
            "report it: the camera was not made",
        ));
    };
    let told = desk.place(WORD);
    let file = FilePath::new(&told);
    let space = lab::space::read(&desk.bytes(WORD)?, file).map_err(Fault::from_tool)?;
    let time: Vec<Second> = space.time.iter().map(|t| axes.start + t).collect();
    meets(&time, film, &told)?;
    let (noise, mark) = ([tracks.sigma.powi(2), 0.0, tracks.sigma.powi(2)], [mark.powi(2), 0.0, mark.powi(2)]);
    let mut markers = Vec::new();
    for marker in &of.card.marker {
        let seen = space.whole(&marker.name, file).map_err(Fault::from_tool)?;
        let at: Vec<Point2> = seen.iter().map(|p| in_cad(axes, *p)).collect();
        painted(&told, &marker.name, at[0], [marker.at[0], marker.at[1]], of.card.length)?;
        let spread = vec![[0, 1, 2].map(|k| noise[k] + mark[k]); at.len()];
        markers.push(Path { name: marker.name.clone(), at, spread });
    }
    let parts = Parts { noise: vec![noise; time.len()], shared: vec![mark; time.len()] };
    Ok(Markers { parts: vec![parts; markers.len()], time, markers, left_out: Vec::new(), stand: None })
}

/// x and y of the CAD frame, m, of a place in the file's axes (m).
fn in_cad(axes: &Axes, place: Point3) -> Point2 {
    let from = vec3::sub(place, axes.origin);
    [vec3::dot(from, axes.x), vec3::dot(from, vec3::cross(axes.z, axes.x))]
}

/// The file and the film have a moment in common.
fn meets(time: &[Second], film: &[Second], told: &str) -> Outcome<()> {
    let span = |t: &[Second]| (t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0));
    let ((a, b), (from, to)) = (span(time), span(film));
    if a <= to && b >= from {
        return Ok(());
    }
    Err(Fault::new(
        format!("{told} runs from {a:.3} to {b:.3} s of the film's clock, the film from {from:.3} to {to:.3} s"),
        "the lamp in the film ties both to the logs, so they must overlap",
        "correct start of [tracks.space] on the card: the film's time of the file's first frame, in s",
    ))
}

fn painted(told: &str, name: &str, [x, y]: Point2, at: Point2, length: Metre) -> Outcome<()> {
    let (away, limit) = ((x - at[0]).hypot(y - at[1]), ASTRAY * length);
    if away <= limit {
        return Ok(());
    }
    Err(Fault::new(
        format!(
            "{told} has marker `{name}` at ({x:.4}, {y:.4}) m in its first frame; it is painted at ({:.4}, {:.4}) m",
            at[0], at[1]
        ),
        format!("that is {away:.4} m away; the limit is {limit:.4} m, a fifth of the specimen's length"),
        "check the file's unit, and origin, x and z of [tracks.space] on the card",
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
    fn millimetres_taken_for_metres_are_too_far_from_the_paint() {
        assert!(painted("a.c3d", "m1", [0.052, 0.001], [0.05, 0.0], 0.1).is_ok());
        assert!(painted("a.c3d", "m1", [5e-5, 0.0], [0.05, 0.0], 0.1).is_err());
    }
}
