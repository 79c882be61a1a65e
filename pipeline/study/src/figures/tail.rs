//! Figure `tail`: one tail cut open, the same inflated in simulation and on film, and the displacement
//! of its walls. Paper, figure 1.

use plot::{Axes, Axis, ColourBar, DOUBLE_COLUMN_MM, Figure, Mark, Marker, OverlayKind, Paint, Panel, Picture, Placed};
use plot::{Scene, View, palette};
use si::{MILLIBAR, MILLIMETRE, Point2, Point3, vec3};

use super::order::{in_order, of, title};
use super::origin_note;
use crate::records::{ExampleFrames, Inflation, Mesh, Shape};
use crate::subject::{Specimen, Study, Trial};
use diagnostics::{Diagnostic, Result};
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
    type Needs = (Every<Mesh, Specimen>, Every<Inflation, Specimen>, Every<ExampleFrames, Trial>);
    const NAME: &'static str = "tail";
    const CAPTION: &'static str = "a tail cut open, inflated in simulation and on film, and the buckling of its wall";
    const VERSION: u32 = 4;

    fn draw((Every(meshes), Every(inflations), Every(examples)): Self::Needs) -> Result<Figure> {
        let (meshes, inflations) = (in_order(meshes), in_order(inflations));
        let Some((specimen, inflation)) = inflations.first() else { return Err(no_tail()) };
        let name = &specimen.card.name;
        let (Some(mesh), Some(shape)) = (of(&meshes, name), shape_to_draw(inflation)) else { return Err(no_tail()) };
        let simulated = format!("simulated at {:.0} mbar", shape.pressure() / MILLIBAR);
        let mut top = vec![
            Panel::Scene(cut(mesh)).titled(&format!("{}, cut open at mid height", title(name))),
            Panel::Scene(inflated(mesh, inflation, shape)).titled(&simulated).share(1.15),
        ];
        top.extend(of(&examples, name).map(filmed));
        let bottom = [
            Panel::Scene(section(mesh, inflation, shape)).titled(&walls(shape)),
            Panel::Axes(leaving(inflation)).titled("displacement of the walls relative to the sheet"),
        ];
        let figure = Figure::new(DOUBLE_COLUMN_MM).row(ROWS[0], top).row(ROWS[1], bottom);
        Ok(figure.noted(&origin_note([specimen.card.as_ref()].into_iter())))
    }
}

fn no_tail() -> Diagnostic {
    Diagnostic::new("there is no tail to show", "no specimen was identified and inflated", "study run inflate")
}

/// The shape that was filmed, else the last one.
fn shape_to_draw(inflation: &Inflation) -> Option<&Shape> {
    inflation.filmed.and_then(|i| inflation.shapes.get(i)).or(inflation.shapes.last())
}

fn cut(mesh: &Mesh) -> Scene {
    let lower = Surfaces::lower(&mesh.solid, &mesh.solid.nodes);
    lower.onto(Scene::new(super::CUT_VIEW), Bounds::painted).with_scale_bar(20.0 * MILLIMETRE)
}

fn inflated(mesh: &Mesh, inflation: &Inflation, shape: &Shape) -> Scene {
    let moved = inflation.moved(mesh, shape);
    let whole = Surfaces::whole(&mesh.solid, &moved);
    let rest = Surfaces::whole(&mesh.solid, &mesh.solid.nodes);
    let far = |(a, b): (&Point3, &Point3)| vec3::norm(vec3::sub(*a, *b)) / MILLIMETRE;
    let far: Vec<f64> = whole.points.iter().zip(&rest.points).map(far).collect();
    let outer: Vec<[u32; 3]> =
        [Bounds::Body, Bounds::Sheet].iter().filter_map(|b| whole.faces.get(b)).flatten().copied().collect();
    let markers: Vec<Point3> = mesh.markers.iter().map(|spot| spot.at(&moved)).collect();
    Scene::new(ABOVE)
        .with_values(&whole.points, &outer, &far, ColourBar::linear("displacement", "mm"))
        .with_overlay(markers, OverlayKind::Markers(Marker::Disc), palette::BLACK, 4.0)
        .with_scale_bar(20.0 * MILLIMETRE)
}

/// The film's frame, cut to where the tail moves, with the markers as they were tracked.
fn filmed(example: &ExampleFrames) -> Placed {
    let [left, top, right, bottom] = example.seen.window_px;
    let crop = example.held.crop(left, top, right - left, bottom - top);
    let at: Vec<Point2> =
        example.seen.held_px.iter().map(|p| [p[0] - left as f64 + 0.5, p[1] - top as f64 + 0.5]).collect();
    let picture = Picture::new(crop.width, crop.height, crop.pixels)
        .with(Mark::points(at, Marker::Plus, palette::PRESSURE).sized(6.5))
        .with_scale_bar(0.02 * example.seen.px_per_m, "20 mm");
    let pressure = example.seen.pressures_pa.iter().copied().fold(0.0, f64::max);
    Panel::Picture(picture).titled(&format!("filmed at {:.0} mbar", pressure / MILLIBAR))
}

/// The section at mid height, inflated, over the one at rest.
fn section(mesh: &Mesh, inflation: &Inflation, shape: &Shape) -> Scene {
    let moved = inflation.moved(mesh, shape);
    let cut = |bounds: Bounds| bounds.is_cut().then(|| bounds.colour());
    let rest = Surfaces::lower(&mesh.solid, &mesh.solid.nodes);
    let low = |s: &mut Surfaces, by: f64| s.points.iter_mut().for_each(|p| p[2] = by);
    let (mut rest, mut now) = (rest, Surfaces::lower(&mesh.solid, &moved));
    low(&mut rest, -1e-3);
    low(&mut now, 0.0);
    let faint = |b: Bounds| cut(b).map(|c| Paint::Solid(c.towards(palette::PAPER, 0.75)));
    let scene = rest.onto(Scene::new(ABOVE), faint);
    now.onto(scene, |b| cut(b).map(Paint::Solid)).with_scale_bar(20.0 * MILLIMETRE)
}

fn walls(shape: &Shape) -> String {
    let walls = shape.walls;
    format!(
        "section: filled side bulges {:.1} mm, the other dents {:.2} mm",
        walls.bulge_m / MILLIMETRE,
        walls.dent_m / MILLIMETRE
    )
}

fn leaving(inflation: &Inflation) -> Axes {
    let curve = |of: fn(&Shape) -> f64| -> Vec<Point2> {
        let points = inflation.shapes.iter().map(|s| [s.pressure() / MILLIBAR, of(s) / MILLIMETRE]);
        std::iter::once([0.0, 0.0]).chain(points).collect()
    };
    let (bulge, dent) = (curve(|s| s.walls.bulge_m), curve(|s| s.walls.dent_m));
    let marked = |points: Vec<Point2>, marker, colour, label: &str| {
        [Mark::line(points.clone(), colour), Mark::points(points, marker, colour).sized(3.0).labelled(label)]
    };
    let axes = Axes::new(Axis::linear("pressure in one side", "mbar"), Axis::linear("distance from the sheet", "mm"));
    let both = [
        marked(bulge, Marker::Disc, palette::PRESSURE, "bulge of the filled side"),
        marked(dent, Marker::Triangle, palette::SIMULATED, "dent of the other side"),
    ];
    let axes = both.into_iter().flatten().fold(axes, Axes::with);
    match shape_to_draw(inflation) {
        Some(shape) => {
            axes.with(Mark::vertical_line(shape.pressure() / MILLIBAR, palette::MUTED).dashed(plot::Dash::Dashed))
        }
        None => axes,
    }
}
