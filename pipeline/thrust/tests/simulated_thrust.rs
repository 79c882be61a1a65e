//! Thrust of a simulated motion: its gradient against differences, and gradient ascent.

#![allow(clippy::unwrap_used)] // a test may fail where it stands 

use std::sync::Arc;

use fem::{
    Branch, Clamps, DynamicSettings, Mesh, RegionProperties, Relaxation, Scheme, Solver, System, box_mesh, materials,
};
use hydro::{Stations, Tail};
use mesh::Spot;
use nalgebra::DMatrix;
use optimize::network::{Network, Scale};
use sysid::{Elastic, Model, ReducedBody, Snapshots, Viscoelastic};
use thrust::ascent::{Limits, Objective, ascend};
use thrust::flapping::{FlappingModel, MeanThrust};
use thrust::models::linear::Weighted;
use thrust::simulated::{Evaluation, SimulatedThrust, ThrustLaw};
use thrust::square_wave::SquareWave;
use thrust::{Fitted, ThrustModel};

/// A bar of 80 × 20 × 20 mm, half of it meshed, with an air chamber on either side of a stiff sheet.
fn body() -> (Solver, Mesh) {
    let (system, mesh) = held();
    (system.solver(), mesh)
}

fn held() -> (Arc<System>, Mesh) {
    let air = |c: [usize; 3], y: usize| (1..7).contains(&c[0]) && c[1] == y && c[2] == 0;
    let place = |at: [f64; 3]| [0.08 * at[0], 0.02 * (at[1] - 0.5), 0.01 * at[2]];
    let region = move |c: [usize; 3]| if air(c, 1) || air(c, 3) { None } else { Some(u16::from(c[1] == 2)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([8, 5, 2], true, place, region));
    let material = materials::by_name("neo_hookean").unwrap();
    let soft = RegionProperties::elastic(material, 2e5, 0.45, 1e3);
    let stiff = RegionProperties { youngs_modulus: 5e6, poissons_ratio: 0.35, ..soft.clone() };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    (Arc::new(System::new(mesh.clone(), vec![soft, stiff], clamps).unwrap()), mesh)
}

/// The nodes on the middle plane nearest to three places along the bar.
fn marks(mesh: &Mesh) -> Vec<Vec<(u32, f64)>> {
    let away = |at: &[f64; 3], x: f64| (at[0] - x).powi(2) + at[1].powi(2) + at[2].powi(2);
    let nearest = |x: f64| {
        let order = |a: &usize, b: &usize| away(&mesh.nodes[*a], x).total_cmp(&away(&mesh.nodes[*b], x));
        (0..mesh.nodes.len()).min_by(order).unwrap() as u32
    };
    [0.04, 0.06, 0.08].map(|x| vec![(nearest(x), 1.0)]).to_vec()
}

fn bench<'a>(mesh: &Mesh, marks: &'a [Vec<(u32, f64)>]) -> Evaluation<'a> {
    let settings = DynamicSettings {
        step: 5e-3,
        scheme: Scheme::Bdf2,
        mass_damping: 2.0,
        stiffness_damping: 1e-3,
        tolerance: 1e-11,
    };
    Evaluation { nodes: mesh.nodes.len(), marks, settings, steps: 40, settled: 10 }
}

const WAVE: SquareWave = SquareWave { amplitude: 6e3, frequency: 4.0, sharpness: 4.0 };

fn tail() -> Tail {
    Tail::new(1000.0, &Stations { clamp: 0.0, marks: &[0.04, 0.06, 0.08], edge: 0.08, end: 0.08 }, 12, &|_| 0.02)
        .unwrap()
}

fn network() -> Network {
    let spread = [vec![5e-3; 6], vec![0.1; 6], vec![3e3; 2], vec![5e4; 2]].concat();
    let scale = Scale { input_mean: vec![0.0; 16], input_spread: spread, answer_mean: 0.02, answer_spread: 0.05 };
    Network::new(scale, &[30, 40, 30], 11)
}

