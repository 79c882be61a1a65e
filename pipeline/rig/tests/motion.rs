//! The bench's motions: the reduced model against the whole body in air and in water, and the energy balance of the whole body.
#![allow(clippy::unwrap_used)] // a panic fails the test

use fem::{DynamicSettings, InitialValueProblem, ReducedMotion, Scheme, State};
use nalgebra::DVector;
use rig::Side;
use rig::physics::{
    Body, BodySettings, CentreLine, Conditions, FlappingModel, Fluid, Motion, PressureSweep, Sampling, Staircase,
    TimeSpan, Water, even_pressures, integrate,
};
use rig::random::RandomStream;
use rig::settings::{Resolution, Settings};
use rig::specimen::{HiddenProperties, SHEET};
use rig::specimens::ALL;
use rig::valve::{Command, Trace, ValveDisturbance, valve_response};
use tail_cad::Tail;

/// Marlin, whose walls are thick, on a mesh for tests.
struct Coarse {
    set: Settings,
    tail: Tail,
    body: Body,
}

impl Coarse {
    fn marlin() -> Self {
        Self::unbonded_along(Settings::built_in().casting.unbonded)
    }

    /// With silicone that does not adhere to the sheet along so many chambers.
    fn unbonded_along(chambers: usize) -> Self {
        let mut set = Settings::built_in();
        set.casting.unbonded = chambers;
        let own = &set.specimen["marlin"];
        let hidden = HiddenProperties::drawn(&set, own);
        let resolution = Resolution { edge: 0.010, per_chamber: 1, per_rib: 1, hexahedra: None };
        let tail = (ALL.iter().find(|s| s.name == "marlin").unwrap().tail)();
        let laws = [&*set.material[&own.body].law, &*set.material[SHEET].law];
        let body =
            Body::new(&tail, &BodySettings { resolution: &resolution, clamp: own.clamp, laws }, &hidden).unwrap();
        Self { tail: hidden.cast_tail(&tail), body, set }
    }

    /// Both sides' sweeps to 200 mbar.
    fn sweeps(&self) -> [PressureSweep; 2] {
        let pressures = even_pressures(2.0e4, 10);
        [Side::Left, Side::Right].map(|side| PressureSweep::solve_sweep(&self.body, side, &pressures, &|| ()).unwrap())
    }

    fn flapping_model(&self) -> FlappingModel<'_> {
        let line = CentreLine::of_tail(&self.tail, &self.body, self.set.specimen["marlin"].clamp);
        let sweeps = self.sweeps();
        let reduced = FlappingModel::reduce_body(&self.body, &line, &sweeps, &|| ()).unwrap();
        FlappingModel::of_reduced_data(&self.body, line, &sweeps, &reduced).unwrap()
    }

    /// Both sides' pressures in a square wave, left first.
    fn square_wave(&self, frequency: f64, cycles: usize) -> [Trace; 2] {
        let half = 0.5 / frequency;
        let commands = |late: f64| -> Vec<Command> {
            let one = |i: usize| {
                let start = 2.0 * half * i as f64 + late;
                [Command { time: start, pressure: 2e4 }, Command { time: start + half, pressure: 0.0 }]
            };
            (0..cycles).flat_map(one).collect()
        };
        let mut random = RandomStream::new(1, "valve");
        [0.0, half]
            .map(|late| valve_response(&self.set.valve, &commands(late), ValveDisturbance::default(), &mut random))
    }

    /// The node at the fin's tip.
    fn tip(&self) -> usize {
        let nodes = &self.body.mesh.nodes;
        (0..nodes.len()).max_by(|a, b| nodes[*a][0].total_cmp(&nodes[*b][0])).unwrap()
    }
}

const STEP: f64 = 1.0 / 240.0;

fn span(end: f64) -> TimeSpan {
    TimeSpan { start: 0.0, end, step: STEP }
}

fn sampling(end: f64) -> Sampling {
    Sampling { start: 0.0, end, rate: 60.0, step: STEP }
}

