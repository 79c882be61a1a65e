//! Brown–Conrady distortion: radial and tangential polynomials \[brown1971\].

use si::Point2;

/// x' = x (1 + k₁r² + k₂r⁴ + k₃r⁶) + 2p₁xy + p₂(r² + 2x²), y' alike with p₁ and p₂ exchanged    \[brown1971\]
pub(super) fn distort([k1, k2, p1, p2, k3]: &[f64; 5], [x, y]: Point2) -> Point2 {
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    [x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y]
}

/// d(distorted)/d(normalised), 2 × 2, no unit.
pub(super) fn distortion_jacobian([k1, k2, p1, p2, k3]: &[f64; 5], [x, y]: Point2) -> [[f64; 2]; 2] {
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let jacobian = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
    let cross = jacobian * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    [
        [radial + jacobian * x * x + 2.0 * p1 * y + 6.0 * p2 * x, cross],
        [cross, radial + jacobian * y * y + 6.0 * p1 * y + 2.0 * p2 * x],
    ]
}

/// d(distorted)/d(k₁ k₂ p₁ p₂ k₃), 2 × 5, no unit.
pub(super) fn by_coefficients([x, y]: Point2) -> [[f64; 5]; 2] {
    let r2 = x * x + y * y;
    [
        [x * r2, x * r2 * r2, 2.0 * x * y, r2 + 2.0 * x * x, x * r2 * r2 * r2],
        [y * r2, y * r2 * r2, r2 + 2.0 * y * y, 2.0 * x * y, y * r2 * r2 * r2],
    ]
}

/// d(r · radial)/dr at r²: positive while rays spread.
pub(super) fn rise([k1, k2, _, _, k3]: &[f64; 5], r2: f64) -> f64 {
    1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3))
}