/// Largest difference of the gradient's components from central differences, over the larger of the two.
fn worst(law: &ThrustLaw) -> f64 {
    let (mut solver, mesh) = body();
    let marks = marks(&mesh);
    let bench = bench(&mesh, &marks);
    let found = bench.gradient(&mut solver, &WAVE, law).unwrap();
    assert!((found.mean - bench.mean(&mut solver, &WAVE, law).unwrap()).abs() < 1e-9 * found.mean.abs());
    let mut mean_of = |amplitude: f64, frequency: f64| {
        bench.mean(&mut solver, &SquareWave { amplitude, frequency, ..WAVE }, law).unwrap()
    };
    // steps at which a difference of second order is good to some 1e-7 and a kink of the network is rarely crossed
    let (a, f) = (1e-4 * WAVE.amplitude, 1e-4 * WAVE.frequency);
    let by_a = (mean_of(WAVE.amplitude + a, WAVE.frequency) - mean_of(WAVE.amplitude - a, WAVE.frequency)) / (2.0 * a);
    let by_f = (mean_of(WAVE.amplitude, WAVE.frequency + f) - mean_of(WAVE.amplitude, WAVE.frequency - f)) / (2.0 * f);
    let mut stiff = |region: usize, e: f64, nu: f64| {
        let step = 1e-4 * e;
        let mut at = |e: f64| {
            solver.set_elastic(region, e, nu).unwrap();
            bench.mean(&mut solver, &WAVE, law).unwrap()
        };
        let difference = (at(e + step) - at(e - step)) / (2.0 * step);
        at(e);
        difference
    };
    let (by_body, by_sheet) = (stiff(0, 2e5, 0.45), stiff(1, 5e6, 0.35));
    let pairs = [
        (found.by_amplitude, by_a),
        (found.by_frequency, by_f),
        (found.by_youngs_modulus[0], by_body),
        (found.by_youngs_modulus[1], by_sheet),
    ];
    let off = |(a, b): &(f64, f64)| (a - b).abs() / a.abs().max(b.abs());
    pairs.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn the_gradient_of_theory_s_mean_thrust_is_what_differences_say() {
    assert!(worst(&ThrustLaw::Theory(&tail(), [0.9, 0.8, 1.2, 0.05, 0.01])) < 1e-4);
}

#[test]
fn a_network_that_always_predicts_the_same_thrust_has_that_mean() {
    let scale = Scale { input_mean: vec![0.0; 16], input_spread: vec![1.0; 16], answer_mean: 0.02, answer_spread: 0.0 };
    let ((mut solver, mesh), network) = (body(), Network::new(scale, &[4], 1));
    let marks = marks(&mesh);
    let mean = bench(&mesh, &marks).mean(&mut solver, &WAVE, &ThrustLaw::Network(&network)).unwrap();
    assert!((mean - f64::from(0.02_f32)).abs() < 1e-12, "{mean}");
}

#[test]
fn the_gradient_of_the_network_s_mean_thrust_is_what_differences_say() {
    assert!(worst(&ThrustLaw::Network(&network())) < 1e-4);
}

#[test]
fn the_best_wave_climbs_to_the_limit_of_pressure() {
    let (mut solver, mesh) = body();
    let marks = marks(&mesh);
    let bench = Evaluation { steps: 30, settled: 6, ..bench(&mesh, &marks) };
    let limits = Limits { amplitude: 8e3, frequency: [2.0, 8.0], iterations: 6 };
    let start = SquareWave { amplitude: 4e3, ..WAVE };
    let tail = tail();
    let law = ThrustLaw::Theory(&tail, [1.0, 1.0, 0.0, 0.0, 0.0]);
    let mut objective = SimulatedThrust { bench: &bench, solver: &mut solver, law: &law };
    let way = ascend(&mut objective, start, &limits).unwrap();
    assert!(way.len() > 2 && way.windows(2).all(|w| w[1].1 > w[0].1));
    let best = way[way.len() - 1].0;
    // more pressure always gives more thrust in theory without drag
    assert!(best.amplitude > 0.9 * limits.amplitude, "{best:?}");
}

/// The body as a model: markers as [`markers`], its two chambers left and right.
fn model() -> Model {
    let (system, mesh) = held();
    let markers = marks(&mesh).into_iter().map(|weights| Spot { weights }).collect();
    Model {
        system,
        markers,
        nominal: Elastic { youngs_moduli: vec![2e5, 5e6], poissons_ratios: vec![0.45, 0.35], stiffening: [0.0; 2] },
    }
}

/// With a branch that damps the bar's vibration.
fn silicone(model: &Model) -> Viscoelastic {
    let relaxation = Relaxation::maxwell(&[Branch { strength: 0.3, time: 0.01 }]).unwrap();
    Viscoelastic { elastic: model.nominal.clone(), relaxation }
}

/// Coefficients of theory without the inertia of a fixture.
const TUNED: [f64; 5] = [0.9, 0.8, 1.2, 0.0, 0.0];

/// Evaluates the reduced model in a fluid of `density` (kg/m³): one cycle after `settle` others.
fn swimming<T>(model: &Model, density: f64, settle: usize, ask: &dyn Fn(&FlappingModel) -> T) -> T {
    let top = [1.2 * WAVE.amplitude; 2];
    let kept =
        Snapshots { model, elastic: &model.nominal, top: &top, length: 0.08, stroke: None }.reduce(5e-4).unwrap().data;
    let small = ReducedBody::of(model, &silicone(model), &kept).unwrap();
    let tail =
        Tail::new(density, &Stations { clamp: 0.0, marks: &[0.04, 0.06, 0.08], edge: 0.08, end: 0.08 }, 12, &|_| 0.02)
            .unwrap();
    let rows: DMatrix<f64> = small.rows(&[0, 1, 2]);
    ask(&FlappingModel {
        reduced_body: &small,
        tail: &tail,
        rows: &rows,
        wet: (&tail, &rows),
        halves: vec![Some(0), Some(1)],
        by: hydro::Coefficients { added: 1.0, drag: 2.0 },
        half: true,
        steps_per_cycle: 50,
        cycles: [settle, 1],
    })
}

/// So thin that its force is negligible; theory's thrust is proportional to the density.
const THIN: f64 = 1e-6;

#[test]
fn the_reduced_model_s_thrust_and_slope_are_the_whole_one_s_where_nothing_surrounds_it() {
    let model = model();
    let (reduced, slope) = swimming(&model, THIN, 1, &|flapping| {
        let theory = Fitted::Weighted(Weighted { model: ThrustModel::Theory, weights: TUNED.to_vec() });
        let limits = Limits { amplitude: 1.2 * WAVE.amplitude, frequency: [2.0, 8.0], iterations: 0 };
        let mut objective = MeanThrust { flapping, model: &theory, limits, simulations: 0 };
        (objective.value(&WAVE).unwrap(), objective.gradient(&WAVE).unwrap())
    });
    let marks: Vec<Vec<(u32, f64)>> = model.markers.iter().map(|m| m.weights.clone()).collect();
    let nodes = model.system.mesh().nodes.len();
    let settings = DynamicSettings {
        step: 5e-3,
        scheme: Scheme::Bdf2,
        mass_damping: 0.0,
        stiffness_damping: 0.0,
        tolerance: 1e-9,
    };
    let bench = Evaluation { nodes, marks: &marks, settings, steps: 100, settled: 50 };
    let tail =
        Tail::new(THIN, &Stations { clamp: 0.0, marks: &[0.04, 0.06, 0.08], edge: 0.08, end: 0.08 }, 12, &|_| 0.02)
            .unwrap();
    let law = ThrustLaw::Theory(&tail, TUNED);
    let mut solver = model.system.solver();
    silicone(&model).apply(&mut solver).unwrap();
    let found = bench.gradient(&mut solver, &WAVE, &law).unwrap();
    // reduced motions have errors of some hundredths, and thrust is proportional to their square
    assert!((reduced / found.mean - 1.0).abs() < 0.1, "{reduced:e} {:e}", found.mean);
    assert!((slope[0] / found.by_amplitude - 1.0).abs() < 0.1, "{:e} {:e}", slope[0], found.by_amplitude);
}

#[test]
fn a_tail_in_water_is_slower_to_leave_its_rest() {
    let model = model();
    // one side is filled at once and observed for 20 ms, less than half a period of this bar at some 10 Hz
    let left = |_: f64| vec![WAVE.amplitude, 0.0];
    let amplitude = |density: f64| {
        swimming(&model, density, 0, &|flapping| {
            flapping.run_under(50.0, WAVE.amplitude, &left).unwrap().amplitude_of_tip()
        })
    };
    let (free, wet) = (amplitude(THIN), amplitude(1e3));
    // the bar weighs 0.3 kg a metre and carries as much water: half as far, were all of it equally quick
    assert!(wet < 0.85 * free && wet > 0.2 * free, "{wet} {free}");
}
