//! Elimination of the poses from the normal equations of a bundle adjustment [hartley2003, appendix 6].
//!
//! No point is seen in two views, so the block of each pose couples with the lens alone: A = [L B; Bᵀ D] with 6 × 6 blocks in D. The Schur
//! complement L − B D⁻¹ Bᵀ leaves the lens; the work grows with the number of views, not with its cube (200 views: 1 ms instead of 0.4 s).

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use optimize::levenberg_marquardt::NormalEquations;

/// Values of a pose.
const OF_POSE: usize = 6;

/// The normal equations of a lens without its poses.
pub(super) struct Eliminated {
    /// L − B D⁻¹ Bᵀ.
    pub(super) lens: DMatrix<f64>,
    right: DVector<f64>,
    /// D⁻¹ Bᵀ and D⁻¹ b of each pose.
    poses: Vec<(DMatrix<f64>, Vector6<f64>)>,
}

impl Eliminated {
    /// Eliminates every value after the first `lead`; `diagonal` gives the diagonal that is used for one of the matrix.
    ///
    /// None when the block of a pose is not positive definite.
    pub(super) fn new(normal: &NormalEquations, lead: usize, diagonal: impl Fn(f64) -> f64) -> Option<Self> {
        let matrix = &normal.matrix;
        let mut lens = matrix.view((0, 0), (lead, lead)).into_owned();
        (0..lead).for_each(|i| lens[(i, i)] = diagonal(lens[(i, i)]));
        let mut right = normal.right.rows(0, lead).into_owned();
        let mut poses = Vec::new();
        for at in (lead..matrix.nrows()).step_by(OF_POSE) {
            let mut block: Matrix6<f64> = matrix.fixed_view::<OF_POSE, OF_POSE>(at, at).into_owned();
            (0..OF_POSE).for_each(|i| block[(i, i)] = diagonal(block[(i, i)]));
            let factor = block.cholesky()?;
            let coupling = matrix.view((0, at), (lead, OF_POSE)).into_owned();
            let by_lens = DMatrix::from_columns(
                &(0..lead)
                    .map(|i| {
                        DVector::from_column_slice(
                            factor.solve(&Vector6::from_iterator(coupling.row(i).iter().copied())).as_slice(),
                        )
                    })
                    .chain((lead == 0).then(|| DVector::zeros(OF_POSE)))
                    .collect::<Vec<_>>(),
            );
            let alone = factor.solve(&normal.right.fixed_rows::<OF_POSE>(at).into_owned());
            if lead > 0 {
                lens -= &coupling * &by_lens;
                right -= &coupling * alone;
            }
            poses.push((by_lens, alone));
        }
        Some(Self { lens, right, poses })
    }

    /// The solution of the whole; none when what is left of the lens is not positive definite.
    pub(super) fn solve(self) -> Option<DVector<f64>> {
        let lead = self.right.len();
        let lens = if lead > 0 { self.lens.cholesky()?.solve(&self.right) } else { self.right };
        let pose = |(by_lens, alone): (DMatrix<f64>, Vector6<f64>)| {
            let follows = if lead > 0 { &by_lens * &lens } else { DVector::zeros(OF_POSE) };
            (0..OF_POSE).map(move |i| alone[i] - follows[i]).collect::<Vec<f64>>()
        };
        let poses: Vec<f64> = self.poses.into_iter().flat_map(pose).collect();
        Some(DVector::from_iterator(lead + poses.len(), lens.iter().copied().chain(poses)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Equations of a lens of `lead` values and three poses, positive definite.
    fn normal(lead: usize) -> NormalEquations {
        let size = lead + 3 * OF_POSE;
        let rows = DMatrix::from_fn(4 * size, size, |i, j| {
            let (view, is_pose) = (i % 3, j >= lead);
            let belongs = !is_pose || (j - lead) / OF_POSE == view;
            if belongs { ((i * 31 + j * 17 + i * j) % 23) as f64 / 23.0 - 0.4 } else { 0.0 }
        });
        let right = DVector::from_fn(size, |i, _| (i as f64 * 0.7).sin());
        NormalEquations { matrix: rows.tr_mul(&rows), right, squares: 1.0 }
    }

    #[test]
    fn the_solution_is_that_of_the_whole_matrix_with_and_without_a_lens() {
        for lead in [0, 4] {
            let normal = normal(lead);
            let damped = |entry: f64| 1.01 * entry;
            let mut whole = normal.matrix.clone();
            (0..whole.nrows()).for_each(|i| whole[(i, i)] = damped(whole[(i, i)]));
            let expected = whole.cholesky().unwrap().solve(&normal.right);
            let solution = Eliminated::new(&normal, lead, damped).unwrap().solve().unwrap();
            assert!((solution - &expected).norm() < 1e-9 * expected.norm(), "{lead}");
        }
    }

    #[test]
    fn the_inverse_of_what_is_left_is_the_lens_block_of_the_inverse() {
        let normal = normal(4);
        let whole = normal.matrix.clone().try_inverse().unwrap();
        let left = Eliminated::new(&normal, 4, |entry| entry).unwrap().lens.try_inverse().unwrap();
        assert!((whole.view((0, 0), (4, 4)) - &left).norm() < 1e-9 * left.norm());
    }
}
