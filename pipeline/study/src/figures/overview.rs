//! Figure `overview`: the loop from sim to real and back. Paper, figure 2.
//!
//! Films give the markers' motion x_m, pressures drive a simulation that gives x_t; the gradient of their loss moves the moduli until both
//! agree, and the identified model predicts motion and thrust. Every panel of the loop is a record of one tail; the graph of all
//! stages is on the page (`figures/index.html`).

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Diagram, Figure, Legend, Mark, Marker, Panel, Part, Picture};
use plot::{Scene, Side, View, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::order::{capitalised, in_order, record_of};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study, Trial};
use records::{ExampleFrames, Identified, Inflation, Mesh, MethodComparison, Thrust, Trace, Validation};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Overview;

/// What is inflated and filmed, and what is predicted.
type Motions = (Every<ExampleFrames, Trial>, Every<Inflation, Specimen>, Every<Validation, Trial>);

impl figure::Figure for Overview {
    type Of = Study;
    type Needs = (
        (Every<Mesh, Specimen>, Every<Identified, Specimen>, Every<MethodComparison, Specimen>),
        Motions,
        Every<Thrust, Specimen>,
    );
    const NAME: &'static str = "overview";
    const CAPTION: &'static str = "the loop from films and pressures to moduli, and the predictions that follow";
    const VERSION: u32 = 7;

    fn draw(
        ((Every(meshes), Every(identified), Every(compared)), motions, Every(thrusts)): Self::Needs,
    ) -> Result<Figure> {
        let (Every(examples), Every(inflations), Every(validations)) = motions;
        let (meshes, validations) = (in_order(meshes), in_order(validations));
        let Some((specimen, mesh)) = meshes.first() else {
            return Err(Diagnostic::new("there is no loop to show", "no specimen was found", "rig record"));
        };
        let name = specimen.card.name.as_str();
        let identification = record_of(&identified, name);
        let comparison = record_of(&compared, name)
            .zip(identification)
            .filter(|(_, identification)| identification.solids.len() == 2);
        let validation = record_of(&validations, name);
        let traced = record_of(&thrusts, name).and_then(|thrust| thrust.traces.last());
        let insets = [
            record_of(&examples, name).map(|example| Panel::Picture(film_picture(example))),
            validation.map(|validation| Panel::Axes(pressure_axes(validation))),
            record_of(&inflations, name).and_then(|inflation| inflated_scene(mesh, inflation)).map(Panel::Scene),
            identification.map(|identification| Panel::Axes(misfit_axes(identification))),
            comparison.map(|(comparison, identification)| Panel::Axes(iterate_axes(comparison, identification))),
            validation.map(|validation| Panel::Axes(motion_axes(validation))),
            traced.map(|trace| Panel::Axes(thrust_axes(trace))),
        ];
        let note = origin_note(meshes.iter().map(|(s, _)| s.card.as_ref()));
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(SHEET[1] + 4.0, [Panel::Diagram(loop_diagram(insets)).titled(&capitalised(name))]);
        Ok(figure.noted(&note))
    }
}

/// Sides of the diagram, mm.
const SHEET: Point2 = [181.0, 96.0];

