//! How a case is solved, and what is written of it.
//!
//! Stands on: serde. Never knows: a solver, a file.

use serde::Deserialize;
use si::{Hertz, Metre, Point3, Second};

/// `[static]`: equilibria at rising loads.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Static {
    /// Parts of all loads but gravity, in the order in which they are solved.
    #[serde(default = "full")]
    pub levels: Vec<f64>,
    /// Steps in which a level is reached from rest.
    #[serde(default = "three")]
    pub load_steps: usize,
    /// The last correction moves no node further than this part of the body's size.
    #[serde(default = "fine")]
    pub tolerance: f64,
}

/// `[dynamic]`: a motion.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dynamic {
    /// s.
    pub duration: Second,
    /// s; steps of one length.
    pub step: Option<Second>,
    /// Steps of the march's own choice.
    pub adaptive: Option<Steps>,
    /// How a step is taken from the past.
    #[serde(default)]
    pub scheme: Scheme,
    /// α of Rayleigh's damping, 1/s.
    #[serde(default)]
    pub mass_damping: Hertz,
    /// β of Rayleigh's damping, s.
    #[serde(default)]
    pub stiffness_damping: Second,
    /// Mass on the diagonal alone.
    #[serde(default)]
    pub lumped_mass: bool,
    /// Where it begins.
    #[serde(default)]
    pub start: Start,
}

/// Bounds of steps that the march chooses.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Error that one step may make, m.
    pub tolerance: Metre,
    /// s.
    pub shortest: Second,
    /// s.
    pub longest: Second,
}

/// How a step is taken from the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// First order.
    ImplicitEuler,
    /// Second order.
    #[default]
    Bdf2,
}

/// Where a motion begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// In the mesh's shape; all loads set in at once.
    #[default]
    Rest,
    /// In the equilibrium under the loads of time 0.
    Equilibrium,
}

/// `[output]`: what is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// A row of the table each so many steps.
    pub every: usize,
    /// A frame each so many steps or levels; 0: none. Not said: each level, each tenth step.
    pub vtu_every: Option<usize>,
    /// Nodes whose path is written.
    pub node: Vec<Node>,
    /// Material points of the outer skin whose path is written.
    pub marker: Vec<Marker>,
}

impl Default for Output {
    fn default() -> Self {
        Self { every: 1, vtu_every: None, node: Vec::new(), marker: Vec::new() }
    }
}

/// The node nearest to a point.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Node {
    /// What heads its columns.
    pub name: String,
    /// m.
    pub near: Point3,
}

/// The point of the skin nearest to a point.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// What heads its columns.
    pub name: String,
    /// m.
    pub at: Point3,
}

fn full() -> Vec<f64> {
    vec![1.0]
}

fn three() -> usize {
    3
}

fn fine() -> f64 {
    1e-8
}
