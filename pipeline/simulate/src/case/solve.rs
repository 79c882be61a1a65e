//! Settings of the solution and of the output of a case.

use serde::Deserialize;
use si::{Hertz, Metre, Point3, Second};

use crate::budget::Budget;

/// `[static]`: equilibria at rising loads.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Static {
    /// Fractions of all loads except gravity, in the order in which they are solved.
    #[serde(default = "full")]
    pub levels: Vec<f64>,
    /// Load steps from rest to a level.
    #[serde(default = "three")]
    pub load_steps: usize,
    /// Tolerance: the last Newton step moves no node by more than this fraction of the body's size.
    #[serde(default = "fine")]
    pub tolerance: f64,
    /// The path from rest to the last level is followed through limit points and bifurcations; without it each level is
    /// solved for by itself.
    pub arc_length: Option<ArcLength>,
    /// Newton iterations of a level at most.
    pub max_iterations: Option<usize>,
    /// Halvings of a load step at most.
    pub max_cutbacks: Option<usize>,
    /// Seconds of all levels at most.
    pub timeout: Option<Second>,
}

impl Static {
    /// The limits that it sets.
    pub fn budget(&self) -> Budget {
        Budget { max_iterations: self.max_iterations, max_cutbacks: self.max_cutbacks, timeout: self.timeout }
    }
}

/// Path following by the arc-length method.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArcLength {
    /// Which branch is followed from a bifurcation.
    pub branch: BranchRule,
    /// Longest step: root mean square displacement over the body's size.
    pub max_step: f64,
    /// Steps at most.
    pub max_steps: usize,
}

impl Default for ArcLength {
    fn default() -> Self {
        let path_settings = continuation::PathSettings::default();
        Self { branch: BranchRule::AlongMode, max_step: path_settings.max_step, max_steps: path_settings.max_steps }
    }
}

/// Which branch is followed from a bifurcation at which stability is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BranchRule {
    /// The unstable one on which it was found.
    Primary,
    /// The secondary one on the side to which the mode's largest displacement is positive.
    AlongMode,
    /// The secondary one on the other side.
    AgainstMode,
}

impl From<BranchRule> for continuation::Branch {
    fn from(branch: BranchRule) -> Self {
        match branch {
            BranchRule::Primary => Self::Primary,
            BranchRule::AlongMode => Self::AlongMode,
            BranchRule::AgainstMode => Self::AgainstMode,
        }
    }
}

/// `[dynamic]`: a motion.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dynamic {
    /// s.
    pub duration: Second,
    /// s; steps of one length.
    pub step: Option<Second>,
    /// Adaptive steps.
    pub adaptive: Option<Steps>,
    /// The integration scheme.
    #[serde(default)]
    pub scheme: Scheme,
    /// α of Rayleigh's damping, 1/s.
    #[serde(default)]
    pub mass_damping: Hertz,
    /// β of Rayleigh's damping, s.
    #[serde(default)]
    pub stiffness_damping: Second,
    /// Lumped mass matrix.
    #[serde(default)]
    pub lumped_mass: bool,
    /// The initial state.
    #[serde(default)]
    pub start: Start,
    /// Newton iterations of a time step at most.
    pub max_iterations: Option<usize>,
    /// Seconds of the whole motion at most.
    pub timeout: Option<Second>,
}

impl Dynamic {
    /// The limits that it sets.
    pub fn budget(&self) -> Budget {
        Budget { max_iterations: self.max_iterations, max_cutbacks: None, timeout: self.timeout }
    }
}

/// Bounds of adaptive steps.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Tolerance of the local error, m.
    pub tolerance: Metre,
    /// s.
    pub shortest: Second,
    /// s.
    pub longest: Second,
}

/// The integration scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// First order.
    ImplicitEuler,
    /// Second order.
    #[default]
    Bdf2,
    /// Equilibria, one after the other, of a body that relaxes.
    QuasiStatic,
}

impl From<Scheme> for fem::Scheme {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::ImplicitEuler => Self::ImplicitEuler,
            Scheme::Bdf2 => Self::Bdf2,
            Scheme::QuasiStatic => Self::QuasiStatic,
        }
    }
}

/// The initial state of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The undeformed shape; all loads are applied at once.
    #[default]
    Rest,
    /// The equilibrium under the loads at time 0.
    Equilibrium,
}

/// `[output]`: what is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Steps between rows of the table.
    pub every: usize,
    /// Steps or levels between frames; 0: none. Default: each level, each tenth step.
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
    /// The prefix of its columns.
    pub name: String,
    /// m.
    pub near: Point3,
}

/// The point of the skin nearest to a point.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// The prefix of its columns.
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
