//! The error of the mesh in the identified moduli, from a finer mesh of the same surfaces at the same moduli.

use ::mesh::{ElementChoice, Grading, QuadraticElements};
use optimize::Residuals;

use super::fitting::{Card, Films, Fitting, Settings, mean_rest};
use super::mesh;
use records::Mesh;
use sysid::discretisation::{MeshError, mesh_error};
use sysid::{Elastic, LevelSolver, Loss, Model, SimulatedLevel, statics};
use workflow::stage::StageContext;

/// Lengths of hexahedra over those of the mesh on which their error is estimated.
const FINER: f64 = 1.5;

/// The model on a mesh with edges of `[identify] fine_edge`, or of finer hexahedra; or why there is none.
// A study needs no such mesh to go on: its absence is a sentence beside the moduli, not an end.
pub(super) fn finer_model(
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
    let mesher = mesh::Mesher { settings, elements };
    let fine_mesh =
        mesh::specimen_mesh(&card.mesh, &mesher, mesh::MARKER_LIMIT, context).map_err(|d| on_edges(set, &d.what))?;
    let [coarse_count, fine_count] = [&mesh.solid, &fine_mesh.solid].map(|solid| solid.elements.len());
    if fine_count <= coarse_count {
        let kind = mesh.solid.elements.name();
        return Err(on_edges(set, &format!("there are {fine_count} {kind}, not more than {coarse_count}")));
    }
    let model = fine_mesh.model(&card.body).map_err(|d| on_edges(set, &d.what))?;
    Ok(model.with_markers_at(&fine_mesh.solid, &card.body, &mean_rest(&films.0)))
}

fn on_edges(set: &Settings, why: &dyn std::fmt::Display) -> String {
    format!("on edges of {:.1} mm, {why}", 1e3 * set.fine_edge)
}

impl Fitting<'_> {
    /// The error of the mesh at the identified parameters, from the `levels` simulated there, with the whitened residuals; or why that is not
    /// known.
    pub(super) fn discretisation_error(
        &self,
        finer: Result<Model, String>,
        (elastic, levels): (&Elastic, &[SimulatedLevel]),
        residuals: (&Residuals, usize),
    ) -> Result<MeshError, String> {
        let Loss { model, misfit, .. } = &self.loss;
        let settings = statics(self.set.static_tolerance);
        let mut solver = LevelSolver::new(finer?, misfit.levels.clone(), settings, self.set.parallel_solves);
        let error = mesh_error(&mut solver, elastic, (model.system.mesh(), levels));
        error.and_then(|error| MeshError::new(misfit, residuals, &error)).map_err(|d| on_edges(self.set, &d.what))
    }
}
