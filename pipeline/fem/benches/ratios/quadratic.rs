//! Whole equilibria with 10-node elements: cold, warm, with their gradient, on both cores.

use crate::Outcome;
use crate::beams::{slender, system};
use crate::clock::{say, timed};
use fem::{Equilibrium, StaticSettings, System, box_mesh};
use std::time::Instant;

/// Cold and warm solves, and the gradient, and the same tetrahedra without mid-edge nodes.
pub fn solves(system: &System) -> Outcome<()> {
    let set = StaticSettings::default();
    let mut solver = system.solver();
    let (from_rest, low) = timed(1, || Ok(solver.equilibrium(&[0.0, 2e4], None, &set)?))?;
    say(&counted("from rest to 200 mbar", &low), from_rest, None);
    let start = Some(low.displacement.as_slice());
    let (cold, high) = timed(2, || Ok(system.solver().equilibrium(&[0.0, 2.5e4], start, &set)?))?;
    say(&counted("cold, from 200 to 250 mbar", &high), cold, None);
    let high = solver.equilibrium(&high.pressures, start, &set)?;
    let (gradient, _) = timed(1, || Ok(solver.gradient(&high, &high.displacement)?))?;
    say("gradient by everything", gradient, Some((cold, "its forward solve, cold")));
    solver.set_elastic(0, 1.05 * 2e5, 0.45)?;
    let reuse = StaticSettings { reuse_factor: true, ..set };
    let start = Some(high.displacement.as_slice());
    let (warm, again) = timed(1, || Ok(solver.equilibrium(&[0.0, 2.5e4], start, &reuse)?))?;
    say(&counted("warm, after E + 5 %", &again), warm, Some((cold, "cold")));
    let coarse = self::system(slender(5), 12500.0)?;
    let (linear, _) = timed(1, || Ok(coarse.solver().equilibrium(&[0.0, 2e4], None, &set)?))?;
    say("the same from rest to 200 mbar with 10 nodes", from_rest, Some((linear, "4 nodes on the same tetrahedra")));
    Ok(())
}

pub fn counted(what: &str, at: &Equilibrium) -> String {
    format!("{what} ({} its, {} factors)", at.iterations, at.factorisations)
}

/// Two pressure levels side by side over one after the other, by the wall clock.
pub fn two_cores(system: &System) -> Outcome<()> {
    let set = StaticSettings::default();
    let level = |pressure: f64| system.solver().equilibrium(&[0.0, pressure], None, &set).map(|_| ());
    let clock = Instant::now();
    level(1e4)?;
    level(1.05e4)?;
    let sequential_seconds = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    std::thread::scope(|scope| {
        let second_solve = scope.spawn(|| level(1e4));
        level(1.05e4)?;
        second_solve.join().map_err(|_| "a solve broke down")??;
        Ok::<(), Box<dyn std::error::Error>>(())
    })?;
    let parallel_seconds = clock.elapsed().as_secs_f64();
    println!(
        "two levels on two cores: {sequential_seconds:.3} s over {parallel_seconds:.3} s = {:.2} ×",
        sequential_seconds / parallel_seconds
    );
    Ok(())
}

/// Prints the peak memory of another process that solves about 150 thousand dofs.
pub fn memory_of_another() -> Outcome<()> {
    let output = std::process::Command::new(std::env::current_exe()?).arg("--memory").output()?;
    print!("{}", String::from_utf8_lossy(&output.stdout));
    Ok(())
}

/// Solves about 150 thousand dofs, and prints the peak memory of this process.
pub fn memory() -> Outcome<()> {
    let system = system(box_mesh::to_quadratic(&slender(17)), 12500.0)?;
    let set = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let (time, at) = timed(1, || Ok(system.solver().equilibrium(&[0.0, 5e3], None, &set)?))?;
    let peak = peak_memory();
    println!("{} dofs, {}: {time:.1} s, peak memory {peak}", system.dofs(), counted("50 mbar", &at));
    Ok(())
}

/// The most memory that this process has had, as reported by the kernel.
pub fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")).map_or("unknown", str::trim).to_owned()
}
