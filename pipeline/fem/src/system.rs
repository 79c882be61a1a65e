//! Systems: a validated mesh with everything that no parameter changes.
//!
//! Reference geometry, mass, chambers, sparsity, elimination order and symbolic factorisation are computed once and
//! shared by all solvers on all threads.

use crate::adjoint::shape::moved_nodes;
use crate::assembly::mass::{Mass, MassAssembly, ShapeProducts};
use crate::assembly::reference::{ReferenceElements, SHEAR_SHARE};
use crate::contact::SelfContact;
use crate::loads::ChamberPressure;
use crate::mesh::Mesh;
use crate::mesh::clamps::Clamps;
use crate::properties::{Options, RegionProperties};
use crate::setup_error::SetupError;
use crate::solver::Solver;
use crate::system_data::{SystemData, block_positions};
use crate::validation;
use si::CubicMetre;
use sparse::{NodeGraph, Pattern, Symbolic};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A body ready to be solved. Immutable and shared: a clone copies a pointer.
#[derive(Clone)]
pub struct System {
    pub(crate) data: Arc<SystemData>,
}

impl std::fmt::Debug for System {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (nodes, elements) = (self.data.mesh.nodes.len(), self.data.mesh.elements.len());
        write!(out, "System of {nodes} nodes, {elements} elements, {} dofs", self.dofs())
    }
}

/// What was validated, before anything is factorised.
struct CheckedBody {
    mesh: Mesh,
    regions: Vec<RegionProperties>,
    clamps: Clamps,
    graph: NodeGraph,
    reference: ReferenceElements,
    chambers: Vec<ChamberPressure>,
}

impl CheckedBody {
    fn new(mesh: Mesh, regions: Vec<RegionProperties>, clamps: Clamps, options: &Options) -> Result<Self, SetupError> {
        validation::check_nodes(&mesh, &clamps)?;
        validation::check_regions(&mesh, &regions)?;
        validation::check_masses(&mesh, &options.masses)?;
        options.contact.map_or(Ok(()), |contact| validation::check_contact(&mesh, contact))?;
        let clamps = clamps.with_symmetry(&mesh);
        let graph = mesh.graph();
        let shear_share = options.shear_share.unwrap_or(SHEAR_SHARE);
        validation::shear_share(shear_share)?;
        let reference = ReferenceElements::new(&mesh, shear_share);
        validation::check_elements(&mesh, &reference, &graph)?;
        validation::check_constraints(&mesh, &graph, &clamps)?;
        let chambers = chamber_pressures(&mesh, &graph)?;
        Ok(Self { mesh, regions, clamps, graph, reference, chambers })
    }

    /// The system, with sparsity, masses and symbolic factorisation.
    fn prepare(self, options: Options) -> Result<System, SetupError> {
        let Self { mesh, regions, clamps, graph, reference, chambers } = self;
        let constrained = clamps.by_node(mesh.nodes.len());
        let pattern = Pattern::new(&mesh.nodes, &graph, &constrained);
        let contact = options.contact.map(|contact| Arc::new(SelfContact::new(&mesh, contact)));
        let block_positions = block_positions(&mesh, &pattern);
        if pattern.dofs() == 0 {
            return Err(SetupError::FullyConstrained { nodes: mesh.nodes.len() });
        }
        let densities: Vec<f64> = regions.iter().map(|region| region.density).collect();
        let products = ShapeProducts::new(&mesh, options.lumped_mass);
        let assembly =
            MassAssembly { mesh: &mesh, pattern: &pattern, block_positions: &block_positions, products: &products };
        let mass = Arc::new(Mass::new(&assembly, &densities, &options.masses));
        let symbolic = Symbolic::new(&pattern).map_err(|cause| SetupError::TooLarge { dofs: pattern.dofs(), cause })?;
        let data = SystemData {
            size: mesh.size(),
            volumes: region_volumes(&mesh, &reference, regions.len()),
            mesh,
            regions,
            reference,
            pattern,
            block_positions,
            symbolic: Arc::new(symbolic),
            options,
            products,
            mass,
            chambers,
            contact,
            constrained,
            couplings: BTreeSet::new(),
        };
        Ok(System { data: Arc::new(data) })
    }
}

impl System {
    /// Validates and prepares `mesh`.
    ///
    /// `regions`: properties by region number. `clamped`: node numbers (`&[u32]`, constrained along all axes) or
    /// [`Clamps`]; the nodes of a half model's symmetry plane are constrained in z as well.
    ///
    /// # Errors
    /// [`SetupError`], which names the invalid element, face, node or region.
    pub fn new(mesh: Mesh, regions: Vec<RegionProperties>, clamped: impl Into<Clamps>) -> Result<Self, SetupError> {
        Self::with(mesh, regions, clamped, Options::default())
    }

    /// As [`System::new`], with `options`.
    ///
    /// # Errors
    /// As [`System::new`]; also when a mass is attached to no node, or is not a positive number.
    pub fn with(
        mesh: Mesh,
        regions: Vec<RegionProperties>,
        clamped: impl Into<Clamps>,
        options: Options,
    ) -> Result<Self, SetupError> {
        CheckedBody::new(mesh, regions, clamped.into(), &options)?.prepare(options)
    }

    /// The same body whose walls pass through each other: what a reduced model of motions, which have no contact, is reduced from.
    #[must_use]
    pub fn without_contact(&self) -> Self {
        Self { data: Arc::new(SystemData { contact: None, ..SystemData::clone(&self.data) }) }
    }

