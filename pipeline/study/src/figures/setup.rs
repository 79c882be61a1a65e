//! Figure `setup`: the bench with its dimensions from the card and the calibration. Paper, figure 4.
//!
//! (a) the bench from the side, to scale; (b) the tail from the side; (c) the camera's image; (d) the instruments.

use lab::card::Card;
use plot::{
    DOUBLE_COLUMN_MM, Dash, Diagram, Figure, Mark, Marker, Panel, Part, Picture, Placed, Scene, Side, View, palette,
};
use si::{MILLIMETRE, Metre, Point2, Point3};

use super::order::{capitalised, in_order, record_of};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study, Trial};
use records::{Camera, ExampleFrames, LoadCell, Mesh, Tank};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Setup;

/// What is known of one specimen's bench.
struct Bench<'a> {
    card: &'a Card,
    filmed: &'a lab::card::Camera,
    camera: &'a Camera,
    mesh: &'a Mesh,
    example: Option<&'a ExampleFrames>,
    cell: Option<&'a LoadCell>,
    tank: Option<&'a Tank>,
}

impl figure::Figure for Setup {
    type Of = Study;
    type Needs = (
        Every<Camera, Specimen>,
        Every<Mesh, Specimen>,
        Every<ExampleFrames, Trial>,
        (Every<LoadCell, Specimen>, Every<Tank, Specimen>),
    );
    const NAME: &'static str = "setup";
    const CAPTION: &'static str = "the bench: tank, camera, tail, load cell and lamp, with their dimensions";
    const VERSION: u32 = 5;

    fn is_made_for(study: &Study) -> bool {
        Every::<Camera>::any(study)
    }

    fn draw(
        (Every(cameras), Every(meshes), Every(examples), (Every(cells), Every(tanks))): Self::Needs,
    ) -> Result<Figure> {
        let cameras = in_order(cameras);
        let Some((specimen, camera)) = cameras.first() else { return Err(no_bench()) };
        let name = &specimen.card.name;
        let mesh = record_of(&meshes, name).ok_or_else(no_bench)?;
        let card = specimen.card.as_ref();
        let filmed = card.camera.as_ref().ok_or_else(no_bench)?;
        let bench = Bench {
            card,
            filmed,
            camera,
            mesh,
            example: record_of(&examples, name),
            cell: record_of(&cells, name),
            tank: record_of(&tanks, name),
        };
        let view = bench.example.map(|example| film_picture(&bench, example).titled("the camera's image"));
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(
                74.0,
                [
                    Panel::Diagram(bench_diagram(&bench)).titled("the bench from the side, to scale").share(1.55),
                    Panel::Diagram(tail_diagram(&bench)).titled(&format!("{} from the side", capitalised(name))),
                ],
            )
            .row(
                62.0,
                view.into_iter()
                    .chain([Panel::Diagram(instrument_list(&bench)).titled("instruments")])
                    .collect::<Vec<Placed>>(),
            );
        Ok(figure.noted(&origin_note(std::iter::once(card))))
    }
}

fn no_bench() -> Diagnostic {
    Diagnostic::new(
        "there is no bench to show",
        "no specimen has a calibrated camera and a mesh",
        "study run camera mesh",
    )
}

fn in_mm(metres: f64) -> f64 {
    metres / MILLIMETRE
}

fn line_part(points: Vec<Point2>, colour: plot::Colour, width: f64, dash: Dash) -> Part {
    Part::Line { points, colour, width, dash }
}

fn text_part(at: Point2, text: &str, side: Side) -> Part {
    Part::Text { at, text: text.into(), side, colour: palette::BLACK }
}

fn dimension_part(from: Point2, to: Point2, metres: f64, side: Side) -> Part {
    Part::Dimension { from, to, text: format!("{:.0} mm", in_mm(metres)), side }
}

/// The tail from the side between two corners (m), as large as its sheet has them, mm.
fn tail_silhouette(bench: &Bench, from: Point2) -> Part {
    let nodes = &bench.mesh.solid.nodes;
    let surfaces = Surfaces::whole(&bench.mesh.solid, nodes);
    let ends = |k: usize| {
        let coordinates = surfaces.points.iter().map(|p| p[k]);
        [coordinates.clone().fold(f64::INFINITY, f64::min), coordinates.fold(f64::NEG_INFINITY, f64::max)]
    };
    let ([x0, x1], [z0, z1]) = (ends(0), ends(2));
    let scene =
        surfaces.add_to(Scene::new(View::SIDE), |b| b.painted().filter(|_| matches!(b, Bounds::Body | Bounds::Sheet)));
    let scene = scene.with_window([x0, 0.0, z0], [x1, 0.0, z1]);
    let centre = [from[0] + 0.5 * in_mm(x0 + x1), from[1] + 0.5 * in_mm(z0 + z1)];
    Part::Inset { at: centre, size: [in_mm(x1 - x0), in_mm(z1 - z0)], panel: Box::new(Panel::Scene(scene)) }
}

