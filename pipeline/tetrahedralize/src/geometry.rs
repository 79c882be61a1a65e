//! Predicates and measures of points, triangles and tetrahedra.
//!
//! Orientation and in-sphere tests are exact [shewchuk1997]: Delaunay insertion with rounded ones loses the star shape of its cavity. Measures of
//! quality are rounded; they rank elements that are known to be positive.

use robust::Coord3D;
use si::Point3;
use si::vec3::{add, cross, dot, norm, scale, sub};

fn to_coordinates([x, y, z]: Point3) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

/// Positive, zero or negative as the volume of the tetrahedron is; the sign is exact.
pub(crate) fn orientation([a, b, c, d]: [Point3; 4]) -> f64 {
    -robust::orient3d(to_coordinates(a), to_coordinates(b), to_coordinates(c), to_coordinates(d))
}

/// Positive when `at` lies within the sphere through the corners of a tetrahedron of positive volume; the sign is exact.
pub(crate) fn in_sphere([a, b, c, d]: [Point3; 4], at: Point3) -> f64 {
    -robust::insphere(to_coordinates(a), to_coordinates(b), to_coordinates(c), to_coordinates(d), to_coordinates(at))
}

/// Six times the volume of a tetrahedron, rounded.
pub(crate) fn six_volumes([a, b, c, d]: [Point3; 4]) -> f64 {
    dot(cross(sub(b, a), sub(c, a)), sub(d, a))
}

/// Normal times twice the area.
pub(crate) fn normal([a, b, c]: [Point3; 3]) -> Point3 {
    cross(sub(b, a), sub(c, a))
}

/// A vector of length 1 along another; zero of zero.
pub(crate) fn unit(a: Point3) -> Point3 {
    let length = norm(a);
    if length > 0.0 { scale(a, 1.0 / length) } else { [0.0; 3] }
}

pub(crate) fn distance(a: Point3, b: Point3) -> f64 {
    norm(sub(a, b))
}

pub(crate) fn centroid<const N: usize>(points: [Point3; N]) -> Point3 {
    scale(points.into_iter().fold([0.0; 3], add), 1.0 / N as f64)
}

/// Least height of a triangle over its longest side: 0 where it is degenerate, 0.87 where it is equilateral.
pub(crate) fn flatness(corners: [Point3; 3]) -> f64 {
    let [a, b, c] = corners;
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    if longest > 0.0 { norm(normal(corners)) / (longest * longest) } else { 0.0 }
}

/// Least height of a triangle.
pub(crate) fn least_height([a, b, c]: [Point3; 3]) -> f64 {
    flatness([a, b, c]) * distance(a, b).max(distance(b, c)).max(distance(c, a))
}

/// The point of a triangle nearest to `at` [ericson2005, section 5.1.5].
pub(crate) fn nearest_on_triangle(at: Point3, [a, b, c]: [Point3; 3]) -> Point3 {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(at, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = sub(at, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = sub(at, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return add(a, scale(ab, d1 / (d1 - d3)));
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return add(a, scale(ac, d2 / (d2 - d6)));
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return add(b, scale(sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    let sum = va + vb + vc;
    add(a, add(scale(ab, vb / sum), scale(ac, vc / sum)))
}

/// The points of shares `(i, j, k)/n` of a triangle's corners, these left out.
pub(crate) fn triangle_samples([a, b, c]: [Point3; 3], parts: usize) -> impl Iterator<Item = Point3> {
    let n = parts as f64;
    (0..=parts).flat_map(move |i| (0..=parts - i).map(move |j| [i, j, parts - i - j])).filter_map(move |shares| {
        let [i, j, k] = shares.map(|s| s as f64 / n);
        let corner = shares.contains(&parts);
        (!corner).then(|| [0, 1, 2].map(|x| i * a[x] + j * b[x] + k * c[x]))
    })
}

/// Inverse mean ratio of a tetrahedron: 1 when it is regular, infinite when it is not positive [liu1994].
pub(crate) fn distortion(corners: [Point3; 4]) -> f64 {
    let volume = six_volumes(corners);
    let [a, b, c, d] = corners;
    let square = |p, q| {
        let side = sub(p, q);
        dot(side, side)
    };
    let sum = square(a, b) + square(a, c) + square(a, d) + square(b, c) + square(b, d) + square(c, d);
    if volume <= 1e-14 * sum * sum.sqrt() {
        return f64::INFINITY;
    }
    // ‖J‖³ / (3√3 det J) with ‖J‖² = ½ Σ l², det J = 6 V √2
    (0.5 * sum) * (0.5 * sum).sqrt() / (27f64.sqrt() * std::f64::consts::SQRT_2 * volume)
}

/// The six dihedral angles of a tetrahedron, rad.
pub(crate) fn dihedral_angles(corners: [Point3; 4]) -> [f64; 6] {
    let [a, b, c, d] = corners;
    let outward = [normal([b, c, d]), normal([a, d, c]), normal([a, b, d]), normal([a, c, b])].map(unit);
    let pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    pairs.map(|[i, j]| (-dot(outward[i], outward[j])).clamp(-1.0, 1.0).acos())
}
