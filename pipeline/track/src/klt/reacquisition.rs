//! Search for a hidden marker: the place of greatest correlation with its first view.
//!
//! Correlation does not depend on brightness and contrast, which change when what covered the marker throws a shadow. Places on other
//! markers are excluded, because all markers look alike.

use super::background::Disc;
use super::template::Template;
use crate::Gray;
use si::{Point2, Radian};

/// Largest search radius, px: a marker that oscillates stays within it for any time.
pub(super) const MAX_RADIUS: f64 = 90.0;
/// Places are tried this far apart, px: a tenth of a marker, from where its middle is found anyway.
const STRIDE: i32 = 3;
/// Pixels of the window that are compared, every so many each way.
const SPARSE: usize = 2;
/// Turns tried, rad.
const TURNS: [Radian; 3] = [-0.4, 0.0, 0.4];

/// Where a hidden marker is searched.
pub(super) struct Region<'a> {
    /// Its last position, px.
    pub(super) centre: Point2,
    /// px.
    pub(super) radius: f64,
    /// Positions of the other markers, px; a window around each is excluded.
    pub(super) excluded: &'a [Point2],
}

/// The place in a region of the greatest correlation with the template, and that correlation, −1 to 1.
pub(super) fn best_match(picture: &Gray, template: &Template, region: &Region) -> (Point2, f64) {
    let (around, reach, taken) = (region.centre, region.radius, region.excluded);
    let steps = (reach / f64::from(STRIDE)) as i32;
    let min_distance = template.radius();
    let mut best = (around, -1.0);
    for row in -steps..=steps {
        for column in -steps..=steps {
            let point = [around[0] + f64::from(STRIDE * column), around[1] + f64::from(STRIDE * row)];
            let free = taken.iter().all(|t| (t[0] - point[0]).hypot(t[1] - point[1]) > min_distance);
            if free && (column * column + row * row) <= steps * steps && picture.holds_with_margin(point, min_distance)
            {
                let best_turn = TURNS.map(|turn| template_correlation(picture, template, point, turn));
                let best_turn = best_turn.into_iter().fold(-1.0, f64::max);
                if best_turn > best.1 {
                    best = (point, best_turn);
                }
            }
        }
    }
    best
}

/// Correlation of the picture around a place with the template at a turn (rad), no unit.
fn template_correlation(picture: &Gray, template: &Template, place: Point2, turn: Radian) -> f64 {
    let turn = turn.sin_cos();
    let (mut n, mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Disc { middle: place, radius: template.radius(), stride: SPARSE }.visit_pixels(picture, |x, y, _, level| {
        let share = template.level_share([x, y], turn);
        n += 1.0;
        a += level;
        b += share;
        aa += level * level;
        bb += share * share;
        ab += level * share;
    });
    let spread = ((aa - a * a / n) * (bb - b * b / n)).sqrt();
    if spread > 0.0 { (ab - a * b / n) / spread } else { 0.0 }
}
