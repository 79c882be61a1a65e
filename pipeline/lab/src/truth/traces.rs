//! True forces: what truly pulled on the fixture through a trial, part by part.

use std::fmt::Write;
use std::path::Path;

use serde::Deserialize;
use si::{Newton, Second};

use diagnostics::{Diagnostic, input};

/// Forces at even times, every list as long as `time`; N, forwards.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrueForces {
    /// On the video's clock, s.
    pub time: Vec<Second>,
    /// On the fixture's mass: water and the tail's own inertia together.
    pub pull: Vec<Newton>,
    /// Of `pull`, the water's thrust: the reaction of what the tail sheds.
    pub thrust: Vec<Newton>,
    /// Beside the mass: what follows pressure although nothing moves.
    pub lift: Vec<Newton>,
    /// Beside the mass: the tank's standing waves.
    pub wave: Vec<Newton>,
}

#[derive(Deserialize)]
struct Row {
    time_s: f64,
    pull_n: f64,
    thrust_n: f64,
    lift_n: f64,
    wave_n: f64,
}

/// The text of a file of forces: one line a time.
pub fn write_forces(forces: &TrueForces, remark: &str) -> String {
    let mut text = format!("# {remark}\ntime_s,pull_n,thrust_n,lift_n,wave_n\n");
    let rows = forces.time.iter().zip(&forces.pull).zip(&forces.thrust).zip(&forces.lift).zip(&forces.wave);
    for ((((time, pull), thrust), lift), wave) in rows {
        writeln!(text, "{time:.6},{pull:.6},{thrust:.6},{lift:.6},{wave:.6}").expect("a string takes any text");
    }
    text
}

const ACTION: &str = "record the specimen on the virtual bench again";

/// The forces in the file `path`.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read or a line is broken.
pub fn read_forces(path: &Path) -> Result<TrueForces, Diagnostic> {
    let text = input::read_text(path, input::MESH).map_err(|e| Diagnostic::io(path, e, ACTION))?;
    parse_forces(&text, path)
}

/// The forces in a text; `path` appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] when a line is broken.
pub(crate) fn parse_forces(text: &str, path: &Path) -> Result<TrueForces, Diagnostic> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let mut forces = TrueForces::default();
    for row in reader.deserialize::<Row>() {
        let row = row.map_err(|e| {
            let line = e.position().map(|p| p.line() as usize);
            Diagnostic::file(path, "the line holds no true forces", e.to_string().to_lowercase(), ACTION).at_line(line)
        })?;
        forces.time.push(row.time_s);
        forces.pull.push(row.pull_n);
        forces.thrust.push(row.thrust_n);
        forces.lift.push(row.lift_n);
        forces.wave.push(row.wave_n);
    }
    Ok(forces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_read_as_they_were_written() {
        let one = |x: f64| vec![x, -x];
        let forces =
            TrueForces { time: one(0.5), pull: one(0.25), thrust: one(0.125), lift: one(0.75), wave: one(-0.5) };
        let text = write_forces(&forces, "a remark");
        assert_eq!(parse_forces(&text, Path::new("forces.csv")), Ok(forces));
    }
}
