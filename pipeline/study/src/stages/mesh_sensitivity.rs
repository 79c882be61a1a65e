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
use sysid::{Attached, Body, CertifiedSearch, Derivatives, Elastic, Interrupted, LevelSolver, Misfit, Model};
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
    const VERSION: u32 = 11;

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
        let row = |(number, cells): (usize, &Cells)| {
            context.progress(number as f64 / meshes.len() as f64, &cells.size_text());
            films.result_on(cells, context)
        };
        let rows = meshes.iter().enumerate().map(row).collect::<Result<_>>()?;
        Ok(records::MeshSensitivity { rows })
    }
}

/// The films of a specimen with what was identified from them on the study's mesh.
struct IdentifiedFilms<'a> {
    card: &'a Card,
    set: &'a Settings,
    identified: &'a Identified,
}

impl IdentifiedFilms<'_> {
    /// The moduli on another mesh.
    fn result_on(&self, cells: &Cells, context: &dyn StageContext) -> Result<MeshResult> {
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
        let dofs = 3 * model.system.mesh().nodes.len();
        let locks = matches!(cells, Cells::Tetrahedra { .. });
        let (best, reduced_sigma) = identify_moduli(set, (&model, locks), &levels, &identified)?;
        Ok(MeshResult { cells: *cells, dofs, loss: best.loss, at: moduli_at(&identified, &best.at), reduced_sigma })
    }
}

fn model_on_mesh(body: &Body, mesh: &Mesh, nodes: usize, identified: &Identified) -> Result<Model> {
    let quadratic = Solid::Quadratic(mesh.solid.clone());
    let solid = if nodes == 4 { Solid::Linear(quadratic.to_linear()) } else { quadratic };
    let rest_positions = identified.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
    let spots = body.marks_at(&rest_positions).map(|(centre, diameter)| solid.embed_mark(centre, diameter).0);
    Model::new(&solid, Attached { chambers: &mesh.skin_codes(), clamped: &[] }, spots.collect(), body)
}

fn moduli_at(identified: &Identified, point: &[f64]) -> Moduli {
    identified.best.iter().zip(point).map(|(modulus, log_ratio)| modulus * log_ratio.exp()).collect()
}

/// Gauss-Newton over the logarithms of the moduli over the identified ones, in a reduced model that the whole mesh certifies. Elements that lock
/// have their answer far from the start: what is not certified is searched on the whole mesh, which finer hexahedra neither need nor allow. With
/// the largest difference of a marker at the end, over its deviation, of a search in the reduced model.
fn identify_moduli(
    set: &Settings,
    (model, locks): (&Model, bool),
    levels: &Misfit,
    identified: &Identified,
) -> Result<(Evaluation, Option<f64>)> {
    let statics = StaticSettings { tolerance: 1e-6, ..StaticSettings::default() };
    let mut whole_mesh = LevelSolver::new(model.clone(), levels.levels.clone(), statics, 2);
    let certification = CertifiedSearch::new(identified.elastic(model), Derivatives::Sensitivities, levels);
    let elastic = |point: &[f64]| Elastic { youngs_moduli: moduli_at(identified, point), ..identified.elastic(model) };
    let mut search_reduced = |solver: &mut LevelSolver| {
        let best = minimise(set, (levels, identified), &elastic, solver)?;
        Ok((elastic(&best.at), best))
    };
    match certification.run(&mut whole_mesh, &mut search_reduced, &|_| ()) {
        Ok(certified) if certified.certificate.holds() || !locks => {
            Ok((certified.found, Some(certified.certificate.sigma)))
        }
        _ => Ok((minimise(set, (levels, identified), &elastic, &mut whole_mesh)?, None)),
    }
}

fn minimise(
    set: &Settings,
    (levels, identified): (&Misfit, &Identified),
    elastic: &dyn Fn(&[f64]) -> Elastic,
    solver: &mut LevelSolver,
) -> Result<Evaluation> {
    let (wide, count) = (set.modulus_factor.ln(), identified.solids.len());
    let bounds = Bounds { low: vec![-wide; count], high: vec![wide; count] };
    let names: Vec<&str> = identified.solids.iter().map(String::as_str).collect();
    let search = Problem::new(&names, vec![0.0; count], bounds)?;
    let newton = gauss_newton::Settings {
        step_tolerance: set.step_tolerance,
        fall_tolerance: gauss_newton::FALL,
        iterations: set.iterations,
        ..gauss_newton::Settings::default()
    };
    let mut optimiser = gauss_newton::GaussNewton::new(&search, &newton)?;
    let mut evaluate = |point: &Vec<f64>| -> Result<Evaluation> {
        let constants = elastic(point);
        let Ok(simulated) = solver.solve(&constants, Derivatives::Sensitivities) else {
            return Ok(Evaluation::of_loss(point.clone(), f64::INFINITY));
        };
        let markers: Vec<_> = simulated.iter().map(|l| l.markers.clone()).collect();
        let residuals = levels.residuals(&simulated, &constants.youngs_moduli)?;
        Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(point.clone(), levels.loss(&markers)) })
    };
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
        batch.iter().map(|point| evaluate(point).map_err(Interrupted)).collect()
    };
    Ok(optimize::minimise(&mut optimiser, &mut problem).map_err(|stop| stop.0)?.best)
}
