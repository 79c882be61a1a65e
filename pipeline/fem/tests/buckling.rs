//! Snap-through of thin walls: the equilibrium beyond it is found.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Clamps, Mesh, RegionProperties, StaticSettings, System, box_mesh, materials};

/// A block of 40 × 40 × 14 mm, half of it in z, whose chamber has a thin roof in +y that is arched outwards by 3 mm.
fn arched_box() -> Mesh {
    let air = |cell: [usize; 3]| (2..10).contains(&cell[0]) && cell[1] == 1 && cell[2] < 4;
    let position = |at: [f64; 3]| {
        let (x, z) = (0.04 * at[0], 0.02 * at[2]);
        let level = [0.0, 0.005, 0.011, 0.012][(3.0 * at[1]).round() as usize];
        let hump = ((x - 0.02) / 0.02).powi(2) + (z / 0.02).powi(2);
        let arch = if at[1] > 0.5 { 0.003 * (1.0 - hump).max(0.0) } else { 0.0 };
        [x, level + arch, z]
    };
    box_mesh::to_quadratic(&box_mesh::grid([12, 3, 6], true, position, |cell| (!air(cell)).then_some(0)))
}

/// [`arched_box`] of rubber, its floor clamped.
fn clamped() -> System {
    let mesh = arched_box();
    let material = materials::by_name("neo_hookean").unwrap();
    let clamps = Clamps::where_nodes(&mesh, [true; 3], |at| at[1] < 1e-9);
    let regions = vec![RegionProperties::elastic(material, 2e5, 0.45, 1070.0)];
    System::new(mesh, regions, clamps).unwrap()
}

#[test]
fn a_thin_arched_roof_snaps_through_under_suction_to_the_equilibrium_beyond() {
    let system = clamped();
    let nodes = &system.mesh().nodes;
    let top = (0..nodes.len()).max_by(|&a, &b| nodes[a][1].total_cmp(&nodes[b][1])).unwrap();
    let mut solver = system.solver();
    let (mut heights, mut snapped_through) = (Vec::new(), Vec::new());
    let mut start: Option<Vec<f64>> = None;
    for pressure in [-20.0, -150.0, -1000.0] {
        let equilibrium = solver.equilibrium(&[pressure], start.as_deref(), &StaticSettings::default()).unwrap();
        assert!(equilibrium.residual < 1e-6, "{}", equilibrium.residual);
        snapped_through.push(!equilibrium.snap_through.is_empty());
        heights.push(equilibrium.displacement[3 * top + 1]);
        start = Some(equilibrium.displacement);
    }
    assert!(heights[0] > -5e-4 && heights[1] < -3e-3 && heights[2] < -6e-3, "{heights:?}");
    assert!(!snapped_through[0] && snapped_through[2], "and it says where: {snapped_through:?}");
}

#[test]
fn the_path_of_a_suction_that_rises_in_three_levels_leads_through_the_snap() {
    let system = clamped();
    let nodes = system.mesh().nodes.len();
    let (mut solver, settings) = (system.solver(), StaticSettings::default());
    let mut equilibria = vec![(0.0, vec![0.0; 3 * nodes])];
    for pressure in [-20.0, -150.0, -1000.0] {
        let shapes: Vec<(f64, &[f64])> = equilibria.iter().map(|(p, shape)| (*p, shape.as_slice())).collect();
        let equilibrium = solver.equilibrium_from(&shapes, &[pressure], &settings).unwrap();
        assert!(equilibrium.residual < 1e-5 && equilibrium.pressures == [pressure], "{}", equilibrium.residual);
        equilibria.push((pressure, equilibrium.displacement));
    }
    // beyond the snap there is one equilibrium
    let post_snap = solver.equilibrium(&[-1000.0], Some(&equilibria[3].1), &settings).unwrap();
    let largest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, |most: f64, x| most.max(x.abs()));
    let deviation = largest(&mut equilibria[3].1.iter().zip(&post_snap.displacement).map(|(a, b)| a - b));
    assert!(deviation < 1e-6 && largest(&mut equilibria[3].1.iter().copied()) > 6e-3, "off by {deviation} m");
}

