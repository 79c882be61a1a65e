//! Figure `overview`: what becomes what, from the recordings to thrust, as the list of stages has it. Paper, figure 2.
//!
//! (a) every stage with its story and what it reads, drawn from the list itself; then what some of them made, of one tail.
//!
//! Stands on: plot, the flow, the surfaces of solids. Never knows: a stage's code.

use plot::{
    Axes, Axis, Colour, DOUBLE_COLUMN_MM, Dash, Diagram, Figure, Legend, Mark, Marker, Panel, Part, Picture, Placed,
};
use plot::{Scene, View, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::order::{in_order, of, title};
use super::origin_note;
use super::solid::{Bounds, Surfaces};
use crate::fault::{Fault, Outcome};
use crate::figure;
use crate::flow::{Flow, Place, lay_out};
use crate::needs::Every;
use crate::records::{Inflation, Mesh, Still, Thrust, Validation};
use crate::subject::Study;

/// The figure.
pub struct Overview;

/// What the thumbnails show.
type Seen = (Every<Mesh>, Every<Still>, Every<Inflation>, (Every<Validation>, Every<Thrust>));

impl figure::Figure for Overview {
    type Needs = (Flow, Seen);
    const NAME: &'static str = "overview";
    const SHOWS: &'static str = "what becomes what, from two STL files and films to thrust";
    const EDITION: u32 = 5;

    fn card(study: &Study) -> serde_json::Value {
        Flow::of(study, crate::stages::ALL).as_json()
    }

    fn draw((flow, seen): Self::Needs) -> Outcome<Figure> {
        let (Every(meshes), ..) = &seen;
        if meshes.is_empty() {
            return Err(Fault::new("there is no pipeline to show", "no specimen was found", "rig record"));
        }
        let note = origin_note(meshes.iter().map(|(s, _)| s.card.as_ref()));
        let chart = graph(&flow, &|_| None);
        let tall = (DOUBLE_COLUMN_MM - 1.0) * chart.size[1] / chart.size[0];
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(tall + 4.0, [Panel::Diagram(chart).titled("the stages, and what each reads")]);
        Ok(figure.row(37.0, thumbnails(seen)).noted(&note))
    }
}

/// Sides of a card, and the room beside it, mm.
const CARD: Point2 = [24.4, 24.0];
const APART: Point2 = [2.6, 2.4];
/// Height of a recording's card, mm.
const SOURCE: f64 = 12.0;

/// The flow as a diagram; `said` may say something else than a stage's story.
pub fn graph(flow: &Flow, said: &dyn Fn(&str) -> Option<String>) -> Diagram {
    let direct = flow.direct();
    let laid = lay_out(&direct, flow.recordings);
    let pitch = [CARD[0] + APART[0], CARD[1] + APART[1]];
    let size = [laid.columns as f64 * pitch[0] - APART[0] + 1.0, laid.height * pitch[1]];
    let middle = |p: &Place| [0.5 + 0.5 * CARD[0] + p.column as f64 * pitch[0], 0.5 * size[1] - p.down * pitch[1]];
    let mut diagram = Diagram::new(size[0], size[1]);
    for (from, to, between) in &laid.lines {
        let (a, b) = (middle(&laid.rooms[*from]), middle(&laid.rooms[*to]));
        let through = between.iter().map(middle).flat_map(|[x, y]| [[x - 0.5 * CARD[0], y], [x + 0.5 * CARD[0], y]]);
        let ends = ([a[0] + 0.5 * CARD[0], a[1]], [b[0] - 0.5 * CARD[0], b[1]]);
        let points = std::iter::once(ends.0).chain(through).chain([ends.1]).collect();
        diagram = diagram.with(Part::Arrow { points, text: None, colour: palette::MUTED, dash: Dash::Solid });
    }
    for (i, room) in flow.rooms.iter().enumerate() {
        let words = said(&room.name).unwrap_or_else(|| room.story.clone());
        let title = room.name.replace('_', " ");
        let tall = if i < flow.recordings { SOURCE } else { CARD[1] };
        let (at, size, fill) = (middle(&laid.rooms[i]), [CARD[0], tall], ground(flow, i));
        diagram = diagram.with(Part::Card { at, size, title, words, fill });
    }
    diagram
}

/// Recordings are grey, what ends the story is green, all between is blue.
fn ground(flow: &Flow, room: usize) -> Colour {
    let read = flow.rooms.iter().any(|r| r.reads.contains(&room));
    match (room < flow.recordings, read) {
        (true, _) => palette::FAINT,
        (false, true) => palette::BODY.towards(palette::PAPER, 0.72),
        (false, false) => palette::NETWORK.towards(palette::PAPER, 0.72),
    }
}

fn thumbnails(
    (Every(meshes), Every(stills), Every(inflations), (Every(validations), Every(thrusts))): Seen,
) -> Vec<Placed> {
    let (meshes, validations) = (in_order(meshes), in_order(validations));
    let Some((specimen, mesh)) = meshes.first() else { return Vec::new() };
    let name = specimen.card.name.as_str();
    let lower = Surfaces::lower(&mesh.solid, &mesh.solid.nodes);
    let cut = lower.onto(Scene::new(super::CUT_VIEW), Bounds::painted);
    let mut all = vec![Panel::Scene(cut).titled(&format!("mesh: {}", title(name)))];
    all.extend(of(&stills, name).map(|s| Panel::Picture(frame(s)).titled("track: markers")));
    all.extend(of(&inflations, name).and_then(|i| blown(mesh, i)));
    all.extend(of(&validations, name).map(|v| Panel::Axes(beat(v)).titled("validate")));
    let pull = of(&thrusts, name).and_then(|t| t.traces.last());
    all.extend(pull.map(|t| Panel::Axes(thrust(t)).titled("thrust")));
    all
}

fn frame(still: &Still) -> Picture {
    let [left, top, right, bottom] = still.seen.window_px;
    let crop = still.held.crop(left, top, right - left, bottom - top);
    let at = still.seen.held_px.iter().map(|p| [p[0] - left as f64 + 0.5, p[1] - top as f64 + 0.5]).collect();
    Picture::new(crop.width, crop.height, crop.pixels)
        .with(Mark::points(at, Marker::Plus, palette::PRESSURE).sized(5.0))
}

fn blown(mesh: &Mesh, inflation: &Inflation) -> Option<Placed> {
    let shape = inflation.shapes.last()?;
    let whole = Surfaces::whole(&mesh.solid, &inflation.moved(mesh, shape));
    let scene = whole.onto(Scene::new(View::TOP), Bounds::painted);
    Some(Panel::Scene(scene).titled(&format!("inflate: {:.0} mbar", shape.pressure() / MILLIBAR)))
}

fn beat(v: &Validation) -> Axes {
    let curve = |path: &[Point2]| v.time.iter().zip(path).map(|(t, p)| [*t, p[1] / MILLIMETRE]).collect();
    Axes::new(Axis::linear("time", "s"), Axis::linear("tip", "mm"))
        .with(Mark::line(curve(&v.measured), palette::MEASURED).sized(1.3))
        .with(Mark::line(curve(&v.simulated), palette::SIMULATED).dashed(Dash::Dashed))
        .legend(Legend::None)
}

fn thrust(trace: &crate::records::Trace) -> Axes {
    let first = trace.time.first().copied().unwrap_or(0.0);
    let curve = |values: &[f64]| trace.time.iter().zip(values).map(|(t, f)| [t - first, 1e3 * f]).collect();
    Axes::new(Axis::linear("time", "s"), Axis::linear("force", "mN"))
        .with(Mark::line(curve(&trace.measured), palette::MEASURED).sized(1.3))
        .with(Mark::line(curve(&trace.network), palette::NETWORK))
        .legend(Legend::None)
}
