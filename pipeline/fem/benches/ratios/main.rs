//! What a solve costs, in CPU seconds and as ratios taken in one run, on hollow beams with ribs and a stiff sheet.
//!
//! `just bench` runs it; `-- --long` behind its command takes a motion of 2000 steps and its gradient instead, some ten minutes.

mod beams;
mod clock;
mod iteration;
mod linear;
mod projective;
mod quadratic;

use fem::box_mesh;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    if std::env::args().any(|word| word == "--memory") {
        return quadratic::memory();
    }
    if std::env::args().any(|word| word == "--long") {
        return linear::long_motion();
    }
    let system = beams::system(box_mesh::to_quadratic(&beams::slender(5)), 12500.0)?;
    println!("10-node hollow beam: {system:?}");
    iteration::iteration(&system)?;
    quadratic::solves(&system)?;
    quadratic::two_cores(&system)?;
    quadratic::memory_of_another()?;
    linear::as_diffpd()?;
    projective::against_newton()
}