    /// The same body with its nodes moved by `part` times `velocity` (3 entries per node) before any load: sparsity, elimination order and symbolic
    /// factorisation are kept.
    ///
    /// # Errors
    /// [`SetupError`] when an element or a chamber is inverted.
    ///
    /// # Panics
    /// When the velocity does not have 3 entries per node.
    pub fn morphed(&self, velocity: &[f64], part: f64) -> Result<Self, SetupError> {
        assert_eq!(velocity.len(), self.data.full_length(), "a velocity has 3 entries per node");
        let mut data = SystemData::clone(&self.data);
        data.mesh.nodes = moved_nodes(&self.data.mesh.nodes, velocity, part);
        let mesh = &data.mesh;
        let shear_share = data.options.shear_share.unwrap_or(SHEAR_SHARE);
        data.reference = ReferenceElements::new(mesh, shear_share);
        let graph = mesh.graph();
        validation::check_elements(mesh, &data.reference, &graph)?;
        data.chambers = chamber_pressures(mesh, &graph)?;
        data.volumes = region_volumes(mesh, &data.reference, data.regions.len());
        data.products = ShapeProducts::new(mesh, data.options.lumped_mass);
        data.contact = data.options.contact.map(|contact| Arc::new(SelfContact::new(mesh, contact)));
        data.size = mesh.size();
        let densities: Vec<f64> = data.regions.iter().map(|region| region.density).collect();
        data.mass = Arc::new(Mass::new(&data.mass_assembly(), &densities, &data.options.masses));
        Ok(Self { data: Arc::new(data) })
    }

    /// Whether walls repel each other at `displacement` (3 per node, m); never in a body without contact.
    ///
    /// # Panics
    /// When the displacement does not have 3 entries per node.
    pub fn walls_touch(&self, displacement: &[f64]) -> bool {
        assert_eq!(displacement.len(), 3 * self.data.mesh.nodes.len(), "a displacement has 3 entries per node");
        self.data.contact.as_ref().is_some_and(|contact| contact.touch(displacement))
    }

    /// Mass of the body and of the attached masses, kg; of a half model, of the half.
    pub fn mass(&self) -> si::Kilogram {
        self.data.mass.nodal.iter().sum()
    }

    /// Mass of each node, kg: row sums of the mass matrix. Their sum with node positions is the mass times the centre
    /// of mass; the corners of quadratic elements may have negative ones.
    pub fn node_masses(&self) -> &[si::Kilogram] {
        &self.data.mass.nodal
    }

    /// A new solver on this system; each thread takes its own.
    pub fn solver(&self) -> Solver {
        Solver::new(Arc::clone(&self.data))
    }

    /// The mesh at rest.
    pub fn mesh(&self) -> &Mesh {
        &self.data.mesh
    }

    /// The properties of the regions that the system was made with.
    pub fn regions(&self) -> &[RegionProperties] {
        &self.data.regions
    }

    /// Number of degrees of freedom: 3 per node less the constrained ones.
    pub fn dofs(&self) -> usize {
        self.data.pattern.dofs()
    }

    /// Whether each component of the displacement is a degree of freedom, 3 entries per node.
    pub fn free_components(&self) -> Vec<bool> {
        let moved = self.data.pattern.scattered(&vec![1.0; self.dofs()], 1.0, 3 * self.mesh().nodes.len());
        moved.iter().map(|&component| component != 0.0).collect()
    }

    /// Number of entries of the lower triangle of the stiffness matrix, and of its factor.
    pub fn entries(&self) -> (usize, usize) {
        (self.data.pattern.entries(), self.data.symbolic.entries())
    }

    /// Multiplications and additions of one factorisation of the stiffness matrix.
    pub fn factor_flops(&self) -> f64 {
        self.data.symbolic.flops()
    }

    /// Volume of the solid at rest, m³; of a half model, of the half.
    pub fn volume(&self) -> CubicMetre {
        self.data.reference.volumes.iter().sum()
    }

    /// Volume of each element at rest, m³.
    pub fn element_volumes(&self) -> &[CubicMetre] {
        &self.data.reference.volumes
    }

    /// Volume of the cavity of `chamber` at `displacement` (3 per node, m), m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber, or the displacement does not have 3 entries per node.
    pub fn chamber_volume(&self, chamber: usize, displacement: &[f64]) -> CubicMetre {
        assert_eq!(displacement.len(), 3 * self.data.mesh.nodes.len(), "a displacement has 3 entries per node");
        self.data.chambers[chamber].volume(displacement)
    }
}

/// By region, m³.
fn region_volumes(mesh: &Mesh, reference: &ReferenceElements, regions: usize) -> Vec<f64> {
    let mut volumes = vec![0.0; regions];
    for (&region, volume) in mesh.regions.iter().zip(&reference.volumes) {
        volumes[region as usize] += volume;
    }
    volumes
}

fn chamber_pressures(mesh: &Mesh, graph: &NodeGraph) -> Result<Vec<ChamberPressure>, SetupError> {
    let mut pressures = Vec::new();
    for (index, chamber) in mesh.chambers.iter().enumerate() {
        validation::check_closed(mesh, index, chamber)?;
        validation::on_elements(graph, index, chamber)?;
        let pressure = ChamberPressure::new(mesh, chamber);
        let volume = pressure.at_rest;
        if volume.is_nan() || volume <= 0.0 {
            return Err(SetupError::InvertedChamber { chamber: index, volume });
        }
        pressures.push(pressure);
    }
    Ok(pressures)
}
