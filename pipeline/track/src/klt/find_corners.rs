//! Detection of markers by Shi and Tomasi's corner measure: the dark spot at each strong corner.

use kornia_image::{Image, ImageSize};
use kornia_imgproc::features::gftt_response;
use si::Point2;

use super::gates::SPREAD_LIMIT;
use super::{Settings, blob};
use crate::Gray;

/// Sides of the derivative's window and of the window it is summed over, px.
const WINDOWS: (usize, usize) = (3, 5);
/// A corner counts when it is this strong against the strongest of the region.
const QUALITY: f32 = 0.05;
/// Pixels around a region that are looked at too: the measure is wrong near the edge of its picture.
const MARGIN: f64 = 8.0;

/// The `count` markers with the strongest corners inside a region (left, top, right, bottom, px), from left to right: px each.
///
/// A marker's corners stand around the middle of one dark spot, which is its place. Fewer come back when there are fewer.
/// Beside [`super::find_blobs`], something else that is dark may touch a marker over a tenth of its window's rim.
pub fn find_corners(picture: &Gray, region: [f64; 4], count: usize, settings: &Settings) -> Vec<Point2> {
    if picture.check().is_err() {
        return Vec::new();
    }
    let [left, top, right, bottom] = region;
    let inside = |[x, y]: Point2| (left..=right).contains(&x) && (top..=bottom).contains(&y);
    let mut markers: Vec<Point2> = Vec::new();
    for corner in strongest_corners(picture, region) {
        if markers.len() == count {
            break;
        }
        let Ok(blob) = blob::find_blob(picture, corner, settings.radius) else { continue };
        let marker = blob.contrast >= settings.contrast_limit && blob.spread <= SPREAD_LIMIT && inside(blob.at);
        let distance_from_blob = |from: &Point2| (from[0] - blob.at[0]).hypot(from[1] - blob.at[1]);
        if marker
            && distance_from_blob(&corner) < settings.radius
            && markers.iter().all(|other| distance_from_blob(other) >= settings.radius)
        {
            markers.push(blob.at);
        }
    }
    markers.sort_by(|a, b| a[0].total_cmp(&b[0]));
    markers
}

/// The corners of a region, px, strongest first.
fn strongest_corners(picture: &Gray, [left, top, right, bottom]: [f64; 4]) -> Vec<Point2> {
    let (from, above) = ((left - MARGIN).max(0.0) as usize, (top - MARGIN).max(0.0) as usize);
    let [wide, high] = [right + MARGIN - from as f64, bottom + MARGIN - above as f64].map(|v| v.max(0.0) as usize + 1);
    let part = picture.crop(from, above, wide, high);
    let pixel_of = |i: usize| [(from + i % part.width) as f64, (above + i / part.width) as f64];
    let inside = |[x, y]: Point2| (left..=right).contains(&x) && (top..=bottom).contains(&y);
    let corners = corner_response(&part).unwrap_or_default().into_iter().enumerate();
    let mut corners: Vec<(f32, Point2)> =
        corners.map(|(i, strength)| (strength, pixel_of(i))).filter(|c| inside(c.1)).collect();
    let greatest = corners.iter().map(|corner| corner.0).fold(0.0, f32::max);
    corners.retain(|(strength, _)| *strength > QUALITY * greatest);
    // a stable sort: equal corners stay in reading order
    corners.sort_by(|a, b| b.0.total_cmp(&a.0));
    corners.into_iter().map(|corner| corner.1).collect()
}

/// The lesser eigenvalue of the structure tensor where it is largest among its neighbours, else 0: pixels.
fn corner_response(part: &Gray) -> Option<Vec<f32>> {
    let size = ImageSize { width: part.width, height: part.height };
    let levels = part.pixels.iter().map(|&p| f32::from(p) / 255.0).collect();
    let image = Image::<f32, 1>::new(size, levels).ok()?;
    let mut response = Image::<f32, 1>::from_size_val(size, 0.0).ok()?;
    gftt_response(&image, &mut response, WINDOWS.0, WINDOWS.1, true).ok()?;
    Some(response.as_slice().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Crosses of arms 11 px long and 5 px wide on background with a dark stripe, which reaches into the windows of two.
    fn crosses(places: &[Point2]) -> Gray {
        Gray::from_fn(320, 200, |x, y| {
            let on = |p: &Point2| {
                let (dx, dy) = ((x as f64 - p[0]).abs(), (y as f64 - p[1]).abs());
                (dx <= 11.0 && dy <= 2.5) || (dy <= 11.0 && dx <= 2.5)
            };
            let stripe = if y > 117 && y < 121 { 60.0 } else { 0.0 };
            if places.iter().any(on) { 40.0 } else { 190.0 - stripe }
        })
    }

    #[test]
    fn crosses_above_a_dark_stripe_are_found_by_their_corners_to_a_twentieth_of_a_pixel() {
        let truth = [[60.0, 100.0], [140.0, 60.0], [230.0, 100.0]];
        let found = find_corners(&crosses(&truth), [30.0, 30.0, 290.0, 170.0], 9, &Settings::default());
        assert_eq!(found.len(), 3, "{found:?}");
        for (at, truth) in found.iter().zip(truth) {
            assert!((at[0] - truth[0]).hypot(at[1] - truth[1]) < 0.05, "{at:?} {truth:?}");
        }
    }

    #[test]
    fn even_ground_has_no_corner_with_a_marker() {
        assert!(
            find_corners(&Gray::filled(200, 150, 170), [20.0, 20.0, 180.0, 130.0], 3, &Settings::default()).is_empty()
        );
    }
}
