//! Hydrodynamics of a bending tail in still water: thrust and forces from the motion of its centre line, with derivatives.
//!
//! [`mod@line`] interpolates the centre line from a few markers; [`elongated`] is elongated-body theory, as in the paper's appendix
//! (the trailing edge alone) and in Lighthill's large-amplitude form (the whole tail); [`resistive`] is the drag of
//! sections normal to themselves; [`Tail`] integrates them.
//!
//! Coordinates: x from the clamp to the fin's tip, y sideways. A centre line r(a) keeps its length, so r' = (x', y') is its
//! unit tangent; the normal is n = (−y', x'), the normal velocity w = ṙ · n, the tangential velocity u = ṙ · r'. Thrust is the force
//! on the tail along −x.
//!
//! ```
//! use hydro::{Stations, Tail};
//!
//! let stations = Stations { clamp: 0.01, marks: &[0.05, 0.07, 0.09], edge: 0.11, end: 0.11 };
//! let tail = Tail::new(1000.0, &stations, 24, &|_| 0.04)?;
//! // all markers move sideways at 0.1 m/s
//! let terms = tail.terms(&[[0.0; 2]; 3], &[[0.0, 0.1]; 3]);
//! assert!(terms.trailing_edge.value > 0.0);
//! # Ok::<(), hydro::TailError>(())
//! ```
//!
//! The pipeline's water alone: the bench has a hydrodynamic model of its own, so that the two check each other.
//!
//! Depends on `si`. Paper, section V and appendix.

pub mod elongated;
pub mod line;
pub mod resistive;
mod tail;

pub use tail::{Coefficients, SectionOfTail, Stations, Tail, TailError, Term, Terms, Water};

/// A moving section of the tail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// r' = (x', y'), no unit.
    pub tangent: si::Point2,
    /// ṙ, m/s.
    pub velocity: si::Point2,
}

/// A quantity of a section with its gradient by tangent and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ValueWithGradient {
    /// The value.
    pub value: f64,
    /// By x' and y'.
    pub by_tangent: si::Point2,
    /// By ẋ and ẏ, per m/s.
    pub by_velocity: si::Point2,
}

impl Section {
    /// w = ẏ x' − ẋ y', m/s.
    pub(crate) fn normal_velocity(&self) -> ValueWithGradient {
        let ([tx, ty], [vx, vy]) = (self.tangent, self.velocity);
        ValueWithGradient { value: vy * tx - vx * ty, by_tangent: [vy, -vx], by_velocity: [-ty, tx] }
    }

    /// u = ẋ x' + ẏ y', m/s.
    pub(crate) fn tangential_velocity(&self) -> ValueWithGradient {
        let ([tx, ty], [vx, vy]) = (self.tangent, self.velocity);
        ValueWithGradient { value: vx * tx + vy * ty, by_tangent: [vx, vy], by_velocity: [tx, ty] }
    }
}

impl ValueWithGradient {
    /// x'.
    fn tangent_x(section: &Section) -> Self {
        Self { value: section.tangent[0], by_tangent: [1.0, 0.0], by_velocity: [0.0; 2] }
    }

    /// n_x = −y'.
    fn normal_x(section: &Section) -> Self {
        Self { value: -section.tangent[1], by_tangent: [0.0, -1.0], by_velocity: [0.0; 2] }
    }

    /// The quantity times a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            value: factor * self.value,
            by_tangent: self.by_tangent.map(|v| factor * v),
            by_velocity: self.by_velocity.map(|v| factor * v),
        }
    }

    /// The sum of two.
    #[allow(clippy::should_implement_trait)] // one method among others of one line each, chained by name
    pub fn add(self, other: Self) -> Self {
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let by_tangent = add(self.by_tangent, other.by_tangent);
        Self { value: self.value + other.value, by_tangent, by_velocity: add(self.by_velocity, other.by_velocity) }
    }

    /// The product of two.
    #[allow(clippy::should_implement_trait)] // one method among others of one line each, chained by name
    pub(crate) fn mul(self, other: Self) -> Self {
        let (a, b) = (self.scaled(other.value), other.scaled(self.value));
        Self { value: self.value * other.value, ..a.add(b) }
    }

    /// |value|; its derivative at zero is taken as zero.
    pub fn abs(self) -> Self {
        // `signum` of a zero is ±1 by its sign bit: the gradient of a tail at rest would depend on it. The drag |w| w
        // has the slope zero there under either choice.
        let sign = if self.value == 0.0 { 0.0 } else { self.value.signum() };
        self.scaled(sign)
    }
}

#[cfg(test)]
mod testing;
