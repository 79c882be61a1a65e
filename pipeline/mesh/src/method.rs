//! The choice of the method by which tetrahedra are made from surfaces.

use serde::{Deserialize, Serialize};

/// How tetrahedra are made from surfaces, as settings and cases name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// In columns over the sheet's plane; bodies that are no stack of layers are refused.
    #[default]
    Columns,
    /// By insertion of the surfaces into Delaunay tetrahedra: any closed surfaces.
    General,
    /// In columns where they divide the body, else by the general method.
    Auto,
}
