//! Figure `thrust`: motion, measured thrust, theory, tuned theory and network, on a training run and on a held-out run. Paper, figure 8.
//!
//! A pair of panels a specimen (training, test): the last marker's lateral displacement above the forces; then the mean thrust of
//! every held-out run, predicted against measured.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Marker, Panel, Placed, palette};
use si::{MILLIMETRE, Point2};

use super::order::{capitalised, in_order};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use records::{self, Trace};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Thrust;

impl figure::Figure for Thrust {
    type Of = Study;
    type Needs = Every<records::Thrust, Specimen>;
    const NAME: &'static str = "thrust";
    const CAPTION: &'static str = "thrust of theory and network on training and test runs";
    const VERSION: u32 = 3;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::Thrust>::any(study)
    }

    fn draw(Every(thrusts): Self::Needs) -> Result<Figure> {
        if thrusts.is_empty() {
            return Err(Diagnostic::new(
                "there is no thrust to show",
                "no card has a split of trials with a force log",
                "add one",
            ));
        }
        let thrusts = in_order(thrusts);
        let mut figure = Figure::new(DOUBLE_COLUMN_MM);
        for (specimen, thrust) in &thrusts {
            let motions: Vec<Placed> = thrust.traces.iter().map(|t| motion_panel(specimen, t)).collect();
            let force_panels: Vec<Placed> = thrust.traces.iter().map(force_panel).collect();
            figure = figure.row(26.0, motions).row(42.0, force_panels);
        }
        figure = figure.row(50.0, thrusts.iter().map(|(s, t)| means_panel(s, t)).collect::<Vec<Placed>>());
        Ok(figure.noted(&origin_note(thrusts.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

/// Points against time from the trace's first sample on.
fn trace_curve(trace: &Trace, values: &[f64], scale: f64) -> Vec<Point2> {
    let first = trace.time.first().copied().unwrap_or(0.0);
    trace.time.iter().zip(values).map(|(t, v)| [t - first, scale * v]).collect()
}

fn motion_panel(specimen: &Specimen, trace: &Trace) -> Placed {
    let kind = if trace.training { "training" } else { "test" };
    let axes = Axes::new(Axis::linear("time", "s").without_tick_labels(), Axis::linear("tail", "mm"))
        .with(Mark::line(trace_curve(trace, &trace.moved, 1.0 / MILLIMETRE), palette::DISPLACEMENT));
    Panel::Axes(axes).titled(&format!("{} {kind}: {}", capitalised(&specimen.card.name), trace.run.replace('_', " ")))
}

fn force_panel(trace: &Trace) -> Placed {
    let mean = |values: &[f64]| 1e3 * values.iter().sum::<f64>() / values.len().max(1) as f64;
    let label = |what: &str, values: &[f64]| format!("{what}, mean {:.0} mN", mean(values));
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("thrust", "mN"))
        .with(Mark::horizontal_line(0.0, palette::MUTED))
        .with(
            Mark::line(trace_curve(trace, &trace.theory, 1e3), palette::ELONGATED_BODY)
                .dashed(Dash::Dashed)
                .labelled(&label("elongated-body theory", &trace.theory)),
        )
        .with(
            Mark::line(trace_curve(trace, &trace.tuned, 1e3), palette::DISPLACEMENT)
                .dashed(Dash::Dotted)
                .labelled(&label("tuned theory", &trace.tuned)),
        )
        .with(
            Mark::line(trace_curve(trace, &trace.measured, 1e3), palette::MEASURED)
                .sized(1.3)
                .labelled(&label("measured, corrected", &trace.measured)),
        )
        .with(
            Mark::line(trace_curve(trace, &trace.network, 1e3), palette::NETWORK)
                .labelled(&label("network", &trace.network)),
        );
    Placed::from(Panel::Axes(axes.legend(Legend::Over))).without_panel_label()
}

fn means_panel(specimen: &Specimen, thrust: &records::Thrust) -> Placed {
    let points = |predicted: fn(&records::Means) -> f64| -> Vec<Point2> {
        thrust.means.iter().map(|m| [1e3 * m.measured_n, 1e3 * predicted(m)]).collect()
    };
    let highest_mean = thrust.means.iter().map(|m| 1e3 * m.measured_n).fold(0.0, f64::max);
    let axes = Axes::new(Axis::linear("measured mean", "mN"), Axis::linear("predicted mean", "mN"))
        .with(Mark::line(vec![[0.0, 0.0], [highest_mean, highest_mean]], palette::MUTED).dashed(Dash::Dotted))
        .with(
            Mark::points(points(|m| m.theory_n), Marker::Triangle, palette::ELONGATED_BODY)
                .labelled("elongated-body theory"),
        )
        .with(Mark::points(points(|m| m.tuned_n), Marker::Cross, palette::DISPLACEMENT).labelled("tuned theory"))
        .with(Mark::points(points(|m| m.network_n), Marker::Disc, palette::NETWORK).labelled("network"));
    Panel::Axes(axes.legend(Legend::Over)).titled(&format!("{}: held-out runs", capitalised(&specimen.card.name)))
}
