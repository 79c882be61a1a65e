//! Figure `overview`: the stages from the recordings to thrust and what each reads. Paper, figure 2.
//!
//! (a) every stage with its description and what it reads, drawn from the list of stages; then records of one tail.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Marker, Panel, Picture, Placed};
use plot::{Scene, View, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::order::{in_order, of, title};
use super::origin_note;
use crate::records::{ExampleFrames, Inflation, Mesh, Thrust, Validation};
use crate::subject::{Specimen, Study, Trial};
use diagnostics::{Diagnostic, Result};
use publish::stage_diagram::stage_diagram;
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::{Every, Needs, RecordId, RecordReader};
use workflow::stage_graph::StageGraph;

/// The figure.
pub struct Overview;

/// What reads what in the pipeline, for the figure that shows it.
pub struct Pipeline(StageGraph);

impl Needs<Study> for Pipeline {
    fn ids(_: &Study) -> Vec<RecordId> {
        Vec::new()
    }

    fn parts(of: &Study) -> serde_json::Value {
        serde_json::to_value(StageGraph::of(of, crate::stages::ALL)).unwrap_or_default()
    }

    fn read(of: &Study, _: &dyn RecordReader) -> diagnostics::Result<Self> {
        Ok(Self(StageGraph::of(of, crate::stages::ALL)))
    }
}

/// The records that the thumbnails show.
type Seen = (
    Every<Mesh, Specimen>,
    Every<ExampleFrames, Trial>,
    Every<Inflation, Specimen>,
    (Every<Validation, Trial>, Every<Thrust, Specimen>),
);

impl figure::Figure for Overview {
    type Of = Study;
    type Needs = (Pipeline, Seen);
    const NAME: &'static str = "overview";
    const CAPTION: &'static str = "the stages of the pipeline and the records that each reads";
    const VERSION: u32 = 6;

    fn draw((Pipeline(graph), seen): Self::Needs) -> Result<Figure> {
        let (Every(meshes), ..) = &seen;
        if meshes.is_empty() {
            return Err(Diagnostic::new("there is no pipeline to show", "no specimen was found", "rig record"));
        }
        let note = origin_note(meshes.iter().map(|(s, _)| s.card.as_ref()));
        let chart = stage_diagram(&graph, &|_| None);
        let tall = (DOUBLE_COLUMN_MM - 1.0) * chart.size[1] / chart.size[0];
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(tall + 4.0, [Panel::Diagram(chart).titled("the stages and what each reads")]);
        Ok(figure.row(37.0, thumbnails(seen)).noted(&note))
    }
}

fn thumbnails(
    (Every(meshes), Every(examples), Every(inflations), (Every(validations), Every(thrusts))): Seen,
) -> Vec<Placed> {
    let (meshes, validations) = (in_order(meshes), in_order(validations));
    let Some((specimen, mesh)) = meshes.first() else { return Vec::new() };
    let name = specimen.card.name.as_str();
    let lower = Surfaces::lower(&mesh.solid, &mesh.solid.nodes);
    let cut = lower.onto(Scene::new(super::CUT_VIEW), Bounds::painted);
    let mut all = vec![Panel::Scene(cut).titled(&format!("mesh: {}", title(name)))];
    all.extend(of(&examples, name).map(|s| Panel::Picture(frame(s)).titled("track: markers")));
    all.extend(of(&inflations, name).and_then(|i| blown(mesh, i)));
    all.extend(of(&validations, name).map(|v| Panel::Axes(validation_axes(v)).titled("validate")));
    let pull = of(&thrusts, name).and_then(|t| t.traces.last());
    all.extend(pull.map(|t| Panel::Axes(thrust(t)).titled("thrust")));
    all
}

fn frame(example: &ExampleFrames) -> Picture {
    let [left, top, right, bottom] = example.seen.window_px;
    let crop = example.held.crop(left, top, right - left, bottom - top);
    let at = example.seen.held_px.iter().map(|p| [p[0] - left as f64 + 0.5, p[1] - top as f64 + 0.5]).collect();
    Picture::new(crop.width, crop.height, crop.pixels)
        .with(Mark::points(at, Marker::Plus, palette::PRESSURE).sized(5.0))
}

fn blown(mesh: &Mesh, inflation: &Inflation) -> Option<Placed> {
    let shape = inflation.shapes.last()?;
    let whole = Surfaces::whole(&mesh.solid, &inflation.moved(mesh, shape));
    let scene = whole.onto(Scene::new(View::TOP), Bounds::painted);
    Some(Panel::Scene(scene).titled(&format!("inflate: {:.0} mbar", shape.pressure() / MILLIBAR)))
}

fn validation_axes(v: &Validation) -> Axes {
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
