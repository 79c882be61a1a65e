//! Mesh honesty: the moduli that other meshes would have been given by the same films: finer and coarser ones, with elements of
//! ten nodes and of four. What an element cannot bend, it blames on the material.
//!
//! Stands on: the mesher's stage, the levels, fit. Never knows: a film.

use fem::StaticSettings;
use fit::optimisers::gauss_newton;
use fit::{Bounds, Evaluation, Needs, Search};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use shape::Solid;
use si::Metre;

use super::levels::Levels;
use super::mesh;
use super::stop::Stop;
use crate::fault::{Fault, Outcome};
use crate::model::{Elastic, Ladder, Model, Want};
use crate::records::{self, Honest, Identified, Mesh, Point};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct MeshHonesty;

/// `[mesh_honesty]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Target lengths of an edge, m.
    edges: Vec<Metre>,
    /// Of the highest pressure, the part up to which levels are used: all meshes must have a shape there.
    highest: f64,
    /// How many times softer or stiffer than identified a modulus may come out.
    beyond: f64,
    /// Simulations at most, each mesh.
    iterations: usize,
    /// A search has converged when no logarithm of a modulus moves by more.
    step_tolerance: f64,
}

impl Stage for MeshHonesty {
    type Settings = Settings;
    type Needs = Identified;
    type Makes = records::MeshHonesty;
    const STORY: &'static str = "the same films tell other meshes other moduli";
    const EDITION: u32 = 2;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        mesh::Mesh::raw(of)
    }

    fn card(of: &Specimen) -> Value {
        mesh::Mesh::card(of)
    }

    fn run(of: &Specimen, set: &Settings, found: Identified, desk: &dyn Desk) -> Outcome<records::MeshHonesty> {
        let top = found.levels.iter().map(records::Level::pressure).fold(0.0, f64::max);
        let low: Vec<_> = found.levels.iter().filter(|l| l.pressure() <= set.highest * top).cloned().collect();
        let levels = Levels::kept(&low, &found.doubt, found.length)?;
        let mut rows = Vec::new();
        for (i, &edge) in set.edges.iter().enumerate() {
            desk.progress(i as f64 / set.edges.len() as f64, &format!("edges of {:.1} mm", 1e3 * edge));
            let mesher = shape::Settings { use_symmetry: true, ..shape::Settings::new(edge) };
            let made = mesh::made(&of.card, &mesher, MARKER_LIMIT, desk)?;
            for nodes in [10, 4] {
                let model = model(of, &made, nodes, &found)?;
                let freedoms = 3 * model.system.mesh().nodes.len();
                let best = moduli(set, &model, &levels, &found)?;
                rows.push(Honest { edge, nodes, freedoms, loss: best.loss, at: point(&found, &best.at) });
            }
        }
        Ok(records::MeshHonesty { rows })
    }
}

/// A coarse mesh's skin may lie so far from a marker, m.
const MARKER_LIMIT: Metre = 3e-3;

fn model(of: &Specimen, mesh: &Mesh, nodes: usize, found: &Identified) -> Outcome<Model> {
    let whole = Solid::Quadratic(mesh.solid.clone());
    let solid = if nodes == 4 { Solid::Linear(whole.lowered()) } else { whole };
    let rest = found.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
    let spots = of.card.marker.iter().zip(&rest).map(|(m, at)| solid.embed([at[0], at[1], m.at[2]]).0);
    Model::of(&solid, &mesh.chambers, spots.collect(), &of.card)
}

fn point(found: &Identified, at: &[f64]) -> Point {
    Point { body_e_pa: found.best.body_e_pa * at[0].exp(), spine_e_pa: found.best.spine_e_pa * at[1].exp() }
}

/// Gauss-Newton over the logarithms of both moduli over the identified ones.
fn moduli(set: &Settings, model: &Model, levels: &Levels, found: &Identified) -> Outcome<Evaluation> {
    let wide = set.beyond.ln();
    let bounds = Bounds { low: vec![-wide; 2], high: vec![wide; 2] };
    let search = Search::new(&["body", "spine"], vec![0.0; 2], bounds).map_err(Fault::from_tool)?;
    let newton = gauss_newton::Settings {
        step_tolerance: set.step_tolerance,
        iterations: set.iterations,
        ..gauss_newton::Settings::default()
    };
    let mut optimiser = gauss_newton::GaussNewton::new(&search, &newton).map_err(Fault::from_tool)?;
    let statics = StaticSettings { tolerance: 1e-6, halvings: 2, ..StaticSettings::default() };
    let mut ladder = Ladder::new(model.clone(), levels.rungs.clone(), statics, 2);
    let mut evaluate = |at: &Vec<f64>| -> Outcome<Evaluation> {
        let Point { body_e_pa, spine_e_pa } = point(found, at);
        let constants = Elastic { youngs_moduli: [body_e_pa, spine_e_pa], ..model.nominal };
        let Ok(shown) = ladder.climb(&constants, Want::Slopes) else {
            return Ok(Evaluation::of_loss(at.clone(), f64::INFINITY));
        };
        let markers: Vec<_> = shown.iter().map(|l| l.markers.clone()).collect();
        let residuals = levels.residuals(&shown, &constants.youngs_moduli)?;
        Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(at.clone(), levels.loss(&markers)) })
    };
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Stop> {
        batch.iter().map(|at| evaluate(at).map_err(Stop)).collect()
    };
    Ok(fit::minimise(&mut optimiser, &mut problem).map_err(|stop| stop.0)?.best)
}
