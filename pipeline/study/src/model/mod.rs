//! The model: a meshed specimen handed from `shape` to `fem`, with the card's materials, clamp, chambers and markers.
//!
//! Stands on: fem, shape, the mesh record, the card. Never knows: a measurement, an optimiser.

mod known;
mod ladder;
mod reduced;
mod solid_angle;

use std::sync::Arc;

use fem::{Chamber, Clamps, Elements, Faces, RegionProperties, Solver, System};
use lab::card::Card;
use serde::{Deserialize, Serialize};
use shape::{Skin, Solid, Spot};
use si::{Pascal, Point2, Point3};

use crate::fault::{Fault, Outcome};
use crate::records::{Cavity, Mesh};

pub use ladder::{Ladder, Rung, Simulated, Want};
pub use reduced::{Small, reduce};
pub use solid_angle::{chamber_at, chamber_holding};

/// A specimen ready to be simulated.
#[derive(Clone)]
pub struct Model {
    /// What `fem` solves: region 0 is the body, region 1 the spine; chambers in the order of the card.
    pub system: Arc<System>,
    /// The card's markers as material points, in its order.
    pub markers: Vec<Spot>,
    /// What the card says of body and spine.
    pub nominal: Elastic,
}

/// The elastic constants of body and spine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Elastic {
    /// E, Pa.
    pub youngs_moduli: [Pascal; 2],
    /// ν, no unit.
    pub poissons_ratios: [f64; 2],
}

impl Elastic {
    /// Gives them to a solver.
    ///
    /// # Errors
    /// A [`Fault`] when a modulus is not positive or a ratio is not below one half.
    pub fn give(&self, solver: &mut Solver) -> Outcome<()> {
        for (region, (e, nu)) in self.youngs_moduli.into_iter().zip(self.poissons_ratios).enumerate() {
            solver.set_elastic(region, e, nu).map_err(Fault::from_tool)?;
        }
        Ok(())
    }
}

/// The region of the soft body.
pub const BODY: usize = shape::BODY as usize;
/// The region of the stiff sheet.
pub const SPINE: usize = shape::SPINE as usize;

impl Model {
    /// The model of a specimen from its mesh and its card.
    ///
    /// # Errors
    /// A [`Fault`] when a material is unknown or the simulator refuses the mesh.
    pub fn new(mesh: &Mesh, card: &Card) -> Outcome<Self> {
        Self::of(&Solid::Quadratic(mesh.solid.clone()), &mesh.chambers, mesh.markers.clone(), card)
    }

    /// The same with elements of either order; markers are given as material points of that mesh.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn of(solid: &Solid, chambers: &[Cavity], markers: Vec<Spot>, card: &Card) -> Outcome<Self> {
        let solid = fem_mesh(solid, chambers.iter().map(|c| c.skin));
        let regions = vec![region("body", &card.solid.body)?, region("spine", &card.solid.spine)?];
        let clamps = Clamps::below_x(&solid, card.clamp.below_x);
        let system = System::new(solid, regions, clamps).map_err(Fault::from_tool)?;
        let solids = [&card.solid.body, &card.solid.spine];
        let nominal = Elastic {
            youngs_moduli: solids.map(|s| s.youngs_modulus),
            poissons_ratios: solids.map(|s| s.poissons_ratio),
        };
        Ok(Self { system: Arc::new(system), markers, nominal })
    }

    /// The model with its markers where films saw them at rest (m, in the plane), instead of where the card has them.
    ///
    /// A mark painted a little off its place moves with the material there.
    pub fn seen_at(self, mesh: &Mesh, card: &Card, rest: &[Point2]) -> Self {
        let spot =
            |(marker, at): (&lab::card::Marker, &Point2)| shape::embed(&mesh.solid, [at[0], at[1], marker.at[2]]).0;
        Self { markers: card.marker.iter().zip(rest).map(spot).collect(), ..self }
    }

    /// The model with further places behind its markers.
    pub fn and(mut self, spots: Vec<Spot>) -> Self {
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

fn fem_mesh(solid: &Solid, chambers: impl Iterator<Item = u16>) -> fem::Mesh {
    let faces = |skin: u16| match solid {
        Solid::Linear(mesh) => {
            Faces::Linear(mesh.skin.iter().filter(|f| f.on == Skin::Chamber(skin)).map(|f| f.nodes).collect())
        }
        Solid::Quadratic(mesh) => {
            Faces::Quadratic(mesh.skin.iter().filter(|f| f.on == Skin::Chamber(skin)).map(|f| f.nodes).collect())
        }
    };
    fem::Mesh {
        nodes: solid.nodes().to_vec(),
        elements: match solid {
            Solid::Linear(mesh) => Elements::Linear(mesh.tets.clone()),
            Solid::Quadratic(mesh) => Elements::Quadratic(mesh.tets.clone()),
        },
        regions: solid.regions().to_vec(),
        chambers: chambers.map(|skin| Chamber { faces: faces(skin) }).collect(),
        symmetry_plane_z: solid.half(),
    }
}

fn region(name: &str, solid: &lab::card::Solid) -> Outcome<RegionProperties> {
    let material = fem::materials::by_name(&solid.material).ok_or_else(|| {
        let known: Vec<&str> = fem::materials::ALL.iter().map(|m| m.name()).collect();
        Fault::new(
            format!("the card gives solid.{name} the material `{}`", solid.material),
            format!("known materials: {}", known.join(", ")),
            "correct the card",
        )
    })?;
    Ok(RegionProperties {
        material,
        youngs_modulus: solid.youngs_modulus,
        poissons_ratio: solid.poissons_ratio,
        density: solid.density,
    })
}
