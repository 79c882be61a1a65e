//! Figure `sysid`: the loss has one minimum and the gradient finds it. Paper, figure 5.
//!
//! (a) the loss over both moduli with the way of Adam; (b) the lowest loss of each method against simulations; (c) static
//! shapes of the back, measured against simulated, with the largest error at each pressure.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::{Axes, Axis, ColourBar, DOUBLE_COLUMN_MM, Figure, Landscape, Mark, Marker, Panel, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::origin_note;
use crate::fault::{Fault, Outcome};
use crate::figure;
use crate::needs::Every;
use crate::records::{Identified, Level, Point};

/// The figure.
pub struct Sysid;

impl figure::Figure for Sysid {
    type Needs = Every<Identified>;
    const NAME: &'static str = "sysid";
    const SHOWS: &'static str = "the loss has one minimum, and the gradient finds it";
    const EDITION: u32 = 3;

    fn draw(Every(all): Self::Needs) -> Outcome<Figure> {
        let Some((_, first)) = all.first() else {
            return Err(Fault::new("there is no identification to show", "no specimen has one", "study run identify"));
        };
        let top =
            [landscape(first).titled("loss over both moduli").share(1.15), convergence(first).titled("convergence")];
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(68.0, top)
            .row(62.0, [shapes(first).titled("static shapes"), errors(first).titled("static error")]);
        Ok(figure.noted(&origin_note(all.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

fn place(at: &Point) -> Point2 {
    [1e-6 * at.body_e_pa, 1e-9 * at.spine_e_pa]
}

fn landscape(found: &Identified) -> Panel {
    let surface = &found.surface;
    let adam = found.searches.iter().find(|s| s.method == "adam");
    let path: Vec<Point2> = adam.map(|s| s.tried.iter().map(|t| place(&t.at)).collect()).unwrap_or_default();
    let grid = found.searches.iter().find(|s| s.method == "grid");
    let grid: Vec<Point2> = grid.map(|s| s.tried.iter().map(|t| place(&t.at)).collect()).unwrap_or_default();
    let map = Landscape::new(
        Axis::log("E of the body", "MPa"),
        Axis::log("E of the spine", "GPa"),
        surface.body_e_pa.iter().map(|e| 1e-6 * e).collect(),
        surface.spine_e_pa.iter().map(|e| 1e-9 * e).collect(),
        surface.loss.clone(),
        ColourBar::log("loss", ""),
    );
    let map = map
        .with(Mark::points(grid, Marker::Plus, palette::INK).sized(3.6).labelled("grid"))
        .with_path(path, palette::PAPER, "Adam")
        .with(Mark::cross(place(&found.best), palette::OPTIMUM).sized(8.0).labelled("identified"));
    Panel::Landscape(map)
}

fn convergence(found: &Identified) -> Panel {
    let axes = Axes::new(Axis::linear("simulations of all levels", ""), Axis::log("lowest loss", ""));
    let curves = found.searches.iter().map(|search| {
        let lowest = (1..=search.tried.len()).map(|n| [n as f64, search.loss_after(n)]).collect();
        Mark::line(lowest, palette::method(&search.method)).labelled(&title(&search.method))
    });
    Panel::Axes(curves.fold(axes, Axes::with))
}

fn title(method: &str) -> String {
    match method {
        "adam" => "Adam".into(),
        "gauss_newton" => "Gauss-Newton".into(),
        "grid" => "grid search".into(),
        "cma_es" => "CMA-ES".into(),
        other => other.into(),
    }
}

/// The back at each level: the clamp and the markers, seen from above, mm.
fn shapes(found: &Identified) -> Panel {
    let mut axes = Axes::new(Axis::linear("x", "mm"), Axis::linear("y", "mm"));
    axes.equal = true;
    for (i, level) in found.levels.iter().enumerate() {
        let colour = palette::heat(0.85 * i as f64 / found.levels.len().max(1) as f64);
        let simulated = Mark::line(back(level, &level.simulated_m), colour);
        let measured =
            Mark::points(back(level, &level.measured_m)[1..].to_vec(), Marker::Ring, palette::MEASURED).sized(4.0);
        let (simulated, measured) = match i {
            0 => (simulated.labelled("simulated"), measured.labelled("measured")),
            _ => (simulated, measured),
        };
        axes = axes.with(simulated).with(measured);
    }
    Panel::Axes(axes)
}

fn back(level: &Level, moved: &[Point2]) -> Vec<Point2> {
    let at = |(r, d): (&Point2, &Point2)| [0, 1].map(|k| (r[k] + d[k]) / MILLIMETRE);
    std::iter::once([0.0, 0.0]).chain(level.rest_m.iter().zip(moved).map(at)).collect()
}

fn errors(found: &Identified) -> Panel {
    let axes =
        Axes::new(Axis::linear("pressure", "mbar"), Axis::linear("largest error", "mm").range(0.0, ceiling(found)));
    let films = found.levels.chunk_by(|a, b| a.trial == b.trial).enumerate();
    Panel::Axes(films.fold(axes, |axes, (i, film)| {
        let points: Vec<Point2> =
            film.iter().map(|l| [l.pressure() / MILLIBAR, l.largest_error() / MILLIMETRE]).collect();
        let label = film.first().map(|l| l.trial.replace('_', " ")).unwrap_or_default();
        axes.with(Mark::line(points.clone(), palette::series(i)).labelled(&label))
            .with(Mark::points(points, Marker::Disc, palette::series(i)).sized(4.0))
    }))
}

fn ceiling(found: &Identified) -> f64 {
    let largest = found.levels.iter().map(Level::largest_error).fold(0.0, f64::max) / MILLIMETRE;
    (1.2 * largest).max(0.03)
}
