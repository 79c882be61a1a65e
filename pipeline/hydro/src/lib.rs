//! Hydrodynamics of a bending tail: from the motion of its centre line to thrust, with derivatives.
//!
//! [`line`] makes the centre line of a few marks on it; [`elongated`] has elongated-body theory, as the paper's appendix has
//! it (the trailing edge alone) and as Lighthill's large-amplitude form (the whole tail); [`resistive`] has the drag of
//! sections across the flow; [`Tail`] puts them together.
//!
//! Coordinates: x from the clamp to the fin's tip, y sideways. A centre line r(a) keeps its length, so r' = (x', y') is its
//! unit tangent; the normal is n = (−y', x'), the velocity across it w = ṙ · n, along it u = ṙ · r'. Thrust is the force on
//! the tail along −x.
//!
//! Stands on: `si`. Never knows: a mesh, a camera, a specimen, how a motion came about.

pub mod elongated;
pub mod line;
pub mod resistive;
mod tail;

pub use tail::{Coefficients, Part, Tail, TailError, Terms, Water};

/// A section of the tail in motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// r' = (x', y'), no unit.
    pub tangent: si::Point2,
    /// ṙ, m/s.
    pub velocity: si::Point2,
}

/// A number of a section, and its derivative by tangent and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sloped {
    /// The number.
    pub value: f64,
    /// By x' and y'.
    pub by_tangent: si::Point2,
    /// By ẋ and ẏ, per m/s.
    pub by_velocity: si::Point2,
}

impl Section {
    /// w = ẏ x' − ẋ y', m/s.
    pub fn across(&self) -> Sloped {
        let ([tx, ty], [vx, vy]) = (self.tangent, self.velocity);
        Sloped { value: vy * tx - vx * ty, by_tangent: [vy, -vx], by_velocity: [-ty, tx] }
    }

    /// u = ẋ x' + ẏ y', m/s.
    pub fn along(&self) -> Sloped {
        let ([tx, ty], [vx, vy]) = (self.tangent, self.velocity);
        Sloped { value: vx * tx + vy * ty, by_tangent: [vx, vy], by_velocity: [tx, ty] }
    }
}

impl Sloped {
    /// x' itself.
    fn tangent_x(section: &Section) -> Self {
        Self { value: section.tangent[0], by_tangent: [1.0, 0.0], by_velocity: [0.0; 2] }
    }

    /// n_x = −y'.
    fn normal_x(section: &Section) -> Self {
        Self { value: -section.tangent[1], by_tangent: [0.0, -1.0], by_velocity: [0.0; 2] }
    }

    /// A number times this.
    pub fn times(self, by: f64) -> Self {
        Self {
            value: by * self.value,
            by_tangent: self.by_tangent.map(|v| by * v),
            by_velocity: self.by_velocity.map(|v| by * v),
        }
    }

    /// The sum of two.
    pub fn plus(self, other: Self) -> Self {
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let by_tangent = add(self.by_tangent, other.by_tangent);
        Self { value: self.value + other.value, by_tangent, by_velocity: add(self.by_velocity, other.by_velocity) }
    }

    /// The product of two.
    pub fn by(self, other: Self) -> Self {
        let (a, b) = (self.times(other.value), other.times(self.value));
        Self { value: self.value * other.value, ..a.plus(b) }
    }

    /// |this|; its slope at zero is taken as zero.
    pub fn size(self) -> Self {
        let sign = if self.value == 0.0 { 0.0 } else { self.value.signum() };
        self.times(sign)
    }
}

#[cfg(test)]
mod testing;