/// The whole bench; the sheet is in millimetres of the bench.
fn bench_diagram(bench: &Bench) -> Diagram {
    let (card, filmed, eye) = (bench.card, bench.filmed, bench.camera.pose.centre());
    let (length, depth) = bench.card.tank.map_or((0.45, 0.15), |t| (t.length, t.depth));
    let surface = card.water.as_ref().map(|w| w.surface);
    let bottom = surface.map_or(filmed.plane.height, |s| s - depth).min(filmed.plane.height);
    // the sheet: the tail's middle over the tank's, with a margin for dimensions
    let (wide, margin) = (in_mm(length) + 222.0, 26.0);
    let origin = [88.0 + 0.5 * in_mm(length - card.length), margin - in_mm(bottom)];
    let tall = origin[1] + in_mm(eye[2]) + 34.0;
    let on_sheet = |x: f64, z: f64| [origin[0] + in_mm(x), origin[1] + in_mm(z)];
    let mid = 0.5 * card.length;
    let (left, right) = (mid - 0.5 * length, mid + 0.5 * length);
    let mut d = Diagram::new(wide, tall);
    if let (Some(surface), true) = (surface, bench.tank.is_some()) {
        d = with_tank(d, &FilledTank { sides: [left, right], bottom, surface, length }, &on_sheet);
    }
    d = with_field_of_view(d, bench, &on_sheet);
    d = d.with(line_part(
        vec![on_sheet(left + 0.01, filmed.plane.height), on_sheet(right - 0.01, filmed.plane.height)],
        palette::MUTED,
        1.0,
        Dash::Dotted,
    ));
    d = d.with(text_part(on_sheet(left + 0.01, filmed.plane.height - 0.012), "calibrated plane", Side::Right));
    let level =
        |x: f64, z: f64| line_part(vec![on_sheet(x, z), on_sheet(right + 0.08, z)], palette::MUTED, 0.4, Dash::Dotted);
    d = d.with(level(card.length, 0.0)).with(level(eye[0], eye[2]));
    d = with_pneumatics(with_holder(d, bench, &on_sheet), bench, &on_sheet);
    d = d.with(tail_silhouette(bench, origin));
    with_camera(d, eye, &on_sheet).with(dimension_part(
        on_sheet(right + 0.075, 0.0),
        on_sheet(right + 0.075, eye[2]),
        eye[2],
        Side::Right,
    ))
}

/// A tank filled with water, from the side; heights over the tail's middle, m.
struct FilledTank {
    sides: [Metre; 2],
    bottom: Metre,
    surface: Metre,
    length: Metre,
}

/// Water and walls of a tank, with their dimensions.
fn with_tank(d: Diagram, tank: &FilledTank, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let FilledTank { sides: [left, right], bottom, surface, length } = *tank;
    let pale = palette::BODY.towards(palette::PAPER, 0.8);
    let water =
        vec![on_sheet(left, bottom), on_sheet(right, bottom), on_sheet(right, surface), on_sheet(left, surface)];
    let rim = surface + 0.03;
    let walls = vec![on_sheet(left, rim), on_sheet(left, bottom), on_sheet(right, bottom), on_sheet(right, rim)];
    d.with(Part::Polygon { points: water, fill: pale })
        .with(line_part(walls, palette::BLACK, 1.2, Dash::Solid))
        .with(text_part(on_sheet(left + 0.01, surface - 0.012), "water", Side::Right))
        .with(dimension_part(on_sheet(left, bottom - 0.014), on_sheet(right, bottom - 0.014), length, Side::Below))
        .with(dimension_part(
            on_sheet(right + 0.014, bottom),
            on_sheet(right + 0.014, surface),
            surface - bottom,
            Side::Right,
        ))
        .with(dimension_part(on_sheet(left - 0.014, 0.0), on_sheet(left - 0.014, surface), surface, Side::Left))
}

/// Two rays from the camera to the ends of its view of the plane, in air.
fn with_field_of_view(mut d: Diagram, bench: &Bench, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let (eye, height) = (bench.camera.pose.centre(), bench.filmed.plane.height);
    let field = bench.camera.visible_field(height);
    let ends = [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| field.iter().map(|p| p[0]).reduce(pick));
    for x in ends.into_iter().flatten() {
        d = d.with(line_part(
            vec![on_sheet(eye[0], eye[2]), on_sheet(x, height)],
            palette::PRESSURE,
            0.7,
            Dash::Dashed,
        ));
    }
    d
}

