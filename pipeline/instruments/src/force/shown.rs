//! The results of `study force` as text, table, record and figure.

use std::fmt;
use std::path::Path;

use diagnostics::Result;
use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Figure, Mark, Marker, Panel, PlotError, palette};
use serde_json::{Value, json};

use super::Report;
use super::run::Run;
use signal::crosstalk::CrossTalk;

/// Writes `force.csv`, `force.json` and `force.svg`.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when the folder cannot be written.
pub(super) fn write_results(report: &Report, folder: &Path) -> Result<()> {
    crate::write_result(folder, "force.csv", run_table(report))?;
    let record = serde_json::to_string_pretty(&result_record(report))?;
    crate::write_result(folder, "force.json", format!("{record}\n"))?;
    match report.runs.is_empty() {
        true => Ok(()),
        false => crate::write_result(folder, "force.svg", &run_figure(report)?),
    }
}

fn run_table(report: &Report) -> String {
    let head = "run,frequency_hz,from_s,to_s,cycles,raw_mean_n,crosstalk_n,mean_n,low_n,high_n,zero_drift_n,waves_n\n";
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
    let line = |run: &Run| {
        let Run { id, frequency, within: [from, to], cycles, raw, mean, interval: [low, high], .. } = run;
        let (talk, drift) = (word(run.crosstalk), word(run.drift));
        format!(
            "{id},{frequency},{from:.3},{to:.3},{cycles},{raw:.5},{talk},{mean:.5},{low:.5},{high:.5},{drift},{:.5}\n",
            run.waves
        )
    };
    head.to_owned() + &report.runs.iter().map(line).collect::<String>()
}

/// Everything that the logs gave, with how they were sampled.
fn result_record(report: &Report) -> Value {
    let log_settings = &report.page.log;
    let card_lag = log_settings.force_lag.map(|s| json!({ "lag_s": s, "sigma_s": log_settings.force_lag_sigma }));
    let fixture = report.taps.as_ref().map(|taps| {
        let estimate = &taps.in_time;
        json!({
            "natural_frequency_hz": [estimate.cell.natural_frequency, estimate.frequency_sigma],
            "damping_ratio": [estimate.cell.damping_ratio, estimate.damping_sigma],
            "gain": estimate.gain, "taps": taps.taps, "noise_n": taps.noise,
        })
    });
    let waves = report.waves.as_ref().map(|fit| {
        let evidence_entry = |e: &signal::wave::Evidence| {
            json!({ "band_hz": e.band, "frequency_hz": e.frequency, "amplitude_n": e.amplitude, "p_value": e.p_value })
        };
        let wave_entry = |w: &signal::wave::Wave| {
            json!({ "frequency_hz": [w.frequency, w.frequency_sigma], "decay": [w.decay, w.decay_sigma], "amplitude_n": w.amplitude })
        };
        json!({
            "level": report.page.settings.level, "noise_n": fit.noise,
            "evidence": fit.evidence.iter().map(evidence_entry).collect::<Vec<_>>(),
            "waves": fit.waves.iter().map(wave_entry).collect::<Vec<_>>(),
        })
    });
    let talk = report.talk.as_ref().map(|talk| {
        json!({
            "pressures_pa": talk.pressures, "forces_n": talk.forces, "lag_s": talk.lag,
            "lag_interval_s": talk.lag_interval, "residual_n": talk.residual,
        })
    });
    let sampling: serde_json::Map<String, Value> =
        report.samplings.iter().map(|(id, sampling)| (id.clone(), json!(sampling))).collect();
    json!({
        "name": report.page.name, "cell_lag": card_lag, "fixture": fixture, "still_water": waves,
        "crosstalk": talk, "sampling": sampling,
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))?;
        if let Some(taps) = &self.taps {
            let estimate = &taps.in_time;
            let (f0, zeta) = (estimate.cell.natural_frequency, estimate.cell.damping_ratio);
            writeln!(
                f,
                "fixture: {f0:.3} ± {:.3} Hz, damping ratio {zeta:.4} ± {:.4}, {} taps",
                estimate.frequency_sigma, estimate.damping_sigma, taps.taps
            )?;
        }
        if let Some(fit) = &self.waves {
            let evidence_text = |e: &signal::wave::Evidence| format!("{:.2} Hz, p = {:.1e}", e.frequency, e.p_value);
            let evidence: Vec<String> = fit.evidence.iter().map(evidence_text).collect();
            writeln!(
                f,
                "standing waves: {} over the noise of {:.2} mN ({})",
                fit.waves.len(),
                1e3 * fit.noise,
                evidence.join("; ")
            )?;
        }
        if let Some(talk) = &self.talk {
            write_crosstalk(f, talk, self.page.log.force_lag.is_some())?;
        }
        self.runs.iter().try_for_each(|run| write_run(f, run))
    }
}

