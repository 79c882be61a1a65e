//! Table `recovery`: estimates against the hidden truth of the virtual bench.

use lab::card::Origin;
use plot::Column;

use diagnostics::Result;
use records::subject::Study;
use records::{Estimate, Recovered};
use workflow::table::Table;

/// The table.
pub struct Recovery;

impl Table for Recovery {
    type Of = Study;
    type Needs = Recovered;
    const NAME: &'static str = "recovery";
    const CAPTION: &'static str = "identified and hidden parameters";
    const VERSION: u32 = 5;

    fn is_made_for(study: &Study) -> bool {
        study.specimens.iter().any(|s| s.card.origin == Origin::VirtualBench)
    }

    fn fill(recovered: Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("quantity"),
            Column::text("of"),
            Column::numbers("identified", ""),
            Column::numbers("hidden", ""),
            Column::numbers("error", ""),
            Column::numbers("error / σ", ""),
        ];
        let estimates = recovered.specimens.iter().flat_map(|s| s.estimates.iter().map(|e| estimate_row(&s.name, e)));
        let rows = estimates.chain(instrument_rows(&recovered)).collect();
        let table = plot::Table::new(columns, rows)?;
        Ok(table.noted("Error / σ: the error of the logarithm over its standard deviation as the pipeline states it."))
    }
}

fn estimate_row(specimen: &str, estimate: &Estimate) -> Vec<String> {
    let (title, unit) = estimate.quantity.title();
    vec![
        title,
        specimen.to_owned(),
        format!("{:.4}", unit * estimate.found),
        format!("{:.4}", unit * estimate.hidden),
        format!("{:.1} %", 100.0 * estimate.relative_error()),
        format!("{:.1}", estimate.standardised_error().abs()),
    ]
}

/// Instruments: the worst trial or specimen each.
fn instrument_rows(recovered: &Recovered) -> Vec<Vec<String>> {
    let row = |quantity: &str, value: f64, digits: usize, unit: &str| {
        [quantity, "worst", "", "", &format!("{value:.digits$} {unit}"), ""].map(str::to_owned).to_vec()
    };
    let named = |mut row: Vec<String>, worst: &str| {
        row[1] = if worst.is_empty() { row[1].clone() } else { worst.to_owned() };
        row
    };
    let covered = |quantity: &str, [inside, count]: [usize; 2]| {
        let share = format!("{:.1} %", 100.0 * inside as f64 / count.max(1) as f64);
        [quantity, "all", &share, "95 %", "", ""].map(str::to_owned).to_vec()
    };
    let mut rows = vec![
        named(row("tracked pixels", recovered.track_rms_px, 3, "px"), &recovered.track_worst),
        row("displacements", recovered.marker_rms_mm, 4, "mm"),
        row("clock", recovered.clock_error_ms, 2, "ms"),
        row("focal length", recovered.focal_error_percent, 2, "%"),
        covered("pixels inside their 95 % ellipse", recovered.track_coverage),
        covered("displacements inside their 95 % ellipse", recovered.marker_coverage),
    ];
    rows.extend(recovered.load_cell_frequency_error_percent.map(|e| row("load cell's frequency", e, 2, "%")));
    rows.extend(recovered.wave_residual_mn.map(|e| row("residual standing wave", e, 2, "mN")));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use records::Quantity;

    #[test]
    fn a_modulus_is_set_beside_the_hidden_one_with_sign_and_in_deviations() {
        let body = Estimate { quantity: Quantity::BodyModulus, found: 0.19e6, hidden: 0.2e6, sigma: 0.025 };
        assert_eq!(estimate_row("a", &body)[1..], ["a", "0.1900", "0.2000", "-5.0 %", "2.1"]);
    }

    #[test]
    fn every_row_has_a_cell_a_column() {
        let all = Recovered { wave_residual_mn: Some(1.0), ..Recovered::default() };
        assert!(instrument_rows(&all).iter().all(|row| row.len() == 6));
        assert_eq!(instrument_rows(&all).len(), 7);
    }
}
