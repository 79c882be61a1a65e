//! The gas in a chamber: at a prescribed pressure, or sealed with its own law.
//!
//! Prescribed p: Π −= p V.  Sealed, isothermal: (p + pₐ) V₀ = (g + pₐ) V with the gauge pressure p of the charge at the
//! rest volume V₀, the ambient pressure pₐ and the gauge pressure g at V: Π += −(p + pₐ) V₀ ln(V/V₀) + pₐ V. The
//! Hessian of a sealed chamber is that of a prescribed pressure g, plus the rank-one term (p + pₐ) V₀/V² ∇V ∇Vᵀ, a
//! dense block between all nodes of the wall, which is kept apart as one vector and solved by Woodbury's formula.

use crate::loads::{ChamberPressure, Load};
use nalgebra::Matrix3;
use si::{CubicMetre, Pascal};

/// One chamber and its gas.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gas<'a> {
    pub chamber: &'a ChamberPressure,
    /// p, gauge.
    pub pressure: Pascal,
    /// pₐ where the chamber is sealed.
    pub ambient: Option<Pascal>,
}

impl Gas<'_> {
    /// Whether it is open at zero pressure.
    pub(crate) fn is_idle(&self) -> bool {
        self.pressure == 0.0 && self.ambient.is_none()
    }

    /// Its part of Π, J; infinite when a sealed chamber has no volume.
    pub(crate) fn potential(&self, u: &[f64]) -> f64 {
        let volume = self.chamber.volume(u);
        let Some(ambient) = self.ambient else { return -self.pressure * volume };
        let rest_volume = self.chamber.at_rest;
        // Infinite and no error: the line search then shortens the step.
        if volume <= 0.0 {
            return f64::INFINITY;
        }
        -(self.pressure + ambient) * rest_volume * (volume / rest_volume).ln() + ambient * (volume - rest_volume)
    }

    /// g at the volume V, Pa.
    pub fn gauge(&self, volume: CubicMetre) -> Pascal {
        self.ambient
            .map_or(self.pressure, |ambient| (self.pressure + ambient) * self.chamber.at_rest / volume - ambient)
    }

    /// g at the displacement `u`, Pa.
    pub(crate) fn gauge_at(&self, u: &[f64]) -> Pascal {
        if self.ambient.is_none() { self.pressure } else { self.gauge(self.chamber.volume(u)) }
    }

    /// ∂g/∂p at `u`, no unit.
    pub(crate) fn gauge_by_pressure(&self, u: &[f64]) -> f64 {
        self.ambient.map_or(1.0, |_| self.chamber.at_rest / self.chamber.volume(u))
    }

    /// Adds its part of ∂Π/∂u.
    pub(crate) fn add_gradient(&self, u: &[f64], gradient: &mut [f64]) {
        self.chamber.add_gradient(u, self.gauge_at(u), gradient);
    }

    /// Calls `add` with its part of ∂²Π/∂u_a∂u_b, without the rank-one term of a sealed chamber.
    pub(crate) fn add_hessian(&self, u: &[f64], add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {
        self.chamber.add_hessian(u, self.gauge_at(u), add);
    }

    /// The rank-one term c v vᵀ: c (Pa/m³) and v = ∇V (3 entries per node, m²); none when the chamber is not sealed.
    pub(crate) fn rank_one_term(&self, u: &[f64]) -> Option<(f64, Vec<f64>)> {
        let ambient = self.ambient?;
        let volume = self.chamber.volume(u);
        let mut gradient = vec![0.0; u.len()];
        self.chamber.add_gradient(u, -1.0, &mut gradient);
        Some(((self.pressure + ambient) * self.chamber.at_rest / (volume * volume), gradient))
    }
}
