//! Two faces that are close: their pairs of samples, and the second derivative by their nodes.

use super::boxes::ClosePair;
use super::law::RepulsiveLaw;
use super::surface::{NODES, Samples, Surface};
use nalgebra::{Matrix3, Vector3};
use si::Metre;
use std::ops::ControlFlow;

/// The samples of two faces; those of the second are its mirror images where that is meant.
pub(crate) struct FacePair<'a> {
    pub(crate) pair: ClosePair,
    pub(crate) samples: [&'a Samples; 2],
}

impl FacePair<'_> {
    /// Breaks off at the first two samples that are closer than `range`.
    pub(crate) fn first_contact(&self, range: Metre) -> ControlFlow<()> {
        self.visit_point_pairs(range, |_, _, _, _| ControlFlow::Break(()))
    }

    /// Calls `visit` with the indices of two samples closer than `range`, the vector from the second to the first, and its length.
    pub(crate) fn for_each_point_pair(&self, range: Metre, mut visit: impl FnMut(usize, usize, Vector3<f64>, Metre)) {
        let _ = self.visit_point_pairs(range, |i, j, apart, distance| {
            visit(i, j, apart, distance);
            ControlFlow::Continue(())
        });
    }

    /// The same until `visit` breaks off: whether walls touch is known from the first two samples that do.
    fn visit_point_pairs(
        &self,
        range: Metre,
        mut visit: impl FnMut(usize, usize, Vector3<f64>, Metre) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let [a, b] = self.samples;
        let extent = b.bounds.high - b.bounds.low;
        // Along the longest side of the second face the fewest of its samples lie within the range of one.
        let axis = extent.imax();
        let mut candidates: Vec<(usize, Vector3<f64>)> = samples_near(b, a, range).collect();
        // most pairs of faces are near each other by their boxes alone
        if candidates.is_empty() {
            return ControlFlow::Continue(());
        }
        candidates.sort_by(|(_, x), (_, y)| x[axis].total_cmp(&y[axis]));
        for (i, x) in samples_near(a, b, range) {
            let first = candidates.partition_point(|(_, y)| y[axis] < x[axis] - range);
            for &(j, y) in candidates[first..].iter().take_while(|(_, y)| y[axis] < x[axis] + range) {
                let difference = x - y;
                let squared = difference.norm_squared();
                if squared < range * range {
                    visit(i, j, difference, squared.sqrt())?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// The samples of one face that may be closer than `range` to one of the other, with their indices.
fn samples_near(samples: &Samples, other: &Samples, range: Metre) -> impl Iterator<Item = (usize, Vector3<f64>)> {
    let bounds = other.bounds.widened(range);
    samples.positions.iter().copied().enumerate().filter(move |(_, x)| bounds.contains(x))
}

/// One 3 × 3 block for each pair of nodes.
type NodeBlocks = [[Matrix3<f64>; NODES]; NODES];

/// Second derivatives by the nodes of two faces: of each by itself, a ≥ b, and between them.
#[derive(Default)]
pub(crate) struct Blocks {
    pub(crate) own: [NodeBlocks; 2],
    pub(crate) between: NodeBlocks,
}

impl Blocks {
    /// `scale` times the second derivative of the law's sum over the samples of two faces; of its `convex` part alone where that is meant.
    // Sums over the samples of the other face come first: each pair then costs one block and six products, not 78 of them.
    pub(crate) fn of_faces(
        faces: &FacePair,
        surface: &Surface,
        law: &RepulsiveLaw,
        (scale, convex): (f64, bool),
    ) -> Self {
        let [first, second] = faces.pair.faces().map(|(face, _)| surface.shapes(face));
        let mut sums = faces.samples.map(|samples| vec![Matrix3::zeros(); samples.positions.len()]);
        let mut mixed = vec![[Matrix3::zeros(); NODES]; first.len()];
        faces.for_each_point_pair(law.range, |i, j, difference, distance| {
            let hessian = law.hessian(&difference, distance, convex) * scale;
            sums[0][i] += hessian;
            sums[1][j] += hessian;
            mixed[i].iter_mut().zip(&second[j]).for_each(|(sum, shape)| *sum += hessian * *shape);
        });
        let mirror = faces.pair.mirror_map();
        let mut own_blocks = [face_blocks(first, &sums[0]), face_blocks(second, &sums[1])];
        own_blocks[1].iter_mut().flatten().for_each(|block| *block = mirror * *block * mirror);
        let mut mixed_blocks = NodeBlocks::default();
        for (shape, mixed) in first.iter().zip(&mixed) {
            for (a, row) in mixed_blocks.iter_mut().enumerate() {
                row.iter_mut().zip(mixed).for_each(|(block, sum)| *block -= sum * mirror * shape[a]);
            }
        }
        Self { own: own_blocks, between: mixed_blocks }
    }
}

/// Σ N_a N_b H over the samples of one face, a ≥ b.
fn face_blocks(shapes: &[[f64; NODES]], sums: &[Matrix3<f64>]) -> NodeBlocks {
    let mut blocks = NodeBlocks::default();
    for (shape, sum) in shapes.iter().zip(sums) {
        for (a, row) in blocks.iter_mut().enumerate() {
            row[..=a].iter_mut().zip(shape).for_each(|(block, other)| *block += sum * (shape[a] * other));
        }
    }
    blocks
}
