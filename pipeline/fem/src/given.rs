//! What a solver was given beside its system: properties that may change, and all loads but the pressures.
//!
//! Stands on: `system`, `mass`, `loads`. Never knows: a displacement, how anything is solved.

use crate::body::assembly::Elastic;
use crate::body::mass::Mass;
use crate::descent::potential::{Inertia, Potential};
use crate::loads::DeadForces;
use crate::material::Lame;
use crate::parts::Parts;
use crate::region::RegionProperties;
use si::{Pascal, Point3};
use std::sync::Arc;

/// Properties and loads of one solver.
#[derive(Debug)]
pub(crate) struct Given {
    pub properties: Vec<RegionProperties>,
    pub elastic: Vec<Elastic>,
    pub mass: Arc<Mass>,
    /// 3 a node, N; empty: none.
    pub forces: Vec<f64>,
    /// m/s².
    pub gravity: Point3,
    /// Forces and weights together.
    pub dead: DeadForces,
    /// One a chamber: ambient pressure where it is sealed.
    pub ambient: Vec<Option<Pascal>>,
}

impl Given {
    /// The system's own properties, and no load.
    pub fn new(parts: &Parts) -> Self {
        let mean = |region: usize| parts.options.mean_dilatation.get(region).copied().unwrap_or(false);
        let elastic = parts.regions.iter().enumerate().map(|(region, is)| Elastic {
            material: is.material,
            lame: Lame::of(is.youngs_modulus, is.poissons_ratio),
            mean_dilatation: mean(region),
        });
        Self {
            properties: parts.regions.clone(),
            elastic: elastic.collect(),
            mass: Arc::clone(&parts.mass),
            forces: Vec::new(),
            gravity: [0.0; 3],
            dead: DeadForces::default(),
            ambient: vec![None; parts.chambers.len()],
        }
    }

    /// Sums forces and weights anew.
    pub fn gather_dead(&mut self) {
        let mut all = self.forces.clone();
        if self.gravity != [0.0; 3] {
            all.resize(3 * self.mass.weights.len(), 0.0);
            add_weights(&self.mass.weights, self.gravity, &mut all);
        }
        self.dead.forces = all;
    }

    /// The potential at rest under `pressures` and `dead_strength` of the dead forces.
    pub fn at_rest<'a>(&'a self, parts: &'a Parts, pressures: &'a [Pascal], dead_strength: f64) -> Potential<'a> {
        Potential {
            parts,
            elastic: &self.elastic,
            mass: &self.mass,
            stiffening: 1.0,
            pressures,
            ambient: &self.ambient,
            dead: &self.dead,
            dead_strength,
            inertia: None,
        }
    }

    /// The potential of one time step.
    pub fn in_motion<'a>(
        &'a self,
        parts: &'a Parts,
        pressures: &'a [Pascal],
        stiffening: f64,
        inertia: &'a Inertia,
    ) -> Potential<'a> {
        Potential { stiffening, inertia: Some(inertia), ..self.at_rest(parts, pressures, 1.0) }
    }
}

/// Adds m g of every node to `forces`, 3 a node.
pub(crate) fn add_weights(weights: &[f64], gravity: Point3, forces: &mut [f64]) {
    for (force, mass) in forces.chunks_exact_mut(3).zip(weights) {
        (0..3).for_each(|axis| force[axis] += mass * gravity[axis]);
    }
}
