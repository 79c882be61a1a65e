//! Quadrature rules of the tetrahedron, the cube, the triangle, the square and the interval.
//!
//! Reference cube and square: (0, 1) along each axis. Reference tetrahedron: ξ, η, ζ ≥ 0, ξ + η + ζ ≤ 1, volume 1/6. Reference triangle: ξ, η ≥ 0, ξ + η ≤ 1, area 1/2.

use si::{Point2, Point3};

/// One point, exact for linear integrands: the strain energy of the 4-node tetrahedron.
pub(crate) fn tetrahedron_1() -> Vec<(Point3, f64)> {
    vec![([0.25; 3], 1.0 / 6.0)]
}

/// Four points, exact to degree 2: the strain energy of the 10-node tetrahedron.     [hammer1956]
pub(crate) fn tetrahedron_4() -> Vec<(Point3, f64)> {
    let lesser = (5.0 - 5f64.sqrt()) / 20.0;
    let greater = 1.0 - 3.0 * lesser;
    let points =
        [[lesser, lesser, lesser], [greater, lesser, lesser], [lesser, greater, lesser], [lesser, lesser, greater]];
    points.into_iter().map(|point| (point, 1.0 / 24.0)).collect()
}

/// Gauss-Legendre points of a cube folded onto the tetrahedron: 125 points, exact to degree 7. For integrals evaluated
/// once.
pub(crate) fn tetrahedron_125() -> Vec<(Point3, f64)> {
    let line = line_5();
    let mut points = Vec::with_capacity(125);
    for &(a, wa) in &line {
        for &(b, wb) in &line {
            for &(c, wc) in &line {
                let point = [a, b * (1.0 - a), c * (1.0 - a) * (1.0 - b)];
                points.push((point, wa * wb * wc * (1.0 - a) * (1.0 - a) * (1.0 - b)));
            }
        }
    }
    points
}

/// Gauss-Legendre points of the cube, two along each axis, exact to degree 3 in each coordinate: the strain energy of
/// the trilinear hexahedron.
pub(crate) fn cube_8() -> Vec<(Point3, f64)> {
    let lower = 0.5 - (1.0f64 / 12.0).sqrt();
    let line = [lower, 1.0 - lower];
    (0..8).map(|n| ([line[n % 2], line[n / 2 % 2], line[n / 4]], 0.125)).collect()
}

/// Gauss-Legendre points of the cube, three along each axis, exact to degree 5 in each coordinate: the share of the energy of the 20-node
/// hexahedron that keeps its deviatoric part of full rank.
pub(crate) fn cube_27() -> Vec<(Point3, f64)> {
    let line = line_3();
    let tensor_point = |n: usize| [line[n % 3], line[n / 3 % 3], line[n / 9]];
    (0..27).map(tensor_point).map(|points| (points.map(|(x, _)| x), points.iter().map(|(_, w)| w).product())).collect()
}

/// Gauss-Legendre points of the cube, five along each axis. For integrals evaluated once.
pub(crate) fn cube_125() -> Vec<(Point3, f64)> {
    let line = line_5();
    let tensor_point = |n: usize| [line[n % 5], line[n / 5 % 5], line[n / 25]];
    (0..125).map(tensor_point).map(|points| (points.map(|(x, _)| x), points.iter().map(|(_, w)| w).product())).collect()
}

/// Three points of the triangle and two of the interval, exact to degree 2 in the plane and 3 across it.     [hammer1956]
pub(crate) fn wedge_6() -> Vec<(Point3, f64)> {
    let lower = 0.5 - (1.0f64 / 12.0).sqrt();
    prism_rule(
        &[[1.0 / 6.0; 2], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]].map(|point| (point, 1.0 / 6.0)),
        &[lower, 1.0 - lower].map(|z| (z, 0.5)),
    )
}

/// Seven points of the triangle and three of the interval, exact to degree 5.
pub(crate) fn wedge_21() -> Vec<(Point3, f64)> {
    prism_rule(&triangle_7(), &line_3())
}

/// Gauss-Legendre points of a cube folded onto the wedge. For integrals evaluated once.
pub(crate) fn wedge_125() -> Vec<(Point3, f64)> {
    prism_rule(&triangle_25(), &line_5())
}

/// A rule of the triangle times one of the interval.
fn prism_rule(plane: &[(Point2, f64)], interval: &[(f64, f64)]) -> Vec<(Point3, f64)> {
    plane.iter().flat_map(|&([x, y], wa)| interval.iter().map(move |&(z, wb)| ([x, y, z], wa * wb))).collect()
}

/// A rule with its last point repeated until there are `count`, of a share of its weight each.
pub(crate) fn repeat_last(mut rule: Vec<(Point3, f64)>, count: usize) -> Vec<(Point3, f64)> {
    if let Some((point, weight)) = rule.pop() {
        let shares = count - rule.len();
        rule.extend(vec![(point, weight / shares as f64); shares]);
    }
    rule
}

/// Gauss-Legendre points of the square, three along each axis, exact to degree 5 in each coordinate: the volume under a curved 8-node face.
pub(crate) fn square_9() -> Vec<(Point2, f64)> {
    let line = line_3();
    line.iter().flat_map(|&(a, wa)| line.map(|(b, wb)| ([a, b], wa * wb))).collect()
}

