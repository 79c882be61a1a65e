//! The tails that are timed: of thick walls, and of the thin ones of the virtual bench's first specimen, with nominal materials.

use crate::{Outcome, WAVE};
use fem::{Branch, Relaxation};
use hydro::Tail;
use lab::card::Clamp;
use mesh::{Grading, QuadraticMesh, Solid};
use nalgebra::DMatrix;
use sysid::{Attached, Body, Elastic, Material, Model, ReducedBody, Snapshots, Stroke, Viscoelastic};
use tail_cad::Resolution;
use thrust::outline::Outline;

/// m.
pub const LENGTH: f64 = 0.1;
/// Highest pressures of the snapshots, Pa: of thick walls, and of thin ones as far as they are held.
const TOP: [f64; 2] = [2e4, 2.4e4];
/// Of the cubature, as in the study.
const TOLERANCE: f64 = 1e-3;
/// Number of sections in water, as in the study.
const SECTIONS: usize = 30;

/// A model with its markers, then the stations in water.
pub struct Specimen {
    pub model: Model,
    pub silicone: Viscoelastic,
    pub wet: Tail,
    markers: usize,
    /// Pa.
    top: f64,
    stroke: Option<Stroke>,
}

impl Specimen {
    /// Nine chambers a side with thick walls, in tetrahedra.
    pub fn thick() -> Outcome<Self> {
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
        Self::new(&tail, solid, ([0.0; 2], TOP[0], None))
    }

    /// The same with the walls of the photograph, which buckle, in hexahedra; it learns from the first strokes of a motion as well.
    pub fn thin() -> Outcome<Self> {
        let tail = tail_cad::Tail {
            wall: [1.55e-3; 2],
            rib: 1.5e-3,
            inner_wall: 0.4e-3,
            top_wall: 1.55e-3,
            sheet: 0.6e-3,
            slot_share: 0.5,
            ..tail_cad::Tail::nine_chambers()
        };
        let stroke = Stroke { amplitude: WAVE.amplitude, frequency: WAVE.frequency };
        Self::new(&tail, tail.hexahedra(&Grading::COARSE)?, ([0.02; 2], TOP[1], Some(stroke)))
    }

    fn new(
        tail: &tail_cad::Tail,
        solid: QuadraticMesh,
        (stiffening, top, stroke): ([f64; 2], f64, Option<Stroke>),
    ) -> Outcome<Self> {
        let markers = [0.033, 0.053, 0.068].map(|x| tail.back_point(x)).to_vec();
        let material = |name: &str, law: &str, youngs_modulus, poissons_ratio, density| Material {
            name: name.into(),
            law: law.into(),
            youngs_modulus,
            poissons_ratio,
            density,
            stiffening: if law == "yeoh" { stiffening } else { [0.0; 2] },
            stiffening_sigma: None,
            plausible: [0.5 * youngs_modulus, 2.0 * youngs_modulus],
        };
        let materials =
            vec![material("body", "yeoh", 2.5e5, 0.487, 1070.0), material("spine", "neo_hookean", 4.4e9, 0.37, 1410.0)];
        let marker_diameters = vec![None; markers.len()];
        let body = Body { materials, clamp: Clamp::below(4e-3), length: LENGTH, markers, marker_diameters };
        let (wet, stations) = Outline::new(&body, &solid).whole(998.0, SECTIONS)?;
        let spots = body.markers.iter().map(|at| mesh::embed(&solid, *at).0).collect();
        let model = Model::new(&Solid::Quadratic(solid), Attached { chambers: &[0, 1], clamped: &[] }, spots, &body)?
            .with_spots(stations);
        let branches = [(0.002, 0.08), (0.02, 0.06), (0.2, 0.05), (2.0, 0.04), (20.0, 0.03)];
        let relaxation = Relaxation::maxwell(&branches.map(|(time, strength)| Branch { strength, time }))?;
        let silicone = Viscoelastic { elastic: model.nominal.clone(), relaxation };
        Ok(Self { model, silicone, wet, markers: body.markers.len(), top, stroke })
    }

    /// Index of the marker next to the tip.
    pub fn tip(&self) -> usize {
        self.markers - 1
    }

    pub fn reduced(&self) -> Outcome<ReducedBody> {
        let elastic: &Elastic = &self.silicone.elastic;
        let top = [self.top; 2];
        let snapshots = Snapshots { model: &self.model, elastic, top: &top, length: LENGTH, stroke: self.stroke };
        ReducedBody::of(&self.model, &self.silicone, &snapshots.reduce(TOLERANCE)?.data)
    }

    /// Rows of the stations in water.
    pub fn stations(&self, body: &ReducedBody) -> DMatrix<f64> {
        body.rows(&(self.markers..body.markers()).collect::<Vec<_>>())
    }
}