/// Largest lateral position, and largest difference, of the tip in both motions.
fn tip_difference(coarse: &Coarse, whole: &dyn Motion, reduced: &dyn Motion, length: f64) -> (f64, f64) {
    let tip = coarse.tip();
    let place = |motion: &dyn Motion, i: usize| motion.nodes(i as f64 / 60.0)[tip][1];
    let steps = (length * 60.0) as usize;
    (0..steps).fold((0.0, 0.0), |(size, off), i| {
        let (a, b) = (place(whole, i), place(reduced, i));
        (f64::max(size, a.abs()), f64::max(off, (a - b).abs()))
    })
}

#[test]
fn in_air_the_reduced_model_flaps_as_the_whole_body_to_two_per_cent() {
    let coarse = Coarse::marlin();
    let flapping_model = coarse.flapping_model();
    for (frequency, length) in [(2.0, 0.6), (4.0, 0.4)] {
        let [left, right] = coarse.square_wave(frequency, 2);
        let pressures = |t: f64| [left.at(t), right.at(t)];
        let whole = integrate(&coarse.body, &sampling(length), &pressures, &|| ()).unwrap();
        let in_air = Conditions { fluid: None, softening: 1.0, softened: None };
        let reduced = flapping_model.simulate_flapping(span(length), &pressures, &in_air).unwrap();
        let (size, off) = tip_difference(&coarse, &whole, &reduced, length);
        println!("{frequency} Hz: the tip moves {:.2} mm, off by {:.3} mm", size * 1e3, off * 1e3);
        assert!(size > 5e-3 && off < 0.02 * size, "{frequency} Hz: off by {off} of {size} m");
    }
}

#[test]
fn cycles_soften_the_silicone_where_it_is_strained_most_and_the_tail_flaps_further() {
    let coarse = Coarse::marlin();
    let (flapping_model, mullins) = (coarse.flapping_model(), coarse.set.causes.mullins);
    let pressures = even_pressures(2.0e4, 10);
    let [low, high] = [0.5e4, 2.0e4].map(|top| flapping_model.softened_model(&mullins, &pressures, top).unwrap());
    let most = 1.0 / mullins.r;
    assert!(low.factors.iter().zip(&high.factors).all(|(low, high)| low >= high && *high > 1.0 - most));
    assert!(high.mean < low.mean && low.mean < 1.0);
    let range = high.factors.iter().fold([1.0_f64, 0.0_f64], |[a, b], s| [a.min(*s), b.max(*s)]);
    assert!(range[0] < 1.0 - 0.8 * most && range[1] > 1.0 - 0.2 * most, "{range:?}");
    let [left, right] = coarse.square_wave(2.0, 1);
    let both = |t: f64| [left.at(t), right.at(t)];
    let largest = |softened| {
        let motion =
            flapping_model.simulate_flapping(span(0.5), &both, &Conditions { fluid: None, softening: 1.0, softened });
        let motion = motion.unwrap();
        (0..50).map(|i| motion.nodes(0.01 * f64::from(i))[coarse.tip()][1].abs()).fold(0.0, f64::max)
    };
    let further = largest(Some(&high)) / largest(None) - 1.0;
    assert!(further > 0.002 && further < most, "{further}");
}

#[test]
fn where_silicone_and_sheet_do_not_adhere_pressure_is_passed_on_and_shear_is_not() {
    let tip_at = |chambers: usize| {
        let coarse = Coarse::unbonded_along(chambers);
        assert_eq!(coarse.body.system.regions().len(), if chambers > 0 { 3 } else { 2 });
        coarse.sweeps().map(|sweep| sweep.shapes[sweep.shapes.len() - 1][3 * coarse.tip() + 1])
    };
    let (bonded, two, six) = (tip_at(0), tip_at(2), tip_at(6));
    for side in 0..2 {
        let [two, six] = [two, six].map(|tip| tip[side] / bonded[side] - 1.0);
        println!("two chambers move the tip by {:+.3} %, six by {:+.3} %", 100.0 * two, 100.0 * six);
        // a film with the silicone's shear modulus moves it by at most 0.05 %: that is the other division of the mesh
        assert!(six > two && six > 8e-4 && six < 3e-3, "{two} {six}");
    }
}

