//! `[solid]`: the solids of a specimen, each with its material, from STL files or as regions of one mesh.

use std::fmt;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use si::{KilogramPerCubicMetre, Pascal};

use super::LengthUnit;

/// `[solid]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solids {
    /// Unit of the files.
    pub unit: LengthUnit,
    /// A mesh, relative to the card; without one, STL files are meshed.
    pub mesh: Option<String>,
    /// The solids, the softest (by nominal modulus) first.
    pub parts: Vec<Part>,
}

/// `[solid.NAME]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// Its name, the key of its table.
    pub name: String,
    /// The solid.
    pub solid: Solid,
}

/// A solid and its material, with the values of the data sheet.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// STL file, relative to the card; none of a region of a mesh.
    #[serde(default)]
    pub file: Option<String>,
    /// Its region in the mesh by name, or by its tag as text; its own name where it is not given.
    #[serde(default)]
    pub region: Option<String>,
    /// Name of the constitutive model, e.g. `neo_hookean`.
    pub material: String,
    /// Nominal Young's modulus, Pa: the initial guess of an identification.
    pub youngs_modulus: Pascal,
    /// Poisson's ratio, no unit.
    pub poissons_ratio: f64,
    /// Density, kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Nominal C₂₀/C₁₀ and C₃₀/C₁₀ of a law that stiffens, such as `yeoh`: the initial guess of an identification.
    #[serde(default)]
    pub stiffening: [f64; 2],
    /// Standard deviations of `stiffening`, such as those of a tensile test of the batch; without them it is taken for a guess.
    #[serde(default)]
    pub stiffening_sigma: Option<[f64; 2]>,
    /// Lowest and highest plausible Young's modulus, Pa: the bounds of an identification.
    pub plausible: [Pascal; 2],
}

/// The solid that is made from the STL file of the soft body.
pub const BODY: &str = "body";
/// The solid that is made from the STL file of the stiff sheet in it.
pub const SPINE: &str = "spine";

impl Solids {
    /// The softest first; of equal moduli, the first by name.
    pub fn new(unit: LengthUnit, mesh: Option<String>, mut parts: Vec<Part>) -> Self {
        let order = |a: &Part, b: &Part| a.solid.youngs_modulus.total_cmp(&b.solid.youngs_modulus);
        parts.sort_by(|a, b| order(a, b).then_with(|| a.name.cmp(&b.name)));
        Self { unit, mesh, parts }
    }

    /// A solid and its place in the order, by its name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }

    /// The STL file of a solid.
    pub fn file(&self, name: &str) -> Option<&str> {
        self.parts.iter().find(|part| part.name == name)?.solid.file.as_deref()
    }

    /// All files: the mesh or the surfaces, with their keys on the card.
    pub fn files(&self) -> Vec<(String, &str)> {
        let mesh = self.mesh.as_deref().map(|file| ("solid.mesh".to_owned(), file));
        let surface = |part: &'_ Part| format!("solid.{}.file", part.name);
        let surfaces = self.parts.iter().filter_map(|part| Some((surface(part), part.solid.file.as_deref()?)));
        mesh.into_iter().chain(surfaces).collect()
    }
}

impl Part {
    /// Its region in a mesh: a name, or a tag as text.
    pub fn region(&self) -> &str {
        self.solid.region.as_deref().unwrap_or(&self.name)
    }
}

/// Read entry by entry, so that an error keeps its line.
impl<'de> Deserialize<'de> for Solids {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Entries)
    }
}

struct Entries;

impl<'de> Visitor<'de> for Entries {
    type Value = Solids;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("the unit and the solids, each a table [solid.NAME]")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Solids, A::Error> {
        let (mut unit, mut mesh, mut parts) = (None, None, Vec::new());
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "unit" => unit = Some(map.next_value()?),
                "mesh" => mesh = Some(map.next_value()?),
                _ => parts.push(Part { name: key, solid: map.next_value()? }),
            }
        }
        Ok(Solids::new(unit.ok_or_else(|| A::Error::missing_field("unit"))?, mesh, parts))
    }
}
