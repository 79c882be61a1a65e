//! The bench's motions: the reduced tail against the whole one, in air and in water, and the books of the whole one's energy.
//!
//! Stands on: `rig`, `fem`. Never knows: a recording.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{March, Scheme, State};
use lab::card::Side;
use nalgebra::DVector;
use rig::draw::Draw;
use rig::physics::{Body, CentreLine, Conditions, Fluid, Ladder, Motion, Swimmer, Water, march};
use rig::settings::{Resolution, Settings};
use rig::specimen::{Hidden, SHEET};
use rig::specimens::ALL;
use rig::valve::{Command, Trace, Unrest, follow};
use shape::tail::Tail;

/// Nemo on a mesh for tests.
struct Coarse {
    set: Settings,
    tail: Tail,
    body: Body,
}

impl Coarse {
    fn nemo() -> Self {
        let set = Settings::built_in();
        let own = &set.specimen["nemo"];
        let hidden = Hidden::drawn(&set, own);
        let fineness = Resolution { edge: 0.010, per_chamber: 1, per_rib: 1 };
        let tail = (ALL[0].tail)();
        let materials = [&set.material[&own.body], &set.material[SHEET]];
        let body = Body::new(&tail, &fineness, own.clamp, materials, &hidden).unwrap();
        Self { tail: hidden.cast(&tail), body, set }
    }

    fn clamp(&self) -> f64 {
        self.set.specimen["nemo"].clamp
    }

    /// Both sides' ladders to 200 mbar.
    fn ladders(&self) -> [Ladder; 2] {
        [Side::Left, Side::Right].map(|side| Ladder::climb(&self.body, side, 2.0e4, 10, &|| ()).unwrap())
    }

    fn swimmer(&self) -> Swimmer<'_> {
        Swimmer::train(&self.body, &self.tail, self.clamp(), &self.ladders(), &|| ()).unwrap()
    }

    /// Both sides' pressures when they are filled in turn, left first.
    fn beat(&self, frequency: f64, cycles: usize) -> [Trace; 2] {
        let half = 0.5 / frequency;
        let commands = |late: f64| -> Vec<Command> {
            let one = |i: usize| {
                let start = 2.0 * half * i as f64 + late;
                [Command { time: start, pressure: 2e4 }, Command { time: start + half, pressure: 0.0 }]
            };
            (0..cycles).flat_map(one).collect()
        };
        let mut draw = Draw::new(1, "valve");
        [0.0, half].map(|late| follow(&self.set.valve, &commands(late), Unrest::default(), &mut draw))
    }

    /// The node at the fin's tip.
    fn tip(&self) -> usize {
        let nodes = &self.body.mesh.nodes;
        (0..nodes.len()).max_by(|a, b| nodes[*a][0].total_cmp(&nodes[*b][0])).unwrap()
    }
}

const STEP: f64 = 1.0 / 240.0;

/// Largest sideways place, and largest difference, of the tip in both motions.
fn apart(coarse: &Coarse, whole: &dyn Motion, less: &dyn Motion, length: f64) -> (f64, f64) {
    let tip = coarse.tip();
    let place = |motion: &dyn Motion, i: usize| motion.nodes(i as f64 / 60.0)[tip][1];
    let steps = (length * 60.0) as usize;
    (0..steps).fold((0.0, 0.0), |(size, off), i| {
        let (a, b) = (place(whole, i), place(less, i));
        (f64::max(size, a.abs()), f64::max(off, (a - b).abs()))
    })
}

