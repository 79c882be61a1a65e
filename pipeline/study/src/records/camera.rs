//! Camera: the lens and where the camera stands over the specimen.

use serde::{Deserialize, Serialize};
use track::lens::Lens;
use track::pose::Pose;

use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// A calibrated camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The lens.
    pub lens: Lens,
    /// CAD frame → camera frame.
    pub pose: Pose,
    /// Root of the mean squared distance between seen and projected corners, px.
    pub reprojection_px: f64,
    /// Standard deviation of the focal length along u, px.
    pub focal_sigma_px: f64,
    /// Boards that were seen.
    pub views: usize,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    focal_px: [f64; 2],
    principal_point_px: [f64; 2],
    radial: [f64; 3],
    tangential: [f64; 2],
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    reprojection_px: f64,
    focal_sigma_px: f64,
    views: usize,
}

impl Record for Camera {
    type Of = Specimen;
    const STAGE: &'static str = "camera";

    fn pack(&self) -> Result<Parcel, RecordError> {
        let lens = self.lens;
        Parcel::default().scalars(
            "camera.json",
            &Scalars {
                focal_px: [lens.fx, lens.fy],
                principal_point_px: [lens.cx, lens.cy],
                radial: [lens.k1, lens.k2, lens.k3],
                tangential: [lens.p1, lens.p2],
                rotation: self.pose.rotation,
                translation_m: self.pose.translation,
                reprojection_px: self.reprojection_px,
                focal_sigma_px: self.focal_sigma_px,
                views: self.views,
            },
        )
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let s: Scalars = parcel.read_scalars("camera.json")?;
        let ([fx, fy], [cx, cy], [k1, k2, k3], [p1, p2]) = (s.focal_px, s.principal_point_px, s.radial, s.tangential);
        Ok(Self {
            lens: Lens { fx, fy, cx, cy, k1, k2, p1, p2, k3 },
            pose: Pose { rotation: s.rotation, translation: s.translation_m },
            reprojection_px: s.reprojection_px,
            focal_sigma_px: s.focal_sigma_px,
            views: s.views,
        })
    }

    fn metrics(&self, _: &Specimen) -> Vec<Metric> {
        vec![
            Metric::new("camera.reprojection_px", self.reprojection_px, "px"),
            Metric::new("camera.focal_sigma_px", self.focal_sigma_px, "px"),
        ]
    }

    fn telling(&self) -> String {
        format!("{} boards, reprojection {:.3} px", self.views, self.reprojection_px)
    }
}
