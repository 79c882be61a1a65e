//! The model: a meshed body with its materials, clamp, chambers and markers.

use std::sync::Arc;

use fem::{Clamps, Contact, Options, RegionProperties, Relaxation, Solver, System};
use mesh::{QuadraticMesh, Solid, Spot};
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Point3, Second};

use crate::body::{Body, Material};
use diagnostics::{Diagnostic, Result};

/// The finite-element model of a specimen.
#[derive(Clone)]
pub struct Model {
    /// What `fem` solves: one region a solid, the softest first; chambers in the order of the card.
    pub system: Arc<System>,
    /// The card's markers as material points, in its order.
    pub markers: Vec<Spot>,
    /// Nominal constants of the solids, from the card.
    pub nominal: Elastic,
}

/// What surrounds a meshed body.
#[derive(Debug, Clone, Copy, Default)]
pub struct Attached<'a> {
    /// The skin indices of the chambers, in the order of the card.
    pub chambers: &'a [u16],
    /// The nodes of the surface that the card's clamp names; none of a clamp by its place.
    pub clamped: &'a [u32],
}

/// The elastic constants of the solids, the softest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Elastic {
    /// E, Pa.
    pub youngs_moduli: Vec<Pascal>,
    /// ν, no unit.
    pub poissons_ratios: Vec<f64>,
    /// C₂₀/C₁₀ and C₃₀/C₁₀ of the softest, no unit; without effect where its law does not stiffen.
    pub stiffening: [f64; 2],
}

impl Elastic {
    /// Sets them in a solver.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a modulus is not positive or a ratio is not below one half.
    pub fn apply(&self, solver: &mut Solver) -> Result<()> {
        for (region, (e, nu)) in self.youngs_moduli.iter().zip(&self.poissons_ratios).enumerate() {
            solver.set_elastic(region, *e, *nu)?;
        }
        Ok(solver.set_stiffening(BODY, self.stiffening)?)
    }
}

/// Elastic constants after all relaxation, with the relaxation of the softest solid.
#[derive(Debug, Clone, PartialEq)]
pub struct Viscoelastic {
    /// Long-term constants.
    pub elastic: Elastic,
    /// Of the softest solid; others do not relax.
    pub relaxation: Relaxation,
}

impl From<Elastic> for Viscoelastic {
    fn from(elastic: Elastic) -> Self {
        Self { elastic, relaxation: Relaxation::default() }
    }
}

impl Viscoelastic {
    /// Of a body whose Young's modulus was measured `held` seconds after loading.
    pub fn measured_at(held: Second, elastic: Elastic, relaxation: Relaxation) -> Self {
        let mut long_term = elastic;
        long_term.youngs_moduli[BODY] /= relaxation.modulus(held);
        Self { elastic: long_term, relaxation }
    }

    /// Sets both in a solver.
    ///
    /// # Errors
    /// As [`Elastic::apply`]; also when the body's law cannot relax.
    pub fn apply(&self, solver: &mut Solver) -> Result<()> {
        self.elastic.apply(solver)?;
        Ok(solver.set_relaxation(BODY, self.relaxation.clone())?)
    }
}

/// Distance within which walls of chambers repel each other, over the body's size.
const CONTACT_RANGE: f64 = 1.0 / 200.0;
/// Pressure between two walls at half that distance, over the nominal modulus of the softest solid.
const CONTACT_PRESSURE: f64 = 0.1;

/// The region of the softest solid.
pub const BODY: usize = mesh::BODY as usize;

impl Model {
    /// A solver of the model with these constants.
    ///
    /// # Errors
    /// As [`Elastic::apply`].
    pub(crate) fn solver(&self, elastic: &Elastic) -> Result<Solver> {
        let mut solver = self.system.solver();
        elastic.apply(&mut solver)?;
        Ok(solver)
    }

