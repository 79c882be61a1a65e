//! The error of the mesh in the identified moduli, from a finer mesh of the same surfaces at the same moduli.

use ::mesh::{ElementChoice, Grading, QuadraticElements};
use fem::StaticSettings;
use optimize::Residuals;
use si::Point2;

use super::fitting::{Card, Films, Fitting, Settings, mean_rest};
use super::mesh;
use crate::records::Mesh;
use sysid::discretisation::{error, shift};
use sysid::{Elastic, Model};
use workflow::stage::StageContext;

/// Lengths of hexahedra over those of the mesh on which their error is estimated.
const FINER: f64 = 1.5;

/// The model on a mesh with edges of `[identify] fine_edge`, or of finer hexahedra; or why there is none.
// A study needs no such mesh to go on: its absence is a sentence beside the moduli, not an end.
pub(super) fn finer(
    card: &Card,
    set: &Settings,
    (mesh, films): (&Mesh, &Films),
    context: &dyn StageContext,
) -> Result<Model, String> {
    if !card.mesh.has_surfaces() {
        return Err("the body came as a mesh file, of which there is no finer one".into());
    }
    let settings = ::mesh::Settings { use_symmetry: mesh.solid.half, ..::mesh::Settings::new(set.fine_edge) };
    let elements = match mesh.solid.elements {
        QuadraticElements::Hexahedra(_) => ElementChoice::Hexahedra(Grading::COARSE.finer(FINER)),
        QuadraticElements::Tetrahedra(_) => ElementChoice::Tetrahedra,
    };
    let by = mesh::Mesher { settings, elements };
    let made = mesh::made(&card.mesh, &by, mesh::MARKER_LIMIT, context).map_err(|d| on_edges(set, &d.what))?;
    let [here, there] = [&mesh.solid, &made.solid].map(|solid| solid.elements.len());
    if there <= here {
        let kind = mesh.solid.elements.name();
        return Err(on_edges(set, &format!("there are {there} {kind}, not more than {here}")));
    }
    let model = made.model(&card.body).map_err(|d| on_edges(set, &d.what))?;
    Ok(model.with_markers_at(&made.solid, &card.body, &mean_rest(&films.0)))
}

fn on_edges(set: &Settings, why: &dyn std::fmt::Display) -> String {
    format!("on edges of {:.1} mm, {why}", 1e3 * set.fine_edge)
}

impl Fitting<'_> {
    /// By how much the discretisation error shifts the logarithm of each parameter; or why that is not known. `found` are the markers'
    /// displacements at the identified parameters (levels × markers, m), with the whitened residuals there.
    pub(super) fn discretisation(
        &self,
        finer: Result<Model, String>,
        elastic: &Elastic,
        found: &[Vec<Point2>],
        residuals: (&Residuals, usize),
    ) -> Result<Vec<f64>, String> {
        // the lowest pressures are reached at once; three steps to each took half of the stage's time
        let settings =
            StaticSettings { tolerance: self.set.static_tolerance, load_steps: 1, ..StaticSettings::default() };
        let error = error(&self.loss.misfit.levels, found, &finer?, (elastic, &settings));
        error.and_then(|error| shift(&self.loss.misfit, residuals, &error)).map_err(|d| on_edges(self.set, &d.what))
    }
}
