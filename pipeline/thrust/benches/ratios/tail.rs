//! The tail that is timed: the shape of the virtual bench's first specimen, with its nominal materials.

use crate::Outcome;
use fem::{Branch, Relaxation};
use hydro::Tail;
use lab::card::Clamp;
use mesh::Solid;
use nalgebra::DMatrix;
use sysid::{Attached, Body, Elastic, Material, Model, ReducedBody, Snapshots, Viscoelastic};
use tail_cad::Resolution;
use thrust::outline::Outline;

/// m.
pub const LENGTH: f64 = 0.1;
/// Highest pressure of the snapshots, Pa.
const TOP: f64 = 2e4;
/// Of the cubature, as in the study. 3e-3 leaves 219 of 376 points: 48 and 57 times faster than real time instead of 29 and 37, and as near
/// to the whole model.
const TOLERANCE: f64 = 5e-4;
/// Number of sections in water, as in the study.
const SECTIONS: usize = 30;

/// A model with its markers, then the stations in water.
pub struct Specimen {
    pub model: Model,
    pub silicone: Viscoelastic,
    pub wet: Tail,
    markers: usize,
}

impl Specimen {
    pub fn nine_chambers() -> Outcome<Self> {
        let tail = tail_cad::Tail {
            wall: [1.85e-3; 2],
            rib: 3e-3,
            top_wall: 1.85e-3,
            sheet: 0.69e-3,
            slot_share: 0.3,
            first_longer: 3e-3,
            ..tail_cad::Tail::nine_chambers()
        };
        let solid = mesh::quadratic(&tail.mesh(&Resolution { edge: 4e-3, per_chamber: 2, per_rib: 1 })?);
        let markers = [0.033, 0.053, 0.068].map(|x| tail.back_point(x)).to_vec();
        let material = |name: &str, youngs_modulus, poissons_ratio, density| Material {
            name: name.into(),
            law: "neo_hookean".into(),
            youngs_modulus,
            poissons_ratio,
            density,
            stiffening: [0.0; 2],
            stiffening_sigma: None,
            plausible: [0.5 * youngs_modulus, 2.0 * youngs_modulus],
        };
        let materials = vec![material("body", 2.3e5, 0.487, 1070.0), material("spine", 3e9, 0.37, 1410.0)];
        let marker_diameters = vec![None; markers.len()];
        let body = Body { materials, clamp: Clamp::below(4e-3), length: LENGTH, markers, marker_diameters };
        let (wet, stations) = Outline::new(&body, &solid).whole(998.0, SECTIONS)?;
        let spots = body.markers.iter().map(|at| mesh::embed(&solid, *at).0).collect();
        let model = Model::new(&Solid::Quadratic(solid), Attached { chambers: &[0, 1], clamped: &[] }, spots, &body)?
            .with_spots(stations);
        let branches = [(0.002, 0.08), (0.02, 0.06), (0.2, 0.05), (2.0, 0.04), (20.0, 0.03)];
        let relaxation = Relaxation::maxwell(&branches.map(|(time, strength)| Branch { strength, time }))?;
        let silicone = Viscoelastic { elastic: model.nominal.clone(), relaxation };
        Ok(Self { model, silicone, wet, markers: body.markers.len() })
    }

    /// Index of the marker next to the tip.
    pub fn tip(&self) -> usize {
        self.markers - 1
    }

    pub fn reduced(&self) -> Outcome<ReducedBody> {
        let elastic: &Elastic = &self.silicone.elastic;
        let snapshots = Snapshots { model: &self.model, elastic, top: &[TOP; 2], length: LENGTH };
        ReducedBody::of(&self.model, &self.silicone, &snapshots.reduce(TOLERANCE)?.data)
    }

    /// Rows of the stations in water.
    pub fn stations(&self, body: &ReducedBody) -> DMatrix<f64> {
        body.rows(&(self.markers..body.markers()).collect::<Vec<_>>())
    }
}