    /// The model of a meshed body, `attached` to what surrounds it; markers are material points of the mesh.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a material is unknown or the simulator refuses the mesh.
    pub fn new(solid: &Solid, attached: Attached<'_>, markers: Vec<Spot>, body: &Body) -> Result<Self> {
        let mesh = simulate::fem_mesh(solid, attached.chambers);
        let regions = body.materials.iter().map(region_properties).collect::<Result<_>>()?;
        let size = longest_side(solid.nodes());
        let mut clamps = Clamps::where_nodes(&mesh, [true; 3], |node| body.clamp.holds(node, size));
        attached.clamped.iter().for_each(|node| clamps.constrain(*node, [true; 3]));
        // Of the nominal modulus, which no search moves: a potential that followed E would add a term to every
        // derivative by it.
        let soft = body.materials.first().map_or(1.0, |first| first.youngs_modulus);
        let contact = Some(Contact { range: CONTACT_RANGE * size, pressure: CONTACT_PRESSURE * soft });
        let system = System::with(mesh, regions, clamps, Options { contact, ..Options::default() })?;
        let nominal = Elastic {
            youngs_moduli: body.materials.iter().map(|m| m.youngs_modulus).collect(),
            poissons_ratios: body.materials.iter().map(|m| m.poissons_ratio).collect(),
            stiffening: body.materials.first().map_or([0.0; 2], |soft| soft.stiffening),
        };
        Ok(Self { system: Arc::new(system), markers, nominal })
    }

    /// The model with its markers at their measured positions at rest (m, in the plane) instead of the card's.
    ///
    /// A marker beside its nominal position moves with the material at its actual position; a mark is tracked by its centroid.
    pub fn with_markers_at(self, mesh: &QuadraticMesh, body: &Body, rest: &[Point2]) -> Self {
        let spot = |(centre, diameter)| mesh::embed_mark(mesh, centre, diameter).0;
        Self { markers: body.marks_at(rest).map(spot).collect(), ..self }
    }

    /// The model whose walls pass through each other.
    pub(crate) fn without_contact(&self) -> Self {
        Self { system: Arc::new(self.system.without_contact()), ..self.clone() }
    }

    /// The model with further points after its markers.
    pub fn with_spots(mut self, spots: Vec<Spot>) -> Self {
        self.markers.extend(spots);
        self
    }

    /// Displacement of a marker in the plane, m, from the displacement of all nodes (3 a node).
    pub fn in_plane(spot: &Spot, displacement: &[f64]) -> Point2 {
        let sum = |k: usize| spot.weights.iter().map(|&(node, w)| w * displacement[3 * node as usize + k]).sum();
        [sum(0), sum(1)]
    }
}

/// Displacements of all nodes, m, one point a node.
pub fn by_node(displacement: &[f64]) -> Vec<Point3> {
    displacement.chunks_exact(3).map(|u| [u[0], u[1], u[2]]).collect()
}

/// The longest side of the box around nodes, m.
fn longest_side(nodes: &[Point3]) -> Metre {
    let side = |k: usize| {
        let coordinates = || nodes.iter().map(|node| node[k]);
        coordinates().fold(f64::NEG_INFINITY, f64::max) - coordinates().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}

fn region_properties(material: &Material) -> Result<RegionProperties> {
    let law = fem::materials::by_name(&material.law).ok_or_else(|| {
        let names: Vec<&str> = fem::materials::ALL.iter().map(|m| m.name()).collect();
        Diagnostic::new(
            format!("the card gives solid.{} the material `{}`", material.name, material.law),
            format!("known materials: {}", names.join(", ")),
            "correct the card",
        )
    })?;
    if material.stiffening != [0.0; 2] && !law.is_stiffening() {
        let stiffening = fem::materials::ALL.iter().filter(|m| m.is_stiffening()).map(|m| m.name());
        return Err(Diagnostic::new(
            format!("the card gives solid.{} of the material `{}` a stiffening", material.name, material.law),
            format!("materials that stiffen: {}", stiffening.collect::<Vec<_>>().join(", ")),
            "take one of them, or leave stiffening out",
        ));
    }
    let elastic = RegionProperties::elastic(law, material.youngs_modulus, material.poissons_ratio, material.density);
    Ok(RegionProperties { stiffening: material.stiffening, ..elastic })
}
