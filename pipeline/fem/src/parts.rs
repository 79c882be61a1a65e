//! Parts: everything about a body that no solve changes, shared by all solvers.
//!
//! Stands on: `body`, `algebra`, `loads`, `options`. Never knows: a solver.

use crate::algebra::factor::Symbolic;
use crate::algebra::sparse::Pattern;
use crate::body::assembly::Body;
use crate::body::mass::{Mass, Overlaps};
use crate::body::rest::Rest;
use crate::loads::ChamberPressure;
use crate::mesh::Mesh;
use crate::options::Options;
use crate::region::RegionProperties;
use si::Metre;
use std::sync::Arc;

/// What a system is made of.
#[derive(Debug)]
pub(crate) struct Parts {
    pub mesh: Mesh,
    pub regions: Vec<RegionProperties>,
    pub rest: Rest,
    /// By region, m³.
    pub volumes: Vec<f64>,
    pub pattern: Pattern,
    pub places: Vec<u32>,
    pub symbolic: Symbolic,
    pub options: Options,
    pub overlaps: Overlaps,
    pub mass: Arc<Mass>,
    pub chambers: Vec<ChamberPressure>,
    pub size: Metre,
}

impl Parts {
    pub fn body(&self) -> Body<'_> {
        Body { mesh: &self.mesh, rest: &self.rest, pattern: &self.pattern, places: &self.places }
    }
}
