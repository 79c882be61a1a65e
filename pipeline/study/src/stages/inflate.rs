//! Inflate: the identified model under rising pressure in the channels of one staircase, up to the highest that a film shows; among them the pressure
//! of the film's example frame, so that both can be compared. Paper: figure 1, the buckle.

use std::collections::BTreeSet;

use fem::{Solver, StaticSettings};
use serde::{Deserialize, Serialize};
use si::{Pascal, Point3, vec3};

use super::walls::WallGauge;
use diagnostics::{Diagnostic, Result};
use mesh::wall::end_rotation;
use records::selections::OfTrials;
use records::subject::{Specimen, Trial};
use records::{ExampleFrames, FrameData, Identified, Inflation, Mesh, Shape};
use sysid::silhouette::Stations;
use sysid::{Body, by_node};
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Inflate;

/// `[inflate]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How many shapes, evenly up to the highest pressure.
    shapes: usize,
    /// Tolerance of an equilibrium: the last Newton step moves no node by more than this fraction of the body's size.
    static_tolerance: f64,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    body: Body,
    /// The channel of each chamber.
    channels: Vec<String>,
    staircase: Option<Staircase>,
}

/// The staircase with the highest level.
#[derive(Debug, Serialize)]
struct Staircase {
    /// The channels that it fills.
    channels: Vec<String>,
    highest: Pascal,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        let staircase = |t: Trial| Staircase {
            channels: t.trial.experiment.channels().to_vec(),
            highest: t.trial.experiment.highest_level().unwrap_or(0.0),
        };
        Self {
            body: Body::of(&of.card),
            channels: of.card.chamber.iter().map(|c| c.channel.clone()).collect(),
            staircase: of.highest_staircase().map(staircase),
        }
    }
}

impl Stage for Inflate {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Mesh, Identified, OfTrials<ExampleFrames>);
    type Makes = Inflation;
    const DESCRIPTION: &'static str = "the identified model is inflated to the highest filmed pressure";
    const VERSION: u32 = 10;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Inflation> {
        let (mesh, found, OfTrials(examples, _)) = needs;
        let staircase = card.staircase.as_ref().ok_or_else(no_staircase)?;
        let seen = examples.first().map(|(_, example)| &example.seen);
        let filmed = seen.map(|seen| seen.pressures_pa.clone());
        let asked_pa = staircase.highest;
        let levels = levels(card, staircase, set.shapes, filmed.as_deref());
        let model = mesh.model(&card.body)?;
        let mut solver = model.system.solver();
        found.elastic(&model).apply(&mut solver)?;
        let statics = StaticSettings { tolerance: set.static_tolerance, ..StaticSettings::default() };
        let rest = vec![0.0; 3 * mesh.solid.nodes.len()];
        let displacements = solve_levels((&mut solver, &statics), &levels, rest, context)?;
        let gauge = WallGauge::new(&mesh);
        let solved = levels.iter().zip(&displacements);
        let mut shapes: Vec<Shape> = solved.map(|(p, u)| shape((&mesh, &gauge), p, by_node(u))).collect();
        if let Some(eye) = seen.filter(|seen| !seen.walls.is_empty()).map(|seen| seen.eye_m) {
            see(&mut shapes, card, &mesh, eye);
        }
        let film = seen.and_then(FrameData::shown_walls);
        let filmed = filmed.and_then(|wanted| shapes.iter().position(|s| s.pressures_pa == wanted));
        let nodes = skin(&mesh);
        let keep = |s: Shape| Shape { moved: nodes.iter().map(|&n| s.moved[n as usize]).collect(), ..s };
        Ok(Inflation { shapes: shapes.into_iter().map(keep).collect(), nodes, filmed, asked_pa, film })
    }
}

/// Pressures of all chambers in rising order: even levels, and those of the film.
fn levels(card: &Card, staircase: &Staircase, count: usize, filmed: Option<&[Pascal]>) -> Vec<Vec<Pascal>> {
    let highest = staircase.highest;
    let filled = |channel: &String| f64::from(u8::from(staircase.channels.contains(channel)));
    let at = |p: Pascal| card.channels.iter().map(|channel| filled(channel) * p).collect();
    let even = (1..=count).map(|i| at(highest * i as f64 / count as f64));
    let mut all: Vec<Vec<Pascal>> = even.chain(filmed.map(<[Pascal]>::to_vec)).collect();
    let top = |p: &Vec<Pascal>| p.iter().copied().fold(0.0, f64::max);
    all.sort_by(|a, b| top(a).total_cmp(&top(b)));
    all.dedup();
    all
}

/// Displacements (3 a node, m) while there is an equilibrium, each from those before.
fn solve_levels(
    (solver, statics): (&mut Solver, &StaticSettings),
    levels: &[Vec<Pascal>],
    rest: Vec<f64>,
    context: &dyn StageContext,
) -> Result<Vec<Vec<f64>>> {
    let mut solved = vec![(0.0, rest)];
    for (i, pressures) in levels.iter().enumerate() {
        context.progress(i as f64 / levels.len() as f64, "inflating");
        let known: Vec<(Pascal, &[f64])> = solved.iter().map(|(p, u)| (*p, u.as_slice())).collect();
        let to = pressures.iter().sum();
        match solver.equilibrium_from(&known, pressures, statics) {
            Ok(found) => solved.push((to, found.displacement)),
            Err(error) if i == 0 => return Err(Diagnostic::from(error)),
            Err(_) => break,
        }
    }
    Ok(solved.into_iter().skip(1).map(|(_, shape)| shape).collect())
}

fn shape((mesh, gauge): (&Mesh, &WallGauge), pressures: &[Pascal], moved: Vec<Point3>) -> Shape {
    let nodes: Vec<Point3> = mesh.solid.nodes.iter().zip(&moved).map(|(&x, &u)| vec3::add(x, u)).collect();
    let walls = gauge.walls(pressures, &nodes);
    let rotation = end_rotation(&mesh.solid.nodes, &nodes);
    Shape { pressures_pa: pressures.to_vec(), moved, walls, silhouette: None, rotation }
}

/// Measures the silhouettes of shapes whose nodes have all moved, as `eye` (m) sees them.
fn see(shapes: &mut [Shape], card: &Card, mesh: &Mesh, eye: Point3) {
    let Some(stations) = Stations::new(card.body.clamp.end(), &card.body.markers) else { return };
    let (rest, _) = stations.of_solid((&mesh.solid, &mesh.markers), &mesh.solid.nodes, eye);
    for shape in shapes {
        let nodes: Vec<Point3> = mesh.solid.nodes.iter().zip(&shape.moved).map(|(&x, &u)| vec3::add(x, u)).collect();
        shape.silhouette = stations.walls(&stations.of_solid((&mesh.solid, &mesh.markers), &nodes, eye), &rest);
    }
}

/// The nodes of the skin, in rising order.
fn skin(mesh: &Mesh) -> Vec<u32> {
    let nodes: BTreeSet<u32> = mesh.solid.skin.iter().flat_map(|f| f.nodes()).copied().collect();
    nodes.into_iter().collect()
}

fn no_staircase() -> Diagnostic {
    Diagnostic::new("the specimen is never held under pressure", "no trial on its card is a staircase", "record one")
}