#[test]
fn in_a_staircase_the_tail_vibrates_and_rests_as_the_whole_body() {
    let coarse = Coarse::marlin();
    let (flapping_model, sweeps) = (coarse.flapping_model(), coarse.sweeps());
    let commands = [Command { time: 0.0, pressure: 1.7e4 }, Command { time: 0.5, pressure: 0.0 }];
    let trace =
        valve_response(&coarse.set.valve, &commands, ValveDisturbance::default(), &mut RandomStream::new(1, "valve"));
    let staircase = Staircase { side: Side::Left, sweep: &sweeps[0], trace: trace.clone() };
    let motion = flapping_model.simulate_staircase(staircase, span(0.8), None).unwrap();
    let whole = integrate(&coarse.body, &sampling(0.8), &|t| [trace.at(t), 0.0], &|| ()).unwrap();
    let (size, off) = tip_difference(&coarse, &whole, &motion, 0.8);
    let tip = coarse.tip();
    let deviation = (motion.nodes(0.49)[tip][1] - whole.nodes(0.49)[tip][1]).abs();
    println!("the tip moves {:.2} mm, off by {:.3} mm, held {:.4} mm off", size * 1e3, off * 1e3, deviation * 1e3);
    assert!(size > 5e-3 && off < 0.02 * size, "off by {off} of {size} m");
    // 0.07 mm: 0.6 % of the motion
    assert!(deviation < 8e-5, "held {deviation} m off the whole body's creep");
    let some = motion.nodes_of(0.53, &[tip as u32]);
    assert_eq!(some[tip], motion.nodes(0.53)[tip]);
}

/// Implicit Euler, so that the water's force can be applied to the whole body step by step.
#[test]
fn in_water_the_reduced_model_moves_as_the_whole_body_to_two_per_cent() {
    let coarse = Coarse::marlin();
    let flapping_model = coarse.flapping_model();
    let fluid = Fluid { density: 998.0, added: 1.0, drag: 2.0 };
    let [left, right] = coarse.square_wave(2.0, 1);
    let mut observed = ObservedWater { water: flapping_model.water_at_rest(fluid), forces: Vec::new() };
    let settings = DynamicSettings { step: STEP, scheme: Scheme::ImplicitEuler, ..DynamicSettings::default() };
    let pressures = |t: f64| coarse.body.pressures(left.at(t), right.at(t));
    let actuation = |t: f64| fem::Actuation { pressures: pressures(t) };
    let (tip, mut reduced) = (coarse.tip(), Vec::new());
    let mut keep =
        |_: f64, q: &DVector<f64>, _: &DVector<f64>| reduced.push(flapping_model.reduced.displacement(q)[3 * tip + 1]);
    flapping_model
        .reduced
        .integrate(
            &ReducedMotion {
                settings: &settings,
                modulus_scale: &coarse.body.modulus_scales(1.0),
                relaxation: &[],
                stiffening: &[],
                actuation: &actuation,
            },
            &mut observed,
            90,
            &mut keep,
        )
        .unwrap();
    let whole = whole_tip(
        &Forced { coarse: &coarse, line: &flapping_model.line, settings: &settings, forces: &observed.forces },
        &pressures,
        tip,
    );
    let size = whole.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let off = whole.iter().zip(&reduced).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    println!("in water the tip moves {:.2} mm, off by {:.3} mm", size * 1e3, off * 1e3);
    assert!(size > 5e-3 && off < 0.02 * size, "off by {off} of {size} m");
}

/// Water that stores its forces on the stations.
struct ObservedWater<'a> {
    water: Water<'a>,
    forces: Vec<DVector<f64>>,
}

