//! Why surfaces did not become tetrahedra.

use si::{Metre, Point3};

/// Why surfaces did not become tetrahedra, with the place.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// No faces.
    #[error(
        "part {part} has no faces\n  why: a solid needs at least 4\n  do:  export the part again, as a solid and not as a sketch"
    )]
    Empty {
        /// Which part, from 0.
        part: usize,
    },
    /// A face with a corner that does not exist, or a coordinate that is no number.
    #[error(
        "face {face} of part {part} has no place\n  why: a corner of it does not exist, or has a coordinate that is not finite\n  do:  check the surface's file there"
    )]
    NoPlace {
        /// Which part, from 0.
        part: usize,
        /// Which face, from 0.
        face: usize,
    },
    /// A setting that is none.
    #[error(
        "the mesher has the setting {name} = {value}\n  why: it must be a finite number above 0\n  do:  correct it; lengths are in metres"
    )]
    Setting {
        /// Its name in [`crate::Settings`].
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Walls in more elements than there is memory for.
    #[error(
        "walls with so many elements through them would take about {elements:.0e} elements\n  why: the limit is {limit:.0e}\n  do:  ask for fewer elements through a wall, or for longer smallest edges"
    )]
    ThinWalls {
        /// Estimated elements.
        elements: f64,
        /// The limit.
        limit: f64,
    },
    /// More elements than there is memory for.
    #[error(
        "surfaces of {length:.3e} m with edges of {edge:.3e} m would take about {elements:.0e} elements\n  why: the limit is {limit:.0e}\n  do:  check that lengths are in metres, not in millimetres, or take a longer edge"
    )]
    TooLarge {
        /// Longest side of the surfaces, m.
        length: Metre,
        /// Target length of edges, m.
        edge: Metre,
        /// Estimated number.
        elements: f64,
        /// The most.
        limit: f64,
    },
    /// Surfaces that enclose nothing.
    #[error("the surfaces enclose no solid near ({:.2}, {:.2}, {:.2}) mm\n  why: no tetrahedron has a winding number above one half, which a surface with holes wider than its parts has nowhere\n  do:  close the holes in the CAD program, or check which way its faces look", .at[0] * 1e3, .at[1] * 1e3, .at[2] * 1e3)]
    Nothing {
        /// Middle of the surfaces, m.
        at: Point3,
    },
}
