//! A twin moves as the reduced model that it was made of, and as the whole one.
#![allow(clippy::unwrap_used)] // tests

use fem::{
    Branch, Clamps, DynamicSettings, InitialValueProblem, NoForce, RegionProperties, Relaxation, Scheme, State, System,
    box_mesh, materials,
};
use hydro::{Coefficients, Stations, Tail};
use mesh::Spot;
use nalgebra::DVector;
use std::sync::Arc;
use sysid::{Elastic, ForcedMotion, Model, ReducedBody, Snapshots, Viscoelastic, even_times};
use thrust::real_time::{Surroundings, twin_data};
use thrust::water::Water;
use twin::Twin;

const LENGTH: f64 = 0.09;
const RATE: f64 = 240.0;
const STEPS: usize = 120;
/// Highest pressure, Pa.
const TOP: f64 = 2e4;
const STATIONS: [f64; 3] = [0.03, 0.06, 0.09];

/// A beam of silicone with a chamber on either side and a stiffer sheet between them, the upper half.
fn beam(law: &str, hexahedra: bool) -> (Model, Viscoelastic) {
    let (cells, region) = ([12, 5, 2], |[_, j, _]: [usize; 3]| if j == 2 { 1 } else { 0 });
    let air = |[i, j, k]: [usize; 3]| (1..11).contains(&i) && (j == 1 || j == 3) && k < 1;
    let place = |at: [f64; 3]| [LENGTH * at[0], 0.02 * (at[1] - 0.5), 0.008 * at[2]];
    let solid = |cell| if air(cell) { None } else { Some(region(cell)) };
    let mesh = match hexahedra {
        true => box_mesh::quadratic_hexahedra(cells, true, place, solid),
        false => box_mesh::to_quadratic(&box_mesh::grid(cells, true, place, solid)),
    };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let law = materials::by_name(law).unwrap();
    let elastic = Elastic { youngs_moduli: vec![2e5, 2e6], poissons_ratios: vec![0.45, 0.4], stiffening: [0.0; 2] };
    let region =
        |i: usize| RegionProperties::elastic(law, elastic.youngs_moduli[i], elastic.poissons_ratios[i], 1100.0);
    let markers = STATIONS.map(|x| nearest(&mesh.nodes, [x, 0.0, 0.0])).map(|node| Spot { weights: vec![(node, 1.0)] });
    let system = System::new(mesh, vec![region(0), region(1)], clamps).unwrap();
    let relaxation =
        Relaxation::maxwell(&[(0.002, 0.2), (0.05, 0.1)].map(|(time, strength)| Branch { strength, time }));
    let silicone = Viscoelastic { elastic: elastic.clone(), relaxation: relaxation.unwrap() };
    (Model { system: Arc::new(system), markers: markers.to_vec(), nominal: elastic }, silicone)
}

fn nearest(nodes: &[[f64; 3]], to: [f64; 3]) -> u32 {
    let far = |at: &[f64; 3]| (0..3).map(|k| (at[k] - to[k]).powi(2)).sum::<f64>();
    (0..nodes.len()).min_by(|a, b| far(&nodes[*a]).total_cmp(&far(&nodes[*b]))).unwrap() as u32
}

fn pressures(t: f64) -> Vec<f64> {
    let ease = 1.0 - (-20.0 * t).exp();
    [1.0, -1.0].map(|side| 0.5 * TOP * ease * (1.0 + side * (25.0 * t).sin())).to_vec()
}

fn settings() -> DynamicSettings {
    DynamicSettings { step: 1.0 / RATE, scheme: Scheme::Bdf2, ..DynamicSettings::default() }
}

/// y of the last marker, m, by the reduced model.
fn reduced(body: &ReducedBody, water: Option<&Surroundings>) -> Vec<f64> {
    let (times, settings, tip) = (even_times(1.0 / RATE, STEPS), settings(), body.rows(&[2]));
    let motion = ForcedMotion { settings: &settings, pressures: &pressures, times: &times };
    let mut path = Vec::new();
    let mut see = |q: &DVector<f64>, _: &DVector<f64>| path.push((tip.row(1) * q)[0]);
    match water {
        None => body.integrate_in_fluid(&motion, &mut NoForce, &mut see).unwrap(),
        Some(w) => {
            let mut water = Water::around(w.tail, w.rows, w.by, w.half);
            body.integrate_in_fluid(&motion, &mut water, &mut see).unwrap();
        }
    }
    path
}

/// The same by whatever integrates it fastest.
fn fastest(body: &ReducedBody, water: Option<&Surroundings>) -> Vec<f64> {
    let (times, settings, tip) = (even_times(1.0 / RATE, STEPS), settings(), body.rows(&[2]));
    let motion = ForcedMotion { settings: &settings, pressures: &pressures, times: &times };
    let Some(water) = water else { return body.integrate(&motion, 2).unwrap().iter().map(|at| at[1]).collect() };
    let mut path = Vec::new();
    water.integrate(body, &motion, &mut |q, _| path.push((tip.row(1) * q)[0])).unwrap();
    path
}

