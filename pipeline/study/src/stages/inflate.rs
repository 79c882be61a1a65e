//! Inflate: the identified model under rising pressure in the channels of one staircase, up to the highest that a film shows; among them the
//! pressures that the film holds, so that both can be compared. Paper: figure 1, the buckle.

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
    const VERSION: u32 = 11;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Inflation> {
        let (mesh, identified, OfTrials(examples, _)) = needs;
        let staircase = card.staircase.as_ref().ok_or_else(no_staircase)?;
        let frame_data = examples.first().map(|(_, example)| &example.seen);
        let filmed = frame_data.map(|frame_data| highest_pressure(&frame_data.pressures_pa));
        let asked_pa = staircase.highest;
        let held_levels =
            frame_data.map_or(&[][..], |frame_data| &frame_data.levels).iter().map(|level| level.pressures_pa.clone());
        let levels = pressure_levels(card, staircase, set.shapes, held_levels);
        let model = mesh.model(&card.body)?;
        let mut solver = model.system.solver();
        identified.elastic(&model).apply(&mut solver)?;
        let statics = StaticSettings { tolerance: set.static_tolerance, ..StaticSettings::default() };
        let undeformed = vec![0.0; 3 * mesh.solid.nodes.len()];
        let displacements = solve_levels((&mut solver, &statics), &levels, undeformed, context)?;
        let gauge = WallGauge::new(&mesh);
        let solved = levels.iter().zip(&displacements);
        let mut shapes: Vec<Shape> = solved.map(|(p, u)| inflated_shape((&mesh, &gauge), p, by_node(u))).collect();
        if let Some(eye) =
            frame_data.filter(|frame_data| !frame_data.walls.is_empty()).map(|frame_data| frame_data.eye_m)
        {
            measure_silhouettes(&mut shapes, card, &mesh, eye);
        }
        let film = frame_data.and_then(FrameData::shown_walls);
        let is_filmed = |shape: &Shape, wanted: Pascal| (shape.pressure() - wanted).abs() <= SAME_LEVEL * asked_pa;
        let filmed = filmed.and_then(|wanted| shapes.iter().position(|shape| is_filmed(shape, wanted)));
        let nodes = skin_nodes(&mesh);
        let keep = |s: Shape| Shape { moved: nodes.iter().map(|&n| s.moved[n as usize]).collect(), ..s };
        Ok(Inflation { shapes: shapes.into_iter().map(keep).collect(), nodes, filmed, asked_pa, film })
    }
}

/// Pressures nearer than this, as a part of the highest, are one level: no shape can be extrapolated through two that are the same but for noise.
const SAME_LEVEL: f64 = 2e-3;

/// Pressures of all chambers in rising order: those that the film holds, and even levels where it holds none.
fn pressure_levels(
    card: &Card,
    staircase: &Staircase,
    count: usize,
    held: impl Iterator<Item = Vec<Pascal>>,
) -> Vec<Vec<Pascal>> {
    let highest = staircase.highest;
    let filled = |channel: &String| f64::from(u8::from(staircase.channels.contains(channel)));
    let filled_to = |pressure: Pascal| card.channels.iter().map(|channel| filled(channel) * pressure).collect();
    let even = (1..=count).map(|i| filled_to(highest * i as f64 / count as f64));
    let mut levels: Vec<Vec<Pascal>> = Vec::new();
    for level in held.chain(even) {
        if levels
            .iter()
            .all(|listed| (highest_pressure(listed) - highest_pressure(&level)).abs() > SAME_LEVEL * highest)
        {
            levels.push(level);
        }
    }
    levels.sort_by(|a, b| highest_pressure(a).total_cmp(&highest_pressure(b)));
    levels
}

/// The highest of the pressures of all chambers, Pa.
fn highest_pressure(pressures: &[Pascal]) -> Pascal {
    pressures.iter().copied().fold(0.0, f64::max)
}

/// Displacements (3 a node, m) while there is an equilibrium, each from those before.
fn solve_levels(
    (solver, statics): (&mut Solver, &StaticSettings),
    levels: &[Vec<Pascal>],
    undeformed: Vec<f64>,
    context: &dyn StageContext,
) -> Result<Vec<Vec<f64>>> {
    let mut solved = vec![(0.0, undeformed)];
    for (i, pressures) in levels.iter().enumerate() {
        context.progress(i as f64 / levels.len() as f64, "inflating");
        let solved_shapes: Vec<(Pascal, &[f64])> = solved.iter().map(|(p, u)| (*p, u.as_slice())).collect();
        let total_pressure = pressures.iter().sum();
        match solver.equilibrium_from(&solved_shapes, pressures, statics) {
            Ok(equilibrium) => solved.push((total_pressure, equilibrium.displacement)),
            Err(error) if i == 0 => return Err(Diagnostic::from(error)),
            Err(_) => break,
        }
    }
    Ok(solved.into_iter().skip(1).map(|(_, shape)| shape).collect())
}

fn inflated_shape((mesh, gauge): (&Mesh, &WallGauge), pressures: &[Pascal], displacements: Vec<Point3>) -> Shape {
    let nodes: Vec<Point3> = mesh.solid.nodes.iter().zip(&displacements).map(|(&x, &u)| vec3::add(x, u)).collect();
    let walls = gauge.walls_of_shape(pressures, &nodes);
    let rotation = end_rotation(&mesh.solid.nodes, &nodes);
    Shape { pressures_pa: pressures.to_vec(), moved: displacements, walls, silhouette: None, rotation }
}

/// Measures the silhouettes of shapes whose nodes have all moved, as `eye` (m) sees them.
fn measure_silhouettes(shapes: &mut [Shape], card: &Card, mesh: &Mesh, eye: Point3) {
    let Some(stations) = Stations::new(card.body.clamp.end(), &card.body.markers) else { return };
    let (undeformed, _) = stations.of_solid((&mesh.solid, &mesh.markers), &mesh.solid.nodes, eye);
    for shape in shapes {
        let nodes: Vec<Point3> = mesh.solid.nodes.iter().zip(&shape.moved).map(|(&x, &u)| vec3::add(x, u)).collect();
        shape.silhouette = stations.walls(&stations.of_solid((&mesh.solid, &mesh.markers), &nodes, eye), &undeformed);
    }
}

/// The nodes of the skin, in rising order.
fn skin_nodes(mesh: &Mesh) -> Vec<u32> {
    let nodes: BTreeSet<u32> = mesh.solid.skin.iter().flat_map(|f| f.nodes()).copied().collect();
    nodes.into_iter().collect()
}

fn no_staircase() -> Diagnostic {
    Diagnostic::new("the specimen is never held under pressure", "no trial on its card is a staircase", "record one")
}
