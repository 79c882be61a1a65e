//! Markers at rest: where the first frame of a trial shows them, against the places of the card.

use si::{Metre, Point2};

use diagnostics::{Diagnostic, Result};

/// A marker at rest: its name, x and y of its place on the card, and where the first frame shows it, m.
pub type AtRest = (String, Point2, Point2);

/// What showed the markers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownBy {
    /// A film, by its calibrated camera.
    Film,
    /// A film, by a camera that is known from one view of the board.
    FilmRoughly,
    /// Another instrument, in axes of its own.
    Space,
}

impl ShownBy {
    /// Largest distance of a marker from its place on the card, as a fraction of the specimen's length. A wrong unit, origin or axis gives
    /// more than a fifth; a film that is cut or turned against its calibration more than a tenth, a specimen that hangs by its own weight less.
    fn limit_fraction(self) -> f64 {
        match self {
            Self::Film => 0.1,
            Self::FilmRoughly => 0.15,
            Self::Space => 0.2,
        }
    }

    /// Largest departure of the distances between neighbours from those of the card, no unit: marks are painted to half a millimetre, and a body
    /// that hangs by its weight is as long as before. One view of the board leaves the distance of the camera open by 15 %.
    fn scale_limit(self) -> f64 {
        match self {
            Self::Film | Self::Space => 0.08,
            Self::FilmRoughly => 0.2,
        }
    }

    fn corrective_action(self) -> &'static str {
        match self {
            Self::Film | Self::FilmRoughly => {
                "check that the film is neither cut, scaled, mirrored nor turned against the calibration, [camera.plane] on the card, and the order of the markers"
            }
            Self::Space => "check the file's unit, and origin, x and z of [tracks.space] on the card",
        }
    }
}

/// Whether every marker is near its place on the card, for a specimen of this length (m); `file` shows them.
///
/// # Errors
/// A [`Diagnostic`] with the marker that is farthest.
pub fn check(file: &str, markers: &[AtRest], length: Metre, source: ShownBy) -> Result<()> {
    let distance = |(_, painted, shown): &AtRest| (shown[0] - painted[0]).hypot(shown[1] - painted[1]);
    let limit = source.limit_fraction() * length;
    let farthest = markers.iter().filter(|marker| distance(marker) > limit || distance(marker).is_nan());
    let Some(marker) = farthest.max_by(|a, b| distance(a).total_cmp(&distance(b))) else {
        return check_scale(file, markers, source);
    };
    let (name, [u, v], [x, y]) = marker;
    let defect = format!(
        "{file} has marker `{name}` at ({x:.4}, {y:.4}) m in its first frame; it is painted at ({u:.4}, {v:.4}) m"
    );
    let reason = format!(
        "that is {:.4} m away; the limit is {limit:.4} m, {} of the specimen's length",
        distance(marker),
        source.limit_fraction()
    );
    Err(Diagnostic::new(defect, reason, source.corrective_action()))
}

/// Sum of the distances of neighbours below which the errors of the paint are seen, m.
const SHORTEST: Metre = 0.02;

/// Whether the markers lie as far from each other as on the card: a film that was enlarged, or taken from another distance, has them near their
/// places about its middle.
fn check_scale(file: &str, markers: &[AtRest], source: ShownBy) -> Result<()> {
    let between = |a: Point2, b: Point2| (a[0] - b[0]).hypot(a[1] - b[1]);
    let nearest = |k: usize| {
        let others = (0..markers.len()).filter(move |other| *other != k);
        others.min_by(|a, b| between(markers[k].1, markers[*a].1).total_cmp(&between(markers[k].1, markers[*b].1)))
    };
    let pairs: Vec<(usize, usize)> = (0..markers.len()).filter_map(|k| Some((k, nearest(k)?))).collect();
    let painted: Metre = pairs.iter().map(|(a, b)| between(markers[*a].1, markers[*b].1)).sum();
    let shown: Metre = pairs.iter().map(|(a, b)| between(markers[*a].2, markers[*b].2)).sum();
    let limit = source.scale_limit();
    if painted < SHORTEST || (shown / painted - 1.0).abs() <= limit {
        return Ok(());
    }
    let defect = format!(
        "{file} has neighbouring markers {:.3} times as far apart in its first frame as the card",
        shown / painted
    );
    let reason = format!("the limit is {:.2} to {:.2}", 1.0 - limit, 1.0 + limit);
    Err(Diagnostic::new(defect, reason, source.corrective_action()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAINTED: [Point2; 3] = [[0.02, 0.0], [0.05, 0.0], [0.08, 0.0]];

    /// The refusal of markers that a film shows elsewhere; the specimen is 0.1 m long.
    fn shown(place: impl Fn(Point2) -> Point2, by: ShownBy) -> Option<String> {
        let names = ["m1", "m2", "m3"].map(str::to_owned);
        let markers = [0, 1, 2].map(|k| (names[k].clone(), PAINTED[k], place(PAINTED[k])));
        check("film.mp4", &markers, 0.1, by).err().map(|refused| refused.to_string())
    }

    #[test]
    fn a_film_that_is_cut_mirrored_or_turned_is_refused_with_the_marker_that_is_farthest() {
        assert_eq!(shown(|[x, y]| [x + 2e-3, y - 5e-3], ShownBy::Film), None, "it hangs by its weight");
        let cut = shown(|[x, y]| [x + 0.018, y], ShownBy::Film).unwrap();
        assert!(cut.contains("0.0180 m away; the limit is 0.0100 m, 0.1 of"), "{cut}");
        let mirrored = shown(|[x, y]| [0.12 - x, y], ShownBy::Film).unwrap();
        assert!(mirrored.contains("marker `m1` at (0.1000, 0.0000) m"), "{mirrored}");
        assert!(shown(|[x, y]| [-y, x], ShownBy::Film).is_some());
        assert!(shown(|[x, y]| [f64::NAN * x, y], ShownBy::Film).is_some());
    }

    #[test]
    fn a_film_that_is_enlarged_about_its_middle_is_refused_with_its_scale() {
        let enlarged = |scale: f64| shown(move |[x, y]| [0.05 + scale * (x - 0.05), scale * y], ShownBy::Film);
        assert!(enlarged(1.111).unwrap().contains("1.111 times as far apart"));
        assert!(enlarged(0.9).unwrap().contains("0.900 times") && enlarged(1.05).is_none());
        let hanging = |[x, y]: Point2| [0.05 + 0.98 * (x - 0.05), y - 0.2 * (x - 0.05)];
        assert_eq!(shown(hanging, ShownBy::Film), None);
    }

    #[test]
    fn millimetres_taken_for_metres_are_too_far_from_the_card() {
        assert_eq!(shown(|[x, y]| [x + 2e-3, y + 1e-3], ShownBy::Space), None);
        assert!(shown(|[x, y]| [1e-3 * x, 1e-3 * y], ShownBy::Space).unwrap().contains("0.2 of the specimen"));
    }
}