fn twin(body: &ReducedBody, water: Option<&Surroundings>) -> Vec<f64> {
    let twin = Twin::new(twin_data(body, water, &[("tip", 2)]).unwrap()).unwrap();
    assert_eq!(twin.outputs().collect::<Vec<_>>(), ["tip_x", "tip_y"]);
    let mut state = twin.start();
    let mut step = |n: usize| {
        twin.step(&mut state, &pressures(n as f64 / RATE), 1.0 / RATE).unwrap();
        twin.output(&state, 1)
    };
    (1..=STEPS).map(&mut step).collect()
}

fn whole(model: &Model, silicone: &Viscoelastic) -> Vec<f64> {
    let (settings, rest) = (settings(), State::rest(model.system.mesh().nodes.len()));
    let mut solver = model.system.solver();
    silicone.apply(&mut solver).unwrap();
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures };
    let mut path = Vec::new();
    let mut see = |_: f64, state: &State| path.push(Model::in_plane(&model.markers[2], &state.displacement)[1]);
    solver.integrate(&problem, STEPS, &mut see).unwrap();
    path
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[test]
fn in_air_and_in_water_a_twin_moves_as_its_reduced_model_and_within_a_five_hundredth_of_the_length_of_the_whole_one() {
    let (model, silicone) = beam("neo_hookean", false);
    let snapshots =
        Snapshots { model: &model, elastic: &silicone.elastic, top: &[TOP; 2], length: LENGTH, stroke: None };
    let body = ReducedBody::of(&model, &silicone, &snapshots.reduce(1e-3).unwrap().data).unwrap();
    let stations = Stations { clamp: 0.0, marks: &STATIONS, edge: LENGTH, end: LENGTH };
    let (tail, rows) = (Tail::new(998.0, &stations, 12, &|_| 0.016).unwrap(), body.rows(&[0, 1, 2]));
    let water = Surroundings { tail: &tail, rows: &rows, by: Coefficients { added: 1.2, drag: 3.0 }, half: true };
    let (dry, wet) = (twin(&body, None), twin(&body, Some(&water)));
    assert!(dry.iter().fold(0.0, |far: f64, y| far.max(y.abs())) > 0.04 * LENGTH);
    assert!(difference(&dry, &wet) > 0.02 * LENGTH, "water matters");
    // tolerances of a step accumulate; both models solve the same equations
    assert!(difference(&dry, &reduced(&body, None)) < 2e-5 * LENGTH);
    assert!(difference(&wet, &reduced(&body, Some(&water))) < 2e-5 * LENGTH);
    // the stages' motions are the twin's, to the tolerance of the reduced model's own
    assert!(difference(&fastest(&body, None), &reduced(&body, None)) < 1e-6 * LENGTH);
    assert!(difference(&fastest(&body, Some(&water)), &reduced(&body, Some(&water))) < 1e-6 * LENGTH);
    assert!(fastest(&body, None) != reduced(&body, None), "integrated by the twin");
    assert!(difference(&dry, &whole(&model, &silicone)) < 2e-3 * LENGTH);
}

/// Their cubature has two groups of points in each solid.
#[test]
fn a_beam_in_hexahedra_has_a_twin_whose_groups_have_names_of_their_own() {
    let (model, silicone) = beam("neo_hookean", true);
    let snapshots =
        Snapshots { model: &model, elastic: &silicone.elastic, top: &[0.5 * TOP; 2], length: LENGTH, stroke: None };
    let body = ReducedBody::of(&model, &silicone, &snapshots.reduce(1e-2).unwrap().data).unwrap();
    let data = twin_data(&body, None, &[]).unwrap();
    let names: Vec<&str> = data.regions.iter().map(|region| region.name.as_str()).collect();
    assert_eq!(names, ["solid0_0", "solid0_1", "solid1_0", "solid1_1"]);
    let (by_twin, by_reduced_model) = (fastest(&body, None), reduced(&body, None));
    assert!(difference(&by_twin, &by_reduced_model) < 1e-6 * LENGTH);
    assert!(by_twin != by_reduced_model, "integrated by the twin");
}

#[test]
fn a_law_that_a_twin_lacks_is_refused() {
    let (model, silicone) = beam("corotated", false);
    let snapshots =
        Snapshots { model: &model, elastic: &silicone.elastic, top: &[0.2 * TOP; 2], length: LENGTH, stroke: None };
    let body = ReducedBody::of(&model, &silicone, &snapshots.reduce(1e-2).unwrap().data).unwrap();
    let refused = twin_data(&body, None, &[]).unwrap_err().to_string();
    assert!(refused.contains("`corotated`") && refused.contains("neo_hookean"), "{refused}");
    assert_eq!(fastest(&body, None), reduced(&body, None), "it moves all the same");
}
