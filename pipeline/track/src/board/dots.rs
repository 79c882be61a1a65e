//! Detection of a board of dark dots in a square grid: their centres, to a fraction of a pixel, in one order.
//!
//! The board's frame: dot (i, j) lies at (i · pitch, j · pitch, 0); i runs along the columns, j along the rows, and z points from
//! the printed side towards the camera. The board is symmetric under a half turn: the first dot is the one of the two ends
//! that lies nearer the picture's upper left corner (least u + v).
//!
//! A dot in perspective is an ellipse whose centre is not quite the dot's: at a tilt of 30°, dots of 5 mm at 0.4 m are off by
//! 0.02 px of 1000 px focal length, far below the accuracy that a lens needs.

use si::{Metre, Point2, Point3};

use super::dark::dark_patches;
use super::reduced::Reduced;
use super::{BoardError, lattice};
use crate::Gray;
use crate::klt::blob;

/// A board of `columns` × `rows` dots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dots {
    /// Dots along the first axis.
    pub columns: usize,
    /// Dots along the second axis.
    pub rows: usize,
    /// Between the middles of two neighbours, m.
    pub pitch: Metre,
}

impl Dots {
    /// The dots in the board's frame, m: row after row, i fastest.
    pub fn points(&self) -> Vec<Point3> {
        let dot = |i: usize, j: usize| [i as f64 * self.pitch, j as f64 * self.pitch, 0.0];
        (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| dot(i, j))).collect()
    }
}

/// Half the side of the square around a pixel with whose mean it is compared, as a share of the picture's shorter side.
const AROUND: f64 = 0.06;
/// Pixels that a dot has at least.
const LEAST: usize = 16;
/// Share of the picture that it has at most.
const MOST: f64 = 0.01;
/// How far its pixels' number may be from that of the ellipse with its second moments, as a share.
const ROUND: f64 = 0.12;
/// Longest axis of its ellipse against the shortest.
const LONG: f64 = 3.0;
/// Light ground around it that its middle is measured with, px.
const RIM: f64 = 2.5;

/// Finds the dots of `board`, px, in the order of [`Dots::points`].
///
/// # Errors
/// [`BoardError`] when the board's order is not unique, or it is not in the picture as a whole.
pub fn find(picture: &Gray, board: &Dots) -> Result<Vec<Point2>, BoardError> {
    super::check_levels(picture)?;
    let Dots { columns, rows, .. } = *board;
    if columns < 3 || rows < 3 || columns == rows {
        return Err(BoardError::Square { columns, rows });
    }
    let (mut in_grid, mut seen) = (0, 0);
    for places in disc_centres(picture) {
        match lattice::find(&places, columns, rows) {
            Ok(dots) => return Ok(from_upper_left(dots)),
            Err(size) => (in_grid, seen) = (in_grid, seen).max((size, places.len())),
        }
    }
    Err(BoardError::NoDots { columns, rows, in_grid, seen })
}

/// The dots, or the dots from the last on, so that the first is the one nearer the upper left corner.
fn from_upper_left(mut dots: Vec<Point2>) -> Vec<Point2> {
    let first_from_corner = |dots: &[Point2]| dots[0][0] + dots[0][1];
    let last_from_corner = dots[dots.len() - 1][0] + dots[dots.len() - 1][1];
    if last_from_corner < first_from_corner(&dots) {
        dots.reverse();
    }
    dots
}

/// Middles of the dark discs, px, those of typical size first: of a large picture as a reduced copy shows them, then as itself does.
pub(super) fn disc_centres(picture: &Gray) -> impl Iterator<Item = Vec<Point2>> {
    let middle = |disc: &Disc| blob::find_blob(picture, disc.at, disc.radius + RIM).ok().map(|blob| blob.at);
    typical_discs(picture).map(move |discs| discs.iter().filter_map(middle).collect())
}

/// The same to a pixel: the means of their dark pixels.
pub(super) fn rough_centres(picture: &Gray) -> impl Iterator<Item = Vec<Point2>> {
    typical_discs(picture).map(|discs| discs.iter().map(|disc| disc.at).collect())
}

fn typical_discs(picture: &Gray) -> impl Iterator<Item = Vec<Disc>> {
    let reduced = Reduced::of_large_picture(picture);
    let itself = std::iter::once_with(|| find_discs(picture));
    let discs = reduced.map(|reduced| enlarge_discs(find_discs(&reduced.picture), &reduced)).into_iter().chain(itself);
    discs.map(|mut discs| {
        // the board's dots are alike, so the typical one is among them
        discs.sort_by_key(|disc| disc.pixels);
        let typical = discs.get(discs.len() / 2).map_or(0, |disc| disc.pixels);
        discs.sort_by_key(|disc| disc.pixels.abs_diff(typical));
        discs
    })
}