/// A suction of 60 to 960 Pa, by equal steps.
#[test]
fn reduced_equilibria_follow_the_roof_inwards_from_any_of_its_shapes() {
    let system = clamped();
    let undeformed = vec![0.0; 3 * system.mesh().nodes.len()];
    let (mut solver, settings) = (system.solver(), StaticSettings::default());
    let mut equilibria = vec![(0.0, undeformed)];
    for level in 1..=16 {
        let shapes: Vec<(f64, &[f64])> = equilibria.iter().map(|(p, shape)| (*p, shape.as_slice())).collect();
        let pressure = -60.0 * f64::from(level);
        equilibria.push((pressure, solver.equilibrium_from(&shapes, &[pressure], &settings).unwrap().displacement));
    }
    let shapes: Vec<&[f64]> = equilibria[1..].iter().map(|(_, shape)| shape.as_slice()).collect();
    let reduced = system.reduce(&shapes, &fem::ReductionSettings { tolerance: 1e-6, ..Default::default() }).unwrap();
    for start in [&equilibria[0].1, &equilibria[8].1, &equilibria[16].1].map(|shape| reduced.projected(shape)) {
        for (pressure, shape) in &equilibria[1..] {
            let displacement = reduced.displacement(&reduced.equilibrium(&[*pressure], &[1.0], &start).unwrap());
            let deviation = displacement.iter().zip(shape).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(deviation < 1e-6, "at {pressure} Pa off by {deviation} m");
        }
    }
}

#[test]
fn a_ramp_of_suction_and_of_forces_ends_at_the_equilibrium_under_both() {
    let system = clamped();
    let nodes = &system.mesh().nodes;
    let (mut solver, settings) = (system.solver(), StaticSettings::default());
    let undeformed = vec![0.0; 3 * nodes.len()];
    let initial = solver.equilibrium_from(&[(0.0, &undeformed)], &[-20.0], &settings).unwrap().displacement;
    // 80 mN along x on the roof, and through the snap
    let roof: Vec<bool> = nodes.iter().map(|at| at[1] > 0.0115).collect();
    let nodal_force = 0.08 / roof.iter().filter(|on| **on).count() as f64;
    let forces: Vec<f64> = roof.iter().flat_map(|on| [if *on { nodal_force } else { 0.0 }, 0.0, 0.0]).collect();
    let ramp = fem::LoadRamp { pressures: [&[-20.0], &[-1000.0]], forces: [&undeformed, &forces] };
    let equilibrium = solver.equilibrium_along(&[(0.0, &initial)], &ramp, &settings).unwrap();
    assert!(equilibrium.residual < 1e-5 && equilibrium.pressures == [-1000.0], "{}", equilibrium.residual);
    // the forces of the end remain
    let repeated = solver.equilibrium(&[-1000.0], Some(&equilibrium.displacement), &settings).unwrap();
    let unforced = {
        solver.set_forces(&[]).unwrap();
        solver.equilibrium(&[-1000.0], Some(&equilibrium.displacement), &settings).unwrap()
    };
    let deviation = |shape: &[f64]| {
        let far = shape.iter().zip(&equilibrium.displacement).map(|(a, b)| (a - b).abs());
        far.fold(0.0, f64::max)
    };
    assert!(
        deviation(&repeated.displacement) < 1e-6 && deviation(&unforced.displacement) > 1e-4,
        "{}",
        deviation(&unforced.displacement)
    );
}

#[test]
fn a_path_ends_where_no_equilibrium_follows() {
    let system = clamped();
    let undeformed = vec![0.0; 3 * system.mesh().nodes.len()];
    let refused =
        system.solver().equilibrium_from(&[(0.0, &undeformed)], &[2e4], &StaticSettings::default()).unwrap_err();
    assert!(matches!(refused, fem::SolveError::NoEquilibrium { .. }), "{refused}");
}

#[test]
fn a_load_without_equilibrium_is_refused_with_the_last_converged_state() {
    let system = clamped();
    let settings = StaticSettings { max_halvings: 4, ..Default::default() };
    let refused = system.solver().equilibrium(&[2e4], None, &settings).unwrap_err();
    let last_state = refused.last_converged().expect("a part of the load can be borne");
    assert!(last_state.pressures[0] > 2e3 && last_state.pressures[0] < 2e4, "{:?}", last_state.pressures);
    let text = refused.to_string();
    assert!(text.contains("why:") && text.contains("do:") && text.contains("% of the load"), "{text}");
}
