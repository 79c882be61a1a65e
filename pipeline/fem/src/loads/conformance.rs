//! Properties that every load must have, and closed forms for the volume of a chamber.

use super::gas::Gas;
use super::{ChamberPressure, DeadForces};
use crate::contact::{Contact, SelfContact};
use crate::loads::Load;
use crate::mesh::box_mesh;
use crate::mesh::{Faces, Mesh};
use nalgebra::Matrix3;
use std::f64::consts::PI;

const RADIUS: f64 = 0.013;
const CELLS: usize = 8;

/// The faces of a chamber's wall.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Linear,
    Quadratic,
    Quadrilateral,
}

const KINDS: [Kind; 3] = [Kind::Linear, Kind::Quadratic, Kind::Quadrilateral];

/// A cube of (CELLS)³ cells whose inner quarter is air, mapped so that the cavity becomes a ball of `RADIUS`.
fn ball(kind: Kind, half: bool) -> Mesh {
    let (from, to) = (CELLS / 4, CELLS - CELLS / 4);
    let layers = if half { CELLS / 2 } else { CELLS };
    let lift = if half { 0 } else { CELLS / 2 };
    let air = move |cell: [usize; 3]| {
        let z = cell[2] + CELLS / 2 - lift;
        [cell[0], cell[1], z].iter().all(|&at| at >= from && at < to)
    };
    let place = move |at: [f64; 3]| {
        let cube = [4.0 * at[0] - 2.0, 4.0 * at[1] - 2.0, if half { 2.0 * at[2] } else { 4.0 * at[2] - 2.0 }];
        round(cube).map(|x| RADIUS * x)
    };
    let (cells, region) = ([CELLS, CELLS, layers], |cell| (!air(cell)).then_some(0));
    let mut mesh = match kind {
        Kind::Linear => return box_mesh::grid(cells, half, place, region),
        Kind::Quadratic => box_mesh::to_quadratic(&box_mesh::grid(cells, half, place, region)),
        Kind::Quadrilateral => return box_mesh::quadratic_hexahedra(cells, half, place, region),
    };
    let Faces::Quadratic(faces) = &mesh.chambers[0].faces else { unreachable!("the mesh is quadratic") };
    for node in faces.iter().flatten() {
        let at = mesh.nodes[*node as usize];
        let size = at.iter().map(|x| x * x).sum::<f64>().sqrt();
        mesh.nodes[*node as usize] = at.map(|x| x * RADIUS / size);
    }
    mesh
}

/// Maps every point of a cube's surface onto the sphere of half its width.
fn round(at: [f64; 3]) -> [f64; 3] {
    let most = at.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let size = at.iter().map(|x| x * x).sum::<f64>().sqrt();
    at.map(|x| if size > 0.0 { x * most / size } else { 0.0 })
}

/// A wavy displacement, a fifth of the radius high, that maps the plane z = 0 to itself.
fn wave(mesh: &Mesh) -> Vec<f64> {
    let bend = |x: f64, phase: f64| 0.2 * RADIUS * (x / RADIUS + phase).sin();
    mesh.nodes.iter().flat_map(|at| [bend(at[1], 0.3), bend(at[0] + at[2], 1.0), 0.7 * bend(at[2], 0.0)]).collect()
}

/// The same on a ball that is pressed flat in y, so that its walls meet each other, and those of a half model their images.
fn flattened(mesh: &Mesh) -> Vec<f64> {
    let mut u = wave(mesh);
    u.iter_mut().skip(1).step_by(3).zip(&mesh.nodes).for_each(|(u, at)| *u -= 0.8 * at[1]);
    u
}

fn loads(mesh: &Mesh) -> Vec<Box<dyn Load>> {
    let forces = (0..3 * mesh.nodes.len()).map(|at| (at as f64).sin()).collect();
    let contact = SelfContact::new(mesh, Contact { range: 0.6 * RADIUS, pressure: 1e4 });
    let chamber = ChamberPressure::new(mesh, &mesh.chambers[0]);
    vec![Box::new(chamber), Box::new(DeadForces { forces }), Box::new(contact)]
}

