//! Markers: pixel tracks become metres in the plane of the CAD frame, each marker at its own height over the calibrated
//! plane. Paper: section IV, parallax and distortion.
//!
//! Stands on: track. Never knows: time.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Point2};
use track::plane;

use crate::fault::{Fault, Outcome};
use crate::records::{self, Camera, Path, Spread, Tracks};
use crate::stage::{Desk, Stage};
use crate::subject::Trial;

/// The stage.
pub struct Markers;

/// `[markers]` in `study.toml`: nothing to set yet.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

impl Stage for Markers {
    type Settings = Settings;
    type Needs = (Camera, Tracks);
    type Makes = records::Markers;
    const STORY: &'static str = "pixels become metres in the plane";
    const EDITION: u32 = 1;

    fn card(of: &Trial) -> Value {
        json!({ "heights": of.card.marker.iter().map(|m| m.at[2]).collect::<Vec<_>>() })
    }

    fn run(of: &Trial, _: &Settings, (camera, tracks): Self::Needs, _: &dyn Desk) -> Outcome<records::Markers> {
        let heights = of.card.marker.iter().map(|m| m.at[2]);
        let markers = tracks.markers.iter().zip(heights).map(|(path, height)| in_plane(&camera, path, height));
        Ok(records::Markers { markers: markers.collect::<Outcome<_>>()?, time: tracks.time })
    }
}

fn in_plane(camera: &Camera, path: &Path, height: Metre) -> Outcome<Path> {
    let mut metres = Path { name: path.name.clone(), ..Path::default() };
    for (frame, (&pixel, spread)) in path.at.iter().zip(&path.spread).enumerate() {
        let at = plane::meet(&camera.lens, &camera.pose, pixel, height);
        let slope = plane::sensitivity(&camera.lens, &camera.pose, pixel, height);
        let (Some(at), Some(slope)) = (at, slope) else {
            return Err(no_ray(&path.name, frame, pixel));
        };
        metres.at.push(at);
        metres.spread.push(carried(slope, spread));
    }
    Ok(metres)
}

/// J C Jᵀ
fn carried(j: [[f64; 2]; 2], [xx, xy, yy]: &Spread) -> Spread {
    let entry = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] * xx + (a[0] * b[1] + a[1] * b[0]) * xy + a[1] * b[1] * yy;
    [entry(j[0], j[0]), entry(j[0], j[1]), entry(j[1], j[1])]
}

fn no_ray(marker: &str, frame: usize, pixel: Point2) -> Fault {
    Fault::new(
        format!(
            "marker `{marker}` at ({:.1}, {:.1}) px in frame {frame} meets no point of the plane",
            pixel[0], pixel[1]
        ),
        "the calibrated lens has no ray there, or it runs away from the plane",
        "film the board up to the frame's corners, or check the plane's height on the card",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covariance_turned_by_a_right_angle_changes_its_axes() {
        let turned = carried([[0.0, -2.0], [2.0, 0.0]], &[1.0, 0.5, 3.0]);
        assert_eq!(turned, [12.0, -2.0, 4.0]);
    }
}