/// A box of the loop: its title, its centre and its sides, mm.
struct Station(&'static str, Point2, Point2);

/// In the order of the panels inside.
const STATIONS: [Station; 7] = [
    Station("films: markers", [21.5, 73.0], [42.0, 44.0]),
    Station("pressures", [21.5, 21.0], [42.0, 40.0]),
    Station("simulation", [77.0, 21.0], [42.0, 40.0]),
    Station("loss of x − xₘ", [77.0, 73.0], [42.0, 44.0]),
    Station("moduli by iteration", [149.0, 73.0], [62.0, 44.0]),
    Station("motion never seen", [130.0, 21.0], [37.0, 40.0]),
    Station("thrust", [165.5, 21.0], [30.0, 40.0]),
];

/// The arrows between the boxes, mm, with their texts.
const ARROWS: [(&[Point2], &str, Side); 6] = [
    (&[[42.5, 76.0], [56.0, 76.0]], "xₘ", Side::Above),
    (&[[42.5, 21.0], [56.0, 21.0]], "p", Side::Above),
    (&[[77.0, 41.0], [77.0, 51.0]], "x", Side::Left),
    (&[[98.0, 76.0], [118.0, 76.0]], "gradient", Side::Above),
    (&[[118.0, 62.0], [108.0, 62.0], [108.0, 34.0], [98.0, 34.0]], "E", Side::Right),
    (&[[98.0, 14.0], [111.5, 14.0]], "", Side::Above),
];

/// The loop with a panel in each box; a box is left empty where its record is not made.
fn loop_diagram(insets: [Option<Panel>; 7]) -> Diagram {
    let framed = STATIONS.iter().zip(insets).fold(Diagram::new(SHEET[0], SHEET[1]), |diagram, (station, inset)| {
        let Station(title, [x, y], [width, height]) = *station;
        let fill = palette::FAINT.towards(palette::PAPER, 0.6);
        let framed = diagram.with(Part::Box { at: [x, y], size: [width, height], lines: Vec::new(), fill });
        let text = Part::Text {
            at: [x, y + 0.5 * height - 3.0],
            text: title.into(),
            side: Side::Centre,
            colour: palette::BLACK,
        };
        let framed = framed.with(text);
        // axes have their tick labels and labels outside of an inset
        let (middle, size) = match inset {
            Some(Panel::Axes(_)) => ([x + 4.5, y + 1.5], [width - 16.0, height - 18.0]),
            _ => ([x, y - 2.5], [width - 4.0, height - 9.0]),
        };
        inset
            .into_iter()
            .fold(framed, |framed, panel| framed.with(Part::Inset { at: middle, size, panel: Box::new(panel) }))
    });
    ARROWS.iter().fold(framed, |diagram, (points, text, side)| {
        let text = (!text.is_empty()).then(|| ((*text).to_owned(), *side));
        diagram.with(Part::Arrow { points: points.to_vec(), text, colour: palette::BLACK, dash: Dash::Solid })
    })
}

fn film_picture(example: &ExampleFrames) -> Picture {
    let [left, top, right, bottom] = example.seen.window_px;
    let crop = example.held.crop(left, top, right - left, bottom - top);
    let centres: Vec<Point2> =
        example.seen.held_px.iter().map(|p| [p[0] - left as f64 + 0.5, p[1] - top as f64 + 0.5]).collect();
    super::marker_circles(&centres).fold(Picture::new(crop.width, crop.height, crop.pixels), Picture::with)
}

fn inflated_scene(mesh: &Mesh, inflation: &Inflation) -> Option<Scene> {
    let shape = inflation.filmed.and_then(|i| inflation.shapes.get(i)).or(inflation.shapes.last())?;
    let surfaces = Surfaces::whole(&mesh.solid, &inflation.moved(mesh, shape));
    Some(surfaces.add_to(Scene::new(View::TOP), Bounds::painted))
}

/// Places of the markers at every level, measured and simulated, mm.
fn misfit_axes(identified: &Identified) -> Axes {
    let marker_position = |(rest, moved): (&Point2, &Point2)| [0, 1].map(|k| (rest[k] + moved[k]) / MILLIMETRE);
    let axes = Axes::new(Axis::linear("x", "mm"), Axis::linear("y", "mm")).equal().legend(Legend::None);
    identified.levels.iter().fold(axes, |axes, level| {
        // length: a level has a measured and a simulated displacement for each marker
        let measured = level.rest_m.iter().zip(&level.measured_m).map(marker_position).collect();
        let simulated = level.rest_m.iter().zip(&level.simulated_m).map(marker_position).collect();
        axes.with(Mark::line(simulated, palette::SIMULATED))
            .with(Mark::points(measured, Marker::Ring, palette::MEASURED).sized(2.6))
    })
}

/// Both moduli at each simulation of the search by Gauss and Newton, and where it ends.
fn iterate_axes(comparison: &MethodComparison, identified: &Identified) -> Axes {
    let moduli: Vec<_> = identified.moduli().collect();
    let tried = comparison.by("gauss_newton").map_or(&[][..], |search| &search.tried);
    let path: Vec<Point2> = tried.iter().map(|t| [0, 1].map(|k| moduli[k].scale * t.at[k])).collect();
    let axis = |k: usize| Axis::linear(&format!("E, {}", moduli[k].solid), moduli[k].unit);
    let end = path.last().copied().into_iter().collect();
    Axes::new(axis(0), axis(1))
        .with(Mark::line(path.clone(), palette::SIMULATED))
        .with(Mark::points(path, Marker::Disc, palette::SIMULATED).sized(3.5))
        .with(Mark::points(end, Marker::Cross, palette::OPTIMUM).sized(6.5))
        .legend(Legend::None)
}

/// Frames of a motion from its middle on, over so many seconds.
const EXCERPT: f64 = 1.2;

fn motion_excerpt(validation: &Validation) -> impl Iterator<Item = (usize, f64)> + '_ {
    let begin = validation.time[validation.time.len() / 2];
    let within = move |t: &f64| (begin..begin + EXCERPT).contains(t);
    validation.time.iter().enumerate().filter(move |(_, t)| within(t)).map(move |(frame, t)| (frame, t - begin))
}

fn pressure_axes(validation: &Validation) -> Axes {
    let looks = [palette::PRESSURE, palette::PRESSURE.towards(palette::BLACK, 0.5)];
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("p", "mbar")).legend(Legend::None);
    validation.pressures.iter().zip(looks.into_iter().cycle()).fold(axes, |axes, (chamber, colour)| {
        let curve = motion_excerpt(validation).map(|(frame, t)| [t, chamber[frame] / MILLIBAR]).collect();
        axes.with(Mark::line(curve, colour))
    })
}

fn motion_axes(validation: &Validation) -> Axes {
    let curve =
        |path: &[Point2]| motion_excerpt(validation).map(|(frame, t)| [t, path[frame][1] / MILLIMETRE]).collect();
    Axes::new(Axis::linear("time", "s"), Axis::linear("tip", "mm"))
        .with(Mark::line(curve(&validation.measured), palette::MEASURED).sized(1.3))
        .with(Mark::line(curve(&validation.simulated), palette::SIMULATED).dashed(Dash::Dashed))
        .legend(Legend::None)
}

fn thrust_axes(trace: &Trace) -> Axes {
    let first = trace.time.first().copied().unwrap_or(0.0);
    let curve = |values: &[f64]| {
        let shown = trace.time.iter().zip(values).map(|(t, force)| [t - first, 1e3 * force]);
        shown.filter(|[t, _]| *t < EXCERPT).collect()
    };
    Axes::new(Axis::linear("time", "s"), Axis::linear("force", "mN"))
        .with(Mark::line(curve(&trace.measured), palette::MEASURED).sized(1.3))
        .with(Mark::line(curve(&trace.network), palette::NETWORK))
        .legend(Legend::None)
}