/// Σ ∂²W/∂u_a∂u_b v_b
fn hessian_times(load: &dyn Load, u: &[f64], v: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; u.len()];
    load.add_hessian(u, 1.0, &mut |a, b, block: &Matrix3<f64>| {
        for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
            let (row, column) = (3 * a as usize + i, 3 * b as usize + k);
            image[row] += block[(i, k)] * v[column];
            image[column] += if a == b { 0.0 } else { block[(i, k)] * v[row] };
        }
    });
    image
}

fn along(u: &[f64], v: &[f64], step: f64) -> Vec<f64> {
    u.iter().zip(v).map(|(u, v)| u + step * v).collect()
}

#[test]
fn the_gradient_of_every_load_is_the_difference_of_its_potential() {
    for mesh in [ball(Kind::Linear, false), ball(Kind::Quadratic, false), ball(Kind::Quadratic, true)] {
        let (u, v): (Vec<f64>, Vec<f64>) =
            (flattened(&mesh), (0..3 * mesh.nodes.len()).map(|at| (0.7 * at as f64).cos()).collect());
        for load in loads(&mesh) {
            let step = 1e-4 * RADIUS;
            let difference =
                (load.potential(&along(&u, &v, step)) - load.potential(&along(&u, &v, -step))) / (2.0 * step);
            let mut gradient = vec![0.0; u.len()];
            load.add_gradient(&u, 1.0, &mut gradient);
            let exact: f64 = gradient.iter().zip(&v).map(|(g, v)| g * v).sum();
            assert!((difference - exact).abs() < 1e-6 * exact.abs(), "{difference} {exact}");
        }
    }
}

#[test]
fn the_gradient_of_gas_is_the_difference_of_its_potential_sealed_or_not() {
    let mesh = ball(Kind::Quadratic, false);
    let chamber = ChamberPressure::new(&mesh, &mesh.chambers[0]);
    let (u, v): (Vec<f64>, Vec<f64>) = (wave(&mesh), wave(&mesh).iter().rev().map(|u| 3.0 * u).collect());
    for (pressure, ambient) in [(2e4, None), (0.0, Some(1.013e5)), (2e4, Some(1.013e5))] {
        let gas = Gas { chamber: &chamber, pressure, ambient };
        let step = 1e-5;
        let difference = (gas.potential(&along(&u, &v, step)) - gas.potential(&along(&u, &v, -step))) / (2.0 * step);
        let mut gradient = vec![0.0; u.len()];
        gas.add_gradient(&u, &mut gradient);
        let exact: f64 = gradient.iter().zip(&v).map(|(g, v)| g * v).sum();
        assert!((difference - exact).abs() < 1e-6 * exact.abs(), "{difference} {exact}");
        // Boyle's law: (g + pₐ) V is that of the chamber at rest
        let volume = chamber.volume(&u);
        let held = ambient.map_or(pressure, |ambient| (pressure + ambient) * chamber.at_rest / volume - ambient);
        assert!((gas.gauge(volume) - held).abs() < 1e-9 * held.abs(), "{held}");
    }
    let rest = vec![0.0; u.len()];
    assert_eq!(Gas { chamber: &chamber, pressure: 2e4, ambient: Some(1e5) }.potential(&rest), 0.0);
}

