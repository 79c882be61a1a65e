//! The equilibrium under pressure does not depend on the time step.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, DynamicSettings, InitialValueProblem, RegionProperties, Scheme, State, StaticSettings, System, box_mesh,
    materials,
};

const PRESSURE: f64 = 3e4;

/// A bar of 40 × 12 × 12 mm, half of it meshed, with a chamber beside a stiff sheet.
fn bar() -> System {
    let air = |cell: [usize; 3]| (1..4).contains(&cell[0]) && cell[1] == 2 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.04 * at[0], 0.012 * at[1], 0.006 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([5, 4, 2], true, place, region));
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let material = materials::by_name("corotated").unwrap();
    let body = RegionProperties::elastic(material, 2e5, 0.45, 1070.0);
    let sheet = RegionProperties { youngs_modulus: 4e6, poissons_ratio: 0.4, ..body.clone() };
    System::new(mesh, vec![body, sheet], clamps).unwrap()
}

#[test]
fn the_tip_at_rest_is_the_same_for_time_steps_of_ten_one_and_a_tenth_of_a_millisecond() {
    let system = bar();
    let nodes = &system.mesh().nodes;
    let tip = (0..nodes.len()).max_by(|&a, &b| nodes[a][0].total_cmp(&nodes[b][0])).unwrap();
    let mut solver = system.solver();
    let rest = solver.equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap().displacement[3 * tip + 1];
    assert!(rest.abs() > 5e-4, "the bar bends visibly: {rest}");
    for scheme in [Scheme::ImplicitEuler, Scheme::Bdf2] {
        for (step, steps) in [(1e-2, 60), (1e-3, 200), (1e-4, 1500)] {
            let settings = DynamicSettings {
                step,
                scheme,
                mass_damping: 150.0,
                stiffness_damping: 1e-4,
                ..DynamicSettings::default()
            };
            let mut last = 0.0;
            let mut see = |_: f64, state: &State| last = state.displacement[3 * tip + 1];
            solver
                .integrate(
                    &InitialValueProblem {
                        settings: &settings,
                        initial: &State::rest(nodes.len()),
                        pressures: &|_| vec![PRESSURE],
                    },
                    steps,
                    &mut see,
                )
                .unwrap();
            // what is left of the motion, and of each step's own tolerance
            assert!((last / rest - 1.0).abs() < 1e-4, "{scheme:?} at {step:e} s: {}", last / rest);
        }
    }
}
