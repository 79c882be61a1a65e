//! Figure `sysid`: the loss over both moduli and the convergence of each method. Paper, figure 5.
//!
//! (a) the loss over both moduli on the mesh of the comparison, with Adam's iterates and the moduli at which a wall buckles just at a level;
//! (b) the lowest loss of each method; (c) static shapes of the back, measured and simulated; (d) each tail's largest error over pressure.

use optimize::optimisers;
use plot::{
    Axes, Axis, ColourBar, DOUBLE_COLUMN_MM, Dash, Figure, Landscape, Mark, Marker, Panel, Placed, Side, palette,
};
use si::{MILLIBAR, MILLIMETRE, Pascal, Point2};

use super::order::{capitalised, in_order, tail_colour};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use records::{Identified, Level, MethodComparison};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Sysid;

impl figure::Figure for Sysid {
    type Of = Study;
    type Needs = (Every<Identified, Specimen>, Every<MethodComparison, Specimen>);
    const NAME: &'static str = "sysid";
    const CAPTION: &'static str = "the loss over both moduli, and convergence of the methods";
    const VERSION: u32 = 11;

    fn draw((Every(identifications), Every(compared)): Self::Needs) -> Result<Figure> {
        let identifications = in_order(identifications);
        let Some(front) = identifications.first() else {
            return Err(Diagnostic::new(
                "there is no identification to show",
                "no specimen has one",
                "study run identify",
            ));
        };
        let (specimen, first) = front;
        let wide = specimen.card.marker.iter().filter_map(|m| m.diameter).fold(0.0, f64::max) / MILLIMETRE;
        let compared = compared.iter().find(|(_, comparison)| comparison.is_made());
        let top = compared.map(|(owner, comparison)| by_all_methods(&owner.card.name, comparison, &identifications));
        let name = capitalised(&specimen.card.name);
        let bottom = [
            shape_panel(first).titled(&format!("{name}: the back at each pressure (mbar)")).share(1.3),
            error_panel(&identifications).titled(&match wide {
                0.0 => "static error".to_owned(),
                wide => format!("static error (a marker is {wide:.0} mm wide)"),
            }),
        ];
        let figure = Figure::new(DOUBLE_COLUMN_MM);
        let figure = top.into_iter().fold(figure, |figure, top| figure.row(68.0, top)).row(56.0, bottom);
        Ok(figure.noted(&origin_note(identifications.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

/// Two moduli in the units in which they are printed.
fn printed_moduli(identified: &Identified, moduli: &[Pascal]) -> Point2 {
    let mut scales = identified.moduli().map(|m| m.scale);
    [0, 1].map(|k| scales.next().map_or(f64::NAN, |scale| scale * moduli[k]))
}

/// The landscape, where there is one, and the convergence of each method on a specimen.
fn by_all_methods(
    name: &str,
    comparison: &MethodComparison,
    identifications: &[(Specimen, Identified)],
) -> Vec<Placed> {
    let identified =
        identifications.iter().find(|(specimen, _)| specimen.card.name == name).map(|(_, identified)| identified);
    let name = capitalised(name);
    let landscape = identified.filter(|_| !comparison.surface.loss.is_empty()).map(|identified| {
        landscape_panel(identified, comparison).titled(&format!("{name}: loss over both moduli")).share(1.15)
    });
    let curves = convergence_panel(comparison).titled(&format!("{name}: lowest loss so far"));
    landscape.into_iter().chain([curves]).collect()
}

fn landscape_panel(identified: &Identified, comparison: &MethodComparison) -> Panel {
    let surface = &comparison.surface;
    let points = |method: &str| -> Vec<Point2> {
        comparison
            .by(method)
            .map_or(Vec::new(), |s| s.tried.iter().map(|t| printed_moduli(identified, &t.at)).collect())
    };
    let (path, grid) = (points("adam"), points("grid"));
    let moduli: Vec<_> = identified.moduli().collect();
    let axis = |k: usize, values: &[Pascal]| {
        let modulus = &moduli[k];
        (
            Axis::log(&format!("E of the {}", modulus.solid), modulus.unit),
            values.iter().map(|e| modulus.scale * e).collect(),
        )
    };
    let map = Landscape::new(
        axis(0, &surface.across),
        axis(1, &surface.up),
        surface.loss.clone(),
        ColourBar::log("loss", ""),
    );
    let critical: Vec<f64> = surface.critical.iter().map(|p| if *p > 0.0 { *p } else { f64::NAN }).collect();
    let map = film_pressures(identified).iter().fold(map, |map, level| {
        let text = format!("buckles at {:.0} mbar", level / MILLIBAR);
        map.with_isoline(critical.clone(), *level, &text, palette::BLACK)
    });
    let map = map
        .with(Mark::points(grid, Marker::Plus, palette::BLACK).sized(3.6).labelled("grid"))
        .with_path(path, palette::PAPER, "Adam")
        .with(
            Mark::cross(printed_moduli(identified, &identified.best), palette::OPTIMUM)
                .sized(8.0)
                .labelled("identified"),
        );
    Panel::Landscape(map)
}

/// The pressures of the first film, Pa.
fn film_pressures(identified: &Identified) -> Vec<Pascal> {
    let films = identified.levels.chunk_by(|a, b| a.trial == b.trial);
    films.take(1).flatten().map(Level::pressure).collect()
}

fn convergence_panel(comparison: &MethodComparison) -> Panel {
    let axes = Axes::new(Axis::log("simulations of all levels", ""), Axis::log("lowest loss", ""));
    let curves = comparison.searches.iter().flat_map(|search| {
        // where a tail has no equilibrium its loss is infinite: a search's curve begins with its first finite loss
        let losses = (1..=search.tried.len()).map(|n| [n as f64, search.loss_after(n)]);
        let lowest: Vec<Point2> = losses.filter(|[_, loss]| loss.is_finite()).collect();
        let colour = palette::method(&search.method);
        let line = Mark::line(lowest.clone(), colour).sized(1.2).labelled(optimisers::title_of(&search.method));
        [line, Mark::points(lowest, Marker::Disc, colour).sized(2.4)]
    });
    Panel::Axes(curves.fold(axes, Axes::with))
}

/// The back at each level: the clamp and the markers, seen from above, mm.
fn shape_panel(identified: &Identified) -> Panel {
    let mut axes = Axes::new(Axis::linear("x", "mm"), Axis::linear("y", "mm")).equal();
    let highest = identified.levels.iter().map(Level::pressure).fold(f64::MIN_POSITIVE, f64::max);
    for (i, level) in identified.levels.iter().enumerate() {
        let colour = palette::heat(0.85 * level.pressure() / highest);
        let simulated = Mark::line(back_curve(level, &level.simulated_m), colour).sized(1.3);
        let measured = back_curve(level, &level.measured_m);
        let points = Mark::points(measured[1..].to_vec(), Marker::Ring, palette::MEASURED).sized(4.0);
        let (simulated, points) = match i {
            0 => (simulated.labelled("simulated"), points.labelled("measured")),
            _ => (simulated, points),
        };
        axes = axes.with(simulated).with(points);
    }
    Panel::Axes(pressure_labels(&identified.levels).into_iter().fold(axes, Axes::with).legend(plot::Legend::Over))
}

/// The pressure of each level beside the back's end, of the highest first; one that would lie on another is left out.
fn pressure_labels(levels: &[Level]) -> Vec<Mark> {
    let mut ends: Vec<(Pascal, Point2)> = levels
        .iter()
        .filter_map(|level| Some((level.pressure(), *back_curve(level, &level.measured_m).last()?)))
        .collect();
    ends.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut placed: Vec<f64> = Vec::new();
    ends.retain(|(_, [_, y])| {
        let free = placed.iter().all(|other| (y - other).abs() > LABEL_MM);
        placed.extend(free.then_some(y));
        free
    });
    let label = |(pressure, [x, y]): (Pascal, Point2)| {
        let text = format!("{:.0}", pressure / MILLIBAR);
        Mark::text([x + 1.5, y], &text, Side::Right, palette::BLACK).sized(6.0)
    };
    ends.into_iter().map(label).collect()
}

/// The height of a label, in millimetres of the tail.
const LABEL_MM: f64 = 4.0;

fn back_curve(level: &Level, moved: &[Point2]) -> Vec<Point2> {
    let printed_position = |(r, d): (&Point2, &Point2)| [0, 1].map(|k| (r[k] + d[k]) / MILLIMETRE);
    std::iter::once([0.0, 0.0]).chain(level.rest_m.iter().zip(moved).map(printed_position)).collect()
}

/// The largest error at each pressure: a colour a tail, solid lines for films of the left side, dashed for the right.
fn error_panel(identifications: &[(Specimen, Identified)]) -> Panel {
    let top = 1.2 * identifications.iter().map(|(_, identified)| largest_error_mm(identified)).fold(LEAST_MM, f64::max);
    let axes = Axes::new(Axis::linear("pressure", "mbar"), Axis::linear("largest error", "mm").range(0.0, top));
    let axes = identifications.iter().fold(axes, |axes, (specimen, identified)| {
        let films = identified.levels.chunk_by(|a, b| a.trial == b.trial).enumerate();
        films.fold(axes, |axes, (i, film)| film_errors(axes, specimen, film, i))
    });
    Panel::Axes(axes.legend(plot::Legend::Over))
}

/// The error axis reaches at least so far.
const LEAST_MM: f64 = 0.025;

fn film_errors(axes: Axes, specimen: &Specimen, film: &[Level], index: usize) -> Axes {
    let points: Vec<Point2> = film.iter().map(|l| [l.pressure() / MILLIBAR, l.largest_error() / MILLIMETRE]).collect();
    let colour = tail_colour(&specimen.card.name);
    let text = film.first().map(|l| l.trial.replace("static_", "")).unwrap_or_default();
    let (dash, marker) =
        if index.is_multiple_of(2) { (Dash::Solid, Marker::Disc) } else { (Dash::Dashed, Marker::Ring) };
    let line = Mark::line(points.clone(), colour).dashed(dash);
    axes.with(line.labelled(&format!("{} {text}", capitalised(&specimen.card.name).replace('_', " "))))
        .with(Mark::points(points, marker, colour).sized(4.0))
}

fn largest_error_mm(identified: &Identified) -> f64 {
    identified.levels.iter().map(Level::largest_error).fold(0.0, f64::max) / MILLIMETRE
}
