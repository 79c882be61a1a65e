//! What a solve costs, in CPU seconds and as ratios taken in one run, on hollow beams with ribs and a stiff sheet.
//!
//! `just bench` runs it; `-- --long` behind its command takes a motion of 2000 steps and its gradient instead, some ten minutes.
//!
//! Stands on: `fem` as its users see it, `faer`. Never knows: a specimen.

mod beams;
mod clock;
mod linear;
mod parts;
mod projective;
mod quadratic;

use fem::boxes;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    if std::env::args().any(|word| word == "--memory") {
        return quadratic::memory();
    }
    if std::env::args().any(|word| word == "--long") {
        return linear::long_motion();
    }
    let system = beams::system(boxes::with_middles(&beams::slender(5)), 12500.0)?;
    println!("10-node hollow beam: {system:?}");
    parts::iteration(&system)?;
    quadratic::solves(&system)?;
    quadratic::two_cores(&system)?;
    quadratic::memory_of_another()?;
    linear::as_diffpd()?;
    projective::beside_newton()
}
