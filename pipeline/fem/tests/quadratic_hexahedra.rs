//! Twenty-node hexahedra with shared integration, and the wedges among them: patch test, rigid rotation, beam, Cook's membrane, chambers, and derivatives of equilibria
//! and motions against differences. Thick walls and contact stand with those of tetrahedra.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Branch, Clamps, DynamicSettings, Elements, Equilibrium, Forces, InitialValueProblem, LossGradient, Mesh, Options,
    Parameter, RegionProperties, Relaxation, Scheme, SetupError, State, StaticSettings, System, box_mesh, materials,
    wedges,
};

const FINE: StaticSettings =
    StaticSettings { tolerance: 1e-12, load_steps: 3, max_iterations: 40, max_halvings: 40, reuse_factor: false };

fn region(law: &str, poissons_ratio: f64) -> RegionProperties {
    RegionProperties::elastic(materials::by_name(law).unwrap(), 2e5, poissons_ratio, 1e3)
}

fn solid(cells: [usize; 3], place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    box_mesh::quadratic_hexahedra(cells, false, place, |_| Some(0))
}

/// Hexahedra, or the wedges that they are cut into.
fn cut(mesh: Mesh, into_wedges: bool) -> Mesh {
    if into_wedges { wedges::split(&mesh) } else { mesh }
}

/// Sides at the far end along x, pulled by a traction.
fn pulled(mesh: &Mesh, traction: [f64; 3]) -> Vec<f64> {
    let Elements::QuadraticHexahedra(elements) = &mesh.elements else { panic!("20-node hexahedra") };
    let far = mesh.nodes.iter().fold(0.0, |most: f64, at| most.max(at[0]));
    let sides = elements.iter().map(|nodes| [1, 2, 6, 5, 9, 18, 13, 17].map(|n| nodes[n]));
    let on_end = |side: &[u32; 8]| side.iter().all(|&node| mesh.nodes[node as usize][0] > far - 1e-9);
    sides.filter(on_end).fold(Forces::none(mesh), |sum, side| sum.on_face(&side, traction).unwrap()).as_slice().to_vec()
}

/// The largest displacement along an axis.
fn largest(found: &Equilibrium, axis: usize) -> f64 {
    found.displacement.chunks_exact(3).fold(0.0, |most: f64, u| most.max(u[axis].abs()))
}

#[test]
fn inner_nodes_of_a_skewed_patch_are_in_balance_under_a_homogeneous_deformation() {
    let mesh = solid([3, 2, 2], |[x, y, z]| [0.03 * x + 0.004 * y, 0.02 * y - 0.003 * z, 0.02 * z + 0.002 * x]);
    let bounds = mesh.bounds();
    balanced(&mesh, 8);
    // a corner of twelve wedges; the box is sheared, so that its faces are found by their elements
    balanced(&wedges::split(&mesh), 12);
    assert_eq!(wedges::split(&mesh).bounds(), bounds);
}

/// Checks the forces on the nodes with so many elements under a homogeneous deformation.
fn balanced(mesh: &Mesh, around: usize) {
    let own = |node: usize| {
        let Elements::QuadraticHexahedra(elements) = &mesh.elements else { panic!("20-node hexahedra") };
        elements.iter().filter(|nodes| nodes.contains(&(node as u32))).count()
    };
    // a corner inside has eight elements, the middle of an edge inside four
    let inside: Vec<usize> = (0..mesh.nodes.len()).filter(|&node| own(node) == around).collect();
    assert!(!inside.is_empty());
    let stretch = |at: &[f64; 3]| [0.1 * at[0] + 0.05 * at[1], -0.03 * at[1], 0.04 * at[2] - 0.02 * at[0]];
    let field: Vec<f64> = mesh.nodes.iter().flat_map(stretch).collect();
    for law in ["linear", "neo_hookean"] {
        let system = System::new(mesh.clone(), vec![region(law, 0.45)], Clamps::below_x(mesh, 1e-3)).unwrap();
        let solver = system.solver();
        let energy = |node: usize, axis: usize, step: f64| {
            let mut moved = field.clone();
            moved[3 * node + axis] += step;
            solver.elastic_energy(&moved).unwrap()
        };
        let scale = energy(0, 0, 0.0) / 0.03;
        for (node, axis) in inside.iter().flat_map(|&node| (0..3).map(move |axis| (node, axis))) {
            let force = (energy(node, axis, 1e-7) - energy(node, axis, -1e-7)) / 2e-7;
            assert!(force.abs() < 1e-6 * scale, "{law} {node} {axis}: {force:e} of {scale:e}");
        }
    }
}

