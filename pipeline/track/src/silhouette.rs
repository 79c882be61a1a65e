//! Silhouette: where the outline of a filmed body lies along a direction in the plane at mid height.
//!
//! Grey levels distinguish the body from its ground and from bright lines on it. The search goes outwards until ground alone is met, beyond any
//! marker on the body, which is darker, and from there back to the first run of levels that the body has near its outline. A line along the
//! search has ground to both sides and counts as ground; the flanks of a line across that touches the body are narrower than a run.

use crate::Gray;
use crate::lens::Lens;
use crate::pose::Pose;
use si::{Metre, Point2};

/// A picture whose outline is searched.
#[derive(Debug, Clone, Copy)]
pub struct Outline<'a> {
    /// The picture.
    pub picture: &'a Gray,
    /// The lens.
    pub lens: &'a Lens,
    /// World → camera.
    pub pose: &'a Pose,
    /// Grey levels: of the ground from the first to the second, of the body near its outline from the second to the third.
    pub grey: [f64; 3],
}

/// Samples a pixel.
const SAMPLES: f64 = 4.0;
/// The shortest run that is ground or body, px: more than a flank of a line or marker, blurred over two pixels and crossed aslant.
const RUN: f64 = 5.0;
/// So far to either side of the search a line along it is no longer met, px: more than its width with both blurred flanks.
const ASIDE: f64 = 6.0;

impl Outline<'_> {
    /// Distance (m) of the outline from a place (m) in the plane z = 0 along a unit vector, at most `reach` (m).
    ///
    /// None where no ground is met, or no body before it.
    pub fn edge(&self, [origin, direction]: [Point2; 2], reach: Metre) -> Option<Metre> {
        let point_at = |far: Metre| [origin[0] + far * direction[0], origin[1] + far * direction[1], 0.0];
        let pixel = |far: Metre| self.lens.project(self.pose.apply(point_at(far)));
        let (from, to) = (pixel(0.0)?, pixel(reach)?);
        let count = (SAMPLES * (to[0] - from[0]).hypot(to[1] - from[1])).ceil().max(1.0);
        let far = |i: usize| reach * i as f64 / count;
        let [u, v] = [0, 1].map(|k| (to[k] - from[k]) * ASIDE * SAMPLES / count);
        let level = |i: usize| pixel(far(i)).map_or(f64::NAN, |p| self.level_beside(p, [-v, u]));
        let levels: Vec<f64> = (0..=count as usize).map(level).collect();
        let run = (RUN * SAMPLES) as usize;
        let is = |run: &[f64], k: usize| run.iter().all(|level| (self.grey[k]..self.grey[k + 1]).contains(level));
        // From the inside: a search from outside was misled by up to 24 mm by bright lines of the grid that cross the
        // search at less than 17 degrees, and one from inside without `level_beside` by 8 mm by lines along it.
        let ground = levels.windows(run).position(|w| is(w, 0))?;
        let end = (run..=ground).rev().find(|&i| is(&levels[i - run..i], 1))?;
        Some(0.5 * (far(end - 1) + far(end)))
    }

    /// The grey level at a pixel, or that `aside` (px) of it where both sides are ground; no number near the border of the picture.
    // Not wherever both sides are darker: a line across the bottom of a dent has body to both sides, and would fill it.
    fn level_beside(&self, pixel: Point2, aside: Point2) -> f64 {
        let level =
            |side: f64| self.picture.interpolated_level([pixel[0] + side * aside[0], pixel[1] + side * aside[1]]);
        let sides = level(1.0).max(level(-1.0));
        match self.picture.holds_with_margin(pixel, ASIDE) {
            true if sides < self.grey[1] => sides,
            true => level(0.0),
            false => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refraction::RefractiveCamera;

    const LENS: [f64; 9] = [600.0, 603.0, 322.0, 178.0, -0.08, 0.02, 2e-4, -3e-4, 0.0];

    /// A camera 0.2 m above, tilted.
    fn camera() -> RefractiveCamera {
        let pose = Pose::from_vector([std::f64::consts::PI - 0.04, 0.03, 0.05], [-0.03, 0.005, 0.2]);
        RefractiveCamera { lens: Lens::default().with_values(LENS), pose, water: None }
    }

    /// Half width of a body that is notched at x = 20 mm, m.
    fn half(x: f64) -> f64 {
        0.018 - 0.1 * x - 3e-3 * (-((x - 0.02) / 0.004).powi(2)).exp()
    }

    /// The body of grey 80 to 140 with a dark marker, over dark ground with bright lines 0.8 mm wide every 9 mm, one of them at
    /// the bottom of the notch, blurred by pixels.
    fn picture() -> Gray {
        let level = |[x, y]: Point2| match () {
            () if y.abs() < half(x) && (x - 0.03).hypot(y) < 3e-3 => 20.0,
            () if y.abs() < half(x) => 110.0 + 1500.0 * y,
            () if [x, y - 4e-3].iter().any(|v| v.rem_euclid(9e-3) < 0.8e-3) => 168.0,
            () => 44.0,
        };
        let quarter = |u: f64, v: f64| camera().intersect([u, v], 0.0).map_or(44.0, level);
        Gray::from_fn(640, 360, |u, v| {
            let near = [-0.25, 0.25].map(|a| [-0.25, 0.25].map(|b| quarter(u as f64 + a, v as f64 + b)));
            near.iter().flatten().sum::<f64>() / 4.0
        })
    }

    #[test]
    fn the_outline_of_a_notched_body_over_a_grid_lies_where_it_was_drawn() {
        let (picture, camera) = (picture(), camera());
        let outline = Outline { picture: &picture, lens: &camera.lens, pose: &camera.pose, grey: [34.0, 62.0, 150.0] };
        for side in [1.0, -1.0] {
            let error = |x: f64| Some((outline.edge([[x, 0.0], [0.0, side]], 0.03)? - half(x)).abs());
            // a line of 0.8 mm touches this place, on the other side at a distance of half a pixel, which the camera cannot resolve
            assert!(error(0.02).unwrap() < 0.5e-3, "{:?}", error(0.02));
            let mut errors: Vec<f64> = (10..100).filter_map(|i| error(5e-4 * f64::from(i))).collect();
            errors.sort_by(f64::total_cmp);
            // a pixel is 0.33 mm; the threshold is nearer to the ground, so the blurred edge is found by up to a pixel farther out
            assert!(errors.len() > 85, "{}", errors.len());
            assert!(errors[errors.len() / 2] < 0.2e-3 && errors[errors.len() * 9 / 10] < 0.33e-3, "{errors:?}");
        }
    }

    #[test]
    fn ground_alone_has_no_outline_and_neither_has_a_search_that_ends_within_the_body() {
        let (picture, camera) = (picture(), camera());
        let outline = Outline { picture: &picture, lens: &camera.lens, pose: &camera.pose, grey: [34.0, 62.0, 150.0] };
        assert_eq!(outline.edge([[0.025, 0.0], [0.0, 1.0]], 0.005), None);
        assert_eq!(outline.edge([[0.012, 0.022], [0.0, 1.0]], 0.004), None);
        assert_eq!(Outline { grey: [34.0, 60.0, 61.0], ..outline }.edge([[0.025, 0.0], [0.0, 1.0]], 0.03), None);
    }
}
