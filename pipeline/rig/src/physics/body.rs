//! A specimen as a system of finite elements: its mesh, its chambers by side, its hidden properties.
//!
//! Stands on: `shape` (the mesh), `fem` (the system). Never knows: a pressure in time.

use fem::{Chamber, Clamps, Elements, Faces, Mesh, RegionProperties, System};
use lab::card::Side;
use lab::truth::Properties;
use shape::tail::{Resolution, Tail};
use shape::{QuadraticMesh, Skin};
use si::{Metre, Pascal};

use crate::fault::Fault;
use crate::settings;
use crate::specimen::Hidden;

/// A specimen, ready to be solved.
pub struct Body {
    /// Its mesh at rest, half of it.
    pub mesh: QuadraticMesh,
    /// The same as a system of equations.
    pub system: System,
    /// Which chamber of the mesh lies on the left.
    left: usize,
    /// What loses energy when it moves.
    pub stiffness_damping: f64,
}

/// Nodes this close to the holder's edge (m) are held by it.
const TOUCH: Metre = 1e-9;

impl Body {
    /// The system of `tail`, as it was cast, with its hidden properties, held as far as `clamp` (m).
    ///
    /// # Errors
    /// [`Fault`] when the tail's numbers leave no room for a part, the law is unknown, or the mesh cannot be trusted.
    pub fn new(
        tail: &Tail,
        fineness: &settings::Resolution,
        clamp: Metre,
        [body, sheet]: [&settings::Material; 2],
        hidden: &Hidden,
    ) -> Result<Self, Fault> {
        let resolution =
            Resolution { edge: fineness.edge, per_chamber: fineness.per_chamber, per_rib: fineness.per_rib };
        let mesh =
            shape::quadratic(&hidden.cast(tail).mesh(&resolution).map_err(|e| Fault::at("the bench's mesh", e))?);
        let model = model(&mesh);
        let clamped = Clamps::below_x(&model, clamp + TOUCH);
        let regions = vec![region(&body.law, &hidden.body)?, region(&sheet.law, &hidden.spine)?];
        let system = System::new(model, regions, clamped).map_err(|e| Fault::at("the bench's mesh", e))?;
        let left = usize::from(mean_y(&mesh, 0) < mean_y(&mesh, 1));
        Ok(Self { mesh, system, left, stiffness_damping: hidden.damping.stiffness })
    }

    /// Pressures of all chambers (Pa) when each side has its own.
    pub fn pressures(&self, left: Pascal, right: Pascal) -> Vec<Pascal> {
        let mut pressures = vec![right; 2];
        pressures[self.left] = left;
        pressures
    }

    /// Pressures of all chambers (Pa) when `side` alone is filled.
    pub fn one_side(&self, side: Side, pressure: Pascal) -> Vec<Pascal> {
        match side {
            Side::Left => self.pressures(pressure, 0.0),
            Side::Right => self.pressures(0.0, pressure),
        }
    }
}

/// The mesh as `fem` takes it: chambers in the order of their numbers.
fn model(mesh: &QuadraticMesh) -> Mesh {
    let faces =
        |chamber: u16| mesh.skin.iter().filter(move |f| f.on == Skin::Chamber(chamber)).map(|f| f.nodes).collect();
    Mesh {
        nodes: mesh.nodes.clone(),
        elements: Elements::Quadratic(mesh.tets.clone()),
        regions: mesh.regions.clone(),
        chambers: (0..2).map(|c| Chamber { faces: Faces::Quadratic(faces(c)) }).collect(),
        symmetry_plane_z: mesh.half,
    }
}

fn region(material: &str, properties: &Properties) -> Result<RegionProperties, Fault> {
    let known = || fem::materials::ALL.iter().map(|m| m.name()).collect::<Vec<_>>().join(", ");
    let material = fem::materials::by_name(material).ok_or_else(|| {
        let what = format!("the material `{material}` is unknown");
        Fault::new("bench.toml", &what, &format!("fem has {}", known()), "name one of them")
    })?;
    Ok(RegionProperties {
        material,
        youngs_modulus: properties.youngs_modulus,
        poissons_ratio: properties.poissons_ratio,
        density: properties.density,
    })
}

/// Mean y of a chamber's wall, m.
fn mean_y(mesh: &QuadraticMesh, chamber: u16) -> Metre {
    let wall = mesh.skin.iter().filter(|f| f.on == Skin::Chamber(chamber));
    let (sum, count) =
        wall.flat_map(|f| f.nodes).fold((0.0, 0.0), |(s, n), v| (s + mesh.nodes[v as usize][1], n + 1.0));
    sum / count
}
