//! Stairs: a tail whose chamber is filled and opened level after level, and the swing that follows each.
//!
//! u(t) = u₀(p(t)) + V (q(t) − q₀(p(t))): the whole body's equilibrium at the pressure of the moment, and how far the reduced body in
//! motion is from its own. Where it has come to rest, it is where the whole body rests.
//!
//! Stands on: the ladder, the flap. Never knows: what is commanded.

use nalgebra::DVector;
use si::{Newton, Point3, Second};

use super::flap::{self, Flap};
use super::{Motion, Quasistatic};

/// A tail on its stairs.
pub struct Stairs<'a> {
    /// The whole body's equilibria.
    pub still: Quasistatic<'a>,
    /// The reduced body's motion under the same pressure.
    pub flap: Flap<'a>,
    /// The reduced body's own equilibria on the same rungs.
    pub rests: &'a [DVector<f64>],
}

impl Stairs<'_> {
    /// Coordinates in which the motion is away from its equilibrium.
    fn swing(&self, t: Second) -> DVector<f64> {
        let (first, weights) = self.still.rungs(t);
        let here = self.flap.coordinates(t);
        self.rests[first..].iter().zip(weights).fold(here, |left, (rest, weight)| left - rest * weight)
    }
}

impl Motion for Stairs<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (mut nodes, moved) = (self.still.nodes(t), flap::moved(self.flap.modes(), &self.swing(t)));
        let (moved, _) = moved.as_chunks::<3>();
        nodes.iter_mut().zip(moved).for_each(|(x, u)| shift(x, u));
        nodes
    }

    fn seen(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let mut nodes = self.still.seen(t, of);
        let moved = flap::moved_of(self.flap.modes(), &self.swing(t), of);
        of.iter().zip(moved).for_each(|(i, u)| shift(&mut nodes[*i as usize], &u));
        nodes
    }

    fn pull(&self, t: Second) -> Newton {
        self.flap.pull(t)
    }

    fn thrust(&self, t: Second) -> Newton {
        self.flap.thrust(t)
    }
}

fn shift(x: &mut Point3, u: &[f32; 3]) {
    x.iter_mut().zip(u).for_each(|(x, u)| *x += f64::from(*u));
}
