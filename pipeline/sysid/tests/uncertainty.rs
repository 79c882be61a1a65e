//! Uncertainty of an identification on a case small enough to be repeated: a bar of two materials under three loads, with noisy
//! displacements of a few points.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::f64::consts::{LN_10, TAU};

use fem::{
    Clamps, Equilibrium, Forces, Mesh, Parameter, RegionProperties, Solver, StaticSettings, System, box_mesh, materials,
};
use optimize::optimisers::gauss_newton::{self, GaussNewton, Settings};
use optimize::optimisers::{self, adam, cma_es};
use optimize::posterior::WITHIN_95;
use optimize::{Bounds, Evaluation, EvaluationLog, Needs, OptimiseError, Optimiser, Problem, Residuals, minimise};

/// Of a soft body and a stiffer sheet, Pa.
const E: [f64; 2] = [2.1e5, 8e5];
/// Lateral loads across the end of the half that is meshed, N.
const PULLS: [f64; 3] = [0.1, 0.2, 0.3];
/// Standard deviation of a measured point, m.
const SIGMA: f64 = 2e-5;

/// A bar of 60 × 20 × 20 mm, half of it meshed, with a sheet in the outer part of its lower side: the inner part bends as the
/// body lets it, the outer one as the sheet does.
fn bar() -> Mesh {
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1], 0.01 * at[2]];
    let region = |cell: [usize; 3]| Some(u16::from(cell[1] == 0 && cell[0] >= 1));
    box_mesh::to_quadratic(&box_mesh::grid([5, 3, 1], true, place, region))
}

/// A bar on the bench: its system, where it is pulled, where it is seen, and its last shapes.
struct Bench {
    solver: Solver,
    mesh: Mesh,
    seen: Vec<usize>,
    shapes: Vec<Option<Equilibrium>>,
}

impl Bench {
    fn new() -> Self {
        let mesh = bar();
        let material = materials::by_name("neo_hookean").unwrap();
        let region = |(e, nu)| RegionProperties::elastic(material, e, nu, 1e3);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let system = System::new(mesh.clone(), [(E[0], 0.47), (E[1], 0.35)].map(region).to_vec(), clamps).unwrap();
        let top = |x: f64| (0..mesh.nodes.len()).find(|&n| is_at(mesh.nodes[n], [x, 0.02, 0.0])).unwrap();
        let seen = [0.012, 0.024, 0.036, 0.048, 0.06].map(top).to_vec();
        Self { solver: system.solver(), seen, mesh, shapes: vec![None; PULLS.len()] }
    }

    /// Places (m) and their derivatives by the logarithms of the moduli, at moduli e^`at` times the true ones.
    fn look(&mut self, at: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut places, mut slopes) = (Vec::new(), Vec::new());
        let end = (0..self.mesh.nodes.len()).max_by(|&a, &b| self.mesh.nodes[a][0].total_cmp(&self.mesh.nodes[b][0]));
        let settings = StaticSettings { tolerance: 1e-9, ..StaticSettings::default() };
        for (region, nu) in [0.47, 0.35].into_iter().enumerate() {
            self.solver.set_elastic(region, E[region] * at[region].exp(), nu).unwrap();
        }
        for (pull, known) in PULLS.iter().zip(&mut self.shapes) {
            let forces = Forces::none(&self.mesh).on_node(end.unwrap() as u32, [0.0, *pull, 0.0]).unwrap();
            self.solver.set_forces(forces.as_slice()).unwrap();
            let start = known.as_ref().map(|shape| shape.displacement.as_slice());
            let shape = self.solver.equilibrium(&[], start, &settings).unwrap();
            let by: Vec<Vec<f64>> =
                (0..2).map(|r| self.solver.sensitivity(&shape, Parameter::YoungsModulus(r)).unwrap()).collect();
            for freedom in self.seen.iter().flat_map(|n| [3 * n, 3 * n + 1]) {
                places.push(shape.displacement[freedom]);
                slopes.extend((0..2).map(|r| by[r][freedom] * E[r] * at[r].exp()));
            }
            *known = Some(shape);
        }
        (places, slopes)
    }

    /// Gauss-Newton from `start` over two decades of each modulus.
    fn identify(&mut self, measured: &[f64], start: [f64; 2]) -> EvaluationLog {
        let bounds = Bounds { low: vec![-LN_10; 2], high: vec![LN_10; 2] };
        let search = Problem::new(&["body", "sheet"], start.to_vec(), bounds).unwrap();
        let set = Settings { step_tolerance: 1e-5, ..Settings::default() };
        let mut optimiser = GaussNewton::new(&search, &set).unwrap();
        let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, OptimiseError> {
            Ok(batch.iter().map(|at| self.weigh(at, measured)).collect())
        };
        minimise(&mut optimiser as &mut dyn Optimiser, &mut problem).unwrap()
    }

    fn weigh(&mut self, at: &[f64], measured: &[f64]) -> Evaluation {
        let (places, slopes) = self.look(at);
        let values = places.iter().zip(measured).map(|(ours, theirs)| (ours - theirs) / SIGMA).collect();
        let residuals = Residuals { values, jacobian: slopes.iter().map(|slope| slope / SIGMA).collect() };
        let (loss, gradient) = (residuals.half_sum_of_squares(), Some(residuals.gradient(2)));
        Evaluation { at: at.to_vec(), loss, gradient, residuals: Some(residuals) }
    }
}

