//! Figure `load_cell`: the fixture's transfer function from hammer taps, and its deconvolution. Paper, appendix.
//!
//! (a) mass, spring and damper between the force and the cell; (b), (c) size and phase of the response, measured and fitted,
//! with the coherence; (d) a non-negative example thrust, the simulated measurement, and its deconvolution.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Diagram, Figure, Mark, Marker, Panel, Part, Side, palette};
use si::Point2;

use super::order::{capitalised, in_order};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct LoadCell;

impl figure::Figure for LoadCell {
    type Of = Study;
    type Needs = Every<records::LoadCell, Specimen>;
    const NAME: &'static str = "load_cell";
    const CAPTION: &'static str = "the fixture's response to hammer taps, and its deconvolution";
    const VERSION: u32 = 3;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::LoadCell>::any(study)
    }

    fn draw(Every(cells): Self::Needs) -> Result<Figure> {
        let cells = in_order(cells);
        let Some((specimen, cell)) = cells.first() else {
            return Err(Diagnostic::new("there is no load cell to show", "no card has taps", "study run load_cell"));
        };
        let dynamics = &cell.in_time;
        let text = format!(
            "{}: {:.3} ± {:.4} Hz, ζ {:.5} ± {:.5}",
            capitalised(&specimen.card.name),
            dynamics.natural_frequency_hz,
            dynamics.frequency_sigma_hz,
            dynamics.damping_ratio,
            dynamics.damping_sigma
        );
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(
                54.0,
                [
                    Panel::Diagram(cell_schematic()).titled("measurement dynamics"),
                    gain_panel(cell).titled(&text).share(1.4),
                ],
            )
            .row(44.0, [phase_panel(cell).titled("phase"), coherence_panel(cell).titled("coherence")])
            .row(52.0, [deconvolution_panel(cell).titled("deconvolution of a non-negative thrust")]);
        Ok(figure.noted(&origin_note(cells.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

fn cell_schematic() -> Diagram {
    let arrow = |points: Vec<Point2>, text: &str| Part::Arrow {
        points,
        text: Some((text.to_owned(), Side::Above)),
        colour: palette::BLACK,
        dash: Dash::Solid,
    };
    let words =
        |at: Point2, text: &str| Part::Text { at, text: text.to_owned(), side: Side::Above, colour: palette::BLACK };
    let lines = vec!["m".to_owned()];
    Diagram::new(76.0, 42.0)
        .with(Part::Wall { from: [16.0, 6.0], to: [16.0, 36.0] })
        .with(Part::Spring { from: [16.0, 13.0], to: [36.0, 13.0] })
        .with(Part::Damper { from: [36.0, 29.0], to: [16.0, 29.0] })
        .with(Part::Box { at: [45.0, 21.0], size: [18.0, 24.0], lines, fill: palette::FAINT })
        .with(arrow(vec![[72.0, 21.0], [54.5, 21.0]], "water"))
        .with(arrow(vec![[14.0, 21.0], [2.0, 21.0]], "cell"))
        .with(words([26.0, 15.5], "k"))
        .with(words([26.0, 32.5], "b"))
}

fn response_curve(cell: &records::LoadCell, part: impl Fn(&signal::cell::FrequencyResponse) -> f64) -> Vec<Point2> {
    cell.response.iter().map(|r| [r.frequency, part(r)]).collect()
}

/// The fit on a grid ten times as fine as the response.
fn fitted_curve(cell: &records::LoadCell, part: impl Fn(signal::spectrum::Phasor) -> f64) -> Vec<Point2> {
    let ends = [cell.response.first(), cell.response.last()].map(|r| r.map_or(1.0, |r| r.frequency));
    let frequency_at = |i: usize| ends[0] + (ends[1] - ends[0]) * i as f64 / 600.0;
    (0..=600).map(frequency_at).map(|f| [f, part(cell.in_time.cell().transfer(f))]).collect()
}

fn frequency_axis() -> Axis {
    Axis::linear("frequency", "Hz")
}

fn gain_panel(cell: &records::LoadCell) -> Panel {
    let axes = Axes::new(frequency_axis(), Axis::log("measured over true force", ""))
        .with(
            Mark::points(response_curve(cell, |r| r.transfer.norm()), Marker::Ring, palette::MEASURED)
                .sized(2.6)
                .labelled("taps"),
        )
        .with(Mark::line(fitted_curve(cell, |h| h.norm()), palette::SIMULATED).labelled("fit"));
    Panel::Axes(axes)
}

fn phase_panel(cell: &records::LoadCell) -> Panel {
    let axes = Axes::new(frequency_axis(), Axis::linear("phase", "°"))
        .with(
            Mark::points(response_curve(cell, |r| r.transfer.arg().to_degrees()), Marker::Ring, palette::MEASURED)
                .sized(2.6),
        )
        .with(Mark::line(fitted_curve(cell, |h| h.arg().to_degrees()), palette::SIMULATED));
    Panel::Axes(axes)
}

fn coherence_panel(cell: &records::LoadCell) -> Panel {
    let axes = Axes::new(frequency_axis(), Axis::linear("coherence", "").range(0.0, 1.05))
        .with(Mark::line(response_curve(cell, |r| r.coherence), palette::MEASURED));
    Panel::Axes(axes)
}

/// Start and duration of the plotted trace, s.
const FROM: f64 = 2.0;
const LONG: f64 = 1.5;

fn deconvolution_panel(cell: &records::LoadCell) -> Panel {
    let example = &cell.example;
    let cut = |values: &[f64]| -> Vec<Point2> {
        let samples = example.time.iter().zip(values).map(|(t, v)| [*t, *v]);
        samples.filter(|p| (FROM..FROM + LONG).contains(&p[0])).collect()
    };
    let deconvolved = cut(&example.deconvolved);
    let edge = |sigmas: f64| deconvolved.iter().map(|p| p[1] + sigmas * example.sigma).collect::<Vec<f64>>();
    let x = deconvolved.iter().map(|p| p[0]).collect();
    let label = |what: &str, nrmse: f64| format!("{what}, NRMSE {nrmse:.2}");
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("force", "N"))
        .with(Mark::horizontal_line(0.0, palette::MUTED))
        .with(Mark::band(x, edge(-2.0), edge(2.0), palette::SIMULATED))
        .with(
            Mark::line(cut(&example.measured), palette::MEASURED)
                .labelled(&label("through the cell", example.nrmse[0])),
        )
        .with(Mark::line(cut(&example.thrust), palette::NETWORK).sized(1.6).labelled("thrust"))
        .with(
            Mark::line(deconvolved.clone(), palette::SIMULATED)
                .dashed(Dash::Dashed)
                .labelled(&label("deconvolved", example.nrmse[1])),
        );
    Panel::Axes(axes.legend(plot::Legend::Over))
}
