//! Mesh sensitivity: the moduli identified from the same films on other meshes: tetrahedra of ten and of four nodes, whose locking a lower modulus
//! makes up for, and hexahedra that are finer than the study's.

use ::mesh::Solid;
use fem::StaticSettings;
use optimize::optimisers::gauss_newton;
use optimize::{Bounds, Evaluation, Needs, Problem};
use serde::{Deserialize, Serialize};
use si::Metre;

use super::mesh;
use diagnostics::Result;
use records::subject::Specimen;
use records::{self, Cells, Identified, Mesh, MeshResult, Moduli};
use sysid::{
    Attached, Body, Certified, CertifiedSearch, Derivatives, Elastic, Interrupted, LevelSolver, Misfit, Model,
};
use sysid::{PressureLevel, SimulatedLevel, SimulatedMesh};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct MeshSensitivity;

/// `[mesh_sensitivity]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Target lengths of an edge of tetrahedra, m.
    edges: Vec<Metre>,
    /// Lengths of the study's cells over those of finer hexahedra,
    finer: Vec<f64>,
    /// on which these specimens are identified.
    finer_specimens: Vec<String>,
    /// Fraction of the highest pressure up to which levels are used on tetrahedra: all such meshes must have an equilibrium there.
    pressure_fraction: f64,
    /// Bounds: the largest factor between a modulus and the identified one.
    modulus_factor: f64,
    /// Simulations at most, each mesh.
    iterations: usize,
    /// Tolerance of a step: a search has converged when no logarithm of a modulus changes by more.
    step_tolerance: f64,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    name: String,
    mesh: mesh::Card,
    body: Body,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { name: of.card.name.clone(), mesh: Part::part_of(of), body: Part::part_of(of) }
    }
}

impl Stage for MeshSensitivity {
    type Settings = Settings;
    type Card = Card;
    type Needs = Identified;
    type Makes = records::MeshSensitivity;
    const DESCRIPTION: &'static str = "identified moduli depend on the mesh";
    const VERSION: u32 = 12;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        mesh::Mesh::raw(of)
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        identified: Identified,
        context: &dyn StageContext,
    ) -> Result<records::MeshSensitivity> {
        let finer = if set.finer_specimens.contains(&card.name) { set.finer.as_slice() } else { &[] };
        let tetrahedra = |&edge: &Metre| [10, 4].map(|nodes| Cells::Tetrahedra { edge, nodes });
        let meshes: Vec<Cells> = set.edges.iter().flat_map(tetrahedra).collect();
        let meshes = meshes.into_iter().chain(finer.iter().map(|&finer| Cells::Hexahedra { finer }));
        let meshes: Vec<Cells> = meshes.collect();
        let films = IdentifiedFilms { card, set, identified: &identified };
        let (mut rows, mut searched_before) = (Vec::new(), None);
        for (number, cells) in meshes.iter().enumerate() {
            context.progress(number as f64 / meshes.len() as f64, &cells.size_text());
            let (row, searched) = films.result_on(cells, searched_before.as_ref(), context)?;
            rows.push(row);
            // shapes of elements that lock are the worse guesses
            if cells.nodes() > 4 {
                searched_before = Some(searched);
            }
        }
        Ok(records::MeshSensitivity { rows })
    }
}

/// Where the search on a mesh ended: the next mesh begins there.
struct SearchedMesh {
    mesh: fem::Mesh,
    levels: Vec<PressureLevel>,
    elastic: Elastic,
    simulated: Vec<SimulatedLevel>,
}

impl SearchedMesh {
    fn simulated_mesh(&self) -> SimulatedMesh<'_> {
        let Self { mesh, levels, elastic, simulated } = self;
        SimulatedMesh { mesh, elastic, levels, simulated }
    }
}

/// The films of a specimen with what was identified from them on the study's mesh.
struct IdentifiedFilms<'a> {
    card: &'a Card,
    set: &'a Settings,
    identified: &'a Identified,
}

impl IdentifiedFilms<'_> {
    /// The moduli on another mesh, and where their search ended; it begins where the one on the mesh `before` did.
    fn result_on(
        &self,
        cells: &Cells,
        before: Option<&SearchedMesh>,
        context: &dyn StageContext,
    ) -> Result<(MeshResult, SearchedMesh)> {
        let Self { card, set, identified } = *self;
        let (other_mesh, identified) = match cells {
            Cells::Tetrahedra { edge, .. } => {
                (mesh::with_edge(&card.mesh, *edge, context)?, identified.clone().up_to(set.pressure_fraction))
            }
            Cells::Hexahedra { finer } => {
                (mesh::with_finer_cells(&card.mesh, (set.edges[0], *finer), context)?, identified.clone())
            }
        };
        let levels = Misfit::of_record(&identified.levels, &identified.noise, identified.length)?;
        let model = model_on_mesh(&card.body, &other_mesh, cells.nodes(), &identified)?;
        let mesh = model.system.mesh().clone();
        let search = MeshSearch { set, model: &model, levels: &levels, identified: &identified };
        let mut solver = search.seeded_solver(before);
        let (best, simulated, reduced_sigma) =
            if cells.nodes() == 4 { search.certified_end(&mut solver) } else { search.whole_end(&mut solver) }?;
        let (dofs, at) = (3 * mesh.nodes.len(), search.moduli_at(&best.at));
        let row = MeshResult { cells: *cells, dofs, loss: best.loss, at, reduced_sigma };
        let elastic = search.elastic_at(&best.at);
        Ok((row, SearchedMesh { mesh, levels: levels.levels, elastic, simulated }))
    }
}

