//! Inputs of a solver: material constants and all loads but the pressures. They may change from solve to solve.

use crate::assembly::elastic::Elastic;
use crate::assembly::mass::Mass;
use crate::loads::{DeadForces, add_gravity};
use crate::material::Lame;
use crate::newton::potential::Potential;
use crate::properties::RegionProperties;
use crate::system_data::SystemData;
use si::{Pascal, Point3};
use std::sync::Arc;

/// Materials and loads of one solver.
#[derive(Debug)]
pub(crate) struct Inputs {
    pub properties: Vec<RegionProperties>,
    pub elastic: Vec<Elastic>,
    pub mass: Arc<Mass>,
    /// 3 entries per node, N; empty: none.
    pub forces: Vec<f64>,
    /// m/s².
    pub gravity: Point3,
    /// Forces and weight together.
    pub dead: DeadForces,
    /// One per chamber: ambient pressure where it is sealed.
    pub ambient: Vec<Option<Pascal>>,
}

/// Pressures and the load factor of all dead forces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AppliedLoad<'a> {
    /// One per chamber, Pa.
    pub pressures: &'a [Pascal],
    /// Factor of the dead forces in load stepping, 0 to 1.
    pub load_factor: f64,
}

impl Inputs {
    /// The system's own properties, without loads.
    pub fn new(data: &SystemData) -> Self {
        let mean = |region: usize| data.options.mean_dilatation.get(region).copied().unwrap_or(false);
        let elastic = data.regions.iter().enumerate().map(|(region, is)| Elastic {
            material: is.material,
            lame: Lame::of(is.youngs_modulus, is.poissons_ratio),
            mean_dilatation: mean(region),
        });
        Self {
            properties: data.regions.clone(),
            elastic: elastic.collect(),
            mass: Arc::clone(&data.mass),
            forces: Vec::new(),
            gravity: [0.0; 3],
            dead: DeadForces::default(),
            ambient: vec![None; data.chambers.len()],
        }
    }

    /// Sums forces and weight.
    pub(crate) fn update_dead_forces(&mut self) {
        let mut all = self.forces.clone();
        if self.gravity != [0.0; 3] {
            all.resize(3 * self.mass.nodal.len(), 0.0);
            add_gravity(&self.mass.nodal, self.gravity, &mut all);
        }
        self.dead.forces = all;
    }

    /// The static potential under `load`.
    pub(crate) fn static_potential<'a>(&'a self, data: &'a SystemData, load: AppliedLoad<'a>) -> Potential<'a> {
        Potential {
            data,
            elastic: &self.elastic,
            mass: &self.mass,
            elastic_scale: 1.0,
            pressures: load.pressures,
            ambient: &self.ambient,
            dead: &self.dead,
            load_factor: load.load_factor,
            inertia: None,
        }
    }

    /// The static potential under `pressures` and the whole dead load.
    pub fn at_rest<'a>(&'a self, data: &'a SystemData, pressures: &'a [Pascal]) -> Potential<'a> {
        self.static_potential(data, AppliedLoad { pressures, load_factor: 1.0 })
    }
}