fn with_camera(d: Diagram, eye: Point3, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let [x, z] = [eye[0], eye[2]];
    let lens = vec![
        on_sheet(x - 0.006, z + 0.003),
        on_sheet(x + 0.006, z + 0.003),
        on_sheet(x + 0.009, z - 0.004),
        on_sheet(x - 0.009, z - 0.004),
    ];
    d.with(Part::Box { at: on_sheet(x, z + 0.013), size: [40.0, 20.0], lines: vec![], fill: palette::MUTED })
        .with(Part::Polygon { points: lens, fill: palette::BLACK })
        .with(text_part(on_sheet(x + 0.024, z + 0.013), "camera", Side::Right))
}

/// The clamp, the rods and the load cell; only the clamp's edge is known, the rest is a sketch.
fn with_holder(d: Diagram, bench: &Bench, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let edge = bench.card.clamp.end();
    let grey = palette::MUTED.towards(palette::PAPER, 0.5);
    let rod =
        |z: f64| line_part(vec![on_sheet(edge - 0.1, z), on_sheet(edge - 0.03, z)], palette::MUTED, 1.6, Dash::Solid);
    d.with(rod(0.012))
        .with(rod(-0.012))
        .with(Part::Box { at: on_sheet(edge - 0.02, 0.0), size: [36.0, 56.0], lines: vec![], fill: grey })
        .with(text_part(on_sheet(edge - 0.036, 0.028), "holder", Side::Above))
        .with(Part::Box { at: on_sheet(edge - 0.115, 0.0), size: [44.0, 38.0], lines: vec![], fill: palette::FAINT })
        .with(text_part(on_sheet(edge - 0.115, -0.019), "load cell", Side::Below))
}

/// Valve and logger on the holder's hose, and the lamp that synchronises film and log: a sketch, only the lamp's place in the picture is known.
fn with_pneumatics(d: Diagram, bench: &Bench, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let x = bench.card.clamp.end() - 0.008;
    let lines = ["valve".to_owned(), "pressure logger".to_owned()].to_vec();
    let hose = line_part(vec![on_sheet(x, 0.028), on_sheet(x, 0.1)], palette::PRESSURE, 1.6, Dash::Solid);
    let d = d.with(hose).with(Part::Box { at: on_sheet(x, 0.12), size: [136.0, 40.0], lines, fill: palette::FAINT });
    let lamp = [bench.card.length + 0.05, bench.filmed.plane.height + 0.004];
    match bench.card.led {
        None => d,
        Some(_) => d
            .with(Part::Disc { at: on_sheet(lamp[0], lamp[1]), radius: 4.0, fill: palette::PRESSURE })
            .with(text_part(on_sheet(lamp[0], lamp[1] + 0.003), "lamp", Side::Above)),
    }
}

/// Markers nearer than this to the last labelled one are not labelled, m.
const LABEL_SPACING: Metre = 0.0105;

/// The tail with its markers, clamp and water; the sheet is in millimetres of the bench.
fn tail_diagram(bench: &Bench) -> Diagram {
    let card = bench.card;
    let above = card.water.as_ref().map_or(0.03, |w| w.surface);
    let (low, wide) = (44.0, 166.0);
    let origin = [24.0, low];
    let on_sheet = |x: f64, z: f64| [origin[0] + in_mm(x), origin[1] + in_mm(z)];
    let mut d = Diagram::new(wide, low + in_mm(above) + 14.0);
    if card.water.is_some() {
        d = d.with(line_part(
            vec![on_sheet(-0.02, above), on_sheet(0.122, above)],
            palette::SIMULATED,
            1.0,
            Dash::Solid,
        ));
        d = d.with(text_part(on_sheet(0.095, above + 0.001), "surface of the water", Side::Above));
    }
    let edge = card.clamp.end();
    let grip = palette::MUTED.towards(palette::PAPER, 0.4);
    d = d.with(tail_silhouette(bench, origin));
    d = d.with(Part::Polygon {
        points: vec![on_sheet(-0.02, -0.027), on_sheet(edge, -0.027), on_sheet(edge, 0.027), on_sheet(-0.02, 0.027)],
        fill: grip,
    });
    d = d.with(text_part(on_sheet(0.5 * (edge - 0.02), 0.0), "held", Side::Centre));
    d = with_markers(d, card, &on_sheet);
    let below_tail = -0.032;
    if let (Some(first), Some(last)) = (card.marker.first(), card.marker.last()) {
        let z = 0.034;
        d = d.with(dimension_part(
            on_sheet(first.at[0], z),
            on_sheet(last.at[0], z),
            last.at[0] - first.at[0],
            Side::Above,
        ));
    }
    d.with(dimension_part(on_sheet(0.0, below_tail), on_sheet(card.length, below_tail), card.length, Side::Below))
        .with(dimension_part(on_sheet(0.116, 0.0), on_sheet(0.116, above), above, Side::Right))
}