impl fem::ExternalForce for ObservedWater<'_> {
    fn force(&self, at: &fem::StepState) -> DVector<f64> {
        self.water.force(at)
    }

    fn accept(&mut self, at: &fem::StepState) {
        self.water.accept(at);
        self.forces.push(self.water.forces.clone());
    }
}

/// The whole body under given forces on the stations, one vector a step.
struct Forced<'a> {
    coarse: &'a Coarse,
    line: &'a CentreLine,
    settings: &'a DynamicSettings,
    forces: &'a [DVector<f64>],
}

/// The lateral displacement of the whole body's tip, step by step.
fn whole_tip(forced: &Forced, pressures: &dyn Fn(f64) -> Vec<f64>, tip: usize) -> Vec<f64> {
    let Forced { coarse, line, settings, forces } = *forced;
    let nodes = coarse.body.mesh.nodes.len();
    let fraction = if coarse.body.mesh.half { 0.5 } else { 1.0 };
    let mut solver = coarse.body.system.solver();
    // each step is an integration of its own, which would begin with relaxed histories
    solver.set_relaxation(0, fem::Relaxation::default()).unwrap();
    let mut state = State::rest(nodes);
    let mut tips = Vec::new();
    for (i, force) in forces.iter().enumerate() {
        solver.set_forces(&line.nodal_forces(nodes, &(force * fraction))).unwrap();
        let now = |_: f64| pressures((i + 1) as f64 * STEP);
        state = solver
            .integrate(&InitialValueProblem { settings, initial: &state, pressures: &now }, 1, &mut |_, _| ())
            .unwrap();
        tips.push(state.displacement[3 * tip + 1]);
    }
    tips
}

#[test]
fn the_energy_balance_of_the_whole_body_closes_to_one_per_cent_over_a_cycle() {
    let coarse = Coarse::marlin();
    let [left, right] = coarse.square_wave(2.0, 1);
    let pressures = |t: f64| coarse.body.pressures(left.at(t), right.at(t));
    // its relaxation would dissipate inside of the material, where nothing is counted
    let beta = 1.8e-3;
    let settings =
        DynamicSettings { step: STEP, scheme: Scheme::Bdf2, stiffness_damping: beta, ..DynamicSettings::default() };
    let system = &coarse.body.system;
    let solver = system.solver();
    let volumes = |u: &[f64]| [0, 1].map(|chamber| system.chamber_volume(chamber, u));
    let rest = State::rest(coarse.body.mesh.nodes.len());
    let (mut before, mut force) = (rest.displacement.clone(), vec![0.0; rest.displacement.len()]);
    let (mut time, mut work, mut dissipated, mut stored, mut turnover) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut keep = |t: f64, state: &State| {
        let (then, now) = (volumes(&before), volumes(&state.displacement));
        let (p, q) = (pressures(time), pressures(t));
        let gain: f64 = (0..2).map(|c| 0.5 * (p[c] + q[c]) * (now[c] - then[c])).sum();
        let elastic = solver.elastic_force(&state.displacement).unwrap();
        let rise = elastic.iter().zip(&force).map(|(b, a)| b - a);
        let moved = state.displacement.iter().zip(&before).map(|(b, a)| b - a);
        dissipated += beta / STEP * rise.zip(moved).map(|(f, u)| f * u).sum::<f64>();
        work += gain;
        turnover += gain.abs();
        stored = solver.elastic_energy(&state.displacement).unwrap() + solver.kinetic_energy(&state.velocity).unwrap();
        (before, force, time) = (state.displacement.clone(), elastic, t);
    };
    let mut moving = system.solver();
    moving.set_relaxation(0, fem::Relaxation::default()).unwrap();
    moving
        .integrate(&InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures }, 120, &mut keep)
        .unwrap();
    let residual = work - dissipated - stored;
    println!(
        "work {work:.4e} J (turnover {turnover:.4e} J), dissipated {dissipated:.4e} J, stored {stored:.4e} J, residual {residual:.2e} J"
    );
    assert!(residual.abs() < 0.01 * work, "{residual} J of {work} J are unaccounted for");
}
