//! Boxes along the axes around faces, and which of them are close: sweep and prune along x.

use nalgebra::{Matrix3, Vector3};
use si::Metre;

/// A box with sides along the axes, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Box3 {
    pub(crate) low: Vector3<f64>,
    pub(crate) high: Vector3<f64>,
}

/// Two faces that are close; where `mirrored`, the first and the mirror image of the second in z = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ClosePair {
    a: u32,
    b: u32,
    mirrored: bool,
}

impl ClosePair {
    /// Both faces, and whether each is a mirror image.
    pub(crate) fn faces(&self) -> [(u32, bool); 2] {
        [(self.a, false), (self.b, self.mirrored)]
    }

    /// The map from the displacement of the second face's nodes to that of its image.
    pub(crate) fn mirror_map(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, if self.mirrored { -1.0 } else { 1.0 }))
    }
}

impl Box3 {
    /// Around `points`.
    pub(crate) fn around(points: &[Vector3<f64>]) -> Self {
        let empty = Self { low: Vector3::repeat(f64::INFINITY), high: Vector3::repeat(f64::NEG_INFINITY) };
        points.iter().fold(empty, |all, point| Self { low: all.low.inf(point), high: all.high.sup(point) })
    }

    /// The same with every side moved outwards.
    pub(crate) fn widened(&self, margin: Metre) -> Self {
        Self { low: self.low.add_scalar(-margin), high: self.high.add_scalar(margin) }
    }

    /// Whether a point lies inside.
    pub(crate) fn contains(&self, point: &Vector3<f64>) -> bool {
        (0..3).all(|axis| (self.low[axis]..=self.high[axis]).contains(&point[axis]))
    }

    /// Distance to another box, m; 0 where they overlap.
    pub(crate) fn distance(&self, other: &Self) -> Metre {
        let gaps = (self.low - other.high).sup(&(other.low - self.high));
        gaps.map(|gap| gap.max(0.0)).norm()
    }

    fn mirror_image(&self) -> Self {
        let [mut low, mut high] = [self.low, self.high];
        (low.z, high.z) = (-self.high.z, -self.low.z);
        Self { low, high }
    }
}

/// Pairs of boxes closer than `reach`, each pair once; of a half model also those of a box and the mirror image of another.
pub(crate) fn close_pairs(boxes: &[Box3], reach: Metre, half: bool) -> Vec<ClosePair> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.sort_by(|a, b| boxes[*a as usize].low.x.total_cmp(&boxes[*b as usize].low.x));
    let mut pairs = Vec::new();
    for (index, &first) in order.iter().enumerate() {
        let first_box = &boxes[first as usize];
        let behind =
            order[index + 1..].iter().take_while(|next| boxes[**next as usize].low.x < first_box.high.x + reach);
        for &second in behind {
            let second_box = &boxes[second as usize];
            let (a, b) = (first.min(second), first.max(second));
            if first_box.distance(second_box) < reach {
                pairs.push(ClosePair { a, b, mirrored: false });
            }
            // A sum first: boxes that lie above the plane by more than the reach are farther than that from each
            // other's images.
            if half
                && first_box.low.z + second_box.low.z < reach
                && first_box.distance(&second_box.mirror_image()) < reach
            {
                pairs.push(ClosePair { a, b, mirrored: true });
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_finds_the_pairs_that_a_comparison_of_all_finds() {
        let at = |seed: usize| (0..3).map(move |axis| ((7 * seed + 5 * axis + seed * seed) % 23) as f64 / 23.0);
        let boxes: Vec<Box3> = (0..40)
            .map(|seed| {
                let low = Vector3::from_iterator(at(seed));
                Box3 { low, high: low + Vector3::new(0.05, 0.08, 0.03) }
            })
            .collect();
        for (reach, half) in [(0.1, false), (0.1, true), (0.3, true)] {
            let mut found = close_pairs(&boxes, reach, half);
            found.sort_unstable();
            let mut all = Vec::new();
            for (a, b) in (0..40).flat_map(|b| (0..b).map(move |a| (a, b))) {
                let [one, other] = [a, b].map(|n: u32| &boxes[n as usize]);
                let images = [(false, *other), (true, other.mirror_image())];
                let near =
                    images.into_iter().filter(|(mirrored, image)| (half || !mirrored) && one.distance(image) < reach);
                all.extend(near.map(|(mirrored, _)| ClosePair { a, b, mirrored }));
            }
            all.sort_unstable();
            assert_eq!(found, all);
        }
    }
}