/// The markers, named where there is room.
fn with_markers(mut d: Diagram, card: &Card, on_sheet: &dyn Fn(f64, f64) -> Point2) -> Diagram {
    let mut last_labelled = f64::NEG_INFINITY;
    for marker in &card.marker {
        let [x, _, z] = marker.at;
        let radius = 0.5 * in_mm(marker.diameter.unwrap_or_default());
        d = d.with(Part::Disc { at: on_sheet(x, z), radius, fill: palette::BLACK });
        if x - last_labelled >= LABEL_SPACING {
            d = d.with(text_part(on_sheet(x, z + 0.0015), &marker.name, Side::Above));
            last_labelled = x;
        }
    }
    d
}

/// The first frame with the markers and a scale bar.
fn film_picture(bench: &Bench, example: &ExampleFrames) -> Panel {
    let frame_at_rest = &example.rest;
    let shift = |p: &Point2| [p[0] + 0.5, p[1] + 0.5];
    let markers: Vec<Point2> = example.seen.rest_px.iter().map(shift).collect();
    // at the right: films may have an overlay of text at the left
    let end = [0.96 * frame_at_rest.width as f64, 0.95 * frame_at_rest.height as f64];
    let bar = [[end[0] - 0.02 * example.seen.px_per_m, end[1]], end];
    let mut picture = Picture::new(frame_at_rest.width, frame_at_rest.height, frame_at_rest.pixels.clone())
        .with(Mark::points(markers.clone(), Marker::Plus, palette::PRESSURE).sized(6.0));
    for [u, v] in bench.card.led.iter().map(|led| led.centre) {
        let above = [u, v - 0.03 * frame_at_rest.height as f64];
        picture = picture
            .with(Mark::points(vec![shift(&[u, v])], Marker::Plus, palette::PRESSURE).sized(8.0))
            .with(Mark::text(above, "lamp", Side::Above, palette::PAPER));
    }
    picture = picture.with(Mark::line(bar.to_vec(), palette::PAPER).sized(1.6)).with(Mark::text(
        [0.5 * (bar[0][0] + bar[1][0]), bar[0][1]],
        "20 mm",
        Side::Above,
        palette::PAPER,
    ));
    let label_offset = 0.015 * frame_at_rest.height as f64;
    for (i, (marker, marker_px)) in bench.card.marker.iter().zip(&markers).enumerate() {
        let (side, offset) = if i % 2 == 0 { (Side::Above, -label_offset) } else { (Side::Below, label_offset) };
        picture = picture.with(Mark::text([marker_px[0], marker_px[1] + offset], &marker.name, side, palette::PAPER));
    }
    Panel::Picture(picture)
}

/// Properties of the instruments, as lines of text.
fn instrument_list(bench: &Bench) -> Diagram {
    let (c, card) = (bench.camera, bench.card);
    let mut text = vec![
        format!("camera: {} × {} px, focal length {:.0} px", c.size_px[0], c.size_px[1], c.lens.fx),
        format!(
            "calibration: {} boards of {:.0} mm squares, reprojection error {:.2} px",
            c.views,
            in_mm(bench.filmed.board.square),
            c.reprojection_px
        ),
        format!("sensor readout {:.1} ms", 1e3 * bench.filmed.readout),
    ];
    text.extend(bench.example.map(|s| format!("scale at the markers: {:.2} px/mm", s.seen.px_per_m * MILLIMETRE)));
    text.extend(card.water.as_ref().map(|w| format!("water: refractive index {:.3}", w.index)));
    text.extend(bench.cell.map(|l| {
        format!(
            "load cell: {:.2} Hz, damping ratio {:.4}, noise {:.2} mN",
            l.in_time.natural_frequency_hz,
            l.in_time.damping_ratio,
            1e3 * l.noise
        )
    }));
    text.extend(bench.tank.map(|t| {
        let waves: Vec<String> = t.waves.iter().map(|w| format!("{:.2} Hz", w.frequency)).collect();
        match waves.is_empty() {
            true => "standing waves of the tank: none over the noise".to_owned(),
            false => format!("standing waves of the tank: {}", waves.join(", ")),
        }
    }));
    let line = |i: usize| 50.0 - 6.0 * i as f64;
    text.iter()
        .enumerate()
        .fold(Diagram::new(84.0, 56.0), |d, (i, text)| d.with(text_part([1.0, line(i)], text, Side::Right)))
}
