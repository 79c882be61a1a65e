//! The margin of a board: light ground all around it. A board that ends at something dark, or at the picture's edge, may go on there.

use crate::Gray;
use crate::calibrate::homography::{homography, map_point};
use nalgebra::Matrix3;
use si::Point2;

/// Places along each side of a board at which its margin is looked at, and the part of them that is light.
const MARGIN_PLACES: usize = 12;
const MARGIN: f64 = 0.8;
/// Share of the contrast that a light margin has, at least.
const MARGIN_LEVEL: f64 = 0.6;

/// Whether there is light ground `beyond` the outer points of a square grid (rows of `across`), in steps of it.
pub(super) fn grid_margin(picture: &Gray, (points, across): (&[Point2], usize), beyond: f64) -> bool {
    let cells: Vec<Point2> = (0..points.len()).map(|k| [(k % across) as f64, (k / across) as f64]).collect();
    let [right, bottom] = [across, points.len() / across].map(|count| count as f64 - 1.0 + beyond);
    let middles = cells.iter().map(|[x, y]| [x + 0.5, y + 0.5]).collect::<Vec<_>>();
    homography(&cells, points).is_some_and(|map| {
        let levels: Vec<f64> = middles.iter().chain(&cells).filter_map(|cell| level_at(picture, &map, *cell)).collect();
        has_light_margin(picture, &map, ([-beyond, right], [-beyond, bottom]), &levels)
    })
}

pub(super) fn level_at(picture: &Gray, map: &Matrix3<f64>, cell: Point2) -> Option<f64> {
    let place = map_point(map, cell);
    picture.holds_with_margin(place, 1.0).then(|| picture.interpolated_level(place))
}

/// Whether the sides of a rectangle (from left to right, from top to bottom) are light, where `levels` are those of dark and light parts of
/// the board; what lies out of the picture is not.
pub(super) fn has_light_margin(
    picture: &Gray,
    map: &Matrix3<f64>,
    ([left, right], [top, bottom]): (Point2, Point2),
    levels: &[f64],
) -> bool {
    let (dark, light) = levels.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(d, l), v| (d.min(*v), l.max(*v)));
    let is_light =
        |cell: Point2| level_at(picture, map, cell).is_some_and(|v| v - dark > MARGIN_LEVEL * (light - dark));
    let between = |a: f64, b: f64, k: usize| a + (b - a) * (k as f64 + 0.5) / MARGIN_PLACES as f64;
    let sides: [&dyn Fn(usize) -> Point2; 4] = [
        &|k| [between(left, right, k), top],
        &|k| [between(left, right, k), bottom],
        &|k| [left, between(top, bottom, k)],
        &|k| [right, between(top, bottom, k)],
    ];
    let light_places = |side: &dyn Fn(usize) -> Point2| (0..MARGIN_PLACES).filter(|k| is_light(side(*k))).count();
    sides.into_iter().all(|side| light_places(side) as f64 >= MARGIN * MARGIN_PLACES as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_that_is_covered_on_one_side_has_no_margin_there() {
        let is_dark = |x: usize, y: usize| {
            (40..160).contains(&x) && (40..120).contains(&y) && (x / 20 + y / 20).is_multiple_of(2)
        };
        let corners: Vec<Point2> =
            (0..15).map(|k| [59.5 + 20.0 * (k % 5) as f64, 59.5 + 20.0 * (k / 5) as f64]).collect();
        let shown = |covered_from: usize| {
            let level = |x: usize, y: usize| if is_dark(x, y) || y >= covered_from { 30.0 } else { 220.0 };
            grid_margin(&Gray::from_fn(200, 160, level), (&corners, 5), 1.3)
        };
        assert!(shown(160) && !shown(122));
        // and where the picture ends
        let cut = Gray::from_fn(162, 160, |x, y| if is_dark(x, y) { 30.0 } else { 220.0 });
        assert!(!grid_margin(&cut, (&corners, 5), 1.3));
    }
}