#[test]
fn a_rigid_rotation_costs_no_energy_and_the_rest_volume_and_mass_are_those_of_the_box() {
    for (lumped_mass, into_wedges) in [(false, false), (true, false), (false, true), (true, true)] {
        let mesh = cut(solid([3, 2, 2], |[x, y, z]| [0.1 * x, 0.02 * y, 0.03 * z]), into_wedges);
        let (sine, cosine) = 0.7f64.sin_cos();
        let turned =
            |at: &[f64; 3]| [cosine * at[0] - sine * at[1] - at[0], sine * at[0] + cosine * at[1] - at[1], 0.01];
        let field: Vec<f64> = mesh.nodes.iter().flat_map(turned).collect();
        let options = Options { lumped_mass, ..Options::default() };
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let system = System::with(mesh, vec![region("neo_hookean", 0.45)], clamps, options).unwrap();
        assert!(system.solver().elastic_energy(&field).unwrap().abs() < 1e-14);
        assert!((system.volume() - 6e-5).abs() < 1e-18 && (system.mass() - 0.06).abs() < 1e-15);
    }
}

#[test]
fn one_element_through_a_beam_bends_it_as_beam_theory_says() {
    let (length, width, force) = (0.1, 0.005, 1e-4);
    for (nu, law, into_wedges) in [(0.0, "linear", false), (0.3, "neo_hookean", false), (0.3, "neo_hookean", true)] {
        let mesh = cut(solid([10, 1, 1], |[x, y, z]| [length * x, width * y, width * z]), into_wedges);
        let forces = pulled(&mesh, [0.0, 0.0, force / (width * width)]);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let system = System::new(mesh, vec![region(law, nu)], clamps).unwrap();
        let mut solver = system.solver();
        solver.set_forces(&forces).unwrap();
        let found = solver.equilibrium(&[], None, &FINE).unwrap();
        let (modulus, area) = (2e5, width * width);
        let [inertia, shear] = [area * area / 12.0, modulus / (2.0 * (1.0 + nu))];
        let theory = force * length.powi(3) / (3.0 * modulus * inertia) + force * length / (5.0 / 6.0 * shear * area);
        // the clamp holds the width of its section, which theory lets contract
        assert!((largest(&found, 2) / theory - 1.0).abs() < 0.02, "{law}: {} of {theory}", largest(&found, 2));
    }
}

#[test]
fn cook_s_membrane_does_not_lock_close_to_incompressibility() {
    // 48 × 44 to 16, thickness 1 held in plane strain, E = 70, sheared by 1/16 along its end
    let tip_of = |n: usize, nu: f64, into_wedges: bool| {
        let place = |[x, y, z]: [f64; 3]| [48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x), z].map(|at| 1e-3 * at);
        let mesh = cut(solid([n, n, 1], place), into_wedges);
        let forces = pulled(&mesh, [0.0, 70.0 / 16.0, 0.0]);
        let clamps = Clamps::below_x(&mesh, 1e-9).and(&Clamps::where_nodes(&mesh, [false, false, true], |_| true));
        let silicone = RegionProperties { youngs_modulus: 70.0 * 70.0, ..region("linear", nu) };
        let system = System::new(mesh, vec![silicone], clamps).unwrap();
        let mut solver = system.solver();
        solver.set_forces(&forces).unwrap();
        largest(&solver.equilibrium(&[], None, &FINE).unwrap(), 1)
    };
    let tip = |n: usize, nu: f64| tip_of(n, nu, false);
    let (coarse, fine) = (tip(8, 0.4999), tip(16, 0.4999));
    // wedges have twelve points of the λ part where a hexahedron has eight: stiffer, and no more so than refinement mends
    let wedges = [8, 16].map(|n| 1.0 - tip_of(n, 0.4999, true) / fine);
    assert!(wedges[0] < 0.08 && wedges[1] < 0.5 * wedges[0], "{wedges:?}");
    // the stress at the upper clamped corner is singular
    assert!((coarse / fine - 1.0).abs() < 0.03, "{coarse} {fine}");
    // plane strain and nearly incompressible: stiffer than a compressible one by less than a third
    assert!(fine / tip(16, 0.3) > 0.65, "{fine} {}", tip(16, 0.3));
}

/// A bar of 60 × 20 × 20 mm, half of it meshed: a chamber beside a stiff sheet.
fn bar(shear_share: Option<f64>, into_wedges: bool) -> Result<System, SetupError> {
    let air = |cell: [usize; 3]| (1..4).contains(&cell[0]) && cell[1] == 2 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1] * (0.6 + 0.4 * at[1]), 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    let mesh = cut(box_mesh::quadratic_hexahedra([5, 4, 2], true, place, region), into_wedges);
    let silicone = self::region("neo_hookean", 0.45);
    let sheet = RegionProperties { youngs_modulus: 1e7, poissons_ratio: 0.35, ..silicone.clone() };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::with(mesh, vec![silicone, sheet], clamps, Options { shear_share, ..Options::default() })
}

