//! Figure `tail`: one tail cut open, the same inflated in simulation and on film, and the displacement of its walls, of the model and of the
//! film's silhouette. Paper, figure 1.

use plot::{
    Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Marker, OverlayKind, Paint, Panel, Picture, Placed,
};
use plot::{Scene, View, palette};
use si::{MILLIBAR, MILLIMETRE, Pascal, Point2, Point3};

use super::order::{capitalised, in_order, record_of};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use mesh::wall::Walls;
use records::subject::{Specimen, Study, Trial};
use records::{ExampleFrames, Inflation, Mesh, Recovered, Shape};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Tail;

/// From above, the head at the left, as the camera sees it.
const ABOVE: View = View::TOP;
/// Height of both rows, mm.
const ROWS: [f64; 2] = [58.0, 50.0];

impl figure::Figure for Tail {
    type Of = Study;
    type Needs = (Every<Mesh, Specimen>, Every<Inflation, Specimen>, Every<ExampleFrames, Trial>, Recovered);
    const NAME: &'static str = "tail";
    const CAPTION: &'static str = "a tail cut open, inflated in simulation and on film, and the buckling of its wall";
    const VERSION: u32 = 7;

    fn draw((Every(meshes), Every(inflations), Every(examples), recovered): Self::Needs) -> Result<Figure> {
        let (meshes, inflations) = (in_order(meshes), in_order(inflations));
        let Some((specimen, inflation)) = inflations.first() else { return Err(no_tail()) };
        let name = &specimen.card.name;
        let (Some(mesh), Some(shape)) = (record_of(&meshes, name), shape_to_draw(inflation)) else {
            return Err(no_tail());
        };
        let simulated = format!("simulated at {:.0} mbar", shape.pressure() / MILLIBAR);
        let mut top = vec![
            Panel::Scene(cut_scene(mesh)).titled(&format!("{}, cut open at mid height", capitalised(name))),
            Panel::Scene(inflated_scene(mesh, inflation, shape)).titled(&simulated),
        ];
        let example = record_of(&examples, name);
        top.extend(example.map(filmed_picture));
        let film = example.map_or(&[][..], |example| &example.seen.walls);
        let body = recovered.specimens.iter().find(|s| s.name == *name);
        let hidden = body.and_then(|body| Some(body.walls?.hidden_critical_pressure_pa));
        let film_buckling = example.and_then(|example| example.seen.buckling_pressures());
        let buckles = [inflation.buckling_pressure(), hidden];
        let other_walls = [film, body.map_or(&[][..], |body| &body.hidden)];
        let dents = over_pressure(inflation, other_walls, ("dent of the slack wall", |w| w.dent_m));
        let bulges =
            over_pressure(inflation, other_walls, ("bulge of the filled wall", |w| w.bulge_m)).legend(Legend::None);
        let bottom = [
            Panel::Scene(section_scene(mesh, inflation, shape)).titled(&section_title(shape)),
            Panel::Axes(with_critical_pressures(dents, film_buckling, buckles)).titled("dent, and where it buckles"),
            Panel::Axes(bulges).titled("bulge"),
        ];
        let figure = Figure::new(DOUBLE_COLUMN_MM).row(ROWS[0], top).row(ROWS[1], bottom);
        Ok(figure.noted(&origin_note([specimen.card.as_ref()].into_iter())))
    }
}

pub(super) fn no_tail() -> Diagnostic {
    Diagnostic::new("there is no tail to show", "no specimen was identified and inflated", "study run inflate")
}

/// The shape that was filmed, else the last one.
fn shape_to_draw(inflation: &Inflation) -> Option<&Shape> {
    inflation.filmed.and_then(|i| inflation.shapes.get(i)).or(inflation.shapes.last())
}

fn cut_scene(mesh: &Mesh) -> Scene {
    let lower = Surfaces::lower_half(&mesh.solid, &mesh.solid.nodes);
    lower.add_to(Scene::new(super::CUT_VIEW), Bounds::painted).with_scale_bar(20.0 * MILLIMETRE)
}

fn inflated_scene(mesh: &Mesh, inflation: &Inflation, shape: &Shape) -> Scene {
    let nodes = inflation.moved(mesh, shape);
    let outside = |bounds: Bounds| matches!(bounds, Bounds::Body | Bounds::Sheet).then(|| bounds.painted()).flatten();
    let markers: Vec<Point3> = mesh.markers.iter().map(|spot| spot.at(&nodes)).collect();
    Surfaces::whole(&mesh.solid, &nodes)
        .add_to(Scene::new(ABOVE), outside)
        .with_overlay(markers, OverlayKind::Markers(Marker::Disc), palette::BLACK, 4.0)
        .with_scale_bar(20.0 * MILLIMETRE)
}

