//! Figure `relaxation`: the relaxation of the silicone, and the transients that it was identified from.
//!
//! (a), (b) storage modulus over the identified modulus and loss factor of every specimen, with 95 % intervals and the true values; (c), (d) the tip marker
//! of one specimen during its highest hold and after the release that follows, measured and simulated.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Marker, Panel, palette};
use si::{Hertz, MILLIBAR, MILLIMETRE, Point2, Second};

use super::order::{capitalised, in_order, tail_colour};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use records::{self, Estimate, Quantity, Recovered};
use sysid::relaxation::Transient;
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Relaxation;

/// Frequencies of (a) and (b), Hz: of the films, from a hold to the tail's free vibration.
const FREQUENCIES: [Hertz; 2] = [0.1, 10.0];
const POINTS: usize = 41;
/// Half of a 95 % interval in standard deviations.
const WIDTH: f64 = 1.96;
/// Duration of (d), s.
const SHOWN: Second = 0.8;

type All = Vec<(Specimen, records::Relaxation)>;

impl figure::Figure for Relaxation {
    type Of = Study;
    type Needs = (Every<records::Relaxation, Specimen>, Recovered);
    const NAME: &'static str = "relaxation";
    const CAPTION: &'static str = "storage modulus and loss factor of the silicones, and the transients behind them";
    const VERSION: u32 = 2;

    fn is_made_for(study: &Study) -> bool {
        Every::<records::Relaxation>::any(study)
    }

    fn draw((Every(relaxations), recovered): Self::Needs) -> Result<Figure> {
        let relaxations = in_order(relaxations);
        let (specimen, held, released) = shown_transients(&relaxations)?;
        let name = capitalised(&specimen.card.name);
        let [storage, loss] = [
            spectrum_panel(&relaxations, (0, &recovered), Axis::linear("storage modulus over E", ""))?,
            spectrum_panel(&relaxations, (1, &recovered), Axis::linear("loss factor", ""))?,
        ];
        let hold = format!("{name}, {:.0} mbar held", held.command_pa / MILLIBAR);
        let figure = Figure::new(DOUBLE_COLUMN_MM)
            .row(50.0, [storage.titled("storage modulus"), loss.titled("loss factor")])
            .row(
                50.0,
                [
                    transient_panel(held, held_time(held)).titled(&hold),
                    transient_panel(released, SHOWN).titled("released"),
                ],
            );
        Ok(figure.noted(&origin_note(relaxations.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

/// The first specimen with its highest hold and the window after it.
fn shown_transients(relaxations: &All) -> Result<(&Specimen, &Transient, &Transient)> {
    let highest = |windows: &[Transient]| {
        let pairs = 0..windows.len().saturating_sub(1);
        pairs
            .filter(|&i| windows[i + 1].command_pa <= 0.0)
            .max_by(|&a, &b| windows[a].command_pa.total_cmp(&windows[b].command_pa))
    };
    let transients_of = |(specimen, relaxation): &'_ (Specimen, records::Relaxation)| {
        Some((specimen.clone(), highest(&relaxation.transients)?))
    };
    let first = relaxations.iter().position(|relaxation| transients_of(relaxation).is_some());
    let none = || {
        Diagnostic::new("there is no transient to show", "no film holds and releases a pressure", "film a staircase")
    };
    let (specimen, relaxation) = &relaxations[first.ok_or_else(none)?];
    let hold = highest(&relaxation.transients).ok_or_else(none)?;
    Ok((specimen, &relaxation.transients[hold], &relaxation.transients[hold + 1]))
}

fn held_time(window: &Transient) -> Second {
    window.time_s.last().copied().unwrap_or(SHOWN)
}

/// Storage modulus over the identified one (0) or loss factor (1) of every specimen, with the true values where they are known.
fn spectrum_panel(relaxations: &All, (which, recovered): (usize, &Recovered), axis: Axis) -> Result<Panel> {
    let [from, to] = FREQUENCIES;
    let frequency = |i: usize| from * (to / from).powf(i as f64 / (POINTS - 1) as f64);
    let frequencies: Vec<Hertz> = (0..POINTS).map(frequency).collect();
    let mut axes = Axes::new(Axis::log("frequency", "Hz"), axis);
    for (specimen, records::Relaxation { spectrum: identified, .. }) in relaxations {
        let name = &specimen.card.name;
        let values: Vec<f64> = frequencies.iter().map(|f| Ok(identified.at(*f)?[which])).collect::<Result<_>>()?;
        let sigma: Vec<f64> = frequencies.iter().map(|f| Ok(identified.sigma_at(*f)?[which])).collect::<Result<_>>()?;
        let edge = |sign: f64| values.iter().zip(&sigma).map(|(v, s)| v + sign * WIDTH * s).collect::<Vec<_>>();
        let line: Vec<Point2> = frequencies.iter().zip(&values).map(|(f, v)| [*f, *v]).collect();
        axes = axes
            .with(Mark::band(frequencies.clone(), edge(-1.0), edge(1.0), tail_colour(name)))
            .with(Mark::line(line, tail_colour(name)).labelled(&capitalised(name)));
    }
    for (i, (specimen, _)) in relaxations.iter().enumerate() {
        let name = &specimen.card.name;
        let true_values = true_spectrum(recovered, name, which);
        if !true_values.is_empty() {
            let points = Mark::points(true_values, Marker::Cross, tail_colour(name)).sized(5.0);
            axes = axes.with(if i == 0 { points.labelled("true") } else { points });
        }
    }
    Ok(Panel::Axes(axes))
}

/// The true storage moduli over the identified time's (0) or loss factors (1) of a specimen, by frequency.
fn true_spectrum(recovered: &Recovered, name: &str, which: usize) -> Vec<Point2> {
    let estimates = recovered.specimens.iter().filter(|s| s.name == name).flat_map(|s| &s.estimates);
    let true_value = |estimate: &Estimate| match (&estimate.quantity, which) {
        (Quantity::StorageRatio(frequency), 0) | (Quantity::LossFactor(frequency), 1) => {
            Some([*frequency, estimate.hidden])
        }
        _ => None,
    };
    estimates.filter_map(true_value).collect()
}

/// The tip marker of a window about its mean, up to a time after the change of the command.
fn transient_panel(window: &Transient, until: Second) -> Panel {
    let path = |lateral: &[f64]| -> Vec<Point2> {
        let samples = window.time_s.iter().zip(lateral).map(|(t, y)| [*t, y / MILLIMETRE]);
        samples.filter(|p| p[0] <= until).collect()
    };
    let axes = Axes::new(Axis::linear("time after the command", "s"), Axis::linear("lateral, about its mean", "mm"))
        .with(Mark::points(path(&window.measured_m), Marker::Ring, palette::MEASURED).sized(1.6).labelled("measured"))
        .with(Mark::line(path(&window.simulated_m), palette::SIMULATED).dashed(Dash::Solid).labelled("simulated"));
    Panel::Axes(axes)
}