fn model_on_mesh(body: &Body, mesh: &Mesh, nodes: usize, identified: &Identified) -> Result<Model> {
    let quadratic = Solid::Quadratic(mesh.solid.clone());
    let solid = if nodes == 4 { Solid::Linear(quadratic.to_linear()) } else { quadratic };
    let rest_positions = identified.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
    let spots = body.marks_at(&rest_positions).map(|(centre, diameter)| solid.embed_mark(centre, diameter).0);
    Model::new(&solid, Attached { chambers: &mesh.skin_codes(), clamped: &[] }, spots.collect(), body)
}

/// Gauss-Newton over the logarithms of the moduli over the identified ones.
struct MeshSearch<'a> {
    set: &'a Settings,
    model: &'a Model,
    levels: &'a Misfit,
    identified: &'a Identified,
}

/// The end of a search: its best point, the whole mesh there, and, of a search in a reduced model, the largest difference of a marker from the whole
/// mesh over its deviation.
type SearchEnd = (Evaluation, Vec<SimulatedLevel>, Option<f64>);

impl MeshSearch<'_> {
    /// In a reduced model where the whole mesh certifies it, else by the whole mesh: elements that lock have their answer far from the start, where the
    /// whole mesh of four-node tetrahedra follows paths at each evaluation, minutes for the model's one.
    fn certified_end(&self, solver: &mut LevelSolver) -> Result<SearchEnd> {
        let start = self.identified.elastic(self.model);
        let certification = CertifiedSearch::new(start, Derivatives::Sensitivities, self.levels);
        let mut search_reduced = |reduced: &mut LevelSolver| {
            let best = self.minimise(reduced)?;
            Ok((self.elastic_at(&best.at), best))
        };
        match certification.run(solver, &mut search_reduced, &|_| ()) {
            Ok(Certified { found, levels, certificate, .. }) if certificate.holds() => {
                Ok((found, levels, Some(certificate.sigma)))
            }
            _ => self.whole_end(solver),
        }
    }

    /// By the whole mesh, whose own answer it is: a reduced model of finer hexahedra took about as long.
    fn whole_end(&self, solver: &mut LevelSolver) -> Result<SearchEnd> {
        let best = self.minimise(solver)?;
        let simulated = solver.solve(&self.elastic_at(&best.at), Derivatives::None)?;
        Ok((best, simulated, None))
    }

    /// Of the whole mesh, from the equilibria of the mesh `before`.
    fn seeded_solver(&self, before: Option<&SearchedMesh>) -> LevelSolver {
        let statics = StaticSettings { tolerance: 1e-6, ..StaticSettings::default() };
        let mut solver = LevelSolver::new(self.model.clone(), self.levels.levels.clone(), statics, 2);
        if let Some(before) = before {
            solver.add_guesses_of_mesh(&before.simulated_mesh());
        }
        solver
    }

    fn moduli_at(&self, point: &[f64]) -> Moduli {
        self.identified.best.iter().zip(point).map(|(modulus, log_ratio)| modulus * log_ratio.exp()).collect()
    }

    fn elastic_at(&self, point: &[f64]) -> Elastic {
        Elastic { youngs_moduli: self.moduli_at(point), ..self.identified.elastic(self.model) }
    }

    fn minimise(&self, solver: &mut LevelSolver) -> Result<Evaluation> {
        let Self { set, identified, .. } = *self;
        let (wide, count) = (set.modulus_factor.ln(), identified.solids.len());
        let bounds = Bounds { low: vec![-wide; count], high: vec![wide; count] };
        let names: Vec<&str> = identified.solids.iter().map(String::as_str).collect();
        let problem = Problem::new(&names, vec![0.0; count], bounds)?;
        let newton = gauss_newton::Settings {
            step_tolerance: set.step_tolerance,
            fall_tolerance: gauss_newton::FALL,
            iterations: set.iterations,
            ..gauss_newton::Settings::default()
        };
        let mut optimiser = gauss_newton::GaussNewton::new(&problem, &newton)?;
        let mut evaluate_batch = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            batch.iter().map(|point| self.evaluate_point(solver, point).map_err(Interrupted)).collect()
        };
        Ok(optimize::minimise(&mut optimiser, &mut evaluate_batch).map_err(|stop| stop.0)?.best)
    }

    /// Loss and residuals at a point; infinite where a level has no equilibrium.
    fn evaluate_point(&self, solver: &mut LevelSolver, point: &[f64]) -> Result<Evaluation> {
        let constants = self.elastic_at(point);
        let Ok(simulated) = solver.solve(&constants, Derivatives::Sensitivities) else {
            return Ok(Evaluation::of_loss(point.to_vec(), f64::INFINITY));
        };
        let markers: Vec<_> = simulated.iter().map(|level| level.markers.clone()).collect();
        let residuals = self.levels.residuals(&simulated, &constants.youngs_moduli)?;
        Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(point.to_vec(), self.levels.loss(&markers)) })
    }
}
