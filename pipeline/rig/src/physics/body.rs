//! A specimen as a finite-element system: its mesh, the chambers of each side, its hidden properties.

use std::path::Path;

use crate::side::Side;
use diagnostics::{Diagnostic, Result};
use fem::{Branch, Clamps, Contact, Options, RegionProperties, Relaxation, System};
use lab::truth::Properties;
use mesh::{Grading, QuadraticMesh, SPINE, Skin, Solid};
use si::{MILLIMETRE, Metre, Pascal};
use tail_cad::{FILM, Resolution, Tail};

use crate::settings;
use crate::specimen::HiddenProperties;

/// A specimen, ready to be solved.
pub struct Body {
    /// Its mesh at rest, half of it.
    pub mesh: QuadraticMesh,
    /// The same as a system of equations.
    pub system: System,
    /// Which chamber of the mesh lies on the left.
    left: usize,
}

/// Nodes this close to the holder's edge (m) are clamped.
const TOLERANCE: Metre = 1e-9;

/// Distance within which walls repel each other, m.
const CONTACT_RANGE: Metre = 0.5 * MILLIMETRE;
/// Pressure between two walls at half that distance, over the modulus of the silicone.
const CONTACT_PRESSURE: f64 = 0.1;

/// How a body is meshed and held.
pub struct BodySettings<'a> {
    /// Resolution of the mesh.
    pub resolution: &'a settings::Resolution,
    /// Everything at or below this x is clamped, m.
    pub clamp: Metre,
    /// Constitutive laws of body and sheet, by their names in `fem`.
    pub laws: [&'a str; 2],
}

impl Body {
    /// The system of `tail` as it was cast, with its hidden properties.
    ///
    /// # Errors
    /// When the tail's dimensions are inconsistent, a material law is unknown, or the mesh is invalid.
    pub fn new(tail: &Tail, settings: &BodySettings, hidden: &HiddenProperties) -> Result<Self> {
        let in_mesh = |e: Diagnostic| e.while_doing("the bench's mesh");
        let mesh = mesh_of_tail(&hidden.cast_tail(tail), settings.resolution).map_err(in_mesh)?;
        let model = simulate::fem_mesh(&Solid::Quadratic(mesh.clone()), &[0, 1]);
        let clamped = Clamps::below_x(&model, settings.clamp + TOLERANCE);
        let [body, sheet] = settings.laws;
        let mut regions = vec![region_properties(body, &hidden.body)?, region_properties(sheet, &hidden.spine)?];
        if mesh.regions.contains(&FILM) {
            regions.push(region_properties(body, &film_properties(&hidden.body))?);
        }
        let contact = Some(Contact { range: CONTACT_RANGE, pressure: CONTACT_PRESSURE * hidden.body.youngs_modulus });
        let options = Options { contact, ..Options::default() };
        let system = System::with(model, regions, clamped, options).map_err(|e| in_mesh(e.into()))?;
        let left_chamber = usize::from(mean_y(&mesh, 0) < mean_y(&mesh, 1));
        Ok(Self { mesh, system, left: left_chamber })
    }

    /// Factors of the moduli of each region when those of the silicone are multiplied by `softening`.
    pub fn modulus_scales(&self, softening: f64) -> Vec<f64> {
        let scale = |region: usize| if region == usize::from(SPINE) { 1.0 } else { softening };
        (0..self.system.regions().len()).map(scale).collect()
    }

    /// Relaxation of each region.
    pub fn relaxation(&self) -> Vec<Relaxation> {
        self.system.regions().iter().map(|region| region.relaxation.clone()).collect()
    }

    /// Pressures of all chambers (Pa) when each side has its own.
    pub fn pressures(&self, left: Pascal, right: Pascal) -> Vec<Pascal> {
        let mut pressures = vec![right; 2];
        pressures[self.left] = left;
        pressures
    }

    /// Pressures of all chambers (Pa) when `side` alone is filled.
    pub(crate) fn one_side(&self, side: Side, pressure: Pascal) -> Vec<Pascal> {
        let [left, right] = side.alone(pressure);
        self.pressures(left, right)
    }
}

/// The mesh of a tail, from its own layers.
fn mesh_of_tail(tail: &Tail, resolution: &settings::Resolution) -> Result<QuadraticMesh> {
    let settings::Resolution { edge, per_chamber, per_rib, hexahedra } = *resolution;
    Ok(match hexahedra {
        Some(factor) => tail.hexahedra(&Grading::COARSE.finer(factor))?,
        None => mesh::quadratic(&tail.mesh(&Resolution { edge, per_chamber, per_rib })?),
    })
}

/// Shear modulus of the film between silicone and sheet where they do not adhere, over that of the silicone.
const FILM_SHEAR: f64 = 0.01;

/// The film on which silicone slides: of its bulk modulus, so that it passes on pressure, with hardly a shear modulus. Suction keeps the two
/// from parting.
fn film_properties(silicone: &Properties) -> Properties {
    let Properties { youngs_modulus, poissons_ratio, .. } = *silicone;
    Properties {
        youngs_modulus: FILM_SHEAR * youngs_modulus,
        poissons_ratio: 0.5 - FILM_SHEAR * (0.5 - poissons_ratio),
        stiffening: [0.0; 2],
        ..silicone.clone()
    }
}

fn region_properties(material: &str, properties: &Properties) -> Result<RegionProperties> {
    let known_laws = || fem::materials::ALL.iter().map(|m| m.name()).collect::<Vec<_>>().join(", ");
    let material = fem::materials::by_name(material).ok_or_else(|| {
        let (file, message) = (Path::new("bench.toml"), format!("the material law `{material}` is unknown"));
        Diagnostic::file(file, message, format!("fem has {}", known_laws()), "name one of these")
    })?;
    let branches: Vec<Branch> =
        properties.branch.iter().map(|b| Branch { strength: b.strength, time: b.time }).collect();
    let relaxation = Relaxation::maxwell(&branches).map_err(|e| Diagnostic::from(e).while_doing("bench.toml"))?;
    let Properties { youngs_modulus, poissons_ratio, density, stiffening, .. } = *properties;
    let elastic = RegionProperties::elastic(material, youngs_modulus, poissons_ratio, density);
    Ok(RegionProperties { stiffening, relaxation, ..elastic })
}

/// Mean y of a chamber's wall, m.
fn mean_y(mesh: &QuadraticMesh, chamber: u16) -> Metre {
    let wall = mesh.skin.iter().filter(|f| f.on == Skin::Chamber(chamber));
    let (sum, count) = wall
        .flat_map(|f| f.nodes().iter().copied())
        .fold((0.0, 0.0), |(s, n), v| (s + mesh.nodes[v as usize][1], n + 1.0));
    sum / count
}