#[test]
fn the_hessian_of_every_load_is_the_difference_of_its_gradient() {
    for mesh in [ball(Kind::Linear, false), ball(Kind::Quadratic, false), ball(Kind::Quadratic, true)] {
        let (u, v): (Vec<f64>, Vec<f64>) =
            (flattened(&mesh), (0..3 * mesh.nodes.len()).map(|at| (0.7 * at as f64).cos()).collect());
        for load in loads(&mesh) {
            let step = 2e-5 * RADIUS;
            let (mut above, mut below) = (vec![0.0; u.len()], vec![0.0; u.len()]);
            load.add_gradient(&along(&u, &v, step), 1.0, &mut above);
            load.add_gradient(&along(&u, &v, -step), 1.0, &mut below);
            let exact = hessian_times(load.as_ref(), &u, &v);
            let size = exact.iter().fold(1e-30, |most: f64, x| most.max(x.abs()));
            let errors = above
                .iter()
                .zip(&below)
                .zip(&exact)
                .map(|((above, below), exact)| ((above - below) / (2.0 * step) - exact).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(error < 1e-7 * size, "{error:e} of {size:e}");
        }
    }
}

#[test]
fn a_curved_cavity_has_the_volume_of_its_ball() {
    let mesh = ball(Kind::Quadratic, false);
    let volume = ChamberPressure::new(&mesh, &mesh.chambers[0]).volume(&vec![0.0; 3 * mesh.nodes.len()]);
    let exact = 4.0 / 3.0 * PI * RADIUS.powi(3);
    assert!((volume / exact - 1.0).abs() < 0.01, "{}", volume / exact);
}

/// The wall of a half model and its mirror image in one surface, with the displacement mirrored too.
fn mirrored(half: &Mesh, u: &[f64]) -> (Mesh, Vec<f64>) {
    let (mut whole, mut moved) = (half.clone(), u.to_vec());
    whole.symmetry_plane_z = false;
    let mut image = Vec::new();
    for (node, &[x, y, z]) in half.nodes.iter().enumerate() {
        if z == 0.0 {
            image.push(node as u32);
            continue;
        }
        image.push(whole.nodes.len() as u32);
        whole.nodes.push([x, y, -z]);
        moved.extend([u[3 * node], u[3 * node + 1], -u[3 * node + 2]]);
    }
    let of = |nodes: &[u32]| -> Vec<u32> { nodes.iter().map(|&node| image[node as usize]).collect() };
    whole.chambers[0].faces = match &half.chambers[0].faces {
        Faces::Linear(faces) => {
            let reversed = faces.iter().map(|face| [0, 2, 1].map(|n| of(face)[n]));
            Faces::Linear(faces.iter().copied().chain(reversed).collect())
        }
        Faces::Quadratic(faces) => {
            let reversed = faces.iter().map(|face| [0, 2, 1, 5, 4, 3].map(|n| of(face)[n]));
            Faces::Quadratic(faces.iter().copied().chain(reversed).collect())
        }
        Faces::QuadraticQuadrilaterals(faces) => {
            let reversed = faces.iter().map(|face| [0, 3, 2, 1, 7, 6, 5, 4].map(|n| of(face)[n]));
            Faces::QuadraticQuadrilaterals(faces.iter().copied().chain(reversed).collect())
        }
    };
    (whole, moved)
}

#[test]
fn a_half_model_has_half_the_volume_at_rest_and_deformed() {
    for kind in KINDS {
        let half = ball(kind, true);
        let u = wave(&half);
        let (whole, moved) = mirrored(&half, &u);
        crate::validation::check_closed(&whole, 0, &whole.chambers[0]).unwrap();
        let part = ChamberPressure::new(&half, &half.chambers[0]).volume(&u);
        let all = ChamberPressure::new(&whole, &whole.chambers[0]).volume(&moved);
        assert!((2.0 * part / all - 1.0).abs() < 1e-13, "{part} {all}");
    }
}

#[test]
fn pressure_in_a_closed_chamber_has_no_resultant() {
    let mesh = ball(Kind::Quadratic, false);
    let mut force = vec![0.0; 3 * mesh.nodes.len()];
    ChamberPressure::new(&mesh, &mesh.chambers[0]).add_gradient(&wave(&mesh), 1.0, &mut force);
    for axis in 0..3 {
        let sum: f64 = force.iter().skip(axis).step_by(3).sum();
        assert!(sum.abs() < 1e-15 * RADIUS);
    }
}