/// Gauss-Legendre points of the square, five along each axis. For integrals evaluated once.
pub(crate) fn square_25() -> Vec<(Point2, f64)> {
    let line = line_5();
    line.iter().flat_map(|&(a, wa)| line.map(|(b, wb)| ([a, b], wa * wb))).collect()
}

/// One point, exact for linear integrands.
pub(crate) fn triangle_1() -> Vec<(Point2, f64)> {
    vec![([1.0 / 3.0; 2], 0.5)]
}

/// Seven points, exact to degree 5: the volume under a curved 6-node face is of degree 4.     [radon1948]
// With a 3-point rule the tangent of follower pressure on curved faces was 14 % unsymmetric, with this one 7e-10. The
// rule must be exact, because one Cholesky factor serves Newton and the adjoint only if the tangent is symmetric.
pub(crate) fn triangle_7() -> Vec<(Point2, f64)> {
    let root = 15f64.sqrt();
    let mut points = vec![([1.0 / 3.0; 2], 9.0 / 80.0)];
    for (a, w) in [((6.0 + root) / 21.0, (155.0 + root) / 2400.0), ((6.0 - root) / 21.0, (155.0 - root) / 2400.0)] {
        let b = 1.0 - 2.0 * a;
        points.extend([([a, a], w), ([b, a], w), ([a, b], w)]);
    }
    points
}

/// Gauss-Legendre points of a square folded onto the triangle: 25 points, exact to degree 8. For integrals evaluated
/// once.
pub(crate) fn triangle_25() -> Vec<(Point2, f64)> {
    let line = line_5();
    let fold = |&(a, wa): &(f64, f64)| line.map(|(b, wb)| ([a, b * (1.0 - a)], wa * wb * (1.0 - a)));
    line.iter().flat_map(fold).collect()
}

/// Three points and weights of Gauss and Legendre on (0, 1), exact to degree 5.
fn line_3() -> [(f64, f64); 3] {
    let offset = 0.15f64.sqrt();
    [(0.5 - offset, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + offset, 5.0 / 18.0)]
}

/// Five points and weights of Gauss and Legendre on (0, 1), exact to degree 9.
pub(crate) fn line_5() -> [(f64, f64); 5] {
    let root = 2.0 * (10.0f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - root).sqrt() / 3.0, (5.0 + root).sqrt() / 3.0);
    let term = 13.0 * 70f64.sqrt();
    let (heavy, light) = ((322.0 + term) / 900.0, (322.0 - term) / 900.0);
    let points = [(-outer, light), (-inner, heavy), (0.0, 128.0 / 225.0), (inner, heavy), (outer, light)];
    points.map(|(x, w)| ((1.0 + x) / 2.0, w / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|k| k as f64).product()
    }

    fn tetrahedron_error(points: &[(Point3, f64)], degree: usize) -> f64 {
        let mut worst: f64 = 0.0;
        for (a, b, c) in (0..=degree).flat_map(|a| (0..=degree).flat_map(move |b| (0..=degree).map(move |c| (a, b, c))))
        {
            if a + b + c <= degree {
                let sum: f64 = points
                    .iter()
                    .map(|(x, w)| w * x[0].powi(a as i32) * x[1].powi(b as i32) * x[2].powi(c as i32))
                    .sum();
                let exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
                worst = worst.max((sum - exact).abs());
            }
        }
        worst
    }

    #[test]
    fn each_rule_of_the_tetrahedron_is_exact_to_its_degree() {
        assert!(tetrahedron_error(&tetrahedron_1(), 1) < 1e-16);
        assert!(tetrahedron_error(&tetrahedron_4(), 2) < 1e-16);
        assert!(tetrahedron_error(&tetrahedron_125(), 7) < 1e-15);
    }

    #[test]
    fn each_rule_of_the_cube_is_exact_to_its_degree_in_each_coordinate() {
        for (rule, degree) in [(cube_8(), 3), (cube_27(), 5), (cube_125(), 9)] {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.iter().map(|x| x.powi(degree)).product::<f64>()).sum();
            assert!((sum - 1.0 / f64::from(degree + 1).powi(3)).abs() < 1e-15, "{degree}");
        }
    }

    #[test]
    fn each_rule_of_the_wedge_is_exact_to_its_degree_and_repeating_a_point_keeps_its_integral() {
        let whole = repeat_last(wedge_6(), 8);
        assert_eq!(whole.len(), 8);
        for (rule, plane, across) in [(wedge_6(), 2, 3), (whole, 2, 3), (wedge_21(), 5, 5), (wedge_125(), 8, 9)] {
            let sum: f64 = rule.iter().map(|(x, w)| w * x[0] * x[1].powi(plane - 1) * x[2].powi(across)).sum();
            let exact = factorial(plane as usize - 1) / factorial(plane as usize + 2) / f64::from(across + 1);
            assert!((sum - exact).abs() < 1e-16, "{plane} {across}");
        }
    }

    #[test]
    fn the_seven_point_rule_of_the_triangle_is_exact_to_degree_five() {
        for (a, b) in (0..=5usize).flat_map(|a| (0..=5 - a).map(move |b| (a, b))) {
            let sum: f64 = triangle_7().iter().map(|(x, w)| w * x[0].powi(a as i32) * x[1].powi(b as i32)).sum();
            let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
            assert!((sum - exact).abs() < 1e-16, "{a} {b}");
        }
    }
}
