//! Projective dynamics beside Newton's method: iterations and CPU seconds of one implicit step and of its gradient, on a
//! hollow beam of 4-node tetrahedra whose sheet is 1, 100 and 10000 times as stiff as its silicone.
//!
//! `cargo bench --workspace --bench projective`; all in one run, so that the ratios hold whatever the machine. DiffPD, measured on
//! such a beam: one step of 33 thousand freedoms 38 to 42 s by projective dynamics and 73 s by Newton; on a coarser one
//! 311, 700 and 2645 iterations forwards, 322, 1038 and more than 4000 backwards, at ratios of 1, 100 and 12500.
//!
//! Stands on: `fem` as its users see it. Never knows: a specimen.

use fem::{Clamps, March, Mesh, Projective, ProjectiveSettings, RegionProperties, Scheme, State, System};
use fem::{boxes, materials};
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// One implicit step, s, under one chamber's pressure, Pa.
const STEP: f64 = 0.01;
const PRESSURE: f64 = 1e4;
const RATIOS: [f64; 3] = [1.0, 1e2, 1e4];
/// Boundaries of the layers across and upwards from the middle, m.
const ACROSS: [f64; 16] = [
    -0.0120, -0.0110, -0.0100, -0.0078, -0.0056, -0.0034, -0.0012, -0.00025, 0.00025, 0.0012, 0.0034, 0.0056, 0.0078,
    0.0100, 0.0110, 0.0120,
];
const UP: [f64; 10] = [0.0, 0.0016, 0.0032, 0.0048, 0.0064, 0.0080, 0.0096, 0.0112, 0.0126, 0.0140];
/// A rib, and seven cells of chamber.
const PITCH: usize = 8;
const CELL: f64 = 0.00125;

/// The upper half of a beam of `pitches` chambers a side, joined by a channel along the middle, with a sheet between.
pub fn beam(pitches: usize) -> Mesh {
    let along = pitches * PITCH + 1;
    let air = move |[i, j, k]: [usize; 3]| {
        let side = (2..6).contains(&j) || (9..13).contains(&j);
        let inside = k < 7 && i > 0 && i + 1 < along;
        side && inside && (!i.is_multiple_of(PITCH) || k < 2)
    };
    let place = move |at: [f64; 3]| {
        let (y, z) = ((15.0 * at[1]).round() as usize, (9.0 * at[2]).round() as usize);
        [CELL * along as f64 * at[0], ACROSS[y], UP[z]]
    };
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 7)) };
    boxes::grid([along, 15, 9], true, place, region)
}

/// The beam with a sheet `ratio` times as stiff as the silicone.
pub fn system(mesh: Mesh, ratio: f64) -> Outcome<System> {
    let material = materials::by_name("corotated").ok_or("no such material")?;
    let silicone = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.45, density: 1070.0 };
    let sheet = RegionProperties { youngs_modulus: ratio * 2e5, poissons_ratio: 0.37, density: 1410.0, ..silicone };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    Ok(System::new(mesh, vec![silicone, sheet], clamps)?)
}

/// Seconds that this thread has run, from the kernel where it tells, else from the wall clock.
fn cpu(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// What `run` gives, and its seconds.
fn timed<T>(run: impl FnOnce() -> Outcome<T>) -> Outcome<(T, f64)> {
    let clock = Instant::now();
    let before = cpu(clock);
    let given = run()?;
    Ok((given, cpu(clock) - before))
}

/// Iterations and seconds, forwards and backwards.
pub struct Effort {
    /// Of the step.
    pub forwards: (usize, f64),
    /// Of its gradient.
    pub backwards: (usize, f64),
}

/// The same step and gradient by both.
pub struct Comparison {
    /// Iterations of a local and a global step each.
    pub projective: Effort,
    /// Factors forwards, iterations with a factor backwards.
    pub newton: Effort,
    /// Seconds of the constant matrix and its factor, made once for all steps.
    pub prepared: f64,
    /// Seconds of the solver's own march, which keeps a factor while it serves.
    pub march: f64,
    /// How far their steps and their gradients lie apart, over the largest entry.
    pub apart: [f64; 2],
}

/// Takes one step from rest and its gradient by both methods.
pub fn compare(system: &System) -> Outcome<Comparison> {
    let set = ProjectiveSettings::default();
    let rest = State::rest(system.mesh().nodes.len());
    let pressures = [0.0, PRESSURE];
    let b: Vec<f64> = (0..rest.displacement.len()).map(|at| f64::from(u8::from(at % 3 == 1))).collect();
    let (mut projective, prepared) = timed(|| Ok(Projective::new(system, STEP)?))?;
    let ((state, there), there_s) = timed(|| Ok(projective.step(&rest, &pressures, &[], &set)?))?;
    let ((z, back), back_s) = timed(|| Ok(projective.backward(&state.displacement, &pressures, &b, &set)?))?;
    let ((exact, steps), steps_s) = timed(|| Ok(projective.step_by_newton(&rest, &pressures, &[])?))?;
    let ((w, solve), solve_s) = timed(|| Ok(projective.backward_by_newton(&exact.displacement, &pressures, &b)?))?;
    let march = March { step: STEP, scheme: Scheme::ImplicitEuler, ..March::default() };
    let mut solver = system.solver();
    let (_, march) = timed(|| Ok(solver.march(&march, &rest, &|_| pressures.to_vec(), 1, &mut |_, _| ())?))?;
    Ok(Comparison {
        projective: Effort { forwards: (there, there_s), backwards: (back, back_s) },
        newton: Effort { forwards: (steps, steps_s), backwards: (solve, solve_s) },
        prepared,
        march,
        apart: [apart(&state.displacement, &exact.displacement), apart(&z, &w)],
    })
}

/// Largest difference over the largest entry of `exact`.
fn apart(found: &[f64], exact: &[f64]) -> f64 {
    let largest = |most: f64, x: f64| most.max(x.abs());
    found.iter().zip(exact).map(|(a, b)| a - b).fold(0.0, largest) / exact.iter().copied().fold(0.0, largest)
}

fn line(name: &str, (its, s): (usize, f64), (steps, newton_s): (usize, f64), apart: f64) {
    let ratio = s / newton_s;
    println!(
        "  {name:9} {its:6} its {s:8.3} s   Newton {steps:3} {newton_s:7.3} s   {ratio:6.1} ×   apart {apart:.1e}"
    );
}

/// Prints one line a ratio and direction.
pub fn table(mesh: &Mesh) -> Outcome<()> {
    for ratio in RATIOS {
        let system = system(mesh.clone(), ratio)?;
        let Comparison { projective, newton, prepared, march, apart } = compare(&system)?;
        let freedoms = system.freedoms();
        println!("sheet {ratio} × silicone, {freedoms} freedoms; constant factor {prepared:.3} s, march {march:.3} s");
        line("forwards", projective.forwards, newton.forwards, apart[0]);
        line("backwards", projective.backwards, newton.backwards, apart[1]);
    }
    Ok(())
}

fn main() -> Outcome<()> {
    table(&beam(11))
}
