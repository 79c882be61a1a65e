//! Symmetric tensors of second order as six numbers: xx, yy, zz, yz, xz, xy.

use nalgebra::Matrix3;

/// xx, yy, zz, yz, xz, xy.
pub type Symmetric = [f64; 6];

/// The symmetric part.
pub fn symmetric_part(of: &Matrix3<f64>) -> Symmetric {
    let mean = |i: usize, k: usize| 0.5 * (of[(i, k)] + of[(k, i)]);
    [of[(0, 0)], of[(1, 1)], of[(2, 2)], mean(1, 2), mean(0, 2), mean(0, 1)]
}

/// The whole tensor.
pub fn full_tensor([xx, yy, zz, yz, xz, xy]: &Symmetric) -> Matrix3<f64> {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
}

/// a : b
pub fn double_contraction(a: &Symmetric, b: &Symmetric) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// `sum` += `factor` `term`.
pub fn add_scaled(sum: &mut Symmetric, factor: f64, term: &Symmetric) {
    sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += factor * term);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_numbers_stand_for_the_symmetric_part() {
        let of = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0);
        let part = (of + of.transpose()) * 0.5;
        assert_eq!(full_tensor(&symmetric_part(&of)), part);
        assert!((double_contraction(&symmetric_part(&of), &symmetric_part(&of)) - part.norm_squared()).abs() < 1e-12);
        let mut sum = symmetric_part(&of);
        add_scaled(&mut sum, -1.0, &symmetric_part(&part));
        assert_eq!(sum, [0.0; 6]);
    }
}
