//! Buffers of a step, kept from one to the next: in a controller's loop a step takes no memory.

use wide::f32x8;

use crate::chambers::PressureWork;
use crate::elastic::{Acting, Solid, Stresses};
use crate::lanes::Lanes;
use crate::single_precision;
use crate::water::WaterSums;

/// Buffers of one step.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    /// One per region.
    pub acting: Vec<Acting>,
    /// One per region: those of the last residual.
    pub stresses: Vec<Stresses>,
    pub pressure_work: PressureWork,
    /// Σ w of q, q̇ and the water's momentum.
    pub past: [Vec<f64>; 3],
    /// The iterate, and q̇ and q̈ there.
    pub coordinates: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub momentum: Vec<f64>,
    pub residual: Vec<f64>,
    /// Of the iterate in this iteration and in the one before.
    pub change: Vec<f64>,
    pub former_change: Vec<f64>,
    /// r numbers on the way.
    pub row: Vec<f64>,
    pub lanes: Vec<Lanes>,
    pub water: WaterSums,
    pub tangent: Vec<f64>,
    pub triangle: Vec<f32x8>,
}

impl Workspace {
    /// Of these solids and `r` coordinates.
    pub(crate) fn new(solids: &[Solid], r: usize) -> Self {
        let zeros = || vec![0.0; r];
        let acting = |solid: &Solid| Acting {
            constants: solid.constants_with_gain(0.0),
            held: Vec::with_capacity(if solid.branches.is_empty() { 0 } else { solid.block_count() }),
        };
        Self {
            acting: solids.iter().map(acting).collect(),
            stresses: solids.iter().map(|solid| Stresses::with_capacity(solid.block_count())).collect(),
            pressure_work: PressureWork::none(r),
            past: [zeros(), zeros(), zeros()],
            coordinates: zeros(),
            velocity: zeros(),
            acceleration: zeros(),
            momentum: zeros(),
            residual: zeros(),
            change: zeros(),
            former_change: zeros(),
            row: zeros(),
            lanes: vec![Lanes::ZERO; r],
            water: WaterSums::new(r),
            tangent: vec![0.0; r * r],
            triangle: single_precision::zero_triangle(r),
        }
    }
}