#[test]
fn in_air_the_reduced_tail_beats_as_the_whole_one_to_two_per_cent() {
    let coarse = Coarse::nemo();
    let swimmer = coarse.swimmer();
    for (frequency, length) in [(2.0, 0.6), (4.0, 0.4)] {
        let [left, right] = coarse.beat(frequency, 2);
        let pressures = |t: f64| [left.at(t), right.at(t)];
        let whole = march(&coarse.body, [0.0, length], 60.0, STEP, &pressures, &|| ()).unwrap();
        let still = Conditions { fluid: None, softening: 1.0 };
        let less = swimmer.flap([0.0, length], STEP, &pressures, &still).unwrap();
        let (size, off) = apart(&coarse, &whole, &less, length);
        println!("{frequency} Hz: the tip moves {:.2} mm, off by {:.3} mm", size * 1e3, off * 1e3);
        assert!(size > 5e-3 && off < 0.02 * size, "{frequency} Hz: off by {off} of {size} m");
    }
}

#[test]
fn a_tail_on_its_stairs_swings_as_the_whole_one_and_rests_where_that_rests() {
    let coarse = Coarse::nemo();
    let (swimmer, ladders) = (coarse.swimmer(), coarse.ladders());
    let commands = [Command { time: 0.0, pressure: 1.7e4 }, Command { time: 0.5, pressure: 0.0 }];
    let trace = follow(&coarse.set.valve, &commands, Unrest::default(), &mut Draw::new(1, "valve"));
    let stairs = swimmer.stairs(Side::Left, &ladders[0], trace.clone(), [0.0, 0.8], STEP, None).unwrap();
    let whole = march(&coarse.body, [0.0, 0.8], 60.0, STEP, &|t| [trace.at(t), 0.0], &|| ()).unwrap();
    let (size, off) = apart(&coarse, &whole, &stairs, 0.8);
    let held = trace.at(0.49);
    let at_rest = coarse.body.system.solver().equilibrium(
        &coarse.body.one_side(Side::Left, held),
        Some(ladders[0].nearest(held)),
        &fem::StaticSettings::default(),
    );
    let tip = coarse.tip();
    let rests = at_rest.unwrap().displacement[3 * tip + 1] + coarse.body.mesh.nodes[tip][1];
    let still = (stairs.nodes(0.49)[tip][1] - rests).abs();
    println!("the tip moves {:.2} mm, off by {:.3} mm, held {:.4} mm off", size * 1e3, off * 1e3, still * 1e3);
    assert!(size > 5e-3 && off < 0.02 * size, "off by {off} of {size} m");
    assert!(still < 2e-5, "held {still} m off the whole body's equilibrium");
    let seen = stairs.seen(0.53, &[tip as u32]);
    assert_eq!(seen[tip], stairs.nodes(0.53)[tip]);
}

/// Implicit Euler, so that the whole body can be given the water's force step by step.
#[test]
fn in_water_the_whole_tail_moves_as_the_reduced_one_says_to_two_per_cent() {
    let coarse = Coarse::nemo();
    let swimmer = coarse.swimmer();
    let fluid = Fluid { density: 998.0, added: 1.0, drag: 2.0 };
    let [left, right] = coarse.beat(2.0, 1);
    let rows = swimmer.line.rows(&swimmer.reduced);
    let rest = swimmer.line.rest(&coarse.body);
    let mut noted =
        Noted { water: Water::around(&swimmer.line, fluid, &rest, &rows, coarse.body.mesh.half), forces: Vec::new() };
    let march = March {
        step: STEP,
        scheme: Scheme::ImplicitEuler,
        stiffness_damping: coarse.body.stiffness_damping,
        ..March::default()
    };
    let pressures = |t: f64| coarse.body.pressures(left.at(t), right.at(t));
    let drive = |t: f64| fem::Drive { pressures: pressures(t) };
    let (tip, mut less) = (coarse.tip(), Vec::new());
    let mut keep = |_: f64, q: &DVector<f64>, _: &DVector<f64>| less.push(swimmer.reduced.displacement(q)[3 * tip + 1]);
    swimmer.reduced.march(&march, &[1.0, 1.0], &drive, &mut noted, 90, &mut keep).unwrap();
    let whole = pushed(&coarse, &swimmer.line, &march, &pressures, &noted.forces, tip);
    let size = whole.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let off = whole.iter().zip(&less).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    println!("in water the tip moves {:.2} mm, off by {:.3} mm", size * 1e3, off * 1e3);
    assert!(size > 5e-3 && off < 0.02 * size, "off by {off} of {size} m");
}

