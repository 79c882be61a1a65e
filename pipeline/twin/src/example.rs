//! The arrays of an example: a clamped beam of rubber by the method of Ritz, with three bending and four axial shapes, a chamber on either side,
//! and still water.

use crate::data::{Chamber, Output, Region, Section, TwinData};

/// Length of the beam, m.
pub const LENGTH: f64 = 0.1;
const HEIGHT: f64 = 0.01;
const AREA: f64 = 2e-4;
const DENSITY: f64 = 1100.0;
/// Highest pressure of a chamber, Pa.
const HIGHEST: f64 = 8e4;
/// Coordinates.
const R: usize = 7;
/// First derivative of a chamber's volume by the slope of the end, m³.
const ARM: f64 = 6e-8;

/// Displacement of the axis along x and y by coordinate `m` at ξ = x/L, and its first and second derivative by x.
fn mode_shape(m: usize, xi: f64) -> [[f64; 2]; 3] {
    let power = if m < 3 { m + 2 } else { m - 2 } as i32;
    let [n, l] = [f64::from(power), LENGTH];
    let second = if power > 1 { n * (n - 1.0) * xi.powi(power - 2) / (l * l) } else { 0.0 };
    let derivatives = [xi.powi(power), n * xi.powi(power - 1) / l, second];
    derivatives.map(|value| if m < 3 { [0.0, value] } else { [value, 0.0] })
}

/// ∂F/∂q of coordinate `m` at ξ and a distance from the axis.
fn mode_gradient(m: usize, xi: f64, y: f64) -> [f64; 9] {
    let [_, slope, curvature] = mode_shape(m, xi);
    let mut gradient = [0.0; 9];
    gradient[0] = slope[0] - y * curvature[1];
    gradient[1] = slope[1];
    gradient[3] = -slope[1];
    gradient
}

fn interval_middles(count: usize) -> impl Iterator<Item = f64> + Clone {
    (0..count).map(move |i| (i as f64 + 0.5) / count as f64)
}

/// Matrix of the integral of products of shapes along the beam, times `factor`.
fn shape_products(factor: f64) -> Vec<f64> {
    let product = |m: usize, n: usize| {
        let integrand = |x: f64| (0..2).map(|k| mode_shape(m, x)[0][k] * mode_shape(n, x)[0][k]).sum::<f64>();
        factor * interval_middles(200).map(integrand).sum::<f64>() / 200.0
    };
    (0..R * R).map(|entry| product(entry / R, entry % R)).collect()
}

/// The rubber of the beam, sampled at Gauss's points of its height and in the middle of even lengths.
fn rubber_region() -> Region {
    let heights = [-0.8611363, -0.3399810, 0.3399810, 0.8611363].map(|y| 0.5 * HEIGHT * y);
    let shares = [0.3478548, 0.6521452, 0.6521452, 0.3478548].map(|w| 0.5 * w);
    let places: Vec<(f64, usize)> = interval_middles(20).flat_map(|x| (0..4).map(move |k| (x, k))).collect();
    let weights = places.iter().map(|(_, k)| AREA * LENGTH / 20.0 * shares[*k]).collect();
    let gradients =
        places.iter().flat_map(|(x, k)| (0..R).flat_map(|m| mode_gradient(m, *x, heights[*k])).collect::<Vec<_>>());
    Region {
        name: "rubber".into(),
        mu: 7e4,
        lambda: 1e5,
        stiffening: [500.0, 50.0],
        branches: vec![[0.15, 0.01], [0.1, 0.3]],
        weights,
        gradients: gradients.collect(),
    }
}

/// A chamber whose volume follows the slope of the end, with this `sign`.
fn side_chamber((name, sign): (&str, f64)) -> Chamber {
    Chamber {
        name: name.into(),
        range: [0.0, HIGHEST],
        at_rest: 1e-5,
        linear: (0..R).map(|m| sign * ARM * mode_shape(m, 1.0)[1][1]).collect(),
        quadratic: vec![0.0; R * R],
        cubic: vec![0.0; R * R * (R + 1) / 2],
    }
}

/// The derivative of an order of the displacement along an axis, at ξ, by each coordinate.
fn shape_row(axis: usize, order: usize, xi: f64) -> Vec<f64> {
    (0..R).map(|m| mode_shape(m, xi)[order][axis]).collect()
}

/// Sections of still water along the beam, and that of its trailing edge.
fn water_sections() -> Vec<Section> {
    let both = |order: usize, xi: f64| [shape_row(0, order, xi), shape_row(1, order, xi)].concat();
    let section = |(xi, last): (f64, bool)| {
        let (mass, drag, length) =
            (0.25 * std::f64::consts::PI * 998.0 * 4e-4, 5.0 * 0.5 * 998.0 * 0.02, LENGTH / 12.0);
        let coefficients =
            if last { [0.0, 0.0, 0.0, mass] } else { [mass * length, drag * length, mass * length, 0.0] };
        Section { slope: both(1, xi), value: both(0, xi), by: coefficients }
    };
    interval_middles(12).map(|xi| (xi, false)).chain([(1.0, true)]).map(section).collect()
}

/// The beam, in water or in air.
pub fn beam(wet: bool) -> TwinData {
    TwinData {
        mass: shape_products(DENSITY * AREA * LENGTH),
        size: 0.02,
        regions: vec![rubber_region()],
        chambers: [("left", 1.0), ("right", -1.0)].map(side_chamber).to_vec(),
        sections: if wet { water_sections() } else { vec![] },
        outputs: [("tip_x", 0, LENGTH), ("tip_y", 1, 0.0)]
            .map(|(name, axis, at_rest)| Output { name: name.into(), row: shape_row(axis, 0, 1.0), at_rest })
            .to_vec(),
        half: false,
        provenance: vec![("example".into(), "a clamped beam of rubber".into())],
    }
}