/// Weights of the displacements in a scalar that does not cancel: by the distance from the clamp.
fn weights(system: &System) -> Vec<f64> {
    system.mesh().nodes.iter().flat_map(|at| [0.3, 1.0, 0.5].map(|axis| 1e3 * axis * at[0])).collect()
}

#[test]
fn the_volume_of_a_chamber_is_that_of_its_cells_and_its_wall_is_closed() {
    for into_wedges in [false, true] {
        cavity(&bar(None, into_wedges).unwrap());
    }
    assert!(matches!(bar(Some(1.5), false), Err(SetupError::ShearShare { .. })));
}

fn cavity(system: &System) {
    // y from 0.5 to 0.75 of the height: 0.02 · (0.75 · 0.9 − 0.5 · 0.8)
    let volume = 3.0 / 5.0 * 0.06 * 0.02 * (0.75 * 0.9 - 0.5 * 0.8) * 0.005;
    let rest = vec![0.0; 3 * system.mesh().nodes.len()];
    assert!((system.chamber_volume(0, &rest) / volume - 1.0).abs() < 1e-12, "{}", system.chamber_volume(0, &rest));
}

#[test]
fn adjoint_and_sensitivities_of_an_equilibrium_are_differences_for_every_share() {
    for (share, into_wedges) in [(0.0, false), (0.1, false), (0.25, false), (1.0, false), (0.0, true), (0.25, true)] {
        let system = bar(Some(share), into_wedges).unwrap();
        let (mut solver, along) = (system.solver(), weights(&system));
        let first = solver.equilibrium(&[5e3], None, &FINE).unwrap();
        let gradient = solver.adjoint(&first, &along).unwrap();
        let by_pressure = solver.sensitivity(&first, Parameter::Pressure(0)).unwrap();
        let by_pressure: f64 = by_pressure.iter().zip(&along).map(|(u, w)| u * w).sum();
        let mut loss = |e: f64, nu: f64, pressure: f64| {
            solver.set_elastic(0, e, nu).unwrap();
            let found = solver.equilibrium(&[pressure], Some(&first.displacement), &FINE).unwrap();
            found.displacement.iter().zip(&along).map(|(u, w)| u * w).sum::<f64>()
        };
        let differences = [
            (loss(2.002e5, 0.45, 5e3) - loss(1.998e5, 0.45, 5e3)) / 400.0,
            (loss(2e5, 0.4501, 5e3) - loss(2e5, 0.4499, 5e3)) / 2e-4,
            (loss(2e5, 0.45, 5.002e3) - loss(2e5, 0.45, 4.998e3)) / 4.0,
        ];
        let exact = [gradient[0].youngs_modulus, gradient[0].poissons_ratio, by_pressure];
        for (exact, difference) in exact.into_iter().zip(differences) {
            assert!((exact / difference - 1.0).abs() < 1e-5, "share {share}: {exact:e} {difference:e}");
        }
    }
}

#[test]
fn a_relaxing_motion_has_the_gradient_of_differences() {
    for into_wedges in [false, true] {
        relaxing(&bar(None, into_wedges).unwrap());
    }
}

fn relaxing(system: &System) {
    let along = weights(system);
    let settings = DynamicSettings { step: 4e-3, scheme: Scheme::Bdf2, tolerance: 5e-12, ..DynamicSettings::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let pressures = |t: f64| vec![4e3 * (t / 0.02).min(1.0)];
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures };
    let solver = |e: f64, strength: f64| {
        let mut solver = system.solver();
        solver.set_elastic(0, e, 0.45).unwrap();
        solver.set_relaxation(0, Relaxation::maxwell(&[Branch { strength, time: 0.01 }]).unwrap()).unwrap();
        solver
    };
    let steps = 8;
    let end = |e: f64, strength: f64| -> f64 {
        let end = solver(e, strength).integrate(&problem, steps, &mut |_, _| ()).unwrap();
        end.displacement.iter().zip(&along).map(|(u, w)| u * w).sum()
    };
    let mut own = solver(2e5, 0.3);
    let trajectory = own.record(&problem, steps, usize::MAX).unwrap();
    let mut loss = |n: usize, _: &State| LossGradient {
        displacement: if n == steps { along.clone() } else { Vec::new() },
        velocity: Vec::new(),
    };
    let gradient = own.trajectory_adjoint(&trajectory, &mut loss).unwrap();
    let by_modulus = (end(2.001e5, 0.3) - end(1.999e5, 0.3)) / 200.0;
    let by_strength = (end(2e5, 0.3005) - end(2e5, 0.2995)) / 1e-3;
    let modulus = gradient.regions[0].youngs_modulus;
    assert!((modulus / by_modulus - 1.0).abs() < 1e-4, "{modulus:e} {by_modulus:e}");
    let branch = gradient.relaxation[0][0][0];
    assert!((branch / by_strength - 1.0).abs() < 1e-4, "{branch:e} {by_strength:e}");
}
