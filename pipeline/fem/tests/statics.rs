//! Statics against closed forms: uniform strain, beams, and shells under pressure.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Clamps, Mesh, RegionProperties, StaticSettings, System, box_mesh, materials};

fn made_of(material: &str, youngs_modulus: f64, poissons_ratio: f64) -> RegionProperties {
    let material = materials::by_name(material).unwrap();
    RegionProperties::elastic(material, youngs_modulus, poissons_ratio, 1070.0)
}

/// 30 × 20 × 10 mm, with its inner nodes shaken so that no element is like another.
fn shaken(mut mesh: Mesh) -> Mesh {
    let size = [0.03, 0.02, 0.01];
    for node in &mut mesh.nodes {
        if (0..3).all(|axis| node[axis] > 1e-9 && node[axis] < size[axis] - 1e-9) {
            let position = *node;
            (0..3).for_each(|axis| {
                node[axis] += 4e-4 * (900.0 * position[(axis + 1) % 3] + 500.0 * position[axis]).sin()
            });
        }
    }
    mesh
}

#[test]
fn a_uniform_stretch_passes_the_patch_test_for_every_material_and_element() {
    let linear = shaken(box_mesh::linear([0.03, 0.02, 0.01], [3, 2, 2]));
    for mesh in [box_mesh::to_quadratic(&linear), linear] {
        for law in materials::ALL {
            // rollers on three sides, and dead forces that pull the end x = 30 mm with a uniform stress
            let mut clamps = Clamps::none();
            for axis in 0..3 {
                let axes = std::array::from_fn(|other| other == axis);
                clamps = clamps.and(&Clamps::where_nodes(&mesh, axes, |at| at[axis] < 1e-9));
            }
            let system = System::new(mesh.clone(), vec![made_of(law.name(), 2e5, 0.4)], clamps).unwrap();
            let mut solver = system.solver();
            solver.set_forces(&pull(&mesh, 0.03, 2e4)).unwrap();
            let equilibrium =
                solver.equilibrium(&[], None, &StaticSettings { tolerance: 1e-13, ..Default::default() }).unwrap();
            let stretch = uniform(&mesh, &equilibrium.displacement);
            let worst = mesh
                .nodes
                .iter()
                .zip(equilibrium.displacement.chunks(3))
                .flat_map(|(at, moved)| (0..3).map(move |axis| (moved[axis] - stretch[axis] * at[axis]).abs()));
            let worst = worst.fold(0.0, f64::max);
            assert!(worst < 1e-10 * 0.03 * stretch[0].abs(), "{} {worst:e} {}", law.name(), equilibrium.residual);
            assert!(stretch[0] > 0.08 && stretch[1] < -0.03);
        }
    }
}

/// Strain along each axis, read off the far corner.
fn uniform(mesh: &Mesh, displacement: &[f64]) -> [f64; 3] {
    let (_, far) = mesh.bounds();
    let corner = mesh.nodes.iter().position(|at| *at == far).unwrap();
    std::array::from_fn(|axis| displacement[3 * corner + axis] / far[axis])
}

/// Nodal forces of a uniform traction (Pa) along x on the side x = `end`.
fn pull(mesh: &Mesh, end: f64, traction: f64) -> Vec<f64> {
    side_forces(mesh, end, [traction, 0.0, 0.0])
}

/// Nodal forces of a uniform traction (Pa) on the side x = `end`, from the sides of elements that lie on it.
fn side_forces(mesh: &Mesh, end: f64, traction: [f64; 3]) -> Vec<f64> {
    let mut forces = vec![0.0; 3 * mesh.nodes.len()];
    for element in 0..mesh.elements.len() {
        let nodes = mesh.elements.nodes(element);
        let on_side: Vec<usize> = (0..4).filter(|&n| (mesh.nodes[nodes[n] as usize][0] - end).abs() < 1e-9).collect();
        if on_side.len() != 3 {
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|n| mesh.nodes[nodes[on_side[n]] as usize]);
        let area = 0.5 * ((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])).abs();
        // ∫ N over a straight triangle: a third at each corner of 3 nodes; a third at each middle of 6, none at corners
        let takers: Vec<u32> = if nodes.len() == 4 {
            on_side.iter().map(|&n| nodes[n]).collect()
        } else {
            nodes[4..].iter().copied().filter(|&n| (mesh.nodes[n as usize][0] - end).abs() < 1e-9).collect()
        };
        for node in takers {
            (0..3).for_each(|axis| forces[3 * node as usize + axis] += traction[axis] * area / 3.0);
        }
    }
    forces
}

