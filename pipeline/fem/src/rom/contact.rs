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
    contact: SelfContact,
    /// The nodes of the walls that may meet.
    nodes: Vec<u32>,
    /// Their rows of V, (3 nodes) × r, m per unit of q.
    modes: DMatrix<f64>,
    /// Entries of a displacement of the whole body.
    full_length: usize,
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
        let contact = contact.between_faces(&faces);
        let nodes: Vec<u32> = contact.nodes().into_iter().collect();
        let row = |index: usize| 3 * nodes[index / 3] as usize + index % 3;
        let modes = DMatrix::from_fn(3 * nodes.len(), model.coordinates(), |i, k| model.modes[(row(i), k)]);
        Ok(Some(ReducedContact { contact, nodes, modes, full_length }))
    }
}

impl ReducedContact {
    /// Adds ∂W/∂q (J) to `gradient` and returns W, J.
    pub(super) fn add_gradient(&self, q: &DVector<f64>, gradient: &mut DVector<f64>) -> Joule {
        let mut by_displacement = vec![0.0; self.full_length];
        let energy = self.contact.add_energy(&self.displacement(q), 1.0, &mut by_displacement);
        if energy > 0.0 {
            let by_walls = self.nodes.iter().flat_map(|&node| nodal_values(&by_displacement, node));
            gradient.gemv_tr(1.0, &self.modes, &DVector::from_iterator(self.modes.nrows(), by_walls), 1.0);
        }
        energy
    }

    /// Adds ∂²W/∂q² (J) to `tangent`; its `convex` part alone where that is asked for.
    pub(super) fn add_hessian(&self, q: &DVector<f64>, convex: bool, tangent: &mut DMatrix<f64>) {
        let (displacement, mut by_walls) =
            (self.displacement(q), DMatrix::zeros(self.modes.nrows(), self.modes.ncols()));
        let mut is_touching = false;
        self.contact.add_stiffness(&displacement, (1.0, convex), &|_, _| true, &mut |a, b, block| {
            is_touching = true;
            let [row, column] = [a, b].map(|node| self.first_row(node));
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
        self.contact.admissible_part(&self.displacement(q), &self.displacement(change))
    }

    /// Distance within which walls repel each other, m.
    pub fn range(&self) -> Metre {
        self.contact.range()
    }

    /// V q at the walls, and zero elsewhere.
    fn displacement(&self, q: &DVector<f64>) -> Vec<f64> {
        let (of_walls, mut displacement) = (&self.modes * q, vec![0.0; self.full_length]);
        // length: three entries a node
        for (&node, moved) in self.nodes.iter().zip(of_walls.as_slice().chunks_exact(3)) {
            displacement[3 * node as usize..3 * node as usize + 3].copy_from_slice(moved);
        }
        displacement
    }

    fn first_row(&self, node: u32) -> usize {
        3 * self.nodes.binary_search(&node).expect("faces have nodes of the walls")
    }
}

fn nodal_values(field: &[f64], node: u32) -> [f64; 3] {
    [0, 1, 2].map(|axis| field[3 * node as usize + axis])
}

/// Adds `block` · `modes` to the three rows from `row` on.
fn add_block_product(sum: &mut DMatrix<f64>, row: usize, (block, modes): (nalgebra::Matrix3<f64>, DMatrixView<f64>)) {
    sum.rows_mut(row, 3).gemm(1.0, &block, &modes, 1.0);
}
