//! Displaced clamps against dead forces, closed forms and the work that they do.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, Equilibrium, Mesh, Parameter, RegionProperties, SolveError, Solver, StaticSettings, System, box_mesh,
    materials,
};

const SIZE: [f64; 3] = [0.04, 0.01, 0.01];
const MODULUS: f64 = 2e5;
const SETTINGS: StaticSettings =
    StaticSettings { tolerance: 1e-11, load_steps: 3, max_iterations: 40, max_halvings: 40, reuse_factor: false };

fn bar(poissons_ratio: f64, clamps: impl Fn(&Mesh) -> Clamps) -> System {
    let mesh =
        box_mesh::quadratic_hexahedra([4, 2, 2], false, |at| [0, 1, 2].map(|axis| SIZE[axis] * at[axis]), |_| Some(0));
    let silicone =
        RegionProperties::elastic(materials::by_name("neo_hookean").unwrap(), MODULUS, poissons_ratio, 1070.0);
    let grips = clamps(&mesh);
    System::new(mesh, vec![silicone], &grips).unwrap()
}

/// Rollers on the three sides at 0, and along x on the end.
fn rollers(mesh: &Mesh) -> Clamps {
    let side =
        |axis: usize| Clamps::where_nodes(mesh, std::array::from_fn(|other| other == axis), move |at| at[axis] < 1e-9);
    let end = Clamps::where_nodes(mesh, [true, false, false], |at| at[0] > SIZE[0] - 1e-9);
    side(0).and(&side(1)).and(&side(2)).and(&end)
}

/// Grips on both ends.
fn grips(mesh: &Mesh) -> Clamps {
    Clamps::where_nodes(mesh, [true; 3], |at| at[0] < 1e-9 || at[0] > SIZE[0] - 1e-9)
}

fn end_nodes(mesh: &Mesh) -> impl Iterator<Item = usize> + '_ {
    (0..mesh.nodes.len()).filter(|&node| mesh.nodes[node][0] > SIZE[0] - 1e-9)
}

/// The end moved by `motion`, along those axes that are not 0.
fn moved_end(mesh: &Mesh, motion: [f64; 3]) -> Vec<f64> {
    let mut displacement = vec![0.0; 3 * mesh.nodes.len()];
    end_nodes(mesh).for_each(|node| displacement[3 * node..3 * node + 3].copy_from_slice(&motion));
    displacement
}

fn stretched(solver: &mut Solver, mesh: &Mesh, motion: [f64; 3], guess: Option<&Equilibrium>) -> Equilibrium {
    solver.prescribe(&moved_end(mesh, motion)).unwrap();
    solver.equilibrium(&[], guess.map(|at| at.displacement.as_slice()), &SETTINGS).unwrap()
}

/// The force on the body at its end, N.
fn reaction(solver: &Solver, mesh: &Mesh, at: &Equilibrium) -> [f64; 3] {
    let residual = solver.residual(&at.displacement, &[]).unwrap();
    [0, 1, 2].map(|axis| end_nodes(mesh).map(|node| residual[3 * node + axis]).sum())
}

#[test]
fn a_bar_between_grips_that_let_it_thin_pulls_as_its_law_says() {
    let system = bar(0.4995, rollers);
    let mesh = system.mesh();
    let mut solver = system.solver();
    for stretch in [0.6, 0.9, 1.5, 2.0, 3.0] {
        let equilibrium = stretched(&mut solver, mesh, [(stretch - 1.0) * SIZE[0], 0.0, 0.0], None);
        let force = reaction(&solver, mesh, &equilibrium)[0];
        // an incompressible neo-Hookean bar: μ (λ − λ⁻²) A
        let exact = MODULUS / 3.0 * (stretch - stretch.powi(-2)) * SIZE[1] * SIZE[2];
        assert!((force / exact - 1.0).abs() < 3e-3, "{stretch}: {force} {exact}");
    }
}

#[test]
fn the_reaction_of_a_grip_is_the_derivative_of_the_energy_by_its_motion() {
    let system = bar(0.45, grips);
    let (mesh, mut solver) = (system.mesh(), system.solver());
    for motion in [[0.016, 0.0, 0.0], [-0.006, 0.004, 0.0], [0.0, 0.01, 0.005]] {
        let mut energy_at = |part: f64| {
            let equilibrium = stretched(&mut solver, mesh, motion.map(|u| part * u), None);
            (solver.elastic_energy(&equilibrium.displacement).unwrap(), reaction(&solver, mesh, &equilibrium))
        };
        let step = 1e-4;
        let [(above, _), (below, _), (_, force)] = [1.0 + step, 1.0 - step, 1.0].map(&mut energy_at);
        let (difference, work) =
            ((above - below) / (2.0 * step), force.iter().zip(motion).map(|(f, u)| f * u).sum::<f64>());
        assert!((difference / work - 1.0).abs() < 1e-6, "{motion:?}: {difference} {work}");
    }
}

#[test]
fn a_level_started_from_the_one_before_ends_where_load_stepping_does() {
    let system = bar(0.45, grips);
    let (mesh, mut solver) = (system.mesh(), system.solver());
    let half = stretched(&mut solver, mesh, [0.012, 0.0, 0.0], None);
    let from_half = stretched(&mut solver, mesh, [0.024, 0.0, 0.0], Some(&half));
    let from_rest = stretched(&mut solver, mesh, [0.024, 0.0, 0.0], None);
    assert!(!from_half.load_stepped && from_rest.load_stepped && from_half.factorisations < from_rest.factorisations);
    let difference =
        from_half.displacement.iter().zip(&from_rest.displacement).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-9, "{difference:e}");
    // and back at rest nothing is left
    solver.prescribe(&[]).unwrap();
    let unloaded = solver.equilibrium(&[], Some(&from_half.displacement), &SETTINGS).unwrap();
    assert!(unloaded.displacement.iter().all(|u| u.abs() < 1e-9));
}

#[test]
fn sensitivities_at_a_stretched_shape_are_differences() {
    let system = bar(0.45, grips);
    let (mesh, mut solver) = (system.mesh(), system.solver());
    let motion = [0.02, 0.003, 0.0];
    let equilibrium = stretched(&mut solver, mesh, motion, None);
    let derivative = solver.sensitivity(&equilibrium, Parameter::PoissonsRatio(0)).unwrap();
    let mut shape = |ratio: f64| {
        solver.set_elastic(0, MODULUS, ratio).unwrap();
        stretched(&mut solver, mesh, motion, Some(&equilibrium)).displacement
    };
    let (above, below) = (shape(0.4501), shape(0.4499));
    let largest = derivative.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    for ((above, below), derivative) in above.iter().zip(&below).zip(&derivative) {
        assert!(((above - below) / 2e-4 - derivative).abs() < 1e-4 * largest);
    }
}

#[test]
fn a_displacement_of_a_free_axis_is_refused() {
    let system = bar(0.45, rollers);
    let mut solver = system.solver();
    let refused = solver.prescribe(&moved_end(system.mesh(), [0.0, 1e-3, 0.0])).unwrap_err();
    assert!(matches!(refused, SolveError::Setting { .. }), "{refused}");
    assert!(refused.to_string().contains("no clamp holds"), "{refused}");
    assert!(matches!(solver.prescribe(&[0.0]), Err(SolveError::Length { .. })));
}
