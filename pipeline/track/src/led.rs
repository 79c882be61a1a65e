//! Brightness of a lamp in a picture.

use crate::Gray;
use si::Point2;

/// Mean grey level (0 … 255) of the disc around `centre` (px) of `radius` (px), its edge pixels by their share.
///
/// A disc that leaves the frame is averaged over the part inside; one wholly outside is dark (0).
pub fn brightness(picture: &Gray, centre: Point2, radius: f64) -> f64 {
    let span = |c: f64, size: usize| {
        let first = (c - radius - 1.0).floor().max(0.0) as usize;
        first..((c + radius + 2.0).max(0.0) as usize).min(size)
    };
    let (mut sum, mut weight) = (0.0, 0.0);
    for y in span(centre[1], picture.height) {
        for x in span(centre[0], picture.width) {
            let away = (x as f64 - centre[0]).hypot(y as f64 - centre[1]);
            let share = (radius + 0.5 - away).clamp(0.0, 1.0);
            sum += share * picture.pixel_level(x, y);
            weight += share;
        }
    }
    if weight > 0.0 { sum / weight } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_tells_its_own_level_and_not_its_surroundings() {
        let lamp =
            Gray::from_fn(60, 40, |x, y| if (x as f64 - 30.0).hypot(y as f64 - 20.0) < 9.0 { 200.0 } else { 10.0 });
        assert!((brightness(&lamp, [30.0, 20.0], 6.0) - 200.0).abs() < 1e-9);
        assert!((brightness(&lamp, [8.0, 8.0], 5.0) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn a_disc_over_the_border_is_averaged_inside_and_one_outside_is_dark() {
        let even = Gray::filled(20, 20, 90);
        assert!((brightness(&even, [0.0, 0.0], 5.0) - 90.0).abs() < 1e-9);
        assert_eq!(brightness(&even, [-40.0, 5.0], 5.0), 0.0);
    }
}