#[test]
fn one_layer_of_quadratic_elements_bends_like_timoshenkos_beam_near_incompressibility() {
    let (length, width, height) = (0.04, 0.004, 0.002);
    let (e, nu) = (2e5, 0.499);
    let mesh = box_mesh::quadratic([length, width, height], [30, 2, 1]);
    // the clamp lets its section contract and curl sideways, as the beam's theory has it
    let on_axis = |at: [f64; 3], axis: usize, size: f64| at[0] < 1e-9 && (at[axis] - 0.5 * size).abs() < 1e-9;
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0] < 1e-9)
        .and(&Clamps::where_nodes(&mesh, [false, true, false], |at| on_axis(at, 1, width)))
        .and(&Clamps::where_nodes(&mesh, [false, false, true], |at| on_axis(at, 1, width) && on_axis(at, 2, height)));
    let force = 1e-5;
    let forces = side_forces(&mesh, length, [0.0, 0.0, force / (width * height)]);
    let tip =
        mesh.nodes.iter().position(|at| (at[0] - length).abs() < 1e-9 && (at[2] - 0.5 * height).abs() < 1e-9).unwrap();
    let system = System::new(mesh, vec![made_of("linear", e, nu)], clamps).unwrap();
    let mut solver = system.solver();
    solver.set_forces(&forces).unwrap();
    let equilibrium = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    let second_moment = width * height.powi(3) / 12.0;
    let shear = e / (2.0 * (1.0 + nu)) * width * height * 5.0 / 6.0;
    let exact = force * length.powi(3) / (3.0 * e * second_moment) + force * length / shear;
    let ratio = equilibrium.displacement[3 * tip + 2] / exact;
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

/// A cube with a round cavity, mapped to a thick sphere; an eighth of it by rollers would do, half is enough here.
fn thick_sphere(inner: f64, outer: f64, layers: usize) -> Mesh {
    let half = 2;
    let cells = 2 * (half + layers);
    let position = move |at: [f64; 3]| {
        let cube = [2.0 * at[0] - 1.0, 2.0 * at[1] - 1.0, at[2]].map(|x| x * (half + layers) as f64);
        let max_norm = cube.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let size = cube.iter().map(|x| x * x).sum::<f64>().sqrt();
        let radius = inner + (outer - inner) * (max_norm - half as f64) / layers as f64;
        cube.map(|x| if max_norm < half as f64 - 0.5 { 0.0 } else { x / size * radius })
    };
    let air = move |cell: [usize; 3]| {
        [cell[0], cell[1]].iter().all(|&at| at >= layers && at < layers + 2 * half) && cell[2] < half
    };
    let straight = box_mesh::grid([cells, cells, cells / 2], true, position, |cell| (!air(cell)).then_some(0));
    let mut mesh = box_mesh::to_quadratic(&straight);
    // middle nodes onto their spheres: those of edges whose ends have the same radius
    let radius = |at: [f64; 3]| at.iter().map(|x| x * x).sum::<f64>().sqrt();
    for shell in 0..=layers {
        let shell_radius = inner + (outer - inner) * shell as f64 / layers as f64;
        let on_shell: Vec<bool> = straight.nodes.iter().map(|&at| (radius(at) - shell_radius).abs() < 1e-9).collect();
        let fem::Elements::Quadratic(tets) = &mesh.elements else { unreachable!() };
        let edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];
        let mut projected = mesh.nodes.clone();
        for tet in tets {
            for (edge, (a, b)) in edges.into_iter().enumerate() {
                if on_shell[tet[a] as usize] && on_shell[tet[b] as usize] {
                    let edge_middle = mesh.nodes[tet[4 + edge] as usize];
                    projected[tet[4 + edge] as usize] = edge_middle.map(|x| x * shell_radius / radius(edge_middle));
                }
            }
        }
        mesh.nodes = projected;
    }
    mesh
}

#[test]
fn a_thick_sphere_under_pressure_agrees_with_lames_solution() {
    let (a, b, e, nu, pressure) = (0.01, 0.02, 2e5, 0.45, 100.0);
    let mesh = thick_sphere(a, b, 3);
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0].abs() < 1e-9).and(&Clamps::where_nodes(
        &mesh,
        [false, true, false],
        |at| at[1].abs() < 1e-9,
    ));
    let system = System::new(mesh.clone(), vec![made_of("neo_hookean", e, nu)], clamps).unwrap();
    let equilibrium = system.solver().equilibrium(&[pressure], None, &StaticSettings::default()).unwrap();
    let radial = |wanted: f64| {
        let wall_nodes = mesh.nodes.iter().enumerate().filter(|(_, at)| (norm(at) - wanted).abs() < 1e-6);
        let radial_displacements: Vec<f64> = wall_nodes
            .map(|(node, at)| {
                (0..3).map(|axis| equilibrium.displacement[3 * node + axis] * at[axis]).sum::<f64>() / wanted
            })
            .collect();
        radial_displacements.iter().sum::<f64>() / radial_displacements.len() as f64
    };
    let scale = pressure * a.powi(3) / (e * (b.powi(3) - a.powi(3)));
    for r in [a, b] {
        let exact = scale * ((1.0 - 2.0 * nu) * r + (1.0 + nu) * b.powi(3) / (2.0 * r * r));
        assert!((radial(r) / exact - 1.0).abs() < 0.01, "{r} {}", radial(r) / exact);
    }
}

fn norm(at: &[f64; 3]) -> f64 {
    at.iter().map(|x| x * x).sum::<f64>().sqrt()
}
