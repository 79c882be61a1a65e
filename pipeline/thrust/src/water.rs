//! Water around a reduced body: hydrodynamic forces on its stations, projected onto the coordinates.
//!
//! Q = Σ R_iᵀ (F_i − dP_i/dt) over the markers, R_i a marker's rows; the rate of P by the step's own stencil.

use std::collections::VecDeque;

use fem::{ExternalForce, StepState};
use hydro::{Coefficients, Tail};
use nalgebra::{DMatrix, DVector};
use si::Point2;

/// Still water around a tail that starts from rest.
pub struct Water<'a> {
    tail: &'a Tail,
    /// (markers × 2) × coordinates, m.
    rows: &'a DMatrix<f64>,
    by: Coefficients,
    /// Modelled fraction of the tail: ½ of a half model.
    share: f64,
    /// Momenta of past steps, newest first, N s.
    past: VecDeque<DVector<f64>>,
}

impl<'a> Water<'a> {
    /// Around a tail whose markers move by `rows`; a `half` model has half of the water's force.
    pub fn around(tail: &'a Tail, rows: &'a DMatrix<f64>, by: Coefficients, half: bool) -> Self {
        let share = if half { 0.5 } else { 1.0 };
        Self { tail, rows, by, share, past: VecDeque::from([DVector::zeros(rows.nrows())]) }
    }

    fn water_state(&self, state: &StepState) -> hydro::Water {
        self.tail.water_force(&points(self.rows * state.coordinates), &points(self.rows * state.velocity), self.by)
    }
}

impl ExternalForce for Water<'_> {
    fn force(&self, state: &StepState) -> DVector<f64> {
        let water = self.water_state(state);
        let mut force = flat_vector(&water.force) - flat_vector(&water.momentum) * state.gamma;
        self.past.iter().zip(state.weights).for_each(|(momentum, weight)| force.axpy(-weight, momentum, 1.0));
        self.rows.tr_mul(&force) * self.share
    }

    fn accept(&mut self, state: &StepState) {
        self.past.push_front(flat_vector(&self.water_state(state).momentum));
        self.past.truncate(2);
    }
}

/// Pairs of numbers as points.
pub fn points(coordinates: DVector<f64>) -> Vec<Point2> {
    coordinates.as_slice().chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

fn flat_vector(points: &[Point2]) -> DVector<f64> {
    DVector::from_iterator(2 * points.len(), points.iter().flatten().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::testing::tail;

    #[test]
    fn a_half_model_bears_half_of_what_the_whole_one_does() {
        let (tail, rows) =
            (tail(), DMatrix::from_fn(6, 2, |i, j| if i % 2 == j { 0.01 * (i / 2 + 1) as f64 } else { 0.0 }));
        let (shape, speed) = (DVector::from_vec(vec![-0.1, 0.5]), DVector::from_vec(vec![-0.2, 3.0]));
        let at = StepState { time: 0.01, coordinates: &shape, velocity: &speed, gamma: 100.0, weights: &[-100.0] };
        let force = |half: bool| Water::around(&tail, &rows, Coefficients { added: 1.0, drag: 1.0 }, half).force(&at);
        assert!((force(true) * 2.0 - force(false)).norm() < 1e-12 * force(false).norm());
        // the force opposes the acceleration at the start
        assert!(force(false)[1] < 0.0);
    }

    #[test]
    fn water_that_moves_along_steadily_pushes_by_nothing_but_what_leaves() {
        let (tail, rows) = (tail(), DMatrix::identity(6, 6) * 0.01);
        let (shape, speed) = (DVector::zeros(6), DVector::from_fn(6, |i, _| if i % 2 == 1 { 1.0 } else { 0.0 }));
        let at = StepState { time: 0.01, coordinates: &shape, velocity: &speed, gamma: 100.0, weights: &[-100.0] };
        let mut water = Water::around(&tail, &rows, Coefficients { added: 1.0, drag: 0.0 }, false);
        water.accept(&at);
        let push = rows.tr_mul(&flat_vector(&water.water_state(&at).force));
        assert!((water.force(&at) - push).norm() < 1e-12 && water.past.len() == 2);
    }
}
