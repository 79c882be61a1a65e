//! Systems: a checked mesh with everything that no parameter changes.
//!
//! Rest shapes, mass, loads, sparsity, elimination order and the structure of the factor are worked out once and
//! shared by all solvers on all threads.
//!
//! Stands on: `checks`, `parts`, `solver`. Never knows: a displacement, a pressure.

use crate::algebra::factor::Symbolic;
use crate::algebra::graph::Graph;
use crate::algebra::sparse::Pattern;
use crate::body::mass::{Mass, Overlaps};
use crate::body::rest::Rest;
use crate::checks;
use crate::clamps::Clamps;
use crate::loads::ChamberPressure;
use crate::mesh::Mesh;
use crate::options::Options;
use crate::parts::Parts;
use crate::refusal::SetupError;
use crate::region::RegionProperties;
use crate::solver::Solver;
use si::CubicMetre;
use std::sync::Arc;

/// A body ready to be solved. Immutable and shared: a clone costs nothing.
#[derive(Clone)]
pub struct System {
    pub(crate) parts: Arc<Parts>,
}

impl std::fmt::Debug for System {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (nodes, elements) = (self.parts.mesh.nodes.len(), self.parts.mesh.elements.len());
        write!(out, "System of {nodes} nodes, {elements} elements, {} freedoms", self.freedoms())
    }
}

impl System {
    /// Checks `mesh` and prepares it.
    ///
    /// `regions`: properties by region number. `clamped`: node numbers (`&[u32]`, held along all axes) or [`Clamps`];
    /// nodes on the plane of a half model are held in z beside them.
    ///
    /// # Errors
    /// [`SetupError`], which names the element, face, node or region that is refused.
    pub fn new(mesh: Mesh, regions: Vec<RegionProperties>, clamped: impl Into<Clamps>) -> Result<Self, SetupError> {
        Self::with(mesh, regions, clamped, Options::default())
    }

    /// The same with `options`.
    ///
    /// # Errors
    /// As [`System::new`]; also when a mass is attached to no node, or is not a positive number.
    pub fn with(
        mesh: Mesh,
        regions: Vec<RegionProperties>,
        clamped: impl Into<Clamps>,
        options: Options,
    ) -> Result<Self, SetupError> {
        let clamps: Clamps = clamped.into();
        checks::nodes(&mesh, &clamps)?;
        checks::regions(&mesh, &regions)?;
        checks::masses(&mesh, &options.masses)?;
        let clamps = clamps.with_symmetry(&mesh);
        let graph = Graph::new(mesh.nodes.len(), &mesh.elements);
        let rest = Rest::new(&mesh);
        checks::elements(&mesh, &rest, &graph)?;
        checks::held(&mesh, &graph, &clamps)?;
        let chambers = chambers(&mesh, &graph)?;
        let pattern = Pattern::new(&mesh.nodes, &graph, &clamps);
        let places = places(&mesh, &pattern);
        if pattern.freedoms() == 0 {
            return Err(SetupError::AllHeld { nodes: mesh.nodes.len() });
        }
        let densities: Vec<f64> = regions.iter().map(|region| region.density).collect();
        let overlaps = Overlaps::new(&mesh, options.lumped_mass);
        let mass = Arc::new(Mass::new(&mesh, &pattern, &places, &overlaps, &densities, &options.masses));
        let symbolic = Symbolic::new(&pattern)
            .map_err(|fault| SetupError::TooLarge { freedoms: pattern.freedoms(), why: fault.to_string() })?;
        let size = mesh.size();
        let volumes = volumes(&mesh, &rest, regions.len());
        let parts =
            Parts { mesh, regions, rest, volumes, pattern, places, symbolic, options, overlaps, mass, chambers, size };
        Ok(Self { parts: Arc::new(parts) })
    }

    /// Mass of the body at rest and of what is attached, kg; of a half model, of the half.
    pub fn mass(&self) -> si::Kilogram {
        self.parts.mass.weights.iter().sum()
    }

    /// Mass that each node stands for, kg: Σ of them times node places is the mass times the centre of mass. `nodes` long;
    /// the corners of quadratic elements may stand for less than nothing.
    pub fn node_masses(&self) -> &[si::Kilogram] {
        &self.parts.mass.weights
    }

    /// A solver of its own numbers on this system; make one for each thread.
    pub fn solver(&self) -> Solver {
        Solver::new(Arc::clone(&self.parts))
    }

    /// The mesh at rest.
    pub fn mesh(&self) -> &Mesh {
        &self.parts.mesh
    }

    /// What the regions were made of when the system was made.
    pub fn regions(&self) -> &[RegionProperties] {
        &self.parts.regions
    }

    /// Degrees of freedom: 3 a node less the held ones.
    pub fn freedoms(&self) -> usize {
        self.parts.pattern.freedoms()
    }

    /// Entries of the stiffness matrix's lower triangle, and of its factor.
    pub fn entries(&self) -> (usize, usize) {
        (self.parts.pattern.entries(), self.parts.symbolic.entries())
    }

    /// Volume of the solid at rest, m³; of a half model, of the half.
    pub fn volume(&self) -> CubicMetre {
        self.parts.rest.volumes.iter().sum()
    }

    /// Volume of the cavity of `chamber` at `displacement` (3 a node, m), m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber, or the displacement is not 3 a node.
    pub fn chamber_volume(&self, chamber: usize, displacement: &[f64]) -> CubicMetre {
        assert_eq!(displacement.len(), 3 * self.parts.mesh.nodes.len(), "a displacement has 3 numbers a node");
        self.parts.chambers[chamber].volume(displacement)
    }
}

/// By region, m³.
fn volumes(mesh: &Mesh, rest: &Rest, regions: usize) -> Vec<f64> {
    let mut volumes = vec![0.0; regions];
    for (&region, volume) in mesh.regions.iter().zip(&rest.volumes) {
        volumes[region as usize] += volume;
    }
    volumes
}

fn chambers(mesh: &Mesh, graph: &Graph) -> Result<Vec<ChamberPressure>, SetupError> {
    let mut found = Vec::new();
    for (index, chamber) in mesh.chambers.iter().enumerate() {
        checks::closed(mesh, index, chamber)?;
        checks::on_elements(graph, index, chamber)?;
        let pressure = ChamberPressure::new(mesh, chamber);
        let volume = pressure.at_rest;
        if volume.is_nan() || volume <= 0.0 {
            return Err(SetupError::ChamberInsideOut { chamber: index, volume });
        }
        found.push(pressure);
    }
    Ok(found)
}

/// elements × pairs (a ≥ b): places of the blocks.
pub(crate) fn places(mesh: &Mesh, pattern: &Pattern) -> Vec<u32> {
    let mut places = Vec::new();
    for element in 0..mesh.elements.len() {
        let nodes = mesh.elements.nodes(element);
        for a in 0..nodes.len() {
            for b in 0..=a {
                places.push(pattern.place(nodes[a], nodes[b]).expect("nodes of one element are neighbours"));
            }
        }
    }
    places
}
