//! Element kernels: the dense sums over the 4, 8, 10 or 20 nodes of one element.

use materials::material::Tangent;
use nalgebra::Matrix3;
use si::Point3;

/// Entries of an element's nodes in a vector with 3 entries per node.
pub(crate) fn element_values<const N: usize>(nodes: &[u32; N], u: &[f64]) -> [Point3; N] {
    std::array::from_fn(|a| {
        let first_dof = 3 * nodes[a] as usize;
        [u[first_dof], u[first_dof + 1], u[first_dof + 2]]
    })
}

/// F = I + ∇u
pub(crate) fn deformation_gradient<const N: usize>(
    gradients: &[Point3; N],
    displacement: &[Point3; N],
) -> Matrix3<f64> {
    let mut sum = displacement_gradient(gradients, displacement);
    (0..3).for_each(|axis| sum[(axis, axis)] += 1.0);
    sum
}

/// ∇u = Σ_a u_a ⊗ ∇N_a
// F − I has it to 1e-16 alone: of an adjoint variable, which is as small as the derivative of the loss, nothing may be left.
pub(crate) fn displacement_gradient<const N: usize>(
    gradients: &[Point3; N],
    displacement: &[Point3; N],
) -> Matrix3<f64> {
    let mut columns = [[0.0; 3]; 3];
    for (gradient, u) in gradients.iter().zip(displacement) {
        for (column, derivative) in columns.iter_mut().zip(gradient) {
            (0..3).for_each(|i| column[i] += u[i] * derivative);
        }
    }
    Matrix3::from_column_slice(columns.as_flattened())
}

/// Adds w P ∇N_a to the force on each node.
pub(crate) fn add_force<const N: usize>(
    force: &mut [Point3; N],
    gradients: &[Point3; N],
    stress: &Matrix3<f64>,
    weight: f64,
) {
    let stress = stress * weight;
    for (force, gradient) in force.iter_mut().zip(gradients) {
        for (axis, derivative) in gradient.iter().enumerate() {
            (0..3).for_each(|i| force[i] += stress[(i, axis)] * derivative);
        }
    }
}

/// Adds the forces of an element to those of all nodes, 3 entries per node.
pub(crate) fn scatter_forces<const N: usize>(nodes: &[u32; N], force: &[Point3; N], forces: &mut [f64]) {
    for (&node, force) in nodes.iter().zip(force) {
        (0..3).for_each(|axis| forces[3 * node as usize + axis] += force[axis]);
    }
}

/// Adds ∇N_aᵀ C ∇N_b for all a ≥ b; each block row by row.
// The tangent is reordered first, so that the inner loops run over 27 and 9 contiguous numbers and vectorise. Assembly
// is then 7 % of an iteration.
#[allow(non_snake_case)]
pub(crate) fn add_blocks<const N: usize>(blocks: &mut [[f64; 9]], gradients: &[Point3; N], tangent: &Tangent) {
    let mut C = [[0.0; 27]; 3];
    for (L, C) in C.iter_mut().enumerate() {
        for (at, entry) in C.iter_mut().enumerate() {
            let (J, i, k) = (at / 9, at % 9 / 3, at % 3);
            *entry = tangent[(i + 3 * J, k + 3 * L)];
        }
    }
    for (b, right) in gradients.iter().enumerate() {
        let half: [f64; 27] = std::array::from_fn(|n| C[0][n] * right[0] + C[1][n] * right[1] + C[2][n] * right[2]);
        for (a, left) in gradients.iter().enumerate().skip(b) {
            let block = &mut blocks[a * (a + 1) / 2 + b];
            for (n, entry) in block.iter_mut().enumerate() {
                *entry += left[0] * half[n] + left[1] * half[9 + n] + left[2] * half[18 + n];
            }
        }
    }
}

/// The same for nodes and gradients in lists, from a vector `u` with 3 entries per node.
pub(crate) fn deformation_of(nodes: &[u32], gradients: &[Point3], u: &[f64]) -> Matrix3<f64> {
    add_gradient_of(Matrix3::identity(), (nodes, gradients), u)
}

/// ∇u, alike.
pub(crate) fn displacement_gradient_of(nodes: &[u32], gradients: &[Point3], u: &[f64]) -> Matrix3<f64> {
    add_gradient_of(Matrix3::zeros(), (nodes, gradients), u)
}

fn add_gradient_of(mut sum: Matrix3<f64>, (nodes, gradients): (&[u32], &[Point3]), u: &[f64]) -> Matrix3<f64> {
    for (&node, gradient) in nodes.iter().zip(gradients) {
        let first_dof = 3 * node as usize;
        for (axis, derivative) in gradient.iter().enumerate() {
            (0..3).for_each(|i| sum[(i, axis)] += u[first_dof + i] * derivative);
        }
    }
    sum
}
