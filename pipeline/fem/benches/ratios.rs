//! What a solve costs, in CPU seconds and as ratios taken in one run, on a hollow beam with ribs and a stiff sheet.
//!
//! `just bench` runs it. Each line: what, its time, and its time over the time it is compared with; targets beside it.
//!
//! Stands on: `fem` as its users see it, `faer`. Never knows: a specimen.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Par, Side};
use fem::{Clamps, Equilibrium, LowerTriangle, March, Mesh, RegionProperties, Scheme, Slope, State, StaticSettings};
use fem::{System, boxes, materials};
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Boundaries of the layers across, m: wall, chamber, silicone, sheet, silicone, chamber, wall.
const ACROSS: [f64; 10] = [-0.010, -0.008, -0.0045, -0.001, -0.00025, 0.00025, 0.001, 0.0045, 0.008, 0.010];
/// Boundaries upwards from the middle, m: channel, chamber, wall.
const UP: [f64; 6] = [0.0, 0.002, 0.006, 0.010, 0.014, 0.016];

/// The upper half of a beam of so many pitches, each of so many cells along it, as 4-node tetrahedra; every cell in `fine`
/// parts along each axis.
fn beam(pitches: usize, cells: usize, fine: usize) -> Mesh {
    let along = pitches * cells + 1;
    let air = move |cell: [usize; 3]| {
        let [i, j, k] = cell.map(|at| at / fine);
        let side = (1..3).contains(&j) || (6..8).contains(&j);
        side && k < 4 && i > 0 && i + 1 < along && (!i.is_multiple_of(cells) || k < 1)
    };
    let between = |list: &[f64], at: f64| {
        let place = (at * (list.len() - 1) as f64).clamp(0.0, (list.len() - 1) as f64);
        let low = (place.floor() as usize).min(list.len() - 2);
        list[low] + (place - low as f64) * (list[low + 1] - list[low])
    };
    let place = move |at: [f64; 3]| {
        let x = at[0] * along as f64;
        let (pitch, step) = ((x / cells as f64).floor(), x % cells as f64);
        let inside = if step <= 1.0 { 0.0025 * step } else { 0.0025 + 0.0075 * (step - 1.0) / (cells as f64 - 1.0) };
        [0.010 * pitch + inside, between(&ACROSS, at[1]), between(&UP, at[2])]
    };
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] / fine == 4)) };
    boxes::grid([along * fine, 9 * fine, 5 * fine], true, place, region)
}

fn system(mesh: Mesh, contrast: f64) -> Outcome<System> {
    let material = materials::by_name("corotated").ok_or("no such material")?;
    let silicone = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.47, density: 1070.0 };
    let sheet = RegionProperties { youngs_modulus: contrast * 2e5, poissons_ratio: 0.37, density: 1410.0, ..silicone };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    Ok(System::new(mesh, vec![silicone, sheet], clamps)?)
}

