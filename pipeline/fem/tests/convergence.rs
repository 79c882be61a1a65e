//! Rate of convergence with the mesh, by the method of manufactured solutions.
//!
//! u = A d sin(πx/L) sin(πy/L) sin(πz/L) vanishes on all sides of a cube of side L, which are clamped. In linear
//! elasticity the body force b = −(λ + μ) ∇(div u) − μ Δu holds it. Forces and errors are integrated here, with shape
//! functions and quadrature of the test's own.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::material::Moduli;
use fem::{Clamps, Mesh, RegionProperties, StaticSettings, System, box_mesh, materials};
use std::f64::consts::PI;

const SIDE: f64 = 0.1;
const MOST: f64 = 1e-3;
const ALONG: [f64; 3] = [1.0, -0.6, 0.3];
const E: f64 = 2e5;
const NU: f64 = 0.3;
/// Edges of a tetrahedron in the order of their middle nodes.
const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

/// Sine along `axis`, and its cosine, at a place (m).
fn wave(at: [f64; 3], axis: usize) -> (f64, f64) {
    let (sine, cosine) = (PI * at[axis] / SIDE).sin_cos();
    (sine, cosine)
}

/// u at a place, m.
fn shape(at: [f64; 3]) -> [f64; 3] {
    let phi: f64 = (0..3).map(|axis| wave(at, axis).0).product();
    ALONG.map(|part| MOST * part * phi)
}

/// b at a place, N/m³, from ∂²φ/∂x_i∂x_j: −φ κ² where i = j, else κ² cos cos sin; κ = π/L.
fn body_force(at: [f64; 3], moduli: Moduli) -> [f64; 3] {
    let waves = [0, 1, 2].map(|axis| wave(at, axis));
    let phi: f64 = waves.iter().map(|wave| wave.0).product();
    let scale = MOST * (PI / SIDE).powi(2);
    let second = |i: usize, j: usize| if i == j { -phi } else { waves[i].1 * waves[j].1 * waves[3 - i - j].0 };
    std::array::from_fn(|i| {
        let slope_of_swell: f64 = (0..3).map(|j| second(i, j) * ALONG[j]).sum();
        -scale * ((moduli.lambda + moduli.mu) * slope_of_swell - moduli.mu * 3.0 * phi * ALONG[i])
    })
}

/// Barycentric coordinates and weights (summing to 1): Gauss and Legendre's points of a cube folded onto a tetrahedron.
fn points() -> Vec<([f64; 4], f64)> {
    // four points on (0, 1), exact to degree 7
    let root = (6.0f64 / 5.0).sqrt() * 2.0 / 7.0;
    let line = [-1.0, -1.0, 1.0, 1.0].iter().zip([1.0, -1.0, -1.0, 1.0]).map(|(side, inner)| {
        let x = side * (3.0 / 7.0 + inner * root).sqrt();
        (0.5 * (1.0 + x), (18.0 - inner * 30f64.sqrt()) / 72.0)
    });
    let line: Vec<(f64, f64)> = line.collect();
    let mut all = Vec::new();
    for &(a, wa) in &line {
        for &(b, wb) in &line {
            for &(c, wc) in &line {
                let at = [a, b * (1.0 - a), c * (1.0 - a) * (1.0 - b)];
                let weight = 6.0 * wa * wb * wc * (1.0 - a).powi(2) * (1.0 - b);
                all.push(([1.0 - at[0] - at[1] - at[2], at[0], at[1], at[2]], weight));
            }
        }
    }
    all
}

/// The shape functions of 4 or 10 nodes at barycentric coordinates.
fn functions(nodes: usize, part: [f64; 4]) -> Vec<f64> {
    if nodes == 4 {
        return part.to_vec();
    }
    let corners = part.iter().map(|p| p * (2.0 * p - 1.0));
    corners.chain(EDGES.iter().map(|&(i, j)| 4.0 * part[i] * part[j])).collect()
}

/// Visits every point of every (straight) element: nodes, shape functions, place (m) and weight (m³).
fn for_each_point(mesh: &Mesh, mut visit: impl FnMut(&[u32], &[f64], [f64; 3], f64)) {
    let rule: Vec<_> =
        points().into_iter().map(|(part, w)| (part, functions(mesh.elements.nodes_each(), part), w)).collect();
    for element in 0..mesh.elements.len() {
        let nodes = mesh.elements.nodes(element);
        let corner = [0, 1, 2, 3].map(|n| mesh.nodes[nodes[n] as usize]);
        let edge = [1, 2, 3].map(|n| si::vec3::sub(corner[n], corner[0]));
        let volume = si::vec3::dot(edge[0], si::vec3::cross(edge[1], edge[2])) / 6.0;
        for (part, functions, weight) in &rule {
            let at = std::array::from_fn(|axis| (0..4).map(|n| part[n] * corner[n][axis]).sum());
            visit(nodes, functions, at, weight * volume);
        }
    }
}

/// √(∫ |u_h − u|² / ∫ |u|²) on a mesh.
fn error(mesh: &Mesh) -> f64 {
    let moduli = Moduli::of(E, NU);
    let mut forces = vec![0.0; 3 * mesh.nodes.len()];
    for_each_point(mesh, |nodes, functions, at, weight| {
        let force = body_force(at, moduli);
        for (&node, share) in nodes.iter().zip(functions) {
            (0..3).for_each(|axis| forces[3 * node as usize + axis] += weight * share * force[axis]);
        }
    });
    let outside = |at: [f64; 3]| at.iter().any(|x| x.abs() < 1e-9 || (x - SIDE).abs() < 1e-9);
    let clamps = Clamps::where_nodes(mesh, [true; 3], outside);
    let material = materials::by_name("linear").unwrap();
    let region = RegionProperties::elastic(material, E, NU, 1070.0);
    let mut solver = System::new(mesh.clone(), vec![region], clamps).unwrap().solver();
    solver.set_forces(&forces).unwrap();
    let settings = StaticSettings { load_steps: 1, tolerance: 1e-12, ..Default::default() };
    let found = solver.equilibrium(&[], None, &settings).unwrap().displacement;
    let (mut wrong, mut whole) = (0.0, 0.0);
    for_each_point(mesh, |nodes, functions, at, weight| {
        for (axis, exact) in shape(at).into_iter().enumerate() {
            let here: f64 = nodes.iter().zip(functions).map(|(&node, n)| n * found[3 * node as usize + axis]).sum();
            wrong += weight * (here - exact).powi(2);
            whole += weight * exact * exact;
        }
    });
    (wrong / whole).sqrt()
}

/// Slope of ln(error) over ln(size of a cell), by least squares.
fn slope(cells: &[usize], errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = cells.iter().zip(errors).map(|(&n, e)| (-(n as f64).ln(), e.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let both: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    both / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

#[test]
fn halving_a_mesh_of_linear_elements_quarters_the_error() {
    let cells = [8, 12, 16, 20];
    let errors = cells.map(|n| error(&box_mesh::linear([SIDE; 3], [n; 3])));
    let order = slope(&cells, &errors);
    assert!(order >= 1.8, "{order} {errors:?}");
}

#[test]
fn halving_a_mesh_of_quadratic_elements_leaves_an_eighth_of_the_error() {
    let cells = [4, 6, 8, 10];
    let errors = cells.map(|n| error(&box_mesh::quadratic([SIDE; 3], [n; 3])));
    let order = slope(&cells, &errors);
    assert!(order >= 2.8, "{order} {errors:?}");
}
