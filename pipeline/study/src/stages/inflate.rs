//! Inflate: the identified model under rising pressure on one side, up to the highest that a film shows; among them the pressure
//! of the film's own frame, so that both can stand side by side. Paper: figure 1, the buckle.
//!
//! Stands on: the model, the walls. Never knows: what a frame looks like.

use std::collections::BTreeSet;

use fem::{Solver, StaticSettings};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Pascal, Point3, vec3};

use super::swing;
use super::wall::Section;
use crate::fault::{Fault, Outcome};
use crate::model::{Model, by_node};
use crate::needs::OfTrials;
use crate::records::{Identified, Inflation, Mesh, Shape, Still, Walls};
use crate::stage::{Desk, Stage};
use crate::subject::{Specimen, Trial};

/// The stage.
pub struct Inflate;

/// `[inflate]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How many shapes, evenly up to the highest pressure.
    shapes: usize,
    /// The last step of each equilibrium moves no node further than this part of the body's size.
    static_tolerance: f64,
}

impl Stage for Inflate {
    type Settings = Settings;
    type Needs = (Mesh, Identified, OfTrials<Still>);
    type Makes = Inflation;
    const STORY: &'static str = "the identified model is blown up as high as a film shows";
    const EDITION: u32 = 2;

    fn card(of: &Specimen) -> Value {
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio]);
        json!({
            "body": region(&of.card.solid.body),
            "spine": region(&of.card.solid.spine),
            "clamp": of.card.clamp.below_x,
            "chambers": of.card.chamber.iter().map(|c| c.log.word()).collect::<Vec<_>>(),
            "staircase": of.highest_staircase().map(|t| format!("{:?}", t.trial.experiment)),
        })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<Inflation> {
        let (mesh, found, OfTrials(stills)) = needs;
        let trial = of.highest_staircase().ok_or_else(|| no_staircase(of))?;
        let filmed = stills.first().map(|(_, still)| still.seen.pressures_pa.clone());
        let asked_pa = trial.highest_level().unwrap_or(0.0);
        let levels = levels(&trial, asked_pa, set.shapes, filmed.as_deref());
        let model = Model::new(&mesh, &of.card)?;
        let mut solver = model.system.solver();
        swing::identified(&model, &found).give(&mut solver)?;
        let statics = StaticSettings {
            tolerance: set.static_tolerance,
            halvings: HALVINGS,
            iterations: DIRECTIONS,
            ..StaticSettings::default()
        };
        let shapes = climb(&mut solver, &levels, &statics, &mesh, desk)?;
        let filmed = filmed.and_then(|wanted| shapes.iter().position(|s| s.pressures_pa == wanted));
        let nodes = skin(&mesh);
        let keep = |s: Shape| Shape { moved: nodes.iter().map(|&n| s.moved[n as usize]).collect(), ..s };
        Ok(Inflation { shapes: shapes.into_iter().map(keep).collect(), nodes, filmed, asked_pa })
    }
}

/// Pressures of all chambers, from the lowest up: evenly, and those of the film.
fn levels(trial: &Trial, highest: Pascal, count: usize, filmed: Option<&[Pascal]>) -> Vec<Vec<Pascal>> {
    let side = trial.trial.experiment.side();
    let at = |p: Pascal| trial.card.chamber.iter().map(|c| if c.log == side { p } else { 0.0 }).collect();
    let even = (1..=count).map(|i| at(highest * i as f64 / count as f64));
    let mut all: Vec<Vec<Pascal>> = even.chain(filmed.map(<[Pascal]>::to_vec)).collect();
    let top = |p: &Vec<Pascal>| p.iter().copied().fold(0.0, f64::max);
    all.sort_by(|a, b| top(a).total_cmp(&top(b)));
    all
}

/// A shape from the one before it: halvings of the way, and Newton directions on each part. A shape that is not there is sought longest.
const HALVINGS: usize = 2;
const DIRECTIONS: usize = 25;

/// The shapes, each from the one before, until there is none any more.
fn climb(
    solver: &mut Solver,
    levels: &[Vec<Pascal>],
    statics: &StaticSettings,
    mesh: &Mesh,
    desk: &dyn Desk,
) -> Outcome<Vec<Shape>> {
    let section = Section::of(mesh);
    let (mut shapes, mut last): (Vec<Shape>, Option<Vec<f64>>) = (Vec::new(), None);
    for (i, pressures) in levels.iter().enumerate() {
        desk.progress(i as f64 / levels.len() as f64, "blowing it up");
        let displacement = match solver.equilibrium(pressures, last.as_deref(), statics) {
            Ok(found) => found.displacement,
            Err(error) if shapes.is_empty() => return Err(Fault::from_tool(error)),
            Err(_) => break,
        };
        shapes.push(shape(mesh, section.as_ref(), pressures, by_node(&displacement)));
        last = Some(displacement);
    }
    Ok(shapes)
}

fn shape(mesh: &Mesh, section: Option<&Section>, pressures: &[Pascal], moved: Vec<Point3>) -> Shape {
    let order = |a: &usize, b: &usize| pressures[*a].total_cmp(&pressures[*b]);
    let fullest = (0..pressures.len()).max_by(order).map_or(0, |k| mesh.chambers[k].skin);
    let nodes: Vec<Point3> = mesh.solid.nodes.iter().zip(&moved).map(|(&x, &u)| vec3::add(x, u)).collect();
    let walls = section.map_or(Walls::default(), |s| s.walls(&nodes, lies_left(mesh, fullest)));
    Shape { pressures_pa: pressures.to_vec(), moved, walls }
}

/// Whether a cavity lies at positive y.
fn lies_left(mesh: &Mesh, cavity: u16) -> bool {
    let on = mesh.solid.skin.iter().filter(|f| f.on == shape::Skin::Chamber(cavity));
    on.map(|f| mesh.solid.nodes[f.nodes[0] as usize][1]).sum::<f64>() > 0.0
}

/// The nodes of the skin, in rising order.
fn skin(mesh: &Mesh) -> Vec<u32> {
    let nodes: BTreeSet<u32> = mesh.solid.skin.iter().flat_map(|f| f.nodes).collect();
    nodes.into_iter().collect()
}

fn no_staircase(of: &Specimen) -> Fault {
    Fault::new(
        format!("`{}` is never held under pressure", of.card.name),
        "no trial on its card is a staircase",
        "record one",
    )
}