fn write_crosstalk(f: &mut fmt::Formatter<'_>, talk: &CrossTalk, is_beyond_page: bool) -> fmt::Result {
    let ([low, high], largest_force) = (talk.lag_interval, talk.forces.last().copied().unwrap_or(0.0));
    let qualifier = if is_beyond_page { " beyond that of the page" } else { "" };
    writeln!(
        f,
        "cross-talk: up to {:.1} mN; lag{qualifier} {:.3} s ({low:.3} to {high:.3})",
        1e3 * largest_force,
        talk.lag
    )
}

fn write_run(f: &mut fmt::Formatter<'_>, run: &Run) -> fmt::Result {
    let ([low, high], drift) =
        (run.interval, run.drift.map_or("unknown".to_owned(), |d| format!("{:+.1} mN", 1e3 * d)));
    let talk = run.crosstalk.map_or("not known".to_owned(), |t| format!("{:.1} mN", 1e3 * t));
    writeln!(
        f,
        "{:<14} {} Hz, {} cycles: {:.2} mN (95 % {:.2} to {:.2}); raw {:.2} mN, cross-talk {talk}, zero drift {drift}",
        run.id,
        run.frequency,
        run.cycles,
        1e3 * run.mean,
        1e3 * low,
        1e3 * high,
        1e3 * run.raw
    )?;
    run.warnings.iter().try_for_each(|warning| writeln!(f, "    {warning}"))
}

/// The corrected force of the first run over time, and every run's mean with its interval.
fn run_figure(report: &Report) -> Result<String, PlotError> {
    let first_run = &report.runs[0];
    let force_curve =
        first_run.force.values().iter().enumerate().map(|(i, force)| [first_run.force.time(i), 1e3 * force]).collect();
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("force", "mN"))
        .with(Mark::span(first_run.within[0], first_run.within[1], palette::MUTED))
        .with(Mark::line(force_curve, palette::MEASURED));
    let means =
        |value: fn(&Run) -> f64| report.runs.iter().map(|run| [run.frequency, 1e3 * value(run)]).collect::<Vec<_>>();
    let bars = report.runs.iter().map(|run| {
        let ends = run.interval.map(|force| [run.frequency, 1e3 * force]);
        Mark::line(ends.to_vec(), palette::MEASURED)
    });
    let mut run_axes = Axes::new(Axis::linear("frequency", "Hz"), Axis::linear("mean force", "mN"))
        .with(Mark::points(means(|run| run.raw), Marker::Ring, palette::MUTED).labelled("less its zero"))
        .with(Mark::points(means(|run| run.mean), Marker::Disc, palette::MEASURED).labelled("corrected"));
    for bar in bars {
        run_axes = run_axes.with(bar);
    }
    let panels = [Panel::Axes(axes).titled(&first_run.id), Panel::Axes(run_axes).titled("all runs, 95 % intervals")];
    Figure::new(DOUBLE_COLUMN_MM).row(60.0, panels).svg()
}
