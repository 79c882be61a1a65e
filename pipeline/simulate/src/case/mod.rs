//! Cases: one body under loads, described by a TOML file.
//!
//! Every key with its unit: [`keys`], which `study simulate --help` shows.

mod check;
mod check_clamp;
mod check_place;
mod check_source;
mod history;
mod loads;
mod read;
mod rule;
mod solve;

use crate::budget::Budget;
use mesh::{Detail, ElementName, Method};
use serde::Deserialize;
use si::{KilogramPerCubicMetre, Metre, Pascal, Point3, Second};

pub use check::check_history;
pub use history::{History, Wave};
pub use lab::place::{Block, Place, Plane};
pub use loads::{Chamber, Load, Mass};
pub use read::{parse, read};
pub use solve::{ArcLength, BranchRule, Dynamic, Marker, Node, Output, Scheme, Start, Static, Steps};

/// The keys of a case, as an example.
const KEYS: &str = include_str!("keys.txt");

/// Every key of a case with its unit and, for the material, the names of all laws.
pub fn keys() -> String {
    let laws: Vec<&str> = fem::materials::ALL.iter().map(|law| law.name()).collect();
    KEYS.replace("MATERIALS", &laws.join(", "))
}

/// The contents of a case.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// m/s²; acts in full at every level and time.
    #[serde(default)]
    pub gravity: Point3,
    /// The mesh, or the surfaces to be meshed.
    pub mesh: Source,
    /// Materials of its regions.
    pub region: Vec<Region>,
    /// Its clamps.
    #[serde(default)]
    pub clamp: Vec<Clamp>,
    /// Its chambers and their pressures.
    #[serde(default)]
    pub chamber: Vec<Chamber>,
    /// Dead loads.
    #[serde(default)]
    pub load: Vec<Load>,
    /// Attached masses.
    #[serde(default)]
    pub mass: Vec<Mass>,
    /// Self-contact of chamber walls; without it they pass through each other.
    pub contact: Option<Contact>,
    /// Settings of equilibria.
    #[serde(rename = "static")]
    pub statics: Option<Static>,
    /// Settings of a motion.
    pub dynamic: Option<Dynamic>,
    /// Settings of the output.
    #[serde(default)]
    pub output: Output,
}

impl Case {
    /// The limits that it sets.
    pub fn budget(&self) -> Budget {
        let statics = self.statics.as_ref().map(Static::budget);
        statics.or(self.dynamic.as_ref().map(Dynamic::budget)).unwrap_or_default()
    }
}

/// `[contact]`: how walls of chambers that meet repel each other.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Distance beyond which they do not, m.
    pub range: Metre,
    /// Pressure between two flat walls at half the range, Pa.
    pub pressure: Pascal,
}

/// `[mesh]`: a mesh, or two surfaces to be meshed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// A mesh file, relative to the case.
    pub file: Option<String>,
    /// The soft body's STL file, relative to the case.
    pub body: Option<String>,
    /// The stiff sheet's STL file, relative to the case, where there is one.
    pub spine: Option<String>,
    /// Length of edges for STL files, m.
    pub edge: Option<Metre>,
    /// Unit of the files' numbers.
    pub unit: Unit,
    /// Order of the elements; the file's own when it is not said, quadratic for STL files.
    pub order: Option<Order>,
    /// Elements for STL files; hexahedra of a body with chambers that rows and levels divide, where they are not longer than `edge`, when it is not said.
    pub elements: Option<ElementName>,
    /// How tetrahedra are made from STL files; in columns where they divide the body, else by the general method, when it is not said.
    #[serde(default = "automatic")]
    pub method: Method,
    /// What the general method is asked for besides.
    #[serde(default)]
    pub detail: Detail,
    /// Whether the half z ≥ 0 of a symmetric body is simulated.
    #[serde(default)]
    pub half: bool,
    /// By how much cells made from STL files are shorter than the case says: for a certificate of resolution.
    #[serde(skip, default = "same_length")]
    pub finer: f64,
}

fn automatic() -> Method {
    Method::Auto
}

fn same_length() -> f64 {
    1.0
}