/// The film's frame, cut to where the tail moves, with the markers as they were tracked.
fn filmed_picture(example: &ExampleFrames) -> Placed {
    let [left, top, right, bottom] = example.seen.window_px;
    let crop = example.held.crop(left, top, right - left, bottom - top);
    let centres: Vec<Point2> =
        example.seen.held_px.iter().map(|p| [p[0] - left as f64 + 0.5, p[1] - top as f64 + 0.5]).collect();
    let picture = super::marker_circles(&centres)
        .fold(Picture::new(crop.width, crop.height, crop.pixels), Picture::with)
        .with_scale_bar(0.02 * example.seen.px_per_m, "20 mm");
    let pressure = example.seen.pressures_pa.iter().copied().fold(0.0, f64::max);
    Panel::Picture(picture).titled(&format!("filmed at {:.0} mbar", pressure / MILLIBAR))
}

/// The section at mid height, inflated, over the one at rest.
fn section_scene(mesh: &Mesh, inflation: &Inflation, shape: &Shape) -> Scene {
    let nodes = inflation.moved(mesh, shape);
    let cut = |bounds: Bounds| bounds.is_cut().then(|| bounds.colour());
    let undeformed = Surfaces::lower_half(&mesh.solid, &mesh.solid.nodes);
    let flatten = |s: &mut Surfaces, height: f64| s.points.iter_mut().for_each(|p| p[2] = height);
    let (mut undeformed, mut inflated) = (undeformed, Surfaces::lower_half(&mesh.solid, &nodes));
    flatten(&mut undeformed, -1e-3);
    flatten(&mut inflated, 0.0);
    let faint = |b: Bounds| cut(b).map(|c| Paint::Solid(c.towards(palette::PAPER, 0.75)));
    let scene = undeformed.add_to(Scene::new(ABOVE), faint);
    inflated.add_to(scene, |b| cut(b).map(Paint::Solid)).with_scale_bar(20.0 * MILLIMETRE)
}

fn section_title(shape: &Shape) -> String {
    let Walls { bulge_m, dent_m, .. } = shape.walls;
    format!("section: bulge {:.1} mm, dent {:.2} mm", bulge_m / MILLIMETRE, dent_m / MILLIMETRE)
}

/// Walls by pressure, Pa.
type Curve<'a> = &'a [(Pascal, Walls)];

/// Displacement of a wall relative to the sheet over pressure: of the model and the true body at mid height, of the model and the film in
/// silhouette.
fn over_pressure(inflation: &Inflation, [film, body]: [Curve; 2], (what, value): (&str, fn(&Walls) -> f64)) -> Axes {
    let point = |p: Pascal, walls: &Walls| [p / MILLIBAR, value(walls) / MILLIMETRE];
    let shapes = || inflation.shapes.iter();
    let section = shapes().map(|s| point(s.pressure(), &s.walls)).collect();
    let silhouette: Vec<Point2> = shapes().filter_map(|s| Some(point(s.pressure(), s.silhouette.as_ref()?))).collect();
    let points = |curve: Curve| curve.iter().map(|(p, walls)| point(*p, walls)).collect();
    let axes = Axes::new(Axis::linear("pressure in one side", "mbar"), Axis::linear(what, "mm"))
        .with(Mark::line(points(body), palette::SPINE).labelled("true body, mid height"))
        .with(Mark::line(section, palette::SIMULATED).labelled("model, mid height"));
    // under water no silhouette is measured
    if silhouette.is_empty() || film.is_empty() {
        return axes;
    }
    axes.with(
        Mark::line(silhouette, palette::SIMULATED)
            .dashed(Dash::Dashed)
            .labelled("model, silhouette (the fold is hidden)"),
    )
    .with(Mark::points(points(film), Marker::Disc, palette::MEASURED).sized(3.5).labelled("film, silhouette"))
}

/// Adds the pressures at which model and true body buckle, and below all those between which the film's tail does.
fn with_critical_pressures(mut axes: Axes, film: Option<[Pascal; 2]>, [model, body]: [Option<Pascal>; 2]) -> Axes {
    let span = |[low, high]: [Pascal; 2]| Mark::span(low / MILLIBAR, high / MILLIBAR, palette::MEASURED);
    axes.marks.splice(0..0, film.map(span).map(|span| span.labelled("film, buckles between")));
    let line = |(p, colour, text): (Option<Pascal>, _, &str)| {
        Some(Mark::vertical_line(p? / MILLIBAR, colour).dashed(Dash::Dotted).labelled(text))
    };
    let lines = [(model, palette::SIMULATED, "model buckles"), (body, palette::SPINE, "true body buckles")];
    lines.into_iter().filter_map(line).fold(axes, Axes::with)
}