/// Seconds that this thread has run, from the kernel where it tells, else from the wall clock.
fn cpu(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// The least CPU time of `times` runs, and what the last one gave.
fn timed<T>(times: usize, mut run: impl FnMut() -> Outcome<T>) -> Outcome<(f64, T)> {
    let clock = Instant::now();
    let mut least = f64::INFINITY;
    let mut given = None;
    for _ in 0..times {
        let before = cpu(clock);
        given = Some(run()?);
        least = least.min(cpu(clock) - before);
    }
    Ok((least, given.ok_or("nothing was run")?))
}

fn say(what: &str, seconds: f64, over: Option<(f64, &str, f64)>) {
    match over {
        Some((other, name, target)) => {
            println!("{what:48} {seconds:8.3} s   {:6.3} of {name} (target {target:.3})", seconds / other);
        }
        None => println!("{what:48} {seconds:8.3} s"),
    }
}

fn main() -> Outcome<()> {
    if std::env::args().any(|word| word == "--memory") {
        return memory();
    }
    if std::env::args().any(|word| word == "--linear") {
        return linear_tetrahedra();
    }
    if std::env::args().any(|word| word == "--warm") {
        return solves(&system(boxes::with_middles(&beam(9, 5, 1)), 12500.0)?).map(|_| ());
    }
    let linear = beam(9, 5, 1);
    let quadratic = system(boxes::with_middles(&linear), 12500.0)?;
    println!("10-node hollow beam: {quadratic:?}, entries {:?}", quadratic.entries());
    parts(&quadratic)?;
    let cold = solves(&quadratic)?;
    orders(&linear, cold)?;
    two_cores(&quadratic)?;
    linear_tetrahedra()?;
    memory_of_another()
}

/// Assembly, factor and solve of one iteration.
fn parts(system: &System) -> Outcome<()> {
    let mut solver = system.solver();
    let at = solver.equilibrium(&[0.0, 1e4], None, &StaticSettings::default())?;
    let (assembly, ()) = timed(3, || Ok(solver.assemble(&at).map(|_| ())?))?;
    let (faer, ()) = faers_own(&solver.assemble(&at)?)?;
    let (factor, ()) = timed(3, || Ok(solver.factorise(&at)?))?;
    let b = vec![1.0; at.displacement.len()];
    let (solve, _) = timed(5, || Ok(solver.solve(&b)?))?;
    let iteration = assembly + factor + solve;
    say("assembly of the tangent", assembly, Some((iteration, "an iteration", 0.10)));
    say("factor, checked", factor, Some((faer, "faer's own on the same matrix", 1.1)));
    say("solve", solve, None);
    Ok(())
}

/// faer's supernodal factor of a matrix in the order that it has.
fn faers_own(matrix: &LowerTriangle) -> Outcome<(f64, ())> {
    let n = matrix.columns.len() - 1;
    let lower = SymbolicSparseColMat::new_checked(n, n, matrix.columns.to_vec(), None, matrix.rows.to_vec());
    let params = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    let (columns, rows) = transposed(matrix);
    let upper = SymbolicSparseColMat::new_checked(n, n, columns, None, rows);
    let symbolic = factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)
        .map_err(|fault| fault.to_string())?;
    let mut values = vec![0.0; symbolic.len_val()];
    let mut space = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()));
    timed(3, || {
        let a = SparseColMatRef::new(lower.as_ref(), matrix.values);
        let (set, stack) = (LltRegularization::default(), MemStack::new(&mut space));
        let made =
            symbolic.factorize_numeric_llt(&mut values, a, Side::Lower, set, Par::Seq, stack, Default::default());
        made.map(|_| ()).map_err(|fault| format!("{fault:?}").into())
    })
}

fn transposed(matrix: &LowerTriangle) -> (Vec<u32>, Vec<u32>) {
    let n = matrix.columns.len() - 1;
    let mut by_row = vec![Vec::new(); n];
    for column in 0..n {
        for &row in &matrix.rows[matrix.columns[column] as usize..matrix.columns[column + 1] as usize] {
            by_row[row as usize].push(column as u32);
        }
    }
    let mut starts = vec![0u32];
    by_row.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len() as u32));
    (starts, by_row.concat())
}

/// Cold and warm solves, and the gradient; returns the time of the solve from rest.
fn solves(system: &System) -> Outcome<f64> {
    let set = StaticSettings::default();
    let mut solver = system.solver();
    let (from_rest, low) = timed(1, || Ok(solver.equilibrium(&[0.0, 2e4], None, &set)?))?;
    say(&counted("from rest to 200 mbar", &low), from_rest, None);
    let start = Some(low.displacement.as_slice());
    let (cold, high) = timed(2, || Ok(system.solver().equilibrium(&[0.0, 2.5e4], start, &set)?))?;
    say(&counted("cold, from 200 to 250 mbar", &high), cold, None);
    solver.equilibrium(&[0.0, 2.5e4], start, &set)?;
    solver.set_elastic(0, 1.05 * 2e5, 0.47)?;
    let reuse = StaticSettings { reuse_factor: true, ..set };
    let start = Some(high.displacement.as_slice());
    let (warm, again) = timed(1, || Ok(solver.equilibrium(&[0.0, 2.5e4], start, &reuse)?))?;
    say(&counted("warm, after E + 5 %", &again), warm, Some((cold, "cold", 0.5)));
    let (gradient, _) = timed(1, || Ok(solver.gradient(&again, &again.displacement)?))?;
    say("gradient by everything", gradient, Some((cold, "its forward solve, cold", 0.2)));
    Ok(from_rest)
}

