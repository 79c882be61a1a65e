//! Where a hidden marker comes out again: the place around that correlates best with how it looked in the first frame.
//!
//! Stands on: templates. Never knows: why it was hidden.

use super::ground::visit;
use super::template::Template;
use crate::Gray;
use si::{Point2, Radian};

/// A search reaches no further than this, px, whatever the time: half a second of a swing that comes back.
pub(super) const FARTHEST: f64 = 90.0;
/// Places are tried this far apart, px: a tenth of a marker, from where its middle is found anyway.
const STRIDE: i32 = 3;
/// Pixels of the window that are compared, every so many each way.
const SPARSE: usize = 2;
/// Turns tried, rad.
const TURNS: [Radian; 3] = [-0.4, 0.0, 0.4];

/// The place within `reach` (px) of `around` that looks most like the template, and its correlation, −1 to 1; places within
/// a window of those `taken` do not count.
pub(super) fn like(picture: &Gray, template: &Template, around: Point2, reach: f64, taken: &[Point2]) -> (Point2, f64) {
    let steps = (reach / f64::from(STRIDE)) as i32;
    let apart = template.radius();
    let mut best = (around, -1.0);
    for row in -steps..=steps {
        for column in -steps..=steps {
            let place = [around[0] + f64::from(STRIDE * column), around[1] + f64::from(STRIDE * row)];
            let free = taken.iter().all(|t| (t[0] - place[0]).hypot(t[1] - place[1]) > apart);
            if free && (column * column + row * row) <= steps * steps && picture.holds(place, apart) {
                let likeness = TURNS.map(|turn| correlation(picture, template, place, turn));
                let likeness = likeness.into_iter().fold(-1.0, f64::max);
                if likeness > best.1 {
                    best = (place, likeness);
                }
            }
        }
    }
    best
}

/// Correlation of the picture around a place with the template at a turn (rad), no unit.
fn correlation(picture: &Gray, template: &Template, place: Point2, turn: Radian) -> f64 {
    let turn = turn.sin_cos();
    let (mut n, mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    visit(picture, place, template.radius(), SPARSE, |x, y, _, level| {
        let share = template.share([x, y], turn);
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
