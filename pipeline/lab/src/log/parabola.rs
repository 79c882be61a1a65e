//! Parabolas by least squares, and their normal equations.

/// Coefficients of the parabola a + b x + c x² through points by least squares.
pub(super) fn fit_parabola(points: impl Iterator<Item = (f64, f64)>) -> Option<[f64; 3]> {
    let mut normal = [[0.0; 4]; 3];
    for (x, y) in points {
        let row = [1.0, x, x * x];
        for a in 0..3 {
            (0..3).for_each(|b| normal[a][b] += row[a] * row[b]);
            normal[a][3] += row[a] * y;
        }
    }
    solve_normal(normal).map(|(solution, _)| solution)
}

/// The solution of three normal equations by elimination, and the last diagonal entry of the inverse.
pub(super) fn solve_normal(mut m: [[f64; 4]; 3]) -> Option<([f64; 3], f64)> {
    for p in 0..3 {
        if m[p][p].abs() < f64::MIN_POSITIVE {
            return None;
        }
        for r in p + 1..3 {
            let factor = m[r][p] / m[p][p];
            (p..4).for_each(|c| m[r][c] -= factor * m[p][c]);
        }
    }
    let z = m[2][3] / m[2][2];
    let y = (m[1][3] - m[1][2] * z) / m[1][1];
    let x = (m[0][3] - m[0][1] * y - m[0][2] * z) / m[0][0];
    Some(([x, y, z], 1.0 / m[2][2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_comes_back_from_its_points_and_not_from_two_places() {
        let value = |x: f64| 3.0 - 2.0 * x + 0.5 * x * x;
        let [a, b, c] = fit_parabola((-6..=6).map(|k| (f64::from(k), value(f64::from(k))))).unwrap();
        assert!((a - 3.0).abs() < 1e-12 && (b + 2.0).abs() < 1e-12 && (c - 0.5).abs() < 1e-12, "{a} {b} {c}");
        assert_eq!(fit_parabola([(0.0, 1.0), (1.0, 2.0)].into_iter()), None);
    }
}