impl Source {
    /// Elements for STL files: hexahedra where rows and levels divide a body with chambers, as thin walls bend in them at a fifth of the work, unless
    /// the case says otherwise or asks for what tetrahedra alone have: an order, a method, a detail.
    pub(crate) fn chosen_elements(&self) -> ElementName {
        let is_free = self.method == Method::Auto && self.detail.is_usual() && self.order != Some(Order::Linear);
        self.elements.unwrap_or(if is_free { ElementName::Auto } else { ElementName::Tetrahedra })
    }

    /// The file that the mesh is read or made from.
    pub fn name(&self) -> &str {
        self.file.as_deref().or(self.body.as_deref()).unwrap_or_default()
    }
}

/// Unit of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Metres.
    M,
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Inches.
    #[serde(alias = "in")]
    Inch,
}

impl Unit {
    /// One of it, m.
    pub fn metres(self) -> Metre {
        match self {
            Self::M => 1.0,
            Self::Mm => 1e-3,
            Self::Cm => 1e-2,
            Self::Inch => 0.0254,
        }
    }
}

/// Order of the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// Four nodes.
    Linear,
    /// Ten nodes.
    Quadratic,
}

/// `[[region]]`: the material of one region of the mesh.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Its name in the file; `body` or `spine` for STL files.
    pub name: Option<String>,
    /// Its tag in the file.
    pub tag: Option<i64>,
    /// The law's name.
    pub material: String,
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// ν, no unit.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Whether the volumetric energy uses each element's mean dilatation.
    #[serde(default)]
    pub mean_dilatation: bool,
    /// C₂₀/C₁₀ and C₃₀/C₁₀ of a law that stiffens.
    #[serde(default)]
    pub stiffening: [f64; 2],
    /// Maxwell branches of its relaxation.
    #[serde(default)]
    pub branch: Vec<Branch>,
    /// A springpot in the place of branches.
    pub springpot: Option<Springpot>,
    /// The time after loading at which `youngs_modulus` was measured, s; left out: so long that nothing relaxes any more.
    pub modulus_time: Option<Second>,
}

/// A Maxwell branch of a region.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Branch {
    /// Its modulus over the long-term one.
    pub strength: f64,
    /// Its relaxation time, s.
    pub time: Second,
}

/// A springpot, laid out as one branch per decade.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Springpot {
    /// Modulus of the branch of one second over the long-term one.
    pub strength: f64,
    /// Exponent, between 0 and 1.
    pub exponent: f64,
    /// Powers of ten of the fastest and the slowest branch, s.
    #[serde(default = "decades")]
    pub decades: [i32; 2],
}

/// From a millisecond to ten seconds: what a camera of some hundred frames a second sees in a trial of a minute.
fn decades() -> [i32; 2] {
    [-3, 1]
}

/// `[[clamp]]`: constrained nodes and axes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// On a plane.
    pub plane: Option<Plane>,
    /// In a box.
    #[serde(rename = "box")]
    pub block: Option<Block>,
    /// A surface that the mesh file names or numbers.
    pub surface: Option<String>,
    /// Axes; all when it is not said.
    #[serde(default = "all_axes")]
    pub hold: Vec<Axis>,
    /// Where it moves them at level 1, m.
    #[serde(default)]
    pub displacement: Point3,
    /// The prefix of the columns of its force on the body.
    pub name: Option<String>,
}

impl Clamp {
    /// Whether it moves its nodes.
    pub(crate) fn is_displaced(&self) -> bool {
        self.displacement != [0.0; 3]
    }
}

/// An axis of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

fn all_axes() -> Vec<Axis> {
    vec![Axis::X, Axis::Y, Axis::Z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_that_the_help_shows_are_those_that_are_read() {
        let page = KEYS.split_once("\n\n").and_then(|(_, rest)| rest.split_once("A history is")).unwrap().0;
        let case: Case = toml::from_str(page).unwrap();
        assert!(case.statics.is_some() && case.dynamic.is_some() && case.contact.is_some());
        assert_eq!((case.load.len(), case.mass.len(), case.output.marker.len()), (1, 1, 1));
    }
}