/// Simulations of a method from `start` until its loss is no more than `enough`.
fn simulations(bench: &mut Bench, name: &str, measured: &[f64], start: [f64; 2], enough: f64) -> usize {
    let bounds = Bounds { low: vec![-LN_10; 2], high: vec![LN_10; 2] };
    let search = Problem::new(&["body", "sheet"], start.to_vec(), bounds).unwrap();
    let mut set = optimisers::Settings::default();
    set.adam = adam::Settings {
        step: 0.2,
        step_decay: 0.05,
        iterations: 400,
        step_tolerance: 1e-9,
        ..adam::Settings::default()
    };
    set.cma_es = cma_es::Settings { generations: 60, step_tolerance: 1e-9, ..cma_es::Settings::default() };
    let mut optimiser = (optimisers::by_name(name).unwrap().build)(&search, &set).unwrap();
    let (mut count, mut reached) = (0, None);
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, OptimiseError> {
        let each = batch.iter().map(|at| {
            let found = bench.weigh(at, measured);
            count += 1;
            reached = reached.or((found.loss <= enough).then_some(count));
            found
        });
        Ok(each.collect())
    };
    minimise(optimiser.as_mut(), &mut problem).unwrap();
    reached.unwrap_or(usize::MAX)
}

fn is_at(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-9)
}

/// Noise of a camera: SplitMix64 and the polar form of Box and Muller.
fn noisy(places: &[f64], seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0xd134_2543_de82_ef95);
    let mut unit = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = || (-2.0 * (1.0 - unit()).ln()).sqrt() * (TAU * unit()).cos();
    places.iter().map(|place| place + SIGMA * normal()).collect()
}

#[test]
fn from_anywhere_in_two_decades_of_both_moduli_the_same_minimum_is_reached() {
    let mut bench = Bench::new();
    let measured = noisy(&bench.look(&[0.0, 0.0]).0, 1);
    let best = bench.identify(&measured, [0.0, 0.0]).best;
    let starts =
        (0..20).map(|i| [0.7549, 0.5698].map(|step| LN_10 * (2.0 * (0.5 + step * f64::from(i)).fract() - 1.0)));
    let reached = |start: [f64; 2]| {
        bench.shapes.fill(None);
        let found = bench.identify(&measured, start).best;
        found.at.iter().zip(&best.at).all(|(a, b)| (a - b).abs() < 1e-3)
    };
    let reached = starts.map(reached).filter(|same| *same).count();
    assert!(reached >= 19, "{reached} of 20");
}

#[test]
fn intervals_of_95_percent_hold_the_truth_in_90_to_98_percent_of_200_repeats() {
    let mut bench = Bench::new();
    let places = bench.look(&[0.0, 0.0]).0;
    let mut held = [0; 2];
    for seed in 0..200 {
        let best = bench.identify(&noisy(&places, 7 + seed), [0.02, -0.02]).best;
        let covariance = best.residuals.unwrap().posterior(2).unwrap();
        let sigmas: [f64; 2] = std::array::from_fn(|k| covariance.sigma(k));
        // a few per cent at most, so that the straight-line posterior is the whole one
        assert!(sigmas.iter().all(|sigma| (1e-4..0.05).contains(sigma)), "{sigmas:?}");
        (0..2).for_each(|k| held[k] += usize::from(best.at[k].abs() < WITHIN_95 * sigmas[k]));
    }
    assert!(held.iter().all(|count| (180..=196).contains(count)), "{held:?} of 200");
}

#[test]
fn gauss_newton_is_there_within_a_fifth_of_adam_s_simulations_and_a_fifteenth_of_cma_es_s() {
    let mut bench = Bench::new();
    let measured = noisy(&bench.look(&[0.0, 0.0]).0, 1);
    let best = bench.identify(&measured, [0.0, 0.0]).best;
    // half of χ² is one standard deviation, the resolution of the films
    let enough = best.loss + 0.5;
    let mut count = |name: &str| {
        bench.shapes.fill(None);
        simulations(&mut bench, name, &measured, [0.4, -0.5], enough)
    };
    let [newton, adam, cma_es] = [gauss_newton::NAME, adam::NAME, cma_es::NAME].map(&mut count);
    assert!(5 * newton <= adam && 15 * newton <= cma_es, "{newton}, {adam}, {cma_es} simulations");
}
