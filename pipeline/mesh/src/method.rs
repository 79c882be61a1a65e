//! The choice of the method by which tetrahedra are made from surfaces.

use serde::{Deserialize, Serialize};
use si::Metre;

/// How tetrahedra are made from surfaces, as settings and cases name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// In columns over the sheet's plane; bodies that are no stack of layers are refused.
    #[default]
    Columns,
    /// By insertion of the surfaces into Delaunay tetrahedra: any closed surfaces.
    General,
    /// In columns where they divide the body in elements of 5° and more, else by the general method.
    Auto,
}

/// What the general method is asked for besides the length of edges; columns follow their own rules.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Detail {
    /// Largest distance between the surfaces and the mesh's, m; 2 % of an edge where there is none.
    pub envelope: Option<Metre>,
    /// Shortest edges, m: smaller features are followed within the envelope only; a sixteenth of an edge where there is none.
    pub smallest: Option<Metre>,
    /// Elements through a wall, as far as edges are not shorter than the shortest; one, five times as wide as the wall is thick, where there is none.
    pub layers: Option<u32>,
}

impl Detail {
    /// Whether nothing is asked for.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}