/// Water that notes its forces on the stations.
struct Noted<'a> {
    water: Water<'a>,
    forces: Vec<DVector<f64>>,
}

impl fem::Around for Noted<'_> {
    fn force(&self, at: &fem::Moment) -> DVector<f64> {
        self.water.force(at)
    }

    fn accept(&mut self, at: &fem::Moment) {
        self.water.accept(at);
        self.forces.push(self.water.forces.clone());
    }
}

/// The whole body's tip, step by step, under pressures and the stations' `forces`.
fn pushed(
    coarse: &Coarse,
    line: &CentreLine,
    march: &March,
    pressures: &dyn Fn(f64) -> Vec<f64>,
    forces: &[DVector<f64>],
    tip: usize,
) -> Vec<f64> {
    let nodes = coarse.body.mesh.nodes.len();
    let share = if coarse.body.mesh.half { 0.5 } else { 1.0 };
    let mut solver = coarse.body.system.solver();
    let mut state = State::rest(nodes);
    let mut tips = Vec::new();
    for (i, force) in forces.iter().enumerate() {
        solver.set_forces(&line.handed_over(nodes, &(force * share))).unwrap();
        let now = |_: f64| pressures((i + 1) as f64 * STEP);
        state = solver.march(march, &state, &now, 1, &mut |_, _| ()).unwrap();
        tips.push(state.displacement[3 * tip + 1]);
    }
    tips
}

#[test]
fn the_books_of_the_whole_tail_s_energy_close_to_one_per_cent_over_a_cycle() {
    let coarse = Coarse::nemo();
    let [left, right] = coarse.beat(2.0, 1);
    let pressures = |t: f64| coarse.body.pressures(left.at(t), right.at(t));
    let beta = coarse.body.stiffness_damping;
    let march = March { step: STEP, scheme: Scheme::Bdf2, stiffness_damping: beta, ..March::default() };
    let system = &coarse.body.system;
    let books = system.solver();
    let volumes = |u: &[f64]| [0, 1].map(|chamber| system.chamber_volume(chamber, u));
    let rest = State::rest(coarse.body.mesh.nodes.len());
    let (mut before, mut force) = (rest.displacement.clone(), vec![0.0; rest.displacement.len()]);
    let (mut time, mut work, mut lost, mut kept, mut flow) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut keep = |t: f64, state: &State| {
        let (then, now) = (volumes(&before), volumes(&state.displacement));
        let (p, q) = (pressures(time), pressures(t));
        let gain: f64 = (0..2).map(|c| 0.5 * (p[c] + q[c]) * (now[c] - then[c])).sum();
        let pushes = books.elastic_force(&state.displacement).unwrap();
        let rise = pushes.iter().zip(&force).map(|(b, a)| b - a);
        let moved = state.displacement.iter().zip(&before).map(|(b, a)| b - a);
        lost += beta / STEP * rise.zip(moved).map(|(f, u)| f * u).sum::<f64>();
        work += gain;
        flow += gain.abs();
        kept = books.elastic_energy(&state.displacement).unwrap() + books.kinetic_energy(&state.velocity).unwrap();
        (before, force, time) = (state.displacement.clone(), pushes, t);
    };
    system.solver().march(&march, &rest, &pressures, 120, &mut keep).unwrap();
    let open = work - lost - kept;
    println!("of {work:.4e} J ({flow:.4e} J to and fro) {lost:.4e} J are lost, {kept:.4e} J kept, {open:.2e} J open");
    assert!(open.abs() < 0.01 * work, "{open} J of {work} J are unaccounted for");
}
