//! What relaxation costs: a motion with four branches over the elastic one, of the whole and of the reduced model, and its gradient.

use std::time::Instant;

use fem::{
    Actuation, Branch, Clamps, DynamicSettings, InitialValueProblem, LossGradient, Mesh, NoForce, ReducedMotion,
    ReductionSettings, RegionProperties, Relaxation, Scheme, State, StaticSettings, System, box_mesh, materials,
};
use nalgebra::DVector;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

const STEPS: usize = 20;
/// Of the reduced model, whose steps are short.
const REDUCED_STEPS: usize = 480;
/// The word after which the motion is named whose memory is asked.
const MEMORY: &str = "--memory";
/// Pa.
const PRESSURE: f64 = 8e3;

fn main() -> Outcome<()> {
    let system = hollow_beam()?;
    let four = [0.002, 0.02, 0.2, 2.0].map(|time| Branch { strength: 0.1, time });
    let relaxation = Relaxation::maxwell(&four)?;
    // this process run once more for its memory alone
    if let Some(which) = std::env::args().skip_while(|word| word != MEMORY).nth(1) {
        motion(&system, &if which == "relaxing" { relaxation } else { Relaxation::default() })?;
        print!("{}", peak_memory());
        return Ok(());
    }
    println!("hollow beam of 10-node elements: {} unknowns, {STEPS} steps", system.dofs());
    let [elastic, relaxing] = [motion(&system, &Relaxation::default())?, motion(&system, &relaxation)?];
    println!("whole_step_elastic = {:.4} s", elastic.step);
    println!("whole_step_four_branches_over_elastic = {:.2}", relaxing.step / elastic.step);
    println!("gradient_over_its_steps_elastic = {:.2}", elastic.gradient / elastic.step);
    println!("gradient_over_its_steps_four_branches = {:.2}", relaxing.gradient / relaxing.step);
    println!("peak memory, elastic {}; with four branches {}", peak_of("elastic")?, peak_of("relaxing")?);
    reduced(&system, &relaxation)
}

/// Seconds a step, forwards and backwards.
struct Motion {
    step: f64,
    gradient: f64,
}

/// Peak memory of another process that makes one of the motions and its gradient.
fn peak_of(which: &str) -> Outcome<String> {
    let output = std::process::Command::new(std::env::current_exe()?).args([MEMORY, which]).output()?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The most memory that this process has had, as reported by the kernel.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")).map_or("unknown", str::trim).to_owned()
}

fn motion(system: &System, relaxation: &Relaxation) -> Outcome<Motion> {
    let settings = DynamicSettings { step: 1.0 / 240.0, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
    let rest_state = State::rest(system.mesh().nodes.len());
    let push = |time: f64| vec![PRESSURE * (1.0 - (12.0 * time).cos()), 0.0];
    let mut solver = system.solver();
    solver.set_relaxation(0, relaxation.clone())?;
    let problem = InitialValueProblem { settings: &settings, initial: &rest_state, pressures: &push };
    let (forward, made) = timed(3, || Ok(solver.record(&problem, STEPS, usize::MAX)?))?;
    let last_step = made.steps();
    let mut ask = |n: usize, state: &State| {
        let displacement = if n == last_step { state.displacement.clone() } else { Vec::new() };
        LossGradient { displacement, ..LossGradient::default() }
    };
    let (backward, _) = timed(3, || Ok(solver.trajectory_adjoint(&made, &mut ask)?))?;
    Ok(Motion { step: forward / STEPS as f64, gradient: backward / STEPS as f64 })
}

fn reduced(system: &System, relaxation: &Relaxation) -> Outcome<()> {
    let mut solver = system.solver();
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for level in 1..=6 {
        for side in [0, 1] {
            let mut pressures = vec![0.0; 2];
            pressures[side] = 2.0 * PRESSURE * f64::from(level) / 6.0;
            shapes.push(solver.equilibrium(&pressures, None, &StaticSettings::default())?.displacement);
        }
    }
    let shapes: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let model = system.reduce(&shapes, &ReductionSettings::default())?;
    let settings = DynamicSettings { step: 1.0 / 240.0, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
    let actuation = |time: f64| Actuation { pressures: vec![PRESSURE * (1.0 - (12.0 * time).cos()), 0.0] };
    let run = |relaxation: &[Relaxation]| {
        let motion = ReducedMotion {
            settings: &settings,
            modulus_scale: &[1.0],
            relaxation,
            stiffening: &[],
            actuation: &actuation,
        };
        let times: Vec<f64> = (1..=REDUCED_STEPS).map(|i| i as f64 * settings.step).collect();
        let mut observer = |_: f64, _: &DVector<f64>, _: &DVector<f64>| ();
        timed(3, || Ok(model.integrate_at(&motion, &mut NoForce, &times, &mut observer)?)).map(|(seconds, ())| seconds)
    };
    let (elastic, relaxing) = (run(&[])?, run(std::slice::from_ref(relaxation))?);
    let points: usize = model.points().iter().sum();
    println!("reduced: {} coordinates, {points} points", model.coordinates());
    println!("reduced_step_elastic = {:.6} s", elastic / REDUCED_STEPS as f64);
    println!("reduced_step_four_branches_over_elastic = {:.2}", relaxing / elastic);
    Ok(())
}

/// A clamped beam of silicone with a chamber on either side, its upper half.
fn hollow_beam() -> Outcome<System> {
    let mesh = box_mesh::to_quadratic(&two_chambers());
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let material = materials::by_name("neo_hookean").ok_or("no such material")?;
    Ok(System::new(mesh, vec![RegionProperties::elastic(material, 2e5, 0.48, 1070.0)], clamps)?)
}

fn two_chambers() -> Mesh {
    let cells = [30, 7, 3];
    let air = |[i, j, k]: [usize; 3]| (2..28).contains(&i) && (j == 1 || j == 2 || j == 4 || j == 5) && k < 2;
    let position = |at: [f64; 3]| [0.09 * at[0], 0.021 * (at[1] - 0.5), 0.009 * at[2]];
    box_mesh::grid(cells, true, position, |cell| if air(cell) { None } else { Some(0) })
}

/// The least CPU time of several runs of this thread, s, and what the last one gave.
fn timed<T>(times: usize, mut run: impl FnMut() -> Outcome<T>) -> Outcome<(f64, T)> {
    let clock = Instant::now();
    let (mut least, mut given) = (f64::INFINITY, None);
    for _ in 0..times {
        let start_seconds = cpu(clock);
        given = Some(run()?);
        least = least.min(cpu(clock) - start_seconds);
    }
    Ok((least, given.ok_or("nothing was run")?))
}

/// Seconds that this thread has run, from the kernel where available, else from the wall clock.
fn cpu(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = text.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}
