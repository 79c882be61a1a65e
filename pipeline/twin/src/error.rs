//! Why a reduced tail cannot be made, read or stepped.

/// An error of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TwinError {
    /// Arrays that do not belong together.
    #[error(
        "these are not the arrays of a reduced tail: {what}\n  why: all arrays have the coordinates of the mass matrix, and masses, moduli, weights and times are those of a body\n  do:  export the tail again"
    )]
    Data {
        /// What is wrong.
        what: String,
    },
    /// A file that cannot be read or written.
    #[error(
        "{file}: {what}\n  why: a reduced tail is read from the safetensors file of `study export twin`\n  do:  export the tail again"
    )]
    File {
        /// The file.
        file: String,
        /// What is wrong.
        what: String,
    },
    /// A step with a wrong input.
    #[error(
        "{what}\n  why: a step takes one finite pressure (Pa) per chamber and a positive duration (s)\n  do:  correct what is given to the step"
    )]
    Input {
        /// What is wrong.
        what: String,
    },
    /// A pressure that the tail was not reduced under.
    #[error(
        "{pressure:.0} Pa in chamber `{chamber}`{}\n  why: it was reduced under {low:.0} to {high:.0} Pa, and the shapes beyond were never seen\n  do:  keep the pressure within that range, or reduce the tail under higher pressures and export it again",
        ratio_of_largest(*pressure, *range), low = range[0], high = range[1]
    )]
    Pressure {
        /// The chamber.
        chamber: String,
        /// Pa.
        pressure: f64,
        /// Lowest and highest that it was reduced under, Pa.
        range: [f64; 2],
    },
    /// An output that there is not.
    #[error("there is no output `{name}`\n  why: this tail has {names}\n  do:  name one of these")]
    Output {
        /// What was asked for.
        name: String,
        /// What there is.
        names: String,
    },
    /// A saved state that cannot be read.
    #[error(
        "this is no saved state of this twin: {what}\n  why: a state is read by the twin that saved it, or one with the same coordinates, chambers, points and branches\n  do:  save the state again, or take one from `start`"
    )]
    Saved {
        /// What is wrong.
        what: String,
    },
    /// A state of another twin.
    #[error(
        "the state has {} coordinates, {} chambers and {} regions; this twin has {}, {} and {}\n  why: a state is stepped by the twin that started it, or one with the same coordinates, chambers, points and branches\n  do:  take a state from `start`, or a recording from `recording`, of this twin",
        counts[0], counts[1], counts[2], required[0], required[1], required[2]
    )]
    State {
        /// Coordinates, chambers and regions of the state.
        counts: [usize; 3],
        /// Those of the twin.
        required: [usize; 3],
    },
    /// A step without a solution.
    #[error(
        "no step is found after {time:.4} s\n  why: {iterations} iterations leave a change of {change:.1e} of the largest shape, even in parts of the step\n  do:  take shorter steps, or pressures within those that the tail was reduced from"
    )]
    NoConvergence {
        /// Time of the last state, s.
        time: f64,
        /// Iterations of the last attempt.
        iterations: usize,
        /// Size of the last one, no unit.
        change: f64,
    },
    /// A step whose tangent has no inverse.
    #[error(
        "the motion has no derivative at {time:.4} s\n  why: the tangent of the step that ends there is singular\n  do:  take shorter steps, or pressures within those that the tail was reduced from"
    )]
    Adjoint {
        /// Time at the end of the step, s.
        time: f64,
    },
}

/// A pressure over the largest of its range (Pa), in words; nothing where the range is that of a vented chamber.
fn ratio_of_largest(pressure: f64, [low, high]: [f64; 2]) -> String {
    let largest = low.abs().max(high.abs());
    if largest > 0.0 {
        format!(", {:.1} times the largest that the tail was reduced under", pressure.abs() / largest)
    } else {
        String::new()
    }
}