fn enlarge_discs(discs: Vec<Disc>, reduced: &Reduced) -> Vec<Disc> {
    let enlarge =
        |disc: Disc| Disc { at: reduced.to_picture(disc.at), radius: disc.radius * reduced.block as f64, ..disc };
    discs.into_iter().map(enlarge).collect()
}

/// A dark disc, roughly.
struct Disc {
    /// Mean of its pixels, px.
    at: Point2,
    /// Longer half axis, px.
    radius: f64,
    pixels: usize,
}

/// The dark patches of a picture that are ellipses.
fn find_discs(picture: &Gray) -> Vec<Disc> {
    let max_pixels = (MOST * picture.pixels.len() as f64) as usize;
    let half = ((AROUND * picture.width.min(picture.height) as f64) as usize).max(3);
    dark_patches(picture, half).filter_map(|patch| fit_disc(&patch, max_pixels)).collect()
}

/// The disc of these pixels, when they fill the ellipse of their second moments.
fn fit_disc(pixels: &[[usize; 2]], max_pixels: usize) -> Option<Disc> {
    if !(LEAST..=max_pixels).contains(&pixels.len()) {
        return None;
    }
    let count = pixels.len() as f64;
    let centre = [0, 1].map(|k| pixels.iter().map(|p| p[k] as f64).sum::<f64>() / count);
    // a pixel is a square, whose own second moment is 1/12
    let moment = |i: usize, j: usize| {
        let sum: f64 = pixels.iter().map(|p| (p[i] as f64 - centre[i]) * (p[j] as f64 - centre[j])).sum();
        sum / count + if i == j { 1.0 / 12.0 } else { 0.0 }
    };
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let half_difference = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    let [long, short] =
        [0.5 * (xx + yy) + half_difference, 0.5 * (xx + yy) - half_difference].map(|m| 2.0 * m.max(0.0).sqrt());
    let filled = count / (std::f64::consts::PI * long * short);
    let is_disc = (filled - 1.0).abs() < ROUND && long < LONG * short;
    is_disc.then_some(Disc { at: centre, radius: long, pixels: pixels.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixels of an ellipse about (60, 50) whose half axes are given, turned by `turn` (rad).
    fn ellipse([a, b]: [f64; 2], turn: f64) -> Vec<[usize; 2]> {
        let inside = |x: usize, y: usize| {
            let (u, v) = (x as f64 - 60.0, y as f64 - 50.0);
            let (along, across) = (u * turn.cos() + v * turn.sin(), v * turn.cos() - u * turn.sin());
            (along / a).powi(2) + (across / b).powi(2) <= 1.0
        };
        (0..100).flat_map(|y| (0..120).map(move |x| [x, y])).filter(|p| inside(p[0], p[1])).collect()
    }

    #[test]
    fn the_dots_of_a_board_stand_row_after_row_at_its_pitch() {
        let points = Dots { columns: 3, rows: 2, pitch: 0.01 }.points();
        assert_eq!(points.len(), 6);
        assert_eq!((points[1], points[3], points[5]), ([0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.02, 0.01, 0.0]));
    }

    #[test]
    fn an_ellipse_is_a_disc_with_its_middle_and_its_longer_half_axis() {
        for (axes, turn) in [([12.0, 12.0], 0.0), ([20.0, 9.0], 0.0), ([9.0, 20.0], 0.0), ([20.0, 9.0], 0.7)] {
            let pixels = ellipse(axes, turn);
            let found = fit_disc(&pixels, 10_000).unwrap();
            assert!((found.at[0] - 60.0).abs() < 0.05 && (found.at[1] - 50.0).abs() < 0.05, "{:?}", found.at);
            let long = axes[0].max(axes[1]);
            assert!((found.radius / long - 1.0).abs() < 0.02 && found.pixels == pixels.len(), "{}", found.radius);
        }
    }

    #[test]
    fn what_is_long_small_large_or_no_ellipse_is_no_disc() {
        assert!(fit_disc(&ellipse([30.0, 9.0], 0.3), 10_000).is_none());
        assert!(fit_disc(&ellipse([2.0, 2.0], 0.0), 10_000).is_none());
        assert!(fit_disc(&ellipse([12.0, 12.0], 0.0), 400).is_none());
        let cross: Vec<[usize; 2]> =
            (0..900).map(|i| [i % 30, i / 30]).filter(|p| p[0] / 10 == 1 || p[1] / 10 == 1).collect();
        assert!(fit_disc(&cross, 10_000).is_none());
        // of 16 pixels it is large enough
        let least: Vec<[usize; 2]> = (0..16).map(|i| [i % 4, i / 4]).collect();
        assert!(fit_disc(&least, 16).is_some());
    }
}
