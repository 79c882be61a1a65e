//! The law by which two points repel each other: k ψ(r) with ψ(r) = (c/r − 1)³ within the range c.
//!
//! ψ and its first two derivatives vanish at c, so that the tangent does not jump where walls come into contact.

use nalgebra::{Matrix3, Vector3};
use si::{Metre, Pascal};
use std::f64::consts::PI;

/// k ψ(r).
#[derive(Debug, Clone, Copy)]
pub(crate) struct RepulsiveLaw {
    /// c, m.
    pub(crate) range: Metre,
    /// k, J/m⁴.
    stiffness: f64,
}

impl RepulsiveLaw {
    /// The law by which two flat walls press on each other with `pressure` (Pa) at half the `range`, where ψ = 1.
    pub(crate) fn new(range: Metre, pressure: Pascal) -> Self {
        // Between flat walls at the distance d the sum of k ψ over one of them gives the pressure 2π d k ψ(d), and
        // ψ(c/2) = 1.
        Self { range, stiffness: pressure / (PI * range) }
    }

    /// k ψ, J/m⁴.
    pub(crate) fn value(&self, distance: Metre) -> f64 {
        self.stiffness * (self.range / distance - 1.0).powi(3)
    }

    /// k ψ′, J/m⁵.
    pub(crate) fn slope(&self, distance: Metre) -> f64 {
        -3.0 * self.stiffness * (self.range / distance - 1.0).powi(2) * self.range / distance.powi(2)
    }

    /// k ψ″, J/m⁶.
    fn curvature(&self, distance: Metre) -> f64 {
        let (c, r) = (self.range, distance);
        6.0 * self.stiffness * (c / r - 1.0) * c / r.powi(3) * (2.0 * c / r - 1.0)
    }

    /// Second derivative by one of two points of this `difference` (m): ψ″ n nᵀ + ψ′/r (I − n nᵀ); of the convex part, the first term alone.
    pub(crate) fn hessian(&self, difference: &Vector3<f64>, distance: Metre, convex: bool) -> Matrix3<f64> {
        let normal = difference / distance;
        let normal_part = normal * normal.transpose();
        // ψ′ is negative: this part makes the tangent indefinite where walls slide along each other.
        let tangential_part = if convex { 0.0 } else { self.slope(distance) / distance };
        normal_part * (self.curvature(distance) - tangential_part) + Matrix3::identity() * tangential_part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_and_curvature_are_differences_and_all_vanish_at_the_range() {
        let law = RepulsiveLaw::new(6e-4, 2.5e4);
        let (r, step) = (2.3e-4, 1e-9);
        let difference = |of: &dyn Fn(f64) -> f64| (of(r + step) - of(r - step)) / (2.0 * step);
        assert!((difference(&|r| law.value(r)) / law.slope(r) - 1.0).abs() < 1e-7);
        assert!((difference(&|r| law.slope(r)) / law.curvature(r) - 1.0).abs() < 1e-7);
        for of in [RepulsiveLaw::value, RepulsiveLaw::slope, RepulsiveLaw::curvature] {
            assert!((of(&law, 6e-4 * (1.0 - 1e-6)) / of(&law, r)).abs() < 1e-5);
        }
    }
}
