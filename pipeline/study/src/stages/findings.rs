//! Findings: metrics of the paper's claims that are derived from several records.

use serde::{Deserialize, Serialize};

use diagnostics::Result;
use records::subject::Condition;
use records::{Finding, Findings as Record, Identified, LoadCell, MethodComparison, Recovered, Thrust, Validation};
use signal::statistics::{correlation, minima, negative_share, ranks};
use sysid::landscape::lowest_points;
use workflow::needs::Every;
use workflow::stage::{Stage, StageContext};

/// Rise of χ² that separates two minima: one standard deviation; less is noise.
const RISE: f64 = 1.0;

/// The stage.
pub struct Findings;

/// `[findings]` in `study.toml`: nothing to set.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

impl Stage for Findings {
    type Settings = Settings;
    type Card = ();
    type Needs = (
        (Every<Identified>, Every<MethodComparison>, Recovered),
        Every<Validation, Condition>,
        Every<Thrust>,
        Every<LoadCell>,
    );
    type Makes = Record;
    const DESCRIPTION: &'static str = "metrics that decide claims are derived";
    const VERSION: u32 = 7;

    fn run((): &(), _: &Settings, needs: Self::Needs, _: &dyn StageContext) -> Result<Record> {
        let ((Every(identified), Every(compared), recovered), Every(validated), Every(thrusts), Every(cells)) = needs;
        let mut findings = Vec::new();
        for (specimen, model) in &identified {
            let (metric, value, unit) = of_identified(model);
            findings.push(named_finding(&specimen.0, metric, value, unit));
        }
        for (specimen, comparison) in &compared {
            findings.extend(
                of_compared(comparison)
                    .into_iter()
                    .map(|(metric, v, unit)| named_finding(&specimen.0, metric, v, unit)),
            );
        }
        for (specimen, walls) in recovered.specimens.iter().filter_map(|s| Some((&s.name, s.walls?))) {
            let error = walls.critical_pressure_pa.abs() / si::MILLIBAR;
            findings.push(named_finding(specimen, "critical_pressure_error_mbar", error, "mbar"));
        }
        for (trial, validation) in &validated {
            findings.extend(
                undamped_increase(validation)
                    .map(|v| named_finding(&trial.0, "undamped_rmse_increase_percent", v, "%")),
            );
        }
        for (specimen, thrust) in &thrusts {
            findings.extend(
                of_thrust(thrust).into_iter().map(|(metric, v, unit)| named_finding(&specimen.0, metric, v, unit)),
            );
        }
        for (specimen, cell) in &cells {
            let lowest = cell.example.measured.iter().copied().fold(0.0, f64::min);
            findings.push(named_finding(&specimen.0, "measured_minimum_over_noise", lowest / cell.noise, ""));
        }
        Ok(Record { found: findings })
    }
}

fn named_finding(subject: &str, metric: &str, value: f64, unit: &str) -> Finding {
    Finding { name: format!("{subject}.{metric}"), value, unit: unit.into() }
}

fn of_identified(identified: &Identified) -> (&'static str, f64, &'static str) {
    let levels = identified.levels.iter().map(|level| (level.pressure(), level.largest_error()));
    let (pressures, errors): (Vec<f64>, Vec<f64>) = levels.unzip();
    ("static_error_rank_correlation", correlation(&ranks(&pressures), &ranks(&errors)), "")
}

/// Minima are counted where profiles exist: a grid with two missing points in a row has none.
fn of_compared(compared: &MethodComparison) -> Vec<(&'static str, f64, &'static str)> {
    let surface = &compared.surface;
    let counted = compared.profiles.iter().map(|p| minima(&p.chi_square, RISE)).max();
    let lowest = || lowest_points(surface.across.len(), &surface.loss) as f64;
    let of_surface = (!surface.loss.is_empty()).then(|| ("landscape_minima", lowest(), ""));
    of_surface.into_iter().chain(counted.map(|count| ("minima", count as f64, ""))).collect()
}

/// By how much the error grows when the relaxation, and with it all damping, is left out, % of the length.
fn undamped_increase(validation: &Validation) -> Option<f64> {
    let elastic = validation.scored.iter().find(|model| model.name == "elastic")?;
    Some(100.0 * (elastic.rmse - validation.rmse) / validation.length)
}

/// Means are over the runs held out by the card; the share of negative force is that of the plotted run.
fn of_thrust(thrust: &Thrust) -> Vec<(&'static str, f64, &'static str)> {
    let sum = |mean_force: fn(&records::Means) -> f64| thrust.means.iter().map(mean_force).sum::<f64>();
    let mut metrics = vec![("theory_over_measured", sum(|m| m.theory_n) / sum(|m| m.measured_n), "")];
    for trace in thrust.traces.iter().filter(|trace| !trace.training) {
        metrics.push(("theory_lowest_mn", 1e3 * trace.theory.iter().copied().fold(f64::INFINITY, f64::min), "mN"));
        metrics.push(("negative_share_percent", 100.0 * negative_share(&trace.measured), "%"));
    }
    metrics
}
