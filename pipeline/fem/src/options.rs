//! Options of a system: choices that change its equations but not its mesh.
//!
//! Stands on: `attached`. Never knows: a mesh, a solve.

use crate::attached::Masses;

/// What a system may be told beside its mesh, its properties and its clamps; the default is none of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Mass on the diagonal alone, instead of the consistent one.
    pub lumped_mass: bool,
    /// By region: whether the part of the energy that λ weighs sees each element's mean deformation instead of each
    /// point's. The remedy against volumetric locking of 10-node elements close to ν = 0.5 [hughes1980]; it changes
    /// nothing for 4-node ones, which have a single point. Regions beyond the list do without.
    pub mean_dilatation: Vec<bool>,
    /// What hangs on nodes.
    pub masses: Masses,
}
