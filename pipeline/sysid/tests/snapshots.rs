//! The reduced model of a tail with a fin bends as the whole one does under inertia and under water.
#![allow(clippy::unwrap_used)] // tests

use fem::{Clamps, Mesh, RegionProperties, StaticSettings, System, box_mesh, materials};
use mesh::Spot;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use sysid::{Elastic, Model, Snapshots, Stroke};

const LENGTH: f64 = 0.09;
/// Highest pressure, Pa.
const TOP: f64 = 5e3;
/// Of the fin, at the end of the length.
const FIN: f64 = 0.67 * LENGTH;

/// A body of silicone with a chamber on either side of a sheet of 1 mm, which is deeper behind the body: the upper half.
fn tail() -> Mesh {
    let across = |t: f64| if t.abs() <= 0.1 { 0.005 * t } else { t.signum() * (0.0005 + 0.024 * (t.abs() - 0.1)) };
    let place = |at: [f64; 3]| [LENGTH * at[0], across(at[1] - 0.5), 0.024 * at[2]];
    let region = |[i, j, k]: [usize; 3]| match (i < 8, j == 2, k < 2) {
        (true, false, true) if (1..7).contains(&i) && (j == 1 || j == 3) && k < 1 => None,
        (true, false, true) => Some(0),
        (true, true, true) | (false, true, _) => Some(1),
        _ => None,
    };
    box_mesh::to_quadratic(&box_mesh::grid([12, 5, 4], true, place, region))
}

fn model(mesh: Mesh) -> Model {
    let law = materials::by_name("neo_hookean").unwrap();
    let elastic = Elastic { youngs_moduli: vec![2e5, 5e8], poissons_ratios: vec![0.45, 0.37], stiffening: [0.0; 2] };
    let region =
        |i: usize| RegionProperties::elastic(law, elastic.youngs_moduli[i], elastic.poissons_ratios[i], 1100.0);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![region(0), region(1)], clamps).unwrap();
    Model { system: Arc::new(system), markers: vec![Spot { weights: vec![(0, 1.0)] }], nominal: elastic }
}

/// The modes of the reduced model.
fn modes(model: &Model) -> DMatrix<f64> {
    let snapshots = Snapshots {
        model,
        elastic: &model.nominal,
        top: &[TOP; 2],
        length: LENGTH,
        stroke: Some(Stroke { amplitude: TOP, frequency: 4.0 }),
    };
    let kept = snapshots.reduce(1e-3).unwrap().data.modes;
    DMatrix::from_fn(kept[0].len(), kept.len(), |i, j| kept[j][i])
}

/// The largest part of an equilibrium under pressures (Pa) and lateral forces, given by node, that the modes leave out, over its largest
/// displacement.
fn left_out(model: &Model, modes: &DMatrix<f64>, pressures: [f64; 2], by: impl Fn(usize) -> f64) -> f64 {
    let nodes = model.system.mesh().nodes.len();
    let mut solver = model.system.solver();
    let mut forces = vec![0.0; 3 * nodes];
    (0..nodes).for_each(|node| forces[3 * node + 1] = by(node));
    solver.set_forces(&forces).unwrap();
    let found = solver.equilibrium(&pressures, None, &StaticSettings::default()).unwrap();
    let whole = DVector::from_vec(found.displacement);
    let within = modes * modes.clone().svd(true, true).solve(&whole, 1e-12).unwrap();
    assert!(whole.amax() > 0.02 * LENGTH, "it bends: {}", whole.amax());
    (&whole - within).amax() / whole.amax()
}

#[test]
fn a_fin_bends_under_water_in_the_reduced_model_as_in_the_whole_one() {
    let model = model(tail());
    let modes = modes(&model);
    let (nodes, masses) = (model.system.mesh().nodes.clone(), model.system.node_masses().to_vec());
    let inertia = left_out(&model, &modes, [0.0; 2], |node| 40.0 * masses[node] * nodes[node][0] / LENGTH);
    // with snapshots under inertia alone 0.012 of it is left out
    let on_fin = |node: usize| f64::from(u8::from(nodes[node][0] > FIN)) * 2e-4;
    let water = left_out(&model, &modes, [0.0; 2], on_fin);
    assert!(inertia < 3e-3 && water < 2e-3, "{inertia} {water}");
}

/// As while one chamber empties and the other one fills.
#[test]
fn with_both_chambers_filled_a_tail_swings_in_the_reduced_model_as_in_the_whole_one() {
    let model = model(tail());
    let modes = modes(&model);
    let (nodes, masses) = (model.system.mesh().nodes.clone(), model.system.node_masses().to_vec());
    for pressures in [[0.4 * TOP, 0.4 * TOP], [0.5 * TOP, 0.3 * TOP]] {
        let inertia =
            left_out(&model, &modes, pressures, |node| 40.0 * masses[node] * (nodes[node][0] / LENGTH).powi(2));
        // the strokes of a motion fill both on the way; without them 2.7e-5 of it is left out
        assert!(inertia < 2.5e-5, "{pressures:?}: {inertia}");
    }
}
