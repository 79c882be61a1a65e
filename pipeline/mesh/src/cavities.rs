//! Volume and centroid of every chamber of a skin, curved faces included.
//!
//! V = −⅓ ∮ x · n dA and V c_k = −½ ∮ x_k² n_k dA over the chamber's faces, by Gauss's rule on the square, collapsed onto the
//! triangle: exact for faces of six nodes. Faces on z = 0 that would close a half cavity contribute nothing to V.

use crate::{Skin, Solid};
use si::vec3::{add, cross, dot, scale};
use si::{CubicMetre, Point3};

/// A closed cavity.
#[derive(Debug, Clone, PartialEq)]
pub struct Cavity {
    /// Its centroid, m; on z = 0 when the plane of symmetry cuts it.
    pub centroid: Point3,
    /// Its volume, m³; both halves when the plane of symmetry cuts it.
    pub volume: CubicMetre,
    /// Whether the plane of symmetry cuts it.
    pub cut: bool,
}

/// Places and weights of Gauss's rule on [0, 1], exact to degree 7.
pub(crate) const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The cavities of a solid, by the number that its skin gives them.
pub fn cavities(solid: &Solid) -> Vec<Cavity> {
    let faces = solid.faces();
    let count = faces.iter().map(|(_, on)| if let Skin::Chamber(k) = on { *k as usize + 1 } else { 0 }).max();
    let mut sums = vec![([0.0; 3], 0.0, false); count.unwrap_or(0)];
    for (nodes, on) in faces {
        let Skin::Chamber(chamber) = on else { continue };
        let corners: Vec<Point3> = nodes.iter().map(|&node| solid.nodes()[node as usize]).collect();
        let (moment, volume) = moment_and_volume(&corners);
        let sum = &mut sums[usize::from(chamber)];
        let cut = solid.half() && corners.iter().any(|at| at[2] == 0.0);
        *sum = (add(sum.0, moment), sum.1 + volume, sum.2 || cut);
    }
    sums.into_iter().map(|(moment, volume, cut)| cavity_from_moment(moment, volume, cut)).collect()
}

/// The cavity of this moment and volume, which may be those of a half.
pub(crate) fn cavity_from_moment(moment: Point3, volume: f64, cut: bool) -> Cavity {
    let centroid = scale(moment, 1.0 / volume);
    match cut {
        true => Cavity { centroid: [centroid[0], centroid[1], 0.0], volume: 2.0 * volume, cut },
        false => Cavity { centroid, volume, cut },
    }
}

/// −½ ∮ x_k² n_k dA, m⁴, and −⅓ ∮ x · n dA, m³, over one face of 3, 6 or 8 nodes.
pub(crate) fn moment_and_volume(corners: &[Point3]) -> (Point3, CubicMetre) {
    let (mut moment, mut volume) = ([0.0; 3], 0.0);
    // Four points each way: x_k² n_k is of degree 7 in each variable on eight nodes, and of degree 6 on six, of which
    // the collapse onto the triangle makes 7.
    for (xi, weight) in GAUSS {
        for (part, other) in GAUSS {
            // onto the triangle
            let squeezed = if corners.len() == 8 { 1.0 } else { 1.0 - xi };
            let [x, by_xi, by_eta] = point_and_tangents(corners, xi, part * squeezed);
            let normal = scale(cross(by_xi, by_eta), weight * other * squeezed);
            volume -= dot(x, normal) / 3.0;
            (0..3).for_each(|k| moment[k] -= x[k] * x[k] * normal[k] / 2.0);
        }
    }
    (moment, volume)
}

/// The place (ξ, η) of a face and its two tangents.
fn point_and_tangents(corners: &[Point3], xi: f64, eta: f64) -> [Point3; 3] {
    let zeta = 1.0 - xi - eta;
    let shapes: Vec<[f64; 3]> = match corners.len() {
        3 => vec![[zeta, -1.0, -1.0], [xi, 1.0, 0.0], [eta, 0.0, 1.0]],
        8 => quadrilateral_shapes(xi, eta),
        _ => vec![
            [zeta * (2.0 * zeta - 1.0), 1.0 - 4.0 * zeta, 1.0 - 4.0 * zeta],
            [xi * (2.0 * xi - 1.0), 4.0 * xi - 1.0, 0.0],
            [eta * (2.0 * eta - 1.0), 0.0, 4.0 * eta - 1.0],
            [4.0 * zeta * xi, 4.0 * (zeta - xi), -4.0 * xi],
            [4.0 * xi * eta, 4.0 * eta, 4.0 * xi],
            [4.0 * eta * zeta, -4.0 * eta, 4.0 * (zeta - eta)],
        ],
    };
    let sum = |k: usize| shapes.iter().zip(corners).fold([0.0; 3], |sum, (n, corner)| add(sum, scale(*corner, n[k])));
    [sum(0), sum(1), sum(2)]
}
/// Shape functions of the quadrilateral of eight nodes and their derivatives: at the middles of its sides the linear function across times
/// 4 ξ (1 − ξ), at its corners the linear function less half of those of the two sides.
fn quadrilateral_shapes(x: f64, y: f64) -> Vec<[f64; 3]> {
    let times = |[a, by_x]: [f64; 2], [b, by_y]: [f64; 2]| [a * b, by_x * b, a * by_y];
    let linear = |t: f64| [[1.0 - t, -1.0], [t, 1.0]];
    let bent = |t: f64| [4.0 * t * (1.0 - t), 4.0 - 8.0 * t];
    let ([x0, x1], [y0, y1]) = (linear(x), linear(y));
    let corners = [times(x0, y0), times(x1, y0), times(x1, y1), times(x0, y1)];
    let middles = [times(bent(x), y0), times(x1, bent(y)), times(bent(x), y1), times(x0, bent(y))];
    let corner = |n: usize| std::array::from_fn(|k| corners[n][k] - 0.5 * (middles[n][k] + middles[(n + 3) % 4][k]));
    (0..4).map(corner).chain(middles).collect()
}
