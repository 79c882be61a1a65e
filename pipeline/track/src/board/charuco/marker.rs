//! One marker: its bits, read in a dark quadrilateral.

use super::dictionary::Dictionary;
use super::quads::{Quad, distance};
use crate::Gray;
use crate::calibrate::homography::{homography, map_point};
use nalgebra::Matrix3;
use si::Point2;

/// A marker that was read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marker {
    pub(super) number: usize,
    /// Its corners, px, clockwise from the upper left one as it is printed.
    pub(super) corners: Quad,
}

/// Cells of the border that may be light, as a share: a reflection, a finger.
const LIGHT_BORDER: f64 = 0.15;
/// Least difference of black and white, grey levels.
const LEAST_CONTRAST: f64 = 15.0;
/// Where white is measured, in cells outside the border: the white margin of an OpenCV board is about a cell wide.
const OUTSIDE: f64 = 0.4;
/// Places in a cell that its level is the mean of, in cells from its middle.
const SAMPLES: [Point2; 5] = [[0.0, 0.0], [-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]];

/// The unit square, clockwise as seen.
pub(super) const UNIT: Quad = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// The marker in a quadrilateral; `codes` are those that may occur.
pub(super) fn read_marker(picture: &Gray, quad: &Quad, dictionary: Dictionary, codes: &[u64]) -> Option<Marker> {
    let bits = read_bits(picture, quad, dictionary.side)?;
    let identified = dictionary.identify_marker(bits, codes)?;
    let corners = std::array::from_fn(|k| quad[(k + identified.quarter_turns) % 4]);
    Some(Marker { number: identified.number, corners })
}

/// The bits inside the border, rows from the quadrilateral's first corner on; none where the border is not black on white.
pub(super) fn read_bits(picture: &Gray, quad: &Quad, side: usize) -> Option<u64> {
    let map = homography(&UNIT, quad)?;
    let cells = side + 2;
    let margin = OUTSIDE / cells as f64;
    if !quad.iter().all(|corner| picture.holds_with_margin(*corner, 2.0 + 2.0 * margin * distance(quad[0], quad[2]))) {
        return None;
    }
    let level = |row: usize, column: usize| cell_level(picture, &map, cells, [column, row]);
    let is_border = |k: &usize| [k / cells, k % cells].iter().any(|place| *place == 0 || *place == cells - 1);
    let border: Vec<f64> = (0..cells * cells).filter(is_border).map(|k| level(k / cells, k % cells)).collect();
    let black = median(border.clone());
    let white = median(margin_levels(picture, &map, cells, margin));
    // From the border and the margin: a threshold from all cells, as Otsu's, has no white to go by in a marker whose
    // bits are almost all black.
    let middle = 0.5 * (black + white);
    let light = border.iter().filter(|level| **level > middle).count();
    if white - black < LEAST_CONTRAST || light as f64 > LIGHT_BORDER * border.len() as f64 {
        return None;
    }
    let bit = |k: usize| u64::from(level(1 + k / side, 1 + k % side) > middle);
    Some((0..side * side).fold(0, |bits, k| bits << 1 | bit(k)))
}

fn cell_level(picture: &Gray, map: &Matrix3<f64>, cells: usize, [column, row]: [usize; 2]) -> f64 {
    let coordinate = |cell: usize, offset: f64| (cell as f64 + 0.5 + offset) / cells as f64;
    let level =
        |[x, y]: Point2| picture.interpolated_level(map_point(map, [coordinate(column, x), coordinate(row, y)]));
    SAMPLES.map(level).iter().sum::<f64>() / SAMPLES.len() as f64
}

/// Levels around the marker, `margin` outside its unit square.
fn margin_levels(picture: &Gray, map: &Matrix3<f64>, cells: usize, margin: f64) -> Vec<f64> {
    let cell_centre = |k: usize| (k as f64 + 0.5) / cells as f64;
    let margin_points = |k: usize| {
        [
            [cell_centre(k), -margin],
            [cell_centre(k), 1.0 + margin],
            [-margin, cell_centre(k)],
            [1.0 + margin, cell_centre(k)],
        ]
    };
    (0..cells).flat_map(margin_points).map(|point| picture.interpolated_level(map_point(map, point))).collect()
}

fn median(mut levels: Vec<f64>) -> f64 {
    levels.sort_by(f64::total_cmp);
    levels[levels.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A marker of 6 × 6 cells of 9 px at (30, 20), as printed.
    fn printed(code: u64) -> Gray {
        let cell = |x: usize, from: usize| (x >= from && x < from + 54).then(|| (x - from) / 9);
        Gray::from_fn(120, 100, |x, y| match (cell(x, 30), cell(y, 20)) {
            (Some(i @ 1..=4), Some(j @ 1..=4)) if code >> (15 - 4 * (j - 1) - (i - 1)) & 1 == 1 => 190.0,
            (Some(_), Some(_)) => 60.0,
            _ => 190.0,
        })
    }

    #[test]
    fn a_marker_is_read_with_its_upper_left_corner_first() {
        let dictionary = Dictionary::opencv(4, 50);
        let codes = dictionary.marker_codes(50);
        let quad: Quad = [[29.5, 19.5], [83.5, 19.5], [83.5, 73.5], [29.5, 73.5]];
        for start in 0..4 {
            let turned = std::array::from_fn(|k| quad[(k + start) % 4]);
            let marker = read_marker(&printed(codes[7]), &turned, dictionary, &codes).unwrap();
            assert_eq!(marker, Marker { number: 7, corners: quad });
        }
    }

    #[test]
    fn a_quadrilateral_without_a_border_on_white_ground_is_no_marker() {
        let dictionary = Dictionary::opencv(4, 50);
        let codes = dictionary.marker_codes(50);
        let quad: Quad = [[29.5, 19.5], [83.5, 19.5], [83.5, 73.5], [29.5, 73.5]];
        assert_eq!(read_marker(&Gray::filled(120, 100, 60), &quad, dictionary, &codes), None);
        assert_eq!(read_marker(&printed(0xffff), &quad.map(|p| p.map(|c| c - 9.0)), dictionary, &codes), None);
        // a picture that ends at the marker
        assert_eq!(read_marker(&printed(codes[7]).crop(30, 20, 54, 54), &quad, dictionary, &codes), None);
    }
}
