//! Camera: the lens and the pose of the camera relative to the specimen.

use serde::{Deserialize, Serialize};
use si::{Metre, Point2};
use track::calibrate::{CAMERA_PARAMETERS, FocalDifference};
use track::lens::{Distortion, Lens};
use track::pose::Pose;
use track::refraction::RefractiveCamera;

use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// A calibrated camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The lens.
    pub lens: Lens,
    /// CAD frame → camera frame.
    pub pose: Pose,
    /// Root of the mean squared distance between seen and projected corners, px.
    pub reprojection_px: f64,
    /// Joint covariance of lens and pose: order and units as in [`CAMERA_PARAMETERS`].
    pub covariance: [[f64; CAMERA_PARAMETERS]; CAMERA_PARAMETERS],
    /// Width and height of its pictures, px.
    pub size_px: [usize; 2],
    /// Number of detected boards.
    pub views: usize,
    /// Of a lens from a file, its focal length against that of the boards, where they differ.
    pub contradiction: Option<FocalDifference>,
}

impl Camera {
    /// The corners of its image on the plane of a height in air, m, from the upper left one around; empty where a corner's ray
    /// does not meet that plane.
    pub fn visible_field(&self, height: Metre) -> Vec<Point2> {
        let sight = RefractiveCamera { lens: self.lens, pose: self.pose, water: None };
        let [w, h] = self.size_px.map(|v| v as f64);
        let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|px| sight.intersect(px, height));
        corners.into_iter().collect::<Option<Vec<_>>>().unwrap_or_default()
    }
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    bend: String,
    focal_px: [f64; 2],
    principal_point_px: [f64; 2],
    radial: [f64; 4],
    tangential: [f64; 2],
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    reprojection_px: f64,
    covariance: [[f64; CAMERA_PARAMETERS]; CAMERA_PARAMETERS],
    size_px: [usize; 2],
    views: usize,
    /// Focal length of the boards and its standard deviation, px, where that of the file differs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    board_focal_px: Option<[f64; 2]>,
}

/// The record's name of a distortion model.
fn distortion_name(bend: Distortion) -> &'static str {
    match bend {
        Distortion::BrownConrady => "brown_conrady",
        Distortion::Fisheye => "fisheye",
    }
}

impl Record for Camera {
    type Of = Specimen;
    const STAGE: &'static str = "camera";

    fn is_made_for(specimen: &Specimen) -> bool {
        !specimen.trials().iter().all(|trial| trial.in_space().is_some())
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let lens = self.lens;
        RecordFiles::default().scalars(
            "camera.json",
            &Scalars {
                bend: distortion_name(lens.distortion).into(),
                focal_px: [lens.fx, lens.fy],
                principal_point_px: [lens.cx, lens.cy],
                radial: [lens.k1, lens.k2, lens.k3, lens.k4],
                tangential: [lens.p1, lens.p2],
                rotation: self.pose.rotation,
                translation_m: self.pose.translation,
                reprojection_px: self.reprojection_px,
                covariance: self.covariance,
                size_px: self.size_px,
                views: self.views,
                board_focal_px: self.contradiction.map(|focal| [focal.estimate, focal.sigma]),
            },
        )
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let s: Scalars = files.read_scalars("camera.json")?;
        let mut kinds = [Distortion::BrownConrady, Distortion::Fisheye].into_iter();
        let bend = kinds
            .find(|kind| s.bend == distortion_name(*kind))
            .ok_or_else(|| super::inconsistent_file("camera.json", s.bend.clone()))?;
        let ([fx, fy], [cx, cy], [k1, k2, k3, k4], [p1, p2]) =
            (s.focal_px, s.principal_point_px, s.radial, s.tangential);
        Ok(Self {
            lens: Lens { distortion: bend, fx, fy, cx, cy, k1, k2, p1, p2, k3, k4 },
            pose: Pose { rotation: s.rotation, translation: s.translation_m },
            reprojection_px: s.reprojection_px,
            covariance: s.covariance,
            size_px: s.size_px,
            views: s.views,
            contradiction: s.board_focal_px.map(|[estimate, sigma]| FocalDifference { known: fx, estimate, sigma }),
        })
    }

    fn metrics(&self, _: &str) -> Vec<Metric> {
        vec![
            Metric::new("camera.reprojection_px", self.reprojection_px, "px"),
            Metric::new("camera.focal_sigma_px", self.covariance[0][0].sqrt(), "px"),
        ]
    }

    fn summary(&self) -> String {
        let warning =
            self.contradiction.map_or_else(String::new, |focal| format!("; warning: {focal}, {}", focal.reason()));
        format!("{} boards, reprojection {:.3} px{warning}", self.views, self.reprojection_px)
    }
}
