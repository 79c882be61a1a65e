//! Self-contact in a reduced model: between the faces of chamber walls that came close to each other in the shapes that trained it.
//!
//! The potential is that of the whole body. Its points follow the modes, so that W(V q) has the gradient Vᵀ ∂W/∂u and the tangent
//! Vᵀ ∂²W/∂u² V. All walls would cost a search among thousands of faces in each iteration; of a thin tail some hundred ever meet. Faces
//! that no shape brought within [`NEAR`] do not repel each other: the model must have been trained where they do.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DMatrixView, DVector};
use si::{Joule, Metre};

use super::error::ReducedError;
use super::model::ReducedModel;
use crate::contact::SelfContact;
use crate::system::System;

/// Walls that came closer than this multiple of the range in a training shape may meet: the walls of a thin tail move by that much between two
/// of its 24 levels.
const NEAR: f64 = 4.0;

/// The walls that may meet, and how they move with the coordinates.
#[derive(Debug, Clone)]
pub struct ReducedContact {
    /// Of these walls alone: their nodes are counted anew, so that nothing of the size of the whole body is made in an iteration.
    contact: SelfContact,
    /// Rows of V at their nodes, (3 nodes) × r, m per unit of q.
    modes: DMatrix<f64>,
}

impl System {
    /// The contact of this body in its reduced `model`, between walls that came close to each other in one of the `shapes` (3 entries per node, m);
    /// none where none did, or the body has no contact.
    ///
    /// # Errors
    /// [`ReducedError::Foreign`] of a shape or a model of another body.
    pub fn reduced_contact(
        &self,
        model: &ReducedModel,
        shapes: &[&[f64]],
    ) -> Result<Option<ReducedContact>, ReducedError> {
        let full_length = self.data.full_length();
        if model.modes.nrows() != full_length || shapes.iter().any(|shape| shape.len() != full_length) {
            let what = format!("a shape of this body has {full_length} numbers, 3 per node");
            return Err(ReducedError::Foreign { what });
        }
        let Some(contact) = &self.data.contact else { return Ok(None) };
        let reach = NEAR * contact.range();
        let faces: BTreeSet<u32> = shapes.iter().flat_map(|shape| contact.faces_within(shape, reach)).collect();
        if faces.is_empty() {
            return Ok(None);
        }
        let (contact, nodes) = contact.between_faces(&faces);
        let row = |index: usize| 3 * nodes[index / 3] as usize + index % 3;
        let modes = DMatrix::from_fn(3 * nodes.len(), model.coordinates(), |i, k| model.modes[(row(i), k)]);
        Ok(Some(ReducedContact { contact, modes }))
    }
}

impl ReducedContact {
    /// Adds ∂W/∂q (J) to `gradient` and returns W, J.
    pub(super) fn add_gradient(&self, q: &DVector<f64>, gradient: &mut DVector<f64>) -> Joule {
        let mut by_walls = DVector::zeros(self.modes.nrows());
        let energy = self.contact.add_energy(self.displacement(q).as_slice(), 1.0, by_walls.as_mut_slice());
        if energy > 0.0 {
            gradient.gemv_tr(1.0, &self.modes, &by_walls, 1.0);
        }
        energy
    }

    /// Adds ∂²W/∂q² (J) to `tangent`; its `convex` part alone where that is asked for.
    pub(super) fn add_hessian(&self, q: &DVector<f64>, convex: bool, tangent: &mut DMatrix<f64>) {
        let (displacement, mut by_walls) =
            (self.displacement(q), DMatrix::zeros(self.modes.nrows(), self.modes.ncols()));
        let mut is_touching = false;
        self.contact.add_stiffness(displacement.as_slice(), (1.0, convex), &|_, _| true, &mut |a, b, block| {
            is_touching = true;
            let [row, column] = [a, b].map(|node| 3 * node as usize);
            add_block_product(&mut by_walls, row, (block.clone_owned(), self.modes.rows(column, 3)));
            // of two different nodes the block is given once
            if a != b {
                add_block_product(&mut by_walls, column, (block.transpose(), self.modes.rows(row, 3)));
            }
        });
        if is_touching {
            tangent.gemm_tr(1.0, &self.modes, &by_walls, 1.0);
        }
    }

    /// The largest part of `change` from q, at most 1, by which no wall passes through another.
    pub(super) fn admissible_part(&self, q: &DVector<f64>, change: &DVector<f64>) -> f64 {
        self.contact.admissible_part(self.displacement(q).as_slice(), self.displacement(change).as_slice())
    }

    /// Distance within which walls repel each other, m.
    pub fn range(&self) -> Metre {
        self.contact.range()
    }

    /// V q at the walls, m, 3 a node.
    fn displacement(&self, q: &DVector<f64>) -> DVector<f64> {
        &self.modes * q
    }
}

/// Adds `block` · `modes` to the three rows from `row` on.
fn add_block_product(sum: &mut DMatrix<f64>, row: usize, (block, modes): (nalgebra::Matrix3<f64>, DMatrixView<f64>)) {
    sum.rows_mut(row, 3).gemm(1.0, &block, &modes, 1.0);
}