fn counted(what: &str, at: &Equilibrium) -> String {
    format!("{what} ({} its, {} factors)", at.iterations, at.factorisations)
}

/// 10-node against 4-node elements on the same tetrahedra.
fn orders(linear: &Mesh, quadratic: f64) -> Outcome<()> {
    let system = system(linear.clone(), 12500.0)?;
    let set = StaticSettings::default();
    let (time, _) = timed(1, || Ok(system.solver().equilibrium(&[0.0, 2e4], None, &set)?))?;
    say("10-node from rest to 200 mbar", quadratic, Some((time, "4-node on the same tetrahedra", f64::NAN)));
    Ok(())
}

/// Two pressure levels side by side over one after the other, by the wall clock.
fn two_cores(system: &System) -> Outcome<()> {
    let set = StaticSettings::default();
    let level = |pressure: f64| system.solver().equilibrium(&[0.0, pressure], None, &set).map(|_| ());
    let clock = Instant::now();
    level(1e4)?;
    level(1.05e4)?;
    let one = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| level(1e4));
        level(1.05e4)?;
        other.join().map_err(|_| "a solve broke down")??;
        Ok::<(), Box<dyn std::error::Error>>(())
    })?;
    let two = clock.elapsed().as_secs_f64();
    println!("two levels on two cores: {one:.3} s over {two:.3} s = {:.2} × (target 1.7 ×)", one / two);
    Ok(())
}

/// The size that DiffPD was measured at: about 33 thousand freedoms in 4-node tetrahedra.
fn linear_tetrahedra() -> Outcome<()> {
    let system = system(beam(8, 4, 2), 12500.0)?;
    println!("4-node hollow beam: {system:?}, entries {:?}", system.entries());
    parts(&system)?;
    let mut solver = system.solver();
    let set = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let (time, at) = timed(1, || Ok(solver.equilibrium(&[0.0, 2e4], None, &set)?))?;
    say(&counted("static solve, 200 mbar", &at), time, Some((136.0, "DiffPD's 136 s", 4.0 / 136.0)));
    let march = March { step: 1.0 / 100.0, scheme: Scheme::ImplicitEuler, ..March::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let push = |_: f64| vec![0.0, 1e4];
    let (step, _) = timed(1, || Ok(system.solver().march(&march, &rest, &push, 1, &mut |_, _| ())?))?;
    say("the first implicit Euler step, 100 mbar at once", step, Some((38.0, "DiffPD's 38 s", 1.0 / 38.0)));
    let (forward, made) = timed(1, || Ok(solver.record(&march, &rest, &push, 20, usize::MAX)?))?;
    say("20 steps", forward, None);
    say("a step, on the average of 20", forward / 20.0, Some((38.0, "DiffPD's 38 s", 1.0 / 38.0)));
    let last = made.steps();
    let mut ask = |n: usize, state: &State| {
        let displacement = if n == last { state.displacement.clone() } else { Vec::new() };
        Slope { displacement, ..Slope::default() }
    };
    let (backward, _) = timed(1, || Ok(solver.backward(&made, &mut ask)?))?;
    say("their gradient", backward, Some((forward, "the 20 steps", 0.5)));
    say("20 steps with gradient", forward + backward, Some((542.0, "DiffPD's 542 s", 15.0 / 542.0)));
    Ok(())
}

/// Peak memory of a process that solves about 150 thousand freedoms.
fn memory_of_another() -> Outcome<()> {
    let told = std::process::Command::new(std::env::current_exe()?).arg("--memory").output()?;
    print!("{}", String::from_utf8_lossy(&told.stdout));
    Ok(())
}

fn memory() -> Outcome<()> {
    let system = system(boxes::with_middles(&beam(9, 15, 1)), 12500.0)?;
    let set = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let (time, at) = timed(1, || Ok(system.solver().equilibrium(&[0.0, 5e3], None, &set)?))?;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).map_or("unknown", str::trim);
    println!(
        "{} freedoms, {}: {time:.1} s, peak memory {peak} (target 2 GiB)",
        system.freedoms(),
        counted("50 mbar", &at)
    );
    Ok(())
}
