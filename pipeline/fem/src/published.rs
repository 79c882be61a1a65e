//! The face of the crate while its bodies are being written.
#![allow(missing_docs, unused_variables)]
use crate::{Clamps, Material, Mesh};
use si::{Pascal, Second};
use std::sync::Arc;

#[derive(Debug, Clone, Copy)]
pub struct RegionProperties {
    pub material: &'static dyn Material,
    pub youngs_modulus: Pascal,
    pub poissons_ratio: f64,
    pub density: f64,
}
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("set-up refused")]
pub struct SetupError;
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("no solution found")]
pub struct SolveError {
    pub last_converged: Option<Equilibrium>,
}
/// Immutable, Send + Sync; cloning is cheap (an Arc inside).
#[derive(Debug, Clone)]
pub struct System(Arc<Mesh>);
impl System {
    /// `clamped`: `&[u32]`, `&Vec<u32>` (all axes) or `Clamps`.
    pub fn new(mesh: Mesh, regions: Vec<RegionProperties>, clamped: impl Into<Clamps>) -> Result<Self, SetupError> {
        Ok(Self(Arc::new(mesh)))
    }
    pub fn solver(&self) -> Solver {
        unimplemented!()
    }
    pub fn mesh(&self) -> &Mesh {
        &self.0
    }
    pub fn freedoms(&self) -> usize {
        unimplemented!()
    }
    pub fn chamber_volume(&self, chamber: usize, displacement: &[f64]) -> f64 {
        unimplemented!()
    }
}
pub struct Solver;
#[derive(Debug, Clone, PartialEq)]
pub struct StaticSettings {
    pub tolerance: f64,
    pub load_steps: usize,
    pub iterations: usize,
    pub reuse_factor: bool,
}
impl Default for StaticSettings {
    fn default() -> Self {
        Self { tolerance: 1e-8, load_steps: 6, iterations: 40, reuse_factor: false }
    }
}
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    pub displacement: Vec<f64>,
    pub pressures: Vec<Pascal>,
    pub iterations: usize,
    pub factorisations: usize,
    pub residual: f64,
    pub stepped: bool,
}
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionGradient {
    pub youngs_modulus: f64,
    pub poissons_ratio: f64,
}
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    pub regions: Vec<RegionGradient>,
    pub pressures: Vec<f64>,
}
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    YoungsModulus(usize),
    PoissonsRatio(usize),
    Pressure(usize),
}
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    ImplicitEuler,
    Bdf2,
}
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct March {
    pub step: Second,
    pub scheme: Scheme,
    pub mass_damping: f64,
    pub stiffness_damping: f64,
}
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    pub displacement: Vec<f64>,
    pub velocity: Vec<f64>,
}
impl State {
    /// At rest: `nodes` nodes.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }
}
impl Solver {
    pub fn set_elastic(
        &mut self,
        region: usize,
        youngs_modulus: Pascal,
        poissons_ratio: f64,
    ) -> Result<(), SetupError> {
        unimplemented!()
    }
    /// Dead nodal forces, N, 3 a node; empty: none.
    pub fn set_forces(&mut self, forces: &[f64]) {
        unimplemented!()
    }
    pub fn equilibrium(
        &mut self,
        pressures: &[Pascal],
        start: Option<&[f64]>,
        settings: &StaticSettings,
    ) -> Result<Equilibrium, SolveError> {
        unimplemented!()
    }
    pub fn adjoint(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Vec<RegionGradient>, SolveError> {
        unimplemented!()
    }
    pub fn gradient(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Gradient, SolveError> {
        unimplemented!()
    }
    pub fn sensitivity(&mut self, at: &Equilibrium, parameter: Parameter) -> Result<Vec<f64>, SolveError> {
        unimplemented!()
    }
    pub fn march(
        &mut self,
        march: &March,
        initial: &State,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        steps: usize,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<State, SolveError> {
        unimplemented!()
    }
}
