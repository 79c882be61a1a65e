//! Figure `waveforms`: the waveforms of greatest thrust and of greatest thrust per air beside the best recorded flap, and all of them among
//! square waves.
//!
//! A row a specimen: pressures of both sides over one cycle of each actuation, then mean thrust against the flow of air.

use plot::{Axes, Axis, Colour, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Marker, Panel, Placed, palette};
use si::{MILLIBAR, Pascal, Point2};

use super::order::{capitalised, in_order};
use super::origin_note;
use ::thrust::optimal_waveform::{Flap, OptimalWaveforms, Performed};
use diagnostics::Result;
use records::OptimalActuation;
use records::subject::{Specimen, Study};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Waveforms;

impl figure::Figure for Waveforms {
    type Of = Study;
    type Needs = Every<OptimalActuation, Specimen>;
    const NAME: &'static str = "waveforms";
    const CAPTION: &'static str = "the waveforms of greatest thrust and of greatest thrust per air";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        Every::<OptimalActuation>::any(study)
    }

    fn draw(Every(actuations): Self::Needs) -> Result<Figure> {
        let actuations = in_order(actuations);
        let row = |figure: Figure, (specimen, actuation): &(Specimen, OptimalActuation)| {
            let name = capitalised(&specimen.card.name);
            match &actuation.waveforms {
                Some(waveforms) => figure.row(50.0, waveform_panels(&name, waveforms)),
                None => figure.row(50.0, [scan_panel(actuation).titled(&format!("{name}: square waves alone"))]),
            }
        };
        let figure = actuations.iter().fold(Figure::new(DOUBLE_COLUMN_MM), row);
        Ok(figure.noted(&origin_note(actuations.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

fn waveform_panels(name: &str, waveforms: &OptimalWaveforms) -> Vec<Placed> {
    let recorded = cycle_panel(&waveforms.recorded, false).titled(&format!("{name}: recorded, best"));
    let optimal = waveforms.optima.iter().map(|o| cycle_panel(&o.flap, true).titled(&goal_title(&o.flap.name)));
    std::iter::once(recorded).chain(optimal).chain([sweep_panel(waveforms).titled("thrust and air")]).collect()
}

fn goal_title(name: &str) -> String {
    format!("most {}", name.replace('_', " "))
}

/// Pressures of both sides over one cycle, and the command of the first.
fn cycle_panel(flap: &Flap, commanded: bool) -> Panel {
    let axis = format!("time at {:.2} Hz", flap.performed.frequency_hz);
    let mut axes = Axes::new(Axis::linear(&axis, "s"), Axis::linear("pressure", "mbar"));
    let curve = |pressures: &[Pascal]| -> Vec<Point2> {
        let step = 1.0 / (flap.performed.frequency_hz * pressures.len().max(1) as f64);
        pressures.iter().enumerate().map(|(n, p)| [(n + 1) as f64 * step, p / MILLIBAR]).collect()
    };
    for command in flap.command_pa.iter().take(if commanded { 1 } else { 0 }) {
        axes = axes.with(Mark::line(curve(command), palette::MUTED).dashed(Dash::Dotted).labelled("command"));
    }
    let looks = [(palette::PRESSURE, Dash::Solid), (palette::PRESSURE.towards(palette::BLACK, 0.5), Dash::Dashed)];
    for ((pressure, (colour, dash)), side) in flap.pressure_pa.iter().zip(looks).zip(["one side", "other side"]) {
        axes = axes.with(Mark::line(curve(pressure), colour).dashed(dash).sized(1.2).labelled(side));
    }
    Panel::Axes(axes.legend(Legend::Over))
}

fn sweep_panel(waveforms: &OptimalWaveforms) -> Panel {
    let thrust_and_air = |performed: &Performed| [1e6 * performed.air_m3_s, 1e3 * performed.thrust_n];
    let flap_mark = |flap: &Flap, marker: Marker, colour: Colour, label: &str| {
        Mark::points(vec![thrust_and_air(&flap.performed)], marker, colour).labelled(label)
    };
    let squares = waveforms.sweep.iter().map(thrust_and_air).collect();
    let axes = Axes::new(Axis::linear("air", "ml/s"), Axis::linear("mean thrust", "mN"))
        .with(Mark::points(squares, Marker::Disc, palette::MUTED).labelled("square waves"))
        .with(flap_mark(&waveforms.recorded, Marker::Square, palette::MEASURED, "recorded"));
    let looks = [(Marker::Triangle, palette::OPTIMUM), (Marker::Ring, palette::ELONGATED_BODY)];
    let axes = waveforms.optima.iter().zip(looks).fold(axes, |axes, (o, (marker, colour))| {
        axes.with(flap_mark(&o.flap, marker, colour, &goal_title(&o.flap.name)))
    });
    Panel::Axes(axes.legend(Legend::Over))
}

/// Mean thrust of the scanned square waves, by the first thrust model.
fn scan_panel(actuation: &OptimalActuation) -> Panel {
    let thrust = |p: &::thrust::square_wave_search::ActuationPoint| Some([p.frequency_hz, 1e3 * p.thrust_n.first()?]);
    let axes = Axes::new(Axis::linear("frequency", "Hz"), Axis::linear("mean thrust", "mN")).with(Mark::points(
        actuation.scan.iter().filter_map(thrust).collect(),
        Marker::Disc,
        palette::MUTED,
    ));
    Panel::Axes(axes)
}
