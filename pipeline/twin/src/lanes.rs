//! Many small matrices side by side: eight points share a vector, so that products and laws are evaluated for all of them at once.
//!
//! A sum over points runs in lanes and is reduced once at the end: always in the same order.

use wide::f64x8;

/// Points side by side: a register of AVX-512, or two of AVX2.
pub const LANES: usize = 8;

/// One number of each of eight points.
// Plain arrays were measured: the compiler vectorises loops over them across coordinates instead, with gathers, at a quarter of the speed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lanes(f64x8);

/// An operator of two numbers in each lane.
macro_rules! operator {
    ($of:ident, $name:ident, $sign:tt) => {
        impl std::ops::$of for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0 $sign other.0)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Lanes {
    /// Zeros.
    pub const ZERO: Self = Self(f64x8::ZERO);

    /// self + a b, not fused, so that the result is the same on every processor: fused it takes 5 % less time.
    #[inline(always)]
    pub fn plus(self, a: Self, b: Self) -> Self {
        Self(self.0 + a.0 * b.0)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    pub fn sum(self) -> f64 {
        self.0.to_array().iter().sum()
    }

    pub fn to_array(self) -> [f64; LANES] {
        self.0.to_array()
    }
}

/// `value` in each lane.
#[inline(always)]
pub(crate) fn splat(value: f64) -> Lanes {
    Lanes(f64x8::splat(value))
}

/// A function of each lane.
pub(crate) fn per_lane(value_of_lane: impl Fn(usize) -> f64) -> Lanes {
    Lanes(f64x8::new(std::array::from_fn(value_of_lane)))
}

/// Rows of K numbers of every point by every coordinate.
#[derive(Debug, Clone)]
pub struct Blocks<const K: usize> {
    coordinates: usize,
    /// blocks × coordinates.
    values: Vec<[Lanes; K]>,
}

impl<const K: usize> Blocks<K> {
    /// Of `count` points, whose number `k` by coordinate `m` is `of(point, m, k)`; the last block is filled with zeros.
    pub fn new(count: usize, coordinates: usize, of: impl Fn(usize, usize, usize) -> f64) -> Self {
        let mut values = vec![[splat(0.0); K]; count.div_ceil(LANES) * coordinates];
        for (at, block) in values.iter_mut().enumerate() {
            let (first, m) = (at / coordinates * LANES, at % coordinates);
            for (k, lanes) in block.iter_mut().enumerate() {
                *lanes = per_lane(|i| if first + i < count { of(first + i, m, k) } else { 0.0 });
            }
        }
        Self { coordinates, values }
    }

    /// By each coordinate, of one block.
    pub fn block(&self, block: usize) -> &[[Lanes; K]] {
        &self.values[block * self.coordinates..(block + 1) * self.coordinates]
    }

    pub(crate) fn block_count(&self) -> usize {
        self.values.len() / self.coordinates
    }
}

/// Σ q_m A_m.
#[inline(always)]
pub fn gather<const K: usize>(block: &[[Lanes; K]], q: &[f64]) -> [Lanes; K] {
    let mut sums = [splat(0.0); K];
    for (values, q) in block.iter().zip(q) {
        for (sum, values) in sums.iter_mut().zip(values) {
            *sum = sum.plus(*values, splat(*q));
        }
    }
    sums
}

/// `sums`_m += A_m : P.
#[inline(always)]
pub fn scatter<const K: usize>(block: &[[Lanes; K]], stress: &[Lanes; K], sums: &mut [Lanes]) {
    for (values, sum) in block.iter().zip(sums) {
        let mut total = *sum;
        for (values, stress) in values.iter().zip(stress) {
            total = total.plus(*values, *stress);
        }
        *sum = total;
    }
}

/// Adds the sum of each's lanes.
pub(crate) fn add_reduced(lanes: &[Lanes], sums: &mut [f64]) {
    sums.iter_mut().zip(lanes).for_each(|(sum, lanes)| *sum += lanes.sum());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gathering_and_scattering_are_products_with_a_matrix_and_its_transpose() {
        let of = |point: usize, m: usize, k: usize| (1.0 + point as f64 + 10.0 * m as f64 + 0.1 * k as f64).sin();
        let (points, r) = (11, 3);
        let blocks = Blocks::<2>::new(points, r, of);
        let q = [0.3, -1.2, 0.7];
        let mut sums = [splat(0.0); 3];
        for block in 0..blocks.block_count() {
            let found = gather(blocks.block(block), &q);
            for (i, k) in (0..LANES).flat_map(|i| [(i, 0), (i, 1)]) {
                let point = block * LANES + i;
                let exact: f64 = if point < points { (0..r).map(|m| q[m] * of(point, m, k)).sum() } else { 0.0 };
                assert!((found[k].to_array()[i] - exact).abs() < 1e-14);
            }
            scatter(blocks.block(block), &found, &mut sums);
        }
        let mut reduced = [0.0; 3];
        add_reduced(&sums, &mut reduced);
        let work: f64 = reduced.iter().zip(&q).map(|(f, q)| f * q).sum();
        let squares = |point: usize| (0..2).map(move |k| (0..r).map(|m| q[m] * of(point, m, k)).sum::<f64>().powi(2));
        assert!((work - (0..points).flat_map(squares).sum::<f64>()).abs() < 1e-12);
    }
}
