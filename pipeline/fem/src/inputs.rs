//! Inputs of a solver: material constants and all loads but the pressures. They may change from solve to solve.

use crate::assembly::elastic::{Body, Elastic};
use crate::assembly::mass::Mass;
use crate::loads::{DeadForces, add_gravity};
use crate::newton::potential::{Inertia, Potential};
use crate::properties::RegionProperties;
use crate::system_data::SystemData;
use crate::viscoelastic::history::History;
use crate::viscoelastic::step::ActingStress;
use materials::step::RegionStep;
use si::{Metre, Pascal, Point3};
use std::sync::Arc;

/// Materials and loads of one solver.
#[derive(Debug)]
pub(crate) struct Inputs {
    pub properties: Vec<RegionProperties>,
    pub elastic: Vec<Elastic>,
    /// Factor of the moduli of each element; empty: 1.
    pub factors: Vec<f64>,
    /// The laws as they act in the present step: the same, or with damping and relaxation.
    pub acting: Option<ActingStress>,
    pub mass: Arc<Mass>,
    /// 3 entries per node, N; empty: none.
    pub forces: Vec<f64>,
    /// Displacements of constrained dofs, 3 entries per node, m; empty: none.
    pub prescribed: Vec<Metre>,
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
    /// A force that a homotopy adds.
    pub added: Option<&'a Inertia>,
}

impl<'a> AppliedLoad<'a> {
    /// `pressures` and the whole dead load.
    pub fn whole(pressures: &'a [Pascal]) -> Self {
        Self { pressures, load_factor: 1.0, added: None }
    }
}

impl Inputs {
    /// The system's own properties, without loads.
    pub fn new(data: &SystemData) -> Self {
        let mean = |region: usize| data.options.mean_dilatation.get(region).copied().unwrap_or(false);
        let elastic = data.regions.iter().enumerate().map(|(region, is)| Elastic {
            material: is.material,
            moduli: is.moduli(),
            mean_dilatation: mean(region),
        });
        Self {
            properties: data.regions.clone(),
            elastic: elastic.collect(),
            factors: Vec::new(),
            acting: None,
            mass: Arc::clone(&data.mass),
            forces: Vec::new(),
            prescribed: Vec::new(),
            gravity: [0.0; 3],
            dead: DeadForces::default(),
            ambient: vec![None; data.chambers.len()],
        }
    }

    /// Sets the mass to that of the current densities.
    pub(crate) fn update_mass(&mut self, data: &SystemData) {
        let [densities, system_densities] = [&self.properties, &data.regions]
            .map(|regions| regions.iter().map(|region| region.density).collect::<Vec<f64>>());
        self.mass = match densities == system_densities {
            true => Arc::clone(&data.mass),
            false => Arc::new(Mass::new(&data.mass_assembly(), &densities, &data.options.masses)),
        };
        self.update_dead_forces();
    }

    /// Sums forces and weight.
    pub(crate) fn update_dead_forces(&mut self) {
        let mut dead_forces = self.forces.clone();
        if self.gravity != [0.0; 3] {
            dead_forces.resize(3 * self.mass.nodal.len(), 0.0);
            add_gravity(&self.mass.nodal, self.gravity, &mut dead_forces);
        }
        self.dead.forces = dead_forces;
    }

    /// The domain of assembly with the laws, constants and factors of this solver.
    pub(crate) fn body<'a>(&'a self, data: &'a SystemData) -> Body<'a> {
        Body { factors: &self.factors, ..data.body(&self.elastic) }
    }

    /// Prepares a step in which the law's own stress is multiplied by `scale`, after the `past` of relaxing regions.
    pub(crate) fn begin_step(&mut self, data: &SystemData, scale: f64, past: Option<(&[RegionStep], &History)>) {
        let elastic = scale == 1.0 && past.is_none();
        self.acting = (!elastic).then(|| ActingStress::new(data, &self.elastic, scale, past));
    }

    /// Ends the step: the laws act by themselves again.
    pub(crate) fn end_step(&mut self) {
        self.acting = None;
    }

    /// The static potential under `load`.
    pub(crate) fn static_potential<'a>(&'a self, data: &'a SystemData, load: AppliedLoad<'a>) -> Potential<'a> {
        let (elastic, held) = match &self.acting {
            Some(acting) => (&acting.elastic, &acting.held[..]),
            None => (&self.elastic, &[][..]),
        };
        Potential {
            data,
            elastic,
            factors: &self.factors,
            held,
            mass: &self.mass,
            pressures: load.pressures,
            ambient: &self.ambient,
            dead: &self.dead,
            load_factor: load.load_factor,
            inertia: load.added,
        }
    }

    /// The static potential under `pressures` and the whole dead load.
    pub fn at_rest<'a>(&'a self, data: &'a SystemData, pressures: &'a [Pascal]) -> Potential<'a> {
        self.static_potential(data, AppliedLoad::whole(pressures))
    }
}
